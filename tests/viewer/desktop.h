/* SPDX-License-Identifier: MIT
 *
 * desktop.h - a screen of its own for tests of windows: an Xvfb server on a free display, programs
 * on it, keys, pointer, files dropped, and what the windows show. Include after cmocka.h. Whatever
 * does not come about in time fails the test.
 */
#ifndef PHONGSPLAT_TEST_DESKTOP_H
#define PHONGSPLAT_TEST_DESKTOP_H

#include <stdint.h>
#include <sys/types.h>

enum { DESKTOP_SECONDS = 60 }; /* before a condition counts as failed */

typedef struct desktop desktop;

/* 24 bits deep. NULL where there is no Xvfb. */
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
/* Waits for the program to end by itself; its exit code, or -1 where a signal ended it. */
int program_wait(program *p);
void program_kill(program *p); /* no effect after program_wait */

/* Waits until holds(user, p) is not 0; what names the condition in the failure. */
void program_await(const program *p, const char *what, int (*holds)(void *user, const program *p),
                   void *user);
void program_await_title(const program *p, const char *part);
void program_title(const program *p, char *text, size_t size);

/* Of the window: 3 bytes a pixel, row 0 on top; malloc'd. */
typedef struct picture {
    int width, height;
    uint8_t *rgb;
} picture;

picture program_picture(const program *p);

/* name as in X11/keysymdef.h: "m", "F12", "space". */
void program_key(const program *p, const char *name, int shift);
void program_move(const program *p, int x, int y); /* in the window */
void program_button(const program *p, unsigned button, int is_down);
void program_resize(const program *p, int width, int height);
void program_close(const program *p); /* as the button of a window manager does */
/* Drops files by the protocol XDND, version 5; paths are absolute, up to NULL. */
void program_drop(const program *p, const char *const *paths);

#endif
