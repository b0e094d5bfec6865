/* SPDX-License-Identifier: MIT
 *
 * test_levels.c - tests levels of detail (spec 3.13): the bundled levels.gltf, whose finest level
 * is what readers see that know no levels, and lists that are refused with place and cause.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

#define SECOND                                                                                     \
    "{ \"mesh\": 1, \"distance\": 0.25, \"normal\": 4, \"outline\": 0.125, \"scale\": 2 }"

static char *bundled(void) {
    size_t size;
    return document_read(PSPLAT_SOURCE_DIR "/schema/levels.gltf", &size);
}

static psplat_asset *open_text(const char *text) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    return asset;
}

static void check_level(const psplat_asset *asset, size_t index, const psplat_level *expected) {
    const psplat_level *level = psplat_asset_get_level(asset, index);
    assert_true(level->distance == expected->distance);
    assert_true(level->normal == expected->normal);
    assert_true(level->outline == expected->outline);
    assert_int_equal(level->splat_count, expected->splat_count);
}

static void test_levels_of_file(void **state) {
    (void)state;
    char *text = bundled();
    psplat_asset *asset = open_text(text);
    assert_int_equal(psplat_asset_level_count(asset), 3);
    check_level(asset, 0, &(psplat_level){0.05, 1.5, 0.02, 4});
    check_level(asset, 1, &(psplat_level){0.25, 4, 0.125, 2});
    check_level(asset, 2, &(psplat_level){1, 12, 0.5, 1});
    assert_null(psplat_asset_get_level(asset, 3));
    assert_int_equal(psplat_asset_batch_count(asset), 1);
    assert_int_equal(psplat_asset_all_batch_count(asset), 3);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_int_equal(psplat_asset_batch(asset, i)->level, i);
        assert_int_equal(psplat_asset_batch(asset, i)->last_level, i);
    }
    assert_null(psplat_asset_batch(asset, 3));
    psplat_asset_destroy(asset);
    free(text);
}

/* The bounds are those of the finest level, and the coarser ones lie where their place says: their
 * only splat's centre, 0.5 0.25 0, is at 4 (0.5, 0.25, 0) - (2, 1, 0) of the mesh, and the node
 * doubles and moves that. */
static void test_places(void **state) {
    (void)state;
    char *text = bundled();
    document_replace(&text, "\"mesh\": 0 }",
                     "\"mesh\": 0, \"scale\": [2, 2, -2], "
                     "\"translation\": [10, 20, 30] }");
    psplat_asset *asset = open_text(text);
    const psplat_batch *batch = psplat_asset_batch(asset, 2);
    const double expected[16] = {8, 0, 0, 0, 0, 8, 0, 0, 0, 0, -8, 0, 6, 18, 30, 1};
    for (int i = 0; i < 16; ++i) assert_true(batch->model[i] == expected[i]);
    check_level(asset, 2, &(psplat_level){2, 12, 1, 1});
    double min[3], max[3];
    psplat_asset_bounds(asset, min, max);
    assert_true(min[0] == 6 && max[0] == 14 && min[1] == 17 && max[1] == 23);
    psplat_asset_destroy(asset);
    free(text);
}

/* A mesh without levels, or with fewer, is drawn at all levels of the others. */
static void test_fewer_levels(void **state) {
    (void)state;
    char *text = bundled();
    document_replace(&text, "\"nodes\": [0]", "\"nodes\": [0, 1]");
    document_replace(&text, "\"mesh\": 0 }",
                     "\"mesh\": 0 }, { \"mesh\": 1, \"scale\": [3, 3, 3] }");
    psplat_asset *asset = open_text(text);
    assert_int_equal(psplat_asset_batch_count(asset), 2);
    assert_int_equal(psplat_asset_all_batch_count(asset), 4);
    assert_int_equal(psplat_asset_batch(asset, 1)->level, 0);
    assert_int_equal(psplat_asset_batch(asset, 1)->last_level, 2);
    check_level(asset, 2, &(psplat_level){1, 12, 0.5, 3});
    psplat_asset_destroy(asset);
    free(text);
}

/* A mesh that ends before others is drawn at its last level beside all coarser ones, with its
 * errors and its splats. */
static void test_ended_levels(void **state) {
    (void)state;
    char *text = bundled();
    document_replace(&text, "\"nodes\": [0]", "\"nodes\": [0, 1]");
    document_replace(&text, "\"mesh\": 0 }", "\"mesh\": 0 }, { \"mesh\": 1 }");
    document_replace(
        &text, "\"meshes\": [",
        "\"meshes\": [{ \"primitives\": [{ \"mode\": 0, \"attributes\": { \"POSITION\": 0, "
        "\"NORMAL\": 1, \"_PSPLAT_surface_splats:ROTATION\": 2, "
        "\"_PSPLAT_surface_splats:SCALE\": 3 }, \"material\": 0, \"extensions\": { "
        "\"PSPLAT_surface_splats\": { \"version\": 1, \"clipLines\": 0, "
        "\"depthTolerance\": 0.01, \"positionExtent\": [2, 2, 0], \"levels\": [ { "
        "\"distance\": 0.01, \"normal\": 1, \"outline\": 0.01 }, { \"mesh\": 2, \"distance\": "
        "0.5, \"normal\": 20, \"outline\": 0.75, \"scale\": 2 } ] } } }] },");
    document_replace(&text, "\"mesh\": 2, \"distance\": 1", "\"mesh\": 3, \"distance\": 1");
    document_replace(&text, "\"mesh\": 1, \"distance\"", "\"mesh\": 2, \"distance\"");
    psplat_asset *asset = open_text(text);
    check_level(asset, 0, &(psplat_level){0.05, 1.5, 0.02, 8});
    check_level(asset, 1, &(psplat_level){0.5, 20, 0.75, 4});
    check_level(asset, 2, &(psplat_level){1, 20, 0.75, 3});
    assert_int_equal(psplat_asset_batch_count(asset), 2);
    assert_int_equal(psplat_asset_all_batch_count(asset), 5);
    psplat_asset_destroy(asset);
    free(text);
}

/* What stands in for splats with levels has them too. */
static void test_stand_in(void **state) {
    (void)state;
    char *text = bundled();
    document_replace(&text, "\"meshes\": [",
                     "\"meshes\": [{ \"primitives\": [{ \"mode\": 0, \"attributes\": { "
                     "\"POSITION\": 0 } }], \"extensions\": { \"PSPLAT_surface_splats\": { "
                     "\"mesh\": 1 } } },");
    document_replace(&text, "\"mesh\": 2, \"distance\"", "\"mesh\": 3, \"distance\"");
    document_replace(&text, "\"mesh\": 1, \"distance\"", "\"mesh\": 2, \"distance\"");
    psplat_asset *asset = open_text(text);
    assert_int_equal(psplat_asset_level_count(asset), 3);
    check_level(asset, 2, &(psplat_level){1, 12, 0.5, 1});
    psplat_asset_destroy(asset);
    free(text);
}

static void test_without_levels(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    psplat_asset *asset = open_text(text);
    assert_int_equal(psplat_asset_level_count(asset), 1);
    check_level(asset, 0, &(psplat_level){0, 0, 0, 4});
    assert_int_equal(psplat_asset_all_batch_count(asset), psplat_asset_batch_count(asset));
    assert_int_equal(psplat_asset_batch(asset, 0)->last_level, 0);
    psplat_asset_destroy(asset);
    free(text);
    assert_int_equal(psplat_asset_level_count(NULL), 0);
    assert_int_equal(psplat_asset_all_batch_count(NULL), 0);
    assert_null(psplat_asset_get_level(NULL, 0));
}

/* Replaces from by to and checks that the reader refuses that at a place, with a cause. */
static void check_refused(const char *from, const char *to, psplat_result code, const char *at,
                          const char *cause) {
    char *text = bundled();
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    document_replace(&text, from, to);
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != code || error.offset != document_find(text, at) || !strstr(error.text, cause))
        fail_msg("%s: %s (byte %zu, expected %zu)", psplat_result_text(result), error.text,
                 error.offset, document_find(text, at));
    assert_null(asset);
    free(text);
}

static void test_refused_meshes(void **state) {
    (void)state;
    check_refused(SECOND, "{ \"distance\": 0.25, \"normal\": 4, \"outline\": 1 }",
                  PSPLAT_ERROR_FORMAT, "{ \"distance\": 0.25", "mesh is missing");
    check_refused("\"mesh\": 1, \"dist", "\"mesh\": 3, \"dist", PSPLAT_ERROR_RANGE, "3, \"dist",
                  "mesh");
    /* Cycles: a mesh that is a level of itself, or of one that is a level of it. */
    check_refused("\"mesh\": 1, \"dist", "\"mesh\": 0, \"dist", PSPLAT_ERROR_FORMAT, "0, \"dist",
                  "levels of its own");
    check_refused("\"positionExtent\": [1, 0, 0]",
                  "\"positionExtent\": [1, 0, 0], \"levels\": [{ \"distance\": 1, \"normal\": 0, "
                  "\"outline\": 0 }, { \"mesh\": 0, \"distance\": 1, \"normal\": 0, "
                  "\"outline\": 0 }]",
                  PSPLAT_ERROR_FORMAT, "1, \"distance\"", "levels of its own");
    /* The same mesh twice has no fewer splats, as has one that is finer than the level before. */
    check_refused("\"mesh\": 2, \"dist", "\"mesh\": 1, \"dist", PSPLAT_ERROR_FORMAT,
                  "1, \"distance\": 1", "no fewer splats");
    check_refused("{ \"distance\": 0.05", "{ \"mesh\": 0, \"distance\": 0.05", PSPLAT_ERROR_FORMAT,
                  "0, \"distance\": 0.05", "names none");
}

/* A level has to have splats of its own. */
static void test_refused_kinds(void **state) {
    (void)state;
    check_refused("\"meshes\": [",
                  "\"meshes\": [{ \"primitives\": [{ \"mode\": 0, \"attributes\": {} }] },",
                  PSPLAT_ERROR_FORMAT, "1, \"dist", "levels of its own");
    check_refused("\"mesh\": 2, \"dist", "\"mesh\": \"2\", \"dist", PSPLAT_ERROR_FORMAT,
                  "\"2\", \"dist", "mesh");
    check_refused("\"levels\": [", "\"levels\": 1, \"other\": [", PSPLAT_ERROR_FORMAT,
                  "1, \"other\"", "levels");
    check_refused("\"levels\": [", "\"levels\": [], \"other\": [", PSPLAT_ERROR_FORMAT,
                  "[], \"other\"", "empty");
    check_refused(SECOND, "7", PSPLAT_ERROR_FORMAT, "7,\n", "");
}

static void test_refused_stand_in(void **state) {
    (void)state;
    char *text = bundled();
    document_replace(&text, "\"meshes\": [", "\"other\": 1, \"meshes\": [");
    document_replace(&text, "\"other\": 1, \"meshes\": [",
                     "\"meshes\": [{ \"primitives\": [{ \"mode\": 0, \"attributes\": {} }], "
                     "\"extensions\": { \"PSPLAT_surface_splats\": { \"mesh\": 3 } } },");
    document_replace(&text, "\"mesh\": 1, \"distance\"", "\"mesh\": 0, \"distance\"");
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "without splats of its own"));
    assert_int_equal(error.offset, document_find(text, "0, \"distance\""));
    free(text);
}

static void test_refused_errors(void **state) {
    (void)state;
    check_refused("\"distance\": 0.25, ", "", PSPLAT_ERROR_FORMAT, "{ \"mesh\": 1, \"normal\"",
                  "distance is missing");
    check_refused("\"normal\": 4, ", "", PSPLAT_ERROR_FORMAT, "{ \"mesh\": 1, \"dist",
                  "normal is missing");
    check_refused("\"outline\": 0.125, ", "", PSPLAT_ERROR_FORMAT, "{ \"mesh\": 1, \"dist",
                  "outline is missing");
    check_refused("\"distance\": 0.05", "\"distance\": -1", PSPLAT_ERROR_RANGE, "-1, \"norm",
                  "distance must be");
    check_refused("\"normal\": 12", "\"normal\": 181", PSPLAT_ERROR_RANGE, "181, \"out",
                  "normal must be");
    /* No error falls from level to level. */
    check_refused("\"distance\": 1,", "\"distance\": 0.2,", PSPLAT_ERROR_RANGE, "0.2, \"norm",
                  "distance must be 0.25");
    check_refused("\"normal\": 12", "\"normal\": 3.9", PSPLAT_ERROR_RANGE, "3.9, \"out",
                  "normal must be 4");
    check_refused("\"outline\": 0.5", "\"outline\": 0.1", PSPLAT_ERROR_RANGE, "0.1, \"scale\": 4",
                  "outline must be 0.125");
}

static void test_refused_places(void **state) {
    (void)state;
    check_refused("\"scale\": 2", "\"scale\": 0", PSPLAT_ERROR_RANGE, "0 },", "scale");
    check_refused("\"scale\": 2", "\"scale\": -2", PSPLAT_ERROR_RANGE, "-2 },", "scale");
    check_refused("[-2, -1, 0]", "[-2, -1]", PSPLAT_ERROR_RANGE, "[-2, -1]", "translation");
    check_refused("\"outline\": 0.02 ", "\"outline\": 0.02, \"scale\": 2 ", PSPLAT_ERROR_FORMAT,
                  "{ \"distance\": 0.05", "no place of its own");
    /* Beyond what a double can hold. */
    check_refused("\"mesh\": 0 }", "\"mesh\": 0, \"scale\": [1e308, 1, 1] }", PSPLAT_ERROR_RANGE,
                  "{ \"name\": \"levels\"", "transform");
}

/* Levels are those of a mesh, which its first primitive of splats states. */
static void test_refused_second_primitive(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    document_replace(&text, "\"clipLines\": 1,", "\"levels\": [], \"clipLines\": 1,");
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "first primitive"));
    assert_int_equal(error.offset, document_find(text, "[], \"clipLines\""));
    free(text);
}

/* Where memory runs out, the reader says so and loses nothing. */
typedef struct short_memory {
    int left;
    size_t held;
} short_memory;

static void *resize_short(void *user, void *memory, size_t old_size, size_t new_size) {
    short_memory *m = user;
    if (new_size && !m->left--) return ++m->left, NULL;
    m->held += new_size - old_size;
    void *out = new_size ? realloc(memory, new_size) : NULL;
    if (!new_size) free(memory);
    return out;
}

static void test_memory(void **state) {
    (void)state;
    char *text = bundled();
    psplat_result result = PSPLAT_ERROR_MEMORY;
    for (int left = 0; result; ++left) {
        short_memory m = {.left = left};
        psplat_asset *asset = NULL;
        const psplat_asset_desc desc = {.allocator = {resize_short, &m}};
        result = psplat_asset_open_memory(text, strlen(text), &desc, &asset, NULL);
        assert_true(result == PSPLAT_OK || result == PSPLAT_ERROR_MEMORY);
        psplat_asset_destroy(asset);
        assert_int_equal(m.held, 0);
    }
    free(text);
}

int test_levels_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_levels_of_file),
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_fewer_levels),
        cmocka_unit_test(test_ended_levels),
        cmocka_unit_test(test_stand_in),
        cmocka_unit_test(test_without_levels),
        cmocka_unit_test(test_refused_meshes),
        cmocka_unit_test(test_refused_kinds),
        cmocka_unit_test(test_refused_stand_in),
        cmocka_unit_test(test_refused_errors),
        cmocka_unit_test(test_refused_places),
        cmocka_unit_test(test_memory),
        cmocka_unit_test(test_refused_second_primitive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
