/* SPDX-License-Identifier: MIT
 *
 * test_draft.c - tests of drafts of conversions: what is completed from one, in any order, is what
 * a conversion of its own gives, byte by byte.
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
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

static psplat_mesh read_model(const char *name) {
    psplat_mesh mesh;
    psplat_error error;
    char path[512];
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

/* Both become the same file and have the same report. The splats are freed. */
static void assert_same(psplat_splats *a, const psplat_report *a_report, psplat_splats *b,
                        const psplat_report *b_report) {
    uint8_t *data[2];
    size_t size[2];
    assert_int_equal(psplat_glb_write(a, "m", NULL, &data[0], &size[0], NULL), PSPLAT_OK);
    assert_int_equal(psplat_glb_write(b, "m", NULL, &data[1], &size[1], NULL), PSPLAT_OK);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(data[0], data[1], size[0]);
    assert_int_equal(a_report->splats, b_report->splats);
    assert_int_equal(a_report->samples, b_report->samples);
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i) {
        assert_int_equal(a_report->promises[i].broken, b_report->promises[i].broken);
        assert_true(a_report->promises[i].worst == b_report->promises[i].worst);
    }
    for (int i = 0; i < 2; ++i) free(data[i]);
    psplat_splats_free(a);
    psplat_splats_free(b);
}

/* The first precision comes again in the end: what was completed before has left no trace. The
 * painted model has colours, whose mending adds samples and limits to the draft; the cone needs
 * holes filled once splats lie on the grid. */
static void test_same(void **state) {
    (void)state;
    static const double precisions[] = {PSPLAT_USUAL_PRECISION, 0, PSPLAT_USUAL_PRECISION};
    const struct {
        const char *name;
        psplat_convert_desc desc;
    } cases[] = {{"cone.stl", {.tolerance_percent = 0.5, .effort = PSPLAT_EFFORT_NONE}},
                 {"painted.glb",
                  {.tolerance_percent = 8, .effort = PSPLAT_EFFORT_NONE, .bake_textures = 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_mesh mesh = read_model(cases[i].name);
        psplat_draft *draft;
        assert_int_equal(psplat_draft_create(&mesh, &cases[i].desc, &draft, NULL), PSPLAT_OK);
        for (size_t k = 0; k < sizeof precisions / sizeof *precisions; ++k) {
            psplat_convert_desc desc = cases[i].desc;
            psplat_splats drafted, converted;
            psplat_report drafted_report = {0}, converted_report = {0};
            desc.precision = precisions[k];
            assert_int_equal(
                psplat_draft_convert(draft, desc.precision, &drafted, &drafted_report, NULL),
                PSPLAT_OK);
            assert_int_equal(psplat_convert(&mesh, &desc, &converted, &converted_report, NULL),
                             PSPLAT_OK);
            assert_same(&drafted, &drafted_report, &converted, &converted_report);
        }
        psplat_draft_destroy(draft);
        psplat_mesh_free(&mesh);
    }
}

static int stop_at(void *user, const char *stage, double fraction) {
    (void)fraction;
    return !strcmp(stage, user);
}

/* A draft that cannot be made is none; one that was interrupted while it was completed still is. */
static void test_interrupted(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cone.stl");
    char stage[16] = "sampling";
    psplat_convert_desc desc = {.tolerance_percent = 2, .progress = stop_at, .user = stage};
    psplat_draft *draft;
    psplat_splats drafted, converted;
    psplat_report drafted_report = {0}, converted_report = {0};
    psplat_error error;
    assert_int_equal(psplat_draft_create(&mesh, &desc, &draft, &error), PSPLAT_ERROR_INTERRUPTED);
    assert_null(draft);
    snprintf(stage, sizeof stage, "verifying");
    assert_int_equal(psplat_draft_create(&mesh, &desc, &draft, &error), PSPLAT_OK);
    assert_int_equal(psplat_draft_convert(draft, 0, &drafted, &drafted_report, &error),
                     PSPLAT_ERROR_INTERRUPTED);
    assert_int_equal(drafted.count, 0);
    snprintf(stage, sizeof stage, "none");
    assert_int_equal(psplat_draft_convert(draft, 0, &drafted, &drafted_report, &error), PSPLAT_OK);
    assert_int_equal(psplat_convert(&mesh, &desc, &converted, &converted_report, &error),
                     PSPLAT_OK);
    assert_same(&drafted, &drafted_report, &converted, &converted_report);
    psplat_draft_destroy(draft);
    psplat_draft_destroy(NULL);
    psplat_mesh_free(&mesh);
}

int test_draft_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_interrupted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
