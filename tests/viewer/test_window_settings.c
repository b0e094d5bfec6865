/* SPDX-License-Identifier: MIT
 *
 * test_window_settings.c - tests in the real window the keys that change how things are drawn.
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
    picture headlight = start_cube(f);
    program_key(&f->viewer, "l", 0);
    await_change(f, "the lights are others", &headlight);
    free(headlight.rgb);
    quit(f);
}

/* Seen straight on, the face's normal is (0, 0, 1) in eye space: its colour is 1/2, 1/2, 1. */
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
    free(start_cube(f).rgb);
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

/* Expects that a key changes the picture and, pressed again, changes it back. */
static void expect_toggle(const fixture *f, const char *key, int at_least) {
    picture first = program_picture(&f->viewer);
    program_key(&f->viewer, key, 0);
    await_differences(f, key, &first, at_least);
    program_key(&f->viewer, key, 0);
    await_return(f, key, &first);
    free(first.rgb);
}

/* Places a sphere above the cube, so that the strongest light of the studio throws its shadow onto
 * the middle of the cube's upper side. */
static void test_shadows_and_sky(void **state) {
    fixture *f = *state;
    scene ball = scene_sphere(500, 0.5f);
    const double above[3] = {-0.6, 2, 0.8};
    memcpy(ball.origin, above, sizeof above);
    write_scene(f->b, ball);
    start(f, "--lights=studio", f->a, f->b);
    program_await_title(&f->viewer, "a.glb, b.glb - 506 splats");
    free(await_covered(f, "both are drawn", ALL / 20, ALL).rgb);
    expect_toggle(f, "s", 200); /* toggles the shadow */
    expect_toggle(f, "e", MANY);
    quit(f);
}

/* Looks for colours between the cube's and the black backdrop, at least a fifth of the way from
 * both. */
static int has_edges(void *user, const program *p) {
    picture now = program_picture(p);
    int count = 0, at_least = *(const int *)user;
    for (int i = 0; i < WIDTH * 200; ++i) count += now.rgb[3 * i] > 20 && now.rgb[3 * i] < 60;
    free(now.rgb);
    return count >= at_least;
}

/* The key light alone leaves no side of the cube darker than its ambient part, 0.12: 97 of 255. */
static void test_smooth_edges(void **state) {
    fixture *f = *state;
    int some = 20;
    picture hard = start_cube(f);
    for (int i = 0; i < WIDTH * 200; ++i) assert_true(hard.rgb[3 * i] == 0 || hard.rgb[3 * i] > 90);
    program_key(&f->viewer, "v", 0);
    program_await(&f->viewer, "edges are smooth", has_edges, &some);
    program_key(&f->viewer, "v", 0);
    await_return(f, "edges are hard", &hard);
    free(hard.rgb);
    quit(f);
}

static void test_filter(void **state) {
    fixture *f = *state;
    start(f, "--mode=phong", f->b, NULL);
    picture large = await_covered(f, "the sphere is drawn", ALL / 20, ALL);
    for (int i = 0; i < 20; ++i) { /* until splats are a pixel wide */
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
    picture first = start_cube(f);
    program_key(&f->viewer, "F1", 0);
    await_change(f, "the help is shown", &first);
    program_key(&f->viewer, "Escape", 0); /* Escape closes the help, not the window */
    await_return(f, "the help is gone", &first);
    free(first.rgb);
    quit(f);
}

int test_window_settings_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mode_key_goes_round),
        cmocka_unit_test(test_lights_change_the_picture),
        cmocka_unit_test(test_debug_views),
        cmocka_unit_test(test_shadows_and_sky),
        cmocka_unit_test(test_smooth_edges),
        cmocka_unit_test(test_filter),
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_help_covers_and_leaves),
    };
    return window_run(tests, sizeof tests / sizeof *tests);
}
