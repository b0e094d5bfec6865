/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trim_splats.c - the removal of splats that others have made needless, and the shrinking of those
 * whose rims stand off more than they have to.
 *
 * Splats are chosen so that each is needed for some sample. Then their ellipses grow, holes between
 * samples are filled, and gaps that rays find are closed by splats that are extended and by new
 * ones, so that in the end others cover all that some splat does. Such a splat is left out.
 *
 * A splat grows until some point of it is the tolerance away from the surface, and that is a point
 * of its rim. Seen from the side, such rims make the outline too wide and ragged. But most splats
 * reach over samples that others cover, too. So the one that stands off most shrinks to the samples
 * for which it is needed, and then the next one.
 *
 * Where either opens a hole or lets a ray through, a splat that closes it gets its old size back:
 * one that has shrunk rather than one that was left out.
 */
#include "finish/trim_splats.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "finish/openings.h"
#include "finish/stand_off.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"
#include "fit/quantize_candidate.h"
#include "select/fill_holes.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* All of these were chosen by hand. */
/* How far a rim has to stand off for its splat to shrink, in tolerances. */
static const double least_stand_off = 0.5;
/* The least part of its radii that a splat shrinks to. With 0.8, normals of the Duck err by 3 %
 * more, and outlines are hardly narrower. */
static const double least_scale = 0.9;
/* How far beyond the samples that it is needed for a splat reaches, in their spacings. */
static const double margin_spacings = 0.5;
/* The points of a rim at which it is measured how far it stands off. */
enum { SIDES = 16 };

/* A candidate as it was, where it has been trimmed, and what it shrinks to. */
typedef struct trimmed {
    psplat_candidate whole; /* empty unless it is smaller now */
    double scale;           /* of its radii, 1 at most; 0: it is left out */
} trimmed;

typedef struct trimmer {
    psplat_conversion *c;
    psplat_shrunk shrunk; /* a splat's worth is how far its rim stands off, a length, and more than
                             that where it is left out */
    trimmed *splats;      /* count: of the candidates */
    size_t count;
    psplat_selection met; /* Copies of the candidates, recorded to cover all that they do. An
                             extended candidate itself is recorded to cover what it did before. */
    uint32_t *covers;     /* of each sample: how many of these cover it */
} trimmer;

/* Who is to be recorded to cover a sample. */
typedef struct heir {
    uint32_t candidate; /* PSPLAT_NONE: nobody anew */
    double radius;      /* of the sample from its centre, in radii; 0: somebody is already */
} heir;

static void trimmer_free(trimmer *t) {
    for (size_t i = 0; t->splats && i < t->count; ++i) psplat_candidate_free(&t->splats[i].whole);
    psplat_shrunk_free(&t->shrunk);
    psplat_selection_free(&t->met);
    free(t->splats);
    free(t->covers);
}

/* ---- what splats are needed for -------------------------------------------------------------- */

/* Finds how far the rim of a candidate stands off. */
static psplat_result measure(const psplat_fit_context *context, size_t index, void *user) {
    trimmer *t = user;
    double *worth = &t->shrunk.splats[index].worth;
    uint32_t guess = PSPLAT_NONE;
    t->splats[index].scale = 1;
    for (int i = 0; i < SIDES; ++i) {
        double angle = 2 * PSPLAT_PI * i / SIDES;
        const double uv[2] = {cos(angle), sin(angle)};
        psplat_stand_off stand_off;
        psplat_result result = psplat_stand_off_find(context, &t->shrunk.before.regions[index], uv,
                                                     &guess, &stand_off);
        if (result) return result;
        *worth = max2(*worth, stand_off.length);
    }
    return PSPLAT_OK;
}

/* Returns how far a sample is from the centre of a region, in radii. */
static double radius_of(const psplat_samples *samples, const psplat_region *region,
                        uint32_t sample) {
    double uvh[3];
    psplat_region_local(region, samples->positions + 3 * (size_t)sample, uvh);
    return hypot(uvh[0], uvh[1]);
}

/* Records for the copy of a candidate all samples that it covers. */
static psplat_result find_covered(const psplat_fit_context *context, size_t index, void *user) {
    trimmer *t = user;
    return psplat_candidate_cover(context, &t->met.candidates[index]);
}

/* Returns how far from the centre, in radii, the farthest sample is that a candidate covers alone,
 * or that it alone is recorded to cover, as a disc of the last resort may be; negative: there is
 * none. */
static double needed_radius(const trimmer *t, size_t index) {
    const psplat_candidate *met = &t->met.candidates[index],
                           *candidate = &t->c->selection.candidates[index];
    double radius = -1;
    for (size_t i = 0; i < met->covered_count; ++i)
        if (t->covers[met->covered[i]] == 1)
            radius = max2(radius, radius_of(&t->c->samples, &met->region, met->covered[i]));
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (t->covers[candidate->covered[i]] == 0)
            radius = max2(radius, radius_of(&t->c->samples, &met->region, candidate->covered[i]));
    return radius;
}

/* Returns whether a candidate still reaches a sample, at the scale that was chosen for it. */
static int keeps(const trimmer *t, size_t index, uint32_t sample) {
    double scale = t->splats[index].scale;
    if (scale == 0 || scale == 1) return scale == 1;
    return radius_of(&t->c->samples, &t->shrunk.before.regions[index], sample) <= scale;
}

/* Sets the scale of a candidate, which leaves samples that others cover, too. */
static void set_scale(const trimmer *t, size_t index, double scale) {
    const psplat_candidate *met = &t->met.candidates[index];
    t->splats[index].scale = scale;
    for (size_t i = 0; i < met->covered_count && scale < 1; ++i)
        t->covers[met->covered[i]] -= !keeps(t, index, met->covered[i]);
}

/* Leaves a candidate out where others cover all that it does. */
static void leave_out(const trimmer *t, size_t index) {
    if (needed_radius(t, index) >= 0) return;
    set_scale(t, index, 0);
    t->shrunk.splats[index].worth += t->c->diagonal;
}

/* Chooses the scale of a candidate that is needed. */
static void choose_scale(const trimmer *t, size_t index) {
    const double *radius = t->shrunk.before.regions[index].radius;
    double needed = needed_radius(t, index) +
                    margin_spacings * t->c->samples.spacing / min2(radius[0], radius[1]);
    set_scale(t, index, min2(max2(needed, least_scale), 1));
}

/* Finds for each sample that no candidate stays recorded to cover that of those which cover it in
 * whose middle it is most. */
static void find_heirs(const trimmer *t, heir *heirs) {
    for (size_t i = 0; i < t->count; ++i) {
        const psplat_candidate *candidate = &t->c->selection.candidates[i];
        for (size_t k = 0; k < candidate->covered_count; ++k)
            if (keeps(t, i, candidate->covered[k])) heirs[candidate->covered[k]].radius = 0;
    }
    for (size_t i = 0; i < t->count; ++i) {
        const psplat_candidate *met = &t->met.candidates[i];
        for (size_t k = 0; k < met->covered_count; ++k) {
            heir *heir = &heirs[met->covered[k]];
            double radius = radius_of(&t->c->samples, &met->region, met->covered[k]);
            if (radius < heir->radius && keeps(t, i, met->covered[k]))
                *heir = (struct heir){(uint32_t)i, radius};
        }
    }
}

/* Records what candidates are no longer recorded to cover for others. Returns 0 when out of memory.
 */
static int hand_over(const trimmer *t) {
    size_t count = t->c->samples.count;
    heir *heirs = malloc((count + 1) * sizeof *heirs);
    int ok = heirs != NULL;
    for (size_t i = 0; ok && i < count; ++i) heirs[i] = (heir){PSPLAT_NONE, HUGE_VAL};
    if (ok) find_heirs(t, heirs);
    for (size_t i = 0; ok && i < count; ++i)
        if (heirs[i].candidate != PSPLAT_NONE)
            ok = psplat_candidate_add_covered(&t->c->selection.candidates[heirs[i].candidate],
                                              (uint32_t)i);
    free(heirs);
    return ok;
}

/* Chooses the scales of all candidates, those first that stand off most. Returns 0 when out of
 * memory. */
static int choose_scales(trimmer *t) {
    const psplat_smaller *splats = t->shrunk.splats;
    double least = least_stand_off * t->c->limits.tolerance;
    uint32_t *order = psplat_shrunk_order(&t->shrunk);
    t->covers = psplat_selection_count_covers(&t->met, t->c->samples.count);
    int ok = order && t->covers;
    for (size_t i = 0; ok && i < t->count; ++i) leave_out(t, order[i]);
    for (size_t i = 0; ok && i < t->count; ++i)
        if (t->splats[order[i]].scale > 0 && splats[order[i]].worth >= least)
            choose_scale(t, order[i]);
    free(order);
    ok = ok && hand_over(t);
    psplat_selection_free(&t->met);
    return ok;
}

/* ---- smaller splats -------------------------------------------------------------------------- */

/* Drops the samples beyond a scale from what a candidate is recorded to cover. */
static void leave(const psplat_samples *samples, double scale, psplat_candidate *candidate) {
    size_t kept = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (radius_of(samples, &candidate->region, candidate->covered[i]) <= scale)
            candidate->covered[kept++] = candidate->covered[i];
    candidate->covered_count = kept;
}

/* Shrinks a candidate around its centre, and stores whether it keeps the limits and covers what it
 * does not leave, on the grid if there is one. */
static psplat_result shrink(const psplat_fit_context *context, double scale,
                            psplat_candidate *candidate, int *fits) {
    psplat_region region = candidate->region;
    psplat_site site = psplat_site_of(&region, candidate->triangle);
    *fits = 0;
    leave(context->samples, scale, candidate);
    if (!candidate->covered_count) return PSPLAT_OK;
    psplat_candidate_put_nearest_first(context->samples, region.center, candidate);
    for (int k = 0; k < 2; ++k) region.radius[k] *= scale;
    psplat_fit_status status = psplat_candidate_replace(context, &site, &region, 0, 1, candidate);
    if (status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    *fits = !status;
    if (!*fits || !context->limits->precision) return PSPLAT_OK;
    return psplat_quantize_whole_candidate(context, candidate, fits);
}

/* Takes a candidate no more that is left out. Replaces one that shrinks by a smaller one, if that
 * keeps the limits. */
static psplat_result trim(const psplat_fit_context *context, size_t index, void *user) {
    trimmer *t = user;
    trimmed *splat = &t->splats[index];
    psplat_candidate *candidate = &t->c->selection.candidates[index], smaller;
    int fits;
    if (splat->scale == 1) return PSPLAT_OK;
    if (splat->scale == 0) {
        candidate->taken = 0;
        t->shrunk.splats[index].is_smaller = 1;
        return PSPLAT_OK;
    }
    if (!psplat_candidate_copy(candidate, &smaller)) return PSPLAT_ERROR_MEMORY;
    psplat_result result = shrink(context, splat->scale, &smaller, &fits);
    int is_smaller =
        !result && fits &&
        psplat_region_ellipse(&smaller.region) < psplat_region_ellipse(&candidate->region);
    t->shrunk.splats[index].is_smaller = is_smaller;
    if (is_smaller) {
        splat->whole = *candidate;
        *candidate = smaller;
    } else {
        psplat_candidate_free(&smaller);
    }
    return result;
}

/* ---- all ------------------------------------------------------------------------------------- */

/* Gives a candidate its old size. */
static int restore(void *user, uint32_t index, const psplat_opening *opening) {
    trimmer *t = user;
    psplat_candidate *candidate = &t->c->selection.candidates[index];
    (void)opening;
    if (candidate->taken) {
        psplat_candidate_free(candidate);
        *candidate = t->splats[index].whole;
        t->splats[index].whole = (psplat_candidate){0};
    }
    candidate->taken = 1;
    t->shrunk.splats[index].is_smaller = 0;
    return 1;
}

static psplat_result begin(trimmer *t, psplat_conversion *c) {
    *t = (trimmer){.c = c, .count = c->selection.count};
    psplat_result result = psplat_shrunk_begin(c, &t->shrunk);
    t->shrunk.give_back = restore;
    t->shrunk.user = t;
    t->splats = calloc(t->count + 1, sizeof *t->splats);
    if (!result) result = psplat_selection_copy(&c->selection, &t->met);
    return t->splats ? result : PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_trim_splats(psplat_conversion *c, psplat_error *error) {
    trimmer t;
    int any = 0;
    const psplat_fit_context context = psplat_conversion_context(c);
    if (!c->limits.distance) return PSPLAT_OK;
    if (psplat_conversion_interrupted(c->desc, "trimming", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    psplat_result result = begin(&t, c);
    if (!result) result = psplat_fit_each(&context, t.count, measure, &t);
    if (!result) result = psplat_fit_each(&context, t.count, find_covered, &t);
    if (!result && !choose_scales(&t)) result = PSPLAT_ERROR_MEMORY;
    if (!result) result = psplat_fit_each(&context, t.count, trim, &t);
    if (!result) any = psplat_shrunk_is_any(&t.shrunk);
    if (any) result = psplat_shrunk_close(&t.shrunk);
    if (result) psplat_fail(error, result, 0, "out of memory while trimming splats");
    trimmer_free(&t);
    if (!result && any) result = psplat_fill_last_holes(c, error);
    psplat_selection_drop_untaken(&c->selection);
    return result;
}
