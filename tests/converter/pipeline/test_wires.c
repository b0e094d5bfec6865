/* SPDX-License-Identifier: MIT
 *
 * test_wires.c - tests that wires keep their width where the tolerance is wider than they are.
 */
#include "tube_fixture.h"

#include "pipeline/convert.h"
#include "splats/splats.h"
#include "verify/report.h"

static const double radius = 0.01;

/* Converts wires that are 1 long, as their box is but for their width, and returns the report. */
static psplat_report convert_wires(const obj *o, double percent) {
    psplat_mesh mesh = read_text("wires.obj", o->text);
    psplat_convert_desc desc = {.tolerance_percent = percent, .precision = PSPLAT_USUAL_PRECISION};
    psplat_report report = {0};
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(&mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    print_message("%4.1f %%: %zu splats, distance %.3f %%\n", percent, report.splats,
                  report.max_distance_percent);
    return report;
}

/* At twice its radius a wire is as exact as at half of it, and the report is of what was asked. */
static void test_narrow(void **state) {
    (void)state;
    obj wire = {{0}, 0};
    add_tube(&wire, radius, 1, 0, 1, 0);
    psplat_report report = convert_wires(&wire, 100 * 2 * radius);
    assert_true(report.max_distance_percent <= 100 * 0.5 * radius);
    assert_near(report.tolerance_percent, 100 * 2 * radius, 1e-12);
    assert_int_equal(report.uncovered_samples, 0);
    /* Splats run along it: some six around it, and the caps. */
    assert_true(report.splats <= 24);
}

/* Narrower wires become an eighth of the tolerance wider at most. */
static void test_narrowest(void **state) {
    (void)state;
    obj wire = {{0}, 0};
    add_tube(&wire, radius, 1, 0, 1, 0);
    psplat_report report = convert_wires(&wire, 100 * 8 * radius);
    assert_true(report.max_distance_percent <= 100 * radius);
}

/* Wires that are wide enough are as they are at any tolerance. */
static void test_wide(void **state) {
    (void)state;
    obj wire = {{0}, 0};
    add_tube(&wire, radius, 1, 0, 1, 0);
    psplat_report report = convert_wires(&wire, 100 * 0.25 * radius);
    assert_true(report.max_distance_percent <= 100 * 0.25 * radius);
}

int test_wires_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_narrow),
        cmocka_unit_test(test_narrowest),
        cmocka_unit_test(test_wide),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
