/* SPDX-License-Identifier: MIT
 *
 * test_neighborhood.c - tests of neighbourhoods of samples on the surface against brute force:
 * their order, their reach and their sums, points that are near in space but not along the surface,
 * and the creases around. The shapes are a sphere, a torus, a folded sheet, a roof and a cube.
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
#include "base/vector.h"
#include "features/neighborhood.h"
#include "mesh/mesh.h"

/* Returns a metric with random axes in which the second one counts 1 / stretch. */
static psplat_metric metric_at(const double center[3], double stretch, uint64_t *random) {
    psplat_metric m;
    memcpy(m.center, center, sizeof m.center);
    random_axes(random, m.rows[0], m.rows[1], m.rows[2]);
    for (int k = 0; k < 3; ++k) m.rows[1][k] /= stretch;
    return m;
}

static psplat_metric round_metric(const double center[3]) {
    return (psplat_metric){.center = {center[0], center[1], center[2]},
                           .rows = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

static double distance_in(const psplat_metric *m, const double p[3]) {
    double d[3], w[3];
    sub3(d, p, m->center);
    for (int k = 0; k < 3; ++k) w[k] = dot3(m->rows[k], d);
    return length3(w);
}

static void gather(psplat_neighborhood *n, const fixture *f, const psplat_metric *metric,
                   uint32_t triangle, double reach) {
    assert_int_equal(
        psplat_neighborhood_gather(n, &f->surface, &f->samples, metric, triangle, reach, 0), 1);
}

/* ---- order and sums -------------------------------------------------------------------------- */

static void check_covariance(psplat_neighborhood *n, size_t count) {
    psplat_covariance found, direct = {0};
    psplat_neighborhood_covariance(n, count, &found);
    for (size_t i = 0; i < count; ++i)
        psplat_covariance_add(&direct, n->samples[i].p, n->samples[i].n);
    assert_near(found.count, (double)count, 0);
    for (int k = 0; k < 3; ++k) { /* equal sums in equal order */
        assert_near(found.p[k], direct.p[k], 0);
        assert_near(found.n[k], direct.n[k], 0);
        for (int l = 0; l < 3; ++l) assert_near(found.np[k][l], direct.np[k][l], 0);
    }
    for (int k = 0; k < 6; ++k) assert_near(found.pp[k], direct.pp[k], 0);
}

/* On a closed surface without creases, all samples within reach are found, and the nearest come
 * first. */
static void check_ball(psplat_neighborhood *n, const fixture *f, uint32_t seed, double stretch,
                       double reach, uint64_t *random) {
    psplat_metric m = metric_at(f->samples.positions + 3 * (size_t)seed, stretch, random);
    gather(n, f, &m, f->samples.triangles[seed], reach);
    size_t expected = 0;
    for (size_t i = 0; i < f->samples.count; ++i)
        expected += distance_in(&m, f->samples.positions + 3 * i) <= reach;
    assert_int_equal(n->count, expected);
    assert_int_equal(n->crease_count, 0);
    assert_int_equal(n->whole, n->count == f->samples.count);
    double before = 0;
    for (size_t i = 0; i < n->count; ++i) {
        const double *p = f->samples.positions + 3 * (size_t)n->samples[i].index;
        double distance = distance_in(&m, p), relative[3];
        /* Squares are sorted as floats, which are exact to 6e-8, and distances to half of that. */
        assert_true(distance >= before * (1 - 1e-7));
        before = distance;
        sub3(relative, p, n->origin);
        assert_memory_equal(relative, n->samples[i].p, sizeof relative);
    }
    assert_int_equal(n->samples[0].index, seed);
    for (int k = 0; k <= 8; ++k) {
        double part = reach * k / 8 * (1 - 1e-9);
        size_t within = psplat_neighborhood_within(n, part);
        if (within > 0)
            assert_true(
                distance_in(&m, f->samples.positions + 3 * (size_t)n->samples[within - 1].index) <=
                part * (1 + 1e-7));
        if (within < n->count)
            assert_true(
                distance_in(&m, f->samples.positions + 3 * (size_t)n->samples[within].index) >=
                part * (1 - 1e-7));
        check_covariance(n, within);
    }
    check_covariance(n, n->count);
    gather(n, f, &m, f->samples.triangles[seed], reach); /* All before few, too. */
    check_covariance(n, n->count);
    check_covariance(n, n->count / 2);
}

static void test_order(void **state) {
    (void)state;
    fixture f;
    psplat_neighborhood n = {0};
    uint64_t random = 3;
    fixture_model(&f, "sphere.ply");
    fixture_sample(&f, 0.02);
    double radius = length3(f.mesh.positions);
    const double reaches[] = {0.5, 0.05, 1.2, 0.001, 3, 0.3};
    for (uint32_t i = 0; i < 6; ++i) {
        check_ball(&n, &f, (uint32_t)(i * f.samples.count / 6), 1, reaches[i] * radius, &random);
        if (i == 4) assert_int_equal(n.whole, 1); /* The reach exceeds the diameter. */
    }
    n.stamp = UINT32_MAX - 1; /* The stamps of the next calls wrap around. */
    for (uint32_t i = 0; i < 3; ++i) check_ball(&n, &f, 10 * i, 1, 0.4 * radius, &random);
    psplat_neighborhood_free(&n);
    fixture_free(&f);
}

/* With a stretched metric one axis counts less, so that the ball is an ellipsoid. */
static void test_stretched(void **state) {
    (void)state;
    fixture f;
    psplat_neighborhood n = {0};
    uint64_t random = 8;
    fixture_model(&f, "torus.off");
    fixture_sample(&f, 0.02);
    /* The reach is so short that the part of the torus inside it is in one piece. */
    for (uint32_t i = 0; i < 8; ++i)
        check_ball(&n, &f, (uint32_t)(i * f.samples.count / 8), 2, 0.04 * f.surface.diagonal,
                   &random);
    psplat_neighborhood_free(&n);
    fixture_free(&f);
}

/* ---- near in space only ---------------------------------------------------------------------- */

static const double gap = 0.2;

/* Places a sheet bent into a U along y: legs of length 3 at z = 0 and z = gap, and a half circle at
 * x = 3. */
static void place_fold(double s, double t, double p[3]) {
    double bow = fixture_pi * gap / 2, at = s * (6 + bow), turn = (at - 3) / (gap / 2);
    p[1] = t;
    p[0] = at < 3 ? at : at > 3 + bow ? 6 + bow - at : 3 + gap / 2 * sin(turn);
    p[2] = at < 3 ? 0 : at > 3 + bow ? gap : gap / 2 - gap / 2 * cos(turn);
}

/* The other leg is nearer than the reach and connected, but only through points beyond the reach.
 */
static void test_fold(void **state) {
    (void)state;
    fixture f;
    psplat_neighborhood n = {0};
    fixture_grid(&f, 400, 8, place_fold);
    fixture_build(&f);
    assert_int_equal(f.surface.crease_edges, 0);
    assert_int_equal(f.surface.patch_count, 1);
    fixture_sample(&f, 0.01);
    double reach = 2 * gap;
    for (uint32_t seed = 0, tried = 0; tried < 6; seed += 37) {
        const double *p = f.samples.positions + 3 * (size_t)seed;
        if (p[0] > 2.5 || p[2] > 1e-9) continue;
        ++tried;
        psplat_metric m = round_metric(p);
        size_t other = 0;
        for (size_t i = 0; i < f.samples.count; ++i)
            other += f.samples.positions[3 * i + 2] > 0.5 * gap &&
                     distance_in(&m, f.samples.positions + 3 * i) <= reach;
        assert_true(other > 10); /* There are samples that could be found wrongly. */
        gather(&n, &f, &m, f.samples.triangles[seed], reach);
        assert_int_equal(n.whole, 0);
        for (size_t i = 0; i < n.count; ++i) assert_near(n.samples[i].p[2], 0, 1e-9);
        gather(&n, &f, &m, f.samples.triangles[seed], 8); /* far enough to go around the bend */
        assert_int_equal(n.whole, 1);
        assert_int_equal(n.count, f.samples.count);
    }
    psplat_neighborhood_free(&n);
    fixture_free(&f);
}

/* ---- creases --------------------------------------------------------------------------------- */

/* Places two slopes of 45 degrees that meet in a ridge along x = 0. */
static void place_roof(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = -fabs(p[0]);
}

/* Returns the radius of the largest cluster of triangles. */
static double largest_cluster(const psplat_samples *samples) {
    double radius = 0;
    for (size_t c = 0; c < samples->clusters.count; ++c)
        radius = fmax(radius, samples->clusters.spheres[c].radius);
    return radius;
}

/* The ridge is not crossed. Its edges within reach, and those of the borders, are listed once each,
 * on the seed's side. */
static void test_ridge(void **state) {
    (void)state;
    fixture f;
    psplat_neighborhood n = {0};
    fixture_grid(&f, 16, 16, place_roof);
    fixture_build(&f);
    fixture_sample(&f, 0.02);
    const double reaches[] = {0.2, 0.6, 1.1, 3, 8};
    for (int r = 0; r < 5; ++r) {
        psplat_metric m = round_metric((double[]){-0.4, 0.07, -0.4});
        double farthest = reaches[r] + 2 * largest_cluster(&f.samples);
        uint32_t triangle = 0;
        size_t ridge = 0, least = 0, most = 0;
        for (uint32_t t = 0; t < f.mesh.triangle_count; ++t) {
            const uint32_t *v = f.mesh.triangles + 3 * (size_t)t;
            double d = point_triangle_distance2(m.center, f.mesh.positions + 3 * (size_t)v[0],
                                                f.mesh.positions + 3 * (size_t)v[1],
                                                f.mesh.positions + 3 * (size_t)v[2]);
            int left = f.surface.face_normals[3 * (size_t)t] < 0;
            if (left && d < 1e-18) triangle = t;
            for (uint32_t k = 0; k < 3; ++k) {
                least += left && f.surface.creases[3 * t + k] && d <= reaches[r] * reaches[r];
                most += left && f.surface.creases[3 * t + k] && d <= farthest * farthest;
            }
        }
        gather(&n, &f, &m, triangle, reaches[r]);
        for (size_t i = 0; i < n.count; ++i) assert_true(n.samples[i].p[0] <= 0.4 + 1e-12);
        for (size_t i = 0; i < n.crease_count; ++i) {
            uint32_t edge = n.creases[i];
            assert_int_equal(f.surface.creases[edge], 1);
            assert_true(f.surface.face_normals[3 * (size_t)(edge / 3)] < 0);
            ridge += f.surface.neighbors[edge] != PSPLAT_NONE;
            for (size_t k = 0; k < i; ++k) assert_true(n.creases[k] != edge);
        }
        /* A cluster that is within reach brings in all its creases. */
        assert_true(n.crease_count >= least && n.crease_count <= most);
        /* distance of the seed from the ridge */
        if (reaches[r] > 0.4 * sqrt(2)) assert_true(ridge > 0);
        assert_int_equal(n.whole, r == 4);
        size_t creases = n.crease_count; /* A call for creases only finds the same ones. */
        assert_int_equal(
            psplat_neighborhood_gather(&n, &f.surface, &f.samples, &m, triangle, reaches[r], 1), 1);
        assert_int_equal(n.crease_count, creases);
        assert_int_equal(n.count, 0);
    }
    psplat_neighborhood_free(&n);
    fixture_free(&f);
}

/* Where triangles are much larger than the reach, only some of their samples are near, so that a
 * greater reach may find more although no triangle is beyond it. */
static void test_large_triangles(void **state) {
    (void)state;
    fixture f;
    psplat_neighborhood n = {0};
    fixture_model(&f, "cube.off");
    fixture_sample(&f, 0.02);
    size_t before = 0;
    for (int r = 1; r < 45; ++r) {
        psplat_metric m = round_metric(f.samples.positions);
        double reach = 0.02 * r * f.surface.diagonal;
        size_t expected = 0, all = 0;
        for (size_t i = 0; i < f.samples.count; ++i) {
            if (f.surface.patches[f.samples.triangles[i]] !=
                f.surface.patches[f.samples.triangles[0]])
                continue;
            ++all;
            expected += distance_in(&m, f.samples.positions + 3 * i) <= reach;
        }
        gather(&n, &f, &m, f.samples.triangles[0], reach);
        assert_int_equal(n.count, expected);
        assert_true(n.count >= before);
        if (n.whole) assert_int_equal(n.count, all);
        before = n.count;
    }
    assert_int_equal(n.whole, 1); /* The reach is 0.88 diagonals, and a face measures 0.82. */
    psplat_neighborhood_free(&n);
    fixture_free(&f);
}

int test_neighborhood_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_stretched),
        cmocka_unit_test(test_fold),
        cmocka_unit_test(test_ridge),
        cmocka_unit_test(test_large_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
