/* SPDX-License-Identifier: MIT
 *
 * closing_fixture.h - conversions of bundled models up to the stages that close gaps, and counts of
 * the rays that pass between their splats. Include it after cmocka.h.
 */
#ifndef PHONGSPLAT_TESTS_CLOSING_FIXTURE_H
#define PHONGSPLAT_TESTS_CLOSING_FIXTURE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "stage_fixture.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "fit/region_near.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "finish/close_seams.h"
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

/* Runs the stages before close_rays.c on a model that has a surface, which moves. tolerance and
 * spacing are in diagonals; precision is that of psplat_convert_desc. */
static inline void closing_begin_with(closing *r, fixture *model, double tolerance, double spacing,
                                      int planar, double precision) {
    *r = (closing){.f = *model, .desc = {.planar = planar, .precision = precision}};
    r->f.surface.mesh = &r->f.mesh;
    *model = (fixture){0};
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

/* Does that with a bundled model. */
static inline void closing_begin(closing *r, const char *name, double tolerance, double spacing,
                                 int planar, double precision) {
    fixture model;
    fixture_model(&model, name);
    closing_begin_with(r, &model, tolerance, spacing, planar, precision);
}

static inline void closing_end(closing *r) {
    psplat_splats_free(&r->splats);
    psplat_selection_free(&r->c.selection);
    psplat_hole_memory_free(&r->c.hole_memory);
    r->f.samples = r->c.samples; /* Stages have appended samples. */
    fixture_free(&r->f);
}

/* Returns the regions of all candidates, which the caller frees. */
static inline psplat_region *copy_regions(const closing *r) {
    psplat_region *regions = malloc((r->c.selection.count + 1) * sizeof *regions);
    assert_non_null(regions);
    for (size_t i = 0; i < r->c.selection.count; ++i)
        regions[i] = r->c.selection.candidates[i].region;
    return regions;
}

/* Returns how many of 480,000 rays pass between the regions of all candidates, which it frees, and
 * under walls that reach so many tolerances down, and of these along how many one sees through. */
static inline size_t count_rays(const closing *r, psplat_region *regions, double wall_tolerances,
                                uint64_t seed, size_t *shown) {
    psplat_measured_splats measured = {.regions = regions,
                                       .count = r->c.selection.count,
                                       .tolerance = r->c.tolerance,
                                       .wall = wall_tolerances * r->c.tolerance};
    measured.region_tree = psplat_region_tree_create(regions, measured.count, 0);
    assert_non_null(measured.region_tree);
    const psplat_ray_search search = {.surface = &r->c.surface,
                                      .measured = &measured,
                                      .distance = r->f.distance,
                                      .points = 20000,
                                      .seed = seed};
    psplat_ray_holes holes;
    assert_int_equal(psplat_ray_holes_find(&search, &holes), PSPLAT_OK);
    size_t count = holes.count;
    *shown = 0;
    for (size_t i = 0; i < count; ++i)
        *shown += (size_t)psplat_ray_hole_shows(&holes.holes[i], &measured);
    psplat_ray_holes_free(&holes);
    psplat_measured_splats_free(&measured);
    return count;
}

/* Returns how many rays pass between the candidates as seams would be closed, and under walls that
 * reach so many tolerances down, and of these along how many one sees through; asserts that each
 * candidate lies within the tolerance of the surface. */
static inline size_t count_shown_gaps(const closing *r, double wall_tolerances, uint64_t seed,
                                      size_t *shown) {
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
    free(copy.candidates);
    return count_rays(r, regions, wall_tolerances, seed, shown);
}

static inline size_t count_gaps(const closing *r, double wall_tolerances, uint64_t seed) {
    size_t shown;
    return count_shown_gaps(r, wall_tolerances, seed, &shown);
}

/* Asserts that a step changes regions of a torus, and to the same whatever the number of threads.
 */
static inline void check_threads(psplat_result (*step)(closing *r)) {
    psplat_region *first = NULL;
    size_t count = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        closing r;
        fixture_threads(threads);
        closing_begin(&r, "torus.off", 0.004, 0.015, 0, 0.1);
        psplat_region *before = copy_regions(&r);
        size_t count_before = r.c.selection.count;
        assert_int_equal(step(&r), PSPLAT_OK);
        if (!first) count = r.c.selection.count;
        assert_int_equal(r.c.selection.count, count);
        psplat_region *regions = copy_regions(&r);
        size_t both = count < count_before ? count : count_before;
        assert_memory_not_equal(before, regions, both * sizeof *regions);
        if (!first) first = copy_regions(&r);
        assert_memory_equal(first, regions, count * sizeof *regions);
        free(before);
        free(regions);
        closing_end(&r);
    }
    fixture_threads(0);
    free(first);
}

/* Asserts that the candidates cover every sample that they are recorded to cover, and all of them
 * together every sample. */
static inline void check_cover(const closing *r) {
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

#endif
