/* SPDX-License-Identifier: MIT
 * The real window under Xvfb: keys and pointer in, pictures and titles out. Skipped, with a line
 * that says so, where Xvfb is not installed.
 *
 * Most tests look at a cube, straight on or from the corner where the viewer starts, before a
 * black background, so that what is not black is covered. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "desktop.h"
#include "scene.h"

#include <png.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 320, HEIGHT = 240, SKIPPED = 77 };

typedef struct fixture {
    desktop *desktop;
    char directory[64], a[96], b[96]; /* a.glb is a cube, b.glb a sphere */
    program viewer;
} fixture;

/* ---- files -------------------------------------------------------------------------------- */

/* As a converter does: a new file takes the place of the old one. */
static void write_file(const char *path, const void *data, size_t size) {
    char part[128];
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rename(part, path), 0);
}

static void write_scene(const char *path, scene s) {
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

static void start(fixture *f, const char *option, const char *first, const char *second) {
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

/* Shows a.glb; waits until it is there. */
static void start_cube(fixture *f) {
    start(f, "--lights=headlight", f->a, NULL);
    program_await_title(&f->viewer, "a.glb - 6 splats - phong, lit");
}

static void quit(fixture *f) {
    program_key(&f->viewer, "q", 0);
    assert_int_equal(program_wait(&f->viewer), 0);
}

/* ---- pictures ------------------------------------------------------------------------------ */

static int largest_difference(const uint8_t *a, const uint8_t *b) {
    int largest = 0;
    for (int k = 0; k < 3; ++k)
        if (abs(a[k] - b[k]) > largest) largest = abs(a[k] - b[k]);
    return largest;
}

/* Pixels of the upper 200 rows, below which messages are written, that differ by more than a
 * step: how colours are rounded. */
static int count_differences(const picture *a, const picture *b) {
    int count = 0;
    assert_true(a->width == b->width && a->height == b->height);
    for (int i = 0; i < a->width * 200; ++i)
        count += largest_difference(a->rgb + 3 * i, b->rgb + 3 * i) > 1;
    return count;
}

static int count_covered(const picture *p) {
    int count = 0;
    for (int i = 0; i < p->width * 200; ++i)
        count += p->rgb[3 * i] || p->rgb[3 * i + 1] || p->rgb[3 * i + 2];
    return count;
}

/* What a picture is to be like. */
typedef struct wish {
    const picture *other;
    int at_least, at_most; /* differences from other, or covered pixels where other is NULL */
} wish;

static int is_like(void *user, const program *p) {
    const wish *w = user;
    picture now = program_picture(p);
    int count = w->other ? count_differences(&now, w->other) : count_covered(&now);
    free(now.rgb);
    return count >= w->at_least && count <= w->at_most;
}

/* Differences that matter are hundreds of pixels; a few may flip at splats' edges where sums of
 * moves are rounded. */
enum { FEW = 10, MANY = 500, ALL = WIDTH * HEIGHT };

static void await_change(const fixture *f, const char *what, const picture *from) {
    program_await(&f->viewer, what, is_like, &(wish){from, MANY, ALL});
}

static void await_return(const fixture *f, const char *what, const picture *to) {
    program_await(&f->viewer, what, is_like, &(wish){to, 0, FEW});
}

static picture await_covered(const fixture *f, const char *what, int at_least, int at_most) {
    program_await(&f->viewer, what, is_like, &(wish){NULL, at_least, at_most});
    return program_picture(&f->viewer);
}

static picture covered_cube(fixture *f) {
    start_cube(f);
    return await_covered(f, "the cube is drawn", ALL / 20, ALL);
}

/* ---- camera ------------------------------------------------------------------------------- */

static void drag(const fixture *f, unsigned button, int from_x, int to_x) {
    program_move(&f->viewer, from_x, HEIGHT / 2);
    program_button(&f->viewer, button, 1);
    program_move(&f->viewer, (from_x + to_x) / 2, HEIGHT / 2 + 7);
    program_move(&f->viewer, to_x, HEIGHT / 2);
    program_button(&f->viewer, button, 0);
}

static void test_drag_orbits_and_back(void **state) {
    fixture *f = *state;
    picture first = covered_cube(f);
    drag(f, 1, 160, 220);
    await_change(f, "the view is turned", &first);
    picture turned = program_picture(&f->viewer);
    /* The target stays where it is, so the cube does too. */
    assert_true(abs(count_covered(&turned) - count_covered(&first)) < count_covered(&first) / 4);
    drag(f, 1, 220, 160);
    await_return(f, "the view is turned back", &first);
    free(first.rgb);
    free(turned.rgb);
    quit(f);
}

/* Column of the middle of what is covered. */
static double middle_column(const picture *p) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < p->width * 200; ++i)
        if (p->rgb[3 * i]) sum += i % p->width, ++count;
    return sum / count;
}

/* Within a pixel, since edges cover whole ones. */
static int has_middle(void *user, const program *p) {
    picture now = program_picture(p);
    double off = middle_column(&now) - *(const double *)user;
    free(now.rgb);
    return off > -1 && off < 1;
}

static void test_right_drag_pans_with_the_pointer(void **state) {
    fixture *f = *state;
    free(covered_cube(f).rgb);
    program_key(&f->viewer, "p", 0);
    program_key(&f->viewer, "z", 0);
    /* The height of the window is 2 sqrt 3 / cos 13.5 degrees, the face 2: 134.7 pixels. */
    picture first = await_covered(f, "the cube is seen from the front", 17500, 18800);
    drag(f, 3, 160, 200);
    /* 40 pixels; frames in between show less. */
    double to = middle_column(&first) + 40;
    program_await(&f->viewer, "the view moves with the pointer", has_middle, &to);
    program_key(&f->viewer, "r", 0);
    await_return(f, "all is in the window again", &first);
    free(first.rgb);
    quit(f);
}

static void test_wheel_zooms(void **state) {
    fixture *f = *state;
    picture first = covered_cube(f);
    int covered = count_covered(&first);
    for (int i = 0; i < 3; ++i) {
        program_button(&f->viewer, 4, 1);
        program_button(&f->viewer, 4, 0);
    }
    /* Three steps: 0.88^-6 = 2.2 times the area at the middle, less at the window's edges. */
    picture near = await_covered(f, "the cube is larger", covered * 3 / 2, ALL);
    for (int i = 0; i < 3; ++i) {
        program_button(&f->viewer, 5, 1);
        program_button(&f->viewer, 5, 0);
    }
    await_return(f, "the cube is as large as before", &first);
    free(first.rgb);
    free(near.rgb);
    quit(f);
}

static void test_double_click_aims(void **state) {
    fixture *f = *state;
    free(covered_cube(f).rgb);
    program_key(&f->viewer, "z", 0);
    /* The eye is sqrt 3 / sin 13.5 degrees = 7.42 from the middle, 6.42 from the face, which is
     * 2 / (2 6.42 tan 13.5 degrees) of the height: 156 pixels. */
    picture first = await_covered(f, "the cube is seen from the front", 23500, 25000);
    program_move(&f->viewer, WIDTH / 2 + 50, HEIGHT / 2);
    for (int i = 0; i < 2; ++i) {
        program_button(&f->viewer, 1, 1);
        program_button(&f->viewer, 1, 0);
    }
    /* It was 50 pixels = 0.642 from the middle of the face. The eye, still 7.42 away from its
     * target, is now as far from the face: 0.642 are 43.3 pixels. */
    double to = middle_column(&first) - 43.3;
    program_await(&f->viewer, "the point comes to the middle", has_middle, &to);
    free(first.rgb);
    quit(f);
}

static void test_turntable_turns(void **state) {
    fixture *f = *state;
    picture first = covered_cube(f);
    program_key(&f->viewer, "space", 0);
    await_change(f, "the cube turns", &first);
    picture later = program_picture(&f->viewer);
    await_change(f, "it turns on", &later);
    program_key(&f->viewer, "space", 0);
    free(first.rgb);
    free(later.rgb);
    quit(f);
}

/* ---- settings ------------------------------------------------------------------------------ */

static void test_mode_key_goes_round(void **state) {
    fixture *f = *state;
    start(f, "--mode=gaussian", f->b, NULL);
    program_await_title(&f->viewer, "gaussian, lit");
    picture gaussian = await_covered(f, "the sphere is drawn", ALL / 20, ALL);
    program_key(&f->viewer, "m", 0);
    program_await_title(&f->viewer, "flat, lit");
    await_change(f, "the mode is flat", &gaussian);
    picture flat = program_picture(&f->viewer);
    program_key(&f->viewer, "m", 0);
    program_await_title(&f->viewer, "phong, lit");
    await_change(f, "the mode is Phong", &flat);
    program_key(&f->viewer, "m", 0);
    await_return(f, "the mode is Gaussian again", &gaussian);
    free(gaussian.rgb);
    free(flat.rgb);
    quit(f);
}

static void test_lights_change_the_picture(void **state) {
    fixture *f = *state;
    picture headlight = covered_cube(f);
    program_key(&f->viewer, "l", 0);
    await_change(f, "the lights are others", &headlight);
    free(headlight.rgb);
    quit(f);
}

/* Seen straight on, the face's normal is (0, 0, 1) in eye space: 1/2, 1/2, 1. */
static int is_normal_in_the_middle(void *user, const program *p) {
    picture now = program_picture(p);
    const uint8_t *middle = now.rgb + 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    const uint8_t expected[3] = {128, 128, 255};
    int is_normal = largest_difference(middle, expected) <= 1;
    (void)user;
    free(now.rgb);
    return is_normal;
}

static void test_debug_views(void **state) {
    static const char *const names[] = {"lit",   "unlit",    "toon",  "normal",
                                        "depth", "overdraw", "splats"};
    fixture *f = *state;
    free(covered_cube(f).rgb);
    program_key(&f->viewer, "z", 0);
    program_key(&f->viewer, "4", 0);
    program_await(&f->viewer, "the normal is shown", is_normal_in_the_middle, NULL);
    picture before = program_picture(&f->viewer);
    for (int i = 0; i < 7; ++i) {
        char key[2] = {(char)('1' + i), 0}, part[32];
        if (!strcmp(names[i], "normal")) continue;
        program_key(&f->viewer, key, 0);
        snprintf(part, sizeof part, "phong, %s - ", names[i]);
        program_await_title(&f->viewer, part);
        await_change(f, part, &before);
        free(before.rgb);
        before = program_picture(&f->viewer);
    }
    free(before.rgb);
    quit(f);
}

/* What a key changes and, pressed again, changes back. */
static void expect_toggle(const fixture *f, const char *key, int at_least) {
    picture first = program_picture(&f->viewer);
    program_key(&f->viewer, key, 0);
    program_await(&f->viewer, key, is_like, &(wish){&first, at_least, ALL});
    program_key(&f->viewer, key, 0);
    await_return(f, key, &first);
    free(first.rgb);
}

/* A ball above the cube, such that the strongest light of the studio throws its shadow onto the
 * middle of the cube's upper side. */
static void test_shadows_and_sky(void **state) {
    fixture *f = *state;
    scene ball = scene_sphere(500, 0.5f);
    const double above[3] = {-0.6, 2, 0.8};
    memcpy(ball.origin, above, sizeof above);
    write_scene(f->b, ball);
    start(f, "--lights=studio", f->a, f->b);
    program_await_title(&f->viewer, "a.glb, b.glb - 506 splats");
    free(await_covered(f, "both are drawn", ALL / 20, ALL).rgb);
    expect_toggle(f, "s", 200); /* the shadow */
    expect_toggle(f, "e", MANY);
    quit(f);
}

static void test_filter(void **state) {
    fixture *f = *state;
    start(f, "--mode=phong", f->b, NULL);
    picture large = await_covered(f, "the sphere is drawn", ALL / 20, ALL);
    for (int i = 0; i < 20; ++i) { /* to splats of a pixel */
        program_button(&f->viewer, 5, 1);
        program_button(&f->viewer, 5, 0);
    }
    /* Its area shrinks by 0.88^40 = 0.006. */
    int covered = count_covered(&large);
    free(await_covered(f, "the sphere is small", covered / 250, covered / 100).rgb);
    expect_toggle(f, "f", 8);
    free(large.rgb);
    quit(f);
}

static void test_culling(void **state) {
    fixture *f = *state;
    write_scene(f->a, scene_disc(1));
    start(f, "--mode=flat", f->a, NULL);
    free(await_covered(f, "the disc is drawn", ALL / 20, ALL).rgb);
    program_key(&f->viewer, "z", 1);
    free(await_covered(f, "its back is culled", 0, 0).rgb);
    program_key(&f->viewer, "c", 0);
    free(await_covered(f, "its back is shown", ALL / 20, ALL).rgb);
    program_key(&f->viewer, "c", 0);
    free(await_covered(f, "its back is culled again", 0, 0).rgb);
    quit(f);
}

static void test_help_covers_and_leaves(void **state) {
    fixture *f = *state;
    picture first = covered_cube(f);
    program_key(&f->viewer, "F1", 0);
    await_change(f, "the help is shown", &first);
    program_key(&f->viewer, "Escape", 0); /* closes the help, not the window */
    await_return(f, "the help is gone", &first);
    free(first.rgb);
    quit(f);
}

/* ---- files --------------------------------------------------------------------------------- */

static int decodes(void *user, const program *p) {
    png_image image = {.version = PNG_IMAGE_VERSION};
    (void)p;
    int is_png = png_image_begin_read_from_file(&image, user) && image.width == WIDTH &&
                 image.height == HEIGHT;
    if (is_png) {
        uint8_t *pixels = malloc(PNG_IMAGE_SIZE(image));
        image.format = PNG_FORMAT_RGB;
        is_png = png_image_finish_read(&image, NULL, pixels, 0, NULL) != 0;
        free(pixels);
    }
    png_image_free(&image);
    return is_png;
}

static picture read_png(const char *path) {
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, path));
    image.format = PNG_FORMAT_RGB;
    picture p = {(int)image.width, (int)image.height, malloc(PNG_IMAGE_SIZE(image))};
    assert_true(png_image_finish_read(&image, NULL, p.rgb, 0, NULL));
    return p;
}

static void test_screenshots_are_numbered(void **state) {
    fixture *f = *state;
    picture shown = covered_cube(f);
    char first[128], second[128];
    snprintf(first, sizeof first, "%s/a-001.png", f->directory);
    snprintf(second, sizeof second, "%s/a-002.png", f->directory);
    program_key(&f->viewer, "F12", 0);
    program_await(&f->viewer, "a screenshot is written", decodes, first);
    program_key(&f->viewer, "F1", 0); /* is not in the picture */
    program_key(&f->viewer, "F12", 0);
    program_await(&f->viewer, "another one is written", decodes, second);
    picture saved = read_png(first), again = read_png(second);
    assert_int_equal(count_differences(&shown, &saved), 0);
    assert_int_equal(count_differences(&shown, &again), 0);
    free(shown.rgb);
    free(saved.rgb);
    free(again.rgb);
    quit(f);
}

static void test_changed_file_is_loaded_again(void **state) {
    fixture *f = *state;
    picture cube = covered_cube(f);
    write_scene(f->a, scene_sphere(500, 1));
    program_await_title(&f->viewer, "a.glb - 500 splats");
    await_change(f, "the sphere takes the cube's place", &cube);
    free(cube.rgb);
    quit(f);
}

static void test_broken_file_changes_nothing(void **state) {
    fixture *f = *state;
    picture cube = covered_cube(f);
    write_file(f->a, "glTF?", 5);
    program_await_title(&f->viewer, "a.glb (broken) - 6 splats");
    await_return(f, "the cube is still shown", &cube);
    assert_int_equal(unlink(f->a), 0);
    program_await_title(&f->viewer, "a.glb (broken) - 6 splats");
    write_scene(f->a, scene_cube(1));
    program_await_title(&f->viewer, "a.glb - 6 splats");
    await_return(f, "the cube is shown", &cube);
    free(cube.rgb);
    quit(f);
}

static void test_dropped_files_are_shown(void **state) {
    fixture *f = *state;
    picture cube = covered_cube(f);
    program_drop(&f->viewer, (const char *[]){f->b, NULL});
    program_await_title(&f->viewer, "b.glb - 500 splats");
    await_change(f, "the sphere is shown", &cube);
    program_drop(&f->viewer, (const char *[]){f->a, f->b, f->a, NULL});
    program_await_title(&f->viewer, "a.glb, b.glb - 506 splats");
    picture both = await_covered(f, "both are shown", ALL / 20, ALL);
    program_key(&f->viewer, "a", 0);
    await_change(f, "they stand in a row", &both);
    free(cube.rgb);
    free(both.rgb);
    quit(f);
}

static void test_dropped_rubbish_is_refused(void **state) {
    fixture *f = *state;
    picture cube = covered_cube(f);
    write_file(f->b, "[]", 2);
    program_drop(&f->viewer, (const char *[]){f->b, NULL});
    program_await_title(&f->viewer, "b.glb (broken) - a.glb - 6 splats");
    await_return(f, "the cube is still shown", &cube);
    write_scene(f->a, scene_sphere(500, 1)); /* which is still watched */
    program_await_title(&f->viewer, "a.glb - 500 splats");
    free(cube.rgb);
    quit(f);
}

static void test_window_without_files(void **state) {
    fixture *f = *state;
    start(f, "--mode=flat", NULL, NULL);
    program_await_title(&f->viewer, "phongsplat");
    program_drop(&f->viewer, (const char *[]){f->a, NULL});
    program_await_title(&f->viewer, "a.glb - 6 splats - flat, lit");
    quit(f);
}

static void test_gles_draws_the_same(void **state) {
    fixture *f = *state;
    picture gl = covered_cube(f);
    quit(f);
    start(f, "--gles", f->a, NULL);
    program_await_title(&f->viewer, "a.glb - 6 splats");
    await_return(f, "GLES draws the same", &gl);
    free(gl.rgb);
    quit(f);
}

static void test_closing_the_window_ends_the_program(void **state) {
    fixture *f = *state;
    start_cube(f);
    program_close(&f->viewer);
    assert_int_equal(program_wait(&f->viewer), 0);
}

int main(void) {
    fixture f = {.desktop = desktop_start()};
    if (!f.desktop) {
        fprintf(stderr, "skipped: Xvfb is not installed (samples/install.sh installs it)\n");
        return SKIPPED;
    }
#define WINDOW_TEST(function)                                                                      \
    { #function, function, set_up, tear_down, &f }
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(test_drag_orbits_and_back),
        WINDOW_TEST(test_right_drag_pans_with_the_pointer),
        WINDOW_TEST(test_wheel_zooms),
        WINDOW_TEST(test_double_click_aims),
        WINDOW_TEST(test_turntable_turns),
        WINDOW_TEST(test_mode_key_goes_round),
        WINDOW_TEST(test_lights_change_the_picture),
        WINDOW_TEST(test_debug_views),
        WINDOW_TEST(test_shadows_and_sky),
        WINDOW_TEST(test_filter),
        WINDOW_TEST(test_culling),
        WINDOW_TEST(test_help_covers_and_leaves),
        WINDOW_TEST(test_screenshots_are_numbered),
        WINDOW_TEST(test_changed_file_is_loaded_again),
        WINDOW_TEST(test_broken_file_changes_nothing),
        WINDOW_TEST(test_dropped_files_are_shown),
        WINDOW_TEST(test_dropped_rubbish_is_refused),
        WINDOW_TEST(test_window_without_files),
        WINDOW_TEST(test_gles_draws_the_same),
        WINDOW_TEST(test_closing_the_window_ends_the_program),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    desktop_stop(f.desktop);
    return failed;
}
