/* SPDX-License-Identifier: MIT
 *
 * test_covariance.c - tests of covariance sums over oriented points: fitted planes and curvatures
 * against exact answers, and sums of unions against sums of their parts. The points lie on
 * rectangles, rows, quadrics, cylinders and spheres in random frames.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/covariance.h"
#include "base/random.h"
#include "base/vector.h"

/* Adds the point `at` in the frame `axes`, whose normal leans from the third axis by `slope`. */
static void add_point(psplat_covariance *c, double axes[3][3], const double at[3],
                      const double slope[2]) {
    double p[3] = {0, 0, 0}, n[3];
    memcpy(n, axes[2], sizeof n);
    for (int k = 0; k < 3; ++k) mad3(p, at[k], axes[k]);
    for (int k = 0; k < 2; ++k) mad3(n, slope[k], axes[k]);
    normalize3(n);
    psplat_covariance_add(c, p, n);
}

static const double level[2] = {0, 0};

/* ---- planes ---------------------------------------------------------------------------------- */

/* The points lie on a tilted rectangle of 4 by 1 at an offset of up to 1e6, relative to an origin
 * nearby, each with its mirror images in the frame. */
static void test_plane(void **state) {
    (void)state;
    uint64_t random = 11;
    for (int trial = 0; trial < 50; ++trial) {
        double axes[3][3], origin[3], local[3];
        psplat_covariance c = {0};
        psplat_plane plane;
        random_axes(&random, axes[0], axes[1], axes[2]);
        for (int k = 0; k < 3; ++k) origin[k] = 1e6 * (psplat_random_unit(&random) - 0.5);
        for (int i = 0; i < 50; ++i)
            for (int sign = 0; sign < 8; ++sign) {
                /* With all sign changes every odd moment is 0, so that the frame is the exact
                 * answer. */
                double p[3], h = 0.01 * (i % 7) / 6;
                double x = 2 * (i + 1) / 50.0, y = 0.5 * ((i * 17 + 3) % 50) / 50.0;
                memcpy(p, origin, sizeof p);
                mad3(p, sign & 1 ? x : -x, axes[0]);
                mad3(p, sign & 2 ? y : -y, axes[1]);
                mad3(p, sign & 4 ? h : -h, axes[2]);
                sub3(local, p, origin);
                psplat_covariance_add(&c, local, axes[2]);
            }
        psplat_covariance_fit(&c, &plane);
        /* Coordinates of 1e6 are exact to 1e-10, which over an extent of 1 is the error of the
         * angle. */
        assert_near(dot3(plane.n, axes[2]), 1, 1e-12);
        assert_near(fabs(dot3(plane.u, axes[0])), 1, 1e-12);
        assert_near(length3(plane.mean), 0, 1e-9);
        double cross[3];
        cross3(cross, plane.u, plane.v);
        assert_near(dot3(cross, plane.n), 1, 1e-14);
        /* The mean of 1 ... 50 squared is 858.5; the heights 0 ... 6 are summed here. */
        assert_near(plane.variance[0], 858.5 / 625, 1e-9);
        assert_true(plane.variance[1] > 0.07 && plane.variance[1] < 0.09); /* 0.5^2 / 3 */
        double heights = 0;
        for (int i = 0; i < 50; ++i) heights += pow(0.01 * (i % 7) / 6, 2) / 50;
        assert_near(plane.variance[2], heights, 1e-10);
    }
}

/* Noise of a hundredth turns the plane of n points with extent 1 by about 0.01 / (sqrt(n) 0.3). */
static void test_noisy_plane(void **state) {
    (void)state;
    uint64_t random = 23;
    double axes[3][3];
    psplat_covariance c = {0};
    psplat_plane plane;
    random_axes(&random, axes[0], axes[1], axes[2]);
    for (int i = 0; i < 900; ++i) {
        double at[3] = {psplat_random_unit(&random), psplat_random_unit(&random),
                        0.02 * psplat_random_unit(&random) - 0.01};
        add_point(&c, axes, at, level);
    }
    psplat_covariance_fit(&c, &plane);
    assert_true(dot3(plane.n, axes[2]) > cos(0.003)); /* three times the expected angle */
    assert_near(dot3(plane.mean, axes[2]), 0, 0.001);
    assert_near(sqrt(plane.variance[2]), 0.01 / sqrt(3), 0.0005);
}

/* The plane of one sample, or of several in one place, has its normal. In a row the normals decide
 * the plane, and the row is the longer axis. */
static void test_few(void **state) {
    (void)state;
    uint64_t random = 5;
    for (int trial = 0; trial < 20; ++trial) {
        double axes[3][3], at[3] = {0.3, -0.2, 0.1};
        psplat_covariance c = {0};
        psplat_plane plane;
        random_axes(&random, axes[0], axes[1], axes[2]);
        for (int i = 0; i < 3; ++i) {
            add_point(&c, axes, at, level);
            psplat_covariance_fit(&c, &plane);
            assert_near(dot3(plane.n, axes[2]), 1, 1e-14);
            assert_near(dot3(plane.mean, axes[0]), 0.3, 1e-15);
            for (int k = 0; k < 3; ++k) assert_near(plane.variance[k], 0, 1e-16);
            assert_near(dot3(plane.u, plane.n), 0, 1e-15);
        }
        c = (psplat_covariance){0};
        for (int i = 0; i < 4; ++i) {
            at[0] = i;
            at[1] = i == 3 ? 1e-9 : 0; /* too small to count as an extent */
            at[2] = 0;
            add_point(&c, axes, at, level);
        }
        psplat_covariance_fit(&c, &plane);
        assert_near(dot3(plane.n, axes[2]), 1, 1e-14);
        assert_near(fabs(dot3(plane.u, axes[0])), 1, 1e-14);
        assert_near(plane.variance[0], 1.25, 1e-14); /* variance of 0, 1, 2, 3 */
        assert_near(dot3(plane.mean, axes[0]), 1.5, 1e-14);
    }
}

/* On a strip of a cliff that is higher than wide, the points suggest the wall, but the normals
 * decide for the ground. */
static void test_normals_overrule(void **state) {
    (void)state;
    psplat_covariance c = {0};
    psplat_plane plane;
    for (int i = 0; i < 11; ++i)
        for (int k = 0; k < 11; ++k) {
            double p[3] = {0.1 * i, 0.001 * ((i + k) % 3), 0.1 * k}, n[3] = {0, 0, 1};
            psplat_covariance_add(&c, p, n);
        }
    psplat_covariance_fit(&c, &plane);
    assert_near(plane.n[2], 1, 1e-15);
}

/* ---- unions ---------------------------------------------------------------------------------- */

static void test_union(void **state) {
    (void)state;
    uint64_t random = 17;
    psplat_covariance all = {0}, united = {0}, *parts = calloc(3, sizeof *parts);
    assert_non_null(parts);
    for (int i = 0; i < 300; ++i) {
        double p[3], n[3];
        for (int k = 0; k < 3; ++k) {
            p[k] = psplat_random_unit(&random) - 0.5;
            n[k] = psplat_random_unit(&random);
        }
        normalize3(n);
        psplat_covariance_add(&all, p, n);
        psplat_covariance_add(&parts[i % 3], p, n);
    }
    for (int k = 0; k < 3; ++k) psplat_covariance_unite(&united, &parts[k]);
    free(parts);
    assert_near(united.count, 300, 0);
    for (int k = 0; k < 3; ++k) {
        assert_near(united.p[k], all.p[k], 1e-12); /* sums of 300 in another order */
        assert_near(united.n[k], all.n[k], 1e-12);
        for (int l = 0; l < 3; ++l) assert_near(united.np[k][l], all.np[k][l], 1e-12);
    }
    for (int k = 0; k < 6; ++k) assert_near(united.pp[k], all.pp[k], 1e-12);
}

/* Sums moved from one origin to another equal the sums taken at the other. The points lie within
 * about 1 of the first origin, and `far` is the distance of the second one. */
static void check_move(double far, double tolerance, uint64_t *random) {
    psplat_covariance here = {0}, there = {0};
    psplat_plane moved, plane;
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = far * (2 * psplat_random_unit(random) - 1);
    for (int i = 0; i < 100; ++i) {
        double p[3], q[3], n[3];
        for (int k = 0; k < 3; ++k) {
            p[k] = (k < 2 ? 2 : 0.02) * psplat_random_unit(random) - (k < 2 ? 1 : 0.01);
            n[k] = (k < 2 ? 0.1 : 1) * psplat_random_unit(random);
        }
        normalize3(n);
        sub3(q, p, d);
        psplat_covariance_add(&here, p, n);
        psplat_covariance_add(&there, q, n);
    }
    psplat_covariance_move(&here, d);
    /* Sums of 100 terms, each at most the distance or its square. */
    double size = 1 + far, sum = 100 * size, squares = 100 * size * size;
    assert_near(here.count, 100, 0);
    for (int k = 0; k < 3; ++k) {
        assert_near(here.p[k], there.p[k], 1e-12 * sum);
        assert_near(here.n[k], there.n[k], 0);
        for (int l = 0; l < 3; ++l) assert_near(here.np[k][l], there.np[k][l], 1e-12 * sum);
    }
    for (int k = 0; k < 6; ++k) assert_near(here.pp[k], there.pp[k], 1e-12 * squares);
    psplat_covariance_fit(&here, &moved);
    psplat_covariance_fit(&there, &plane);
    for (int k = 0; k < 3; ++k) assert_near(moved.mean[k], plane.mean[k], 1e-12 * size);
    assert_near(moved.variance[0], plane.variance[0], tolerance);
    assert_near(moved.variance[2], plane.variance[2], tolerance);
    assert_near(dot3(moved.n, plane.n), 1, tolerance + 1e-15);
}

static void test_move(void **state) {
    (void)state;
    uint64_t random = 23;
    for (int trial = 0; trial < 20; ++trial) {
        check_move(0, 0, &random); /* no move */
        /* The variance is a difference of squares: it loses 1e-16 of (1 + far)^2, times some
         * thousand terms. */
        check_move(1, 1e-13, &random);
        check_move(10, 1e-11, &random);
        check_move(1000, 1e-8, &random);
    }
    /* Moving to 1e6 and back: squares of 1e12 leave 1e-4 of extents of 1. */
    psplat_covariance c = {0};
    psplat_plane before, after;
    const double far[3] = {6e5, -8e5, 3e5}, back[3] = {-6e5, 8e5, -3e5};
    for (int i = 0; i < 100; ++i) {
        double p[3] = {0.1 * (i % 10), 0.2 * (i / 10), 0}, n[3] = {0, 0, 1};
        psplat_covariance_add(&c, p, n);
    }
    psplat_covariance_fit(&c, &before);
    psplat_covariance_move(&c, far);
    psplat_covariance_move(&c, back);
    psplat_covariance_fit(&c, &after);
    for (int k = 0; k < 3; ++k) assert_near(after.mean[k], before.mean[k], 1e-9);
    for (int k = 0; k < 3; ++k) assert_near(after.variance[k], before.variance[k], 2e-3);
    assert_near(dot3(after.n, before.n), 1, 1e-2);
}

/* ---- curvature ------------------------------------------------------------------------------- */

/* Checks the graph of (a s^2 + b t^2) / 2 over a small square, with curvatures a and b along s and
 * t. The greater curvature has the other direction where a and b are swapped. */
static void check_quadric(double a, double b, uint64_t *random) {
    double axes[3][3], direction[2], curvature[2], turned[3] = {0, 0, 0};
    psplat_covariance c = {0};
    psplat_plane plane;
    const double size = 1e-3;
    random_axes(random, axes[0], axes[1], axes[2]);
    for (int i = -10; i <= 10; ++i)
        for (int k = -10; k <= 10; ++k) {
            double s = size * i / 10, t = size * k / 10;
            double at[3] = {s, t, (a * s * s + b * t * t) / 2}, slope[2] = {-a * s, -b * t};
            add_point(&c, axes, at, slope);
        }
    psplat_covariance_fit(&c, &plane);
    assert_int_equal(psplat_covariance_curvature(&c, &plane, direction, curvature), 1);
    assert_true(curvature[0] >= curvature[1]);
    /* Unit normals differ from local ones by the square of their slope: (3 size)^2. */
    assert_near(curvature[0], max2(fabs(a), fabs(b)), 1e-5 * max2(fabs(a), fabs(b)));
    assert_near(curvature[1], min2(fabs(a), fabs(b)), 1e-5 * max2(fabs(a), fabs(b)));
    assert_near(hypot(direction[0], direction[1]), 1, 1e-14);
    if (fabs(fabs(a) - fabs(b)) < 1e-9) return; /* any direction is principal */
    mad3(turned, direction[0], plane.u);
    mad3(turned, direction[1], plane.v);
    assert_near(fabs(dot3(turned, axes[fabs(a) > fabs(b) ? 0 : 1])), 1, 1e-9);
}

static void test_curvature(void **state) {
    (void)state;
    uint64_t random = 9;
    for (int turn = 0; turn < 20; ++turn) {
        check_quadric(2, 0, &random);  /* cylinder */
        check_quadric(0, -2, &random); /* cylinder from inside */
        check_quadric(3, 3, &random);  /* sphere */
        check_quadric(3, -1, &random); /* saddles */
        check_quadric(1, -3, &random);
        check_quadric(0.5, 1.5, &random); /* both curvatures of one sign */
        check_quadric(-0.5, -1.5, &random);
    }
}

/* A cylinder and a sphere of radius 2, over a piece of a tenth. */
static void test_round(void **state) {
    (void)state;
    for (int sphere = 0; sphere < 2; ++sphere) {
        psplat_covariance c = {0};
        psplat_plane plane;
        double direction[2], curvature[2];
        for (int i = -10; i <= 10; ++i)
            for (int k = -10; k <= 10; ++k) {
                double x = 0.01 * i, y = 0.01 * k, z = sqrt(4 - x * x - sphere * y * y);
                double p[3] = {x, y, z - 2}, n[3] = {x / 2, sphere * y / 2, z / 2};
                psplat_covariance_add(&c, p, n);
            }
        psplat_covariance_fit(&c, &plane);
        assert_int_equal(psplat_covariance_curvature(&c, &plane, direction, curvature), 1);
        /* The mean normal is shorter than 1 by about (0.1 / 2)^2 / 6. */
        assert_near(curvature[0], 0.5, 1e-3);
        assert_near(curvature[1], sphere ? 0.5 : 0, 1e-3);
        if (sphere) continue;
        double across = direction[0] * plane.u[0] + direction[1] * plane.v[0];
        assert_near(fabs(across), 1, 1e-12);
    }
}

/* A plane, a row and a single sample have no curvature direction. */
static void test_no_curvature(void **state) {
    (void)state;
    psplat_covariance flat = {0}, row = {0}, one = {0};
    psplat_plane plane;
    double direction[2], curvature[2];
    for (int i = 0; i < 16; ++i) {
        double p[3] = {i % 4, i / 4, 0}, n[3] = {0, 0, 1}, bent[3] = {0.01 * (i % 4), 0, 1};
        normalize3(bent);
        psplat_covariance_add(&flat, p, n);
        if (i < 4) psplat_covariance_add(&row, p, bent);
        if (i < 1) psplat_covariance_add(&one, p, n);
    }
    psplat_covariance *all[3] = {&flat, &row, &one};
    for (int i = 0; i < 3; ++i) {
        psplat_covariance_fit(all[i], &plane);
        assert_int_equal(psplat_covariance_curvature(all[i], &plane, direction, curvature), 0);
    }
}

int test_covariance_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plane),        cmocka_unit_test(test_noisy_plane),
        cmocka_unit_test(test_few),          cmocka_unit_test(test_normals_overrule),
        cmocka_unit_test(test_union),        cmocka_unit_test(test_move),
        cmocka_unit_test(test_curvature),    cmocka_unit_test(test_round),
        cmocka_unit_test(test_no_curvature),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
