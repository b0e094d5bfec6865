/* SPDX-License-Identifier: MIT
 *
 * test_color_promise.c - tests that colours and finishes of textures and of vertices are a promise:
 * conversions keep it, and the check finds where others break it. The square is painted with rings
 * that lie between the samples of a fit.
 */
#include "appearance_fixture.h"

#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "material/source_materials.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

enum { SIZE = 128 };

/* Black rings, 6 texels wide (3.3 tolerances), on white. */
static void rings(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    double across = (double)x - 63.5, down = (double)y - 63.5;
    int ring = fmod(sqrt(across * across + down * down), 32) < 6;
    memset(rgba, ring ? 0 : 255, 3);
    rgba[3] = 255;
}

/* The same, so close that the fit alone shows more than 5 of 100 points wrong. */
static void close_rings(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    double across = (double)x - 63.5, down = (double)y - 63.5;
    int ring = fmod(sqrt(across * across + down * down), 20) < 10;
    memset(rgba, ring ? 0 : 255, 3);
    rgba[3] = 255;
}

static psplat_convert_desc desc_of(double color_tolerance) {
    return (psplat_convert_desc){.tolerance_percent = 1,
                                 .color_tolerance_percent = color_tolerance,
                                 .effort = PSPLAT_EFFORT_NONE,
                                 .bake_textures = 1};
}

static psplat_splats convert(const painted *p, double color_tolerance, psplat_report *report) {
    const psplat_convert_desc desc = desc_of(color_tolerance);
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(&p->mesh, &desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

/* Asserts that a conversion within 5 % keeps its promise, and that the same check finds that one
 * without a bound of colours breaks it. */
static void assert_promised(const painted *p) {
    psplat_report report, loose;
    const psplat_convert_desc desc = desc_of(5);
    psplat_splats splats = convert(p, 5, &report);
    const psplat_kept *kept = &report.promises[PSPLAT_PROMISE_COLOR];
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_near(kept->limit, 5, 1e-12);
    assert_true(kept->worst <= 5);
    assert_true(report.look_beyond_percent <= 5);
    assert_true(report.max_look_percent >= report.p95_look_percent);
    psplat_splats_free(&splats);
    splats = convert(p, 100, &loose);
    assert_true(loose.promises[PSPLAT_PROMISE_COLOR].limit == 0);
    assert_int_equal(psplat_report_broken(&loose), PSPLAT_PROMISE_COUNT);
    assert_true(loose.splats < report.splats);
    psplat_error error;
    if (psplat_convert_verify(&p->mesh, &desc, &splats, &loose, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&loose), PSPLAT_PROMISE_COLOR);
    assert_true(kept->limit == loose.promises[PSPLAT_PROMISE_COLOR].limit);
    assert_true(loose.promises[PSPLAT_PROMISE_COLOR].worst > 5);
    assert_true(loose.look_beyond_percent > 5);
    assert_true(loose.places[0].value > 5);
    psplat_splats_free(&splats);
}

static void test_base_color(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 2, SIZE, rings);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    assert_promised(&p);
    painted_free(&p);
}

/* Splats of wrong colours have to give way, or the promise is broken. */
static void test_mended(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 2, SIZE, close_rings);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    assert_promised(&p);
    painted_free(&p);
}

static void test_emissive(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 2, SIZE, rings);
    for (int k = 0; k < 3; ++k) p.source_material.material.emissive[k] = 1;
    p.source_material.emissive = (psplat_texture_info){.image = &p.image};
    assert_promised(&p);
    painted_free(&p);
}

static void test_roughness(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 2, SIZE, rings);
    p.source_material.metallic_roughness = (psplat_texture_info){.image = &p.image};
    assert_promised(&p);
    painted_free(&p);
}

/* A square of 64 x 64 cells whose vertices are black along the same rings. */
static void test_vertices(void **state) {
    (void)state;
    enum { CELLS = 64 };
    painted p;
    painted_make(&p, CELLS, 4, rings);
    p.mesh.corner_colors = malloc(p.mesh.triangle_count * 12 * sizeof(float));
    assert_non_null(p.mesh.corner_colors);
    for (size_t c = 0; c < 3 * p.mesh.triangle_count; ++c) {
        size_t vertex = p.mesh.triangles[c];
        uint8_t rgba[4];
        rings((uint32_t)(2 * (vertex % (CELLS + 1))), (uint32_t)(2 * (vertex / (CELLS + 1))), rgba);
        for (size_t k = 0; k < 4; ++k) p.mesh.corner_colors[4 * c + k] = (float)rgba[k] / 255;
    }
    assert_promised(&p);
    painted_free(&p);
}

int test_color_promise_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_base_color), cmocka_unit_test(test_mended),
        cmocka_unit_test(test_emissive),   cmocka_unit_test(test_roughness),
        cmocka_unit_test(test_vertices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
