/* SPDX-License-Identifier: MIT
 *
 * test_scene_levels.c - tests levels of detail of a scene from the conversion to the file and back:
 * a torus, coarser and coarser, and a cube beside it, which has six splats whatever the tolerance.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "import/read_scene.h"
#include "pipeline/convert_scene.h"
#include "pipeline/levels.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A conversion and its levels. */
typedef struct made {
    psplat_scene scene;
    psplat_splats splats[2];
    psplat_scene_report report;
    psplat_mesh_levels *levels;
} made;

static const psplat_convert_desc coarse = {
    .tolerance_percent = 0.6, .effort = PSPLAT_EFFORT_NONE, .precision = PSPLAT_USUAL_PRECISION};

static void make(made *m, const char *model, const psplat_levels_desc *wanted) {
    psplat_error error = {0};
    char path[512];
    *m = (made){.levels = NULL};
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", model);
    if (psplat_scene_read(path, "model", &m->scene, &error)) fail_msg("%s", error.text);
    assert_int_equal(m->scene.mesh_count, 1);
    if (psplat_scene_convert(&m->scene, &coarse, m->splats, &m->report, &error) ||
        psplat_scene_levels(&m->scene, &coarse, wanted, m->splats, &m->report, &m->levels, &error))
        fail_msg("%s", error.text);
}

static void unmake(made *m) {
    psplat_mesh_levels_free(&m->scene, m->levels);
    psplat_scene_splats_free(&m->scene, m->splats);
    psplat_scene_report_free(&m->report);
    psplat_scene_free(&m->scene);
}

/* The torus is converted once for several tests. */
static int make_torus(void **state) {
    static made m;
    make(&m, "torus.off", &(psplat_levels_desc){.most = 3});
    *state = &m;
    return 0;
}

static int unmake_torus(void **state) {
    unmake(*state);
    return 0;
}

/* Tolerances double, splats become fewer by a fifth and more, and errors no smaller; each distance
 * is at least what was found and no less than the tolerance, in units of the mesh. */
static void test_ladder(void **state) {
    const made *m = *state;
    const psplat_mesh_levels *levels = &m->levels[0];
    assert_int_equal(levels->count, 3);
    size_t before = m->splats[0].count;
    for (size_t i = 0; i < levels->count; ++i) {
        const psplat_mesh_level_splats *level = &levels->list[i];
        double unit = m->report.meshes[0].diagonal / 100;
        assert_true(level->distance >= level->tolerance * unit);
        assert_true(level->normal > 0 && level->outline > 0);
        assert_true(level->outline < level->distance);
        if (!i) continue;
        const psplat_mesh_level_splats *finer = level - 1;
        assert_true(level->tolerance >= 2 * finer->tolerance * (1 - 1e-9));
        assert_true(level->distance >= finer->distance && level->normal >= finer->normal &&
                    level->outline >= finer->outline);
        assert_true((double)level->splats.count <= 0.8 * (double)before);
        before = level->splats.count;
    }
}

/* One tolerance makes one coarser level, however many splats are left, and none that pays is none.
 */
static void test_given_tolerances(void **state) {
    const made *m = *state;
    const psplat_levels_desc far_off = {.most = 3, .tolerances = {9}}, near = {.most = 3, {0.61}};
    psplat_mesh_levels *levels;
    psplat_error error = {0};
    assert_int_equal(
        psplat_scene_levels(&m->scene, &coarse, &far_off, m->splats, &m->report, &levels, &error),
        PSPLAT_OK);
    assert_int_equal(levels[0].count, 2);
    assert_true(levels[0].list[1].tolerance == 9);
    psplat_mesh_levels_free(&m->scene, levels);
    assert_int_equal(
        psplat_scene_levels(&m->scene, &coarse, &near, m->splats, &m->report, &levels, &error),
        PSPLAT_OK);
    assert_int_equal(levels[0].count, 1);
    psplat_mesh_levels_free(&m->scene, levels);
}

/* Six faces take six splats at any tolerance: there is nothing to gain. */
static void test_nothing_to_gain(void **state) {
    (void)state;
    made m;
    make(&m, "cube.off", &(psplat_levels_desc){.most = 8});
    assert_int_equal(m.levels[0].count, 1);
    unmake(&m);
}

static psplat_asset *write_and_open(const made *m, const psplat_codec *codec,
                                    const psplat_mesh_levels *levels, uint8_t **data,
                                    size_t *size) {
    const psplat_write_desc desc = {.codec = codec, .levels = levels};
    psplat_error error = {0};
    psplat_asset *asset = NULL;
    if (psplat_scene_write(&m->scene, m->splats, &desc, data, size, &error) ||
        psplat_asset_open_memory(*data, *size, NULL, &asset, &error))
        fail_msg("%s", error.text);
    return asset;
}

/* Errors are rounded up to four digits; the products of matrices add 1e-12. */
static int is_rounded_up(double read, double made) {
    return read >= made * (1 - 1e-9) && read <= made * (1 + 1e-3);
}

/* What is read back are the errors and the splats, where they were. A level's bounds are those of a
 * file of it alone, but for rounding of the products of its place and the node's. */
static void check_round_trip(const made *m, const psplat_codec *codec) {
    uint8_t *data;
    size_t size;
    psplat_asset *asset = write_and_open(m, codec, m->levels, &data, &size);
    assert_int_equal(psplat_asset_level_count(asset), m->levels[0].count);
    for (uint32_t i = 0; i < m->levels[0].count; ++i) {
        const psplat_mesh_level_splats *level = &m->levels[0].list[i];
        const psplat_level *read = psplat_asset_get_level(asset, i);
        assert_true(is_rounded_up(read->distance, level->distance));
        assert_true(is_rounded_up(read->normal, level->normal));
        assert_true(is_rounded_up(read->outline, level->outline));
        assert_int_equal(read->splat_count, i ? level->splats.count : m->splats[0].count);
    }
    for (uint32_t i = 1; i < m->levels[0].count; ++i) {
        made alone = *m;
        uint8_t *other;
        size_t other_size;
        double low[3], high[3], min[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
        alone.splats[0] = m->levels[0].list[i].splats;
        psplat_asset *single = write_and_open(&alone, codec, NULL, &other, &other_size);
        psplat_asset_bounds(single, low, high);
        for (size_t b = 0; b < psplat_asset_all_batch_count(asset); ++b) {
            const psplat_batch *batch = psplat_asset_batch(asset, b);
            for (int k = 0; k < 3 && batch->level == i; ++k)
                min[k] = fmin(min[k], batch->model[12 + k] +
                                          batch->model[5 * k] * (double)batch->bounds_min[k]);
        }
        for (int k = 0; k < 3; ++k) assert_float_equal(min[k], low[k], 1e-9);
        psplat_asset_destroy(single);
        free(other);
    }
    psplat_asset_destroy(asset);
    free(data);
}

static void test_round_trip(void **state) {
    check_round_trip(*state, NULL);
    check_round_trip(*state, &psplat_meshopt_codec);
}

/* Without levels, or with the finest alone, the file is what it was. */
static void test_unchanged(void **state) {
    (void)state;
    made m;
    uint8_t *plain, *single;
    size_t plain_size, single_size;
    make(&m, "cube.off", &(psplat_levels_desc){.most = 2});
    psplat_asset_destroy(write_and_open(&m, &psplat_meshopt_codec, NULL, &plain, &plain_size));
    psplat_asset_destroy(
        write_and_open(&m, &psplat_meshopt_codec, m.levels, &single, &single_size));
    assert_int_equal(plain_size, single_size);
    assert_memory_equal(plain, single, plain_size);
    free(plain);
    free(single);
    unmake(&m);
}

static void test_refused(void **state) {
    (void)state;
    made m;
    psplat_mesh_levels *levels = NULL;
    psplat_error error = {0};
    make(&m, "cube.off", &(psplat_levels_desc){.most = 2});
    assert_int_equal(psplat_scene_levels(&m.scene, &coarse, &(psplat_levels_desc){.most = 1},
                                         m.splats, &m.report, &levels, &error),
                     PSPLAT_ERROR_ARGUMENT);
    assert_null(levels);
    unmake(&m);
}

int test_scene_levels_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ladder),          cmocka_unit_test(test_given_tolerances),
        cmocka_unit_test(test_nothing_to_gain), cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_unchanged),       cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, make_torus, unmake_torus);
}
