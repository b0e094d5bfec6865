/* SPDX-License-Identifier: MIT
 *
 * test_local_search.c - tests of the local search on set covers whose best answer is known: no
 * sample is lost, the number of taken candidates never grows, and better covers than the greedy one
 * are found. Samples lie on a line or a ring, and candidates are intervals or random sets.
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
#include "fit/candidate.h"
#include "select/selection.h"

/* Adds a candidate that covers `count` samples from `first` on. */
static psplat_candidate *add(psplat_selection *selection, uint32_t first, uint32_t count,
                             int taken) {
    psplat_candidate candidate = {.covered_count = count, .taken = taken};
    candidate.covered = malloc((count + 1) * sizeof *candidate.covered);
    assert_non_null(candidate.covered);
    for (uint32_t i = 0; i < count; ++i) candidate.covered[i] = first + i;
    assert_int_equal(psplat_selection_push(selection, &candidate), 1);
    return &selection->candidates[selection->count - 1];
}

/* Returns for each sample how many taken candidates cover it; the caller frees the array. */
static uint32_t *count_covers(const psplat_selection *selection, size_t samples) {
    uint32_t *covers = calloc(samples + 1, sizeof *covers);
    assert_non_null(covers);
    for (size_t c = 0; c < selection->count; ++c)
        for (size_t i = 0;
             selection->candidates[c].taken && i < selection->candidates[c].covered_count; ++i)
            covers[selection->candidates[c].covered[i]]++;
    return covers;
}

/* Asserts that samples covered before are covered still, and that each taken candidate alone covers
 * some sample. */
static void check_cover(const psplat_selection *selection, const uint32_t *before, size_t samples) {
    uint32_t *covers = count_covers(selection, samples);
    for (size_t i = 0; i < samples; ++i) assert_int_equal(covers[i] > 0, before[i] > 0);
    for (size_t c = 0; c < selection->count; ++c) {
        const psplat_candidate *candidate = &selection->candidates[c];
        int needed = !candidate->taken;
        for (size_t i = 0; i < candidate->covered_count; ++i)
            needed |= covers[candidate->covered[i]] == 1;
        assert_true(needed);
    }
    free(covers);
}

/* Takes the candidate of greatest gain, the first one among equals, until all samples are covered.
 */
static void take_greedily(psplat_selection *selection, size_t samples) {
    for (;;) {
        uint32_t *covers = count_covers(selection, samples);
        size_t best = 0, most = 0;
        for (size_t c = 0; c < selection->count; ++c) {
            size_t gain = 0;
            for (size_t i = 0; i < selection->candidates[c].covered_count; ++i)
                gain += !covers[selection->candidates[c].covered[i]];
            if (gain > most) most = gain, best = c;
        }
        free(covers);
        if (!most) return;
        selection->candidates[best].taken = 1;
    }
}

/* Makes random sets of neighbouring samples on a ring, and takes a greedy choice of them or all. */
static void make_ring(psplat_selection *selection, uint32_t samples, uint32_t sets, int greedy,
                      uint64_t seed) {
    *selection = (psplat_selection){0};
    for (uint32_t c = 0; c < sets; ++c) {
        uint32_t first = (uint32_t)(psplat_random_next(&seed) % samples);
        uint32_t count = 3 + (uint32_t)(psplat_random_next(&seed) % 25);
        psplat_candidate *candidate = add(selection, first, count, !greedy);
        for (uint32_t i = 0; i < count; ++i) candidate->covered[i] %= samples;
    }
    if (greedy) take_greedily(selection, samples);
}

/* ---- invariants ----------------------------------------------------------------------------- */

static void test_keeps(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        enum { SAMPLES = 150 };
        psplat_selection selection;
        make_ring(&selection, SAMPLES, 20 + 4 * (uint32_t)seed, seed % 2 == 0, seed);
        uint32_t *before = count_covers(&selection, SAMPLES);
        for (size_t moves = 0; moves <= 400; moves = 2 * moves + 25) {
            size_t taken = psplat_selection_taken(&selection);
            assert_int_equal(fixture_improve(&selection, SAMPLES, SAMPLES, moves, seed + moves),
                             PSPLAT_OK);
            assert_true(psplat_selection_taken(&selection) <= taken);
            check_cover(&selection, before, SAMPLES);
        }
        free(before);
        psplat_selection_free(&selection);
    }
}

/* Without moves, candidates that are not needed are dropped, and none is added. */
static void test_prunes(void **state) {
    (void)state;
    enum { SAMPLES = 100, SETS = 60 };
    psplat_selection selection;
    uint8_t taken[SETS];
    make_ring(&selection, SAMPLES, SETS, 0, 7);
    for (size_t c = 0; c < SETS; c += 3) selection.candidates[c].taken = 0;
    for (size_t c = 0; c < SETS; ++c) taken[c] = (uint8_t)selection.candidates[c].taken;
    uint32_t *before = count_covers(&selection, SAMPLES);
    assert_int_equal(fixture_improve(&selection, SAMPLES, 0, 0, 1), PSPLAT_OK);
    check_cover(&selection, before, SAMPLES);
    for (size_t c = 0; c < SETS; ++c) assert_true(selection.candidates[c].taken <= taken[c]);
    free(before);
    psplat_selection_free(&selection);
    /* One candidate covers nothing; then there is no candidate at all. */
    add(&selection, 0, 0, 1);
    add(&selection, 0, 5, 1);
    assert_int_equal(fixture_improve(&selection, 5, 5, 20, 1), PSPLAT_OK);
    assert_int_equal(psplat_selection_taken(&selection), 1);
    assert_int_equal(selection.candidates[1].taken, 1);
    psplat_selection_free(&selection);
    assert_int_equal(fixture_improve(&selection, 5, 5, 20, 1), PSPLAT_OK);
    psplat_selection_free(&selection);
}

static void test_repeatable(void **state) {
    (void)state;
    enum { SAMPLES = 400, SETS = 300 };
    psplat_selection first, second, other;
    size_t different = 0;
    make_ring(&first, SAMPLES, SETS, 1, 5);
    make_ring(&second, SAMPLES, SETS, 1, 5);
    make_ring(&other, SAMPLES, SETS, 1, 5);
    assert_int_equal(fixture_improve(&first, SAMPLES, SAMPLES, 300, 9), PSPLAT_OK);
    assert_int_equal(fixture_improve(&second, SAMPLES, SAMPLES, 300, 9), PSPLAT_OK);
    assert_int_equal(fixture_improve(&other, SAMPLES, SAMPLES, 300, 10), PSPLAT_OK);
    for (size_t c = 0; c < SETS; ++c) {
        assert_int_equal(first.candidates[c].taken, second.candidates[c].taken);
        different += first.candidates[c].taken != other.candidates[c].taken;
    }
    assert_true(different > 0);
    psplat_selection_free(&first);
    psplat_selection_free(&second);
    psplat_selection_free(&other);
}

/* ---- better than greedy --------------------------------------------------------------------- */

/* Two candidates cover two rows of 30 samples, and columns of 16, 8, 4 and 2 samples of each row
 * cover one sample of the next column too. Greedy choice takes the columns (the worst case of the
 * textbooks), and the search must find the two rows. */
static void test_beats_greedy(void **state) {
    (void)state;
    enum { ROW = 30 };
    psplat_selection selection = {0};
    uint32_t at = 0;
    for (uint32_t width = 16; width >= 2; at += width, width /= 2) {
        psplat_candidate *column = add(&selection, at, 2 * width + (width > 2), 0);
        for (uint32_t i = 0; i < width; ++i) column->covered[width + i] = ROW + at + i;
        if (width > 2) column->covered[2 * width] = at + width;
    }
    add(&selection, 0, ROW, 0);
    add(&selection, ROW, ROW, 0);
    take_greedily(&selection, 2 * ROW);
    for (size_t c = 0; c < 4; ++c) assert_int_equal(selection.candidates[c].taken, 1);
    assert_int_equal(psplat_selection_taken(&selection), 4);
    assert_int_equal(fixture_improve(&selection, 2 * ROW, 2 * ROW, 500, 3), PSPLAT_OK);
    assert_int_equal(psplat_selection_taken(&selection), 2);
    assert_int_equal(selection.candidates[4].taken + selection.candidates[5].taken, 2);
    psplat_selection_free(&selection);
}

/* Of all intervals of 21 among 200 samples every eleventh is taken: each of these 18 alone covers a
 * sample, and yet 10 intervals suffice. */
static void test_line(void **state) {
    (void)state;
    enum { SAMPLES = 200, LONG = 21 };
    for (uint64_t seed = 0; seed < 5; ++seed) {
        psplat_selection selection = {0};
        for (uint32_t first = 0; first + LONG <= SAMPLES; ++first)
            add(&selection, first, LONG, first % 11 == 0 || first + LONG == SAMPLES);
        uint32_t *before = count_covers(&selection, SAMPLES);
        assert_int_equal(fixture_improve(&selection, SAMPLES, SAMPLES, 0, seed), PSPLAT_OK);
        assert_in_range(psplat_selection_taken(&selection), 17, 18);
        assert_int_equal(fixture_improve(&selection, SAMPLES, SAMPLES, 3000, seed), PSPLAT_OK);
        assert_int_equal(psplat_selection_taken(&selection), 10);
        check_cover(&selection, before, SAMPLES);
        free(before);
        psplat_selection_free(&selection);
    }
}

/* Moves start at the samples in focus; candidates that are not connected with these stay. */
static void test_focus(void **state) {
    (void)state;
    enum { HALF = 100, LONG = 21 };
    psplat_selection selection = {0};
    for (uint32_t half = 0; half < 2; ++half)
        for (uint32_t first = 0; first + LONG <= HALF; ++first)
            add(&selection, half * HALF + first, LONG, first % 11 == 0 || first + LONG == HALF);
    assert_int_equal(fixture_improve(&selection, 2 * HALF, 0, 0, 1), PSPLAT_OK);
    size_t each = selection.count / 2, before = 0, after = 0;
    uint8_t taken[2 * HALF];
    for (size_t c = 0; c < selection.count; ++c) {
        taken[c] = (uint8_t)selection.candidates[c].taken;
        before += c >= each && taken[c];
    }
    assert_int_equal(fixture_improve(&selection, 2 * HALF, HALF, 1000, 1), PSPLAT_OK);
    for (size_t c = 0; c < each; ++c) assert_int_equal(selection.candidates[c].taken, taken[c]);
    for (size_t c = each; c < selection.count; ++c) after += selection.candidates[c].taken != 0;
    assert_true(before > 7);
    assert_int_equal(after, 5); /* ceil(100 / 21) */
    psplat_selection_free(&selection);
}

/* Strict moves that save no candidate change nothing, not even to an equal number of other
 * candidates. */
static void test_strict(void **state) {
    (void)state;
    enum { SAMPLES = 300, SETS = 250 };
    size_t saved = 0, moved = 0;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        psplat_selection selection, free_one;
        uint8_t taken[SETS];
        make_ring(&selection, SAMPLES, SETS, 1, seed);
        make_ring(&free_one, SAMPLES, SETS, 1, seed);
        uint32_t *before = count_covers(&selection, SAMPLES);
        assert_int_equal(fixture_improve(&selection, SAMPLES, 0, 0, 1), PSPLAT_OK);
        assert_int_equal(fixture_improve(&free_one, SAMPLES, 0, 0, 1), PSPLAT_OK);
        for (uint64_t round = 0; round < 8; ++round) {
            size_t count = psplat_selection_taken(&selection);
            for (size_t c = 0; c < SETS; ++c) taken[c] = (uint8_t)selection.candidates[c].taken;
            assert_int_equal(fixture_exchange(&selection, SAMPLES, SAMPLES, 40, round, 1),
                             PSPLAT_OK);
            assert_true(psplat_selection_taken(&selection) <= count);
            check_cover(&selection, before, SAMPLES);
            if (psplat_selection_taken(&selection) < count) {
                saved += count - psplat_selection_taken(&selection);
                continue;
            }
            for (size_t c = 0; c < SETS; ++c)
                assert_int_equal(selection.candidates[c].taken, taken[c]);
        }
        for (size_t c = 0; c < SETS; ++c) taken[c] = (uint8_t)free_one.candidates[c].taken;
        size_t count = psplat_selection_taken(&free_one);
        assert_int_equal(fixture_improve(&free_one, SAMPLES, SAMPLES, 40, seed), PSPLAT_OK);
        for (size_t c = 0; c < SETS && psplat_selection_taken(&free_one) == count; ++c)
            moved += free_one.candidates[c].taken != taken[c];
        free(before);
        psplat_selection_free(&selection);
        psplat_selection_free(&free_one);
    }
    assert_true(saved > 40);
    assert_true(moved > 0); /* Moves that are not strict do change candidates here. */
}

/* Two of three overlapping intervals can be replaced by a fourth, which strict moves find. */
static void test_strict_saves(void **state) {
    (void)state;
    psplat_selection selection = {0};
    add(&selection, 0, 10, 1);
    add(&selection, 8, 10, 1);
    add(&selection, 16, 10, 1);
    add(&selection, 5, 9, 0);  /* saves nothing */
    add(&selection, 0, 17, 0); /* replaces the first two */
    assert_int_equal(fixture_exchange(&selection, 26, 26, 100, 1, 1), PSPLAT_OK);
    assert_int_equal(psplat_selection_taken(&selection), 2);
    assert_int_equal(selection.candidates[4].taken + selection.candidates[2].taken, 2);
    psplat_selection_free(&selection);
}

int test_local_search_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_keeps),      cmocka_unit_test(test_prunes),
        cmocka_unit_test(test_repeatable), cmocka_unit_test(test_beats_greedy),
        cmocka_unit_test(test_line),       cmocka_unit_test(test_focus),
        cmocka_unit_test(test_strict),     cmocka_unit_test(test_strict_saves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
