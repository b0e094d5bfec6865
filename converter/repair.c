/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * repair.c - holes between samples.
 *
 * Splats that cover every sample may still leave points between samples uncovered. Points in such
 * holes become samples themselves, candidates of the pool that cover them are found, and the
 * selection is completed and exchanged there, so that a hole costs a splat only where it must.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>

/* Exchanges close holes with few splats but may open others: later rounds only add. */
enum { ROUNDS = 32, EXCHANGING_ROUNDS = 16 };

/* Moves of improvement for each hole, times one more than the rounds before. */
enum { MOVES = 10 };

/* What holes are looked for, in spacings: one in each cube of this side, but not narrower ones. */
static const double coarse = 1, fine = 1.0 / 32;

/* Widens a candidate, and moves it to the grid where there is one. */
static psplat_result fit(void *user, size_t index, psplat_growth *growth) {
    psplat_conversion *c = user;
    psplat_candidate *candidate = &c->selection.candidates[index];
    psplat_result result = PSPLAT_OK;
    if (!candidate->widened)
        result = psplat_candidate_widen(&c->surface, &c->samples, &c->limits, growth, candidate);
    if (!result && c->limits.precision && !candidate->snapped)
        result = psplat_candidate_snap(&c->surface, &c->samples, &c->limits, growth, candidate);
    return result;
}

/* Samples do not ask taken candidates for width, so that exchange does not use it up. */
static psplat_result fit_taken(void *user, size_t index, psplat_growth *growth) {
    const psplat_conversion *c = user;
    return c->selection.candidates[index].taken ? fit(user, index, growth) : PSPLAT_OK;
}

/* Appends points in holes to the samples, and stores how many. */
static psplat_result find_holes(psplat_conversion *c, size_t *count, psplat_error *error) {
    psplat_measured measured;
    psplat_holes holes = {0};
    const psplat_storing storing = {0}; /* only where they are matters here */
    double tolerance = c->limits.tolerance, spacing = c->samples.spacing;
    psplat_result result = psplat_growth_each(c->selection.count, fit_taken, c);
    if (!result) result = psplat_store_splats(&c->selection, &storing, c->splats);
    if (!result) result = psplat_measured_create(c->splats, tolerance, tolerance, &measured);
    if (!result) {
        result =
            psplat_holes_find(&c->surface, &measured, coarse * spacing, fine * spacing, &holes);
        psplat_measured_free(&measured);
    }
    *count = holes.count;
    if (result)
        psplat_fail(error, result, 0, "out of memory while looking for holes");
    else if (holes.count)
        result = psplat_samples_append(&c->samples, &c->surface, holes.points, holes.triangles,
                                       holes.count, error);
    psplat_holes_free(&holes);
    return result;
}

/* ---- candidates that cover new samples ------------------------------------------------------ */

typedef struct marker {
    const psplat_region *regions;
    uint8_t *marks;
    const double *point;
    double tolerance;
} marker;

static int visit_region(void *user, uint32_t index) {
    marker *m = user;
    double uvh[3];
    psplat_region_local(&m->regions[index], m->point, uvh);
    if (fabs(uvh[2]) <= m->tolerance && psplat_region_contains(&m->regions[index], uvh, 1, 0))
        m->marks[index] = 1;
    return 0;
}

/* Marks the candidates that may cover samples from index first on. */
static psplat_result mark_candidates(const psplat_conversion *c, size_t first, uint8_t *marks) {
    size_t count = c->selection.count;
    psplat_region *regions = malloc((count + 1) * sizeof *regions);
    for (size_t i = 0; regions && i < count; ++i) regions[i] = c->selection.candidates[i].region;
    psplat_locator *locator =
        regions ? psplat_locator_create(regions, count, c->limits.tolerance) : NULL;
    for (size_t i = first; locator && i < c->samples.count; ++i) {
        marker m = {regions, marks, c->samples.positions + 3 * i, c->limits.tolerance};
        psplat_locator_visit(locator, m.point, visit_region, &m);
    }
    psplat_result result = locator ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    psplat_locator_destroy(locator);
    free(regions);
    return result;
}

typedef struct marked {
    psplat_conversion *c;
    const uint8_t *marks;
} marked;

/* Finds again what a marked candidate covers. */
static psplat_result cover_marked(void *user, size_t index, psplat_growth *growth) {
    const marked *m = user;
    psplat_conversion *c = m->c;
    if (!m->marks[index]) return PSPLAT_OK;
    return psplat_candidate_cover(&c->surface, &c->samples, &c->limits, growth,
                                  &c->selection.candidates[index]);
}

/* ---- repair -------------------------------------------------------------------------------- */

/* Finds what the pool covers of the samples from index first on. */
static psplat_result cover_holes(psplat_conversion *c, size_t first) {
    uint8_t *marks = calloc(c->selection.count + 1, 1);
    psplat_result result = marks ? mark_candidates(c, first, marks) : PSPLAT_ERROR_MEMORY;
    marked m = {c, marks};
    if (!result) result = psplat_growth_each(c->selection.count, cover_marked, &m);
    free(marks);
    return result;
}

/* Exchanges candidates around the samples from index first on. */
static psplat_result exchange(psplat_conversion *c, size_t first, int round) {
    const psplat_improvement what = {.samples = &c->samples,
                                     .moves =
                                         (size_t)(MOVES * (1 + psplat_improving_rounds(c->desc))) *
                                         (c->samples.count - first),
                                     .focus = first,
                                     .strict = 1,
                                     .axis = round % 3,
                                     .seed = c->desc->seed + (uint64_t)round};
    return psplat_improve(&c->selection, &what);
}

psplat_result psplat_repair_holes(psplat_conversion *c, psplat_error *error) {
    const psplat_convert_desc *desc = c->desc;
    psplat_result result = PSPLAT_OK;
    size_t holes = 1;
    for (int round = 0; !result && holes && round < ROUNDS; ++round) {
        size_t first = c->samples.count;
        if (desc->progress && desc->progress(desc->user, "closing holes", (double)round / ROUNDS))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result = find_holes(c, &holes, error);
        if (result || !holes) break;
        result = cover_holes(c, first);
        if (!result)
            result = psplat_select_cover(&c->surface, &c->samples, &c->limits, desc, &c->selection,
                                         NULL);
        /* Those that exchange may choose from all lie on the grid, or it would bring back holes. */
        if (!result && round < EXCHANGING_ROUNDS && c->limits.precision)
            result = psplat_growth_each(c->selection.count, fit, c);
        if (!result && round < EXCHANGING_ROUNDS) result = exchange(c, first, round);
        if (result)
            psplat_fail(error, result, 0, "%s while closing holes", psplat_result_text(result));
    }
    /* What the last round added. */
    if (!result && holes && psplat_growth_each(c->selection.count, fit_taken, c))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while closing holes");
    return result;
}
