/* SPDX-License-Identifier: MIT
 *
 * window_fixture.h - what the tests of the viewer's window share: a directory with two assets, the
 * viewer on a screen of its own, and pictures to compare. The window is small and its background
 * black, so that every pixel that is not black is covered. Only the upper 200 rows of a picture
 * count, because messages are written below them. Include this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_WINDOW_FIXTURE_H
#define PHONGSPLAT_TEST_WINDOW_FIXTURE_H

#include "desktop.h"
#include "scene_asset.h"

enum { WIDTH = 320, HEIGHT = 240 };

/* Numbers of pixels. Real differences are hundreds of pixels; up to FEW may flip at the edges of
 * splats, where sums of moves are rounded. */
enum { FEW = 10, MANY = 500, ALL = WIDTH * HEIGHT };

typedef struct fixture {
    desktop *desktop;
    char directory[64], a[96], b[96]; /* a.glb is a cube, b.glb a sphere */
    program viewer;
} fixture;

/* Runs the tests, each with a directory of its own, on one desktop, and returns main's exit code.
 * Without Xvfb the tests are skipped, and a line says so. */
int window_run(const struct CMUnitTest *tests, size_t count);

/* Writes as a converter does: a new file takes the place of the old one. */
void write_file(const char *path, const void *data, size_t size);
void write_scene(const char *path, scene s); /* frees s */

/* Starts the viewer with an option and up to two files. The pointer is in the middle of its
 * window. */
void start(fixture *f, const char *option, const char *first, const char *second);
/* Shows a.glb lit by the headlight and waits until it is there. The caller frees rgb. */
picture start_cube(fixture *f);
/* Quits by key and expects exit code 0. */
void quit(fixture *f);

/* Returns the largest difference of two colours' components. */
int largest_difference(const uint8_t *a, const uint8_t *b);
/* Counts pixels that differ by more than one step, which rounding of colours may cause. */
int count_differences(const picture *a, const picture *b);
int count_covered(const picture *p);

/* These wait until at least at_least pixels differ from the picture, until MANY differ, until
 * hardly any differs, or until the number of covered pixels is in a range. */
void await_differences(const fixture *f, const char *what, const picture *from, int at_least);
void await_change(const fixture *f, const char *what, const picture *from);
void await_return(const fixture *f, const char *what, const picture *to);
picture await_covered(const fixture *f, const char *what, int at_least, int at_most);
/* Waits until the picture stays: one may be taken while the window is drawn. The caller frees rgb.
 */
picture await_still(const fixture *f, const char *what);

#endif
