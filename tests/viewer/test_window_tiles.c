/* SPDX-License-Identifier: MIT
 *
 * test_window_tiles.c - tests the real window with a tileset: a coarse tile, a cube of 6 splats,
 * and what takes its place up close, a sphere of 500.
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

#define BOX "\"boundingVolume\": {\"box\": [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]}"

static void write_tileset(const fixture *f, const char *fine) {
    char path[128], text[512];
    snprintf(path, sizeof path, "%s/tileset.json", f->directory);
    snprintf(
        text, sizeof text,
        "{\"asset\": {\"version\": \"1.1\"}, \"geometricError\": 10, \"root\": {" BOX
        ", \"geometricError\": 0.015, \"refine\": \"REPLACE\", \"content\": {\"uri\": \"a.glb\"}, "
        "\"children\": [{" BOX ", \"geometricError\": 0.0001, \"content\": {\"uri\": \"%s\"}}]}}",
        fine);
    write_file(path, text, strlen(text));
}

/* A unit of length is some 100 pixels, so that the cube's error is 1.5 of them, between the
 * greatest error that is allowed at first and twice that. */
static void test_tiles_are_drawn_as_the_error_wants_them(void **state) {
    fixture *f = *state;
    write_tileset(f, "b.glb");
    start(f, "--lights=headlight", f->directory, NULL);
    program_await_title(&f->viewer, " - 500 splats");
    picture sphere = await_covered(f, "the sphere is drawn", ALL / 20, ALL);
    program_key(&f->viewer, "bracketright", 0);
    program_await_title(&f->viewer, " - 6 splats");
    await_change(f, "the cube takes its place", &sphere);
    program_key(&f->viewer, "bracketleft", 0);
    program_await_title(&f->viewer, " - 500 splats");
    await_return(f, "the sphere is back", &sphere);
    program_key(&f->viewer, "t", 0);
    await_differences(f, "numbers of tiles are shown", &sphere, 100);
    program_key(&f->viewer, "t", 0);
    await_return(f, "they are hidden", &sphere);
    free(sphere.rgb);
    quit(f);
}

static void test_a_missing_tile_leaves_the_one_above(void **state) {
    fixture *f = *state;
    char path[128];
    write_tileset(f, "none.glb");
    snprintf(path, sizeof path, "%s/tileset.json", f->directory);
    start(f, "--lights=headlight", path, NULL);
    program_await_title(&f->viewer, "tileset.json - 6 splats");
    free(await_covered(f, "the cube is drawn", ALL / 20, ALL).rgb);
    write_tileset(f, "b.glb"); /* a tileset that changes is opened again */
    program_await_title(&f->viewer, "tileset.json - 500 splats");
    quit(f);
}

static void test_tilesets_stand_beside_assets(void **state) {
    fixture *f = *state;
    picture cube = start_cube(f);
    write_tileset(f, "b.glb");
    program_drop(&f->viewer, (const char *[]){f->directory, f->a, NULL});
    program_await_title(&f->viewer, " - 506 splats");
    picture both = await_covered(f, "both are drawn", ALL / 20, ALL);
    program_key(&f->viewer, "a", 0);
    await_change(f, "they stand in a row", &both);
    program_drop(&f->viewer, (const char *[]){f->a, NULL});
    program_await_title(&f->viewer, "a.glb - 6 splats");
    await_return(f, "the cube alone is drawn", &cube);
    free(both.rgb);
    free(cube.rgb);
    quit(f);
}

static void test_a_broken_tileset_is_refused(void **state) {
    fixture *f = *state;
    char path[128];
    snprintf(path, sizeof path, "%s/tileset.json", f->directory);
    picture cube = start_cube(f);
    write_file(path, "{}", 2);
    program_drop(&f->viewer, (const char *[]){path, NULL});
    program_await_title(&f->viewer, "tileset.json (broken) - a.glb - 6 splats");
    await_return(f, "the cube is still shown", &cube);
    free(cube.rgb);
    quit(f);
}

int test_window_tiles_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tiles_are_drawn_as_the_error_wants_them),
        cmocka_unit_test(test_a_missing_tile_leaves_the_one_above),
        cmocka_unit_test(test_tilesets_stand_beside_assets),
        cmocka_unit_test(test_a_broken_tileset_is_refused),
    };
    return window_run(tests, sizeof tests / sizeof *tests);
}
