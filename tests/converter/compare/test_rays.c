/* SPDX-License-Identifier: MIT
 *
 * test_rays.c - tests of rays against splats and meshes: a square of which known parts are covered,
 * hidden or open, steps between splats, and a sphere of splats with one removed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <cmocka.h>

#include "compare_fixture.h"
#include "compare/rays.h"

/* Rays tried unless a test asks for others, and how near they have to meet, % of the diagonal. */
enum { RAYS = 20000 };
static const double reach = 0.1;

/* Five standard deviations of a count of so many rays of which each counts with a probability. */
static double five_sigma(double part, size_t count) {
    return 5 * sqrt(part * (1 - part) * (double)count);
}

static psplat_ray_errors cast(const fixture *f, scene s, double percent) {
    psplat_ray_errors errors;
    psplat_error error = {0};
    const psplat_ray_desc desc = {.rays = RAYS, .reach = percent, .seed = 3};
    psplat_asset *asset = scene_open(&s);
    if (psplat_rays_compare(f->source, asset, &desc, &errors, &error)) fail_msg("%s", error.text);
    psplat_asset_destroy(asset);
    scene_free(&s);
    return errors;
}

/* All rays meet a splat like the square, and the ranges of cosines get as many each. */
static void test_whole(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    psplat_ray_errors e = cast(&f, fixture_rectangle(0, 1, 0, 1, 0), reach);
    assert_in_range(e.count, RAYS - 2, RAYS + 2);
    assert_int_equal(e.missed + e.hidden + e.outline + e.place_count, 0);
    assert_near(e.reach, reach, 1e-12);
    for (int i = 0; i < PSPLAT_RAY_RANGES; ++i)
        assert_near((double)e.range_count[i], RAYS / 4.0, five_sigma(0.25, RAYS));
    assert_near(psplat_rays_least_cosine(0), PSPLAT_LEAST_RAY_COSINE, 0);
    assert_near(psplat_rays_least_cosine(PSPLAT_RAY_RANGES), 1, 1e-15);
    assert_near(psplat_rays_missed_percent(&e), 0, 0);
    fixture_free(&f);
}

/* A quarter of the square is open: at every cosine, and where the places say. */
static void test_open(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    psplat_ray_errors e = cast(&f, fixture_rectangle(0, 0.75, 0, 1, 0), reach);
    size_t missed = 0;
    /* Up to 1 % of the open quarter is beside the outline: reach / 0.2 from its three borders. */
    double beside = 0.01 * (double)e.count;
    assert_near((double)e.missed, 0.25 * (double)e.count, five_sigma(0.25, e.count) + beside);
    assert_int_equal(e.open, e.missed);
    for (int i = 0; i < PSPLAT_RAY_RANGES; ++i) {
        missed += e.range_missed[i];
        assert_near((double)e.range_missed[i], 0.25 * (double)e.range_count[i],
                    five_sigma(0.25, e.range_count[i]) + beside);
    }
    assert_int_equal(missed, e.missed);
    assert_int_equal(e.place_count, PSPLAT_RAY_PLACES);
    for (size_t i = 0; i < e.place_count; ++i) {
        assert_true(e.places[i].point[0] >= 0.75);
        assert_near(e.places[i].direction[2], e.places[i].cosine, 1e-12);
        assert_true(!i || e.places[i].cosine <= e.places[i - 1].cosine);
    }
    /* These are the greatest of 5,000 cosines that are even on 0.2 ... 1. */
    assert_true(e.places[PSPLAT_RAY_PLACES - 1].cosine > 0.99);
    fixture_free(&f);
}

/* A splat below the square is met within the reach over the cosine, which is its height. */
static void test_reach(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    for (int below = 0; below < 2; ++below) {
        double height = below ? -0.01 : 0.01, percent = 100 * 0.01 / sqrt(2);
        /* It is large enough for all slants: 0.01 * tan(acos(0.2)) is 0.05. */
        psplat_ray_errors near =
            cast(&f, fixture_rectangle(-0.1, 1.1, -0.1, 1.1, height), 1.01 * percent);
        psplat_ray_errors far =
            cast(&f, fixture_rectangle(-0.1, 1.1, -0.1, 1.1, height), 0.99 * percent);
        assert_int_equal(near.missed + near.hidden + near.outline, 0);
        assert_int_equal(far.hidden, below ? 0 : far.count);
        assert_int_equal(far.missed + far.outline, below ? far.count : 0);
        assert_int_equal(far.open, 0); /* They meet it too far behind. */
    }
    fixture_free(&f);
}

/* Two splats at +- height overlap by less than the step between them needs in slanted views. */
static void test_step(void **state) {
    (void)state;
    fixture f;
    fixture_square(&f);
    const double height = 0.004, overlap = 0.01;
    scene s = fixture_rectangle(-0.1, 0.5 + overlap / 2, -0.1, 1.1, height);
    scene low = fixture_rectangle(0.5 - overlap / 2, 1.1, -0.1, 1.1, -height);
    s.splats = realloc(s.splats, 2 * sizeof *s.splats);
    assert_non_null(s.splats);
    s.splats[s.count++] = low.splats[0];
    scene_free(&low);
    psplat_ray_errors e = cast(&f, s, 1);
    assert_true(e.missed > 0);
    for (size_t i = 0; i < e.place_count; ++i) {
        const psplat_ray_place *p = &e.places[i];
        double tilt = p->direction[0] / p->direction[2];
        assert_true(p->point[0] + height * tilt >= 0.5 + overlap / 2 - 1e-5);
        assert_true(p->point[0] - height * tilt <= 0.5 - overlap / 2 + 1e-5);
        assert_true(2 * height * tilt >= overlap - 2e-5);
    }
    fixture_free(&f);
}

/* Nobody sees the inner sides of a box from outside. */
static void test_blocked(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "cube.off");
    double half = f.source->surface.diagonal / sqrt(12);
    scene s = scene_cube((float)half);
    for (int k = 0; k < 3; ++k) s.origin[k] = f.source->center[k];
    psplat_ray_errors e = cast(&f, s, reach);
    assert_in_range(e.count, RAYS - 10, RAYS + 10);
    assert_int_equal(e.missed, 0);
    fixture_free(&f);
}

/* Without three neighbouring splats, a sphere is open there and nowhere else. */
static void test_sphere(void **state) {
    (void)state;
    enum { SPLATS = 300, REMOVED = 3 }; /* The first ones lie around a pole. */
    fixture f;
    fixture_model(&f, "sphere.ply");
    for (int removed = 0; removed < 2; ++removed) {
        scene s = scene_sphere(SPLATS, (float)f.source->radius);
        double center[3];
        for (int k = 0; k < 3; ++k) {
            s.origin[k] = f.source->center[k];
            center[k] = f.source->center[k] + (double)s.splats[0].center[k];
        }
        double radius = (double)s.splats[0].radius[0];
        for (int i = 0; i < REMOVED && removed; ++i) s.splats[i] = s.splats[REMOVED];
        /* Discs leave a sphere by the square of their radius over twice its own. */
        psplat_ray_errors e = cast(&f, s, 2);
        assert_int_equal(e.missed > 20, removed);
        if (!removed) assert_int_equal(e.missed, 0);
        for (size_t i = 0; i < e.place_count; ++i)
            assert_true(distance2_3(e.places[i].point, center) <= 9 * radius * radius);
    }
    fixture_free(&f);
}

/* A mesh in place of splats is measured in the same way. */
static void test_mesh(void **state) {
    (void)state;
    fixture f, part;
    static const double positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
    static const uint32_t triangles[] = {0, 1, 2};
    psplat_ray_errors e;
    const psplat_ray_desc desc = {.rays = RAYS, .reach = reach};
    fixture_square(&f);
    fixture_mesh(&part, positions, 3, triangles, 1);
    assert_int_equal(psplat_rays_compare_mesh(f.source, part.source, &desc, &e, NULL), PSPLAT_OK);
    assert_near((double)e.missed, 0.5 * (double)e.count,
                five_sigma(0.5, e.count) + 0.01 * (double)e.count); /* 1 % beside the outline */
    assert_int_equal(e.hidden, 0);
    assert_int_equal(psplat_rays_compare_mesh(f.source, f.source, NULL, &e, NULL), PSPLAT_OK);
    assert_in_range(e.count, 99990, 100010); /* by default */
    assert_int_equal(e.missed + e.hidden + e.outline, 0);
    fixture_free(&part);
    fixture_free(&f);
}

int test_rays_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole), cmocka_unit_test(test_open),    cmocka_unit_test(test_reach),
        cmocka_unit_test(test_step),  cmocka_unit_test(test_blocked), cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
