/* SPDX-License-Identifier: MIT
 *
 * test_candidate.c - tests of growing candidates on surfaces whose best splat is known: a plane, a
 * cylinder, a sphere, a saddle, and the corners of a cube. Expected radii of flat splats follow
 * from the sagitta: at best, a splat spans heights of twice the tolerance. Those of curved ones
 * follow from the third or fourth order of the surface, and from the bound of their slopes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "fit/grow_candidate.h"
#include "fit/fit_context.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "fit/normal_field.h"
#include "features/samples.h"

/* Returns limits for a tolerance in units of the mesh, without a normal tolerance. */
static psplat_limits limits_of(const fixture *f, double tolerance, double margin) {
    return (psplat_limits){.tolerance = tolerance,
                           .crease_tolerance = 0.2 * tolerance,
                           .crease_slack = 0.1 * tolerance,
                           .margin = margin,
                           .distance = f->distance};
}

static psplat_candidate grow(const fixture *f, const psplat_limits *limits, uint32_t seed) {
    psplat_scratch scratch = {0};
    psplat_candidate candidate;
    const psplat_fit_context context = fixture_context(f, limits, &scratch);
    assert_int_equal(psplat_candidate_grow(&context, seed, &candidate), PSPLAT_OK);
    psplat_scratch_free(&scratch);
    return candidate;
}

/* Returns the sample nearest to a point. */
static uint32_t sample_at(const fixture *f, double x, double y, double z) {
    uint32_t best = 0;
    double least = HUGE_VAL;
    const double p[3] = {x, y, z};
    for (uint32_t i = 0; i < f->samples.count; ++i) {
        double d[3];
        sub3(d, f->samples.positions + 3 * (size_t)i, p);
        if (length3(d) < least) least = length3(d), best = i;
    }
    return best;
}

/* Asserts what holds for every candidate: its axes are orthonormal, its radii ordered and positive,
 * its lines normalised so that they keep the seed; it covers the seed; and each covered sample is
 * listed once, lies inside, within the tolerance, and faces the same way. */
static void check_candidate(const fixture *f, const psplat_limits *limits,
                            const psplat_candidate *c, uint32_t seed) {
    const psplat_region *r = &c->region;
    double cross[3];
    cross3(cross, r->u, r->v);
    assert_near(length3(r->u), 1, 1e-12);
    assert_near(length3(r->v), 1, 1e-12);
    assert_near(dot3(cross, r->n), 1, 1e-12);
    assert_true(r->radius[0] >= r->radius[1] && r->radius[1] > 0);
    assert_true(r->line_count <= PSPLAT_MAX_CLIP_LINES);
    for (uint32_t i = 0; i < r->line_count; ++i)
        assert_near(hypot(r->lines[i][0], r->lines[i][1]), 1, 1e-12);
    assert_true(c->deviation <= limits->tolerance * (1 + 1e-12));
    for (int k = 0; k < 16 && psplat_region_is_curved(r); ++k) { /* One field does for both. */
        const double uv[2] = {cos(k), sin(k)};
        double xy[2], normal[3], field[3];
        psplat_region_normal(r, uv, normal);
        psplat_normal_field_at(c->field, r->radius, uv, xy);
        for (int a = 0; a < 3; ++a) field[a] = r->n[a] + xy[0] * r->u[a] + xy[1] * r->v[a];
        assert_near(dot3(field, normal), length3(field), 1e-12);
    }
    uint8_t *seen = calloc(f->samples.count, 1);
    assert_non_null(seen);
    uint32_t patch = f->surface.patches[f->samples.triangles[seed]];
    for (size_t i = 0; i < c->covered_count; ++i) {
        uint32_t sample = c->covered[i];
        double uvh[3];
        psplat_region_local(r, f->samples.positions + 3 * (size_t)sample, uvh);
        assert_true(psplat_region_contains(r, uvh, 1, 1e-6));
        assert_true(fabs(uvh[2]) <= c->deviation * (1 + 1e-9) + 1e-15);
        assert_int_equal(f->surface.patches[f->samples.triangles[sample]], patch);
        double facing = 0;
        for (size_t k = 0; k < 3; ++k)
            facing += r->n[k] * (double)f->samples.normals[3 * (size_t)sample + k];
        assert_true(facing > 0.2);
        assert_int_equal(seen[sample], 0);
        seen[sample] = 1;
    }
    assert_int_equal(seen[seed], 1);
    free(seen);
}

/* ---- plane ----------------------------------------------------------------------------------- */

static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

/* A square is one splat with four clip lines for every seed, also on a side and in a corner. */
static void test_plane(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 7, 7, place_square);
    fixture_build(&f);
    fixture_sample(&f, 0.02);
    psplat_limits limits = limits_of(&f, 0.01, 0.1);
    const double seeds[][2] = {{0, 0}, {1.3, -0.7}, {-2, 0.3}, {2, 2}, {-2, 2}};
    for (size_t i = 0; i < sizeof seeds / sizeof *seeds; ++i) {
        uint32_t seed = sample_at(&f, seeds[i][0], seeds[i][1], 0);
        psplat_candidate c = grow(&f, &limits, seed);
        check_candidate(&f, &limits, &c, seed);
        assert_int_equal(c.covered_count, f.samples.count);
        assert_int_equal(c.region.line_count, 4);
        assert_near(c.deviation, 0, 1e-12);
        for (int k = 0; k < 4; ++k) assert_near(c.field[k], 0, 1e-6); /* the file's floats */
        psplat_candidate_free(&c);
    }
    fixture_free(&f);
}

/* ---- cylinder -------------------------------------------------------------------------------- */

enum { AROUND = 96 };
static const double length = 8;

/* Places half a tube of radius 1 along z. */
static void place_tube(double s, double t, double p[3]) {
    p[0] = sin(fixture_pi * (s - 0.5)), p[1] = cos(fixture_pi * (s - 0.5)),
    p[2] = length * (t - 0.5);
}

/* The best flat splat is a strip along the axis, as wide as the tolerance allows: its half-width w
 * has a sagitta of twice the tolerance, 1 - cos w = 2 tolerance. */
static void test_cylinder(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, AROUND, 24, place_tube);
    for (size_t t = 0; t < f.mesh.triangle_count; ++t) { /* The outer side becomes the front. */
        uint32_t swap = f.mesh.triangles[3 * t];
        f.mesh.triangles[3 * t] = f.mesh.triangles[3 * t + 1];
        f.mesh.triangles[3 * t + 1] = swap;
    }
    fixture_build(&f);
    assert_int_equal(f.surface.crease_edges, 0);
    fixture_sample(&f, 0.004);
    const double tolerance = 0.02;
    psplat_limits limits = limits_of(&f, tolerance, 0.02);
    limits.planar = 1;
    double widest = sin(acos(1 - 2 * tolerance));
    const double axis[3] = {0, 0, 1};
    for (int i = 0; i < 5; ++i) {
        double angle = -1 + 0.5 * i;
        uint32_t seed = sample_at(&f, sin(angle), cos(angle), 0.2 * i);
        psplat_candidate c = grow(&f, &limits, seed);
        const psplat_region *r = &c.region;
        check_candidate(&f, &limits, &c, seed);
        print_message("cylinder: %.2f x %.3f, widest %.3f\n", r->radius[0], r->radius[1], widest);
        assert_true(r->radius[0] > 3 * r->radius[1]);
        assert_true(fabs(dot3(r->u, axis)) > 0.999);
        assert_true(dot3(r->n, f.surface.face_normals + 3 * (size_t)c.triangle) > 0.9);
        assert_true(r->radius[1] > 0.8 * widest && r->radius[1] < 1.02 * widest);
        /* No point of the ellipse is farther than the tolerance from the exact cylinder; the mesh
         * lies inside it by at most 1 - cos(pi / 2 / 96). */
        for (int k = 0; k < 64; ++k) {
            double p[3], turn = 2 * fixture_pi * k / 64;
            for (int ring = 0; ring <= 4; ++ring) {
                region_point(r, ring * cos(turn) / 4, ring * sin(turn) / 4, 0, p);
                assert_near(hypot(p[0], p[1]), 1, tolerance + 2e-4);
            }
        }
        /* The normal turns across the strip and not along it: beta = r_v and alpha = 0 (BSK04), to
         * within a tenth. */
        assert_near(c.field[2], 0, 0.1 * r->radius[1]);
        assert_near(c.field[3], r->radius[1], 0.1 * r->radius[1]);
        psplat_candidate_free(&c);
    }
    fixture_free(&f);
}

/* Returns how far the surface of a region is at most from one whose distance is known, at points
 * all over its ellipse. */
static double farthest(const psplat_region *r, double (*distance)(const double p[3])) {
    double greatest = 0;
    for (int k = 0; k < 64; ++k)
        for (int ring = 0; ring <= 8; ++ring) {
            double p[3], turn = 2 * fixture_pi * k / 64;
            const double uv[2] = {ring * cos(turn) / 8, ring * sin(turn) / 8};
            psplat_region_point(r, uv, p);
            greatest = max2(greatest, distance(p));
        }
    return greatest;
}

static double tube_distance(const double p[3]) {
    return fabs(hypot(p[0], p[1]) - 1);
}

/* A curved splat on the tube is a strip, too. Over the half-width w a parabola leaves the circle by
 * the fourth order, x^4 / 8, of which the best fit leaves w^4 / 64 to both sides: that is the
 * tolerance at w = (64 tolerance)^(1/4) but for higher orders, which are a third of it there. It is
 * at least twice as wide as the flat one, and all of it is within the tolerance. */
static void test_curved_cylinder(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, AROUND, 24, place_tube);
    fixture_build(&f); /* the inner side is the front */
    fixture_sample(&f, 0.004);
    const double tolerance = 0.004, axis[3] = {0, 0, 1};
    psplat_limits limits = limits_of(&f, tolerance, 0.02);
    double flat = sin(acos(1 - 2 * tolerance)), widest = pow(64 * tolerance, 0.25);
    for (int i = 0; i < 5; ++i) {
        double angle = -0.5 + 0.25 * i;
        uint32_t seed = sample_at(&f, sin(angle), cos(angle), 0.2 * i);
        psplat_candidate c = grow(&f, &limits, seed);
        const psplat_region *r = &c.region;
        check_candidate(&f, &limits, &c, seed);
        print_message("curved cylinder: %.2f x %.3f, flat %.3f, widest %.3f\n", r->radius[0],
                      r->radius[1], flat, widest);
        assert_true(fabs(dot3(r->u, axis)) > 0.99);
        assert_true(r->radius[1] > 2 * flat && r->radius[1] < 1.1 * widest);
        /* The mesh lies inside the circle by at most 1 - cos(pi / 2 / 96) = 1.3e-4. */
        assert_true(farthest(r, tube_distance) < tolerance + 2e-4);
        /* It bends around the axis and nowhere else: the second derivative of the best parabola is
         * that of the circle, 1, and up to w^2 more. */
        assert_near(r->hessian[0], 0, 0.02);
        assert_near(r->hessian[1], 0, 0.05);
        assert_near(fabs(r->hessian[2]), 1 + 0.3 * r->radius[1] * r->radius[1], 0.3);
        psplat_candidate_free(&c);
    }
    fixture_free(&f);
}

/* ---- saddle ---------------------------------------------------------------------------------- */

/* Places a saddle over a square of side 4, whose slopes reach 0.9 in the corners. */
static void place_saddle(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2,
    p[2] = 0.15 * (p[0] * p[0] - p[1] * p[1]) + 0.05 * p[0] * p[1];
}

/* A saddle, whatever its size, is one curved splat: its surface is of second order. The tolerance
 * is for the mesh, whose chords of 1/30 leave it by 0.16 * (4 / 60)^2 / 2 = 4e-4. Only the seed in
 * the middle sees all of it alike. */
static void test_saddle(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 60, 60, place_saddle);
    fixture_build(&f);
    fixture_sample(&f, 0.01);
    psplat_limits limits = limits_of(&f, 0.005, 0.05);
    limits.crease_tolerance = limits.tolerance;
    uint32_t seed = sample_at(&f, 0, 0, 0);
    psplat_candidate c = grow(&f, &limits, seed);
    check_candidate(&f, &limits, &c, seed);
    print_message("saddle: %zu of %zu samples, %u lines, deviation %.2g\n", c.covered_count,
                  f.samples.count, c.region.line_count, c.deviation);
    assert_int_equal(c.covered_count, f.samples.count);
    assert_int_equal(c.region.line_count, 4);
    /* its Gaussian curvature: in its own axes 0.3, -0.3 and 0.05 */
    const double *h = c.region.hessian;
    assert_near(h[0] * h[2] - h[1] * h[1], -0.0925, 0.003);
    assert_near(h[0] + h[2], 0, 0.01);
    limits.planar = 1;
    psplat_candidate flat = grow(&f, &limits, seed);
    assert_int_equal(psplat_region_is_curved(&flat.region), 0);
    assert_true(8 * flat.covered_count < c.covered_count);
    psplat_candidate_free(&flat);
    psplat_candidate_free(&c);
    fixture_free(&f);
}

/* ---- sphere ---------------------------------------------------------------------------------- */

/* The best flat splat is a cap whose height is twice the tolerance: 1 - cos(half angle) = 2
 * tolerance.
 */
static void test_sphere(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "sphere.ply");
    double radius = length3(f.mesh.positions);
    fixture_sample(&f, 0.004);
    const double parts[] = {0.02, 0.08};
    for (size_t i = 0; i < 2; ++i) {
        psplat_limits limits = limits_of(&f, parts[i] * radius, 0.02 * radius);
        limits.planar = 1;
        double best = radius * sin(acos(1 - 2 * parts[i]));
        for (uint32_t k = 0; k < 4; ++k) {
            uint32_t seed = (uint32_t)(k * f.samples.count / 4);
            psplat_candidate c = grow(&f, &limits, seed);
            check_candidate(&f, &limits, &c, seed);
            print_message("sphere: %.3f x %.3f of the best\n", c.region.radius[0] / best,
                          c.region.radius[1] / best);
            assert_int_equal(c.region.line_count, 0);
            assert_true(c.region.radius[1] > 0.8 * best);
            /* The outline may reach beyond the covered samples, to where it leaves the sphere by
             * the tolerance, while the middle lies inside by as much: radius^2 = (1 + t)^2 - (1 -
             * t)^2 = 4 t. The mesh lies 0.1 % inside the sphere. An ellipse may be a little longer
             * where it is narrower. */
            double widest2 = 4 * parts[i] * radius * radius;
            assert_true(c.region.radius[0] < 1.1 * sqrt(widest2));
            assert_true(c.region.radius[0] * c.region.radius[1] < 1.02 * widest2);
            for (int n = 0; n < 64; ++n) {
                double p[3], turn = 2 * fixture_pi * n / 64;
                region_point(&c.region, cos(turn), sin(turn), 0, p);
                assert_near(length3(p), radius, (parts[i] + 0.0015) * radius);
            }
            psplat_candidate_free(&c);
        }
    }
    fixture_free(&f);
}

static double sphere_radius;

static double sphere_distance(const double p[3]) {
    return fabs(length3(p) - sphere_radius);
}

/* On a sphere of radius 1 a paraboloid over the radius x leaves it by x^4 / 64 to both sides at
 * best, and a little more for higher orders: x = (64 tolerance)^(1/4). At small tolerances a curved
 * splat comes near to that, and all of it is within the tolerance. */
static void test_curved_sphere(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "sphere.ply");
    double radius = sphere_radius = length3(f.mesh.positions);
    fixture_sample(&f, 0.004);
    const double parts[] = {0.004, 0.02};
    for (size_t i = 0; i < 2; ++i) {
        psplat_limits limits = limits_of(&f, parts[i] * radius, 0.02 * radius);
        double flat = radius * sin(acos(1 - 2 * parts[i])),
               best = radius * pow(64 * parts[i], 0.25);
        for (uint32_t k = 0; k < 4; ++k) {
            uint32_t seed = (uint32_t)(k * f.samples.count / 4);
            psplat_candidate c = grow(&f, &limits, seed);
            check_candidate(&f, &limits, &c, seed);
            print_message("curved sphere: %.3f x %.3f, flat %.3f, best %.3f\n", c.region.radius[0],
                          c.region.radius[1], flat, best);
            assert_int_equal(c.region.line_count, 0);
            assert_true(c.region.radius[1] > 1.8 * flat);
            assert_true(c.region.radius[0] < 1.15 * best);
            /* The mesh lies 0.1 % inside the sphere. */
            assert_true(farthest(&c.region, sphere_distance) < (parts[i] + 0.0015) * radius);
            assert_true(psplat_region_is_curved(&c.region));
            psplat_candidate_free(&c);
        }
    }
    fixture_free(&f);
}

/* With a narrow normal tolerance the normals bound the splat, and not the distance. */
static void test_normal_tolerance(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "sphere.ply");
    double radius = length3(f.mesh.positions);
    fixture_sample(&f, 0.004);
    psplat_limits limits = limits_of(&f, 0.3 * radius, 0.02 * radius);
    limits.normal_tolerance = 0.01;
    psplat_candidate tight = grow(&f, &limits, 7);
    limits.normal_tolerance = 0.05;
    psplat_candidate loose = grow(&f, &limits, 7);
    assert_true(tight.covered_count < loose.covered_count);
    for (int i = 0; i < 2; ++i) {
        const psplat_candidate *c = i ? &loose : &tight;
        double greatest = 0;
        for (size_t k = 0; k < c->covered_count; ++k) {
            double uvh[3], xy[2], n[3], across[3], m[3];
            const float *stored = f.samples.normals + 3 * (size_t)c->covered[k];
            psplat_region_local(&c->region, f.samples.positions + 3 * (size_t)c->covered[k], uvh);
            psplat_normal_field_at(c->field, c->region.radius, uvh, xy);
            for (int a = 0; a < 3; ++a) {
                m[a] = (double)stored[a];
                n[a] = c->region.n[a] + xy[0] * c->region.u[a] + xy[1] * c->region.v[a];
            }
            cross3(across, m, n);
            greatest = max2(greatest, atan2(length3(across), dot3(m, n)));
        }
        /* The bound that fitting promises holds for the sample normals themselves. */
        assert_true(greatest <= (i ? 0.05 : 0.01) * (1 + 1e-6)); /* float normals */
    }
    psplat_candidate_free(&tight);
    psplat_candidate_free(&loose);
    fixture_free(&f);
}

/* ---- corners --------------------------------------------------------------------------------- */

/* From every sample on an edge or corner of the cube a splat of one face grows that reaches across
 * no edge. */
static void test_corners(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "cube.off");
    fixture_sample(&f, 0.05);
    double half = f.surface.diagonal / sqrt(12);
    psplat_limits limits = limits_of(&f, 0.02 * half, 0.1 * half);
    size_t corners = 0;
    for (uint32_t seed = 0; seed < f.samples.count; ++seed) {
        const double *p = f.samples.positions + 3 * (size_t)seed;
        int sides = 0;
        for (int k = 0; k < 3; ++k) sides += fabs(fabs(p[k]) - half) < 1e-9 * half;
        if (sides < 2) continue;
        corners += sides == 3;
        psplat_candidate c = grow(&f, &limits, seed);
        check_candidate(&f, &limits, &c, seed);
        double polygon[68][2];
        size_t count = psplat_region_polygon(&c.region, 0, polygon, 68);
        assert_true(count >= 3);
        for (size_t i = 0; i < count; ++i) {
            double q[3];
            region_point(&c.region, polygon[i][0], polygon[i][1], 0, q);
            for (int k = 0; k < 3; ++k) assert_true(fabs(q[k]) <= half + limits.crease_slack);
        }
        psplat_candidate_free(&c);
    }
    assert_int_equal(corners, 24);
    fixture_free(&f);
}

/* ---- samples added later --------------------------------------------------------------------- */

/* Samples that are added after a candidate has grown count as covered where it covers them. */
static void test_cover(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 7, 7, place_square);
    fixture_build(&f);
    fixture_sample(&f, 0.05);
    psplat_limits limits = limits_of(&f, 0.01, 0.1);
    psplat_candidate c = grow(&f, &limits, 0);
    psplat_samples extra;
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 50, 9, &extra, NULL), PSPLAT_OK);
    assert_int_equal(psplat_samples_append(&f.samples, &f.surface, extra.positions, extra.triangles,
                                           extra.count, NULL),
                     PSPLAT_OK);
    psplat_scratch scratch = {0};
    const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
    assert_int_equal(psplat_candidate_cover(&context, &c), PSPLAT_OK);
    assert_int_equal(c.covered_count, f.samples.count);
    psplat_scratch_free(&scratch);
    psplat_samples_free(&extra);
    psplat_candidate_free(&c);
    fixture_free(&f);
}

int test_candidate_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_cylinder),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_curved_cylinder),
        cmocka_unit_test(test_curved_sphere),
        cmocka_unit_test(test_saddle),
        cmocka_unit_test(test_normal_tolerance),
        cmocka_unit_test(test_corners),
        cmocka_unit_test(test_cover),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
