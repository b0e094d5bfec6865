/* SPDX-License-Identifier: MIT
 * Planes, normal fields (BSK04 eq. 3, 4) and curvature against exact answers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "near.h"
#include "stages.h"
#include "vector.h"

static void test_eigen(void **state) {
    (void)state;
    uint64_t random = 3;
    for (int trial = 0; trial < 200; ++trial) {
        double m[6], values[3], vectors[3][3];
        for (int k = 0; k < 6; ++k) m[k] = psplat_random_unit(&random) - 0.5;
        psplat_fit_eigen(m, values, vectors);
        assert_true(values[0] <= values[1] && values[1] <= values[2]);
        for (int k = 0; k < 3; ++k) {
            const double *v = vectors[k];
            double product[3] = {m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
                                 m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
                                 m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};
            mad3(product, -values[k], v);
            assert_near(length3(product), 0, 1e-14); /* rounding of unit-sized numbers */
            assert_near(length3(v), 1, 1e-14);
        }
    }
}

/* Samples of the plane n.p = 3, offset by 1e6, with one of them 1e-3 off on either side. */
static void test_plane(void **state) {
    (void)state;
    enum { COUNT = 60 };
    static double positions[3 * COUNT];
    static float normals[3 * COUNT];
    static uint32_t chosen[COUNT];
    double n[3] = {2.0 / 7, -3.0 / 7, 6.0 / 7}, u[3], v[3];
    perpendicular3(u, n);
    cross3(v, n, u);
    uint64_t random = 11;
    for (uint32_t i = 0; i < COUNT; ++i) {
        double *p = positions + 3 * (size_t)i;
        for (int k = 0; k < 3; ++k) p[k] = 1e6 + 3 * n[k];
        mad3(p, psplat_random_unit(&random), u);
        mad3(p, psplat_random_unit(&random), v);
        for (int k = 0; k < 3; ++k) normals[3 * i + (uint32_t)k] = (float)n[k];
        chosen[i] = i;
    }
    psplat_samples samples = {.positions = positions, .normals = normals, .count = COUNT};
    double mean[3], fitted[3];
    psplat_fit_plane(&samples, chosen, COUNT, mean, fitted);
    /* Coordinates of 1e6 carry 1e-10; over an extent of 1 that is the angle's error. */
    assert_near(dot3(fitted, n), 1, 1e-15);
    assert_near(length3(fitted), 1, 1e-12);
    psplat_fit_plane(&samples, chosen, 1, mean, fitted); /* one sample: its normal */
    assert_near(dot3(fitted, n), 1, 1e-7);               /* float normals */
}

/* A row of samples says nothing about the plane: the normals decide. */
static void test_plane_of_a_row(void **state) {
    (void)state;
    double positions[12] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 1e-9, 0};
    float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    uint32_t chosen[4] = {0, 1, 2, 3};
    psplat_samples samples = {.positions = positions, .normals = normals, .count = 4};
    double mean[3], fitted[3];
    psplat_fit_plane(&samples, chosen, 4, mean, fitted);
    assert_near(fitted[2], 1, 0);
    assert_near(mean[0], 1.5, 1e-15);
}

static void test_field_recovered(void **state) {
    (void)state;
    enum { COUNT = 25 };
    double uv[COUNT][2], xy[COUNT][2], field[4];
    uint64_t random = 5;
    for (int i = 0; i < COUNT; ++i) {
        uv[i][0] = 2 * psplat_random_unit(&random) - 1;
        uv[i][1] = 2 * psplat_random_unit(&random) - 1;
        xy[i][0] = 0.1 - 0.7 * uv[i][0];
        xy[i][1] = -0.2 + 0.3 * uv[i][1];
    }
    psplat_fit_normals((const double(*)[2])uv, (const double(*)[2])xy, COUNT, field);
    assert_near(field[0], 0.1, 1e-14);
    assert_near(field[1], -0.2, 1e-14);
    assert_near(field[2], -0.7, 1e-14);
    assert_near(field[3], 0.3, 1e-14);
}

/* The residual of a least-squares fit is orthogonal to 1 and to u. */
static void test_field_is_least_squares(void **state) {
    (void)state;
    double uv[4][2] = {{-1, 0}, {-0.2, 0}, {0.4, 0}, {0.9, 0}};
    double xy[4][2] = {{1, 0}, {-2, 0}, {0.5, 0}, {3, 0}}, field[4], sum = 0, moment = 0;
    psplat_fit_normals((const double(*)[2])uv, (const double(*)[2])xy, 4, field);
    for (int i = 0; i < 4; ++i) {
        double residual = field[0] + field[2] * uv[i][0] - xy[i][0];
        sum += residual, moment += residual * uv[i][0];
    }
    assert_near(sum, 0, 1e-14);
    assert_near(moment, 0, 1e-14);
}

/* Underdetermined: among all solutions of x + 0.5 alpha = 1 the one nearest to zero is
 * (0.8, 0.4). */
static void test_field_least_norm(void **state) {
    (void)state;
    double uv[1][2] = {{0.5, 0}}, xy[1][2] = {{1, 0.25}}, field[4];
    psplat_fit_normals((const double(*)[2])uv, (const double(*)[2])xy, 1, field);
    assert_near(field[0], 0.8, 1e-14);
    assert_near(field[2], 0.4, 1e-14);
    assert_near(field[1], 0.25, 1e-14); /* v is 0: nothing is known of beta */
    assert_near(field[3], 0, 1e-14);
}

/* Normals of z = (3 s^2 - t^2) / 2 in axes turned by 30 degrees: (-3 s, t). */
static void test_curvature(void **state) {
    (void)state;
    enum { COUNT = 30 };
    double st[COUNT][2], xy[COUNT][2], direction[2], curvature[2], c = sqrt(0.75), d = 0.5;
    uint64_t random = 9;
    for (int i = 0; i < COUNT; ++i) {
        double s = psplat_random_unit(&random), t = psplat_random_unit(&random);
        st[i][0] = c * s - d * t, st[i][1] = d * s + c * t;
        xy[i][0] = c * (-3 * s) - d * t, xy[i][1] = d * (-3 * s) + c * t;
    }
    psplat_fit_curvature((const double(*)[2])st, (const double(*)[2])xy, COUNT, direction,
                         curvature);
    assert_near(curvature[0], 3, 1e-12);
    assert_near(curvature[1], 1, 1e-12);
    assert_near(fabs(direction[0] * c + direction[1] * d), 1, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eigen),
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_plane_of_a_row),
        cmocka_unit_test(test_field_recovered),
        cmocka_unit_test(test_field_is_least_squares),
        cmocka_unit_test(test_field_least_norm),
        cmocka_unit_test(test_curvature),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
