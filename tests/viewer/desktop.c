/* SPDX-License-Identifier: MIT
 *
 * desktop.c - an X server, programs and synthetic input; see desktop.h.
 */
#define _GNU_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "desktop.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

struct desktop {
    pid_t server;
    char name[32]; /* ":7" */
    Display *display;
};

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void pause_shortly(void) {
    nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
}

/* ---- the server --------------------------------------------------------------------------- */

/* Forks a child that ends with the test, however the test ends. */
static pid_t fork_child(void) {
    pid_t parent = getpid(), pid = fork();
    assert_true(pid >= 0);
    if (!pid && (prctl(PR_SET_PDEATHSIG, SIGKILL) || getppid() != parent)) _exit(127);
    return pid;
}

static void run_server(int number_to) {
    char number[12];
    /* The server's keyboard compiler prints warnings about keys that no keyboard has; they are
     * dropped. */
    if (!freopen("/dev/null", "w", stderr)) _exit(127);
    snprintf(number, sizeof number, "%d", number_to);
    execlp("Xvfb", "Xvfb", "-displayfd", number, "-screen", "0", "800x600x24", "-nolisten", "tcp",
           "-noreset", (char *)NULL);
    _exit(127);
}

/* Windows may vanish while they are queried, so errors are ignored. */
static int ignore_error(Display *display, XErrorEvent *event) {
    (void)display, (void)event;
    return 0;
}

desktop *desktop_start(void) {
    int ends[2];
    desktop *d = calloc(1, sizeof *d);
    assert_non_null(d);
    assert_int_equal(pipe(ends), 0);
    d->server = fork_child();
    if (!d->server) run_server(ends[1]);
    close(ends[1]);
    /* The server writes the number of its display when it is ready; if it fails, it ends. */
    char number[16] = "";
    size_t length = 0;
    for (ssize_t n; length < sizeof number - 1 && !strchr(number, '\n'); length += (size_t)n)
        if ((n = read(ends[0], number + length, sizeof number - 1 - length)) <= 0) break;
    close(ends[0]);
    snprintf(d->name, sizeof d->name, ":%d", atoi(number));
    d->display = length ? XOpenDisplay(d->name) : NULL;
    if (d->display) return XSetErrorHandler(ignore_error), d;
    desktop_stop(d);
    return NULL;
}

void desktop_stop(desktop *d) {
    if (d->display) XCloseDisplay(d->display);
    kill(d->server, SIGTERM);
    waitpid(d->server, NULL, 0);
    free(d);
}

/* ---- programs ----------------------------------------------------------------------------- */

static Atom atom(const program *p, const char *name) {
    return XInternAtom(p->desktop->display, name, False);
}

/* Reads up to size - 1 bytes of a property of 8 bits, or one number of 32. Returns 0 where there is
 * none. */
static unsigned long property(const program *p, Window window, const char *name, char *text,
                              size_t size) {
    Atom type;
    int format = 0;
    unsigned long count = 0, left, value = 0;
    unsigned char *data = NULL;
    XGetWindowProperty(p->desktop->display, window, atom(p, name), 0, (long)size / 4, False,
                       AnyPropertyType, &type, &format, &count, &left, &data);
    if (data && format == 32 && count) memcpy(&value, data, sizeof value);
    if (data && format == 8 && text) {
        value = count < size - 1 ? count : size - 1;
        memcpy(text, data, value);
        text[value] = 0;
    }
    if (data) XFree(data);
    return value;
}

static int is_shown(const program *p, Window window) {
    XWindowAttributes attributes;
    return XGetWindowAttributes(p->desktop->display, window, &attributes) &&
           attributes.map_state == IsViewable &&
           property(p, window, "_NET_WM_PID", NULL, 64) == (unsigned long)p->pid;
}

static int has_window(void *user, const program *p) {
    Window root, parent, *children = NULL, *found = user;
    unsigned count = 0;
    XQueryTree(p->desktop->display, DefaultRootWindow(p->desktop->display), &root, &parent,
               &children, &count);
    for (unsigned i = 0; i < count; ++i)
        if (is_shown(p, children[i])) *found = children[i];
    if (children) XFree(children);
    return *found != 0;
}

static int has_ended(const program *p) {
    siginfo_t info = {.si_pid = 0};
    return waitid(P_PID, (id_t)p->pid, &info, WEXITED | WNOHANG | WNOWAIT) || info.si_pid;
}

void program_await(const program *p, const char *what, int (*holds)(void *user, const program *p),
                   void *user) {
    double end = seconds() + DESKTOP_SECONDS;
    while (!holds(user, p)) {
        char title[256] = "";
        if (p->window) program_title(p, title, sizeof title);
        if (has_ended(p)) fail_msg("the program ended before: %s", what);
        if (seconds() > end) fail_msg("did not happen: %s; the title is: %s", what, title);
        pause_shortly();
    }
}

program program_start(desktop *d, const char *const *argv) {
    program p = {.desktop = d, .pid = fork_child()};
    if (!p.pid) {
        setenv("DISPLAY", d->name, 1);
        unsetenv("WAYLAND_DISPLAY");
        setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
        execv(argv[0], (char *const *)argv);
        _exit(127);
    }
    Window window = 0;
    program_await(&p, "a window is shown", has_window, &window);
    p.window = window;
    return p;
}

int program_wait(program *p) {
    double end = seconds() + DESKTOP_SECONDS;
    int status = 0;
    while (!waitpid(p->pid, &status, WNOHANG)) {
        if (seconds() > end) fail_msg("the program did not end");
        pause_shortly();
    }
    p->pid = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void program_kill(program *p) {
    if (p->pid <= 0) return;
    kill(p->pid, SIGKILL);
    waitpid(p->pid, NULL, 0);
    p->pid = 0;
}

/* ---- what the window shows ---------------------------------------------------------------- */

void program_title(const program *p, char *text, size_t size) {
    *text = 0;
    property(p, p->window, "_NET_WM_NAME", text, size);
}

static int title_has(void *user, const program *p) {
    char title[512];
    program_title(p, title, sizeof title);
    return strstr(title, user) != NULL;
}

void program_await_title(const program *p, const char *part) {
    char what[256], copy[200];
    snprintf(copy, sizeof copy, "%s", part);
    snprintf(what, sizeof what, "the title has '%s'", copy);
    program_await(p, what, title_has, copy);
}

picture program_picture(const program *p) {
    Window root;
    int x, y;
    unsigned width = 0, height = 0, border, depth;
    Display *display = p->desktop->display;
    XGetGeometry(display, p->window, &root, &x, &y, &width, &height, &border, &depth);
    XImage *image = XGetImage(display, p->window, 0, 0, width, height, AllPlanes, ZPixmap);
    assert_non_null(image);
    picture shown = {(int)width, (int)height, malloc((size_t)3 * width * height)};
    assert_non_null(shown.rgb);
    for (int i = 0; i < shown.width * shown.height; ++i) {
        unsigned long pixel = XGetPixel(image, i % shown.width, i / shown.width);
        for (int k = 0; k < 3; ++k) shown.rgb[3 * i + k] = (uint8_t)(pixel >> (16 - 8 * k));
    }
    XDestroyImage(image);
    return shown;
}

/* ---- keys and pointer --------------------------------------------------------------------- */

static KeyCode code_of(const program *p, const char *name) {
    KeyCode code = XKeysymToKeycode(p->desktop->display, XStringToKeysym(name));
    if (!code) fail_msg("there is no key %s", name);
    return code;
}

void program_key(const program *p, const char *name, int shift) {
    Display *display = p->desktop->display;
    KeyCode code = code_of(p, name), shift_code = code_of(p, "Shift_L");
    XSetInputFocus(display, p->window, RevertToParent, CurrentTime);
    if (shift) XTestFakeKeyEvent(display, shift_code, True, CurrentTime);
    XTestFakeKeyEvent(display, code, True, CurrentTime);
    XTestFakeKeyEvent(display, code, False, CurrentTime);
    if (shift) XTestFakeKeyEvent(display, shift_code, False, CurrentTime);
    XSync(display, False);
}

static void to_root(const program *p, int x, int y, int *root_x, int *root_y) {
    Window child;
    XTranslateCoordinates(p->desktop->display, p->window, DefaultRootWindow(p->desktop->display), x,
                          y, root_x, root_y, &child);
}

void program_move(const program *p, int x, int y) {
    to_root(p, x, y, &x, &y);
    XTestFakeMotionEvent(p->desktop->display, -1, x, y, CurrentTime);
    XSync(p->desktop->display, False);
}

void program_button(const program *p, unsigned button, int is_down) {
    XTestFakeButtonEvent(p->desktop->display, button, is_down, CurrentTime);
    XSync(p->desktop->display, False);
}

void program_resize(const program *p, int width, int height) {
    XResizeWindow(p->desktop->display, p->window, (unsigned)width, (unsigned)height);
    XSync(p->desktop->display, False);
}

/* ---- messages ----------------------------------------------------------------------------- */

static void send(const program *p, const char *type, const long data[5]) {
    XEvent event = {.xclient = {.type = ClientMessage,
                                .window = p->window,
                                .message_type = atom(p, type),
                                .format = 32}};
    memcpy(event.xclient.data.l, data, sizeof event.xclient.data.l);
    XSendEvent(p->desktop->display, p->window, False, NoEventMask, &event);
    XSync(p->desktop->display, False);
}

void program_close(const program *p) {
    send(p, "WM_PROTOCOLS", (long[5]){(long)atom(p, "WM_DELETE_WINDOW")});
}

/* Sends the list of files to the window that requests the selection. */
static void give_selection(const program *p, const XSelectionRequestEvent *request,
                           const char *text) {
    XEvent reply = {.xselection = {.type = SelectionNotify,
                                   .requestor = request->requestor,
                                   .selection = request->selection,
                                   .target = request->target,
                                   .property = request->property,
                                   .time = request->time}};
    XChangeProperty(p->desktop->display, request->requestor, request->property, request->target, 8,
                    PropModeReplace, (const unsigned char *)text, (int)strlen(text));
    XSendEvent(p->desktop->display, request->requestor, False, NoEventMask, &reply);
    XSync(p->desktop->display, False);
}

static int is_finished(const program *p, const XEvent *event) {
    return event->type == ClientMessage && event->xclient.message_type == atom(p, "XdndFinished");
}

static void serve_drop(const program *p, const char *text) {
    double end = seconds() + DESKTOP_SECONDS;
    XEvent event = {.type = 0};
    while (!is_finished(p, &event)) {
        if (seconds() > end || has_ended(p)) fail_msg("the files were not taken");
        if (!XPending(p->desktop->display)) {
            pause_shortly();
            continue;
        }
        XNextEvent(p->desktop->display, &event);
        if (event.type == SelectionRequest) give_selection(p, &event.xselectionrequest, text);
    }
}

void program_drop(const program *p, const char *const *paths) {
    Display *display = p->desktop->display;
    Window source = XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
    char text[4096] = "";
    for (; *paths; ++paths) {
        size_t length = strlen(text);
        snprintf(text + length, sizeof text - length, "file://%s\r\n", *paths);
    }
    int x, y;
    to_root(p, 10, 10, &x, &y);
    long me = (long)source, at = (long)x << 16 | y, copy = (long)atom(p, "XdndActionCopy");
    XSetSelectionOwner(display, atom(p, "XdndSelection"), source, CurrentTime);
    send(p, "XdndEnter", (long[5]){me, 5L << 24, (long)atom(p, "text/uri-list")});
    send(p, "XdndPosition", (long[5]){me, 0, at, CurrentTime, copy});
    send(p, "XdndDrop", (long[5]){me, 0, CurrentTime});
    serve_drop(p, text);
    XDestroyWindow(display, source);
}
