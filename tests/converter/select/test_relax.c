/* SPDX-License-Identifier: MIT
 *
 * test_relax.c - tests of the relaxation, which proposes candidates for the cells of taken
 * candidates and for pairs of neighbours. Proposals must keep the limits and cover the samples for
 * which they are proposed. The shapes are a flat square, whose best cover is known, and bundled
 * models.
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
#include "fit/candidate.h"
#include "select/conversion.h"
#include "select/greedy_cover.h"
#include "select/local_search.h"
#include "select/relax.h"
#include "select/selection.h"

static const psplat_convert_desc desc = {.seed = 1};

/* Returns a conversion up to its samples, which the fixture has drawn; tolerance is in diagonals.
 */
static psplat_conversion conversion_of(const fixture *f, double tolerance) {
    double length = tolerance * f->surface.diagonal;
    return (psplat_conversion){.desc = &desc,
                               .surface = f->surface,
                               .samples = f->samples,
                               .distance = f->distance,
                               .tolerance = length,
                               .limits = {.tolerance = 0.98 * length,
                                          .crease_tolerance = 0.5 * length,
                                          .crease_slack = 0.3 * length,
                                          .margin = 0.2 * f->samples.spacing,
                                          .distance = f->distance}};
}

/* Stores for each sample how many taken candidates cover it, and one of these; the caller frees
 * both arrays. */
static uint8_t *count_covers(const psplat_conversion *c, uint32_t **by) {
    uint8_t *covers = calloc(c->samples.count + 1, 1);
    *by = calloc(c->samples.count + 1, sizeof **by);
    assert_non_null(covers);
    assert_non_null(*by);
    for (uint32_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        for (size_t k = 0; candidate->taken && k < candidate->covered_count; ++k) {
            covers[candidate->covered[k]] = (uint8_t)(covers[candidate->covered[k]] + 1);
            (*by)[candidate->covered[k]] = i;
        }
    }
    return covers;
}

/* Asserts that a proposal is not taken, stays near the mesh, and that the samples it covers lie
 * inside its ellipse and lines, within the tolerance and on its side. */
static void check_proposal(const psplat_conversion *c, const psplat_candidate *proposal) {
    assert_int_equal(proposal->taken, 0);
    assert_true(proposal->covered_count > 0);
    assert_true(proposal->deviation <= c->limits.tolerance * (1 + 1e-12));
    fixture_assert_near(&proposal->region, c->distance, c->limits.tolerance);
    for (size_t i = 0; i < proposal->covered_count; ++i) {
        size_t sample = proposal->covered[i];
        double uvh[3], facing = 0;
        assert_true(sample < c->samples.count);
        psplat_region_local(&proposal->region, c->samples.positions + 3 * sample, uvh);
        assert_true(psplat_region_contains(&proposal->region, uvh, 1, 1e-6));
        assert_true(fabs(uvh[2]) <= c->limits.tolerance * (1 + 1e-12));
        for (size_t k = 0; k < 3; ++k)
            facing += proposal->region.n[k] * (double)c->samples.normals[3 * sample + k];
        assert_true(facing > 0);
    }
}

static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

/* Takes a candidate on the part of the square that a line keeps; its covered samples are found. */
static void take_part(psplat_conversion *c, double sign) {
    psplat_scratch scratch = {0};
    psplat_fit_context context = psplat_conversion_context(c);
    psplat_candidate half = {.taken = 1,
                             .region = {.center = {0, 0, 0.01 * sign}, .radius = {3, 3}}};
    psplat_region *r = &half.region;
    r->u[0] = r->v[1] = r->n[2] = 1;
    r->line_count = 1;
    r->lines[0][0] = sign, r->lines[0][2] = 0.1; /* Both halves cover a strip in the middle. */
    half.triangle = c->samples.triangles[0];
    context.scratch = &scratch;
    assert_int_equal(psplat_candidate_cover(&context, &half), PSPLAT_OK);
    psplat_scratch_free(&scratch);
    assert_true(half.covered_count > c->samples.count / 2 && half.covered_count < c->samples.count);
    assert_int_equal(psplat_selection_push(&c->selection, &half), 1);
}

/* For two halves of a flat square one proposal covers both with the square's four lines, and the
 * local search takes it instead of them. Two other proposals belong to the cells of the halves. The
 * halves lie a little above and below the square. */
static void test_two_halves(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 5, 5, place_square);
    fixture_build(&f);
    fixture_sample(&f, 0.02);
    psplat_conversion c = conversion_of(&f, 0.005);
    take_part(&c, 1);
    take_part(&c, -1);
    assert_int_equal(psplat_relax(&c), PSPLAT_OK);
    assert_in_range(c.selection.count, 3, 5);
    const psplat_candidate *whole = NULL;
    for (size_t i = 2; i < c.selection.count; ++i) {
        const psplat_candidate *proposal = &c.selection.candidates[i];
        check_proposal(&c, proposal);
        if (proposal->covered_count == c.samples.count) whole = proposal;
    }
    assert_non_null(whole);
    assert_int_equal(whole->region.line_count, 4);
    /* The proposal lies in the square although neither half did, because the moments of both refer
     * to one origin. */
    assert_near(whole->deviation, 0, 1e-12);
    psplat_local_search_desc what = {&c.samples, 50, c.samples.count, 0, 1, 1, NULL};
    assert_int_equal(psplat_local_search(&c.selection, &what), PSPLAT_OK);
    assert_int_equal(psplat_selection_taken(&c.selection), 1);
    psplat_selection_free(&c.selection);
    fixture_free(&f);
}

/* Takes candidates until all samples are covered, and proposes. Returns the number of candidates
 * before. */
static size_t select_and_relax(psplat_conversion *c) {
    const psplat_fit_context context = psplat_conversion_context(c);
    assert_int_equal(psplat_greedy_cover(&context, c->desc, &c->selection, NULL), PSPLAT_OK);
    psplat_local_search_desc what = {&c->samples, 0, c->samples.count, 0, 1, 0, NULL};
    assert_int_equal(psplat_local_search(&c->selection, &what), PSPLAT_OK);
    psplat_selection_drop_untaken(&c->selection);
    size_t before = c->selection.count;
    assert_int_equal(psplat_relax(c), PSPLAT_OK);
    return before;
}

/* Returns whether a candidate covers all samples that `owner` alone covers. */
static int covers_cell(const psplat_conversion *c, const psplat_candidate *candidate,
                       const uint8_t *covers, const uint32_t *by, uint32_t owner) {
    uint8_t *covered = calloc(c->samples.count, 1);
    int all = 1;
    assert_non_null(covered);
    for (size_t i = 0; i < candidate->covered_count; ++i) covered[candidate->covered[i]] = 1;
    for (size_t i = 0; i < c->samples.count && all; ++i)
        all = covers[i] != 1 || by[i] != owner || covered[i];
    free(covered);
    return all;
}

/* On curved surfaces, flat faces and creases every proposal keeps the limits and covers the cell of
 * at least one taken candidate. Most cells get a proposal. */
static void test_limits(void **state) {
    (void)state;
    const struct {
        const char *name;
        double tolerance, spacing;
    } cases[] = {{"sphere.ply", 0.05, 0.015},
                 {"torus.off", 0.02, 0.01},
                 {"cube.off", 0.02, 0.02},
                 {"part.obj", 0.01, 0.01},
                 {"cone.stl", 0.03, 0.015}};
    for (size_t m = 0; m < sizeof cases / sizeof *cases; ++m) {
        fixture f;
        fixture_model(&f, cases[m].name);
        fixture_sample(&f, cases[m].spacing);
        psplat_conversion c = conversion_of(&f, cases[m].tolerance);
        size_t before = select_and_relax(&c), for_cells = 0;
        uint32_t *by;
        uint8_t *covers = count_covers(&c, &by);
        uint8_t *served = calloc(before, 1);
        assert_non_null(served);
        for (size_t i = before; i < c.selection.count; ++i) {
            const psplat_candidate *proposal = &c.selection.candidates[i];
            int serves = 0;
            check_proposal(&c, proposal);
            for (uint32_t owner = 0; owner < before; ++owner)
                if (covers_cell(&c, proposal, covers, by, owner)) serves = served[owner] = 1;
            assert_int_equal(serves, 1);
        }
        for (size_t i = 0; i < before; ++i) for_cells += served[i];
        print_message("%s: %zu taken, %zu proposed, for %zu cells\n", cases[m].name, before,
                      c.selection.count - before, for_cells);
        assert_true(2 * for_cells > before);
        free(served);
        free(covers);
        free(by);
        psplat_selection_free(&c.selection);
        fixture_free(&f);
    }
}

/* Any number of threads gives the same proposals in the same order. */
static void test_threads(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "sphere.ply");
    fixture_sample(&f, 0.015);
    psplat_conversion one = conversion_of(&f, 0.03), many = one;
    fixture_threads(1);
    select_and_relax(&one);
    fixture_threads(5);
    size_t before = select_and_relax(&many);
    fixture_threads(0);
    assert_int_equal(one.selection.count, many.selection.count);
    assert_true(many.selection.count > before);
    for (size_t i = 0; i < one.selection.count; ++i) {
        const psplat_candidate *a = &one.selection.candidates[i];
        const psplat_candidate *b = &many.selection.candidates[i];
        assert_memory_equal(&a->region, &b->region, offsetof(psplat_region, lines));
        assert_int_equal(a->region.line_count, b->region.line_count);
        assert_memory_equal(a->region.lines, b->region.lines,
                            a->region.line_count * sizeof *a->region.lines);
        assert_memory_equal(a->field, b->field, sizeof a->field);
        assert_int_equal(a->covered_count, b->covered_count);
        assert_memory_equal(a->covered, b->covered, a->covered_count * sizeof *a->covered);
    }
    psplat_selection_free(&one.selection);
    psplat_selection_free(&many.selection);
    fixture_free(&f);
}

/* Without taken candidates there are no proposals. */
static void test_nothing(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "cube.off");
    fixture_sample(&f, 0.05);
    psplat_conversion c = conversion_of(&f, 0.02);
    assert_int_equal(psplat_relax(&c), PSPLAT_OK);
    assert_int_equal(c.selection.count, 0);
    psplat_selection_free(&c.selection);
    fixture_free(&f);
}

int test_relax_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_halves),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
