/* SPDX-License-Identifier: MIT
 *
 * test_mend_textures.c - tests of splats of a narrow strip that have become so wide that they show
 * it over what lies beside it: these get their old regions back, and the others keep theirs. That
 * splats which miss such a strip give way is tested with whole conversions
 * (test_kept_conversion.c).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "finish/mend_textures.h"
#include "fit/fit_context.h"
#include "select/conversion.h"
#include "select/fill_holes.h"
#include "select/greedy_cover.h"
#include "select/selection.h"
#include "splats/splats.h"

enum { CELLS = 32 };

/* The cells of one column, for x from 0 to 1/16, are a chart of their own. */
static int is_strip(uint32_t triangle) {
    return triangle / 2 % CELLS == CELLS / 2;
}

static void chart_strip(uint32_t triangle, const double p[3], float uv[2]) {
    uv[0] = (float)(p[0] / 4 + (is_strip(triangle) ? 0.5 : 0));
    uv[1] = (float)(p[1] / 4);
}

typedef struct stage {
    charted c;
    psplat_convert_desc desc;
    psplat_conversion conversion;
    psplat_splats splats;
    psplat_region *fitted; /* of all candidates */
} stage;

/* Covers the square with splats that end at the borders of charts. */
static void stage_begin(stage *s) {
    const double tolerance = 0.01;
    *s = (stage){.fitted = NULL};
    charted_make(&s->c, CELLS, place_square, chart_strip);
    charted_build(&s->c, fixture_crease_angle);
    fixture_sample(&s->c.f, 0.02);
    psplat_conversion *c = &s->conversion;
    *c = (psplat_conversion){.desc = &s->desc,
                             .surface = s->c.f.surface,
                             .samples = s->c.f.samples,
                             .distance = s->c.f.distance,
                             .splats = &s->splats,
                             .kernel = {2, 2},
                             .tolerance = tolerance,
                             .limits = {.tolerance = 0.98 * tolerance,
                                        .crease_tolerance = 0.5 * tolerance,
                                        .crease_slack = 0.3 * tolerance,
                                        .distance = s->c.f.distance}};
    const psplat_fit_context context = psplat_conversion_context(c);
    assert_int_equal(psplat_greedy_cover(&context, &s->desc, &c->selection, NULL), PSPLAT_OK);
    psplat_selection_drop_untaken(&c->selection);
    assert_int_equal(psplat_fill_holes(c, NULL), PSPLAT_OK);
    psplat_selection_drop_untaken(&c->selection);
    s->fitted = malloc((c->selection.count + 1) * sizeof *s->fitted);
    assert_non_null(s->fitted);
    for (size_t i = 0; i < c->selection.count; ++i)
        s->fitted[i] = c->selection.candidates[i].region;
}

static void stage_end(stage *s) {
    free(s->fitted);
    psplat_splats_free(&s->splats);
    psplat_selection_free(&s->conversion.selection);
    psplat_hole_memory_free(&s->conversion.hole_memory);
    s->c.f.samples = s->conversion.samples;
    charted_free(&s->c);
}

/* Takes the lines of all splats, lets those of the strip reach so far across it, and gives back
 * what may not stay. Returns how many splats of the strip got their old regions back, and stores
 * how many others did. */
static size_t take_back(stage *s, double across, size_t *others) {
    psplat_selection *selection = &s->conversion.selection;
    size_t strip = 0;
    *others = 0;
    for (size_t i = 0; i < selection->count; ++i) {
        psplat_candidate *candidate = &selection->candidates[i];
        psplat_region *region = &candidate->region;
        region->line_count = 0;
        if (is_strip(candidate->triangle)) region->radius[fabs(region->u[0]) < 0.5] = across;
    }
    assert_int_equal(psplat_take_back_slides(&s->conversion, s->fitted), PSPLAT_OK);
    for (size_t i = 0; i < selection->count; ++i) {
        const psplat_candidate *candidate = &selection->candidates[i];
        int is_back = !memcmp(&candidate->region, &s->fitted[i], sizeof *s->fitted);
        *(is_strip(candidate->triangle) ? &strip : others) += (size_t)is_back;
    }
    return strip;
}

/* Splats of the strip that are 16 times as wide as it show it over what lies beside it, of which
 * they have more beneath them. Those beside it are over their own chart mostly, and stay. */
static void test_far(void **state) {
    (void)state;
    stage s;
    size_t others;
    stage_begin(&s);
    assert_true(take_back(&s, 0.5, &others) > 0);
    assert_int_equal(others, 0);
    stage_end(&s);
}

/* Where they are twice as wide as the strip, that is their own. */
static void test_near(void **state) {
    (void)state;
    stage s;
    size_t others;
    stage_begin(&s);
    assert_int_equal(take_back(&s, 0.0625, &others), 0);
    assert_int_equal(others, 0);
    stage_end(&s);
}

int test_mend_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_far),
        cmocka_unit_test(test_near),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
