/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cut_rims.c - clip lines that cut off where rims of splats show beside outlines.
 *
 * What is left of rims that stand off once splats are trimmed (trim_splats.c) mostly does so at one
 * side, and where the surface bends away beneath it shows as a spike of the outline: on horns, ears
 * and beaks. A clip line cuts that off where other splats cover it. Those lines come first that cut
 * off most of what shows. Where one lets a ray through, it moves out to there, and where it opens a
 * hole, it goes.
 */
#include "finish/cut_rims.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "finish/openings.h"
#include "finish/stand_off.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "measure/measured_splats.h"
#include "measure/ray_meeting.h"
#include "select/selection.h"
#include "splats/quantize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* What a line has to cut off, in squared tolerances: how far the rim shows, along it. */
static const double least_gain = 0.7;
/* The share of splats that get a line, since each takes two or three bytes of a file. */
static const double most_share = 0.25;
/* How far a rim stands off that need not be cut off, in tolerances. */
static const double kept_stand_off = 0.2;
/* The nearest and the farthest that a line is from the centre, in units of u and v, and how far
 * outside of it points of the rim lie that count as a whole. Nearer ones show as edges: half way
 * out a splat still weighs a third of what it does in the middle, at 0.8 a thirteenth. */
static const double nearest_line = 0.8, farthest_line = 0.9, whole_beyond = 0.1;
/* How far beyond the samples that it is needed for a splat reaches, in their spacings, and beyond
 * rays that it stops, in tolerances. */
static const double margin_spacings = 0.5, spare_tolerances = 0.15;
/* The points of a rim at which it is measured how far it shows, and the directions of lines. */
enum { SIDES = 48 };

typedef struct rim {
    double shown[SIDES]; /* how far it shows, times the length along the rim that a point stands
                            for: areas in squared tolerances */
    double uv[SIDES][2];
} rim;

/* A line that a splat may get, on the grid: the samples that it alone covers are on its side. */
typedef struct cut {
    double line[3];
    double gain; /* 0: there is none */
} cut;

/* What a splat that is cut was recorded to cover. */
typedef struct record {
    uint32_t *covered; /* NULL: it is not cut */
    size_t count;
} record;

typedef struct cutter {
    psplat_conversion *c;
    psplat_shrunk shrunk; /* a splat's worth is what its line gains */
    rim *rims;            /* count */
    record *records;      /* count */
    size_t count;
    uint32_t *covers; /* of each sample: how many candidates are recorded to cover it */
} cutter;

/* ---- what shows ------------------------------------------------------------------------------ */

/* The search for how far a point of a rim is above the highest of the other splats there. */
typedef struct stepper {
    const psplat_measured_splats *splats;
    uint32_t self;
    const double *point, *normal;
    double step; /* a length */
} stepper;

static int visit_other(void *user, uint32_t splat) {
    stepper *s = user;
    const psplat_region *region = &s->splats->regions[splat];
    double uvh[3];
    psplat_region_local(region, s->point, uvh);
    if (splat != s->self && fabs(uvh[2]) <= PSPLAT_SAME_SURFACE_TOLERANCES * s->splats->tolerance &&
        psplat_region_contains(region, uvh, 1, 0) && dot3(region->n, s->normal) > 0)
        s->step = min2(s->step, uvh[2]);
    return 0;
}

/* Returns the sine of the angle by which a surface bends away from a rim there, or 0 where it
 * bends towards it. normal is the surface's. */
static double bend_away(const psplat_region *region, const double uv[2], const double normal[3]) {
    double along[3] = {0, 0, 0}, slope[2], s = uv[0] * region->radius[0];
    double t = uv[1] * region->radius[1];
    psplat_region_slope(region, uv, slope);
    mad3(along, s, region->u);
    mad3(along, t, region->v);
    mad3(along, slope[0] * s + slope[1] * t, region->n);
    normalize3(along);
    return max2(dot3(along, normal), 0);
}

/* Stores how far a point of a rim shows beside outlines, in tolerances: how far it stands off from
 * the surface and from the other splats there. The more the surface bends away, the more views show
 * that. */
static psplat_result find_shown(const psplat_fit_context *context, const cutter *t, uint32_t index,
                                const double uv[2], uint32_t *guess, double *shown) {
    const psplat_measured_splats *splats = &t->shrunk.before;
    const psplat_region *region = &splats->regions[index];
    psplat_stand_off at;
    psplat_result result = psplat_stand_off_find(context, region, uv, guess, &at);
    *shown = 0;
    if (result || at.length == 0) return result;
    const double *normal = context->surface->face_normals + 3 * (size_t)at.triangle;
    stepper s = {splats, index, at.point, region->n, at.length};
    psplat_region_tree_visit_box(splats->region_tree, at.point, at.point, visit_other, &s);
    *shown = max2(s.step / splats->tolerance - kept_stand_off, 0) * bend_away(region, uv, normal);
    return PSPLAT_OK;
}

static psplat_result measure(const psplat_fit_context *context, size_t index, void *user) {
    cutter *t = user;
    rim *rim = &t->rims[index];
    const double *radius = t->shrunk.before.regions[index].radius;
    uint32_t guess = PSPLAT_NONE;
    psplat_result result = PSPLAT_OK;
    for (int i = 0; i < SIDES && !result; ++i) {
        double angle = 2 * PSPLAT_PI * i / SIDES, *uv = rim->uv[i];
        uv[0] = cos(angle), uv[1] = sin(angle);
        result = find_shown(context, t, (uint32_t)index, uv, &guess, &rim->shown[i]);
        rim->shown[i] *= 2 * PSPLAT_PI / SIDES * norm2(uv[1] * radius[0], uv[0] * radius[1]) /
                         context->limits->tolerance;
    }
    return result;
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* Returns how far from the centre a line across a direction has to be. */
static double least_distance(const cutter *t, size_t index, const double direction[2]) {
    const psplat_samples *samples = &t->c->samples;
    const psplat_candidate *candidate = &t->c->selection.candidates[index];
    const double *radius = candidate->region.radius;
    double margin = margin_spacings * samples->spacing / min2(radius[0], radius[1]);
    double distance = nearest_line;
    for (size_t i = 0; i < candidate->covered_count && distance <= farthest_line; ++i) {
        size_t sample = candidate->covered[i];
        double uvh[3];
        if (t->covers[sample] != 1) continue;
        psplat_region_local(&candidate->region, samples->positions + 3 * sample, uvh);
        distance = max2(distance, direction[0] * uvh[0] + direction[1] * uvh[1] + margin);
    }
    return distance;
}

/* Returns what a line across a direction gains. */
static double gain_of(const rim *rim, const double direction[2], double distance) {
    double gain = 0;
    for (int i = 0; i < SIDES; ++i) {
        double beyond = direction[0] * rim->uv[i][0] + direction[1] * rim->uv[i][1] - distance;
        if (beyond > 0) gain += rim->shown[i] * min2(beyond / whole_beyond, 1);
    }
    return gain;
}

static void round_line(const psplat_conversion *c, const psplat_region *region, double line[3]) {
    double bend = 0;
    if (!c->limits.precision) return;
    const psplat_precision at = psplat_precision_at(c->limits.precision, region->radius);
    psplat_quantize_line(&at, line, &bend);
}

static int is_far(const double line[3]) {
    return line[2] > farthest_line * norm2(line[0], line[1]);
}

/* Stores what a splat is recorded to cover that its last line keeps, of some samples, in the order
 * of these. covered may be what it has. Returns how many they are. */
static size_t keep(const cutter *t, const psplat_region *region, const uint32_t *some, size_t count,
                   uint32_t *covered) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        double uvh[3];
        psplat_region_local(region, t->c->samples.positions + 3 * (size_t)some[i], uvh);
        if (psplat_region_line_value(region, region->line_count - 1, uvh) >= 0)
            covered[kept++] = some[i];
    }
    return kept;
}

/* Returns the line of a splat that gains most. */
static cut find_cut(const cutter *t, size_t index) {
    const psplat_region *region = &t->shrunk.before.regions[index];
    const rim *rim = &t->rims[index];
    cut best = {.gain = 0};
    if (region->line_count + region->seam_count == PSPLAT_MAX_CLIP_LINES) return best;
    for (int i = 0; i < SIDES; ++i) {
        /* Most directions gain nothing, wherever the line is. */
        if (gain_of(rim, rim->uv[i], nearest_line) < max2(best.gain, least_gain)) continue;
        double line[3] = {-rim->uv[i][0], -rim->uv[i][1], least_distance(t, index, rim->uv[i])};
        if (is_far(line)) continue;
        round_line(t->c, region, line);
        const double direction[2] = {-line[0], -line[1]};
        double gain = is_far(line) ? 0 : gain_of(rim, direction, line[2]);
        if (gain <= best.gain || gain < least_gain) continue;
        memcpy(best.line, line, sizeof line);
        best.gain = gain;
    }
    return best;
}

/* Gives a splat its line, and takes what that cuts off from what it is recorded to cover; but not
 * where that is all. Returns 0 when out of memory. */
static int apply(cutter *t, size_t index, const cut *cut) {
    psplat_candidate *candidate = &t->c->selection.candidates[index];
    size_t count = candidate->covered_count;
    uint32_t *covered = malloc((count + 1) * sizeof *covered);
    if (!covered) return 0;
    if (count) memcpy(covered, candidate->covered, count * sizeof *covered);
    psplat_region_add_line(&candidate->region, cut->line, 0);
    size_t kept = keep(t, &candidate->region, covered, count, candidate->covered);
    if (!kept) {
        psplat_region_remove_line(&candidate->region);
        free(covered);
        return 1;
    }
    for (size_t i = 0; i < count; ++i) --t->covers[covered[i]];
    for (size_t i = 0; i < kept; ++i) ++t->covers[candidate->covered[i]];
    candidate->covered_count = kept;
    t->records[index] = (record){covered, count};
    t->shrunk.splats[index] = (psplat_smaller){.worth = cut->gain, .is_smaller = 1};
    return 1;
}

/* Gives splats their lines, those first that gain most. Returns 0 when out of memory. */
static int cut_all(cutter *t) {
    psplat_smaller *splats = t->shrunk.splats;
    size_t most = (size_t)(most_share * (double)t->count);
    t->covers = psplat_selection_count_covers(&t->c->selection, t->c->samples.count);
    if (!t->covers) return 0;
    for (size_t i = 0; i < t->count; ++i) splats[i].worth = find_cut(t, i).gain;
    uint32_t *order = psplat_shrunk_order(&t->shrunk);
    int ok = order != NULL;
    for (size_t i = 0; ok && i < t->count && most && splats[order[i]].worth > 0; ++i) {
        const cut best = find_cut(t, order[i]); /* Others have left samples to it since. */
        if (best.gain == 0) continue;
        ok = apply(t, order[i], &best);
        most -= (size_t)splats[order[i]].is_smaller;
    }
    free(order);
    return ok;
}

/* ---- all ------------------------------------------------------------------------------------- */

/* Takes the line of a splat away, and gives it back what it was recorded to cover. */
static void take_line(cutter *t, uint32_t index) {
    psplat_candidate *candidate = &t->c->selection.candidates[index];
    const record *record = &t->records[index];
    psplat_region_remove_line(&candidate->region);
    memcpy(candidate->covered, record->covered, record->count * sizeof *record->covered);
    candidate->covered_count = record->count;
    t->shrunk.splats[index].is_smaller = 0;
}

/* Moves the line of a splat out to a ray, or takes it away where that is too far or where it has
 * opened a hole. */
static int move_out(void *user, uint32_t index, const psplat_opening *opening) {
    cutter *t = user;
    const psplat_measured_splats *before = &t->shrunk.before;
    psplat_candidate *candidate = &t->c->selection.candidates[index];
    psplat_region *region = &candidate->region;
    double *line = region->lines[region->line_count - 1], height, uv[2];
    if (!opening->ray) {
        take_line(t, index);
        return 1;
    }
    if (!psplat_sight_meets(&opening->ray->sight, &before->regions[index], before->wall, 0, &height,
                            uv))
        return 0;
    double value = psplat_region_line_value(region, region->line_count - 1, uv);
    if (value >= 0) return 0; /* It has moved already. */
    line[2] -= value;
    line[2] += spare_tolerances * before->tolerance *
               norm2(line[0] / region->radius[0], line[1] / region->radius[1]);
    round_line(t->c, region, line);
    if (is_far(line))
        take_line(t, index);
    else
        candidate->covered_count =
            keep(t, region, t->records[index].covered, t->records[index].count, candidate->covered);
    return 1;
}

static psplat_result begin(cutter *t, psplat_conversion *c) {
    *t = (cutter){.c = c, .count = c->selection.count};
    psplat_result result = psplat_shrunk_begin(c, &t->shrunk);
    t->shrunk.before.wall = PSPLAT_WALL_TOLERANCES * c->limits.tolerance; /* Lines have none. */
    t->shrunk.give_back = move_out;
    t->shrunk.user = t;
    t->rims = calloc(t->count + 1, sizeof *t->rims);
    t->records = calloc(t->count + 1, sizeof *t->records);
    return t->rims && t->records ? result : PSPLAT_ERROR_MEMORY;
}

static void cutter_free(cutter *t) {
    for (size_t i = 0; t->records && i < t->count; ++i) free(t->records[i].covered);
    psplat_shrunk_free(&t->shrunk);
    free(t->records);
    free(t->rims);
    free(t->covers);
}

psplat_result psplat_cut_rims(psplat_conversion *c) {
    cutter t;
    const psplat_fit_context context = psplat_conversion_context(c);
    if (!c->limits.distance) return PSPLAT_OK;
    psplat_result result = begin(&t, c);
    if (!result) result = psplat_fit_each(&context, t.count, measure, &t);
    if (!result && !cut_all(&t)) result = PSPLAT_ERROR_MEMORY;
    if (!result && psplat_shrunk_is_any(&t.shrunk)) result = psplat_shrunk_close(&t.shrunk);
    cutter_free(&t);
    return result;
}
