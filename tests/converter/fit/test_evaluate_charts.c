/* SPDX-License-Identifier: MIT
 *
 * test_evaluate_charts.c - tests of how far beyond a border of charts a region has to be near the
 * surface. The shape is a square that is flat up to a known distance right of its middle, where its
 * texture coordinates jump, and bends down from there.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "base/region.h"
#include "features/surface.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"

enum { CELLS = 32 };
static double tolerance;

/* Where the surface begins to bend, and how much: its height is -bend / 2 times the squared
 * distance from there. */
static double bend_at, bend;

static void place_bent(double s, double t, double p[3]) {
    place_square(s, t, p);
    double x = max2(p[0] - bend_at, 0);
    p[2] = -bend * x * x / 2;
}

static void chart_halves(uint32_t triangle, const double p[3], float uv[2]) {
    uv[0] = (float)(p[0] / 4 + (triangle / 2 % CELLS >= CELLS / 2 ? 0.5 : 0));
    uv[1] = (float)(p[1] / 4);
}

/* Evaluates a flat disc left of the middle, which the border or crease there cuts. */
static psplat_evaluation evaluate(uint8_t kind, double radius, double at, double by) {
    charted c;
    psplat_scratch scratch = {0};
    bend_at = at, bend = by;
    charted_make(&c, CELLS, place_bent, chart_halves);
    charted_build(&c, fixture_crease_angle);
    assert_int_equal(c.f.surface.chart_border_edges, CELLS);
    assert_int_equal(c.f.surface.crease_edges, 0);
    for (size_t e = 0; e < 3 * c.f.mesh.triangle_count; ++e)
        if (c.f.surface.creases[e] == PSPLAT_BOUND_CHART) c.f.surface.creases[e] = kind;
    /* A region is known to be near the surface that it is connected with up to 1.5 of the spacings
     * of samples, here 0.127, from these. */
    fixture_sample(&c.f, 0.03);
    const psplat_limits limits = {.tolerance = tolerance,
                                  .crease_tolerance = 0.5 * tolerance,
                                  .crease_slack = 0.3 * tolerance,
                                  .margin = 0.01,
                                  .distance = c.f.distance};
    const psplat_fit_context context = fixture_context(&c.f, &limits, &scratch);
    const psplat_region region = {.center = {-0.3, 0, 0},
                                  .u = {1, 0, 0},
                                  .v = {0, 1, 0},
                                  .n = {0, 0, 1},
                                  .radius = {radius, radius}};
    /* The triangle beneath the centre. */
    uint32_t column = (uint32_t)((region.center[0] + 1) / 2 * CELLS);
    psplat_site site = psplat_site_of(&region, 2 * (CELLS / 2 * CELLS + column));
    psplat_evaluation e =
        psplat_evaluate(&context, &site, &region, &(psplat_demands){.inside = region.center});
    psplat_scratch_free(&scratch);
    charted_free(&c);
    return e;
}

/* Where the surface leaves the disc's plane by more than the tolerance just beyond the border, the
 * disc is refused; a crease there ends it, and a gentle bend leaves it near. A disc of radius 0.45
 * is to be near up to 0.135 from the border, where the surface is 0.036 or 0.009 lower. */
static void test_bends(void **state) {
    (void)state;
    tolerance = 0.02;
    psplat_evaluation e = evaluate(PSPLAT_BOUND_CHART, 0.45, 0, 4);
    assert_int_equal(e.status, PSPLAT_FIT_LEAVES_SURFACE);
    e = evaluate(PSPLAT_BOUND_CREASE, 0.45, 0, 4);
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_int_equal(e.region.chart_lines, 0);
    e = evaluate(PSPLAT_BOUND_CHART | PSPLAT_BOUND_TANGENT, 0.45, 0, 4); /* Splats end at these. */
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_int_equal(e.region.chart_lines, 0);
    e = evaluate(PSPLAT_BOUND_CHART, 0.45, 0, 1);
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_int_equal(e.region.line_count, 1);
    assert_int_equal(e.region.chart_lines, 1);
    /* The line itself stays at the border. */
    assert_near(psplat_region_line_value(&e.region, 0, (const double[2]){0.3 / 0.45, 0}), 0, 1e-6);
}

/* How far a disc has to be near is a part of its radius, 0.3 of it: at 0.135 from the border the
 * surface is 0.017 lower, at 0.06 it is as high as the disc. */
static void test_part_of_radius(void **state) {
    (void)state;
    tolerance = 0.01;
    assert_int_equal(evaluate(PSPLAT_BOUND_CHART, 0.31, 0.07, 8).status, PSPLAT_FIT_KEPT);
    assert_int_equal(evaluate(PSPLAT_BOUND_CHART, 0.45, 0.07, 8).status, PSPLAT_FIT_LEAVES_SURFACE);
    assert_int_equal(evaluate(PSPLAT_BOUND_CREASE, 0.45, 0.07, 8).status, PSPLAT_FIT_KEPT);
}

int test_evaluate_charts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bends),
        cmocka_unit_test(test_part_of_radius),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
