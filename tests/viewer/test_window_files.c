/* SPDX-License-Identifier: MIT
 *
 * test_window_files.c - tests the real window with screenshots, changed, broken and dropped files,
 * contexts, and its end.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "window_fixture.h"

#include <png.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    picture shown = start_cube(f);
    char first[128], second[128];
    snprintf(first, sizeof first, "%s/a-001.png", f->directory);
    snprintf(second, sizeof second, "%s/a-002.png", f->directory);
    program_key(&f->viewer, "F12", 0);
    program_await(&f->viewer, "a screenshot is written", decodes, first);
    program_key(&f->viewer, "F1", 0); /* the help is not in the screenshot */
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

/* The example of the specification has red, green and blue squares in its image. */
static void test_textures_are_shown(void **state) {
    fixture *f = *state;
    start(f, "--shading=unlit", PSPLAT_SOURCE_DIR "/schema/textured.gltf", NULL);
    picture p = await_covered(f, "textured splats are drawn", ALL / 50, ALL);
    int strong[3] = {0, 0, 0};
    for (int i = 0; i < p.width * 200; ++i)
        for (int k = 0; k < 3; ++k) {
            const uint8_t *rgb = p.rgb + 3 * i;
            strong[k] += rgb[k] > 3 * rgb[(k + 1) % 3] / 2 && rgb[k] > 3 * rgb[(k + 2) % 3] / 2;
        }
    for (int k = 0; k < 3; ++k) assert_true(strong[k] > 50);
    free(p.rgb);
    quit(f);
}

static void test_changed_file_is_loaded_again(void **state) {
    fixture *f = *state;
    picture cube = start_cube(f);
    write_scene(f->a, scene_sphere(500, 1));
    program_await_title(&f->viewer, "a.glb - 500 splats");
    await_change(f, "the sphere takes the cube's place", &cube);
    free(cube.rgb);
    quit(f);
}

static void test_broken_file_changes_nothing(void **state) {
    fixture *f = *state;
    picture cube = start_cube(f);
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
    picture cube = start_cube(f);
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
    picture cube = start_cube(f);
    write_file(f->b, "[]", 2);
    program_drop(&f->viewer, (const char *[]){f->b, NULL});
    program_await_title(&f->viewer, "b.glb (broken) - a.glb - 6 splats");
    await_return(f, "the cube is still shown", &cube);
    write_scene(f->a, scene_sphere(500, 1)); /* the file is still watched */
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
    picture gl = start_cube(f);
    quit(f);
    start(f, "--gles", f->a, NULL);
    program_await_title(&f->viewer, "a.glb - 6 splats");
    await_return(f, "GLES draws the same", &gl);
    free(gl.rgb);
    quit(f);
}

static void test_closing_the_window_ends_the_program(void **state) {
    fixture *f = *state;
    free(start_cube(f).rgb);
    program_close(&f->viewer);
    assert_int_equal(program_wait(&f->viewer), 0);
}

int test_window_files_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_textures_are_shown),
        cmocka_unit_test(test_screenshots_are_numbered),
        cmocka_unit_test(test_changed_file_is_loaded_again),
        cmocka_unit_test(test_broken_file_changes_nothing),
        cmocka_unit_test(test_dropped_files_are_shown),
        cmocka_unit_test(test_dropped_rubbish_is_refused),
        cmocka_unit_test(test_window_without_files),
        cmocka_unit_test(test_gles_draws_the_same),
        cmocka_unit_test(test_closing_the_window_ends_the_program),
    };
    return window_run(tests, sizeof tests / sizeof *tests);
}
