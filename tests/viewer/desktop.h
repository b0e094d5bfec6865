/* SPDX-License-Identifier: MIT
 *
 * desktop.h - a screen of its own for tests of windows: it starts an Xvfb server on a free display
 * and programs on it, sends keys, pointer movements and dropped files, and reads what the windows
 * show. A condition that does not come true in time fails the test. Include this file after
 * cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_DESKTOP_H
#define PHONGSPLAT_TEST_DESKTOP_H

#include <stdint.h>
#include <sys/types.h>

enum { DESKTOP_SECONDS = 60 }; /* seconds until a condition has failed */

typedef struct desktop desktop;

/* Starts a screen of 24 bits a pixel. Returns NULL where there is no Xvfb. */
desktop *desktop_start(void);
void desktop_stop(desktop *d);

/* A program with one window. */
typedef struct program {
    desktop *desktop;
    pid_t pid;
    unsigned long window;
} program;

/* Runs argv (up to NULL) on the desktop and waits for its window. */
program program_start(desktop *d, const char *const *argv);
/* Waits for the program to end by itself. Returns its exit code, or -1 where a signal ended it. */
int program_wait(program *p);
void program_kill(program *p); /* has no effect after program_wait */

/* Waits until holds(user, p) is not 0; what names the condition in the failure. */
void program_await(const program *p, const char *what, int (*holds)(void *user, const program *p),
                   void *user);
void program_await_title(const program *p, const char *part);
void program_title(const program *p, char *text, size_t size);

/* A picture of the window: 3 bytes a pixel, row 0 on top, allocated with malloc. */
typedef struct picture {
    int width, height;
    uint8_t *rgb;
} picture;

picture program_picture(const program *p);

/* name is one of X11/keysymdef.h: "m", "F12", "space". */
void program_key(const program *p, const char *name, int shift);
void program_move(const program *p, int x, int y); /* in pixels of the window */
void program_button(const program *p, unsigned button, int is_down);
void program_resize(const program *p, int width, int height);
void program_close(const program *p); /* as a window manager's button does */
/* Drops files by the protocol XDND, version 5. paths are absolute and end with NULL. */
void program_drop(const program *p, const char *const *paths);

#endif
