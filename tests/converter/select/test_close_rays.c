/* SPDX-License-Identifier: MIT
 *
 * test_close_rays.c - tests of closing gaps that slanted rays find between splats. Gaps are counted
 * before and after with rays of other seeds; the splats may cost only so many more, keep their
 * limits, and leave nothing of the surface uncovered.
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
#include "base/region.h"
#include "base/region_tree.h"
#include "fit/region_near.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "select/close_rays.h"
#include "select/close_seams.h"
#include "select/conversion.h"
#include "select/fill_holes.h"
#include "select/greedy_cover.h"
#include "select/precision.h"
#include "select/selection.h"

typedef struct closing {
    fixture f;
    psplat_convert_desc desc;
    psplat_conversion c;
    psplat_splats splats;
} closing;

/* Runs the stages before close_rays.c. tolerance and spacing are in diagonals; precision is that of
 * psplat_convert_desc. */
static void closing_begin(closing *r, const char *name, double tolerance, double spacing,
                          int planar, double precision) {
    *r = (closing){.desc = {.planar = planar, .precision = precision}};
    fixture_model(&r->f, name);
    fixture_sample(&r->f, spacing);
    double length = tolerance * r->f.surface.diagonal;
    r->c = (psplat_conversion){.desc = &r->desc,
                               .surface = r->f.surface,
                               .samples = r->f.samples,
                               .distance = r->f.distance,
                               .splats = &r->splats,
                               .tolerance = length,
                               .percent = 100 * tolerance,
                               .diagonal = r->f.surface.diagonal};
    r->c.limits = (psplat_limits){.tolerance = 0.99 * length,
                                  .crease_tolerance = 0.5 * length,
                                  .crease_slack = 0.3 * length,
                                  .margin = 0.5 * r->f.samples.spacing,
                                  .planar = planar,
                                  .proven = 1,
                                  .distance = r->f.distance};
    const psplat_fit_context context = psplat_conversion_context(&r->c);
    assert_int_equal(psplat_greedy_cover(&context, &r->desc, &r->c.selection, NULL), PSPLAT_OK);
    assert_int_equal(psplat_fill_holes(&r->c, NULL), PSPLAT_OK);
    if (precision > 0) {
        r->splats.precision = psplat_precision_choose(&r->c);
        assert_true(r->splats.precision.unit > 0);
        r->c.limits.precision = &r->splats.precision;
        psplat_selection_drop_untaken(&r->c.selection);
        assert_int_equal(psplat_fill_holes(&r->c, NULL), PSPLAT_OK);
    }
    psplat_selection_drop_untaken(&r->c.selection);
}

static void closing_end(closing *r) {
    psplat_splats_free(&r->splats);
    psplat_selection_free(&r->c.selection);
    psplat_hole_memory_free(&r->c.hole_memory);
    r->f.samples = r->c.samples; /* Stages have appended samples. */
    fixture_free(&r->f);
}

/* Returns how many rays pass between the candidates as seams would be closed, and asserts that each
 * lies within the tolerance of the surface. */
static size_t count_gaps(const closing *r, uint64_t seed) {
    psplat_selection copy = r->c.selection;
    psplat_region *regions = malloc((copy.count + 1) * sizeof *regions);
    copy.candidates = malloc((copy.count + 1) * sizeof *copy.candidates);
    assert_non_null(regions);
    assert_non_null(copy.candidates);
    memcpy(copy.candidates, r->c.selection.candidates, copy.count * sizeof *copy.candidates);
    const psplat_fit_context context = psplat_conversion_context(&r->c);
    assert_int_equal(psplat_close_seams(&context, &copy), PSPLAT_OK);
    for (size_t i = 0; i < copy.count; ++i) {
        int near;
        regions[i] = copy.candidates[i].region;
        assert_true(copy.candidates[i].taken);
        assert_int_equal(psplat_region_near(&regions[i], r->f.distance, r->c.tolerance, &near),
                         PSPLAT_OK);
        assert_true(near);
    }
    psplat_measured_splats measured = {
        .regions = regions, .count = copy.count, .tolerance = r->c.tolerance};
    measured.region_tree = psplat_region_tree_create(regions, copy.count, 0);
    assert_non_null(measured.region_tree);
    const psplat_ray_search search = {.surface = &r->c.surface,
                                      .measured = &measured,
                                      .distance = r->f.distance,
                                      .points = 20000,
                                      .seed = seed};
    psplat_ray_holes holes;
    assert_int_equal(psplat_ray_holes_find(&search, &holes), PSPLAT_OK);
    size_t count = holes.count;
    psplat_ray_holes_free(&holes);
    psplat_measured_splats_free(&measured);
    free(copy.candidates);
    return count;
}

/* Asserts that the candidates cover every sample that they are recorded to cover, and all of them
 * together every sample. */
static void check_cover(const closing *r) {
    uint8_t *covered = calloc(r->c.samples.count + 1, 1);
    assert_non_null(covered);
    for (size_t i = 0; i < r->c.selection.count; ++i) {
        const psplat_candidate *candidate = &r->c.selection.candidates[i];
        for (size_t k = 0; k < candidate->covered_count; ++k) {
            uint32_t sample = candidate->covered[k];
            double uvh[3];
            assert_true(sample < r->c.samples.count);
            psplat_region_local(&candidate->region, r->c.samples.positions + 3 * (size_t)sample,
                                uvh);
            assert_true(fabs(uvh[2]) <= r->c.tolerance);
            /* What rounding may cut off, in units of u and v, is the grid's step at most. */
            assert_true(psplat_region_contains(&candidate->region, uvh, 1 + 1e-6, 1e-6));
            covered[sample] = 1;
        }
    }
    for (size_t i = 0; i < r->c.samples.count; ++i) assert_true(covered[i]);
    free(covered);
}

static double ellipse_area(const psplat_region *region) {
    return region->radius[0] * region->radius[1];
}

/* Returns how many of these candidates, known by what they cover, have a larger ellipse now. */
static size_t count_extended(const closing *r, const psplat_candidate *old, size_t count,
                             const uint32_t *first) {
    size_t extended = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < r->c.selection.count; ++k) {
            const psplat_candidate *now = &r->c.selection.candidates[k];
            /* The step of the grid changes areas by less than a hundredth. */
            if (now->covered_count == old[i].covered_count && now->covered[0] == first[i] &&
                ellipse_area(&now->region) > 1.01 * ellipse_area(&old[i].region))
                ++extended;
        }
    return extended;
}

static void test_gaps(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double tolerance, spacing;
        int planar;
        double precision;
    } cases[] = {{"torus.off", 0.01, 0.015, 1, 0},
                 {"torus.off", 0.01, 0.015, 1, 0.1},
                 {"torus.off", 0.004, 0.015, 0, 0.1},
                 {"part.obj", 0.005, 0.01, 0, 0.1}};
    size_t all_extended = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        closing r;
        closing_begin(&r, cases[i].name, cases[i].tolerance, cases[i].spacing, cases[i].planar,
                      cases[i].precision);
        size_t before = count_gaps(&r, 99), splats = r.c.selection.count;
        psplat_candidate *old = malloc(splats * sizeof *old);
        uint32_t *first = malloc(splats * sizeof *first);
        assert_non_null(old);
        assert_non_null(first);
        memcpy(old, r.c.selection.candidates, splats * sizeof *old);
        for (size_t k = 0; k < splats; ++k) first[k] = old[k].covered[0];
        assert_int_equal(psplat_close_rays(&r.c, NULL), PSPLAT_OK);
        size_t after = count_gaps(&r, 99), extended = count_extended(&r, old, splats, first);
        print_message("%s: %zu splats became %zu, %zu extended, %zu gaps %zu\n", cases[i].name,
                      splats, r.c.selection.count, extended, before, after);
        all_extended += extended;
        free(old);
        free(first);
        check_cover(&r);
        assert_true(before > 0);
        assert_true(2 * after <= before);
        /* What gaps may cost, most_growth of close_rays.c, is 20 % more splats, rounded up. The
         * holes that are filled at last are not bounded by it; here they have taken none. */
        assert_true(r.c.selection.count <= splats + (20 * splats + 99) / 100 + 2);
        closing_end(&r);
    }
    assert_true(all_extended > 4); /* New splats may close all gaps of one model. */
}

/* Where rays find nothing, nothing changes. */
static void test_closed(void **state) {
    (void)state;
    closing r;
    closing_begin(&r, "cube.off", 0.01, 0.05, 0, 0);
    size_t splats = r.c.selection.count;
    psplat_region *regions = malloc(splats * sizeof *regions);
    assert_non_null(regions);
    for (size_t i = 0; i < splats; ++i) regions[i] = r.c.selection.candidates[i].region;
    assert_int_equal(count_gaps(&r, 1), 0);
    assert_int_equal(psplat_close_rays(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(r.c.selection.count, splats);
    for (size_t i = 0; i < splats; ++i)
        assert_memory_equal(&regions[i], &r.c.selection.candidates[i].region, sizeof *regions);
    free(regions);
    closing_end(&r);
}

static int stop(void *user, const char *stage, double fraction) {
    (void)user, (void)stage, (void)fraction;
    return 1;
}

static void test_interrupted(void **state) {
    (void)state;
    closing r;
    psplat_error error = {0};
    closing_begin(&r, "cube.off", 0.01, 0.05, 0, 0);
    r.desc.progress = stop;
    assert_int_equal(psplat_close_rays(&r.c, &error), PSPLAT_ERROR_INTERRUPTED);
    closing_end(&r);
}

int test_close_rays_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gaps),
        cmocka_unit_test(test_closed),
        cmocka_unit_test(test_interrupted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
