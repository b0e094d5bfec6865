/* SPDX-License-Identifier: MIT
 *
 * test_shape_errors.c - tests of shape errors (distances, normals, coverage, overhang) between a
 * mesh and splats or another mesh, where they are known exactly: squares, triangles and cubes with
 * splats at known heights, angles and gaps.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <cmocka.h>

#include "compare_fixture.h"
#include "compare/statistics.h"
#include "compare/shape_errors.h"

static const double degrees = 180 / 3.14159265358979323846;
/* Float rounding of coordinates near 1, in % of a diagonal near 1. */
static const double single = 3e-5;
/* Float rounding of the source's normals, some 1e-7 radians, in degrees. */
static const double single_degrees = 3e-5;
/* diagonal of the square */
static const double root2 = 1.41421356237309505;

/* Returns five standard deviations, in %, of a proportion estimated from `count` independent
 * points. */
static double five_sigma(double part, size_t count) {
    return 5 * 100 * sqrt(part * (1 - part) / (double)count);
}

static void assert_spread(psplat_statistics s, double max, double rms, double p95,
                          double tolerance) {
    assert_near(s.max, max, tolerance);
    assert_near(s.rms, rms, tolerance);
    assert_near(s.p95, p95, tolerance);
}

/* A splat equal to the square has no error. */
static void test_same(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    scene s = fixture_rectangle(0, 1, 0, 1, 0);
    psplat_asset *asset = scene_open(&s);
    psplat_shape_errors e;
    assert_int_equal(psplat_shape_compare(f.source, asset, NULL, &e, NULL), PSPLAT_OK);
    psplat_asset_destroy(asset);
    scene_free(&s);
    assert_near(e.diagonal, root2, 1e-12);
    assert_int_equal(e.elements, 1);
    /* 200,000 samples in all, plus the corners */
    assert_in_range(e.source_samples, 199990, 200020);
    assert_in_range(e.target_samples, 199990, 200020);
    assert_spread(e.outward, 0, 0, 0, single);
    assert_spread(e.inward, 0, 0, 0, single);
    assert_spread(e.distance, 0, 0, 0, single);
    assert_spread(e.normal, 0, 0, 0, single_degrees);
    assert_near(e.uncovered_area, 0, 0);
    assert_near(e.overhang_area, 0, 0);
    assert_near(e.crease_area, 0, 0);      /* borders are no creases */
    assert_near(e.reach, 2 / root2, 1e-6); /* the reach follows the scene's depth tolerance, 0.01 */
    fixture_free(&f);
}

/* One splat lies above one triangle, so that every distance is its height. */
static void test_height(void **state) {
    (void)state;
    static const double positions[] = {0, 0, 0, 3, 0, 0, 0, 4, 0};
    static const uint32_t triangles[] = {0, 1, 2};
    fixture f;
    fixture_mesh(&f, positions, 3, triangles, 1);
    for (int above = 0; above < 2; ++above) {
        scene s = scene_blank(1);
        psplat_splat *splat = &s.splats[0];
        double height = above ? 0.125 : -0.125; /* 2.5 % of the diagonal, 5 */
        splat->radius[0] = splat->radius[1] = 8;
        splat->center[2] = (float)height;
        splat->clip_count = 3; /* x >= 0, y >= 0 and 4 x + 3 y <= 12 */
        splat->clip[0][0] = 1, splat->clip[1][1] = 1;
        splat->clip[2][0] = -32, splat->clip[2][1] = -24, splat->clip[2][2] = 12;
        psplat_asset *asset = scene_open(&s);
        psplat_shape_errors near =
            fixture_compare_asset(&f, asset, &(psplat_shape_desc){.reach = 3});
        psplat_shape_errors far =
            fixture_compare_asset(&f, asset, &(psplat_shape_desc){.reach = 2.4});
        assert_spread(near.outward, 2.5, 2.5, 2.5, single);
        assert_spread(near.inward, 2.5, 2.5, 2.5, single);
        assert_spread(near.distance, 2.5, 2.5, 2.5, single);
        assert_spread(near.normal, 0, 0, 0, single_degrees);
        assert_near(near.uncovered_area, 0, 0);
        assert_near(near.overhang_area, 100, 0); /* farther than 1.5 % */
        assert_near(far.uncovered_area, 100, 0);
        assert_spread(far.normal, 0, 0, 0, 0); /* no point counts */
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    fixture_free(&f);
}

/* A splat whose back is to the viewer covers nothing, however near it is. */
static void test_back(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    scene s = fixture_rectangle(0, 1, 0, 1, 0);
    scene_set_axes(&s.splats[0], (const double[]){0, 1, 0}, (const double[]){1, 0, 0});
    s.splats[0].normal[2] = -1;
    psplat_shape_errors e = fixture_compare(&f, s, NULL);
    assert_spread(e.distance, 0, 0, 0, single);
    assert_near(e.uncovered_area, 100, 0);
    fixture_free(&f);
}

/* A quarter of the square is open. */
static void test_hole(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    psplat_shape_errors e = fixture_compare(&f, fixture_rectangle(0, 0.75, 0, 1, 0), NULL);
    assert_near(e.uncovered_area, 25, five_sigma(0.25, FIXTURE_SAMPLES));
    assert_near(e.overhang_area, 0, 0);
    assert_near(e.outward.max, 25 / root2, single); /* found at the corners of the mesh */
    assert_near(e.inward.max, 0, single);
    /* The mean of x^2 is taken over a quarter of 0 ... 1, and 5 % of points are beyond 0.2. Both
     * are estimates from samples, whose five standard deviations are 1.5 %. */
    assert_near(e.outward.rms, 100 / root2 * sqrt(0.25 * 0.25 * 0.25 / 3), 0.2);
    assert_near(e.outward.p95, 100 / root2 * 0.2, 0.4);
    assert_near(e.distance.rms, e.outward.rms / sqrt(2), single);
    /* A twentieth of both sides is a tenth of the source. */
    assert_near(e.distance.p95, 100 / root2 * 0.15, 0.4);
    assert_near(e.distance.max, e.outward.max, 0);
    fixture_free(&f);
}

/* A splat reaches across a border by a fifth of the square. */
static void test_overhang(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    const psplat_shape_desc desc = {.reach = 100 * 0.2 / root2}; /* half of it hangs over too far */
    psplat_shape_errors e = fixture_compare(&f, fixture_rectangle(0, 1.2, 0, 1, 0), &desc);
    assert_near(e.uncovered_area, 0, 0);
    assert_near(e.overhang_area, 100 * 0.1 / 1.2, five_sigma(1 / 12.0, FIXTURE_SAMPLES));
    assert_near(e.outward.max, 0, single);
    assert_near(e.inward.max, 20 / root2, single);
    assert_near(e.inward.rms, 100 / root2 * sqrt(0.2 * 0.2 * 0.2 / 3 / 1.2), 0.2);
    fixture_free(&f);
}

/* A disc reaches beyond all sides, which tests the sampling of its curved outline. */
static void test_disc(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    scene s = scene_disc(1);
    s.splats[0].center[0] = s.splats[0].center[1] = 0.5f;
    const psplat_shape_desc desc = {.reach = 1e-3};
    psplat_shape_errors e = fixture_compare(&f, s, &desc);
    double outside = 1 - 1 / 3.14159265358979323846; /* exact to 1e-5 of a diagonal */
    assert_near(e.overhang_area, 100 * outside, five_sigma(outside, FIXTURE_SAMPLES));
    assert_near(e.inward.max, 50 / root2, single);
    assert_near(e.outward.max, 0, single);
    fixture_free(&f);
}

/* The normal leans by 10 degrees everywhere. */
static void test_tilted(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    scene s = fixture_rectangle(0, 1, 0, 1, 0);
    s.splats[0].normal[0] = (float)sin(10 / degrees);
    s.splats[0].normal[2] = (float)cos(10 / degrees);
    psplat_shape_errors e = fixture_compare(&f, s, NULL);
    assert_spread(e.normal, 10, 10, 10, single_degrees);
    assert_spread(e.face_normal, 10, 10, 10, single_degrees);
    assert_spread(e.crease_normal, 0, 0, 0, 0);
    fixture_free(&f);
}

/* Two splats with normals leaning to either side blend to the middle normal where their weights are
 * equal. */
static void test_blended(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    scene s = scene_blank(2);
    for (int i = 0; i < 2; ++i) {
        s.splats[i].radius[0] = s.splats[i].radius[1] = 2;
        s.splats[i].center[0] = s.splats[i].center[1] = 0.5f;
        s.splats[i].normal[i] = (float)sin(60 / degrees);
        s.splats[i].normal[2] = (float)cos(60 / degrees);
    }
    /* The blended normal is (tan, tan, 2) / 2, which leans by atan(tan 60 / sqrt 2). */
    psplat_shape_errors e = fixture_compare(&f, s, NULL);
    double angle = atan(tan(60 / degrees) / root2) * degrees;
    assert_spread(e.normal, angle, angle, angle, single_degrees);
    fixture_free(&f);
}

/* Of two splats farther apart than the depth tolerance, only the upper one is seen (spec 5.3). */
static void test_hidden(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    for (int hidden = 0; hidden < 2; ++hidden) {
        scene s = scene_blank(2);
        for (int i = 0; i < 2; ++i) {
            s.splats[i].radius[0] = s.splats[i].radius[1] = 2;
            s.splats[i].center[2] = (float)(i ? -0.03 : 0.03);
        }
        s.depth_tolerance = hidden ? 0.05f : 0.07f;
        s.splats[1].normal[0] = s.splats[1].normal[2] = (float)sqrt(0.5);
        psplat_shape_errors e = fixture_compare(&f, s, NULL);
        /* (0, 0, 1) + (1, 0, 1) at equal weights */
        double angle = hidden ? 0 : atan(0.5) * degrees;
        assert_spread(e.normal, angle, angle, angle, single_degrees);
    }
    fixture_free(&f);
}

/* On each face of a cube, a normal field is exact in the middle and has errors towards the creases:
 * the angle at u is atan(u / 2). */
static void test_creases(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "cube.off");
    double half = f.mesh.positions[0] < 0 ? -f.mesh.positions[0] : f.mesh.positions[0];
    scene s = scene_cube((float)half);
    for (int k = 0; k < 3; ++k) s.origin[k] = f.mesh.origin[k];
    double edge = half / (double)s.splats[0].radius[0]; /* (u, v) at the edge */
    for (size_t i = 0; i < s.count; ++i) s.splats[i].gradient[0] = 0.5f;
    /* A tenth of each face on every side is within the crease width. */
    const psplat_shape_desc desc = {.crease_width = 100 * 0.2 * half / (half * sqrt(12))};
    psplat_shape_errors e = fixture_compare(&f, s, &desc);
    assert_near(e.crease_width, desc.crease_width, 1e-12);
    assert_near(e.crease_area, 36, five_sigma(0.36, FIXTURE_SAMPLES));
    /* The maxima are as close to the edges as samples come: 0.3 % of a face. */
    assert_near(e.crease_normal.max, atan(0.5 * edge) * degrees, 0.1);
    assert_near(e.face_normal.max, atan(0.5 * 0.8 * edge) * degrees, 0.1);
    assert_near(e.normal.max, e.crease_normal.max, 0);
    assert_true(e.face_normal.rms < e.normal.rms && e.normal.rms < e.crease_normal.rms);
    /* The values near and away from creases make up the whole, weighted by their areas. */
    double parts = e.crease_area / 100 * e.crease_normal.rms * e.crease_normal.rms +
                   (1 - e.crease_area / 100) * e.face_normal.rms * e.face_normal.rms;
    assert_near(sqrt(parts), e.normal.rms, 1e-9);
    assert_near(e.uncovered_area, 0, 0.01); /* rounding to float at the creases */
    fixture_free(&f);
}

/* The common edge of three sheets is a crease; their outer ends are borders and no creases. */
static void test_junction(void **state) {
    (void)state;
    static const double positions[] = {0,  0, 0, 0,  1, 0, 1, 0, 0, 1, 1, 0,
                                       -1, 0, 0, -1, 1, 0, 0, 0, 1, 0, 1, 1};
    static const uint32_t triangles[] = {0, 2, 3, 0, 3, 1, 4, 0, 1, 4, 1, 5, 0, 6, 7, 0, 7, 1};
    fixture f;
    fixture_mesh(&f, positions, 8, triangles, 6);
    /* A tenth of each of the three unit squares counts; the diagonal is sqrt(4 + 1 + 1). */
    const psplat_shape_desc desc = {.crease_width = 100 * 0.1 / sqrt(6)};
    psplat_shape_errors e = fixture_compare(&f, fixture_rectangle(-1, 1, 0, 1, 0), &desc);
    assert_near(e.crease_area, 10, five_sigma(0.1, FIXTURE_SAMPLES));
    fixture_free(&f);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static void test_mesh_same(void **state) {
    (void)state;
    fixture f, same;
    fixture_model(&f, "cube.off");
    fixture_model(&same, "cube.off");
    psplat_shape_errors e = fixture_compare_mesh(&f, &same, NULL);
    assert_int_equal(e.elements, 12);
    assert_near(e.reach, 1, 1e-12);
    assert_near(e.crease_width, 1, 1e-12);
    assert_spread(e.distance, 0, 0, 0, 1e-10);
    assert_spread(e.face_normal, 0, 0, 0, single_degrees);
    /* A sample on an edge may get the neighbour's normal. */
    assert_near(e.crease_normal.p95, 0, single_degrees);
    assert_near(e.uncovered_area, 0, 0.01);
    assert_near(e.overhang_area, 0, 0);
    fixture_free(&f);
    fixture_free(&same);
}

/* A square is shifted sideways and up, with another origin. */
static void test_mesh_shifted(void **state) {
    (void)state;
    fixture f, other;
    fixture_square(&f);
    fixture_square(&other);
    other.mesh.origin[0] = 0.25, other.mesh.origin[2] = 0.01;
    fixture_finish(&other);
    psplat_shape_errors e = fixture_compare_mesh(&f, &other, NULL);
    double far = 100 / root2 * hypot(0.25, 0.01);
    assert_near(e.outward.max, far, 1e-9); /* The vertices are among the points. */
    assert_near(e.inward.max, far, 1e-9);
    assert_near(e.uncovered_area, 25, five_sigma(0.25, FIXTURE_SAMPLES));
    /* Its height of 0.7 % is more than half of the reach, 1 %. */
    assert_near(e.overhang_area, 100, 0);
    assert_spread(e.normal, 0, 0, 0, single_degrees);
    fixture_free(&f);
    fixture_free(&other);
}

/* ---- places ---------------------------------------------------------------------------------- */

static void test_probe(void **state) {
    (void)state;
    fixture f, other;
    fixture_square(&f);
    fixture_square(&other);
    for (int k = 0; k < 3; ++k) f.mesh.origin[k] = 10 * (k + 1);
    scene s = fixture_rectangle(0, 0.75, 0, 1, 0.005);
    for (int k = 0; k < 3; ++k) s.origin[k] = f.mesh.origin[k];
    s.splats[0].normal[0] = (float)sin(10 / degrees);
    s.splats[0].normal[2] = (float)cos(10 / degrees);
    psplat_asset *asset = scene_open(&s);
    psplat_shape_probe *probe, *mesh_probe;
    double distance, angle, up[3] = {0, 0, 2};
    assert_int_equal(psplat_shape_probe_create(f.source, asset, NULL, &probe, NULL), PSPLAT_OK);
    psplat_asset_destroy(asset);
    psplat_shape_probe_at(probe, (const double[]){10.5, 20.5, 30}, up, &distance, &angle);
    assert_near(distance, 0.5 / root2, single);
    assert_near(angle, 10, single_degrees);
    psplat_shape_probe_at(probe, (const double[]){10.95, 20.5, 30}, up, &distance, &angle);
    assert_near(distance, 100 * hypot(0.2, 0.005) / root2, single);
    assert_true(angle < 0);
    psplat_shape_probe_destroy(probe);
    psplat_shape_probe_destroy(NULL);
    assert_int_equal(
        psplat_shape_probe_create_mesh(f.source, other.source, NULL, &mesh_probe, NULL), PSPLAT_OK);
    psplat_shape_probe_at(mesh_probe, (const double[]){0.5, 0.5, 0.01}, up, &distance, &angle);
    assert_near(distance, 1 / root2, 1e-9);
    assert_near(angle, 0, single_degrees);
    psplat_shape_probe_destroy(mesh_probe);
    scene_free(&s);
    fixture_free(&f);
    fixture_free(&other);
}

/* ---- settings -------------------------------------------------------------------------------- */

/* Equal seeds give equal results, and other seeds do not; the numbers of samples are kept. */
static void test_settings(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "part.obj");
    scene s = scene_sphere(300, 2);
    psplat_asset *asset = scene_open(&s);
    psplat_shape_desc desc = {.samples = 3000, .seed = 5};
    psplat_shape_errors a = fixture_compare_asset(&f, asset, &desc);
    psplat_shape_errors b = fixture_compare_asset(&f, asset, &desc);
    desc.seed = 6;
    psplat_shape_errors other = fixture_compare_asset(&f, asset, &desc);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.outward.rms != other.outward.rms && a.inward.rms != other.inward.rms);
    /* Each is an estimate from 3000 samples, so that 5 % are about five standard deviations. */
    assert_near(other.outward.rms / a.outward.rms, 1, 0.05);
    assert_in_range(a.source_samples, 3000, 6002);
    assert_in_range(a.target_samples, 2900 + 300 * 8, 3000 + 300 * 12);
    psplat_asset_destroy(asset);
    scene_free(&s);
    fixture_free(&f);
}

/* A target without a surface is infinitely far, and covers nothing. */
static void test_nothing(void **state) {
    (void)state;
    static const double flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    fixture f;
    fixture_square(&f);
    scene s = fixture_rectangle(0, 1, 0, 1, 0);
    psplat_asset *asset = fixture_open(&s, flat); /* a singular matrix, which draws nothing */
    psplat_shape_errors e = fixture_compare_asset(&f, asset, &(psplat_shape_desc){.samples = 100});
    assert_true(isinf(e.outward.max) && isinf(e.outward.rms) && isinf(e.distance.max));
    assert_int_equal(e.elements, 0);
    assert_int_equal(e.target_samples, 0);
    assert_near(e.inward.max, 0, 0);
    assert_near(e.uncovered_area, 100, 0);
    assert_near(e.reach, 1, 0);
    psplat_asset_destroy(asset);
    scene_free(&s);
    fixture_free(&f);
}

int test_shape_errors_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same),      cmocka_unit_test(test_height),
        cmocka_unit_test(test_back),      cmocka_unit_test(test_hole),
        cmocka_unit_test(test_overhang),  cmocka_unit_test(test_disc),
        cmocka_unit_test(test_tilted),    cmocka_unit_test(test_blended),
        cmocka_unit_test(test_hidden),    cmocka_unit_test(test_creases),
        cmocka_unit_test(test_mesh_same), cmocka_unit_test(test_mesh_shifted),
        cmocka_unit_test(test_probe),     cmocka_unit_test(test_settings),
        cmocka_unit_test(test_nothing),   cmocka_unit_test(test_junction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
