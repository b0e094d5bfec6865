/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fill_holes.c - the search for holes between splats, and their covering.
 *
 * Splats that cover every sample may still leave points between samples uncovered. Points in such
 * holes are appended to the samples, and the candidates of the pool that cover them are found. Then
 * the greedy cover completes the selection, and a local search around the holes exchanges
 * candidates, so that a hole costs a splat only where it must.
 */
#include "select/fill_holes.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"
#include "fit/grow_ellipse.h"
#include "fit/quantize_candidate.h"
#include "measure/holes.h"
#include "measure/measured_splats.h"
#include "select/conversion.h"
#include "select/effort.h"
#include "select/greedy_cover.h"
#include "select/local_search.h"
#include "select/selection.h"
#include "select/sort_splats.h"

#include <math.h>
#include <stdlib.h>

/* The rounds after which the search ends, and those in which candidates are exchanged. An exchange
 * saves splats but may open other holes, so later rounds only add splats. Chosen by hand. */
enum { ROUNDS = 32, IMPROVING_ROUNDS = 16 };

/* The moves of the local search for each hole, for effort 0; each round of its search adds as many.
 * And the most for each splat: few splats may have many holes between them, and a move that
 * exchanges most of them takes long. Chosen by hand. */
enum { MOVES_PER_HOLE = 6, MOVES_PER_SPLAT = 6 };

/* The side of the cubes in each of which one hole is found, in sample spacings, and the width below
 * which holes are not found, in sample spacings and in tolerances: the lesser of both, since the
 * verification finds those of the latter. Chosen by hand. */
static const double cube_side_spacings = 1, least_hole_spacings = 1.0 / 32;
static const double least_hole_tolerances = 1.0 / 16;

/* Grows a candidate's ellipse, and moves it to the grid where the limits have a precision. */
static psplat_result grow_and_quantize(const psplat_fit_context *context, size_t index,
                                       void *user) {
    psplat_selection *selection = user;
    psplat_candidate *candidate = &selection->candidates[index];
    psplat_result result = PSPLAT_OK;
    if (!candidate->ellipse_grown) result = psplat_grow_ellipse(context, candidate);
    if (!result && context->limits->precision && !candidate->quantized)
        result = psplat_quantize_candidate(context, candidate);
    return result;
}

/* Does so with a taken candidate only. The others stay as the samples made them, since the local
 * search needs the samples that they cover, and their ellipses can still grow once they are taken.
 */
static psplat_result grow_and_quantize_taken(const psplat_fit_context *context, size_t index,
                                             void *user) {
    const psplat_selection *selection = user;
    return selection->candidates[index].taken ? grow_and_quantize(context, index, user) : PSPLAT_OK;
}

psplat_result psplat_find_holes(psplat_conversion *c, int inside_seams, psplat_holes *holes) {
    psplat_measured_splats measured;
    const psplat_sort_desc storing = {0}; /* Only the regions of the splats matter here. */
    double tolerance = c->limits.tolerance, spacing = c->samples.spacing;
    *holes = (psplat_holes){0};
    psplat_result result = psplat_sort_splats(&c->selection, &storing, c->splats);
    if (!result) result = psplat_measured_splats_create_covering(c->splats, tolerance, &measured);
    if (result) return result;
    double coarse = cube_side_spacings * spacing;
    double fine = fmin(least_hole_spacings * spacing, least_hole_tolerances * tolerance);
    for (size_t i = 0; inside_seams && i < measured.count; ++i)
        measured.regions[i] = psplat_region_inside_seams(&measured.regions[i]);
    if (inside_seams)
        result = psplat_holes_find(&c->surface, &measured, coarse, fine, holes);
    else
        result =
            psplat_holes_find_changed(&c->surface, &measured, coarse, fine, &c->hole_memory, holes);
    psplat_measured_splats_free(&measured);
    return result;
}

/* Finishes the taken candidates, finds the holes between them, and appends points in the holes to
 * the samples. Stores how many. */
static psplat_result append_holes(psplat_conversion *c, size_t *count, psplat_error *error) {
    psplat_holes holes = {0};
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result =
        psplat_fit_each(&context, c->selection.count, grow_and_quantize_taken, &c->selection);
    if (!result) result = psplat_find_holes(c, 0, &holes);
    if (result) psplat_fail(error, result, 0, "out of memory while looking for holes");
    *count = holes.count;
    if (!result && holes.count)
        result = psplat_samples_append(&c->samples, &c->surface, holes.points, holes.triangles,
                                       holes.count, error);
    psplat_holes_free(&holes);
    return result;
}

/* ---- candidates that cover new samples ------------------------------------------------------ */

/* One new sample, for which the candidates that may cover it are marked. */
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
    psplat_region_tree *region_tree =
        regions ? psplat_region_tree_create(regions, count, c->limits.tolerance) : NULL;
    for (size_t i = first; region_tree && i < c->samples.count; ++i) {
        marker m = {regions, marks, c->samples.positions + 3 * i, c->limits.tolerance};
        psplat_region_tree_visit(region_tree, m.point, visit_region, &m);
    }
    psplat_result result = region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    psplat_region_tree_destroy(region_tree);
    free(regions);
    return result;
}

typedef struct marked_pool {
    psplat_selection *selection;
    const uint8_t *marks;
} marked_pool;

/* Finds again the samples that a marked candidate covers. */
static psplat_result cover_marked(const psplat_fit_context *context, size_t index, void *user) {
    const marked_pool *m = user;
    if (!m->marks[index]) return PSPLAT_OK;
    return psplat_candidate_cover(context, &m->selection->candidates[index]);
}

/* ---- covering ------------------------------------------------------------------------------ */

/* Finds which of the samples from index first on the candidates of the pool cover. */
static psplat_result cover_holes(psplat_conversion *c, size_t first) {
    uint8_t *marks = calloc(c->selection.count + 1, 1);
    psplat_result result = marks ? mark_candidates(c, first, marks) : PSPLAT_ERROR_MEMORY;
    const psplat_fit_context context = psplat_conversion_context(c);
    marked_pool m = {&c->selection, marks};
    if (!result) result = psplat_fit_each(&context, c->selection.count, cover_marked, &m);
    free(marks);
    return result;
}

/* Runs a local search around the samples from index first on. */
static psplat_result improve_around_holes(psplat_conversion *c, size_t first, int round) {
    size_t share = (size_t)(1 + psplat_effort_of(c->desc).search_rounds);
    size_t moves = MOVES_PER_HOLE * share * (c->samples.count - first);
    size_t most = MOVES_PER_SPLAT * share * psplat_selection_taken(&c->selection);
    const psplat_local_search_desc what = {.samples = &c->samples,
                                           .surface = &c->surface,
                                           .moves = moves < most ? moves : most,
                                           .focus = first,
                                           .strict = 1,
                                           .axis = round % 3,
                                           .seed = c->desc->seed + (uint64_t)round};
    return psplat_local_search(&c->selection, &what);
}

/* Covers the samples from index first on, which lie in holes, and exchanges candidates there. */
static psplat_result close_holes(psplat_conversion *c, size_t first, int round) {
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result = cover_holes(c, first);
    if (!result) result = psplat_greedy_cover(&context, c->desc, &c->selection, NULL);
    if (result || round >= IMPROVING_ROUNDS) return result;
    /* The local search may take any candidate of the pool. It must lie on the grid already, or
     * moving it there later would open holes again. */
    if (c->limits.precision)
        result = psplat_fit_each(&context, c->selection.count, grow_and_quantize, &c->selection);
    return result ? result : improve_around_holes(c, first, round);
}

static psplat_result fill(psplat_conversion *c, int first_round, psplat_error *error) {
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result = PSPLAT_OK;
    size_t holes = 1;
    for (int round = first_round; !result && holes && round < ROUNDS; ++round) {
        size_t first = c->samples.count;
        /* Half of the time goes into the first round, half of the rest into the next. */
        int before = round - first_round;
        if (psplat_conversion_interrupted(c->desc, "closing holes", before / (before + 1.0)))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result = append_holes(c, &holes, error);
        if (result || !holes) break;
        result = close_holes(c, first, round);
        if (result)
            psplat_fail(error, result, 0, "%s while closing holes", psplat_result_text(result));
    }
    /* The last round may have added candidates. */
    if (!result && holes &&
        psplat_fit_each(&context, c->selection.count, grow_and_quantize_taken, &c->selection))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while closing holes");
    return result;
}

psplat_result psplat_fill_holes(psplat_conversion *c, psplat_error *error) {
    return fill(c, 0, error);
}

psplat_result psplat_fill_last_holes(psplat_conversion *c, psplat_error *error) {
    return fill(c, IMPROVING_ROUNDS, error);
}

psplat_result psplat_cover_samples(psplat_conversion *c, size_t first, int last,
                                   psplat_error *error) {
    psplat_result result = close_holes(c, first, IMPROVING_ROUNDS);
    if (!result) return last ? psplat_fill_last_holes(c, error) : psplat_fill_holes(c, error);
    return psplat_fail(error, result, 0, "%s while covering samples", psplat_result_text(result));
}
