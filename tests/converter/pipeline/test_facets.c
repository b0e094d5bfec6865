/* SPDX-License-Identifier: MIT
 *
 * test_facets.c - tests that splats end at the edges of facets where a mesh of few polygons would
 * take many more of them, and nowhere else, on a ball of flat quadrangles.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "pipeline/convert.h"
#include "shape_fixture.h"
#include "splats/splats.h"
#include "stage_fixture.h"
#include "verify/report.h"

enum { ROWS = 7, SIDES = 14, FACETS = ROWS * SIDES, EDGES = (ROWS - 1) * SIDES + ROWS * SIDES };

static psplat_report convert_ball(int rows, int sides, psplat_convert_desc desc) {
    double profile[65][2];
    for (int i = 0; i <= rows; ++i) {
        double turn = fixture_pi * i / rows;
        profile[i][0] = i % rows ? sin(turn) : 0;
        profile[i][1] = -cos(turn);
    }
    psplat_mesh mesh = shape_turned((const double(*)[2])profile, rows + 1, sides);
    psplat_report report = {0};
    psplat_splats splats;
    psplat_error error;
    desc.precision = PSPLAT_USUAL_PRECISION;
    if (psplat_convert(&mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    print_message("%zu splats, %zu edges of facets, distance %.3f %%, normals %.2f degrees\n",
                  report.splats, report.facet_edges, report.max_distance_percent,
                  report.rms_normal_degrees);
    assert_int_equal(report.uncovered_samples, 0);
    assert_true(report.max_distance_percent <= report.tolerance_percent);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    return report;
}

/* Where the tolerance is small, facets take a splat each, and few more for what rounding leaves
 * open; other splats would be 230 at 0.3 % and 800 at 0.1 %. */
static void test_small_tolerance(void **state) {
    (void)state;
    for (int i = 0; i < 2; ++i) {
        psplat_report report =
            convert_ball(ROWS, SIDES, (psplat_convert_desc){.tolerance_percent = i ? 0.1 : 0.3});
        assert_int_equal(report.facet_edges, EDGES);
        assert_int_equal(report.patches, FACETS);
        assert_in_range(report.splats, FACETS, 3 * FACETS / 2);
    }
}

/* Where splats may reach over edges, or facets are small, these bound nothing. */
static void test_large_tolerance(void **state) {
    (void)state;
    psplat_report report = convert_ball(ROWS, SIDES, (psplat_convert_desc){.tolerance_percent = 2});
    assert_int_equal(report.facet_edges, 0);
    assert_in_range(report.splats, 1, FACETS);
    report = convert_ball(40, 80, (psplat_convert_desc){.tolerance_percent = 0.2});
    assert_int_equal(report.facet_edges, 0);
}

/* Nor do they without creases. */
static void test_no_creases(void **state) {
    (void)state;
    psplat_report report =
        convert_ball(ROWS, SIDES, (psplat_convert_desc){.tolerance_percent = 0.3, .no_creases = 1});
    assert_int_equal(report.facet_edges, 0);
    assert_true(report.splats > 3 * FACETS / 2);
}

/* Where facets take as many splats each, since normals may hardly err and are constant, splats go
 * over their edges after all. */
static void test_after_all(void **state) {
    (void)state;
    psplat_report report = convert_ball(ROWS, SIDES,
                                        (psplat_convert_desc){.tolerance_percent = 1,
                                                              .constant_normals = 1,
                                                              .normal_tolerance_degrees = 5});
    assert_int_equal(report.facet_edges, 0);
    assert_true(report.splats > 4 * FACETS);
}

int test_facets_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_small_tolerance),
        cmocka_unit_test(test_large_tolerance),
        cmocka_unit_test(test_no_creases),
        cmocka_unit_test(test_after_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
