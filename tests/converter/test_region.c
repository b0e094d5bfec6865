/* SPDX-License-Identifier: MIT
 * The walk over the surface above a region: heights and areas against brute force, creases that it
 * meets and does not cross, and when it gives up. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "stage_fixture.h"

/* ---- regions and surfaces -------------------------------------------------------------------- */

static void place_waves(double s, double t, double p[3]) {
    p[0] = 10 * s - 5, p[1] = 10 * t - 5;
    p[2] = 0.3 * sin(1.3 * p[0]) * cos(0.9 * p[1]) + 0.05 * p[0];
}

/* Two slopes of 45 degrees that meet in a ridge along x = 0. */
static void place_roof(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = -fabs(p[0]);
}

static void place_flat(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

static psplat_region level_region(double x, double y, double z, double ru, double rv) {
    return (psplat_region){
        .center = {x, y, z}, .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* A triangle whose projection holds the region's centre. */
static uint32_t triangle_at(const fixture *f, double x, double y) {
    const psplat_mesh *mesh = &f->mesh;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        int inside = 1;
        for (size_t k = 0; k < 3; ++k) {
            const double *a = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + k];
            const double *b = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + (k + 1) % 3];
            inside &= (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0;
        }
        if (inside) return t;
    }
    fail_msg("no triangle at %g, %g", x, y);
    return 0;
}

/* The polygon of 16 sides around the unit circle, as the walk uses it, and the lines. */
static int in_polygon(const psplat_region *r, const double uv[2]) {
    for (int i = 0; i < 16; ++i) {
        double angle = 2 * fixture_pi * i / 16;
        if (cos(angle) * uv[0] + sin(angle) * uv[1] > 1 + 1e-12) return 0;
    }
    return psplat_region_contains(r, uv, 2, 0);
}

/* Least and greatest height of points thrown on every triangle: those inside the polygon, and
 * inside the ellipse. Returns the greatest difference between neighbouring points. */
static double throw_heights(const fixture *f, const psplat_region *r, double polygon[2],
                            double ellipse[2], double *area) {
    enum { STEPS = 20 };
    double step = 0, inside = 0;
    polygon[0] = ellipse[0] = HUGE_VAL, polygon[1] = ellipse[1] = -HUGE_VAL;
    for (size_t t = 0; t < f->mesh.triangle_count; ++t) {
        double corners[3][3];
        for (size_t k = 0; k < 3; ++k)
            psplat_region_local(r, f->mesh.positions + 3 * (size_t)f->mesh.triangles[3 * t + k],
                                corners[k]);
        double full = ((corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                       (corners[1][1] - corners[0][1]) * (corners[2][0] - corners[0][0])) /
                      2;
        for (int i = 0; i < STEPS; ++i)
            for (int k = 0; k < STEPS - i; ++k) {
                double a = (i + 1.0 / 3) / STEPS, b = (k + 1.0 / 3) / STEPS, p[3];
                for (int c = 0; c < 3; ++c)
                    p[c] = corners[0][c] + a * (corners[1][c] - corners[0][c]) +
                           b * (corners[2][c] - corners[0][c]);
                if (!in_polygon(r, p)) continue;
                inside += full * 2 / (STEPS * (STEPS + 1));
                polygon[0] = min2(polygon[0], p[2]), polygon[1] = max2(polygon[1], p[2]);
                for (int c = 1; c < 3; ++c)
                    step = max2(step, fabs(corners[c][2] - corners[0][2]) / STEPS);
                if (!psplat_region_contains(r, p, 1, 0)) continue;
                ellipse[0] = min2(ellipse[0], p[2]), ellipse[1] = max2(ellipse[1], p[2]);
            }
    }
    *area = inside;
    return step;
}

/* ---- heights --------------------------------------------------------------------------------- */

static void test_heights(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 24, 24, place_waves);
    fixture_build(&f);
    assert_int_equal(f.surface.crease_edges, 0);
    psplat_walk walk = {0};
    uint64_t random = 31;
    for (int i = 0; i < 12; ++i) {
        double x = 4 * psplat_random_unit(&random) - 2, y = 4 * psplat_random_unit(&random) - 2;
        double tilt = 0.4 * psplat_random_unit(&random), turn = 6 * psplat_random_unit(&random);
        psplat_region r = level_region(x, y, 0, 1.5, 0.1 + psplat_random_unit(&random));
        const double u[3] = {cos(turn), sin(turn), 0}, side[3] = {-sin(turn), cos(turn), 0};
        const double n[3] = {-sin(tilt) * side[0], -sin(tilt) * side[1], cos(tilt)};
        memcpy(r.u, u, sizeof u);
        memcpy(r.n, n, sizeof n);
        cross3(r.v, n, u);
        r.line_count = (uint32_t)i % 3; /* lines that leave the centre */
        for (uint32_t k = 0; k < r.line_count; ++k) {
            double angle = 6.3 * psplat_random_unit(&random);
            r.lines[k][0] = cos(angle), r.lines[k][1] = sin(angle), r.lines[k][2] = 0.3;
        }
        psplat_walk_surface(&walk, &f.surface, &r, triangle_at(&f, x, y), HUGE_VAL);
        assert_int_equal(walk.failed, 0);
        assert_int_equal(walk.aborted, 0);
        assert_int_equal(walk.segment_count, 0);
        double polygon[2], ellipse[2], area;
        double step = throw_heights(&f, &r, polygon, ellipse, &area);
        /* Bounds for the ellipse; exact for the polygon but for the distance of thrown points. */
        assert_true(walk.height[0] <= ellipse[0] && walk.height[1] >= ellipse[1]);
        assert_near(walk.height[0], polygon[0], 2 * step);
        assert_near(walk.height[1], polygon[1], 2 * step);
        assert_near(walk.area, area, 0.05 * area); /* points at the rim count whole or not */
        if (!r.line_count) assert_near(walk.area, 16 * tan(fixture_pi / 16), 1e-9);
    }
    psplat_walk_free(&walk);
    fixture_free(&f);
}

/* Only triangles that the region's column holds, each once, whatever the scratch held before. */
static void test_triangles(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 16, 16, place_flat);
    fixture_build(&f);
    psplat_walk walk = {0};
    psplat_region r = level_region(0.01, 0.02, 0, 0.7, 0.6);
    uint32_t seed = triangle_at(&f, 0.01, 0.02);
    for (int round = 0; round < 3; ++round) {
        psplat_walk_surface(&walk, &f.surface, &r, seed, HUGE_VAL);
        size_t expected = 0;
        for (uint32_t t = 0; t < f.mesh.triangle_count; ++t) {
            double middle[3] = {0, 0, 0}, uvh[3];
            size_t met = 0;
            for (size_t k = 0; k < 3; ++k)
                mad3(middle, 1.0 / 3, f.mesh.positions + 3 * (size_t)f.mesh.triangles[3 * t + k]);
            psplat_region_local(&r, middle, uvh);
            for (size_t i = 0; i < walk.triangle_count; ++i) met += walk.triangles[i] == t;
            double distance = hypot(uvh[0], uvh[1]);
            assert_true(met <= 1);
            if (distance < 1) assert_int_equal(met, 1);
            /* A triangle is 0.25 wide: 0.42 in the units of the smaller radius. */
            if (distance > 1.02 + 0.42) assert_int_equal(met, 0);
            expected += met;
        }
        assert_int_equal(walk.triangle_count, expected);
        walk.stamp = UINT32_MAX - 1 + (uint32_t)round; /* the next walk's stamp wraps around */
    }
    psplat_walk_free(&walk);
    fixture_free(&f);
}

/* ---- creases --------------------------------------------------------------------------------- */

/* How far the polygon of 16 sides reaches along v at u. */
static double polygon_reach(double u) {
    double reach = HUGE_VAL;
    for (int i = 1; i < 8; ++i) {
        double angle = 2 * fixture_pi * i / 16;
        reach = min2(reach, (1 - cos(angle) * u) / sin(angle));
    }
    return reach;
}

/* The region overlaps the ridge; the walk stays on the seed's slope and reports the ridge. */
static void check_ridge(const fixture *f, psplat_region *r, double ridge, double low, double high) {
    psplat_walk walk = {0};
    psplat_walk_surface(&walk, &f->surface, r, triangle_at(f, -0.3, 0.07), HUGE_VAL);
    double from = HUGE_VAL, to = -HUGE_VAL, length = 0;
    for (size_t i = 0; i < walk.triangle_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            size_t corner = 3 * (size_t)walk.triangles[i] + k;
            assert_true(f->mesh.positions[3 * (size_t)f->mesh.triangles[corner]] <= 1e-12);
        }
    for (size_t i = 0; i < walk.segment_count; ++i) {
        const psplat_segment *s = &walk.segments[i];
        assert_near(s->a[0], ridge, 1e-12);
        assert_near(s->b[0], ridge, 1e-12);
        assert_near(s->a[2], 0, 1e-12); /* the ridge lies in the region's plane */
        assert_true(s->b[1] > s->a[1]); /* the slope of x < 0 to its left */
        from = min2(from, s->a[1]), to = max2(to, s->b[1]);
        length += s->b[1] - s->a[1];
        /* The ends' vertices lie on the ridge, and the triangle across beyond it. */
        for (int k = 0; k < 2; ++k)
            assert_near(f->mesh.positions[3 * (size_t)s->vertex[k]], 0, 1e-12);
        assert_true(s->across < f->mesh.triangle_count);
        assert_true(f->surface.face_normals[3 * (size_t)s->across] > 0.7);
    }
    assert_near(from, low, 1e-12);
    assert_near(to, high, 1e-12);
    assert_near(length, high - low, 1e-12); /* without gap or overlap */
    assert_near(walk.crease_height[0], 0, 1e-12);
    assert_near(walk.crease_height[1], 0, 1e-12);
    psplat_walk_free(&walk);
}

static void test_ridge(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 32, 32, place_roof);
    fixture_build(&f);
    assert_int_equal(f.surface.crease_edges, 32);
    psplat_region r = level_region(-0.3, 0.07, 0, 0.8, 0.5);
    double ridge = 0.3 / 0.8, reach = polygon_reach(ridge);
    check_ridge(&f, &r, ridge, -reach, reach);
    /* A line across the ridge shortens what is reported, exactly. */
    r.line_count = 1;
    r.lines[0][0] = 0.6, r.lines[0][1] = 0.8, r.lines[0][2] = -0.1;
    check_ridge(&f, &r, ridge, (0.1 - 0.6 * ridge) / 0.8, reach);
    /* One that keeps the ridge away leaves nothing of it. */
    psplat_walk walk = {0};
    r.lines[0][0] = -1, r.lines[0][1] = 0, r.lines[0][2] = ridge - 1e-9;
    psplat_walk_surface(&walk, &f.surface, &r, triangle_at(&f, -0.3, 0.07), HUGE_VAL);
    assert_int_equal(walk.segment_count, 0);
    assert_true(walk.crease_height[0] > walk.crease_height[1]);
    psplat_walk_free(&walk);
    fixture_free(&f);
}

/* A border bounds the walk as a crease does, with nothing across. */
static void test_border(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 8, 8, place_flat);
    fixture_build(&f);
    psplat_walk walk = {0};
    psplat_region r = level_region(-1.9, 0.1, 0, 0.5, 0.5);
    psplat_walk_surface(&walk, &f.surface, &r, triangle_at(&f, -1.9, 0.1), HUGE_VAL);
    assert_true(walk.segment_count > 0);
    for (size_t i = 0; i < walk.segment_count; ++i) {
        assert_int_equal(walk.segments[i].across, PSPLAT_NONE);
        assert_near(walk.segments[i].a[0], -0.2, 1e-12);
    }
    assert_true(walk.area > 1.5 && walk.area < 2.5); /* part of pi */
    psplat_walk_free(&walk);
    fixture_free(&f);
}

/* ---- giving up ------------------------------------------------------------------------------- */

static void test_aborted(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 32, 32, place_roof);
    fixture_build(&f);
    psplat_walk walk = {0};
    /* Level above a slope of 45 degrees, clear of ridge and borders: heights span its diameter. */
    psplat_region r = level_region(-1, 0, -1, 0.5, 0.5);
    uint32_t seed = triangle_at(&f, -1, 0);
    psplat_walk_surface(&walk, &f.surface, &r, seed, 1 + 1e-9);
    assert_int_equal(walk.aborted, 0);
    assert_near(walk.height[0], -0.5, 1e-12);
    assert_near(walk.height[1], 0.5, 1e-12);
    size_t all = walk.triangle_count;
    psplat_walk_surface(&walk, &f.surface, &r, seed, 0.6);
    assert_int_equal(walk.aborted, 1);
    assert_true(walk.triangle_count < all);
    /* The same over the ridge: lines yet to be chosen may cut the rest away. */
    r = level_region(-0.03, 0, 0, 0.5, 0.5);
    psplat_walk_surface(&walk, &f.surface, &r, triangle_at(&f, -0.03, 0), 0.3);
    assert_int_equal(walk.aborted, 0);
    assert_true(walk.height[1] - walk.height[0] > 0.3);
    r.line_count = 1; /* they are chosen, and do not */
    r.lines[0][0] = -1, r.lines[0][1] = 0, r.lines[0][2] = 0.06;
    psplat_walk_surface(&walk, &f.surface, &r, triangle_at(&f, -0.03, 0), 0.3);
    assert_int_equal(walk.aborted, 1);
    psplat_walk_free(&walk);
    fixture_free(&f);
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
    r.line_count = 2; /* a quarter */
    r.lines[0][0] = 1, r.lines[1][1] = 1;
    size_t count = psplat_region_polygon(&r, 1, polygon, 68);
    assert_near(area_of(polygon, count), 8 * sin(fixture_pi / 32), 1e-12);
    r.lines[1][2] = -1.5; /* nothing */
    assert_int_equal(psplat_region_polygon(&r, 0, polygon, 68), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heights), cmocka_unit_test(test_triangles),
        cmocka_unit_test(test_ridge),   cmocka_unit_test(test_border),
        cmocka_unit_test(test_aborted), cmocka_unit_test(test_polygon),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
