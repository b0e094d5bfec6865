/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * repair.c - holes between samples.
 *
 * Splats that cover every sample may still leave points between samples uncovered. Fresh samples
 * find such points; they become samples themselves, candidates of the pool that cover them are
 * found, and the selection is completed and improved again.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>

/* Rounds, how many in a row must find nothing, and fresh samples in each, as a multiple of those
 * fitted and at least. Exchanges close holes with few splats but may open others: later rounds only
 * add. */
enum { ROUNDS = 24, EXCHANGING_ROUNDS = 6, CLEAN_ROUNDS = 2, FRESH = 4, LEAST_FRESH = 100000 };

/* Part of the margin that must remain: slits too thin to be met by chance do not stay open. */
static const double looked_at = 0.25;

/* Moves of improvement for each splat in a round. */
enum { MOVES = 8 };

static const uint64_t repair_seed = 0x7265706169720000u;

/* Appends the fresh samples that lie in holes, and stores how many. */
static psplat_result find_holes(psplat_conversion *c, int round, size_t *holes,
                                psplat_error *error) {
    psplat_samples fresh;
    size_t triangles = c->surface.mesh->triangle_count, count = FRESH * c->samples.count;
    if (count < LEAST_FRESH) count = LEAST_FRESH;
    uint64_t seed = c->desc->seed + repair_seed + (uint64_t)round;
    psplat_result result = psplat_samples_draw_uniform(&c->surface, count, seed, &fresh, error);
    if (result) return result;
    uint8_t *open = malloc(fresh.count + 1);
    uint32_t *chosen = malloc((fresh.count + 1) * sizeof *chosen);
    result = PSPLAT_ERROR_MEMORY;
    if (open && chosen)
        result = psplat_verify_coverage(&fresh, c->splats, c->limits.tolerance,
                                        looked_at * c->limits.margin, open, holes);
    if (result) psplat_fail(error, result, 0, "out of memory while looking for holes");
    if (!result && *holes) {
        size_t found = 0;
        for (uint32_t i = 0; i < fresh.count; ++i)
            if (open[i]) chosen[found++] = i;
        result = psplat_samples_append(&c->samples, &fresh, chosen, found, triangles, error);
    }
    free(open);
    free(chosen);
    psplat_samples_free(&fresh);
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

/* Finds again what marked candidates cover. */
static psplat_result cover_marked(psplat_conversion *c, const uint8_t *marks) {
    long count = (long)c->selection.count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        psplat_growth growth = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 4)
#endif
        for (long i = 0; i < count; ++i)
            if (marks[i])
                failed |= psplat_candidate_cover(&c->surface, &c->samples, &c->limits, &growth,
                                                 &c->selection.candidates[i]) != PSPLAT_OK;
        psplat_growth_free(&growth);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* ---- repair -------------------------------------------------------------------------------- */

/* Finds what the pool covers of the samples from index first on. */
static psplat_result cover_holes(psplat_conversion *c, size_t first) {
    uint8_t *marks = calloc(c->selection.count + 1, 1);
    psplat_result result = marks ? mark_candidates(c, first, marks) : PSPLAT_ERROR_MEMORY;
    if (!result) result = cover_marked(c, marks);
    free(marks);
    return result;
}

/* Covers the samples from index first on, and stores the splats again. */
static psplat_result complete(psplat_conversion *c, size_t first, int round, psplat_error *error) {
    psplat_result result = cover_holes(c, first);
    const psplat_improvement what = {.samples = &c->samples,
                                     .moves = MOVES * psplat_selection_taken(&c->selection),
                                     .focus = c->samples.count,
                                     .axis = round % 3,
                                     .seed = c->desc->seed + (uint64_t)round};
    if (!result)
        result =
            psplat_select_cover(&c->surface, &c->samples, &c->limits, c->desc, &c->selection, NULL);
    if (!result && round < EXCHANGING_ROUNDS) result = psplat_improve(&c->selection, &what);
    if (!result) result = psplat_store_splats(&c->selection, c->samples.colors != NULL, c->splats);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "%s while closing holes", psplat_result_text(result));
}

psplat_result psplat_repair_holes(psplat_conversion *c, psplat_error *error) {
    const psplat_convert_desc *desc = c->desc;
    psplat_result result = PSPLAT_OK;
    for (int round = 0, clean = 0; !result && round < ROUNDS && clean < CLEAN_ROUNDS; ++round) {
        size_t holes, first = c->samples.count;
        if (desc->progress && desc->progress(desc->user, "closing holes", (double)round / ROUNDS))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result = find_holes(c, round, &holes, error);
        clean = holes ? 0 : clean + 1;
        if (!result && holes) result = complete(c, first, round, error);
    }
    return result;
}
