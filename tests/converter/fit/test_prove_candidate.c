/* SPDX-License-Identifier: MIT
 *
 * test_prove_candidate.c - tests that what grows is proven: all of a candidate is near the mesh by
 * the division that the check makes, and it covers its seed, however far its draft went astray.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "stage_fixture.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"
#include "measure/splat_distance.h"

enum { SEEDS = 60 };

static int covers(const psplat_candidate *candidate, uint32_t sample) {
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (candidate->covered[i] == sample) return 1;
    return 0;
}

/* Grows candidates from all over a model whose drafts may use so much of the tolerance. Returns the
 * mean area of those that are at least as large as a disc of the last resort. */
static double grow_all(const fixture *f, psplat_limits limits, double draft_part) {
    psplat_scratch scratch = {0};
    double area = 0;
    limits.measured_tolerance = draft_part * limits.tolerance;
    const psplat_fit_context context = fixture_context(f, &limits, &scratch);
    const psplat_splat_distance_desc desc = {.tolerance = limits.tolerance * (1 + 1e-9)};
    for (size_t i = 0; i < SEEDS; ++i) {
        uint32_t seed = (uint32_t)(i * f->samples.count / SEEDS);
        psplat_candidate c;
        psplat_splat_distance measured;
        assert_int_equal(psplat_candidate_grow(&context, seed, &c), PSPLAT_OK);
        assert_true(covers(&c, seed));
        assert_int_equal(psplat_splat_distance_find(&c.region, f->distance, &desc, &measured),
                         PSPLAT_OK);
        assert_int_equal(measured.nearness, PSPLAT_NEARNESS_WITHIN);
        area += psplat_region_area(&c.region) / SEEDS;
        psplat_candidate_free(&c);
    }
    psplat_scratch_free(&scratch);
    return area;
}

/* Drafts of three times the tolerance are not near, so that nearly all have to shrink. */
static void test_proven(void **state) {
    (void)state;
    const struct {
        const char *name;
        double tolerance, spacing;
    } cases[] = {{"sphere.ply", 0.03, 0.015}, {"torus.off", 0.02, 0.01}, {"part.obj", 0.01, 0.01}};
    for (size_t m = 0; m < sizeof cases / sizeof *cases; ++m) {
        fixture f;
        fixture_model(&f, cases[m].name);
        fixture_sample(&f, cases[m].spacing);
        double tolerance = cases[m].tolerance * f.surface.diagonal;
        const psplat_limits limits = {.tolerance = tolerance,
                                      .crease_tolerance = 0.5 * tolerance,
                                      .crease_slack = 0.3 * tolerance,
                                      .margin = 0.2 * f.samples.spacing,
                                      .proven = 1,
                                      .distance = f.distance};
        double usual = grow_all(&f, limits, 0.95), astray = grow_all(&f, limits, 3);
        print_message("%s: mean areas %g, and %g of drafts gone astray\n", cases[m].name, usual,
                      astray);
        assert_true(usual > 10 * tolerance * tolerance);
        assert_true(astray > 0.1 * usual); /* they shrink; they do not end as discs */
        fixture_free(&f);
    }
}

int test_prove_candidate_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_proven)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
