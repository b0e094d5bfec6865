/* SPDX-License-Identifier: MIT
 *
 * test_region_tree.c - tests of finding regions near a point: the tree of boxes against a test of
 * all boxes and against the ellipses themselves. Regions are random ellipses of all sizes, some of
 * them needles and some equal.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"

enum { MOST = 700 };

typedef struct visits {
    uint8_t counts[MOST];
    size_t total, stop_after;
} visits;

static int visit(void *user, uint32_t region) {
    visits *v = user;
    assert_true(region < MOST);
    v->counts[region]++;
    return ++v->total == v->stop_after;
}

/* Makes regions of all sizes; some of them are needles, and some are equal to others. */
static void make_regions(psplat_region *regions, size_t count, double scale, uint64_t *random) {
    for (size_t i = 0; i < count; ++i) {
        psplat_region *r = &regions[i];
        if (i % 7 == 6) {
            *r = regions[i - 3];
            continue;
        }
        *r = (psplat_region){.line_count = 0};
        random_axes(random, r->u, r->v, r->n);
        for (int k = 0; k < 3; ++k) r->center[k] = scale * psplat_random_unit(random);
        r->radius[0] = 0.3 * scale * pow(psplat_random_unit(random), 3);
        r->radius[1] = r->radius[0] * (i % 3 ? psplat_random_unit(random) : 1e-6);
    }
}

typedef struct extent {
    double low[3], high[3];
} extent;

static void include(extent *e, const double p[3]) {
    for (int k = 0; k < 3; ++k) {
        e->low[k] = min2(e->low[k], p[k]);
        e->high[k] = max2(e->high[k], p[k]);
    }
}

/* Stores a box that the region's own box must contain, around corners of its outline, and one that
 * must contain it: that of the whole ellipse, 2 % larger, since the tree uses a circumscribed
 * polygon of 16 sides. */
static void extents_of(const psplat_region *r, extent *inner, extent *outer) {
    const extent none = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    double outline[68][2], p[3];
    size_t corners = psplat_region_polygon(r, 1, outline, 68);
    *inner = *outer = none;
    for (size_t i = 0; i < corners; ++i) {
        region_point(r, 0.999999 * outline[i][0], 0.999999 * outline[i][1], 0, p);
        include(inner, p);
    }
    for (int i = 0; i < 256; ++i) {
        double angle = 2 * fixture_pi * i / 256;
        region_point(r, 1.021 * cos(angle), 1.021 * sin(angle), 0, p);
        include(outer, p);
    }
    region_point(r, 0, 0, 0, p); /* Where lines leave nothing, the box is that of the centre. */
    include(outer, p);
}

static int box_holds(const extent *e, double reach, const double p[3]) {
    for (int k = 0; k < 3; ++k)
        if (p[k] < e->low[k] - reach || p[k] > e->high[k] + reach) return 0;
    return 1;
}

static void check_points(const psplat_region *regions, size_t count, double scale,
                         uint64_t *random) {
    static extent inner[MOST], outer[MOST];
    double reach = 0.02 * scale;
    for (size_t r = 0; r < count; ++r) extents_of(&regions[r], &inner[r], &outer[r]);
    psplat_region_tree *region_tree = psplat_region_tree_create(regions, count, reach);
    assert_non_null(region_tree);
    size_t found = 0;
    for (int i = 0; i < 60; ++i) {
        double p[3];
        for (int k = 0; k < 3; ++k) p[k] = scale * (1.4 * psplat_random_unit(random) - 0.2);
        visits v = {.total = 0};
        psplat_region_tree_visit(region_tree, p, visit, &v);
        found += v.total;
        for (size_t r = 0; r < count; ++r) {
            assert_true(v.counts[r] <= 1);
            if (box_holds(&inner[r], reach * (1 - 1e-9), p)) assert_int_equal(v.counts[r], 1);
            if (!box_holds(&outer[r], reach * (1 + 1e-9), p)) assert_int_equal(v.counts[r], 0);
        }
        if (v.total < 2) continue;
        visits first = {.stop_after = 2};
        psplat_region_tree_visit(region_tree, p, visit, &first);
        assert_int_equal(first.total, 2);
    }
    assert_true(count < 100 || found > 60); /* There was something to find. */
    psplat_region_tree_destroy(region_tree);
}

static void test_random(void **state) {
    (void)state;
    static psplat_region regions[MOST];
    const size_t counts[] = {1, 2, 4, 5, 6, 9, 64, MOST};
    const double scales[] = {1, 1e-9, 1e9};
    uint64_t random = 11;
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k)
        for (size_t s = 0; s < 3; ++s) {
            if (s && counts[k] > 64) continue;
            make_regions(regions, counts[k], scales[s], &random);
            check_points(regions, counts[k], scales[s], &random);
        }
}

/* Every point of an ellipse, and every point within reach of one, finds that ellipse. */
static void test_sound(void **state) {
    (void)state;
    static psplat_region regions[MOST];
    uint64_t random = 12;
    make_regions(regions, MOST, 1, &random);
    psplat_region_tree *region_tree = psplat_region_tree_create(regions, MOST, 0.1);
    assert_non_null(region_tree);
    for (size_t r = 0; r < MOST; ++r) {
        double p[3], angle = 2 * fixture_pi * psplat_random_unit(&random);
        region_point(&regions[r], cos(angle), sin(angle), 0.0999 * (r % 2 ? -1 : 1), p);
        visits v = {.total = 0};
        psplat_region_tree_visit(region_tree, p, visit, &v);
        assert_int_equal(v.counts[r], 1);
    }
    psplat_region_tree_destroy(region_tree);
}

/* Returns whether a box, grown by a length, holds a point of a segment: it is clipped by one pair
 * of sides after the other. */
static int box_cuts(const extent *e, double length, const double from[3], const double to[3]) {
    double first = 0, last = 1;
    for (int k = 0; k < 3; ++k) {
        double way = to[k] - from[k], low = e->low[k] - length, high = e->high[k] + length;
        if (way == 0) {
            if (from[k] < low || from[k] > high) return 0;
            continue;
        }
        double in = ((way > 0 ? low : high) - from[k]) / way;
        double out = ((way > 0 ? high : low) - from[k]) / way;
        first = max2(first, in);
        last = min2(last, out);
    }
    return first <= last;
}

/* Makes a segment: any one, one along an axis, or a point. */
static void make_segment(int kind, double scale, uint64_t *random, double from[3], double to[3]) {
    for (int k = 0; k < 3; ++k) {
        from[k] = scale * (1.4 * psplat_random_unit(random) - 0.2);
        to[k] = from[k];
        if (kind % 4 < 2 || (kind % 4 == 2 && k == kind / 4 % 3))
            to[k] += scale * (psplat_random_unit(random) - 0.5);
    }
}

/* Segments find the regions whose boxes they meet, grown by what is asked for, and no others. */
static void test_segments(void **state) {
    (void)state;
    enum { COUNT = 300 };
    static psplat_region regions[COUNT];
    static extent inner[COUNT], outer[COUNT];
    const double scales[] = {1, 1e-9, 1e9};
    uint64_t random = 14;
    for (int s = 0; s < 3; ++s) {
        double reach = 0.01 * scales[s], from[3], to[3];
        size_t found = 0, missed = 0;
        make_regions(regions, COUNT, scales[s], &random);
        for (size_t r = 0; r < COUNT; ++r) extents_of(&regions[r], &inner[r], &outer[r]);
        psplat_region_tree *region_tree = psplat_region_tree_create(regions, COUNT, reach);
        assert_non_null(region_tree);
        for (int i = 0; i < 400; ++i) {
            double length = i % 3 ? 0.05 * scales[s] * psplat_random_unit(&random) : 0;
            visits v = {.total = 0};
            make_segment(i, scales[s], &random, from, to);
            psplat_region_tree_visit_segment(region_tree, from, to, length, visit, &v);
            for (size_t r = 0; r < COUNT; ++r) {
                assert_true(v.counts[r] <= 1);
                if (box_cuts(&inner[r], (reach + length) * (1 - 1e-9), from, to))
                    assert_int_equal(v.counts[r], 1);
                if (!box_cuts(&outer[r], (reach + length) * (1 + 1e-9), from, to))
                    assert_int_equal(v.counts[r], 0);
            }
            found += v.total;
            missed += COUNT - v.total;
            if (v.total < 2) continue;
            visits first = {.stop_after = 2};
            psplat_region_tree_visit_segment(region_tree, from, to, length, visit, &first);
            assert_int_equal(first.total, 2);
        }
        assert_true(found > 400 && missed > 400); /* There was something to find, and to miss. */
        psplat_region_tree_destroy(region_tree);
    }
}

/* There are no regions, or many that no plane can separate. */
static void test_degenerate(void **state) {
    (void)state;
    static psplat_region regions[MOST];
    const double here[3] = {0, 0, 0}, there[3] = {0, 2, 0};
    visits v = {.total = 0};
    psplat_region_tree *region_tree = psplat_region_tree_create(regions, 0, 1);
    assert_non_null(region_tree);
    psplat_region_tree_visit(region_tree, here, visit, &v);
    assert_int_equal(v.total, 0);
    psplat_region_tree_destroy(region_tree);
    for (size_t r = 0; r < MOST; ++r)
        regions[r] =
            (psplat_region){.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
    region_tree = psplat_region_tree_create(regions, MOST, 0.5);
    assert_non_null(region_tree);
    psplat_region_tree_visit(region_tree, here, visit, &v);
    assert_int_equal(v.total, MOST);
    psplat_region_tree_visit(region_tree, there, visit, &v);
    assert_int_equal(v.total, MOST);
    psplat_region_tree_destroy(region_tree);
    psplat_region_tree_destroy(NULL);
}

/* Makes a region whose slopes are at most steep, with lines bent both ways. */
static psplat_region curved_region(uint64_t *random, double steep, uint32_t lines) {
    psplat_region r = {.line_count = lines, .radius = {2, 0.2 + 1.8 * psplat_random_unit(random)}};
    random_axes(random, r.u, r.v, r.n);
    for (int k = 0; k < 3; ++k) r.center[k] = 2 * psplat_random_unit(random) - 1;
    for (int k = 0; k < 2; ++k) r.slope[k] = steep * (0.6 * psplat_random_unit(random) - 0.3);
    for (int k = 0; k < 3; ++k)
        r.hessian[k] = steep * (psplat_random_unit(random) - 0.5) / r.radius[k == 2];
    for (uint32_t i = 0; i < lines; ++i) {
        double angle = 2 * fixture_pi * psplat_random_unit(random);
        r.lines[i][0] = cos(angle), r.lines[i][1] = sin(angle);
        r.lines[i][2] = 0.1 + 0.6 * psplat_random_unit(random);
        r.bends[i] = 8 * psplat_random_unit(random) - 4;
    }
    return r;
}

/* Returns how far a region's box reaches along an axis, to the side of sign, by halving. */
static double box_end(const psplat_region_tree *region_tree, int axis, int sign) {
    double low = -20, high = 20;
    while (high - low > 1e-9) {
        double from[3] = {-99, -99, -99}, to[3] = {99, 99, 99}, middle = 0.5 * (low + high);
        visits v = {.total = 0};
        *(sign > 0 ? &from[axis] : &to[axis]) = sign * middle;
        psplat_region_tree_visit_box(region_tree, from, to, visit, &v);
        if (v.total)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Boxes hold all of curved, clipped surfaces, and are not much wider: the polygon of 16 sides is up
 * to 2 % wider than the ellipse, tangents stand for bent lines, and heights that curve both ways
 * are bounded one by one. */
static void test_curved(void **state) {
    (void)state;
    uint64_t random = 13;
    double widest = 0;
    for (uint32_t i = 0; i < 120; ++i) {
        psplat_region r = curved_region(&random, i % 3 ? 0.7 : 4, i / 3 % 4);
        psplat_region_tree *region_tree = psplat_region_tree_create(&r, 1, 0);
        extent held = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
        assert_non_null(region_tree);
        for (int k = 0; k < 100 * 100; ++k) {
            const double uv[2] = {k % 100 / 49.5 - 1, k / 100 / 49.5 - 1};
            double p[3];
            psplat_region_point(&r, uv, p);
            if (psplat_region_contains(&r, uv, 1, 0)) include(&held, p);
        }
        for (int k = 0; k < 6 && held.low[0] < HUGE_VAL; ++k) {
            int axis = k / 2, sign = k % 2 ? 1 : -1;
            double end = box_end(region_tree, axis, sign);
            double beyond = end - (k % 2 ? held.high[axis] : -held.low[axis]);
            assert_true(beyond >= -1e-8);
            widest = max2(widest, beyond / 2); /* in first radii */
        }
        psplat_region_tree_destroy(region_tree);
    }
    assert_true(widest < 1);
}

/* Returns whether the tree finds its only region at a point. */
static int finds(const psplat_region_tree *region_tree, const double point[3]) {
    visits v = {.total = 0};
    psplat_region_tree_visit(region_tree, point, visit, &v);
    return v.total == 1;
}

/* Boxes hold all that regions cover, also where these are steep, and around a flat one nothing
 * beside it, nor above. */
static void test_covering(void **state) {
    (void)state;
    const double tolerance = 0.1;
    const psplat_region flat = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {2, 1}};
    uint64_t random = 15;
    size_t covered = 0;
    for (uint32_t i = 0; i < 120; ++i) {
        psplat_region r = curved_region(&random, i % 3 ? 0.7 : 4, i / 3 % 4);
        psplat_region_tree *region_tree = psplat_region_tree_create_covering(&r, 1, tolerance);
        assert_non_null(region_tree);
        for (int k = 0; k < 2000; ++k) {
            double angle = 2 * fixture_pi * psplat_random_unit(&random);
            double radius = k % 2 ? 1 : sqrt(psplat_random_unit(&random));
            double p[3], uvh[3], slope[2], side = k % 4 < 2 ? -1 : 1;
            const double uv[2] = {radius * cos(angle), radius * sin(angle)};
            psplat_region_point(&r, uv, p);
            psplat_region_slope(&r, uv, slope);
            double steep = hypot(1, hypot(slope[0], slope[1]));
            mad3(p, side * steep * tolerance * psplat_random_unit(&random), r.n);
            psplat_region_local(&r, p, uvh);
            if (fabs(uvh[2]) > tolerance || !psplat_region_contains(&r, uvh, 1 + 2e-6, 2e-6))
                continue;
            ++covered;
            assert_true(finds(region_tree, p));
        }
        psplat_region_tree_destroy(region_tree);
    }
    print_message("%zu points are covered\n", covered);
    assert_true(covered > 20000);
    psplat_region_tree *region_tree = psplat_region_tree_create_covering(&flat, 1, tolerance);
    assert_non_null(region_tree);
    const double on[3] = {1.9, 0, 0.99 * tolerance}, above[3] = {0, 0, 1.01 * tolerance};
    const double beside[3] = {2.02, 0, 0}; /* The polygon is not wider on the axes. */
    assert_true(finds(region_tree, on));
    assert_false(finds(region_tree, above));
    assert_false(finds(region_tree, beside));
    psplat_region_tree_destroy(region_tree);
}

int test_region_tree_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random),   cmocka_unit_test(test_sound),
        cmocka_unit_test(test_segments), cmocka_unit_test(test_degenerate),
        cmocka_unit_test(test_curved),   cmocka_unit_test(test_covering),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
