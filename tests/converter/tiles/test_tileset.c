/* SPDX-License-Identifier: MIT
 *
 * Tests of tilesets: the tree of tiles, errors that never grow downwards, and the JSON of files.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/tileset.h"

/* Makes a tile of a level and cell in the box from (0, 0, 0) to (1, 2, 3). */
static psplat_tile tile_of(int level, const char *path, double error) {
    psplat_tile tile = {.level = level,
                        .region = {0, 0, 0, 1, 2, 3},
                        .bounds = {0, 0, 0, 1, 2, 3},
                        .error = error,
                        .normal_error = 2.5,
                        .cone = {0, 0, 1, 0.25},
                        .splats = 7,
                        .bytes = 99};
    snprintf(tile.path, sizeof tile.path, "%s", path);
    snprintf(tile.content, sizeof tile.content, "tiles/%d-%s.glb", level, *path ? path : "root");
    return tile;
}

static void parents_are_the_nearest_cells_above(void **state) {
    (void)state;
    psplat_tile tiles[] = {tile_of(2, "011", 1), tile_of(1, "1", 3), tile_of(0, "", 2),
                           tile_of(1, "0", 2),   tile_of(3, "1", 1), tile_of(2, "00", 9)};
    size_t parents[6];
    assert_int_equal(psplat_tileset_arrange(tiles, 6, parents, NULL), PSPLAT_OK);
    const char *const paths[] = {"", "0", "1", "00", "011", "1"};
    const size_t expected[] = {SIZE_MAX, 0, 0, 1, 1, 2};
    for (int i = 0; i < 6; ++i) {
        assert_string_equal(tiles[i].path, paths[i]);
        assert_int_equal(parents[i], expected[i]);
    }
}

static void errors_never_grow_downwards(void **state) {
    (void)state;
    psplat_tile tiles[] = {tile_of(0, "", 2), tile_of(1, "0", 1), tile_of(1, "1", 1.5),
                           tile_of(2, "00", 3)};
    size_t parents[4];
    assert_int_equal(psplat_tileset_arrange(tiles, 4, parents, NULL), PSPLAT_OK);
    assert_true(tiles[0].error == 3 && tiles[1].error == 3);
    assert_true(tiles[2].error == 1.5 && tiles[3].error == 3);
}

static void tiles_without_one_root_are_refused(void **state) {
    (void)state;
    psplat_error error = {0};
    size_t parents[2];
    psplat_tile orphan[] = {tile_of(0, "0", 1), tile_of(1, "1", 1)};
    psplat_tile twice[] = {tile_of(0, "", 1), tile_of(0, "", 1)};
    assert_int_equal(psplat_tileset_arrange(orphan, 0, parents, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_tileset_arrange(orphan, 2, parents, &error), PSPLAT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "level 1 and cell '1'"));
    assert_int_equal(psplat_tileset_arrange(twice, 2, parents, &error), PSPLAT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "two tiles"));
}

/* The files of a tileset, one after another. */
typedef struct files {
    char *text;
    size_t count;
} files;

static psplat_result take(void *user, const char *name, const char *text, size_t size,
                          psplat_error *error) {
    files *f = user;
    char expected[40];
    (void)error;
    if (f->count)
        snprintf(expected, sizeof expected, "tileset-%zu.json", f->count);
    else
        snprintf(expected, sizeof expected, "tileset.json");
    assert_string_equal(name, expected);
    size_t before = f->text ? strlen(f->text) : 0;
    f->text = realloc(f->text, before + size + 2);
    assert_non_null(f->text);
    memcpy(f->text + before, text, size);
    memcpy(f->text + before + size, "\n", 2);
    ++f->count;
    return PSPLAT_OK;
}

static size_t count_of(const char *text, const char *what) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, what)) != NULL; ++at) ++count;
    return count;
}

static void a_file_says_what_a_tile_is(void **state) {
    (void)state;
    psplat_tile tiles[] = {tile_of(0, "", 2), tile_of(1, "1", 1)};
    size_t parents[2];
    files f = {0};
    tiles[1].bounds[3] = 5; /* the box of a parent holds those of its children */
    assert_int_equal(psplat_tileset_arrange(tiles, 2, parents, NULL), PSPLAT_OK);
    assert_int_equal(psplat_tileset_write(tiles, 2, parents, 0, take, &f, NULL), PSPLAT_OK);
    assert_int_equal(f.count, 1);
    assert_string_equal(
        f.text,
        "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":3.7416573867739413,"
        "\"root\":{\"boundingVolume\":{\"box\":[2.5,-1.5,1,2.5,0,0,0,1.5,0,0,0,1]},"
        "\"geometricError\":2,\"refine\":\"REPLACE\",\"content\":{\"uri\":\"tiles/0-root.glb\"},"
        "\"extras\":{\"phongsplat\":{\"region\":[0,-3,0,1,0,2],\"level\":0,\"splats\":7,"
        "\"bytes\":99,\"normalError\":2.5,\"cone\":[0,-1,0,0.25]}},"
        "\"children\":[{\"boundingVolume\":{\"box\":[2.5,-1.5,1,2.5,0,0,0,1.5,0,0,0,1]},"
        "\"geometricError\":1,\"content\":{\"uri\":\"tiles/1-1.glb\"},"
        "\"extras\":{\"phongsplat\":{\"region\":[0,-3,0,1,0,2],\"level\":1,\"splats\":7,"
        "\"bytes\":99,\"normalError\":2.5,\"cone\":[0,-1,0,0.25]}}}]}}\n");
    free(f.text);
}

/* Appends all tiles of a full tree below a path. */
static size_t full_tree(psplat_tile *tiles, size_t count, const char *path, int level, int most) {
    char below[PSPLAT_CELL_PATH];
    tiles[count++] = tile_of(level, path, 10 - level);
    for (int half = 0; half < 2 && level < most; ++half) {
        memset(below, 0, sizeof below);
        memcpy(below, path, (size_t)level);
        below[level] = half ? '1' : '0';
        count = full_tree(tiles, count, below, level + 1, most);
    }
    return count;
}

static void large_tilesets_get_several_files(void **state) {
    (void)state;
    enum { LEVELS = 9, TILES = (1 << LEVELS) - 1, MOST = 40 };
    static psplat_tile tiles[TILES];
    static size_t parents[TILES];
    files f = {0};
    assert_int_equal(full_tree(tiles, 0, "", 0, LEVELS - 1), TILES);
    assert_int_equal(psplat_tileset_arrange(tiles, TILES, parents, NULL), PSPLAT_OK);
    assert_int_equal(psplat_tileset_write(tiles, TILES, parents, MOST, take, &f, NULL), PSPLAT_OK);
    assert_in_range(f.count, TILES / MOST, 3 * TILES / MOST);
    for (size_t i = 0; i < TILES; ++i) {
        char uri[PSPLAT_TILE_CONTENT + 2];
        snprintf(uri, sizeof uri, "\"%s\"", tiles[i].content);
        assert_int_equal(count_of(f.text, uri), 1);
    }
    for (size_t i = 1; i < f.count; ++i) {
        char uri[40];
        snprintf(uri, sizeof uri, "\"tileset-%zu.json\"", i);
        assert_int_equal(count_of(f.text, uri), 1);
    }
    /* No file has more tiles than it may, those that name further files among them. */
    for (char *line = f.text; *line;) {
        char *end = strchr(line, '\n');
        *end = 0;
        assert_in_range(count_of(line, "\"boundingVolume\""), 2, MOST);
        line = end + 1;
    }
    free(f.text);
}

int test_tileset_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parents_are_the_nearest_cells_above),
        cmocka_unit_test(errors_never_grow_downwards),
        cmocka_unit_test(tiles_without_one_root_are_refused),
        cmocka_unit_test(a_file_says_what_a_tile_is),
        cmocka_unit_test(large_tilesets_get_several_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
