/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_creases.c - splats that reach too far over a crease shrink.
 *
 * The measure is that of the promise. It looks at the splats' outlines and at creases alone, so
 * that no sample has to tell. A splat that shrinks gets its lines anew.
 */
#include "finish/mend_creases.h"

#include "base/region_tree.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/quantize_candidate.h"
#include "measure/crease_crossings.h"
#include "measure/measured_splats.h"
#include "select/fill_holes.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How often splats shrink, and each time by which factor at least and to what part of their width
 * at most. Chosen by hand. */
enum { ROUNDS = 8 };
static const double shrink_factor = 0.85, least_part = 0.25;

/* The number of points for each splat that tell of which sheet splats are, and the bounds of the
 * number of all. Those that are fitted lie closer where fitting was hard, so that they tell another
 * sheet than the check finds. Chosen by hand. */
enum { POINTS_PER_SPLAT = 64, LEAST_POINTS = 32768, MOST_POINTS = 262144 };
/* The share of the votes of a splat's sheet from which on another one counts as its own, too: other
 * points, those of the check, may give that one more. Chosen by hand. */
static const double other_sheet_share = 0.25;
/* An offset of the seed: the letters of "crease". */
static const uint64_t mend_seed = 0x6372656173650000u;

/* The state of a round. */
typedef struct mender {
    psplat_conversion *c;
    psplat_samples points;
    uint8_t *crossed; /* by candidate: a crease lies too deep in it */
    uint32_t *covers; /* by sample: how many candidates cover it */
    size_t count;     /* of crossings */
} mender;

/* Draws the points of all rounds. */
static psplat_result draw_points(mender *m) {
    const psplat_conversion *c = m->c;
    double wanted = POINTS_PER_SPLAT * (double)c->selection.count;
    size_t count = (size_t)fmin(fmax(wanted, LEAST_POINTS), MOST_POINTS);
    return psplat_samples_draw_uniform(&c->surface, count, c->desc->seed + mend_seed, &m->points,
                                       NULL);
}

/* Finds those of the candidates that are asked, a 1 for each, in which creases lie too deep. A
 * splat's crossings depend on no other splat. */
static psplat_result find_crossed(mender *m, const uint8_t *asked) {
    psplat_conversion *c = m->c;
    const psplat_selection *selection = &c->selection;
    psplat_measured_splats measured = {.tolerance = c->tolerance};
    psplat_crease_crossing *crossings = NULL;
    double greatest;
    size_t *from = malloc((selection->count + 1) * sizeof *from); /* of each measured splat */
    measured.regions = malloc((selection->count + 1) * sizeof *measured.regions);
    measured.materials = malloc((selection->count + 1) * sizeof *measured.materials);
    measured.triangles = malloc((selection->count + 1) * sizeof *measured.triangles);
    m->crossed = calloc(selection->count + 1, 1);
    int ok = from && measured.regions && measured.materials && measured.triangles && m->crossed;
    psplat_result result = ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < selection->count && !result; ++i) {
        if (!asked[i]) continue;
        const psplat_candidate *candidate = &selection->candidates[i];
        from[measured.count] = i;
        measured.triangles[measured.count] = candidate->triangle;
        measured.materials[measured.count] =
            psplat_mesh_material_of(c->surface.mesh, candidate->triangle);
        measured.regions[measured.count++] = candidate->region;
    }
    if (!result)
        measured.region_tree =
            psplat_region_tree_create_covering(measured.regions, measured.count, c->tolerance);
    if (!measured.region_tree) result = PSPLAT_ERROR_MEMORY;
    if (!result)
        result = psplat_crease_crossings_find(&c->surface, &m->points, &measured, c->tolerance,
                                              other_sheet_share, &crossings, &m->count, &greatest);
    for (size_t i = 0; i < m->count && !result; ++i) m->crossed[from[crossings[i].splat]] = 1;
    free(crossings);
    free(from);
    psplat_measured_splats_free(&measured);
    return result;
}

/* Returns a region on the surface of a candidate, a part as wide: about the middle of the samples
 * that it alone covers, so that these are the last that it loses, else about its centre. */
static psplat_region smaller_region(const mender *m, const psplat_candidate *candidate,
                                    double part) {
    const psplat_region *old = &candidate->region;
    psplat_region region = *old;
    double middle[2] = {0, 0};
    size_t alone = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double uvh[3];
        if (m->covers[candidate->covered[i]] != 1) continue;
        psplat_region_local(old, m->c->samples.positions + 3 * (size_t)candidate->covered[i], uvh);
        for (int k = 0; k < 2; ++k) middle[k] += uvh[k];
        ++alone;
    }
    for (int k = 0; k < 2; ++k) {
        if (alone) middle[k] *= (1 - part) / (double)alone;
        region.radius[k] *= part;
    }
    psplat_region_point(old, middle, region.center);
    psplat_region_slope(old, middle, region.slope);
    return region;
}

/* Makes a candidate of such a region. It is taken where it keeps the limits. */
static psplat_result make_smaller(const psplat_fit_context *context, const mender *m,
                                  const psplat_candidate *candidate, double part,
                                  psplat_candidate *smaller) {
    psplat_region region = smaller_region(m, candidate, part);
    if (!psplat_candidate_copy(candidate, smaller)) return PSPLAT_ERROR_MEMORY;
    psplat_candidate_put_nearest_first(context->samples, region.center, smaller);
    psplat_site site = psplat_site_of(&region, candidate->triangle);
    const psplat_demands demands = {.inside = context->samples->positions +
                                              3 * (size_t)smaller->covered[0]};
    psplat_evaluation e = psplat_evaluate(context, &site, &region, &demands);
    if (e.status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    smaller->taken = e.status == PSPLAT_FIT_KEPT;
    if (!smaller->taken) return PSPLAT_OK;
    if (psplat_candidate_set(context, &site, &e, 0, smaller)) return PSPLAT_ERROR_MEMORY;
    return context->limits->precision ? psplat_quantize_candidate(context, smaller) : PSPLAT_OK;
}

static int compare_samples(const void *left, const void *right) {
    const uint32_t *a = left, *b = right;
    return *a < *b ? -1 : *a > *b;
}

/* Stores whether a smaller candidate covers all samples that the other one alone covers. */
static psplat_result find_whether_kept(const mender *m, const psplat_candidate *candidate,
                                       const psplat_candidate *smaller, int *kept) {
    size_t count = smaller->covered_count, found = 0, alone = 0;
    uint32_t *covered = malloc((count + 1) * sizeof *covered);
    if (!covered) return PSPLAT_ERROR_MEMORY;
    if (count) {
        memcpy(covered, smaller->covered, count * sizeof *covered);
        qsort(covered, count, sizeof *covered, compare_samples);
    }
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        const uint32_t *sample = &candidate->covered[i];
        if (m->covers[*sample] != 1) continue;
        ++alone;
        found += bsearch(sample, covered, count, sizeof *covered, compare_samples) != NULL;
    }
    free(covered);
    *kept = found == alone;
    return PSPLAT_OK;
}

/* Shrinks a candidate in which a crease lies too deep: as little as it can without losing a sample
 * that it alone covers, for which a new one would grow as this one did, and where that cannot be by
 * as little as the limits allow. Where nothing smaller keeps them, it is no longer taken. */
static psplat_result shrink(const psplat_fit_context *context, size_t index, void *user) {
    const mender *m = user;
    psplat_candidate *candidate = &m->c->selection.candidates[index], best = {0};
    psplat_result result = PSPLAT_OK;
    int is_whole = !candidate->covered_count;
    if (!m->crossed[index]) return PSPLAT_OK;
    for (double part = shrink_factor; !is_whole && part > least_part; part *= shrink_factor) {
        psplat_candidate smaller;
        result = make_smaller(context, m, candidate, part, &smaller);
        if (!result && smaller.taken) result = find_whether_kept(m, candidate, &smaller, &is_whole);
        is_whole |= result != PSPLAT_OK;
        if (!result && smaller.taken && (is_whole || !best.taken)) {
            const psplat_candidate other = best;
            best = smaller;
            smaller = other;
        }
        psplat_candidate_free(&smaller);
    }
    psplat_candidate_free(candidate);
    *candidate = best;
    return result;
}

/* Replaces the candidates in which creases lie too deep. */
static psplat_result replace(mender *m, psplat_error *error) {
    psplat_conversion *c = m->c;
    const psplat_fit_context context = psplat_conversion_context(c);
    m->covers = psplat_selection_count_covers(&c->selection, c->samples.count);
    psplat_result result =
        m->covers ? psplat_fit_each(&context, c->selection.count, shrink, m) : PSPLAT_ERROR_MEMORY;
    free(m->covers);
    psplat_selection_drop_untaken(&c->selection);
    if (!result) result = psplat_cover_samples(c, c->samples.count, 1, error);
    psplat_selection_drop_untaken(&c->selection);
    return result;
}

/* Finds the candidates that have changed since no crease lay too deep in them. */
static psplat_result find_changed(mender *m) {
    psplat_selection *selection = &m->c->selection;
    uint8_t *changed = malloc(selection->count + 1);
    m->crossed = NULL;
    if (!changed) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < selection->count; ++i)
        changed[i] = !selection->candidates[i].is_within_creases;
    psplat_result result = find_crossed(m, changed);
    for (size_t i = 0; i < selection->count && !result; ++i)
        selection->candidates[i].is_within_creases = !m->crossed[i];
    free(changed);
    return result;
}

psplat_result psplat_take_back_crossings(psplat_conversion *c, const psplat_region *before) {
    mender m = {.c = c};
    size_t count = c->selection.count;
    uint8_t *changed = malloc(count + 1);
    psplat_result result = changed ? draw_points(&m) : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; ++i)
        changed[i] = memcmp(&c->selection.candidates[i].region, &before[i], sizeof *before) != 0;
    if (!result) result = find_crossed(&m, changed);
    for (size_t i = 0; i < count && !result; ++i)
        if (m.crossed[i]) c->selection.candidates[i].region = before[i];
    free(m.crossed);
    free(changed);
    psplat_samples_free(&m.points);
    return result;
}

psplat_result psplat_mend_creases(psplat_conversion *c, psplat_error *error) {
    mender m = {.c = c, .count = 1};
    psplat_result result = draw_points(&m);
    for (size_t i = 0; i < c->selection.count; ++i)
        c->selection.candidates[i].is_within_creases = 0;
    for (int round = 0; round < ROUNDS && m.count && !result; ++round) {
        if (psplat_conversion_interrupted(c->desc, "finishing", 0)) {
            result = psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
            break;
        }
        result = find_changed(&m);
        if (!result && m.count) result = replace(&m, error);
        free(m.crossed);
    }
    psplat_samples_free(&m.points);
    if (result && result != PSPLAT_ERROR_INTERRUPTED)
        psplat_fail(error, result, 0, "%s while mending creases", psplat_result_text(result));
    return result;
}
