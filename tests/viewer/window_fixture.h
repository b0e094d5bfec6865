/* SPDX-License-Identifier: MIT
 *
 * window_fixture.h - what the tests of the viewer's window share: a directory with two assets, the
 * viewer on a screen of its own, and pictures to compare. Include after cmocka.h.
 *
 * The window is small and its background black, so that what is not black is covered. Pictures
 * count in their upper 200 rows, below which messages are written.
 */
#ifndef PHONGSPLAT_TEST_WINDOW_FIXTURE_H
#define PHONGSPLAT_TEST_WINDOW_FIXTURE_H

#include "desktop.h"
#include "scene_asset.h"

enum { WIDTH = 320, HEIGHT = 240 };

/* Differences that matter are hundreds of pixels; a few may flip at splats' edges where sums of
 * moves are rounded. */
enum { FEW = 10, MANY = 500, ALL = WIDTH * HEIGHT };

typedef struct fixture {
    desktop *desktop;
    char directory[64], a[96], b[96]; /* a.glb is a cube, b.glb a sphere */
    program viewer;
} fixture;

/* Runs the tests, each with a directory of its own, on one desktop; for main to return. Without
 * Xvfb they are skipped, and a line says so. */
int window_run(const struct CMUnitTest *tests, size_t count);

/* As a converter does: a new file takes the place of the old one. */
void write_file(const char *path, const void *data, size_t size);
void write_scene(const char *path, scene s); /* frees s */

/* The viewer with an option and up to two files; the pointer is in the middle of its window. */
void start(fixture *f, const char *option, const char *first, const char *second);
/* Shows a.glb lit by the headlight and waits until it is there; the caller frees rgb. */
picture start_cube(fixture *f);
/* By its key; the exit code must be 0. */
void quit(fixture *f);

/* The largest difference of two colours' components. */
int largest_difference(const uint8_t *a, const uint8_t *b);
/* Pixels that differ by more than a step: how colours are rounded. */
int count_differences(const picture *a, const picture *b);
int count_covered(const picture *p);

/* Wait until at_least pixels differ from the picture, MANY do, hardly any does, or so many are
 * covered. */
void await_differences(const fixture *f, const char *what, const picture *from, int at_least);
void await_change(const fixture *f, const char *what, const picture *from);
void await_return(const fixture *f, const char *what, const picture *to);
picture await_covered(const fixture *f, const char *what, int at_least, int at_most);

#endif
