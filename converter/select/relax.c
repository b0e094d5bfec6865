/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * relax.c - Lloyd-like relaxation: candidates around the samples for which taken ones are needed.
 *
 * The cell of a splat is the set of samples that it alone covers. A splat around its cell, made as
 * large as it can be, is centred on what it is needed for, as in Lloyd's relaxation. A splat around
 * the cells of two neighbours, and around the samples that only these two cover, may replace both.
 * For most pairs the covariance of the union shows in constant time (Pajarola, Sainz, Guidotti
 * 2003) that no plane is near enough to all of it.
 */
#include "select/relax.h"

#include "base/covariance.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/enclose.h"
#include "fit/fit_context.h"
#include "mesh/mesh.h"
#include "select/conversion.h"
#include "select/selection.h"

#include <stdlib.h>
#include <string.h>

/* A sample that only one taken candidate (first == second) or only two cover. */
typedef struct owned_sample {
    uint32_t first, second, sample;
} owned_sample;

/* The samples that the same candidates cover, and their sums relative to the centre of the
 * first. */
typedef struct cell {
    uint32_t first, second;
    const owned_sample *begin, *end;
    psplat_covariance sums;
} cell;

/* The state of one relaxation. */
typedef struct relaxer {
    psplat_conversion *c;
    owned_sample *owned;        /* owned_count, sorted by their candidates */
    cell *cells;                /* cell_count: of candidates and of pairs */
    uint32_t *cell_indices;     /* per candidate: the index of its own cell, or PSPLAT_NONE */
    psplat_candidate *proposed; /* per cell */
    size_t owned_count, cell_count;
} relaxer;

static int compare_owned_samples(const void *left, const void *right) {
    const owned_sample *a = left, *b = right;
    if (a->first != b->first) return a->first < b->first ? -1 : 1;
    if (a->second != b->second) return a->second < b->second ? -1 : 1;
    return a->sample < b->sample ? -1 : a->sample > b->sample;
}

/* ---- cells of candidates and of pairs -------------------------------------------------------- */

/* Lists the samples that one or two taken candidates cover, but for those of an apron. Returns 0
 * when out of memory. */
static int list_owned_samples(relaxer *r) {
    const psplat_selection *selection = &r->c->selection;
    size_t count = r->c->samples.count;
    uint8_t *covers = calloc(count + 1, 1);
    r->owned = malloc((count + 1) * sizeof *r->owned);
    owned_sample *of = r->owned;
    for (size_t i = 0; covers && r->c->surface.owned && i < count; ++i)
        if (!psplat_surface_owns(&r->c->surface, r->c->samples.positions + 3 * i)) covers[i] = 3;
    for (uint32_t c = 0; covers && of && c < selection->count; ++c) {
        const psplat_candidate *candidate = &selection->candidates[c];
        for (size_t i = 0; candidate->taken && i < candidate->covered_count; ++i) {
            uint32_t sample = candidate->covered[i];
            if (covers[sample] == 0) of[sample] = (owned_sample){c, c, sample};
            if (covers[sample] == 1) of[sample].second = c;
            if (covers[sample] < 3) ++covers[sample];
        }
    }
    for (size_t i = 0; covers && of && i < count; ++i)
        if (covers[i] == 1 || covers[i] == 2) of[r->owned_count++] = of[i];
    if (covers && of) qsort(of, r->owned_count, sizeof *of, compare_owned_samples);
    free(covers);
    return covers && of;
}

static void sum_up(const relaxer *r, cell *group) {
    const psplat_samples *samples = &r->c->samples;
    const double *origin = r->c->selection.candidates[group->first].region.center;
    for (const owned_sample *at = group->begin; at < group->end; ++at) {
        double p[3], n[3];
        sub3(p, samples->positions + 3 * (size_t)at->sample, origin);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)samples->normals[3 * (size_t)at->sample + k];
        psplat_covariance_add(&group->sums, p, n);
    }
}

/* Groups the listed samples into cells. Returns 0 when out of memory. */
static int group_cells(relaxer *r) {
    size_t candidates = r->c->selection.count + 1;
    r->cells = malloc((r->owned_count + 1) * sizeof *r->cells);
    r->cell_indices = malloc(candidates * sizeof *r->cell_indices);
    if (!r->cells || !r->cell_indices) return 0;
    memset(r->cell_indices, 0xff, candidates * sizeof *r->cell_indices);
    const owned_sample *at = r->owned, *end = at + r->owned_count;
    while (at < end) {
        cell *group = &r->cells[r->cell_count];
        *group = (cell){.first = at->first, .second = at->second, .begin = at};
        while (at < end && at->first == group->first && at->second == group->second) ++at;
        group->end = at;
        sum_up(r, group);
        if (group->first == group->second) r->cell_indices[group->first] = (uint32_t)r->cell_count;
        ++r->cell_count;
    }
    return 1;
}

/* ---- candidates ------------------------------------------------------------------------------ */

/* Returns the cell of one candidate; NULL where it has none. */
static const cell *own_cell(const relaxer *r, uint32_t candidate) {
    return r->cell_indices[candidate] == PSPLAT_NONE ? NULL : &r->cells[r->cell_indices[candidate]];
}

/* Returns the sums over the cell of a pair and the cells of both, relative to the centre of
 * the first. */
static psplat_covariance union_sums(const relaxer *r, const cell *group) {
    const psplat_candidate *candidates = r->c->selection.candidates;
    const cell *first = own_cell(r, group->first), *second = own_cell(r, group->second);
    psplat_covariance sums = group->sums;
    if (first) psplat_covariance_unite(&sums, &first->sums);
    if (second) {
        psplat_covariance moved = second->sums;
        double d[3];
        sub3(d, candidates[group->first].region.center, candidates[group->second].region.center);
        psplat_covariance_move(&moved, d);
        psplat_covariance_unite(&sums, &moved);
    }
    return sums;
}

static size_t append(uint32_t *set, size_t count, const cell *group) {
    for (const owned_sample *at = group ? group->begin : NULL; group && at < group->end; ++at)
        set[count++] = at->sample;
    return count;
}

static size_t size_of(const cell *group) {
    return group ? (size_t)(group->end - group->begin) : 0;
}

/* Makes a candidate around the cell of one candidate, or around all cells of a pair, where the
 * plane fitted to them is near enough. */
static psplat_result propose(const psplat_fit_context *context, size_t index, void *user) {
    relaxer *r = user;
    const psplat_conversion *c = r->c;
    const cell *group = &r->cells[index], *first = NULL, *second = NULL;
    if (group->first != group->second)
        first = own_cell(r, group->first), second = own_cell(r, group->second);
    psplat_covariance sums = group->first == group->second ? group->sums : union_sums(r, group);
    psplat_plane plane;
    psplat_covariance_fit(&sums, &plane);
    if (c->limits.planar && plane.variance[2] > c->limits.tolerance * c->limits.tolerance)
        return PSPLAT_OK;
    size_t count = size_of(group) + size_of(first) + size_of(second);
    uint32_t *set = malloc((count + 1) * sizeof *set);
    if (!set) return PSPLAT_ERROR_MEMORY;
    append(set, append(set, append(set, 0, group), first), second);
    const double *origin = c->selection.candidates[group->first].region.center;
    psplat_result result =
        psplat_candidate_enclose(context, set, count, origin, &plane, &r->proposed[index]);
    free(set);
    return result;
}

psplat_result psplat_relax(psplat_conversion *c) {
    relaxer r = {.c = c};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (list_owned_samples(&r) && group_cells(&r))
        r.proposed = calloc(r.cell_count + 1, sizeof *r.proposed);
    const psplat_fit_context context = psplat_conversion_context(c);
    if (r.proposed) result = psplat_fit_each(&context, r.cell_count, propose, &r);
    for (size_t i = 0; r.proposed && i < r.cell_count; ++i) {
        if (!result && r.proposed[i].covered_count &&
            !psplat_selection_push(&c->selection, &r.proposed[i]))
            result = PSPLAT_ERROR_MEMORY;
        psplat_candidate_free(&r.proposed[i]);
    }
    free(r.proposed);
    free(r.owned);
    free(r.cells);
    free(r.cell_indices);
    return result;
}
