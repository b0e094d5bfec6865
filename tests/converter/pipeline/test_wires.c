/* SPDX-License-Identifier: MIT
 *
 * test_wires.c - tests that wires keep their width where the tolerance is wider than they are.
 */
#include "tube_fixture.h"

#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

static const double radius = 0.01;

/* Reads a tube that is 1 long. */
static psplat_mesh read_wire(void) {
    obj wire = {{0}, 0};
    add_tube(&wire, radius, 1, 0, 1, 0);
    return read_text("wires.obj", wire.text);
}

/* Returns the tolerance that a tube is fitted to, in parts of its radius. */
static double fitted_radii(double percent, int has_coarse_wires) {
    psplat_mesh mesh = read_wire();
    psplat_convert_desc desc = {.tolerance_percent = percent, .has_coarse_wires = has_coarse_wires};
    psplat_splats splats = {.splats = NULL};
    psplat_conversion c = {.desc = &desc, .splats = &splats};
    assert_int_equal(psplat_conversion_begin(&c, &mesh, NULL), PSPLAT_OK);
    assert_near(c.percent, percent, 1e-12 * percent);
    double radii = c.tolerance / radius;
    psplat_conversion_free(&c);
    psplat_mesh_free(&mesh);
    return radii;
}

/* A tube is fitted to a quarter of its width, which is 1.96 radii, or to an eighth of the tolerance
 * where that is more; to the tolerance where that is less, and where wires may be coarse. The box
 * is 1.0004 across. */
static void test_tolerance(void **state) {
    (void)state;
    assert_near(fitted_radii(0.2, 0), 0.2, 1e-3);
    assert_near(fitted_radii(0.6, 0), 0.49, 0.01);
    assert_near(fitted_radii(2, 0), 0.49, 0.01);
    assert_near(fitted_radii(8, 0), 1, 1e-3);
    assert_near(fitted_radii(2, 1), 2, 2e-3);
}

/* At twice its radius a tube is as exact as at half of it, and the report is of what was asked. */
static void test_narrow(void **state) {
    (void)state;
    psplat_mesh mesh = read_wire();
    psplat_convert_desc desc = {.tolerance_percent = 2, .precision = PSPLAT_USUAL_PRECISION};
    psplat_report report = {0};
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(&mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    print_message("%zu splats, distance %.3f %%\n", report.splats, report.max_distance_percent);
    assert_true(report.max_distance_percent <= 100 * 0.5 * radius);
    assert_near(report.tolerance_percent, 2, 1e-12);
    assert_int_equal(report.uncovered_samples, 0);
    /* Splats run along it: some six around it, and the caps. */
    assert_true(report.splats <= 24);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

int test_wires_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tolerance),
        cmocka_unit_test(test_narrow),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
