/* SPDX-License-Identifier: MIT
 *
 * test_ray_holes.c - tests of the search for rays that pass between splats: a square under two
 * splats at different heights, where the rays that pass are known for each width of the overlap,
 * with and without a wall under the higher rim.
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
#include "base/region_tree.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "mesh/distance.h"

enum { POINTS = 20000 };

/* Lengths on a square of side 1: the tolerance, how far the splats are from its plane, and how far
 * down a wall reaches. */
static const double tolerance = 0.002, height = 0.0015, wall = 0.001;
static const double middle = 0.5; /* where the higher splat ends */

static void place_square(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

static void begin_square(fixture *f) {
    fixture_grid(f, 3, 3, place_square);
    fixture_build(f);
    f->distance = psplat_distance_create(&f->mesh);
    assert_non_null(f->distance);
}

/* Returns a splat over all of the square that a line cuts: it keeps sign * (x - from) >= 0. */
static psplat_region half(double sign, double from, double z) {
    psplat_region region = {.center = {from, 0.5, z},
                            .u = {1, 0, 0},
                            .v = {0, 1, 0},
                            .n = {0, 0, 1},
                            .radius = {4, 4},
                            .line_count = 1};
    region.lines[0][0] = sign;
    return region;
}

/* Returns a curved splat, flat all the same but for 1e-9 of the square, whose rim is as good as
 * straight where that of half(-1, middle, z) is. */
static psplat_region half_with_wall(double z) {
    const double radius = 4000;
    psplat_region region = half(-1, middle - radius, z);
    region.radius[0] = region.radius[1] = radius;
    region.hessian[2] = 1e-17;
    region.line_count = 0;
    return region;
}

/* Finds the rays that pass between the splats where they overlap by this length. */
static psplat_ray_holes find(const fixture *f, int has_wall, double overlap) {
    psplat_region regions[2] = {has_wall ? half_with_wall(height) : half(-1, middle, height),
                                half(1, middle - overlap, -height)};
    psplat_measured_splats measured = {
        .regions = regions, .count = 2, .tolerance = tolerance, .wall = has_wall ? wall : 0};
    psplat_ray_holes holes;
    measured.region_tree = psplat_region_tree_create(regions, 2, 0);
    assert_non_null(measured.region_tree);
    const psplat_ray_search search = {.surface = &f->surface,
                                      .measured = &measured,
                                      .distance = f->distance,
                                      .points = POINTS,
                                      .seed = 7};
    assert_int_equal(psplat_ray_holes_find(&search, &holes), PSPLAT_OK);
    psplat_region_tree_destroy(measured.region_tree);
    return holes;
}

/* Returns the length along x in which rays of this direction that see the square pass between the
 * splats: they pass the rim of the higher one, or the wall's foot, so high over the lower one, and
 * come to the lower one's plane before its rim. */
static double passing(double cosine, double along_x, double step, double overlap) {
    double slant = sqrt(1 - cosine * cosine) / cosine * along_x;
    double length = step * slant - overlap;
    return length > 0 ? length : 0;
}

/* Returns how many rays pass by the ranges of cosines: eight of each point in each. */
static double expected(double step, double overlap) {
    enum { STEPS = 1000 };
    static const double cosines[] = {0.2, 0.3, 0.55, 1};
    double sum = 0;
    for (int slant = 0; slant < 3; ++slant)
        for (int i = 0; i < STEPS; ++i)
            for (int k = 0; k < STEPS; k += 10) {
                double part = (i + 0.5) / STEPS, angle = 2 * fixture_pi * (k + 5) / STEPS;
                double cosine = cosines[slant] + part * (cosines[slant + 1] - cosines[slant]);
                sum += 10 * passing(cosine, cos(angle), step, overlap) / ((double)STEPS * STEPS);
            }
    return 8 * POINTS * sum;
}

/* The rays pass a step of this height, under the wall where there is one. */
static void check_steps(int has_wall, double step) {
    fixture f;
    begin_square(&f);
    double slant = sqrt(1 - 0.2 * 0.2) / 0.2;
    for (int part = 0; part <= 4; ++part) {
        double overlap = step * slant * part / 4;
        psplat_ray_holes holes = find(&f, has_wall, overlap);
        double wanted = expected(step, overlap);
        for (size_t i = 0; i < holes.count; ++i) {
            const psplat_sight *sight = &holes.holes[i].sight;
            double tilt = sight->direction[0] / sight->direction[2];
            assert_near(holes.holes[i].cosine, sight->direction[2], 1e-12);
            /* The wall's rim is 4 / 1e5 from straight. */
            assert_true(sight->point[0] + (step - height) * tilt >= middle - 4e-5 * has_wall);
            assert_true(sight->point[0] - height * tilt <= middle - overlap);
        }
        print_message("overlap %g: %zu rays pass, %g expected\n", overlap, holes.count, wanted);
        /* Five standard deviations, of which rays of one point share some: their number is three
         * times too uncertain at most. Up to 2 % are beside the outline, tolerance / 0.2 from the
         * ends of the crack. */
        assert_near((double)holes.count, wanted, 5 * sqrt(3 * wanted) + 0.02 * wanted);
        if (part == 4) assert_int_equal(holes.count, 0);
        psplat_ray_holes_free(&holes);
    }
    fixture_free(&f);
}

static void test_steps(void **state) {
    (void)state;
    check_steps(0, 2 * height);
}

static void test_walls(void **state) {
    (void)state;
    check_steps(1, 2 * height - wall);
}

/* Returns whether a ray with a cosine through a point over the middle of the square shows, beside
 * one splat. */
static int shows(psplat_region region, double cosine, double x, double z, double walled) {
    psplat_measured_splats measured = {
        .regions = &region, .count = 1, .tolerance = tolerance, .wall = walled};
    const psplat_ray_hole hole = {{{x, 0.5, z}, {sqrt(1 - cosine * cosine), 0, cosine}}, cosine, 0};
    measured.region_tree = psplat_region_tree_create(&region, 1, 0);
    assert_non_null(measured.region_tree);
    int result = psplat_ray_hole_shows(&hole, &measured);
    psplat_region_tree_destroy(measured.region_tree);
    return result;
}

/* A splat hides holes that it passes by less than 1.5 tolerances, at any slant, whether it is too
 * high or too low; so does its wall, down to its foot. Splats that face away hide nothing. */
static void test_shows(void **state) {
    (void)state;
    static const double cosines[] = {0.1, 0.5, 0.95};
    psplat_region ended = half(-1, -3, 0), walled = half_with_wall(0), away = half(-1, 3, 0);
    away.v[1] = away.n[2] = -1;
    for (size_t i = 0; i < sizeof cosines / sizeof *cosines; ++i) {
        double cosine = cosines[i], tilt = sqrt(1 - cosine * cosine) / cosine;
        for (int side = -1; side <= 1; side += 2) {
            double near = side * 1.49 * tolerance, far = side * 1.51 * tolerance;
            assert_false(shows(half(-1, 3, near), cosine, middle, 0, 0));
            assert_true(shows(half(-1, 3, far), cosine, middle, 0, 0));
            /* One that begins there just before the ray comes, or just behind that. */
            double x = middle + near * tilt;
            assert_false(shows(half(side, x - side * 1e-6, near), cosine, middle, 0, 0));
            assert_true(shows(half(side, x + side * 1e-6, near), cosine, middle, 0, 0));
        }
        assert_true(shows(ended, cosine, middle, 0, 0));
        assert_true(shows(away, cosine, middle, 0, 0));
        /* The rim is 4 / 1e5 from straight; the rays pass it a tenth of the wall over its foot, and
         * as much under that, and then from so far below that the splat's box is out of reach. */
        assert_false(shows(walled, cosine, middle, -0.9 * wall, wall));
        assert_true(shows(walled, cosine, middle, -1.1 * wall, wall));
        assert_true(shows(walled, cosine, middle, -0.9 * wall, 0));
        double below = -0.4 * tolerance - 1.4 * tolerance;
        assert_false(shows(walled, cosine, middle - 1.4 * tolerance * tilt, below, wall));
    }
}

/* Finds the rays that pass between two splats so high over the plane of the square, with so many
 * random points and so far between points of rims; where there are hiders, those that these would
 * hide. A negative width is an overlap. There are two of each splat, so that a single hider is one
 * of few. */
static psplat_ray_holes find_crack(const fixture *f, double z, double width, size_t points,
                                   double spacing, const psplat_measured_splats *hiders) {
    const psplat_region low = half(-1, middle, z), high = half(1, middle + width, z);
    psplat_region regions[4] = {low, high, low, high};
    psplat_measured_splats measured = {.regions = regions, .count = 4, .tolerance = tolerance};
    psplat_ray_holes holes;
    measured.region_tree = psplat_region_tree_create(regions, 4, 0);
    assert_non_null(measured.region_tree);
    const psplat_ray_search search = {.surface = &f->surface,
                                      .measured = &measured,
                                      .distance = f->distance,
                                      .hiders = hiders,
                                      .points = points,
                                      .rim_spacing = spacing,
                                      .seed = 3};
    assert_int_equal(psplat_ray_holes_find(&search, &holes), PSPLAT_OK);
    psplat_region_tree_destroy(measured.region_tree);
    return holes;
}

/* Rays past rims find a crack that is far narrower than random points lie apart, and nothing where
 * there is none: neither where the splats overlap, nor beyond the square, over which they reach. */
static void test_cracks(void **state) {
    (void)state;
    fixture f;
    begin_square(&f);
    double width = 0.05 * tolerance;
    psplat_ray_holes random = find_crack(&f, 0, width, 2000, 0, NULL);
    psplat_ray_holes rims = find_crack(&f, 0, width, 0, tolerance, NULL);
    psplat_ray_holes overlap = find_crack(&f, 0, -tolerance, 0, tolerance, NULL);
    print_message("%zu rays of random points, %zu past rims\n", random.count, rims.count);
    assert_true(rims.count > 100);
    assert_true(rims.count > 10 * random.count);
    for (size_t i = 0; i < rims.count; ++i) {
        const psplat_ray_hole *hole = &rims.holes[i];
        const double *p = hole->sight.point;
        assert_near(p[2], 0, 1e-12);
        assert_near(hole->cosine, hole->sight.direction[2], 1e-12);
        assert_true(p[0] >= middle && p[0] <= middle + width && p[1] >= 0 && p[1] <= 1);
    }
    assert_int_equal(overlap.count, 0);
    psplat_ray_holes_free(&random);
    psplat_ray_holes_free(&rims);
    psplat_ray_holes_free(&overlap);
    fixture_free(&f);
}

/* Returns whether rays are among others, in the same order. */
static int is_among(const psplat_ray_holes *some, const psplat_ray_holes *all) {
    size_t at = 0;
    for (size_t i = 0; i < some->count; ++i, ++at) {
        const psplat_sight *sight = &some->holes[i].sight;
        while (at < all->count && memcmp(sight, &all->holes[at].sight, sizeof *sight)) ++at;
        if (at == all->count) return 0;
    }
    return 1;
}

/* Small splats a few tolerances beside a crack close the flat rays through it that meet them, as
 * one by one tells, and no others. */
static void test_far(void **state) {
    (void)state;
    enum { ROW = 60, POINTS_OF_CRACK = 100000 };
    const double width = 0.5 * tolerance, radius = tolerance, away = 3 * tolerance;
    psplat_region regions[ROW + 2] = {half(-1, middle, 0), half(1, middle + width, 0)};
    fixture f;
    size_t kept = 0;
    begin_square(&f);
    for (int i = 0; i < ROW; ++i)
        regions[i + 2] =
            (psplat_region){.center = {middle + away, (i + 0.5) / ROW, 0.8 * tolerance},
                            .u = {1, 0, 0},
                            .v = {0, 1, 0},
                            .n = {0, 0, 1},
                            .radius = {radius, radius}};
    psplat_measured_splats measured = {
        .regions = regions, .count = ROW + 2, .tolerance = tolerance};
    measured.region_tree = psplat_region_tree_create(regions, measured.count, 0);
    assert_non_null(measured.region_tree);
    const psplat_ray_search search = {.surface = &f.surface,
                                      .measured = &measured,
                                      .distance = f.distance,
                                      .points = POINTS_OF_CRACK,
                                      .seed = 3};
    psplat_ray_holes all = find_crack(&f, 0, width, POINTS_OF_CRACK, 0, NULL), some;
    assert_int_equal(psplat_ray_holes_find(&search, &some), PSPLAT_OK);
    for (size_t i = 0; i < all.count; ++i) {
        int closed = 0;
        for (int k = 2; k < ROW + 2 && !closed; ++k)
            closed = psplat_ray_hole_is_closed(&all.holes[i], &regions[k], tolerance);
        kept += (size_t)!closed;
    }
    print_message("%zu rays, %zu with splats beside the crack\n", all.count, some.count);
    assert_int_equal(some.count, kept);
    assert_true(is_among(&some, &all));
    assert_true(all.count > kept + 20);
    psplat_region_tree_destroy(measured.region_tree);
    psplat_ray_holes_free(&all);
    psplat_ray_holes_free(&some);
    fixture_free(&f);
}

enum { HIDERS = 4 };

/* Makes small curved splats under the crack: the first within the tolerance of the square, the
 * second so far down that it still hides, and the third in the way of no ray. All but the tip of
 * the second, which is narrow, is cut off by a straight line, and half of the fourth, which is as
 * high as the first, by a bent one. */
static void make_hiders(psplat_region hiders[HIDERS]) {
    const double depths[HIDERS] = {0.9 * tolerance, 1.3 * tolerance, 1.8 * tolerance,
                                   0.9 * tolerance};
    const double tip[3] = {1, 0, -0.6}, one_half[3] = {0, -1, -0.1};
    for (int i = 0; i < HIDERS; ++i)
        hiders[i] = (psplat_region){.center = {middle, 0.2 + 0.2 * i, -depths[i]},
                                    .u = {i != 1, i == 1, 0},
                                    .v = {-(i == 1), i != 1, 0},
                                    .n = {0, 0, 1},
                                    .radius = {0.05, i == 1 ? 0.01 : 0.03},
                                    .slope = {0.01, 0},
                                    .hessian = {0.1, 0, 0.1}};
    psplat_region_add_line(&hiders[1], tip, 0);
    psplat_region_add_line(&hiders[3], one_half, -0.5);
}

static int is_hidden(const psplat_ray_hole *hole, const psplat_measured_splats *hiders) {
    for (size_t i = 0; i < hiders->count; ++i)
        if (psplat_ray_hole_is_hidden(hole, &hiders->regions[i], hiders->tolerance, hiders->wall))
            return 1;
    return 0;
}

/* Of the rays through a crack, those are found that one of some hiders would hide, also from far
 * beside it, and no others. Returns how many these are. */
static size_t check_some(const fixture *f, const psplat_ray_holes *all, size_t points,
                         double spacing, psplat_region *regions, size_t count, double high) {
    psplat_measured_splats hiders = {
        .regions = regions, .count = count, .tolerance = tolerance, .wall = high};
    hiders.region_tree = psplat_region_tree_create(regions, count, 0);
    assert_non_null(hiders.region_tree);
    psplat_ray_holes some = find_crack(f, 0.9 * tolerance, tolerance, points, spacing, &hiders);
    size_t matter = 0;
    for (size_t i = 0; i < all->count; ++i) matter += (size_t)is_hidden(&all->holes[i], &hiders);
    for (size_t i = 0; i < some.count; ++i) assert_true(is_hidden(&some.holes[i], &hiders));
    assert_int_equal(some.count, matter);
    assert_true(is_among(&some, all));
    psplat_region_tree_destroy(hiders.region_tree);
    psplat_ray_holes_free(&some);
    return matter;
}

/* Each hider alone, all of them, and none. */
static void check_hiders(const fixture *f, size_t points, double spacing, double high) {
    psplat_region regions[HIDERS];
    size_t matter[HIDERS];
    make_hiders(regions);
    psplat_ray_holes all = find_crack(f, 0.9 * tolerance, tolerance, points, spacing, NULL);
    for (int i = 0; i < HIDERS; ++i)
        matter[i] = check_some(f, &all, points, spacing, &regions[i], 1, high);
    size_t some = check_some(f, &all, points, spacing, regions, HIDERS, high);
    print_message("%zu rays, of which %zu, %zu, %zu and %zu matter, %zu in all\n", all.count,
                  matter[0], matter[1], matter[2], matter[3], some);
    assert_true(matter[0] > 100 && matter[1] > 5 && matter[3] > 2 * matter[1]);
    assert_int_equal(matter[2], 0);
    assert_true(some < all.count / 2);
    assert_int_equal(check_some(f, &all, points, spacing, regions, 0, high), 0);
    psplat_ray_holes_free(&all);
}

static void test_hiders(void **state) {
    (void)state;
    fixture f;
    begin_square(&f);
    check_hiders(&f, 100000, 0, 0);
    check_hiders(&f, 0, tolerance, 0);
    check_hiders(&f, 0, tolerance, wall);
    fixture_free(&f);
}

static void assert_same(const psplat_ray_holes *a, const psplat_ray_holes *b) {
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; ++i) {
        assert_memory_equal(&a->holes[i].sight, &b->holes[i].sight, sizeof(psplat_sight));
        assert_int_equal(a->holes[i].triangle, b->holes[i].triangle);
    }
}

/* The number of threads changes nothing. */
static void test_threads(void **state) {
    (void)state;
    fixture f;
    begin_square(&f);
    fixture_threads(1);
    psplat_ray_holes one = find(&f, 1, 0.001);
    fixture_threads(3);
    psplat_ray_holes three = find(&f, 1, 0.001);
    fixture_threads(0);
    assert_true(one.count > 0);
    assert_same(&one, &three);
    psplat_ray_holes_free(&one);
    psplat_ray_holes_free(&three);
    fixture_free(&f);
}

/* Finds the rays past the rims of splats, by so many threads. */
static psplat_ray_holes find_past_rims(const fixture *f, const psplat_measured_splats *measured,
                                       int threads) {
    const psplat_ray_search search = {.surface = &f->surface,
                                      .measured = measured,
                                      .distance = f->distance,
                                      .rim_spacing = 0.5 * tolerance,
                                      .seed = 5};
    psplat_ray_holes holes;
    fixture_threads(threads);
    assert_int_equal(psplat_ray_holes_find(&search, &holes), PSPLAT_OK);
    fixture_threads(0);
    return holes;
}

/* Nor does it where splats are tilted and lie above each other, so that what a thread remembers of
 * the places before is of use for some rays alone. */
static void test_layers(void **state) {
    (void)state;
    enum { LAYERED = 300 };
    static psplat_region regions[LAYERED];
    psplat_measured_splats measured = {
        .regions = regions, .count = LAYERED, .tolerance = tolerance};
    uint64_t random = 21;
    fixture f;
    begin_square(&f);
    for (int i = 0; i < LAYERED; ++i) {
        psplat_region *r = &regions[i];
        double turn = 2 * fixture_pi * psplat_random_unit(&random);
        double tilt = 0.7 * psplat_random_unit(&random), c = cos(tilt), s = sin(tilt);
        *r = (psplat_region){.u = {c * cos(turn), c * sin(turn), s},
                             .v = {-sin(turn), cos(turn), 0},
                             .n = {-s * cos(turn), -s * sin(turn), c},
                             .radius = {6 * tolerance, 4 * tolerance}};
        for (int k = 0; k < 2; ++k)
            r->center[k] = 0.5 + 30 * tolerance * (psplat_random_unit(&random) - 0.5);
        r->center[2] = 6 * tolerance * (psplat_random_unit(&random) - 0.5);
    }
    measured.region_tree = psplat_region_tree_create(regions, LAYERED, 0);
    assert_non_null(measured.region_tree);
    psplat_ray_holes one = find_past_rims(&f, &measured, 1);
    psplat_ray_holes three = find_past_rims(&f, &measured, 3);
    print_message("%zu rays past layers\n", one.count);
    assert_true(one.count > 50);
    assert_same(&one, &three);
    psplat_region_tree_destroy(measured.region_tree);
    psplat_ray_holes_free(&one);
    psplat_ray_holes_free(&three);
    fixture_free(&f);
}

int test_ray_holes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_steps),   cmocka_unit_test(test_walls),
        cmocka_unit_test(test_shows),   cmocka_unit_test(test_cracks),
        cmocka_unit_test(test_far),     cmocka_unit_test(test_hiders),
        cmocka_unit_test(test_threads), cmocka_unit_test(test_layers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
