/* SPDX-License-Identifier: MIT
 *
 * test_budget.c - tests of searching the smallest tolerance that fits a budget of splats or bytes:
 * the result is within the budget, close to it, and its error decreases as the budget grows. The
 * models are a sphere and a cube.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/budget.h"
#include "pipeline/convert.h"
#include "pipeline/schedule.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

static psplat_mesh read_model(const char *name) {
    psplat_mesh mesh;
    psplat_error error = {0};
    char path[512];
    snprintf(path, sizeof path, "%s/samples/models/%s", PSPLAT_SOURCE_DIR, name);
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

/* Searches the tolerance for the splats of one mesh. */
static psplat_result convert_budget(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_budget *budget, psplat_splats *splats,
                                    psplat_report *report, size_t *needed, psplat_error *error) {
    char name[] = "model";
    uint32_t root = 0;
    psplat_scene_mesh only = {.mesh = *mesh, .name = name};
    psplat_scene_view view = {.roots = &root, .root_count = 1};
    psplat_scene_node node = {.name = name,
                              .rotation = {0, 0, 0, 1},
                              .scale = {1, 1, 1},
                              .camera = PSPLAT_NO_INDEX,
                              .light = PSPLAT_NO_INDEX};
    const psplat_scene scene = {.meshes = &only,
                                .mesh_count = 1,
                                .nodes = &node,
                                .node_count = 1,
                                .scenes = &view,
                                .scene_count = 1,
                                .is_made = 1};
    psplat_scene_report all = {0};
    *splats = (psplat_splats){0};
    psplat_result result = psplat_scene_convert_budget(&scene, desc, budget, splats,
                                                       report ? &all : NULL, needed, error);
    if (report) *report = all.total;
    psplat_scene_report_free(&all);
    return result;
}

static psplat_report search(const psplat_mesh *mesh, psplat_budget budget, psplat_splats *splats) {
    psplat_report report = {0};
    psplat_error error = {0};
    size_t needed = 99;
    /* Of planar splats it is known how many an error takes, and the search is the same for all. */
    const psplat_convert_desc quick = {.effort = PSPLAT_EFFORT_NONE, .planar = 1};
    if (convert_budget(mesh, &quick, &budget, splats, &report, &needed, &error))
        fail_msg("%s", error.text);
    assert_int_equal(needed, 0);
    assert_int_equal(report.splats, splats->count);
    assert_true(report.samples > 0);
    return report;
}

static size_t glb_size(const psplat_splats *splats) {
    uint8_t *data;
    size_t size;
    assert_int_equal(psplat_glb_write(splats, "model", NULL, &data, &size, NULL), PSPLAT_OK);
    free(data);
    return size;
}

static void test_splats(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("sphere.ply");
    const size_t budgets[] = {38, 76};
    double coarser = 100;
    for (size_t i = 0; i < 2; ++i) {
        psplat_splats splats;
        psplat_report r = search(&mesh, (psplat_budget){.splats = budgets[i]}, &splats);
        assert_in_range(splats.count, (budgets[i] * 85 + 99) / 100, budgets[i]);
        /* Twice as many splats give about half of the error, at most three quarters. */
        assert_true(r.tolerance_percent < 0.75 * coarser);
        assert_int_equal(psplat_report_broken(&r), PSPLAT_PROMISE_COUNT);
        assert_true(r.max_distance_percent <= r.tolerance_percent * (1 + 1e-6));
        coarser = r.tolerance_percent;

        if (i == 0) {
            psplat_splats_free(&splats);
            continue;
        }
        /* A conversion with the tolerance found gives the same splats and report. */
        psplat_convert_desc desc = {
            .tolerance_percent = r.tolerance_percent, .effort = PSPLAT_EFFORT_NONE, .planar = 1};
        psplat_splats same;
        psplat_report again = {0};
        assert_int_equal(psplat_convert(&mesh, &desc, &same, &again, NULL), PSPLAT_OK);
        assert_int_equal(same.count, splats.count);
        assert_memory_equal(same.splats, splats.splats, splats.count * sizeof *splats.splats);
        assert_memory_equal(&again, &r, sizeof r);
        psplat_splats_free(&same);
        psplat_splats_free(&splats);
    }
    psplat_mesh_free(&mesh);
}

static void test_bytes(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("sphere.ply");
    psplat_splats splats;
    /* The tighter of two budgets counts. */
    psplat_report r = search(&mesh, (psplat_budget){.splats = 100000, .bytes = 6000}, &splats);
    assert_in_range(glb_size(&splats), 6000 * 85 / 100, 6000);
    assert_int_equal(psplat_report_broken(&r), PSPLAT_PROMISE_COUNT);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* Six faces need six splats at any tolerance: the search must end nevertheless. */
static void test_flat(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    psplat_splats splats;
    psplat_report r = search(&mesh, (psplat_budget){.splats = 1000}, &splats);
    assert_int_equal(splats.count, 6);
    assert_true(r.tolerance_percent >= 0.01);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

static void refuse(const psplat_mesh *mesh, double coarsest, psplat_budget budget,
                   const char *unit) {
    psplat_convert_desc desc = {.tolerance_percent = coarsest};
    psplat_splats splats;
    psplat_report report = {0};
    psplat_error error = {0};
    size_t needed = 0, bound = budget.splats ? budget.splats : budget.bytes;
    assert_int_equal(convert_budget(mesh, &desc, &budget, &splats, &report, &needed, &error),
                     PSPLAT_ERROR_RANGE);
    assert_true(needed > bound);
    if (!strstr(error.text, unit)) fail_msg("no '%s' in: %s", unit, error.text);
    assert_null(splats.splats);
}

static void test_impossible(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    refuse(&mesh, 0, (psplat_budget){.splats = 5}, "takes 6 splats, more than the budget of 5");
    refuse(&mesh, 0, (psplat_budget){.bytes = 100}, "bytes, more than the budget of 100");
    psplat_mesh_free(&mesh);
    /* The budget fits at coarser tolerances than the coarsest allowed one. */
    mesh = read_model("sphere.ply");
    refuse(&mesh, 0.5, (psplat_budget){.splats = 5}, "a tolerance of 0.5 % takes");
    psplat_mesh_free(&mesh);
}

static void test_arguments(void **state) {
    (void)state;
    psplat_mesh mesh = {0};
    psplat_splats splats;
    psplat_budget none = {0};
    size_t needed;
    assert_int_equal(convert_budget(&mesh, NULL, &none, &splats, NULL, &needed, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(convert_budget(&mesh, NULL, NULL, &splats, NULL, &needed, NULL),
                     PSPLAT_ERROR_ARGUMENT);
}

/* The values that the progress callback received. */
typedef struct progress_log {
    double last;
    int calls, stop_at;
} progress_log;

static int note(void *user, const char *stage, double fraction) {
    progress_log *l = user;
    if (strcmp(stage, "searching") != 0) return 0; /* the verification of the result */
    assert_true(fraction >= l->last && fraction <= 1);
    l->last = fraction;
    return ++l->calls == l->stop_at;
}

static void test_progress(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    for (int stop = 0; stop < 2; ++stop) {
        progress_log l = {.stop_at = stop ? 5 : 0};
        psplat_convert_desc desc = {.progress = note, .user = &l};
        psplat_budget budget = {.splats = 6};
        psplat_splats splats;
        size_t needed;
        assert_int_equal(convert_budget(&mesh, &desc, &budget, &splats, NULL, &needed, NULL),
                         stop ? PSPLAT_ERROR_INTERRUPTED : PSPLAT_OK);
        if (stop)
            assert_int_equal(l.calls, 5);
        else
            assert_true(l.last > 0.1);
        psplat_splats_free(&splats);
    }
    psplat_mesh_free(&mesh);
}

/* The shares of the stages follow each other and end with 1. */
static void test_schedule(void **state) {
    (void)state;
    const char *const stages[] = {"reading",          "finding creases", "sampling",
                                  "selecting splats", "improving",       "closing holes",
                                  "closing gaps",     "trimming",        "finishing",
                                  "verifying",        "writing"};
    double before = 0;
    for (size_t i = 0; i < sizeof stages / sizeof *stages; ++i) {
        assert_true(psplat_schedule_done(stages[i], 0) == before);
        assert_true(psplat_schedule_done(stages[i], 0.5) > before);
        before = psplat_schedule_done(stages[i], 1);
        assert_true(psplat_schedule_done(stages[i], 7) == before);
        assert_true(psplat_schedule_done(stages[i], -1) <= psplat_schedule_done(stages[i], 0.1));
    }
    assert_true(before > 0.999 && before < 1.001);
    assert_true(psplat_schedule_done("tea", 0.5) < 0);
}

int test_budget_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_splats),    cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_flat),      cmocka_unit_test(test_impossible),
        cmocka_unit_test(test_arguments), cmocka_unit_test(test_progress),
        cmocka_unit_test(test_schedule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
