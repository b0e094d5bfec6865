/* SPDX-License-Identifier: MIT
 *
 * test_seam_conversion.c - tests of conversions whose texture has a border of charts on a smooth
 * surface: the promises are kept, there are seams, and normals blend across the border. The shape
 * is a square with waves, whose texture coordinates jump along x = 0.
 */
#include "appearance_fixture.h"

#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "material/source_materials.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

enum { SIZE = 64, CELLS = 32 };

static void gray(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    memset(rgba, (x / 8 + y / 8) % 2 ? 200 : 100, 3);
    rgba[3] = 255;
}

static double height_at(double x, double y) {
    return 0.12 * cos(4 * x + 1) * cos(4 * y);
}

static void normal_at(double x, double y, double n[3]) {
    n[0] = 4 * 0.12 * sin(4 * x + 1) * cos(4 * y);
    n[1] = 4 * 0.12 * cos(4 * x + 1) * sin(4 * y);
    n[2] = 1;
    normalize3(n);
}

static void make(painted *p, psplat_source_materials *materials) {
    painted_make(p, CELLS, SIZE, gray);
    for (size_t i = 0; i < p->mesh.vertex_count; ++i) {
        double *at = p->mesh.positions + 3 * i;
        at[2] = height_at(at[0], at[1]);
    }
    for (size_t i = 0; i < 3 * p->mesh.triangle_count; ++i)
        if (i / 6 % CELLS >= CELLS / 2) p->mesh.corner_uvs[0][2 * i + 1] += 0.25f;
    p->source_material.base_color =
        (psplat_texture_info){.image = &p->image, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    *materials = (psplat_source_materials){.source_materials = &p->source_material,
                                           .source_material_count = 1,
                                           .images = &p->image,
                                           .image_count = 1};
    psplat_source_materials_describe_textures(materials);
}

/* Stores the unit normal to which all splats blend at a point of the surface. Returns 0 where
 * nothing is seen. */
static int blended_normal(const psplat_measured_splats *measured, double reach, double x, double y,
                          double normal[3]) {
    psplat_point_blend blend = {
        .measured = measured, .point = {x, y, height_at(x, y)}, .reach = reach, .limit = -HUGE_VAL};
    normal_at(x, y, blend.normal);
    for (uint32_t i = 0; i < measured->count; ++i) psplat_point_blend_limit(&blend, i);
    for (uint32_t i = 0; i < measured->count; ++i) psplat_point_blend_add(&blend, i);
    memcpy(normal, blend.blended, sizeof blend.blended);
    if (!(length3(normal) > 0)) return 0;
    normalize3(normal);
    return 1;
}

/* Returns by how much the error of the blended normal at most changes between neighbouring points
 * of a short way across the border; -1 where nothing is seen. Splats reach over the border by 0.4
 * tolerances, so that those which end there do so within a tolerance of it. */
static double greatest_jump(const psplat_measured_splats *measured, double tolerance, double y) {
    enum { STEPS = 40 };
    double last[3], greatest = 0;
    for (int i = 0; i <= STEPS; ++i) {
        double error[3], n[3], x = tolerance * (2.0 * i / STEPS - 1);
        if (!blended_normal(measured, tolerance, x, y, error)) return -1;
        normal_at(x, y, n);
        sub3(error, error, n);
        if (i) greatest = fmax(greatest, sqrt(distance2_3(error, last)));
        memcpy(last, error, sizeof last);
    }
    return greatest;
}

/* Returns the mean of these jumps all along the border. */
static double mean_jump(const psplat_splats *splats, double tolerance) {
    enum { WAYS = 150 };
    psplat_measured_splats measured;
    double sum = 0;
    size_t seen = 0;
    assert_int_equal(psplat_measured_splats_create(splats, tolerance, tolerance, &measured),
                     PSPLAT_OK);
    for (int i = 0; i < WAYS; ++i) {
        double jump = greatest_jump(&measured, tolerance, -0.95 + 1.9 * i / (WAYS - 1));
        sum += fmax(jump, 0);
        seen += jump >= 0;
    }
    psplat_measured_splats_free(&measured);
    assert_true(seen > WAYS * 9 / 10);
    return sum / (double)seen;
}

static size_t count_with_seams(const psplat_splats *splats) {
    size_t count = 0;
    for (size_t r = 0; r < splats->run_count; ++r) {
        assert_true(splats->runs[r].seam_lines <= splats->runs[r].clip_lines);
        count += splats->runs[r].seam_lines ? splats->runs[r].count : 0;
    }
    return count;
}

static void check(const psplat_convert_desc *desc) {
    painted p;
    psplat_source_materials materials;
    psplat_report report;
    psplat_splats splats;
    psplat_error error;
    make(&p, &materials);
    if (psplat_convert(&p.mesh, desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.chart_border_edges, CELLS);
    assert_true(report.foreign_texture_percent < 1); /* Splats go on, but their texture does not. */
    size_t seams = count_with_seams(&splats);
    double tolerance = report.tolerance_percent / 100 * report.diagonal;
    double blended = mean_jump(&splats, tolerance);
    for (size_t r = 0; r < splats.run_count; ++r) splats.runs[r].seam_lines = 0;
    double cut = mean_jump(&splats, tolerance);
    print_message(
        "%zu of %zu splats have seams; normals jump by %.4f with them, %.4f where they cut\n",
        seams, splats.count, blended, cut);
    assert_true(seams >= 6);
    assert_true(blended < 0.5 * cut);
    psplat_splats_free(&splats);
    painted_free(&p);
}

static void test_curved(void **state) {
    (void)state;
    check(&(psplat_convert_desc){.tolerance_percent = 0.5,
                                 .precision = PSPLAT_USUAL_PRECISION,
                                 .effort = PSPLAT_EFFORT_NONE});
}

static void test_planar(void **state) {
    (void)state;
    check(
        &(psplat_convert_desc){.tolerance_percent = 1, .planar = 1, .effort = PSPLAT_EFFORT_NONE});
}

int test_seam_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_planar),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
