/* SPDX-License-Identifier: MIT
 *
 * test_region.c - tests of regions (ellipses cut by clip lines): which points they contain, their
 * outlines and areas, points spread over them, and whether they are near a mesh. Expected values
 * are exact areas and distances.
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
#include "fit/region_near.h"
#include "mesh/distance.h"

static psplat_region level_region(double x, double y, double z, double ru, double rv) {
    return (psplat_region){
        .center = {x, y, z}, .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* ---- outlines -------------------------------------------------------------------------------- */

static double area_of(double (*polygon)[2], size_t count) {
    double twice = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[(i + 1) % count];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2;
}

static void test_polygon(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 2, 1);
    double polygon[68][2];
    for (int inscribed = 0; inscribed < 2; ++inscribed) {
        size_t count = psplat_region_polygon(&r, inscribed, polygon, 68);
        assert_int_equal(count, 64);
        double angle = fixture_pi / 64;
        double area = 64 * (inscribed ? sin(angle) * cos(angle) : tan(angle));
        assert_near(area_of(polygon, count), area, 1e-12);
    }
    r.line_count = 2; /* a quarter of the ellipse */
    r.lines[0][0] = 1, r.lines[1][1] = 1;
    size_t count = psplat_region_polygon(&r, 1, polygon, 68);
    assert_near(area_of(polygon, count), 8 * sin(fixture_pi / 32), 1e-12);
    r.lines[1][2] = -1.5; /* nothing is left */
    assert_int_equal(psplat_region_polygon(&r, 0, polygon, 68), 0);
}

/* Areas of a whole ellipse, a half, a quarter, a thin strip, a square cut by four lines, and
 * nothing. The outline has 64 sides, and the area of that polygon is exact. */
static void test_area(void **state) {
    (void)state;
    uint64_t random = 14;
    for (int turn = 0; turn < 20; ++turn) {
        psplat_region r = level_region(1e3, -2e3, 5e2, 3, 0.5); /* The place does not matter. */
        random_axes(&random, r.u, r.v, r.n);
        double whole = 32 * sin(fixture_pi / 32) * 3 * 0.5;
        assert_near(psplat_region_area(&r), whole, 1e-12);
        assert_near(psplat_region_area(&r), fixture_pi * 1.5, 0.002 * fixture_pi * 1.5);
        double angle = fixture_pi / 32 * turn; /* The line goes through corners of the outline. */
        r.line_count = 1;
        r.lines[0][0] = -sin(angle), r.lines[0][1] = cos(angle);
        assert_near(psplat_region_area(&r), whole / 2, 1e-12);
        r.line_count = 2;
        r.lines[1][0] = cos(angle), r.lines[1][1] = sin(angle);
        assert_near(psplat_region_area(&r), whole / 4, 1e-12);
        r.lines[1][0] = sin(angle), r.lines[1][1] = -cos(angle), r.lines[1][2] = 0.01;
        /* Between corners the chord at 0.01 is shorter than 2 by 0.01^2 and by the polygon's
         * distance from the ellipse. */
        assert_near(psplat_region_area(&r), 2 * 0.01 * 1.5, 2e-3 * 0.03);
        r.lines[1][2] = -0.01; /* No point is on the inner side of both lines. */
        assert_near(psplat_region_area(&r), 0, 1e-15);
        r.line_count = 4;
        for (int i = 0; i < 4; ++i) {
            double side = angle + fixture_pi / 2 * i;
            r.lines[i][0] = cos(side), r.lines[i][1] = sin(side), r.lines[i][2] = 0.7;
        }
        assert_near(psplat_region_area(&r), 1.4 * 1.4 * 1.5, 1e-12);
    }
}

/* ---- points ---------------------------------------------------------------------------------- */

/* Returns a region anywhere in space, cut by lines that keep its centre. */
static psplat_region random_region(uint64_t *random, uint32_t line_count) {
    psplat_region r = {.radius = {2, 0.5}, .line_count = line_count};
    random_axes(random, r.u, r.v, r.n);
    for (int k = 0; k < 3; ++k) r.center[k] = 10 * psplat_random_unit(random);
    for (uint32_t i = 0; i < line_count; ++i) {
        double angle = 2 * fixture_pi * psplat_random_unit(random);
        r.lines[i][0] = cos(angle), r.lines[i][1] = sin(angle);
        r.lines[i][2] = 0.1 + psplat_random_unit(random);
    }
    return r;
}

static void test_local(void **state) {
    (void)state;
    uint64_t random = 6;
    for (int i = 0; i < 20; ++i) {
        psplat_region r = random_region(&random, 0);
        double p[3], uvh[3], u = psplat_random_unit(&random), v = -psplat_random_unit(&random);
        region_point(&r, u, v, 0.3, p);
        psplat_region_local(&r, p, uvh);
        /* Rounding of coordinates of 10 over a radius of a half. */
        assert_near(uvh[0], u, 1e-14);
        assert_near(uvh[1], v, 2e-14);
        assert_near(uvh[2], 0.3, 1e-14);
    }
}

static void test_contains(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 2, 1);
    r.line_count = 1; /* keeps u <= 0.5 */
    r.lines[0][0] = -1, r.lines[0][2] = 0.5;
    const struct {
        double uv[2], scale, slack;
        int inside;
    } cases[] = {
        {{0, 0}, 1, 0, 1},       {{0.5, 0}, 1, 0, 1},      {{0.51, 0}, 1, 0, 0},
        {{0.51, 0}, 1, 0.02, 1}, {{0, 1}, 1, 0, 1},        {{0, 1.01}, 1, 0.02, 0},
        {{0, 1.01}, 1.02, 0, 1}, {{-0.8, -0.61}, 1, 0, 0}, {{0, 0.6}, 0.5, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_int_equal(psplat_region_contains(&r, cases[i].uv, cases[i].scale, cases[i].slack) !=
                             0,
                         cases[i].inside);
}

/* Points lie in the region's plane and inside it. Some of them lie all along its outline, and one
 * is in the middle of what the lines leave, so that no gap is wider than half of the outline. */
static void test_points(void **state) {
    (void)state;
    uint64_t random = 12;
    for (uint32_t i = 0; i < 25; ++i) {
        psplat_region r = random_region(&random, i % (PSPLAT_MAX_CLIP_LINES + 1));
        double points[PSPLAT_REGION_POINTS][3], polygon[68][2];
        size_t count = psplat_region_points(&r, points);
        size_t corners = psplat_region_polygon(&r, 1, polygon, 68), met = 0;
        assert_true(count > corners && count <= PSPLAT_REGION_POINTS);
        for (size_t k = 0; k < count; ++k) {
            double uvh[3];
            psplat_region_local(&r, points[k], uvh);
            assert_near(uvh[2], 0, 1e-14); /* rounding of coordinates of 10 */
            assert_true(psplat_region_contains(&r, uvh, 1 + 1e-12, 1e-12));
            for (size_t c = 0; c < corners; ++c)
                met += hypot(uvh[0] - polygon[c][0], uvh[1] - polygon[c][1]) < 1e-12;
        }
        assert_true(met >= corners);
        double middle[3], uvh[3], mean[2] = {0, 0};
        memcpy(middle, points[count - 1], sizeof middle);
        psplat_region_local(&r, middle, uvh);
        for (size_t c = 0; c < corners; ++c)
            for (int k = 0; k < 2; ++k) mean[k] += polygon[c][k] / (double)corners;
        assert_near(hypot(uvh[0] - mean[0], uvh[1] - mean[1]), 0, 1e-12);
    }
    psplat_region r = level_region(0, 0, 0, 1, 1); /* Nothing is left of this region. */
    double points[PSPLAT_REGION_POINTS][3];
    r.line_count = 1;
    r.lines[0][0] = 1, r.lines[0][2] = -1.5;
    assert_int_equal(psplat_region_points(&r, points), 0);
}

/* Whether points are within a distance must agree with their distances, near the mesh and far from
 * it, and also at the distance itself up to rounding. */
static void place_bump(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0.3 * sin(5 * s) * cos(7 * t);
}

static int within(const psplat_distance *distance, const double *points, size_t count, double far) {
    int result = -1;
    assert_int_equal(psplat_distance_within(distance, points, count, far, &result), PSPLAT_OK);
    assert_in_range(result, 0, 1);
    return result;
}

static void test_within(void **state) {
    (void)state;
    enum { POINTS = 500 };
    fixture f;
    uint64_t random = 77;
    double points[3 * POINTS], far[POINTS], farthest = 0;
    fixture_grid(&f, 12, 12, place_bump);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    for (int i = 0; i < 3 * POINTS; ++i) points[i] = 5 * psplat_random_unit(&random) - 2.5;
    for (int i = 0; i < POINTS; ++i) points[3 * i + 2] *= i % 2 ? 0.2 : 1;
    assert_int_equal(psplat_distance_query(distance, points, POINTS, far), PSPLAT_OK);
    for (int i = 0; i < POINTS; ++i) {
        const double *p = points + 3 * i;
        farthest = max2(farthest, far[i]);
        for (int k = 0; k < 10; ++k) {
            double asked = 3 * psplat_random_unit(&random);
            assert_int_equal(within(distance, p, 1, asked), far[i] <= asked);
        }
        /* Nearest points are rounded by about 1e-16 of coordinates of 2. */
        assert_int_equal(within(distance, p, 1, far[i] + 1e-14), 1);
        assert_int_equal(within(distance, p, 1, far[i] - 1e-14), 0);
    }
    assert_int_equal(within(distance, points, POINTS, farthest + 1e-14), 1);
    assert_int_equal(within(distance, points, POINTS, farthest - 1e-14), 0);
    /* An empty set is within any distance. */
    assert_int_equal(within(distance, points, 0, 1e-3), 1);
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

/* A disc over a square is near while its height is at most the tolerance and its rim passes the
 * square's side by no more, unless a line cuts off what passes. */
static void test_near(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 3, 3, place_square);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    const struct {
        double x, height;
        int cut, near;
    } cases[] = {{0, 0.09, 0, 1}, {0, 0.11, 0, 0}, {1.09, 0, 0, 1},
                 {1.11, 0, 0, 0}, {1.5, 0, 0, 0},  {1.5, 0, 1, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_region r = level_region(cases[i].x, 0, cases[i].height, 1, 1);
        int near = -1;
        r.line_count = (uint32_t)cases[i].cut;
        r.lines[0][0] = -1, r.lines[0][2] = 0.5;
        assert_int_equal(psplat_region_near(&r, distance, 0.1, &near), PSPLAT_OK);
        assert_int_equal(near, cases[i].near);
        assert_int_equal(psplat_region_near(&r, NULL, 0.1, &near), PSPLAT_OK);
        assert_int_equal(near, 1);
    }
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

/* ---- curved surfaces ------------------------------------------------------------------------- */

/* Returns a random number of low ... high. */
static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

/* Returns a region anywhere whose surface has these curvatures along u and v, in one over lengths,
 * and slopes at its centre. */
static psplat_region curved_region(uint64_t *random, const double slope[2], double along,
                                   double across) {
    psplat_region r = random_region(random, 0);
    for (int k = 0; k < 2; ++k) r.slope[k] = slope[k];
    r.hessian[0] = along, r.hessian[2] = across;
    return r;
}

/* A paraboloid, a saddle, a cylinder and a tilted plane: heights s^2 a / 2 + t^2 b / 2 over a place
 * s, t, and normals perpendicular to differences of points. */
static void test_surface(void **state) {
    (void)state;
    uint64_t random = 15;
    const double shapes[][4] = {
        {0, 0, 0.5, 0.5}, {0, 0, 0.5, -0.5}, {0, 0, -0.8, 0}, {1, -2, 0, 0}, {0.3, 0.2, 1, -0.4}};
    for (int i = 0; i < 50; ++i) {
        const double *shape = shapes[i % 5];
        psplat_region r = curved_region(&random, shape, shape[2], shape[3]);
        double uv[2] = {between(&random, -1, 1), between(&random, -1, 1)}, p[3], q[3], n[3];
        double s = 2 * uv[0], t = 0.5 * uv[1], step = 1e-5, uvh[3];
        double height = shape[0] * s + shape[1] * t + (shape[2] * s * s + shape[3] * t * t) / 2;
        assert_true(psplat_region_is_curved(&r));
        assert_near(psplat_region_height(&r, uv), height, 1e-14);
        region_point(&r, uv[0], uv[1], height, q);
        psplat_region_point(&r, uv, p);
        for (int k = 0; k < 3; ++k) assert_near(p[k], q[k], 1e-14);
        psplat_region_normal(&r, uv, n);
        assert_near(length3(n), 1, 1e-14);
        assert_true(dot3(n, r.n) > 0);
        for (int k = 0; k < 2; ++k) {
            double ahead[2] = {uv[0], uv[1]}, behind[2] = {uv[0], uv[1]}, a[3], b[3], d[3];
            ahead[k] += step, behind[k] -= step;
            psplat_region_point(&r, ahead, a);
            psplat_region_point(&r, behind, b);
            sub3(d, a, b);
            assert_near(dot3(d, n), 0, 1e-13); /* rounding of coordinates of 10 */
        }
        psplat_region_local(&r, p, uvh);
        for (int k = 0; k < 2; ++k) assert_near(uvh[k], uv[k], 1e-13);
        assert_near(uvh[2], 0, 1e-13);
        assert_near(psplat_region_bend(&r), max2(fabs(shape[2]), fabs(shape[3])), 1e-15);
    }
}

/* The curvature of a saddle s t is 1 along both diagonals. */
static void test_bend(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 2, 1);
    r.hessian[1] = 1;
    assert_near(psplat_region_bend(&r), 1, 1e-15);
    assert_near(psplat_region_height(&r, (const double[]){0.5, 0.5}), 0.5, 1e-15);
    r.hessian[0] = 3, r.hessian[1] = 0, r.hessian[2] = -4;
    assert_near(psplat_region_bend(&r), 4, 1e-15);
    r.hessian[0] = r.hessian[2] = 1, r.hessian[1] = 0.5; /* eigenvalues 0.5 and 1.5 */
    assert_near(psplat_region_bend(&r), 1.5, 1e-15);
}

/* The height of a point that lies at a distance along the normal is that distance: exactly for
 * planes and where the slope is 0, and otherwise with an error of half of the second derivative
 * down the slope times the squared distance over (1 + slope^2)^(3/2), and higher orders. */
static void test_local_distance(void **state) {
    (void)state;
    uint64_t random = 16;
    for (int i = 0; i < 300; ++i) {
        const double slope[2] = {between(&random, -2, 2), between(&random, -2, 2)};
        double bend = i % 3 ? 0.5 : 0, p[3], n[3], uvh[3], distance = between(&random, -0.1, 0.1);
        psplat_region r = curved_region(&random, slope, bend * between(&random, -1, 1),
                                        bend * between(&random, -1, 1));
        double uv[2] = {between(&random, -0.5, 0.5), between(&random, -0.5, 0.5)}, at[2];
        psplat_region_point(&r, uv, p);
        psplat_region_normal(&r, uv, n);
        psplat_region_slope(&r, uv, at);
        mad3(p, distance, n);
        psplat_region_local(&r, p, uvh);
        double stretch = sqrt(1 + at[0] * at[0] + at[1] * at[1]);
        double down = r.hessian[0] * at[0] * at[0] + r.hessian[2] * at[1] * at[1];
        double error = down * distance * distance / (2 * stretch * stretch * stretch);
        assert_near(uvh[2], distance + error, 3 * bend * bend * pow(fabs(distance), 3) + 1e-13);
    }
}

/* The sphere around the centre holds all of the surface, and touches it where it is tilted. */
static void test_reach(void **state) {
    (void)state;
    uint64_t random = 17;
    for (int i = 0; i < 100; ++i) {
        const double slope[2] = {between(&random, -2, 2), between(&random, -2, 2)};
        psplat_region r =
            curved_region(&random, slope, between(&random, -1, 1), between(&random, -1, 1));
        r.hessian[1] = between(&random, -1, 1);
        double farthest = 0, reach = psplat_region_reach(&r);
        for (int k = 0; k < 400; ++k) {
            const double uv[2] = {cos(k * fixture_pi / 200), sin(k * fixture_pi / 200)};
            double p[3];
            psplat_region_point(&r, uv, p);
            farthest = max2(farthest, sqrt(distance2_3(p, r.center)));
        }
        assert_true(farthest <= reach && reach < 2 * farthest);
    }
    psplat_region flat = level_region(1, 2, 3, 2, 0.5);
    assert_near(psplat_region_reach(&flat), 2, 0);
    flat.slope[0] = 1;
    assert_near(psplat_region_reach(&flat), sqrt(8), 1e-14);
}

/* ---- bent lines ------------------------------------------------------------------------------ */

static psplat_region bent_region(uint64_t *random, uint32_t lines) {
    psplat_region r = level_region(0, 0, 0, 1, 1);
    r.line_count = lines;
    for (uint32_t i = 0; i < lines; ++i) {
        double angle = between(random, 0, 2 * fixture_pi), length = between(random, 0.8, 1.2);
        r.lines[i][0] = length * cos(angle), r.lines[i][1] = length * sin(angle);
        r.lines[i][2] = length * between(random, -0.3, 1.1);
        r.bends[i] = (i + lines) % 4 ? between(random, -4, 4) : 0;
    }
    return r;
}

/* A line's points have the value 0, and its value grows to the kept side. */
static void test_bent_lines(void **state) {
    (void)state;
    uint64_t random = 18;
    for (int i = 0; i < 100; ++i) {
        psplat_region r = bent_region(&random, 3);
        double m = between(&random, -1, 1), uv[2];
        psplat_region_line_point(&r, 1, m, uv);
        assert_near(psplat_region_line_value(&r, 1, uv), 0, 1e-14);
        for (int k = 0; k < 2; ++k) uv[k] += 0.01 * r.lines[1][k];
        double square = r.lines[1][0] * r.lines[1][0] + r.lines[1][1] * r.lines[1][1];
        assert_near(psplat_region_line_value(&r, 1, uv), 0.01 * square, 1e-14);
    }
    /* Curvature 2 about the vertex 0.5, 0: u >= 0.5 + v^2 is left of bend -2. */
    psplat_region r = level_region(0, 0, 0, 1, 1);
    r.line_count = 1, r.lines[0][0] = 1, r.lines[0][2] = -0.5, r.bends[0] = -2;
    assert_true(psplat_region_contains(&r, (const double[]){0.55, 0.2}, 1, 0));
    assert_false(psplat_region_contains(&r, (const double[]){0.55, 0.3}, 1, 0));
}

/* Whether a point lies inside a polygon: it is crossed an odd number of times on the way there. */
static int is_inside(double (*polygon)[2], size_t count, const double p[2]) {
    int inside = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[(i + 1) % count];
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        inside ^= p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]);
    }
    return inside;
}

/* Corners of inscribed polygons are points of the region, and circumscribed ones hold all of it,
 * with few sides and with many. Areas are those that random points tell. */
static void test_bent_polygons(void **state) {
    (void)state;
    enum { POINTS = 3000 };
    uint64_t random = 19;
    for (uint32_t i = 0; i < 400; ++i) {
        psplat_region r = bent_region(&random, i % (PSPLAT_MAX_CLIP_LINES + 1));
        size_t capacity = i % 2 ? PSPLAT_OUTLINE : 68, kept = 0;
        double(*inner)[2] = malloc(capacity * sizeof *inner);
        double(*outer)[2] = malloc(capacity * sizeof *outer);
        assert_non_null(inner);
        assert_non_null(outer);
        size_t inner_count = psplat_region_polygon(&r, 1, inner, capacity);
        size_t outer_count = psplat_region_polygon(&r, 0, outer, capacity);
        assert_true(inner_count <= capacity && outer_count <= capacity);
        for (size_t k = 0; k < inner_count; ++k)
            assert_true(psplat_region_contains(&r, inner[k], 1 + 2e-9, 2e-9));
        for (int k = 0; k < POINTS; ++k) {
            const double uv[2] = {between(&random, -1, 1), between(&random, -1, 1)};
            if (!psplat_region_contains(&r, uv, 1, 0)) continue;
            assert_true(is_inside(outer, outer_count, uv));
            ++kept;
        }
        /* Four standard deviations of random points, and what a polygon leaves out. */
        double area = psplat_region_area(&r), share = 4.0 / POINTS;
        assert_near(area, share * (double)kept, 4 * share * sqrt((double)kept + 1) + 0.01);
        free(inner);
        free(outer);
    }
}

/* Half of a disc that a bent line cuts through its centre has the area of half a disc, less or more
 * what lies between the line and its chord: bend w^3 / 12 over a width of w. */
static void test_bent_area(void **state) {
    (void)state;
    for (int bend = -1; bend <= 1; ++bend) {
        psplat_region r = level_region(0, 0, 0, 1, 1);
        r.line_count = 1, r.lines[0][1] = 1, r.bends[0] = bend;
        /* It meets the circle where |v| = u^2 / 2. */
        double area = 0;
        for (int k = 0; k < 20000; ++k) {
            double u = (k + 0.5) / 10000 - 1, rim = sqrt(1 - u * u), line = -bend * u * u / 2;
            area += max2(rim - max2(line, -rim), 0) / 10000;
        }
        assert_near(psplat_region_area(&r), area, 2e-3 * area);
        if (bend) continue;
        assert_near(area, fixture_pi / 2, 1e-5);
    }
}

static void test_bent_points(void **state) {
    (void)state;
    uint64_t random = 20;
    for (uint32_t i = 0; i < 200; ++i) {
        psplat_region r = bent_region(&random, i % (PSPLAT_MAX_CLIP_LINES + 1));
        r.hessian[0] = between(&random, -1, 1), r.slope[1] = between(&random, -1, 1);
        double points[PSPLAT_REGION_POINTS][3], uvh[3];
        size_t count = psplat_region_points(&r, points);
        assert_true(count <= PSPLAT_REGION_POINTS);
        assert_true(count > 0 || psplat_region_area(&r) < 1e-3);
        for (size_t k = 0; k < count; ++k) {
            psplat_region_local(&r, points[k], uvh);
            assert_near(uvh[2], 0, 1e-14);
            assert_true(psplat_region_contains(&r, uvh, 1 + 2e-9, 2e-9));
        }
    }
}

/* A curved square has points all along its sides and between: none of its places is farther than a
 * seventh of a side from one. */
static void test_curved_points(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 1, 1);
    r.hessian[0] = 0.1;
    r.line_count = 4;
    for (int i = 0; i < 4; ++i) r.lines[i][i / 2] = i % 2 ? -1 : 1, r.lines[i][2] = 0.5;
    double points[PSPLAT_REGION_POINTS][3];
    size_t count = psplat_region_points(&r, points);
    assert_in_range(count, 100, PSPLAT_REGION_POINTS);
    for (int i = 0; i < 21 * 21; ++i) {
        double x = (i % 21 - 10) / 20.0, y = (i / 21 - 10) / 20.0, least = HUGE_VAL;
        for (size_t k = 0; k < count; ++k)
            least = min2(least, hypot(points[k][0] - x, points[k][1] - y));
        assert_true(least < 1.0 / 7);
    }
}

/* A line is added before the seams, and taken away from there. */
static void test_added_line(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 1, 1), old;
    const double line[3] = {0, -1, 0.25};
    r.line_count = r.seam_count = 1;
    r.lines[0][0] = 1, r.lines[0][2] = 0.5;
    r.lines[1][0] = -1, r.lines[1][2] = 0.125, r.bends[1] = 0.75;
    old = r;
    psplat_region_add_line(&r, line, -0.5);
    assert_int_equal(r.line_count, 2);
    assert_int_equal(r.seam_count, 1);
    assert_memory_equal(r.lines[0], old.lines[0], sizeof line);
    assert_memory_equal(r.lines[1], line, sizeof line);
    assert_memory_equal(r.lines[2], old.lines[1], sizeof line);
    assert_true(r.bends[1] == -0.5 && r.bends[2] == 0.75);
    const double cut[2] = {0, 0.5}, kept[2] = {-0.25, 0}, beyond[2] = {0.25, 0};
    assert_false(psplat_region_contains(&r, cut, 1, 0));
    assert_true(psplat_region_contains(&r, kept, 1, 0));
    assert_true(psplat_region_is_beyond_seam(&r, beyond));
    psplat_region_remove_line(&r);
    assert_memory_equal(&r, &old, sizeof r);
}

int test_region_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_local),         cmocka_unit_test(test_contains),
        cmocka_unit_test(test_polygon),       cmocka_unit_test(test_points),
        cmocka_unit_test(test_near),          cmocka_unit_test(test_area),
        cmocka_unit_test(test_within),        cmocka_unit_test(test_surface),
        cmocka_unit_test(test_bend),          cmocka_unit_test(test_local_distance),
        cmocka_unit_test(test_reach),         cmocka_unit_test(test_bent_lines),
        cmocka_unit_test(test_bent_polygons), cmocka_unit_test(test_bent_area),
        cmocka_unit_test(test_bent_points),   cmocka_unit_test(test_curved_points),
        cmocka_unit_test(test_added_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
