/* SPDX-License-Identifier: MIT
 *
 * window_fixture.c - the viewer on a screen of its own; see window_fixture.h.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "window_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { COUNTED_ROWS = 200, MAX_TESTS = 16, SKIPPED = 77 };

/* ---- files -------------------------------------------------------------------------------- */

void write_file(const char *path, const void *data, size_t size) {
    char part[128];
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rename(part, path), 0);
}

void write_scene(const char *path, scene s) {
    size_t size;
    uint8_t *glb = scene_glb(&s, &size);
    write_file(path, glb, size);
    free(glb);
    scene_free(&s);
}

static void remove_files(const fixture *f) {
    char command[128];
    snprintf(command, sizeof command, "rm -r '%s'", f->directory);
    assert_int_equal(system(command), 0);
}

/* ---- set up ------------------------------------------------------------------------------- */

static int set_up(void **state) {
    fixture *f = *state;
    strcpy(f->directory, "/tmp/phongsplat-XXXXXX");
    assert_non_null(mkdtemp(f->directory));
    snprintf(f->a, sizeof f->a, "%s/a.glb", f->directory);
    snprintf(f->b, sizeof f->b, "%s/b.glb", f->directory);
    write_scene(f->a, scene_cube(1));
    write_scene(f->b, scene_sphere(500, 1));
    return 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    program_kill(&f->viewer);
    remove_files(f);
    return 0;
}

void start(fixture *f, const char *option, const char *first, const char *second) {
    const char *argv[] = {PSPLAT_BINARY_DIR "/phongsplat-viewer",
                          "--size",
                          "320x240",
                          "--background",
                          "black",
                          option,
                          first,
                          second,
                          NULL};
    f->viewer = program_start(f->desktop, argv);
    program_move(&f->viewer, WIDTH / 2, HEIGHT / 2);
}

void quit(fixture *f) {
    program_key(&f->viewer, "q", 0);
    assert_int_equal(program_wait(&f->viewer), 0);
}

/* ---- pictures ------------------------------------------------------------------------------ */

int largest_difference(const uint8_t *a, const uint8_t *b) {
    int largest = 0;
    for (int k = 0; k < 3; ++k)
        if (abs(a[k] - b[k]) > largest) largest = abs(a[k] - b[k]);
    return largest;
}

int count_differences(const picture *a, const picture *b) {
    int count = 0;
    assert_true(a->width == b->width && a->height == b->height);
    for (int i = 0; i < a->width * COUNTED_ROWS; ++i)
        count += largest_difference(a->rgb + 3 * i, b->rgb + 3 * i) > 1;
    return count;
}

int count_covered(const picture *p) {
    int count = 0;
    for (int i = 0; i < p->width * COUNTED_ROWS; ++i)
        count += p->rgb[3 * i] || p->rgb[3 * i + 1] || p->rgb[3 * i + 2];
    return count;
}

/* What a picture is expected to be like. */
typedef struct expectation {
    const picture *other;
    int at_least, at_most; /* differences from other, or covered pixels where other is NULL */
} expectation;

static int is_like(void *user, const program *p) {
    const expectation *w = user;
    picture now = program_picture(p);
    int count = w->other ? count_differences(&now, w->other) : count_covered(&now);
    free(now.rgb);
    return count >= w->at_least && count <= w->at_most;
}

void await_differences(const fixture *f, const char *what, const picture *from, int at_least) {
    program_await(&f->viewer, what, is_like, &(expectation){from, at_least, ALL});
}

void await_change(const fixture *f, const char *what, const picture *from) {
    await_differences(f, what, from, MANY);
}

void await_return(const fixture *f, const char *what, const picture *to) {
    program_await(&f->viewer, what, is_like, &(expectation){to, 0, FEW});
}

picture await_covered(const fixture *f, const char *what, int at_least, int at_most) {
    program_await(&f->viewer, what, is_like, &(expectation){NULL, at_least, at_most});
    return program_picture(&f->viewer);
}

/* Keeps the picture in user, and returns whether it is as the one before. */
static int is_still(void *user, const program *p) {
    picture *before = user, now = program_picture(p);
    int is_same = before->rgb && count_differences(&now, before) == 0;
    free(before->rgb);
    *before = now;
    return is_same;
}

picture await_still(const fixture *f, const char *what) {
    picture still = {.rgb = NULL};
    program_await(&f->viewer, what, is_still, &still);
    return still;
}

picture start_cube(fixture *f) {
    start(f, "--lights=headlight", f->a, NULL);
    program_await_title(&f->viewer, "a.glb - 6 splats - phong, lit");
    return await_covered(f, "the cube is drawn", ALL / 20, ALL);
}

/* ---- running ------------------------------------------------------------------------------- */

int window_run(const struct CMUnitTest *tests, size_t count) {
    fixture f = {.desktop = desktop_start()};
    struct CMUnitTest copies[MAX_TESTS];
    if (!f.desktop) {
        fprintf(stderr, "skipped: Xvfb is not installed (samples/install.sh installs it)\n");
        return SKIPPED;
    }
    assert_true(count <= MAX_TESTS);
    for (size_t i = 0; i < count; ++i) {
        copies[i] = tests[i];
        copies[i].setup_func = set_up;
        copies[i].teardown_func = tear_down;
        copies[i].initial_state = &f;
    }
    int failed = _cmocka_run_group_tests("window", copies, count, NULL, NULL);
    desktop_stop(f.desktop);
    return failed;
}
