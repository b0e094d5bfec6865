/* SPDX-License-Identifier: MIT
 *
 * test_normal_field.c - tests of eigenvectors and of fitting the normal field (spec 3.5) by least
 * squares, against answers that are exact: fields sampled at points, a quadric, and underdetermined
 * systems.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "base/eigen.h"
#include "base/random.h"
#include "base/vector.h"
#include "fit/normal_field.h"

static void test_eigen(void **state) {
    (void)state;
    uint64_t random = 3;
    for (int trial = 0; trial < 200; ++trial) {
        double m[6], values[3], vectors[3][3];
        for (int k = 0; k < 6; ++k) m[k] = psplat_random_unit(&random) - 0.5;
        psplat_eigen(m, values, vectors);
        assert_true(values[0] <= values[1] && values[1] <= values[2]);
        for (int k = 0; k < 3; ++k) {
            const double *v = vectors[k];
            double product[3] = {m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
                                 m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
                                 m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};
            mad3(product, -values[k], v);
            assert_near(length3(product), 0, 1e-14); /* rounding of numbers of unit size */
            assert_near(length3(v), 1, 1e-14);
        }
    }
}

/* ---- the normal field ---------------------------------------------------------------------- */

enum { SAMPLES = 25 };

static const double wide[2] = {2, 0.5};

/* Spreads parameters over a square of this size and centre. */
static void spread(double (*uv)[2], size_t count, double size, double center) {
    uint64_t random = 5;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k)
            uv[i][k] = center + size * (2 * psplat_random_unit(&random) - 1);
}

static void fit(double (*uv)[2], double (*xy)[2], size_t count, const double radius[2],
                double field[5]) {
    psplat_fit_normal_field((const double(*)[2])uv, (const double(*)[2])xy, count, radius, field);
}

/* A field comes back from its own values. From a hundredth of the ellipse, off its centre, the
 * normal equations have a condition of 1e6, hence an error of 1e-16 times that. */
static void test_field_recovered(void **state) {
    (void)state;
    const double field[5] = {0.1, -0.2, -0.7, 0.3, 0.45};
    static const double sizes[2] = {1, 0.01}, centers[2] = {0, 0.6}, errors[2] = {1e-14, 1e-9};
    for (int i = 0; i < 2; ++i) {
        double uv[SAMPLES][2], xy[SAMPLES][2], found[5];
        spread(uv, SAMPLES, sizes[i], centers[i]);
        for (int k = 0; k < SAMPLES; ++k) psplat_normal_field_at(field, wide, uv[k], xy[k]);
        fit(uv, xy, SAMPLES, wide, found);
        for (int k = 0; k < 5; ++k) assert_near(found[k], field[k], errors[i]);
    }
}

/* The height (a s'^2 + c t'^2) / 2, over axes turned against those of the ellipse, has the local
 * normal -grad. This is linear in (s, t) with the symmetric Hessian as its matrix, hence exactly a
 * field with gamma. */
static void test_field_of_turned_quadric(void **state) {
    (void)state;
    const double a = 0.3, c = -0.2, turn = 0.7, radius[2] = {1.5, 0.4};
    const double cosine = cos(turn), sine = sin(turn);
    const double ss = a * cosine * cosine + c * sine * sine;
    const double st = (a - c) * cosine * sine;
    const double tt = a * sine * sine + c * cosine * cosine;
    double uv[SAMPLES][2], xy[SAMPLES][2], field[5];
    spread(uv, SAMPLES, 0.7, 0);
    for (int i = 0; i < SAMPLES; ++i) {
        double s = uv[i][0] * radius[0], t = uv[i][1] * radius[1];
        xy[i][0] = -(ss * s + st * t);
        xy[i][1] = -(st * s + tt * t);
    }
    fit(uv, xy, SAMPLES, radius, field);
    const double expected[5] = {0, 0, -ss * radius[0], -tt * radius[1], -st * radius[0]};
    for (int k = 0; k < 5; ++k) assert_near(field[k], expected[k], 1e-14);
    for (int i = 0; i < SAMPLES; ++i) {
        double found[2];
        psplat_normal_field_at(field, radius, uv[i], found);
        assert_near(found[0], xy[i][0], 1e-14);
        assert_near(found[1], xy[i][1], 1e-14);
    }
}

/* The residual of a least-squares fit is orthogonal to the derivatives by each parameter of the
 * field. */
static void test_field_is_least_squares(void **state) {
    (void)state;
    double uv[SAMPLES][2], xy[SAMPLES][2], field[5], moments[5] = {0};
    uint64_t random = 8;
    spread(uv, SAMPLES, 0.8, 0.1);
    for (int i = 0; i < SAMPLES; ++i)
        for (int k = 0; k < 2; ++k) xy[i][k] = 2 * psplat_random_unit(&random) - 1;
    fit(uv, xy, SAMPLES, wide, field);
    for (int i = 0; i < SAMPLES; ++i) {
        double found[2];
        psplat_normal_field_at(field, wide, uv[i], found);
        double x = found[0] - xy[i][0], y = found[1] - xy[i][1];
        moments[0] += x, moments[1] += y;
        moments[2] += x * uv[i][0], moments[3] += y * uv[i][1];
        moments[4] += x * wide[1] / wide[0] * uv[i][1] + y * uv[i][0];
    }
    for (int k = 0; k < 5; ++k) assert_near(moments[k], 0, 1e-13); /* sums of 25 products */
}

/* The system is underdetermined: among all solutions of x + 0.5 alpha = 1 and y + 0.5 gamma = 0.25,
 * the fit gives the one nearest to zero. */
static void test_field_least_norm(void **state) {
    (void)state;
    double uv[1][2] = {{0.5, 0}}, xy[1][2] = {{1, 0.25}}, field[5];
    fit(uv, xy, 1, wide, field);
    /* The regularisation leaves its square, 1e-18, and rounding divided by it, 1e-16 / 1e-9. */
    assert_near(field[0], 0.8, 1e-7);
    assert_near(field[2], 0.4, 1e-7);
    assert_near(field[1], 0.2, 1e-7);
    assert_near(field[4], 0.1, 1e-7);
    assert_near(field[3], 0, 1e-7); /* v is 0, so that beta is undetermined */
}

/* For a row along u, and for one point repeated, every parameter stays small and the values fit. */
static void test_field_of_a_row(void **state) {
    (void)state;
    for (int same = 0; same < 2; ++same) {
        double uv[4][2], xy[4][2], field[5];
        for (int i = 0; i < 4; ++i) {
            uv[i][0] = same ? 0.3 : 0.3 * i - 0.4, uv[i][1] = 0.2;
            xy[i][0] = 0.1 + 0.5 * uv[i][0], xy[i][1] = 0.2 - 0.3 * uv[i][0];
        }
        fit(uv, xy, 4, wide, field);
        for (int i = 0; i < 4; ++i) {
            double found[2];
            psplat_normal_field_at(field, wide, uv[i], found);
            assert_near(found[0], xy[i][0], 1e-7); /* the tolerance of test_field_least_norm */
            assert_near(found[1], xy[i][1], 1e-7);
        }
        for (int k = 0; k < 5; ++k) assert_true(fabs(field[k]) < 0.6);
    }
}

/* Three samples in a tiny part of the ellipse, whose normals differ much, would need a gradient
 * beyond the bound of spec 3.5; the fit then gives their mean. */
static void test_field_bound(void **state) {
    (void)state;
    double uv[3][2] = {{0, 0}, {0.01, 0}, {0, 0.01}}, xy[3][2] = {{0, 0}, {0.5, 0}, {0, 0.1}};
    double field[5];
    fit(uv, xy, 3, (double[]){1, 1}, field);
    assert_near(field[0], 0.5 / 3, 1e-15);
    assert_near(field[1], 0.1 / 3, 1e-15);
    for (int k = 2; k < 5; ++k) assert_true(field[k] == 0);
    xy[1][0] = 0.05; /* alpha 5 and beta 10, within the bound */
    fit(uv, xy, 3, (double[]){1, 1}, field);
    assert_near(field[2], 5, 1e-6);
    assert_near(field[3], 10, 1e-6);
}

int test_normal_field_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eigen),
        cmocka_unit_test(test_field_recovered),
        cmocka_unit_test(test_field_of_turned_quadric),
        cmocka_unit_test(test_field_is_least_squares),
        cmocka_unit_test(test_field_least_norm),
        cmocka_unit_test(test_field_of_a_row),
        cmocka_unit_test(test_field_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
