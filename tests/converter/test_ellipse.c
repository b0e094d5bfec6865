/* SPDX-License-Identifier: MIT
 * Minimum enclosing ellipses against known ones, and at the extremes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"
#include "stages.h"

static const double pi = 3.14159265358979323846;

/* Largest (p - c)' S^-1 (p - c) over the points; 1 is on the ellipse. */
static double reach(const psplat_ellipse *e, double (*points)[2], size_t count) {
    double greatest = 0;
    for (size_t i = 0; i < count; ++i) {
        double x = points[i][0] - e->center[0], y = points[i][1] - e->center[1];
        double u = (x * e->axis[0] + y * e->axis[1]) / e->radius[0];
        double v = (y * e->axis[0] - x * e->axis[1]) / e->radius[1];
        if (u * u + v * v > greatest) greatest = u * u + v * v;
    }
    return greatest;
}

static psplat_ellipse enclose(double (*points)[2], size_t count) {
    double(*copy)[2] = malloc(count * sizeof *copy);
    psplat_ellipse e;
    assert_non_null(copy);
    memcpy(copy, points, count * sizeof *copy);
    psplat_ellipse_enclose(copy, count, &e);
    free(copy);
    assert_true(e.radius[0] >= e.radius[1]);
    assert_near(hypot(e.axis[0], e.axis[1]), 1, 1e-12); /* rounding */
    return e;
}

/* The ellipse of a rectangle's corners has the sides' half lengths times sqrt 2 as radii. */
static void test_rectangle(void **state) {
    (void)state;
    double points[4][2] = {{1, 2}, {7, 2}, {7, 3}, {1, 3}};
    psplat_ellipse e = enclose(points, 4);
    /* 1 % of area is the documented excess, half of that a radius. */
    assert_near(e.radius[0], 3 * sqrt(2), 0.006 * 3 * sqrt(2));
    assert_near(e.radius[1], 0.5 * sqrt(2), 0.006 * 0.5 * sqrt(2));
    assert_near(e.center[0], 4, 0.02);
    assert_near(e.center[1], 2.5, 0.005);
    assert_true(reach(&e, points, 4) <= 1 + 1e-9);
}

/* Points on a known ellipse, the more of them the tighter; the hull of 3000 is thinned inside. */
static void test_ellipse_recovered(void **state) {
    (void)state;
    static double points[3000][2];
    for (size_t count = 8; count <= 3000; count = count * 3 + 1) {
        for (size_t i = 0; i < count; ++i) {
            double t = 2 * pi * (double)i / (double)count, x = 5 * cos(t), y = 0.25 * sin(t);
            points[i][0] = 0.8 * x - 0.6 * y + 100;
            points[i][1] = 0.6 * x + 0.8 * y - 40;
        }
        psplat_ellipse e = enclose(points, count);
        double area = e.radius[0] * e.radius[1];
        assert_true(reach(&e, points, count) <= 1 + 1e-9);
        assert_in_range((size_t)(1e6 * area / 1.25), 990000, 1010000); /* 1 % of area */
        assert_near(fabs(e.axis[0] * 0.8 + e.axis[1] * 0.6), 1, 1e-3);
    }
}

/* An affine map of the points maps the ellipse: areas scale by the determinant. */
static void test_random_sets(void **state) {
    (void)state;
    uint64_t random = 7;
    for (int set = 0; set < 400; ++set) {
        double points[40][2], stretched[40][2];
        size_t count = 3 + (size_t)set % 38;
        double flatness = pow(10, -6.0 * psplat_random_unit(&random));
        for (size_t i = 0; i < count; ++i) {
            points[i][0] = psplat_random_unit(&random);
            points[i][1] = psplat_random_unit(&random);
            stretched[i][0] = 1e6 + points[i][0] + points[i][1] * 0.5;
            stretched[i][1] = 1e6 + flatness * points[i][1];
        }
        psplat_ellipse e = enclose(points, count), s = enclose(stretched, count);
        /* At an offset of 1e6 coordinates carry 1e-10, of the small radius's size here. */
        double slack = 1e-9 + 1e-9 / s.radius[1];
        assert_true(reach(&e, points, count) <= 1 + 1e-9);
        assert_true(reach(&s, stretched, count) <= 1 + slack);
        double ratio = s.radius[0] * s.radius[1] / (e.radius[0] * e.radius[1] * flatness);
        assert_near(ratio, 1, 0.025 + slack); /* 1.2 % for each of the two */
    }
}

static void test_degenerate(void **state) {
    (void)state;
    double line[5][2] = {{0, 0}, {1, 2}, {2, 4}, {3, 6}, {4, 8}},
           same[3][2] = {{5, 6}, {5, 6}, {5, 6}};
    psplat_ellipse e = enclose(line, 5);
    assert_near(e.radius[0], hypot(4, 8) / 2, 1e-12);
    assert_near(e.radius[1], 0, 1e-9);
    assert_near(fabs(e.axis[0] * 1 + e.axis[1] * 2), sqrt(5), 1e-9);
    e = enclose(same, 3);
    assert_near(e.center[0], 5, 0);
    assert_near(e.center[1], 6, 0);
    assert_near(e.radius[0], 0, 0);
    e = enclose(line, 2);
    assert_near(e.radius[0], hypot(1, 2) / 2, 1e-12);
    psplat_ellipse_enclose(line, 0, &e);
    assert_near(e.radius[0], 0, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rectangle),
        cmocka_unit_test(test_ellipse_recovered),
        cmocka_unit_test(test_random_sets),
        cmocka_unit_test(test_degenerate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
