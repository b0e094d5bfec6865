/* SPDX-License-Identifier: MIT
 *
 * test_extreme_input.c - tests of input with too little or too much in it: vertices that no face
 * uses, no surface, numbers that are not finite, too few points, and surfaces that are nearly flat
 * or bend within the tolerance. Expected values are error codes, or splats known by hand.
 */
#include "mesh_fixture.h"

#include "extreme_fixture.h"
#include "base/region.h"
#include "base/vector.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"

#include <math.h>
#include <string.h>

/* ---- vertices -------------------------------------------------------------------------------- */

/* A cube becomes six splats exact to rounding to float, wherever unused vertices lie. */
static void test_unreferenced(void **state) {
    (void)state;
    for (int strays = 0; strays < 2; ++strays) {
        shape s = {0};
        static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
        if (strays) shape_vertex(&s, 1e6, -1e6, 1e6);
        shape_box(&s, low, high);
        for (int i = 0; i < 100 * strays; ++i) shape_vertex(&s, i, -i, 1e9);
        const char *name = strays ? "cube, 101 vertices unreferenced" : "corners of a cube";
        extreme e = extreme_right(name, &s, 0.5);
        assert_int_equal(e.splats.count, 6);
        extreme_at_most(name, fabs(e.report.diagonal - sqrt(3)), "of the diagonal, its error",
                        1e-15);
        extreme_free(&e);
    }
}

/* ---- no surface, and values that are not finite ---------------------------------------------- */

static double refused(const char *name, const char *text, psplat_result code) {
    psplat_mesh mesh = {0};
    psplat_error error = {0};
    write_bytes(name, text, strlen(text));
    psplat_result result = psplat_mesh_read(fixture_path, &mesh, &error);
    unlink(fixture_path);
    psplat_mesh_free(&mesh);
    return result == code && strlen(error.text) > 10 ? 0 : 1;
}

static void test_nothing(void **state) {
    (void)state;
    static const struct {
        const char *name, *file, *text;
        psplat_result code;
    } cases[] = {
        {"an empty file", "t.obj", "", PSPLAT_ERROR_FORMAT},
        {"an empty mesh", "t.off", "OFF\n0 0 0\n", PSPLAT_ERROR_NO_SPLATS},
        {"lines alone", "t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n", PSPLAT_ERROR_NO_SPLATS},
        {"faces of no area", "t.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 1 1 2\n",
         PSPLAT_ERROR_NO_SPLATS},
        {"a NaN", "t.obj", "v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", PSPLAT_ERROR_RANGE},
        {"an infinity", "t.off", "OFF\n3 1 0\n0 0 0\n1 0 -inf\n0 1 0\n3 0 1 2\n",
         PSPLAT_ERROR_RANGE},
        {"a number beyond double", "t.obj", "v 0 1e999 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
         PSPLAT_ERROR_RANGE},
        {"one point", "t.xyz", "1 2 3\n", PSPLAT_ERROR_NO_SPLATS},
        {"two points", "t.xyz", "1 2 3\n2 3 4\n", PSPLAT_ERROR_NO_SPLATS},
        {"five points in one place", "t.xyz", "1 2 3\n1 2 3\n1 2 3\n1 2 3\n1 2 3\n",
         PSPLAT_ERROR_NO_SPLATS},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        extreme_at_most(cases[i].name, refused(cases[i].file, cases[i].text, cases[i].code),
                        "times not refused with a sentence", 0);
}

/* ---- the smallest surfaces ------------------------------------------------------------------- */

static extreme convert_points(const char *name, const char *text) {
    extreme e = {.mesh = read_text("t.xyz", text)};
    psplat_error error;
    psplat_convert_desc desc = {.tolerance_percent = 5};
    if (psplat_convert(&e.mesh, &desc, &e.splats, &e.report, &error)) fail_msg("%s", error.text);
    e.regions = psplat_splat_regions(&e.splats);
    assert_non_null(e.regions);
    e.tolerance = 0.05 * e.report.diagonal;
    double most = 0;
    for (size_t i = 0; i < e.mesh.point_count; ++i) {
        double least = HUGE_VAL;
        for (size_t k = 0; k < e.splats.count; ++k) {
            double uvh[3];
            psplat_region_local(&e.regions[k], e.mesh.points + 3 * i, uvh);
            int inside = psplat_region_contains(&e.regions[k], uvh, 1 + 1e-5, 1e-5);
            if (inside) least = min2(least, fabs(uvh[2]));
        }
        most = max2(most, least / e.tolerance);
    }
    extreme_at_most(name, most, "of the tolerance, the farthest point", 1 + 1e-5);
    return e;
}

static void test_few_points(void **state) {
    (void)state;
    extreme e = convert_points("three points", "0 0 0\n1 0 0\n0 1 0.2\n");
    assert_int_equal(e.splats.count, 1);
    extreme_free(&e);
    e = convert_points("five points in a line with normals",
                       "0 0 0 0 0 1\n1 0 0 0 0 1\n2 0 0 0 0 1\n3 0 0 0 0 1\n4 0 0 0 0 1\n");
    for (size_t i = 0; i < e.splats.count; ++i) assert_near(e.regions[i].n[2], 1, 1e-6);
    extreme_free(&e);
    e = convert_points("four points, three of them in a line", "0 0 0\n1 0 0\n2 0 0\n1 1 0\n");
    extreme_free(&e);
}

/* Returns the result of converting a right triangle whose legs are so long. */
static psplat_result convert_triangle(double leg) {
    char text[200];
    psplat_splats splats = {0};
    psplat_error error = {0};
    snprintf(text, sizeof text, "OFF\n3 1 0\n0 0 0\n%.17g 0 0\n0 %.17g 0\n3 0 1 2\n", leg, leg);
    psplat_mesh mesh = read_text("t.off", text);
    const psplat_convert_desc desc = {.precision = PSPLAT_USUAL_PRECISION};
    psplat_result result = psplat_convert(&mesh, &desc, &splats, NULL, &error);
    if (result) assert_int_equal(splats.count, 0);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    return result;
}

/* Splats have floats. A mesh that is too small for them is refused; one of 1e-44 was converted for
 * ever. */
static void test_too_small(void **state) {
    (void)state;
    assert_int_equal(convert_triangle(1e-31), PSPLAT_OK);
    assert_int_equal(convert_triangle(1e-33), PSPLAT_ERROR_RANGE);
    assert_int_equal(convert_triangle(1e-44), PSPLAT_ERROR_RANGE);
}

/* ---- curvature ------------------------------------------------------------------------------- */

/* Places a sheet that bends by 1e-9 of its size, which needs one splat, as a plane does. */
static void place_nearly_flat(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 1e-9 * (s * s + 0.5 * t * t);
}

static void test_nearly_flat(void **state) {
    (void)state;
    shape s = {0};
    shape_grid(&s, 8, 8, place_nearly_flat);
    extreme e = extreme_right("curvature of 1e-9", &s, 1);
    assert_int_equal(e.splats.count, 1);
    for (int k = 0; k < 3; ++k) assert_true(fabsf(e.splats.splats[0].gradient[k]) < 1e-6f);
    extreme_free(&e);
}

static void place_ball(double s, double t, double p[3]) {
    double theta = extreme_pi * t, phi = 2 * extreme_pi * (s < 1 ? s : 0),
           z = t < 1 ? -cos(theta) : 1;
    double ring = t > 0 && t < 1 ? sin(theta) : 0, radius = 0.003;
    p[0] = radius * ring * cos(phi), p[1] = radius * ring * sin(phi), p[2] = radius * z;
}

/* A ball whose radius is a third of the tolerance hangs over a square of more than a hundred times
 * its size: the normal field of every splat stays within the bound of spec 3.5. */
static void test_bent_within_tolerance(void **state) {
    (void)state;
    shape s = {0};
    double most = 0;
    shape_grid(&s, 12, 8, place_ball);
    uint32_t v[4];
    for (int i = 0; i < 4; ++i) v[i] = shape_vertex(&s, i % 2 - 0.5, i / 2 - 0.5, -0.2);
    shape_quad(&s, v[0], v[1], v[3], v[2]);
    extreme e = extreme_right("curvature of 3 per tolerance", &s, 0.7);
    for (size_t i = 0; i < e.splats.count; ++i) {
        const psplat_splat *splat = &e.splats.splats[i];
        double a = (double)splat->gradient[0], b = (double)splat->gradient[1];
        double c = (double)splat->gradient[2],
               q = (double)splat->radius[1] / (double)splat->radius[0];
        most = max2(most, sqrt(a * a + b * b + c * c * (1 + q * q)));
    }
    extreme_at_most("curvature of 3 per tolerance", most, "of normal change a radius", 20);
    extreme_free(&e);
}

int test_extreme_input_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_unreferenced), cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_few_points),   cmocka_unit_test(test_too_small),
        cmocka_unit_test(test_nearly_flat),  cmocka_unit_test(test_bent_within_tolerance),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
