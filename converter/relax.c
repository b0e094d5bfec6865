/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * relax.c - candidates for what the taken ones are needed for.
 *
 * What a splat alone covers is its cell: a splat around the cell, made as large as it can be, sits
 * in the middle of what it is needed for, as in Lloyd's relaxation. A splat around the cells of two
 * neighbours, and what only these two cover, replaces both. Of most pairs the covariance of the
 * union tells in constant time (Pauly, Spernat, Gross 2003) that no plane will do.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* A sample that one candidate (first == second) or just two cover. */
typedef struct relation {
    uint32_t first, second, sample;
} relation;

/* Samples with the same relation, and their sums relative to the centre of the first. */
typedef struct bond {
    uint32_t first, second;
    const relation *begin, *end;
    psplat_covariance sums;
} bond;

typedef struct relaxer {
    psplat_conversion *c;
    relation *relations;
    bond *bonds;
    uint32_t *cells;            /* per candidate: bond of its cell, or PSPLAT_NONE */
    psplat_candidate *proposed; /* for each bond */
    size_t relation_count, bond_count;
} relaxer;

static int compare_relations(const void *left, const void *right) {
    const relation *a = left, *b = right;
    if (a->first != b->first) return a->first < b->first ? -1 : 1;
    if (a->second != b->second) return a->second < b->second ? -1 : 1;
    return a->sample < b->sample ? -1 : a->sample > b->sample;
}

/* ---- cells and bonds ------------------------------------------------------------------------- */

/* Lists the samples covered once or twice. */
static int relate(relaxer *r) {
    const psplat_selection *selection = &r->c->selection;
    size_t count = r->c->samples.count;
    uint8_t *covers = calloc(count + 1, 1);
    r->relations = malloc((count + 1) * sizeof *r->relations);
    relation *of = r->relations;
    for (uint32_t c = 0; covers && of && c < selection->count; ++c) {
        const psplat_candidate *candidate = &selection->candidates[c];
        for (size_t i = 0; candidate->taken && i < candidate->covered_count; ++i) {
            uint32_t sample = candidate->covered[i];
            if (covers[sample] == 0) of[sample] = (relation){c, c, sample};
            if (covers[sample] == 1) of[sample].second = c;
            if (covers[sample] < 3) ++covers[sample];
        }
    }
    for (size_t i = 0; covers && of && i < count; ++i)
        if (covers[i] == 1 || covers[i] == 2) of[r->relation_count++] = of[i];
    if (covers && of) qsort(of, r->relation_count, sizeof *of, compare_relations);
    free(covers);
    return covers && of;
}

static void sum_up(const relaxer *r, bond *b) {
    const psplat_samples *samples = &r->c->samples;
    const double *origin = r->c->selection.candidates[b->first].region.center;
    for (const relation *at = b->begin; at < b->end; ++at) {
        double p[3], n[3];
        sub3(p, samples->positions + 3 * (size_t)at->sample, origin);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)samples->normals[3 * (size_t)at->sample + k];
        psplat_covariance_add(&b->sums, p, n);
    }
}

static int find_bonds(relaxer *r) {
    size_t candidates = r->c->selection.count + 1;
    r->bonds = malloc((r->relation_count + 1) * sizeof *r->bonds);
    r->cells = malloc(candidates * sizeof *r->cells);
    if (!r->bonds || !r->cells) return 0;
    memset(r->cells, 0xff, candidates * sizeof *r->cells);
    const relation *at = r->relations, *end = at + r->relation_count;
    while (at < end) {
        bond *b = &r->bonds[r->bond_count];
        *b = (bond){.first = at->first, .second = at->second, .begin = at};
        while (at < end && at->first == b->first && at->second == b->second) ++at;
        b->end = at;
        sum_up(r, b);
        if (b->first == b->second) r->cells[b->first] = (uint32_t)r->bond_count;
        ++r->bond_count;
    }
    return 1;
}

/* ---- candidates ------------------------------------------------------------------------------ */

/* The cell of a candidate; NULL where it has none. */
static const bond *cell_of(const relaxer *r, uint32_t candidate) {
    return r->cells[candidate] == PSPLAT_NONE ? NULL : &r->bonds[r->cells[candidate]];
}

/* Sums over a bond of two and the cells of both, relative to the centre of the first. */
static psplat_covariance united(const relaxer *r, const bond *b) {
    const psplat_candidate *candidates = r->c->selection.candidates;
    const bond *first = cell_of(r, b->first), *second = cell_of(r, b->second);
    psplat_covariance sums = b->sums;
    if (first) psplat_covariance_unite(&sums, &first->sums);
    if (second) {
        psplat_covariance moved = second->sums;
        double d[3];
        sub3(d, candidates[b->first].region.center, candidates[b->second].region.center);
        psplat_covariance_move(&moved, d);
        psplat_covariance_unite(&sums, &moved);
    }
    return sums;
}

static size_t append(uint32_t *set, size_t count, const bond *b) {
    for (const relation *at = b ? b->begin : NULL; b && at < b->end; ++at)
        set[count++] = at->sample;
    return count;
}

static size_t size_of(const bond *b) {
    return b ? (size_t)(b->end - b->begin) : 0;
}

/* A candidate for a cell, or for a pair that may become one. */
static psplat_result propose(void *user, size_t index, psplat_growth *growth) {
    relaxer *r = user;
    const psplat_conversion *c = r->c;
    const bond *b = &r->bonds[index], *first = NULL, *second = NULL;
    if (b->first != b->second) first = cell_of(r, b->first), second = cell_of(r, b->second);
    psplat_covariance sums = b->first == b->second ? b->sums : united(r, b);
    psplat_plane plane;
    psplat_covariance_fit(&sums, &plane);
    if (plane.variance[2] > c->limits.tolerance * c->limits.tolerance) return PSPLAT_OK;
    size_t count = size_of(b) + size_of(first) + size_of(second);
    uint32_t *set = malloc((count + 1) * sizeof *set);
    if (!set) return PSPLAT_ERROR_MEMORY;
    append(set, append(set, append(set, 0, b), first), second);
    psplat_result result = psplat_candidate_enclose(
        &c->surface, &c->samples, &c->limits, set, count,
        c->selection.candidates[b->first].region.center, &plane, growth, &r->proposed[index]);
    free(set);
    return result;
}

psplat_result psplat_relax(psplat_conversion *c) {
    relaxer r = {.c = c};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (relate(&r) && find_bonds(&r)) r.proposed = calloc(r.bond_count + 1, sizeof *r.proposed);
    if (r.proposed) result = psplat_growth_each(r.bond_count, propose, &r);
    for (size_t i = 0; r.proposed && i < r.bond_count; ++i) {
        if (!result && r.proposed[i].covered_count &&
            !psplat_selection_push(&c->selection, &r.proposed[i]))
            result = PSPLAT_ERROR_MEMORY;
        psplat_candidate_free(&r.proposed[i]);
    }
    free(r.proposed);
    free(r.relations);
    free(r.bonds);
    free(r.cells);
    return result;
}
