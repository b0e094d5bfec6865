/* SPDX-License-Identifier: MIT
 *
 * test_extremes_thin.c - tests that input thinner or finer than the tolerance, and input with tips
 * and creases that end, is converted correctly and into few splats. The measure is the brute force
 * of extreme_fixture.h.
 */
#include "mesh_fixture.h"

#include "extreme_fixture.h"

#include <math.h>

/* A square has triangles without area on its side, a needle, and a strip 1e-7 wide. */
static void test_slivers(void **state) {
    (void)state;
    shape s = {0};
    uint32_t v[8];
    for (int i = 0; i < 8; ++i) {
        static const double xs[4] = {0, 0.4, 0.4 + 1e-7, 1};
        v[i] = shape_vertex(&s, xs[i % 4], i / 4, 0);
    }
    for (uint32_t i = 0; i < 3; ++i) shape_quad(&s, v[i], v[i + 1], v[i + 5], v[i + 4]);
    uint32_t middle = shape_vertex(&s, 0.7, 0, 0);
    shape_triangle(&s, v[2], v[3], middle); /* no area */
    uint32_t end = shape_vertex(&s, 2, 0.5, 0), base = shape_vertex(&s, 1, 0.5 + 1e-6, 0);
    uint32_t root = shape_vertex(&s, 1, 0.5 - 1e-6, 0);
    shape_triangle(&s, root, end, base); /* a needle beside the square */
    extreme e = extreme_right("needles, slivers, no area", &s, 1);
    assert_true(e.splats.count <= 8);
    extreme_free(&e);
}

/* ---- thinner than the tolerance -------------------------------------------------------------- */

/* A plate is a tenth of the tolerance thick: each side is covered by splats of its own. */
static void test_thin_plate(void **state) {
    (void)state;
    shape s = {0};
    static const double low[3] = {0, 0, 0}, high[3] = {1, 0.8, 0.0006};
    shape_box(&s, low, high);
    extreme e = extreme_right("plate of 0.1 tolerances", &s, 0.5);
    size_t up = 0, down = 0;
    for (size_t i = 0; i < e.splats.count; ++i) {
        up += e.regions[i].n[2] > 0.99;
        down += e.regions[i].n[2] < -0.99;
    }
    assert_true(up >= 1 && down >= 1);
    assert_true(e.splats.count < 200);
    extreme_free(&e);
}

/* A closed wire is a thousand times longer than thick, and the tolerance is twenty of its radii. */
static void test_wire(void **state) {
    (void)state;
    shape s = {0};
    enum { SIDES = 12 };
    uint32_t low = shape_ring(&s, SIDES, 0.001, 0), high = shape_ring(&s, SIDES, 0.001, 1);
    for (uint32_t i = 0; i < SIDES; ++i) {
        uint32_t k = (i + 1) % SIDES;
        shape_quad(&s, low + i, low + k, high + k, high + i);
    }
    shape_fan(&s, shape_vertex(&s, 0, 0, 1), high, SIDES);
    for (uint32_t i = 1; i + 1 < SIDES; ++i) shape_triangle(&s, low, low + i + 1, low + i);
    extreme e = extreme_right("wire of 0.05 tolerances", &s, 2);
    assert_true(e.splats.count < 200);
    extreme_free(&e);
}

/* ---- tips and ends --------------------------------------------------------------------------- */

/* The tip of a cone lies on no crease and in no plane. */
static void test_cone(void **state) {
    (void)state;
    shape s = {0};
    uint32_t tip = shape_vertex(&s, 0, 0, 1), ring = shape_ring(&s, 64, 0.7, 0);
    shape_fan(&s, tip, ring, 64);
    extreme e = extreme_convert("cone tip", &s, 1);
    /* The promise is about interpolated normals, which at the tip point along the axis. This
     * measure uses face normals, for which a splat of the far side does not cover the very tip: 8
     * of 20,000 points, within 2 % of the height, are open. */
    extreme_at_most("cone tip", (double)e.uncovered, "of 20,000 points uncovered", 8);
    assert_int_equal(e.report.uncovered_samples, 0);
    extreme_at_most("cone tip", e.distance, "of the tolerance, the farthest splat", 1 + 1e-5);
    assert_true(e.splats.count < 100);
    extreme_free(&e);
}

static void place_dart(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t - 1;
    p[2] = p[1] > 0 ? 0.9 * p[1] * fabs(p[0]) : 0;
}

/* A crease fades out in the middle of a sheet. */
static void test_dart(void **state) {
    (void)state;
    shape s = {0};
    shape_grid(&s, 16, 16, place_dart);
    extreme e = extreme_right("crease that fades out", &s, 1);
    assert_true(e.splats.count < 60);
    extreme_free(&e);
}

int test_extremes_thin_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slivers), cmocka_unit_test(test_thin_plate),
        cmocka_unit_test(test_cone),    cmocka_unit_test(test_dart),
        cmocka_unit_test(test_wire),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
