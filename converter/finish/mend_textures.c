/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_textures.c - splats over which textures slide too far give way to smaller ones.
 *
 * Coordinates are fitted to samples whose spacing follows the shape. Where charts are strips that
 * are narrower than that, or coordinates have kinks between samples, as along the edges of long
 * thin triangles, no sample tells of it, and a splat shows one line of the image all over the
 * strip. Points as dense as those of the check find such places. They become samples, under which
 * new splats end where the texture slides. Where lines that were moved out later do it, they are
 * taken back.
 */
#include "finish/mend_textures.h"

#include "base/region_tree.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/texture_candidates.h"
#include "measure/hidden_samples.h"
#include "measure/measured_splats.h"
#include "measure/texture_slides.h"
#include "select/fill_holes.h"
#include "select/selection.h"
#include "finish/thin_points.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
enum { ROUNDS = 6, LEAST_POINTS = 32768, MOST_POINTS = 262144 };
/* The share of points at which a texture may slide too far, and that to which a round tries to
 * bring it, before splats are extended to close gaps and after that. The check spares 0.005. */
static const struct shares {
    double spared, wanted;
} shares[2] = {{0.0035, 0.0015}, {0.0036, 0.001}};
/* The points of a first glance, and the part of the spared share up to which it ends the search. */
static const size_t glance_points = 16384;
static const double glance_part = 0.5;
/* The side of the cubes in each of which one point becomes a sample, in tolerances. */
static const double cube_side_tolerances = 0.5;
/* An offset of the seed: the letters of "slide". */
static const uint64_t mend_seed = 0x736c696465000000u;

/* The state of a round. */
typedef struct mender {
    psplat_conversion *c;
    psplat_measured_splats measured; /* of the candidates, by their indices */
    psplat_splats splats;            /* the same, with their texture coordinates */
    psplat_samples points;
    psplat_texture_slides slides;
    uint32_t *wrong; /* wrong_count indices of points */
    size_t wrong_count, covered_count;
    uint32_t *blames; /* by candidate: over how many wrong points it slides */
    uint8_t *blamed;  /* by candidate: 1 where it is to be replaced */
    int last;         /* of psplat_mend_textures */
} mender;

static void free_round(mender *m) {
    psplat_measured_splats_free(&m->measured);
    free(m->splats.texcoords);
    free(m->splats.runs);
    psplat_samples_free(&m->points);
    psplat_texture_slides_free(&m->slides);
    free(m->wrong);
    free(m->blames);
    free(m->blamed);
}

/* ---- where textures slide -------------------------------------------------------------------- */

/* Prepares the candidates, each with its coordinates, for measurements. */
static psplat_result measure_candidates(mender *m) {
    const psplat_selection *selection = &m->c->selection;
    size_t count = selection->count;
    m->measured = (psplat_measured_splats){.count = count, .tolerance = m->c->tolerance};
    m->measured.regions = malloc((count + 1) * sizeof *m->measured.regions);
    m->splats = (psplat_splats){.count = count, .run_count = count, .kernel = m->c->kernel};
    m->splats.texcoords = malloc((count + 1) * sizeof *m->splats.texcoords);
    m->splats.runs = calloc(count + 1, sizeof *m->splats.runs);
    if (!m->measured.regions || !m->splats.texcoords || !m->splats.runs) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        const psplat_candidate *candidate = &selection->candidates[i];
        m->measured.regions[i] = candidate->region;
        m->splats.texcoords[i] = candidate->texcoord;
        m->splats.runs[i].count = 1;
        m->splats.runs[i].has_texcoord =
            psplat_surface_keeps_textures(&m->c->surface, candidate->triangle);
    }
    m->measured.region_tree = psplat_region_tree_create(
        m->measured.regions, count, PSPLAT_STEEPEST_REACH * m->measured.tolerance);
    return m->measured.region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Stores whether a texture slides too far at a point, and one sees it. */
static psplat_result find_whether_wrong(const mender *m, size_t point, int *wrong) {
    const psplat_conversion *c = m->c;
    double texels = c->desc->texture_tolerance_texels;
    int hidden;
    *wrong = m->slides.seen[point] &&
             (texels > 0 ? m->slides.texels[point] > texels
                         : fmin(m->slides.lengths[point], m->slides.ways[point]) > c->tolerance);
    if (!*wrong) return PSPLAT_OK;
    psplat_result result =
        psplat_sample_is_hidden(&c->surface, &m->points, c->distance, c->tolerance, point, &hidden);
    *wrong = !result && !hidden;
    return result;
}

/* Finds at which of at most so many points textures slide too far. */
static psplat_result find_wrong(mender *m, size_t most, uint64_t seed, psplat_error *error) {
    const psplat_conversion *c = m->c;
    const psplat_fit_context context = psplat_conversion_context(c);
    double dense = c->surface.area / (c->tolerance * c->tolerance);
    size_t wanted = (size_t)fmin(fmax(dense, LEAST_POINTS), (double)most);
    psplat_result result =
        psplat_fit_texcoords(&context, c->selection.candidates, c->selection.count);
    if (!result) result = measure_candidates(m);
    if (!result) result = psplat_samples_draw_uniform(&c->surface, wanted, seed, &m->points, error);
    if (result) return result;
    psplat_samples_drop_apron(&m->points, &c->surface);
    m->wrong = malloc((m->points.count + 1) * sizeof *m->wrong);
    m->blames = calloc(c->selection.count + 1, sizeof *m->blames);
    m->blamed = calloc(c->selection.count + 1, 1);
    if (!m->wrong || !m->blames || !m->blamed) return PSPLAT_ERROR_MEMORY;
    result =
        psplat_texture_slides_find(&c->surface, &m->points, &m->splats, &m->measured, &m->slides);
    for (size_t i = 0; i < m->points.count && !result; ++i) {
        int wrong;
        m->covered_count += m->slides.lengths[i] >= 0;
        result = find_whether_wrong(m, i, &wrong);
        if (wrong) m->wrong[m->wrong_count++] = (uint32_t)i;
    }
    return result;
}

/* ---- mending --------------------------------------------------------------------------------- */

/* Chooses the candidates to replace: those that slide over most wrong points, until so few are left
 * as are wanted, but for those that are as they were before, unless that is NULL. Keeps only the
 * wrong points under these. */
static void choose_blamed(mender *m, const psplat_region *before) {
    size_t left = m->wrong_count, kept = 0;
    size_t wanted = (size_t)(shares[m->last].wanted * (double)m->covered_count);
    for (size_t i = 0; i < m->wrong_count; ++i) {
        uint32_t splat = m->slides.splats[m->wrong[i]];
        const psplat_region *region = &m->c->selection.candidates[splat].region;
        if (!before || memcmp(region, &before[splat], sizeof *region) != 0) ++m->blames[splat];
    }
    while (left > wanted) {
        size_t worst = 0;
        for (size_t i = 1; i < m->c->selection.count; ++i)
            if (m->blames[i] > m->blames[worst]) worst = i;
        if (!m->blames[worst]) break;
        left -= m->blames[worst];
        m->blames[worst] = 0;
        m->blamed[worst] = 1;
    }
    for (size_t i = 0; i < m->wrong_count; ++i)
        if (m->blamed[m->slides.splats[m->wrong[i]]]) m->wrong[kept++] = m->wrong[i];
    m->wrong_count = kept;
}

/* Keeps one wrong point of each cube. Returns 0 when out of memory. */
static int thin_wrong_points(mender *m) {
    return psplat_thin_points(m->points.positions, cube_side_tolerances * m->c->tolerance, m->wrong,
                              &m->wrong_count);
}

/* Appends the wrong points to the samples. */
static psplat_result append_points(mender *m, psplat_error *error) {
    psplat_conversion *c = m->c;
    size_t count = m->wrong_count;
    double *points = malloc((count + 1) * 3 * sizeof *points);
    uint32_t *triangles = malloc((count + 1) * sizeof *triangles);
    psplat_result result = points && triangles ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; ++i) {
        size_t point = m->wrong[i];
        memcpy(points + 3 * i, m->points.positions + 3 * point, 3 * sizeof *points);
        triangles[i] = m->points.triangles[point];
    }
    if (!result)
        result = psplat_samples_append(&c->samples, &c->surface, points, triangles, count, error);
    free(points);
    free(triangles);
    return result;
}

/* Gives the candidates under which textures slide too far now the regions that they had before. */
static void take_back(mender *m, const psplat_region *before) {
    choose_blamed(m, before);
    for (size_t i = 0; i < m->c->selection.count; ++i)
        if (m->blamed[i]) m->c->selection.candidates[i].region = before[i];
}

/* Replaces the candidates under which textures slide too far. */
static psplat_result replace(mender *m, psplat_error *error) {
    psplat_conversion *c = m->c;
    size_t first = c->samples.count;
    choose_blamed(m, NULL);
    if (!thin_wrong_points(m)) return PSPLAT_ERROR_MEMORY;
    psplat_result result = append_points(m, error);
    for (size_t i = 0; i < c->selection.count; ++i)
        if (m->blamed[i]) c->selection.candidates[i].taken = 0;
    psplat_selection_drop_untaken(&c->selection);
    if (!result) result = psplat_cover_samples(c, first, m->last, error);
    psplat_selection_drop_untaken(&c->selection);
    return result;
}

static int is_wrong(const mender *m, double part) {
    return (double)m->wrong_count > part * shares[m->last].spared * (double)m->covered_count;
}

/* Stores whether a few points are wrong so often that more have to tell. */
static psplat_result glance(psplat_conversion *c, int last, int *mends, psplat_error *error) {
    mender m = {.c = c, .last = last};
    psplat_result result =
        find_wrong(&m, glance_points, c->desc->seed + mend_seed - 1 - (uint64_t)last, error);
    *mends = is_wrong(&m, glance_part);
    free_round(&m);
    return result;
}

psplat_result psplat_mend_textures(psplat_conversion *c, int last, psplat_error *error) {
    int mends;
    last = last != 0;
    if (!c->samples.texcoords) return PSPLAT_OK;
    psplat_result result = glance(c, last, &mends, error);
    for (int round = 0; round < ROUNDS && mends && !result; ++round) {
        mender m = {.c = c, .last = last};
        if (psplat_conversion_interrupted(c->desc, "mending textures", (double)round / ROUNDS))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result = find_wrong(&m, MOST_POINTS,
                            c->desc->seed + mend_seed + (uint64_t)(round + ROUNDS * last), error);
        mends = is_wrong(&m, 1);
        if (!result && mends) result = replace(&m, error);
        free_round(&m);
    }
    if (result && result != PSPLAT_ERROR_INTERRUPTED)
        psplat_fail(error, result, 0, "%s while mending textures", psplat_result_text(result));
    return result;
}

psplat_result psplat_take_back_slides(psplat_conversion *c, const psplat_region *before) {
    mender m = {.c = c, .last = 1};
    int slides;
    if (!c->samples.texcoords) return PSPLAT_OK;
    psplat_result result = glance(c, 1, &slides, NULL);
    if (result || !slides) return result;
    result = find_wrong(&m, MOST_POINTS, c->desc->seed + mend_seed + 2 * ROUNDS, NULL);
    if (!result && is_wrong(&m, 1)) take_back(&m, before);
    free_round(&m);
    return result;
}
