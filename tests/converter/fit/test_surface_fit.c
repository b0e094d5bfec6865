/* SPDX-License-Identifier: MIT
 *
 * test_surface_fit.c - tests of fitting a splat's curved surface to samples of known surfaces:
 * paraboloids and saddles, which are found exactly, a sphere, whose third-order error is known, too
 * few samples, noise, and the same samples at other scales and places.
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
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "fit/surface_fit.h"

enum { MOST = 400 };

/* A surface z = (A x^2 + 2 B x y + C y^2) / 2 in a frame, and samples of it. */
typedef struct quadric {
    double center[3], axes[3][3], hessian[3];
} quadric;

/* Returns a number between -1 and 1. */
static double signed_unit(uint64_t *random) {
    return 2 * psplat_random_unit(random) - 1;
}

/* A quadric whose slope is at most `slope` at distance 1 from its centre. */
static quadric random_quadric(uint64_t *random, double slope) {
    quadric q;
    random_axes(random, q.axes[0], q.axes[1], q.axes[2]);
    for (int k = 0; k < 3; ++k) q.center[k] = 4 * signed_unit(random);
    for (int k = 0; k < 3; ++k) q.hessian[k] = slope / 2 * signed_unit(random);
    return q;
}

/* Stores a point of a quadric and its normal there, relative to an origin. */
static psplat_near_sample quadric_sample(const quadric *q, double x, double y,
                                         const double origin[3]) {
    psplat_near_sample sample = {.index = 0};
    const double *h = q->hessian;
    double dx = h[0] * x + h[1] * y, dy = h[1] * x + h[2] * y;
    sub3(sample.p, q->center, origin);
    mad3(sample.p, x, q->axes[0]);
    mad3(sample.p, y, q->axes[1]);
    mad3(sample.p, (dx * x + dy * y) / 2, q->axes[2]);
    memcpy(sample.n, q->axes[2], sizeof sample.n);
    mad3(sample.n, -dx, q->axes[0]);
    mad3(sample.n, -dy, q->axes[1]);
    normalize3(sample.n);
    return sample;
}

/* Draws samples within a disc. */
static void draw(const quadric *q, uint64_t *random, double radius, const double origin[3],
                 size_t count, psplat_near_sample *samples) {
    for (size_t i = 0; i < count;) {
        double x = signed_unit(random), y = signed_unit(random);
        if (x * x + y * y > 1) continue;
        samples[i++] = quadric_sample(q, radius * x, radius * y, origin);
    }
}

/* A region at a quadric's centre whose frame is turned about its normal, and then tilted. */
static psplat_region start_region(const quadric *q, double turn, double tilt, double radius) {
    psplat_region r = {.radius = {radius, radius}};
    double u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
    mad3(u, cos(turn), q->axes[0]);
    mad3(u, sin(turn), q->axes[1]);
    cross3(v, q->axes[2], u);
    memcpy(r.center, q->center, sizeof r.center);
    memcpy(r.v, v, sizeof v);
    mad3(r.u, cos(tilt), u);
    mad3(r.u, sin(tilt), q->axes[2]);
    cross3(r.n, r.u, r.v);
    return r;
}

/* Asserts that axes are orthonormal and right-handed. */
static void check_frame(const psplat_region *r) {
    double cross[3];
    cross3(cross, r->u, r->v);
    assert_near(length3(r->u), 1, 1e-12);
    assert_near(length3(r->v), 1, 1e-12);
    assert_near(dot3(r->u, r->v), 0, 1e-12);
    for (int k = 0; k < 3; ++k) assert_near(cross[k], r->n[k], 1e-12);
}

/* Returns how far a region's surface is from samples at most, along its normal. */
static double farthest(const psplat_region *r, const psplat_near_sample *samples, size_t count,
                       const double origin[3]) {
    double greatest = 0;
    for (size_t i = 0; i < count; ++i) {
        double d[3], uv[2];
        for (int k = 0; k < 3; ++k) d[k] = samples[i].p[k] + origin[k] - r->center[k];
        for (int k = 0; k < 2; ++k) uv[k] = dot3(d, k ? r->v : r->u) / r->radius[k];
        greatest = max2(greatest, fabs(dot3(d, r->n) - psplat_region_height(r, uv)));
    }
    return greatest;
}

/* ---- exact fits ------------------------------------------------------------------------------ */

/* Paraboloids, cylinders and saddles of any size are found as they are from the frame of their
 * vertex, whatever its turn about the normal. */
static void test_paraboloids(void **state) {
    (void)state;
    uint64_t random = 3;
    psplat_near_sample samples[MOST];
    for (int trial = 0; trial < 200; ++trial) {
        quadric q = random_quadric(&random, 2);
        size_t count = 12 + (size_t)trial;
        draw(&q, &random, 1, q.center, count, samples);
        psplat_region r = start_region(&q, 6 * psplat_random_unit(&random), 0, 1);
        /* a height that is off is found, too */
        mad3(r.center, 0.1 * signed_unit(&random), r.n);
        assert_int_equal(psplat_fit_surface(samples, NULL, count, q.center, HUGE_VAL, &r), 1);
        check_frame(&r);
        /* What the diagonal adds, 1e-9 of the trace, is some 1e-7 of the greatest heights, 1. */
        assert_true(farthest(&r, samples, count, q.center) < 1e-6);
        for (int k = 0; k < 2; ++k) assert_near(r.slope[k], 0, 0);
        for (int k = 0; k < 3; ++k) assert_near(r.n[k], q.axes[2][k], 1e-6);
        assert_near(r.hessian[0] + r.hessian[2], q.hessian[0] + q.hessian[2], 1e-5);
        assert_near(r.hessian[0] * r.hessian[2] - r.hessian[1] * r.hessian[1],
                    q.hessian[0] * q.hessian[2] - q.hessian[1] * q.hessian[1], 1e-5);
    }
}

/* From a tilted frame the surface is the same to the third order: a paraboloid seen from aside is
 * no height of the second order. Its second derivative h over a radius r leaves (h r)^2 h r^2 / 2
 * at most, and the frame ends up within the slope (h r)^2 of the tangent plane. */
static void test_tilted(void **state) {
    (void)state;
    uint64_t random = 4;
    psplat_near_sample samples[MOST];
    for (int trial = 0; trial < 200; ++trial) {
        double bend = 0.02 + 0.2 * psplat_random_unit(&random), most, tilt;
        quadric q = random_quadric(&random, 2 * bend);
        draw(&q, &random, 1, q.center, MOST, samples);
        tilt = fixture_pi / 3 * (trial + 1) / 200; /* up to 60 degrees */
        psplat_region r = start_region(&q, 6 * psplat_random_unit(&random), tilt, 1);
        assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &r), 1);
        check_frame(&r);
        most = pow(2 * bend, 3) / 2;
        assert_true(farthest(&r, samples, MOST, q.center) < most + 1e-6);
        assert_true(dot3(r.n, q.axes[2]) > cos(4 * bend * bend + 1e-3));
        /* the centre moves along normals, which stay within the tilt, so little at all */
        assert_true(distance2_3(r.center, q.center) < most * most + 1e-10);
    }
}

/* Only the samples named by their indices count. */
static void test_some(void **state) {
    (void)state;
    uint64_t random = 5;
    psplat_near_sample samples[MOST];
    uint32_t some[MOST / 2];
    quadric q = random_quadric(&random, 1);
    draw(&q, &random, 1, q.center, MOST, samples);
    for (uint32_t i = 0; i < MOST; ++i)
        if (i % 2)
            some[i / 2] = i;
        else
            mad3(samples[i].p, 5, q.axes[2]);
    psplat_region r = start_region(&q, 1, 0, 1);
    assert_int_equal(psplat_fit_surface(samples, some, MOST / 2, q.center, HUGE_VAL, &r), 1);
    for (int k = 0; k < 3; ++k) assert_near(r.center[k], q.center[k], 1e-6);
    for (int k = 0; k < 3; ++k) assert_near(r.n[k], q.axes[2][k], 1e-6);
}

/* Over a cap of a unit sphere the paraboloid leaves an error of the fourth order: with h = 1 - cos,
 * x^2 / 2 + x^4 / 8 less its best quadric, which is within x^4 / 32. The exact height is
 * 1 - sqrt(1 - x^2). */
static void test_sphere(void **state) {
    (void)state;
    uint64_t random = 6;
    psplat_near_sample samples[MOST];
    const double origin[3] = {0, 0, 0}, radii[] = {0.1, 0.2, 0.4};
    for (size_t c = 0; c < sizeof radii / sizeof *radii; ++c) {
        for (size_t i = 0; i < MOST;) {
            double x = radii[c] * signed_unit(&random), y = radii[c] * signed_unit(&random);
            if (x * x + y * y > radii[c] * radii[c]) continue;
            const double p[3] = {x, y, sqrt(1 - x * x - y * y)};
            memcpy(samples[i].p, p, sizeof p);
            memcpy(samples[i++].n, p, sizeof p);
        }
        psplat_region r = {.center = {0, 0, 1},
                           .u = {1, 0, 0},
                           .v = {0, 1, 0},
                           .n = {0, 0, 1},
                           .radius = {radii[c], radii[c]}};
        assert_int_equal(psplat_fit_surface(samples, NULL, MOST, origin, HUGE_VAL, &r), 1);
        double x2 = radii[c] * radii[c], most = x2 * x2 / 8;
        /* Least squares leave up to twice of what the best of all would; 1.3 is for the sixth
         * order. */
        assert_true(farthest(&r, samples, MOST, origin) < 1.3 * most / 2);
        assert_near(r.hessian[0], -1 - x2 / 2, x2);
        assert_near(r.hessian[2], -1 - x2 / 2, x2);
        assert_near(r.hessian[1], 0, 0.1 * x2);
    }
}

/* ---- few samples ----------------------------------------------------------------------------- */

/* A single sample, two, or a row have a surface too, which goes through them, along their normals
 * where these say how it goes on. With two samples heights and slopes are a compromise. */
static void test_few(void **state) {
    (void)state;
    uint64_t random = 7;
    psplat_near_sample samples[MOST];
    for (int trial = 0; trial < 200; ++trial) {
        quadric q = random_quadric(&random, 1);
        double turn = 6 * psplat_random_unit(&random);
        size_t count = 1 + (size_t)trial % 5;
        for (size_t i = 0; i < count; ++i) {
            double at = count > 1 ? -1 + 2 * (double)i / (double)(count - 1) : 0;
            samples[i] = quadric_sample(&q, at * cos(turn), at * sin(turn), q.center);
        }
        psplat_region r = start_region(&q, 0, 0, 1);
        assert_int_equal(psplat_fit_surface(samples, NULL, count, q.center, HUGE_VAL, &r), 1);
        check_frame(&r);
        for (int k = 0; k < 3; ++k) assert_true(isfinite(r.hessian[k]) && isfinite(r.center[k]));
        assert_true(farthest(&r, samples, count, q.center) < 1e-5);
        if (count == 1)
            for (int k = 0; k < 3; ++k) assert_near(r.hessian[k], 0, 1e-6);
        for (int k = 0; k < 3; ++k) assert_near(r.n[k], q.axes[2][k], 1e-4);
        /* Normals along a row tell the second derivatives but for that across it. */
        if (count > 2) {
            double x = cos(turn), y = sin(turn), along[2] = {0, 0}, wanted[2];
            const double dirs[2][2] = {{x, y}, {-y, x}};
            for (int k = 0; k < 2; ++k) {
                const double *d = dirs[k], *h = r.hessian, *w = q.hessian;
                along[k] = h[0] * x * d[0] + h[1] * (x * d[1] + y * d[0]) + h[2] * y * d[1];
                wanted[k] = w[0] * x * d[0] + w[1] * (x * d[1] + y * d[0]) + w[2] * y * d[1];
            }
            for (int k = 0; k < 2; ++k) assert_near(along[k], wanted[k], 1e-4);
        }
    }
}

/* Noise of the heights moves the surface by no more than the noise, and mostly by far less. */
static void test_noise(void **state) {
    (void)state;
    uint64_t random = 8;
    psplat_near_sample samples[MOST], exact[MOST];
    for (int trial = 0; trial < 50; ++trial) {
        quadric q = random_quadric(&random, 0.5);
        const double noise = 0.01;
        draw(&q, &random, 1, q.center, MOST, samples);
        memcpy(exact, samples, sizeof exact);
        for (int i = 0; i < MOST; ++i) mad3(samples[i].p, noise * signed_unit(&random), q.axes[2]);
        psplat_region r = start_region(&q, 0, 0, 1);
        assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &r), 1);
        /* Six unknowns of 400 equations: a standard deviation of 0.58 noise * sqrt(6 / 400) in the
         * mean, here times 7 for the rim of the worst of 50. */
        assert_true(farthest(&r, exact, MOST, q.center) < 0.5 * noise);
    }
}

/* ---- scale and place ------------------------------------------------------------------------- */

/* Neither the size nor the place of samples changes the surface, to nine digits. Positions are
 * relative to an origin nearby, so that offsets cost only what the centre's own rounding does. */
static void test_scale_and_place(void **state) {
    (void)state;
    static const struct {
        double scale, offset, slack;
    } cases[] = {{1e-9, 0, 1e-9},
                 {1e-3, 0, 1e-9},
                 {1e9, 0, 1e-9},
                 {1, 1e6, 1e-8} /* of 1e6, a double holds 1e-10 */};
    uint64_t random = 9;
    for (int trial = 0; trial < 20; ++trial) {
        const quadric q = random_quadric(&random, 1);
        psplat_near_sample samples[MOST], changed[MOST];
        double tilt = 0.5 * psplat_random_unit(&random);
        draw(&q, &random, 1, q.center, MOST, samples);
        psplat_region first = start_region(&q, 1, tilt, 1);
        assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &first), 1);
        for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
            double scale = cases[c].scale, slack = cases[c].slack, origin[3];
            psplat_region r = start_region(&q, 1, tilt, scale);
            memcpy(changed, samples, sizeof changed);
            for (int i = 0; i < MOST; ++i)
                for (int k = 0; k < 3; ++k) changed[i].p[k] *= scale;
            for (int k = 0; k < 3; ++k) {
                origin[k] = q.center[k] * scale + cases[c].offset;
                r.center[k] = origin[k];
            }
            assert_int_equal(psplat_fit_surface(changed, NULL, MOST, origin, HUGE_VAL, &r), 1);
            for (int k = 0; k < 3; ++k) {
                assert_near(r.n[k], first.n[k], slack);
                assert_near(r.u[k], first.u[k], slack);
                assert_near(r.hessian[k] * scale, first.hessian[k], slack);
                assert_near((r.center[k] - origin[k]) / scale, first.center[k] - q.center[k],
                            slack);
            }
        }
    }
}

/* ---- bounds ---------------------------------------------------------------------------------- */

/* A frame that is steeper than 3 against the surface is refused, and the region is flat. */
static void test_steep(void **state) {
    (void)state;
    uint64_t random = 10;
    psplat_near_sample samples[MOST];
    quadric q = random_quadric(&random, 0);
    for (int steep = 0; steep < 2; ++steep) {
        draw(&q, &random, 1, q.center, MOST, samples);
        psplat_region r = start_region(&q, 0, atan(steep ? 3.3 : 2.7), 1);
        for (int k = 0; k < 3; ++k) r.hessian[k] = r.slope[k % 2] = 7; /* what it had before */
        assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &r), !steep);
        assert_int_equal(psplat_region_is_curved(&r) && steep, 0);
        if (!steep) assert_near(fabs(dot3(r.n, q.axes[2])), 1, 1e-9);
    }
}

/* The sagitta is that along the direction in which the surface is bent most, over the larger
 * radius; the bound of slopes is at least every slope in the ellipse and at most sqrt(2) of the
 * greatest. */
static void test_bounds(void **state) {
    (void)state;
    uint64_t random = 11;
    for (int trial = 0; trial < 200; ++trial) {
        psplat_region r = {.radius = {1 + psplat_random_unit(&random), 1}};
        r.radius[1] = r.radius[0] * psplat_random_unit(&random);
        for (int k = 0; k < 3; ++k) r.hessian[k] = signed_unit(&random);
        for (int k = 0; k < 2; ++k) r.slope[k] = trial % 2 * signed_unit(&random);
        double greatest = 0, deepest = 0, bound = psplat_surface_slope_bound(&r);
        for (int i = 0; i < 720; ++i) {
            double x = cos(fixture_pi * i / 360), y = sin(fixture_pi * i / 360), slope[2];
            const double uv[2] = {x, y}, *h = r.hessian;
            psplat_region_slope(&r, uv, slope);
            greatest = max2(greatest, hypot(slope[0], slope[1]));
            deepest = max2(deepest, fabs(h[0] * x * x + 2 * h[1] * x * y + h[2] * y * y) / 2);
        }
        assert_true(bound >= greatest * (1 - 1e-12));
        if (trial % 2 == 0) assert_true(bound <= sqrt(2) * greatest * (1 + 1e-4));
        deepest *= r.radius[0] * r.radius[0];
        assert_near(psplat_surface_sagitta(&r), deepest, 1e-4 * deepest); /* 720 directions */
    }
}

/* A side of a box with smooth normals is a plane, though its normals are those of a ball. A surface
 * that has the normals it is given stays as it is, to the last bit. */
static void test_authored_normals(void **state) {
    (void)state;
    uint64_t random = 17;
    psplat_near_sample samples[MOST];
    quadric q = random_quadric(&random, 2);
    q.hessian[0] = q.hessian[1] = q.hessian[2] = 0;
    draw(&q, &random, 1, q.center, MOST, samples);
    for (size_t i = 0; i < MOST; ++i) {
        mad3(samples[i].n, 1, samples[i].p);
        normalize3(samples[i].n);
    }
    psplat_region r = start_region(&q, 1, 0.2, 1), other = r;
    assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &r), 1);
    assert_true(farthest(&r, samples, MOST, q.center) > 0.05);
    assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, 0.02, &other), 1);
    assert_true(farthest(&other, samples, MOST, q.center) < 1e-4);
    q = random_quadric(&random, 0.5);
    draw(&q, &random, 1, q.center, MOST, samples);
    r = other = start_region(&q, 1, 0.2, 1);
    assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, HUGE_VAL, &r), 1);
    assert_int_equal(psplat_fit_surface(samples, NULL, MOST, q.center, 0.02, &other), 1);
    assert_memory_equal(&r, &other, sizeof r);
}

int test_surface_fit_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_authored_normals),
        cmocka_unit_test(test_paraboloids),
        cmocka_unit_test(test_tilted),
        cmocka_unit_test(test_some),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_few),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_scale_and_place),
        cmocka_unit_test(test_steep),
        cmocka_unit_test(test_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
