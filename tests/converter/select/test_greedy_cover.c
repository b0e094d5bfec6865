/* SPDX-License-Identifier: MIT
 *
 * test_greedy_cover.c - tests of the greedy set cover: the selection covers every sample, repeats
 * bit by bit, and after pruning contains no candidate without which all samples would be covered;
 * no candidate grows where there are enough to choose from.
 * The models are bundled ones.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "fit/grow_candidate.h"
#include "fit/fit_context.h"
#include "fit/candidate.h"
#include "features/samples.h"
#include "select/conversion.h"
#include "select/greedy_cover.h"
#include "select/selection.h"

static int planar; /* 1: splats are flat */

/* Returns limits as a conversion sets them, for samples a quarter of the tolerance apart. */
static psplat_limits limits_of(const fixture *f, double part) {
    double tolerance = part * f->surface.diagonal;
    return (psplat_limits){.tolerance = tolerance,
                           .crease_tolerance = 0.9 * tolerance,
                           .crease_slack = 0.3 * tolerance,
                           .margin = 0.4 * f->samples.spacing,
                           .planar = planar,
                           .distance = f->distance};
}

/* Returns for each sample how many taken candidates cover it; the caller frees the array. */
static uint32_t *count_covers(const fixture *f, const psplat_selection *selection) {
    uint32_t *covers = calloc(f->samples.count, sizeof *covers);
    assert_non_null(covers);
    for (size_t i = 0; i < selection->count; ++i)
        for (size_t k = 0;
             selection->candidates[i].taken && k < selection->candidates[i].covered_count; ++k) {
            assert_true(selection->candidates[i].covered[k] < f->samples.count);
            covers[selection->candidates[i].covered[k]]++;
        }
    return covers;
}

/* Asserts that every sample is covered, and that every taken candidate alone covers one of its
 * samples. */
static void check_cover(const fixture *f, const psplat_selection *selection) {
    uint32_t *covers = count_covers(f, selection);
    for (size_t i = 0; i < f->samples.count; ++i) assert_true(covers[i] > 0);
    for (size_t i = 0; i < selection->count; ++i) {
        const psplat_candidate *c = &selection->candidates[i];
        int needed = !c->taken;
        for (size_t k = 0; k < c->covered_count; ++k) needed |= covers[c->covered[k]] == 1;
        assert_true(needed);
    }
    free(covers);
}

/* Covers all samples, drops candidates that are not needed, and forgets the pool. */
static void select_all(const fixture *f, double part, uint64_t seed, psplat_selection *selection) {
    psplat_limits limits = limits_of(f, part);
    psplat_convert_desc desc = {.seed = seed};
    const psplat_fit_context context = fixture_context(f, &limits, NULL);
    assert_int_equal(psplat_greedy_cover(&context, &desc, selection, NULL), PSPLAT_OK);
    assert_int_equal(fixture_improve(selection, f->samples.count, 0, 0, 0), PSPLAT_OK);
    size_t taken = psplat_selection_taken(selection);
    psplat_selection_drop_untaken(selection);
    assert_int_equal(selection->count, taken);
}

static void test_cover(void **state) {
    (void)state;
    const char *names[] = {"cone.stl", "cube.off"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        fixture f;
        psplat_selection selection = {0};
        fixture_model(&f, names[i]);
        fixture_sample(&f, 0.01);
        select_all(&f, 0.04, 0, &selection);
        print_message("%s: %zu candidates for %zu samples\n", names[i], selection.count,
                      f.samples.count);
        check_cover(&f, &selection);
        if (i == 1) assert_int_equal(selection.count, 6);
        psplat_selection_free(&selection);
        fixture_free(&f);
    }
}

/* The same seed gives the same candidates to the last bit. */
static void check_repeatable(size_t least) {
    fixture f;
    psplat_selection first = {0}, second = {0};
    fixture_model(&f, "sphere.ply");
    fixture_sample(&f, 0.01);
    select_all(&f, 0.05, 5, &first);
    select_all(&f, 0.05, 5, &second);
    assert_int_equal(first.count, second.count);
    assert_true(first.count >= least);
    check_cover(&f, &first);
    for (size_t i = 0; i < first.count; ++i) {
        const psplat_candidate *a = &first.candidates[i], *b = &second.candidates[i];
        assert_memory_equal(a->region.center, b->region.center, sizeof a->region.center);
        assert_memory_equal(a->region.radius, b->region.radius, sizeof a->region.radius);
        assert_memory_equal(a->field, b->field, sizeof a->field);
        assert_int_equal(a->covered_count, b->covered_count);
        assert_memory_equal(a->covered, b->covered, a->covered_count * sizeof *a->covered);
    }
    psplat_selection_free(&first);
    psplat_selection_free(&second);
    fixture_free(&f);
}

/* Flat caps of height 0.1 diagonals at most, 2 sqrt(3) / 10 radii, have less than a sixth of the
 * sphere's area; of curved ones two hemispheres would not do, since their slopes are bounded. */
static void test_repeatable(void **state) {
    (void)state;
    planar = 1;
    check_repeatable(7);
    planar = 0;
    check_repeatable(3);
}

/* A selection that covers all samples stays as it is, and no candidate grows. */
static void test_existing(void **state) {
    (void)state;
    fixture f;
    psplat_selection selection = {0};
    fixture_model(&f, "cube.off");
    fixture_sample(&f, 0.01);
    select_all(&f, 0.04, 0, &selection);
    assert_int_equal(selection.count, 6);
    double kept[6][3];
    for (int i = 0; i < 6; ++i) memcpy(kept[i], selection.candidates[i].region.center, 24);
    /* Two of the candidates are added once more. */
    for (int i = 0; i < 2; ++i) {
        psplat_candidate copy = selection.candidates[i];
        copy.covered = malloc(copy.covered_count * sizeof *copy.covered);
        assert_non_null(copy.covered);
        memcpy(copy.covered, selection.candidates[i].covered,
               copy.covered_count * sizeof *copy.covered);
        assert_true(selection.count < selection.capacity);
        selection.candidates[selection.count++] = copy;
    }
    select_all(&f, 0.03, 1, &selection);
    assert_int_equal(selection.count, 6);
    check_cover(&f, &selection);
    for (int i = 0; i < 6; ++i) {
        int found = 0;
        for (int k = 0; k < 6; ++k)
            found += !memcmp(kept[i], selection.candidates[k].region.center, sizeof kept[i]);
        assert_int_equal(found, 1);
    }
    psplat_selection_free(&selection);
    fixture_free(&f);
}

/* Samples that are appended later are covered by taken candidates after these are asked again, or
 * by selecting again. */
static void test_appended(void **state) {
    (void)state;
    fixture f;
    psplat_selection selection = {0};
    psplat_samples extra;
    psplat_scratch scratch = {0};
    fixture_model(&f, "cone.stl");
    fixture_sample(&f, 0.01);
    select_all(&f, 0.04, 0, &selection);
    size_t before = f.samples.count;
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 500, 9, &extra, NULL), PSPLAT_OK);
    assert_int_equal(psplat_samples_append(&f.samples, &f.surface, extra.positions, extra.triangles,
                                           extra.count, NULL),
                     PSPLAT_OK);
    psplat_limits limits = limits_of(&f, 0.04);
    const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
    for (size_t i = 0; i < selection.count; ++i)
        assert_int_equal(psplat_candidate_cover(&context, &selection.candidates[i]), PSPLAT_OK);
    uint32_t *covers = count_covers(&f, &selection);
    size_t covered = 0;
    for (size_t i = 0; i < f.samples.count; ++i) covered += covers[i] > 0;
    for (size_t i = 0; i < before; ++i) assert_true(covers[i] > 0);
    /* Most of the new samples lie between the old ones. */
    assert_true(covered > before + extra.count / 2);
    free(covers);
    select_all(&f, 0.04, 2, &selection);
    check_cover(&f, &selection);
    psplat_scratch_free(&scratch);
    psplat_samples_free(&extra);
    psplat_selection_free(&selection);
    fixture_free(&f);
}

/* Each seed gives one candidate, in the order of the seeds and independently of when it grew;
 * dropping the rest keeps the order of those taken. */
static void test_pool(void **state) {
    (void)state;
    enum { SEEDS = 40 };
    fixture f;
    psplat_selection selection = {0};
    psplat_scratch scratch = {0};
    uint32_t seeds[SEEDS];
    double kept[SEEDS][3];
    fixture_model(&f, "cone.stl");
    fixture_sample(&f, 0.01);
    psplat_limits limits = limits_of(&f, 0.04);
    const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
    for (uint32_t i = 0; i < SEEDS; ++i) /* 7919 is a prime, so that seeds spread over the mesh. */
        seeds[i] = (uint32_t)((size_t)i * 7919 % f.samples.count);
    assert_int_equal(psplat_selection_grow(&context, seeds, SEEDS, &selection), PSPLAT_OK);
    assert_int_equal(selection.count, SEEDS);
    assert_int_equal(psplat_selection_taken(&selection), 0);
    size_t taken = 0;
    for (size_t i = 0; i < SEEDS; ++i) {
        psplat_candidate alone, *c = &selection.candidates[i];
        assert_int_equal(psplat_candidate_grow(&context, seeds[i], &alone), PSPLAT_OK);
        assert_memory_equal(c->region.center, alone.region.center, sizeof alone.region.center);
        assert_memory_equal(c->region.radius, alone.region.radius, sizeof alone.region.radius);
        assert_memory_equal(c->field, alone.field, sizeof alone.field);
        assert_int_equal(c->covered_count, alone.covered_count);
        psplat_candidate_free(&alone);
        c->taken = i % 3 == 1;
        if (c->taken) memcpy(kept[taken++], c->region.center, sizeof kept[0]);
    }
    assert_int_equal(psplat_selection_taken(&selection), taken);
    psplat_selection_drop_untaken(&selection);
    assert_int_equal(selection.count, taken);
    for (size_t i = 0; i < taken; ++i)
        assert_memory_equal(selection.candidates[i].region.center, kept[i], sizeof kept[0]);
    psplat_scratch_free(&scratch);
    psplat_selection_free(&selection);
    fixture_free(&f);
}

static int stop_at_once(void *user, const char *stage, double fraction) {
    (void)stage;
    assert_true(fraction >= 0 && fraction <= 1);
    return ++*(int *)user == 2;
}

/* An interrupted selection returns that error, and can be freed. */
static void test_interrupted(void **state) {
    (void)state;
    fixture f;
    psplat_selection selection = {0};
    psplat_error error = {0};
    int calls = 0;
    psplat_convert_desc desc = {.progress = stop_at_once, .user = &calls};
    fixture_model(&f, "sphere.ply");
    fixture_sample(&f, 0.01);
    psplat_limits limits = limits_of(&f, 0.002);
    const psplat_fit_context context = fixture_context(&f, &limits, NULL);
    assert_int_equal(psplat_greedy_cover(&context, &desc, &selection, &error),
                     PSPLAT_ERROR_INTERRUPTED);
    assert_int_equal(error.code, PSPLAT_ERROR_INTERRUPTED);
    assert_int_equal(calls, 2);
    psplat_selection_free(&selection);
    assert_int_equal(selection.count, 0);
    fixture_free(&f);
}

/* Asserts the rule of greedy choice after one round: the candidate of greatest gain is taken, each
 * taken one has gained at least 0.8 of that, and no candidate with such a gain is left. */
static void check_greedy(const fixture *f, const psplat_selection *selection) {
    const double worth_taking = 0.8;
    uint32_t *covers = count_covers(f, selection);
    size_t most = 0, least = SIZE_MAX, covered = 0, taken = psplat_selection_taken(selection);
    const psplat_candidate *largest = NULL;
    for (size_t i = 0; i < selection->count; ++i) {
        const psplat_candidate *c = &selection->candidates[i];
        if (c->covered_count > most) most = c->covered_count, largest = c;
        if (c->covered_count < least) least = c->covered_count;
    }
    assert_true((double)least < 0.7 * (double)most); /* The candidates' gains differ. */
    assert_int_equal(largest->taken, 1);
    for (size_t i = 0; i < f->samples.count; ++i) covered += covers[i] > 0;
    assert_true((double)covered >= (double)taken * worth_taking * (double)most);
    for (size_t i = 0; i < selection->count; ++i) {
        const psplat_candidate *c = &selection->candidates[i];
        size_t gain = 0;
        for (size_t k = 0; k < c->covered_count; ++k) gain += covers[c->covered[k]] == 0;
        assert_true((double)gain < worth_taking * (double)most);
    }
    free(covers);
}

static void test_greedy(void **state) {
    (void)state;
    const char *names[] = {"torus.off", "cone.stl"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        fixture f;
        fixture_model(&f, names[i]);
        fixture_sample(&f, 0.01);
        psplat_limits limits = limits_of(&f, 0.005);
        const psplat_fit_context context = fixture_context(&f, &limits, NULL);
        for (uint64_t seed = 0; seed < 3; ++seed) {
            psplat_selection selection = {0};
            int calls = 0;
            psplat_convert_desc desc = {.seed = seed, .progress = stop_at_once, .user = &calls};
            assert_int_equal(psplat_greedy_cover(&context, &desc, &selection, NULL),
                             PSPLAT_ERROR_INTERRUPTED); /* after one round */
            check_greedy(&f, &selection);
            psplat_selection_free(&selection);
        }
        fixture_free(&f);
    }
}

enum { MOST_ROUNDS = 100 };

/* How many candidates there were when each round began. */
typedef struct rounds {
    const psplat_selection *selection;
    size_t counts[MOST_ROUNDS + 1];
    size_t count;
} rounds;

static int note_round(void *user, const char *stage, double fraction) {
    rounds *r = user;
    (void)stage;
    (void)fraction;
    assert_true(r->count < MOST_ROUNDS);
    r->counts[r->count++] = r->selection->count;
    return 0;
}

/* A candidate grows around a sample that fewer than three candidates of the rounds before cover, so
 * that it covers such a sample itself. */
static void test_choices(void **state) {
    (void)state;
    fixture f;
    psplat_selection selection = {0};
    rounds r = {.selection = &selection};
    fixture_model(&f, "torus.off");
    fixture_sample(&f, 0.01);
    psplat_limits limits = limits_of(&f, 0.005);
    const psplat_fit_context context = fixture_context(&f, &limits, NULL);
    const psplat_convert_desc desc = {.progress = note_round, .user = &r};
    assert_int_equal(psplat_greedy_cover(&context, &desc, &selection, NULL), PSPLAT_OK);
    r.counts[r.count] = selection.count;
    uint32_t *choices = calloc(f.samples.count, sizeof *choices);
    assert_non_null(choices);
    for (size_t round = 0; round < r.count; ++round) {
        for (size_t i = r.counts[round]; i < r.counts[round + 1]; ++i) {
            const psplat_candidate *c = &selection.candidates[i];
            int few = 0;
            for (size_t k = 0; k < c->covered_count; ++k) few |= choices[c->covered[k]] < 3;
            assert_true(few);
        }
        for (size_t i = r.counts[round]; i < r.counts[round + 1]; ++i) {
            const psplat_candidate *c = &selection.candidates[i];
            for (size_t k = 0; k < c->covered_count; ++k) ++choices[c->covered[k]];
        }
    }
    print_message("%zu candidates in %zu rounds, %zu taken\n", selection.count, r.count,
                  psplat_selection_taken(&selection));
    assert_true(r.count > 3); /* Otherwise there is nothing to see. */
    free(choices);
    psplat_selection_free(&selection);
    fixture_free(&f);
}

int test_greedy_cover_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cover),       cmocka_unit_test(test_repeatable),
        cmocka_unit_test(test_existing),    cmocka_unit_test(test_appended),
        cmocka_unit_test(test_interrupted), cmocka_unit_test(test_pool),
        cmocka_unit_test(test_greedy),      cmocka_unit_test(test_choices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
