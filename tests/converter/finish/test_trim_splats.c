/* SPDX-License-Identifier: MIT
 *
 * test_trim_splats.c - tests of leaving out splats that are not needed and of shrinking those whose
 * rims stand off: outlines get narrower, and nothing opens, by rays of other seeds than the stage's
 * and by points of the surface.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "closing_fixture.h"
#include "finish/close_rays.h"
#include "finish/trim_splats.h"

/* The distances of rims from the surface, in tolerances. */
typedef struct stand_off {
    double mean, greatest;
} stand_off;

/* Finds those of some of the candidates. */
static stand_off measure(const closing *r, size_t from, size_t to) {
    enum { SIDES = 64 };
    double sum = 0, greatest = 0;
    size_t count = 0;
    for (size_t i = from; i < to; ++i)
        for (int k = 0; k < SIDES; ++k) {
            const psplat_region *region = &r->c.selection.candidates[i].region;
            const double uv[2] = {cos(2 * fixture_pi * k / SIDES), sin(2 * fixture_pi * k / SIDES)};
            double point[3], distance;
            /* A point of the rim is on it but for rounding. */
            if (!psplat_region_contains(region, uv, 1 + 1e-9, 0)) continue;
            psplat_region_point(region, uv, point);
            assert_int_equal(psplat_distance_query(r->f.distance, point, 1, &distance), PSPLAT_OK);
            sum += distance;
            greatest = fmax(greatest, distance);
            ++count;
        }
    return (stand_off){sum / (double)count / r->c.tolerance, greatest / r->c.tolerance};
}

/* Returns the first of old regions, from an index on, of which a region is what trimming has left:
 * that has about the same centre. */
static size_t find_old(const psplat_region *old, size_t from, size_t count,
                       const psplat_region *now) {
    size_t i = from;
    while (i < count &&
           distance2_3(old[i].center, now->center) > 0.01 * old[i].radius[1] * old[i].radius[1])
        ++i;
    return i;
}

/* A torus: rims stand off by less, some splats are smaller, some are left out, none is larger or
 * new, none leaves the surface, every sample stays covered, along no ray more one sees through, and
 * hardly more rays pass under walls.
 */
static void test_torus(void **state) {
    (void)state;
    enum { SEEDS = 3, PRECISIONS = 2 };
    static const double precisions[PRECISIONS] = {0, 0.1};
    static const double wall = 0.5; /* a quarter of a depth tolerance */
    size_t all_gaps = 0, all_now = 0, left_out = 0;
    for (size_t i = 0; i < SEEDS * PRECISIONS; ++i) {
        closing r;
        closing_begin(&r, "torus.off", 0.003, 0.008, 0, precisions[i % PRECISIONS]);
        r.desc.seed = i / PRECISIONS;
        assert_int_equal(psplat_close_rays(&r.c, NULL), PSPLAT_OK);
        size_t count = r.c.selection.count, smaller = 0, at = 0, shown, shown_now;
        size_t gaps = count_shown_gaps(&r, wall, 99, &shown);
        double before = measure(&r, 0, count).mean;
        psplat_region *old = copy_regions(&r);
        assert_int_equal(psplat_trim_splats(&r.c, NULL), PSPLAT_OK);
        size_t trimmed = r.c.selection.count;
        double after = measure(&r, 0, trimmed).mean;
        for (size_t k = 0; k < trimmed; ++k, ++at) {
            const psplat_region *now = &r.c.selection.candidates[k].region;
            at = find_old(old, at, count, now);
            assert_true(at < count);
            double ratio = psplat_region_ellipse(now) / psplat_region_ellipse(&old[at]);
            assert_true(ratio <= 1);
            assert_true(ratio >= 0.9 * 0.9 * 0.95); /* and steps of the grid */
            smaller += ratio < 1;
        }
        left_out += count - trimmed;
        size_t now = count_shown_gaps(&r, wall, 99, &shown_now);
        assert_true(shown_now <= shown);
        print_message("%zu of %zu smaller, %zu left, rims off by %.3f -> %.3f, gaps %zu -> %zu\n",
                      smaller, count, trimmed, before, after, gaps, now);
        assert_true(10 * smaller > count);
        assert_true(after < 0.97 * before);
        all_gaps += gaps;
        all_now += now;
        check_cover(&r);
        free(old);
        closing_end(&r);
    }
    assert_true(left_out >= SEEDS * PRECISIONS); /* one of each on average */
    /* One of 28,800 rays: those of the stage are others, and pass beside these in a gap, or what is
     * left hides them, farther away than the tolerance. */
    assert_true(all_now <= all_gaps + 100);
}

/* Puts a second candidate into the place of every third one, behind all others. The first one stays
 * recorded to cover a half of what it was, and the second one is recorded to cover the rest. */
static void double_some(closing *r) {
    psplat_selection *selection = &r->c.selection;
    size_t count = selection->count;
    for (size_t i = 0; i < count; i += 3) {
        psplat_candidate copy;
        assert_true(psplat_candidate_copy(&selection->candidates[i], &copy));
        size_t kept = copy.covered_count / 2;
        selection->candidates[i].covered_count = kept;
        copy.covered_count -= kept;
        memmove(copy.covered, copy.covered + kept, copy.covered_count * sizeof *copy.covered);
        assert_true(psplat_selection_push(selection, &copy));
    }
}

/* Of two splats in one place one is left out, though it is recorded to cover some samples alone,
 * and then the other one is recorded to. */
static void test_doubled(void **state) {
    (void)state;
    closing r;
    closing_begin(&r, "part.obj", 0.005, 0.01, 0, 0.1);
    size_t count = r.c.selection.count;
    double_some(&r);
    assert_true(r.c.selection.count > count + 10);
    assert_int_equal(psplat_trim_splats(&r.c, NULL), PSPLAT_OK);
    assert_true(r.c.selection.count <= count);
    for (size_t i = 0; i < r.c.selection.count; ++i)
        assert_true(r.c.selection.candidates[i].covered_count > 0);
    check_cover(&r);
    closing_end(&r);
}

/* Splats whose rims stand off by less than half the tolerance stay as they are or are left out,
 * like those of the part's faces, although others cover some of what they do. */
static void test_part(void **state) {
    (void)state;
    closing r;
    size_t kept = 0;
    closing_begin(&r, "part.obj", 0.005, 0.01, 0, 0.1);
    psplat_region *old = copy_regions(&r);
    stand_off *before = malloc(r.c.selection.count * sizeof *before);
    assert_non_null(before);
    size_t count = r.c.selection.count;
    for (size_t i = 0; i < count; ++i) before[i] = measure(&r, i, i + 1);
    assert_int_equal(psplat_trim_splats(&r.c, NULL), PSPLAT_OK);
    for (size_t i = 0, at = 0; i < r.c.selection.count; ++i, ++at) {
        at = find_old(old, at, count, &r.c.selection.candidates[i].region);
        assert_true(at < count);
        if (!(before[at].greatest < 0.49)) continue; /* The stage measures fewer points. */
        assert_memory_equal(&old[at], &r.c.selection.candidates[i].region, sizeof *old);
        ++kept;
    }
    assert_true(4 * kept > count);
    free(before);
    free(old);
    closing_end(&r);
}

static psplat_result trim(closing *r) {
    return psplat_trim_splats(&r->c, NULL);
}

/* The result does not depend on the number of threads. */
static void test_threads(void **state) {
    (void)state;
    check_threads(trim);
}

int test_trim_splats_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_torus),
        cmocka_unit_test(test_doubled),
        cmocka_unit_test(test_part),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
