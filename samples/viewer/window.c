/* SPDX-License-Identifier: MIT
 *
 * window.c - the window, its context and its events. This is the only file that calls GLFW.
 */
#include "viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double double_click_seconds = 0.35, double_click_distance = 4;

struct window {
    GLFWwindow *handle;
    double x, y; /* of the pointer after the events so far, in window units */
    int button;  /* the button that drags, or -1 */
    int modifiers;
    double press_time, press_x, press_y; /* of the left button's last press */
    int frame[4];                        /* position and size before full screen */
};

/* ---- events ------------------------------------------------------------------------------- */

static viewer *viewer_of(GLFWwindow *handle) {
    return glfwGetWindowUserPointer(handle);
}

/* Converts to heights of the window from its middle, y up. */
static void from_middle(GLFWwindow *handle, double x, double y, double out[2]) {
    int width, height;
    glfwGetWindowSize(handle, &width, &height);
    out[0] = height ? (x - 0.5 * width) / height : 0;
    out[1] = height ? 0.5 - y / height : 0;
}

/* Letters are taken as the keyboard's layout names them, all other keys by their place. */
static int layout_key(int key, int scancode) {
    const char *name = glfwGetKeyName(key, scancode);
    return name && name[0] >= 'a' && name[0] <= 'z' && !name[1] ? name[0] - 'a' + GLFW_KEY_A : key;
}

static void on_key(GLFWwindow *handle, int key, int scancode, int action, int modifiers) {
    if (action == GLFW_RELEASE) return;
    input_key(viewer_of(handle), layout_key(key, scancode), modifiers, action == GLFW_REPEAT);
}

static int is_double_click(window *w, double now) {
    int is_close = hypot(w->x - w->press_x, w->y - w->press_y) <= double_click_distance;
    int is_second = now - w->press_time < double_click_seconds && is_close;
    w->press_time = is_second ? -1 : now; /* a third press starts anew */
    w->press_x = w->x;
    w->press_y = w->y;
    return is_second;
}

static void on_button(GLFWwindow *handle, int button, int action, int modifiers) {
    viewer *v = viewer_of(handle);
    window *w = v->window;
    if (action == GLFW_RELEASE) {
        if (button == w->button) w->button = -1;
        return;
    }
    w->button = button;
    w->modifiers = modifiers;
    if (button != GLFW_MOUSE_BUTTON_LEFT || !is_double_click(w, glfwGetTime())) return;
    double at[2];
    from_middle(handle, w->x, w->y, at);
    input_double_click(v, at[0], at[1]);
}

static void on_move(GLFWwindow *handle, double x, double y) {
    viewer *v = viewer_of(handle);
    window *w = v->window;
    double from[2], to[2];
    from_middle(handle, w->x, w->y, from);
    from_middle(handle, x, y, to);
    w->x = x;
    w->y = y;
    if (w->button >= 0) input_drag(v, w->button, w->modifiers, to[0] - from[0], to[1] - from[1]);
}

static void on_scroll(GLFWwindow *handle, double x, double y) {
    viewer *v = viewer_of(handle);
    double at[2];
    (void)x;
    from_middle(handle, v->window->x, v->window->y, at);
    input_scroll(v, y, at[0], at[1]);
}

static void on_drop(GLFWwindow *handle, int count, const char **paths) {
    if (count > 0) input_drop(viewer_of(handle), paths, (size_t)count);
}

static void on_resize(GLFWwindow *handle, int width, int height) {
    (void)width, (void)height;
    viewer_of(handle)->is_cold = viewer_of(handle)->needs_redraw = 1;
}

static void on_refresh(GLFWwindow *handle) {
    viewer_of(handle)->needs_redraw = 1;
}

static void set_callbacks(GLFWwindow *handle) {
    glfwSetKeyCallback(handle, on_key);
    glfwSetMouseButtonCallback(handle, on_button);
    glfwSetCursorPosCallback(handle, on_move);
    glfwSetScrollCallback(handle, on_scroll);
    glfwSetDropCallback(handle, on_drop);
    glfwSetFramebufferSizeCallback(handle, on_resize);
    glfwSetWindowRefreshCallback(handle, on_refresh);
}

/* ---- the window --------------------------------------------------------------------------- */

static void set_hints(const options *o) {
    glfwWindowHint(GLFW_CLIENT_API, o->is_gles ? GLFW_OPENGL_ES_API : GLFW_OPENGL_API);
    glfwWindowHint(GLFW_CONTEXT_CREATION_API,
                   o->is_gles ? GLFW_EGL_CONTEXT_API : GLFW_NATIVE_CONTEXT_API);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, o->is_gles ? 0 : 3);
    if (!o->is_gles) {
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    }
    glfwWindowHint(GLFW_DEPTH_BITS, 24);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, o->width ? GLFW_FALSE : GLFW_TRUE);
}

static psplat_result fail(psplat_error *error) {
    const char *cause = NULL;
    glfwGetError(&cause);
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "no window: %.200s",
                       cause ? cause : "unknown cause");
}

static GLFWwindow *create_handle(const options *o) {
    int width = o->width ? o->width : 1280, height = o->width ? o->height : 800;
    set_hints(o);
    return glfwCreateWindow(width, height, "phongsplat", NULL, NULL);
}

window *window_create(viewer *v, const options *o, psplat_error *error) {
    window *w = calloc(1, sizeof *w);
    if (!w) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a window"), NULL;
    if (!glfwInit()) return fail(error), free(w), NULL;
    w->handle = create_handle(o);
    if (!w->handle) return fail(error), window_destroy(w), NULL;
    w->button = -1;
    w->press_time = -1;
    glfwMakeContextCurrent(w->handle);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(w->handle, v);
    set_callbacks(w->handle);
    return w;
}

void window_destroy(window *w) {
    if (!w) return;
    glfwTerminate(); /* also destroys the window */
    free(w);
}

void window_wait(window *w, double timeout) {
    (void)w;
    if (timeout > 0)
        glfwWaitEventsTimeout(timeout);
    else
        glfwPollEvents();
}

void window_wake(void) {
    glfwPostEmptyEvent();
}

void window_present(window *w) {
    glfwSwapBuffers(w->handle);
}

void window_set_title(window *w, const char *text) {
    glfwSetWindowTitle(w->handle, text);
}

void window_size(const window *w, int *width, int *height) {
    glfwGetFramebufferSize(w->handle, width, height);
}

void window_toggle_full_screen(window *w) {
    if (glfwGetWindowMonitor(w->handle)) {
        glfwSetWindowMonitor(w->handle, NULL, w->frame[0], w->frame[1], w->frame[2], w->frame[3],
                             0);
        return;
    }
    GLFWmonitor *monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode *mode = monitor ? glfwGetVideoMode(monitor) : NULL;
    if (!mode) return;
    glfwGetWindowPos(w->handle, &w->frame[0], &w->frame[1]);
    glfwGetWindowSize(w->handle, &w->frame[2], &w->frame[3]);
    glfwSetWindowMonitor(w->handle, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

int window_is_closing(const window *w) {
    return glfwWindowShouldClose(w->handle);
}

void window_close(window *w) {
    glfwSetWindowShouldClose(w->handle, GLFW_TRUE);
}

double window_seconds(void) {
    return glfwGetTime();
}

void *window_get_proc(void *user, const char *name) {
    void *address;
    GLFWglproc function = glfwGetProcAddress(name);
    (void)user;
    memcpy(&address, &function, sizeof address);
    return address;
}
