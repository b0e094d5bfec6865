/* SPDX-License-Identifier: MIT
 *
 * test_ray_meeting.c - tests of where rays meet the fronts of flat and curved splats, of whether
 * the mesh lets them pass, and of whether they see a point inside its outline. Answers are known
 * from the shapes: a disc, a paraboloid, a square.
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
#include "base/angle.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "measure/ray_meeting.h"
#include "mesh/distance.h"

static const double rounding = 1e-12; /* of lengths near 1 */

/* Returns a disc of radius 1 in the plane z = 0, bent by these second derivatives. */
static psplat_region disc(double along_x, double along_y) {
    return (psplat_region){.u = {1, 0, 0},
                           .v = {0, 1, 0},
                           .n = {0, 0, 1},
                           .radius = {1, 1},
                           .hessian = {along_x, 0, along_y}};
}

/* Returns a sight from a point towards (sine, 0, cosine). */
static psplat_sight sight_from(double x, double y, double z, double cosine) {
    return (psplat_sight){{x, y, z}, {sqrt(1 - cosine * cosine), 0, cosine}};
}

/* A slanted ray meets a disc that lies lower farther back, by the step times the tangent. */
static void test_flat(void **state) {
    (void)state;
    psplat_region low = disc(0, 0);
    for (int i = 1; i <= 5; ++i) {
        double height, uv[2], cosine = 0.2 * i, step = 0.1;
        double slant = sqrt(1 - cosine * cosine) / cosine;
        psplat_sight sight = sight_from(0.25, 0.5, step, cosine);
        assert_int_equal(psplat_sight_meets(&sight, &low, 0, 0, &height, uv), 1);
        assert_near(height, -step / cosine, rounding);
        assert_near(uv[0], 0.25 - step * slant, rounding);
        assert_near(uv[1], 0.5, rounding);
        sight.point[0] = -0.999 + step * slant, sight.point[1] = 0;
        assert_int_equal(psplat_sight_meets(&sight, &low, 0, 0, &height, uv), 1);
        sight.point[0] = -1.001 + step * slant;
        assert_int_equal(psplat_sight_meets(&sight, &low, 0, 0, &height, uv), 0);
        assert_int_equal(psplat_sight_meets(&sight, &low, 0, 0.002, &height, uv), 1);
        assert_int_equal(psplat_sight_leaves(&sight, &low, &height, uv), 1);
        assert_near(uv[0], -1.001, rounding);
        sight.direction[2] = -cosine; /* The back is not seen. */
        assert_int_equal(psplat_sight_leaves(&sight, &low, &height, uv), 0);
    }
}

static void test_lines(void **state) {
    (void)state;
    psplat_region half = disc(0, 0);
    double height, uv[2];
    half.line_count = 1;
    half.lines[0][0] = 1, half.lines[0][2] = -0.25; /* It keeps u >= 1 / 4. */
    psplat_sight sight = sight_from(0.3, 0, 0, 1);
    assert_int_equal(psplat_sight_meets(&sight, &half, 0, 0, &height, uv), 1);
    sight.point[0] = 0.2;
    assert_int_equal(psplat_sight_meets(&sight, &half, 0, 0, &height, uv), 0);
    assert_int_equal(psplat_sight_meets(&sight, &half, 0, 0.06, &height, uv), 1);
}

/* Of the two places where a line meets a bowl or a hill, the front is the one at which it comes out
 * of the side of the normal. */
static void test_curved(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2)
        for (int i = 1; i <= 9; ++i) {
            psplat_region bent = disc(sign, 0.5);
            double height, uv[2], q[3], normal[3], cosine = 0.1 * i;
            psplat_sight sight = sight_from(0.1, -0.2, sign * 0.02, cosine);
            if (!psplat_sight_leaves(&sight, &bent, &height, uv)) continue;
            along3(q, sight.point, height, sight.direction);
            assert_near(q[2], (sign * q[0] * q[0] + 0.5 * q[1] * q[1]) / 2, 1e-10);
            assert_near(uv[0], q[0], rounding);
            psplat_region_normal(&bent, uv, normal);
            assert_true(dot3(normal, sight.direction) > 0);
        }
    /* A ray that is level with the top of a hill passes above it, and one below leaves its front
     * where it falls: x^2 / 2 = 0.02. */
    psplat_region hill = disc(-1, 0);
    double height, uv[2];
    psplat_sight level = sight_from(0, 0, 0.001, 0);
    assert_int_equal(psplat_sight_leaves(&level, &hill, &height, uv), 0);
    level.point[2] = -0.02;
    assert_int_equal(psplat_sight_leaves(&level, &hill, &height, uv), 1);
    assert_near(uv[0], 0.2, rounding);
}

/* Returns a random region of radii near 1, with up to two lines, bent or not. */
static psplat_region random_region(uint64_t *random, int curved) {
    psplat_region r = disc(0, 0);
    for (int k = 0; k < 2; ++k) r.radius[k] = 0.5 + psplat_random_unit(random);
    for (int k = 0; curved && k < 3; ++k) r.hessian[k] = 0.6 * (psplat_random_unit(random) - 0.5);
    for (int k = 0; curved && k < 2; ++k) r.slope[k] = 0.4 * (psplat_random_unit(random) - 0.5);
    r.line_count = (uint32_t)(3 * psplat_random_unit(random));
    for (uint32_t i = 0; i < r.line_count; ++i) {
        double angle = 2 * PSPLAT_PI * psplat_random_unit(random);
        r.lines[i][0] = cos(angle), r.lines[i][1] = sin(angle);
        r.lines[i][2] = 0.2 + 0.5 * psplat_random_unit(random);
        r.bends[i] = curved ? 2 * (psplat_random_unit(random) - 0.5) : 0;
    }
    return r;
}

/* Returns the height of a point over a region's surface, and its parameters. */
static double height_over(const psplat_region *r, const double p[3], double uvh[3]) {
    double d[3];
    sub3(d, p, r->center);
    uvh[0] = dot3(d, r->u) / r->radius[0], uvh[1] = dot3(d, r->v) / r->radius[1];
    return dot3(d, r->n) - psplat_region_height(r, uvh);
}

/* A ray that leaves the cylinder of the rim at a known point meets the wall where that is under the
 * rim, not too deep, kept by the lines, and looked down on: a little farther on it is higher. */
static void test_walls(void **state) {
    (void)state;
    enum { TRIALS = 20000 };
    const double wall = 0.1, step = 1e-7;
    uint64_t random = 5;
    int met = 0;
    for (int trial = 0; trial < TRIALS; ++trial) {
        psplat_region r = random_region(&random, 1);
        double angle = 2 * PSPLAT_PI * psplat_random_unit(&random), found, uv[2], uvh[3];
        double on_rim[2] = {cos(angle), sin(angle)}, p[3], q[3], length = 0;
        double deep = wall * (1.5 * psplat_random_unit(&random) - 0.25);
        double way = 3 * (psplat_random_unit(&random) - 0.5);
        psplat_sight sight;
        psplat_region_point(&r, on_rim, p);
        mad3(p, -deep, r.n);
        for (int k = 0; k < 3; ++k) sight.direction[k] = 2 * psplat_random_unit(&random) - 1;
        length = normalize3(sight.direction);
        if (!(length > 0.01)) continue;
        along3(sight.point, p, -way, sight.direction);
        along3(q, p, step, sight.direction);
        double rise = height_over(&r, q, uvh) + deep;
        double leaves = hypot(uvh[0], uvh[1]) - 1;
        int expected = deep > 0 && deep < wall && rise > 0 && leaves > 0 &&
                       psplat_region_contains(&r, on_rim, 1.001, 0);
        /* Too near to tell. */
        if (fabs(rise) < 1e-3 * step || fabs(leaves) < 1e-3 * step || fabs(deep) < 1e-9) continue;
        int is_met = psplat_sight_meets_wall(&sight, &r, wall, &found, uv);
        /* A ray that only enters at the point may leave on the wall elsewhere. */
        if (leaves > 0) assert_int_equal(is_met, expected);
        assert_int_equal(psplat_sight_meets_wall(&sight, &r, 0, &found, uv), 0);
        if (!expected) continue;
        ++met;
        assert_int_equal(psplat_sight_meets(&sight, &r, wall, 0, &found, uv), 1);
        if (psplat_sight_meets(&sight, &r, 0, 0, &found, uv))
            continue; /* it meets the front, too */
        assert_int_equal(psplat_sight_meets(&sight, &r, wall, 0, &found, uv), 1);
        assert_near(found, way, 1e-9);
        for (int k = 0; k < 2; ++k) assert_near(uv[k], on_rim[k], 1e-9);
    }
    print_message("%d rays meet walls\n", met);
    assert_true(met > 1000);
    psplat_region flat = disc(0, 0); /* has no wall */
    psplat_sight sight = sight_from(1, 0, -wall / 2, 0.5);
    double found, uv[2];
    assert_int_equal(psplat_sight_meets_wall(&sight, &flat, wall, &found, uv), 0);
}

/* Returns a sight through a point with this cosine to a normal. */
static psplat_sight slanted(const double point[3], const double normal[3], double cosine,
                            double angle) {
    psplat_sight sight = {{point[0], point[1], point[2]}, {0, 0, 0}};
    double u[3], v[3], sine = sqrt(max2(1 - cosine * cosine, 0));
    perpendicular3(u, normal);
    cross3(v, normal, u);
    mad3(sight.direction, cosine, normal);
    mad3(sight.direction, sine * cos(angle), u);
    mad3(sight.direction, sine * sin(angle), v);
    return sight;
}

/* Every ray of a cone that the bound accepts meets the splat, those of its side, too; and the bound
 * accepts most cones that do. */
static void test_cones(void **state) {
    (void)state;
    enum { TRIALS = 20000, AROUND = 16, RINGS = 4 };
    static const psplat_sight_cone cones[2] = {{0.2, 0.97979589711327124}, {0.6, 0.8}};
    const double tolerance = 0.05;
    uint64_t random = 11;
    int accepted[2] = {0, 0}, met[2] = {0, 0};
    for (int trial = 0; trial < TRIALS; ++trial) {
        psplat_region r = random_region(&random, trial % 2);
        double uv[2], point[3], normal[3], angle = 2 * PSPLAT_PI * psplat_random_unit(&random);
        double tilt = 0.15 * psplat_random_unit(&random), n[3];
        for (int k = 0; k < 2; ++k) uv[k] = 2 * psplat_random_unit(&random) - 1;
        psplat_region_point(&r, uv, point);
        psplat_region_normal(&r, uv, n);
        mad3(point, 2.2 * tolerance * (psplat_random_unit(&random) - 0.5), n);
        memcpy(normal, slanted(point, n, cos(tilt), angle).direction, sizeof normal);
        int first =
            psplat_sight_cones_meet(&r, psplat_region_bend(&r), point, normal, tolerance, cones, 2);
        for (int k = 0; k < 2; ++k) {
            int all = 1;
            for (int i = 0; i < AROUND * RINGS; ++i) {
                double cosine = cones[k].cosine + (1 - cones[k].cosine) * (i / AROUND) / RINGS;
                double height;
                psplat_sight sight = slanted(point, normal, cosine, 2 * PSPLAT_PI * i / AROUND);
                all &= psplat_sight_meets(&sight, &r, 0, 0, &height, uv) &&
                       fabs(height) * cosine <= tolerance;
            }
            accepted[k] += first <= k, met[k] += all;
            if (first <= k) assert_true(all);
        }
    }
    print_message("%d of %d and %d of %d cones accepted\n", accepted[0], met[0], accepted[1],
                  met[1]);
    assert_true(accepted[0] > 1000 && accepted[0] > 0.6 * met[0]);
    assert_true(accepted[1] > 1000 && accepted[1] > 0.8 * met[1]);
}

static void place_square(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* The square 0 <= x, y <= 1 hides what lies behind it, and not itself. */
static void test_free_way(void **state) {
    (void)state;
    fixture f;
    int is_free;
    fixture_grid(&f, 2, 2, place_square);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    for (int side = -1; side <= 1; side += 2) { /* Backs hide as fronts do. */
        const psplat_sight hidden = {{0.3, 0.4, -0.1 * side}, {0, 0, side}};
        assert_int_equal(psplat_sight_is_free(&hidden, distance, 2, &is_free), PSPLAT_OK);
        assert_int_equal(is_free, 0);
        const psplat_sight beside = {{1.3, 0.4, -0.1 * side}, {0, 0, side}};
        assert_int_equal(psplat_sight_is_free(&beside, distance, 2, &is_free), PSPLAT_OK);
        assert_int_equal(is_free, 1);
        const psplat_sight itself = {{0.3, 0.4, 0}, {0, 0, side}};
        assert_int_equal(psplat_sight_is_free(&itself, distance, 2, &is_free), PSPLAT_OK);
        assert_int_equal(is_free, 1);
    }
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

/* In a picture, seen at a cosine c from +x, a point is nearer to the border x = 0 of the square by
 * the factor c than on the square. */
static void test_inner(void **state) {
    (void)state;
    fixture f;
    const double up[3] = {0, 0, 1}, tolerance = 0.01;
    fixture_grid(&f, 2, 2, place_square);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    for (int i = 2; i <= 9; ++i)
        for (int inner = 0; inner < 2; ++inner) {
            double cosine = 0.1 * i, away = tolerance / cosine * (inner ? 1.01 : 0.99);
            int is_inner;
            psplat_sight sight = sight_from(away, 0.4, 0, cosine);
            assert_int_equal(
                psplat_sight_is_inner(&sight, up, cosine, distance, tolerance, &is_inner),
                PSPLAT_OK);
            assert_int_equal(is_inner, inner);
            sight.point[0] = 1 - away; /* The border that is nearer to the eye counts as well. */
            assert_int_equal(
                psplat_sight_is_inner(&sight, up, cosine, distance, tolerance, &is_inner),
                PSPLAT_OK);
            assert_int_equal(is_inner, inner);
        }
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

int test_ray_meeting_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat),  cmocka_unit_test(test_lines), cmocka_unit_test(test_curved),
        cmocka_unit_test(test_walls), cmocka_unit_test(test_cones), cmocka_unit_test(test_free_way),
        cmocka_unit_test(test_inner),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
