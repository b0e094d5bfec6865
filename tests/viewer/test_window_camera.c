/* SPDX-License-Identifier: MIT
 *
 * test_window_camera.c - tests orbit, pan, zoom and aim in the real window. Expected pixel counts
 * follow from the geometry of the cube and of the camera's lens.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "window_fixture.h"

#include <stdlib.h>

static void drag(const fixture *f, unsigned button, int from_x, int to_x) {
    program_move(&f->viewer, from_x, HEIGHT / 2);
    program_button(&f->viewer, button, 1);
    program_move(&f->viewer, (from_x + to_x) / 2, HEIGHT / 2 + 7);
    program_move(&f->viewer, to_x, HEIGHT / 2);
    program_button(&f->viewer, button, 0);
}

static void test_drag_orbits_and_back(void **state) {
    fixture *f = *state;
    picture first = start_cube(f);
    drag(f, 1, 160, 220);
    await_change(f, "the view is turned", &first);
    picture turned = program_picture(&f->viewer);
    /* The target stays where it is, and so does the cube. */
    assert_true(abs(count_covered(&turned) - count_covered(&first)) < count_covered(&first) / 4);
    drag(f, 1, 220, 160);
    await_return(f, "the view is turned back", &first);
    free(first.rgb);
    free(turned.rgb);
    quit(f);
}

/* Returns the middle column of the covered pixels. */
static double middle_column(const picture *p) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < p->width * 200; ++i)
        if (p->rgb[3 * i]) sum += i % p->width, ++count;
    return sum / count;
}

/* The tolerance is a pixel, since edges cover whole pixels. */
static int has_middle(void *user, const program *p) {
    picture now = program_picture(p);
    double off = middle_column(&now) - *(const double *)user;
    free(now.rgb);
    return off > -1 && off < 1;
}

static void test_right_drag_pans_with_the_pointer(void **state) {
    fixture *f = *state;
    free(start_cube(f).rgb);
    program_key(&f->viewer, "p", 0);
    program_key(&f->viewer, "z", 0);
    /* The window's height spans 2 sqrt 3 / cos 13.5 degrees, the face 2: it is 134.7 pixels
     * wide. */
    picture first = await_covered(f, "the cube is seen from the front", 17500, 18800);
    drag(f, 3, 160, 200);
    /* The drag is 40 pixels long; frames before its end show less. */
    double to = middle_column(&first) + 40;
    program_await(&f->viewer, "the view moves with the pointer", has_middle, &to);
    program_key(&f->viewer, "r", 0);
    await_return(f, "all is in the window again", &first);
    free(first.rgb);
    quit(f);
}

static void test_wheel_zooms(void **state) {
    fixture *f = *state;
    picture first = start_cube(f);
    int covered = count_covered(&first);
    for (int i = 0; i < 3; ++i) {
        program_button(&f->viewer, 4, 1);
        program_button(&f->viewer, 4, 0);
    }
    /* Three steps enlarge the area at the middle by 0.88^-6 = 2.2, and by less at the window's
     * edges. */
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
    free(start_cube(f).rgb);
    program_key(&f->viewer, "z", 0);
    /* The eye is sqrt 3 / sin 13.5 degrees = 7.42 from the middle and 6.42 from the face, which
     * takes 2 / (2 6.42 tan 13.5 degrees) of the height: 156 pixels. */
    picture first = await_covered(f, "the cube is seen from the front", 23500, 25000);
    program_move(&f->viewer, WIDTH / 2 + 50, HEIGHT / 2);
    for (int i = 0; i < 2; ++i) {
        program_button(&f->viewer, 1, 1);
        program_button(&f->viewer, 1, 0);
    }
    /* The point was 50 pixels = 0.642 from the middle of the face. The eye, still 7.42 away from
     * its target, is now as far from the face, where 0.642 are 43.3 pixels. */
    double to = middle_column(&first) - 43.3;
    program_await(&f->viewer, "the point comes to the middle", has_middle, &to);
    free(first.rgb);
    quit(f);
}

static void test_turntable_turns(void **state) {
    fixture *f = *state;
    picture first = start_cube(f);
    program_key(&f->viewer, "space", 0);
    await_change(f, "the cube turns", &first);
    picture later = program_picture(&f->viewer);
    await_change(f, "it turns on", &later);
    program_key(&f->viewer, "space", 0);
    free(first.rgb);
    free(later.rgb);
    quit(f);
}

/* The whole width and height are drawn again, and what fitted before fits the new height. */
static int is_resized(void *user, const program *p) {
    picture now = program_picture(p);
    const int *from_to = user;
    int covered = 0;
    for (int i = 0; i < now.width * now.height; ++i) covered += now.rgb[3 * i] != 0;
    free(now.rgb);
    return now.width == 640 && now.height == 480 && covered > from_to[0] && covered < from_to[1];
}

static void test_resizing_scales_the_picture(void **state) {
    fixture *f = *state;
    free(start_cube(f).rgb);
    program_key(&f->viewer, "z", 0);
    picture first = await_covered(f, "the cube is seen from the front", 23500, 25000);
    /* Twice the height gives four times the area, up to a row of pixels at the edges. */
    int covered = count_covered(&first), between[] = {4 * covered - 700, 4 * covered + 700};
    program_resize(&f->viewer, 640, 480);
    program_await(&f->viewer, "the picture is scaled", is_resized, between);
    free(first.rgb);
    quit(f);
}

int test_window_camera_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_drag_orbits_and_back),
        cmocka_unit_test(test_right_drag_pans_with_the_pointer),
        cmocka_unit_test(test_wheel_zooms),
        cmocka_unit_test(test_double_click_aims),
        cmocka_unit_test(test_turntable_turns),
        cmocka_unit_test(test_resizing_scales_the_picture),
    };
    return window_run(tests, sizeof tests / sizeof *tests);
}
