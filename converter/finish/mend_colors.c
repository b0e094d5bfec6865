/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_colors.c - splats that blend to other colours than the surface has give way to smaller ones.
 *
 * A splat is fitted to some sixty samples, and its error of colours is a mean over them. So a
 * painted line may lie between samples, and a corner of a splat may reach far over an edge. Points
 * as dense as the texels find such places. They become samples at each of which a splat has to have
 * the right colour, not only on average; the splats that are wrong there are taken back, and the
 * greedy cover closes what they leave open.
 */
#include "finish/mend_colors.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/color_fit.h"
#include "fit/fit_context.h"
#include "measure/color_errors.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "mesh/mesh.h"
#include "select/fill_holes.h"
#include "select/selection.h"
#include "finish/thin_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
enum { ROUNDS = 6 };
/* The share of points that may be wrong, and that to which a round tries to bring it, before splats
 * are extended to close gaps and after that. The check spares 0.05. */
static const struct shares { double spared, wanted; } shares[2] = {{0.045, 0.04}, {0.047, 0.045}};
/* The most points of a first glance, and the part of the spared share up to which it ends the
 * search: with so many points a share of 0.02 is known to a tenth of itself. Most conversions show
 * right colours, and a scene may have many small meshes. */
static const size_t glance_points = 4096;
static const double glance_part = 0.5;
/* The side of the cubes in each of which one wrong point becomes a sample, in tolerances. */
static const double cube_side_tolerances = 0.5;
/* An offset of the seed: the letters of "paint". */
static const uint64_t mend_seed = 0x7061696e74000000u;

/* The state of a round. */
typedef struct mender {
    psplat_conversion *c;
    psplat_measured_splats measured; /* of the candidates, by their indices */
    psplat_samples points;
    float *looks;    /* points.count x PSPLAT_LOOK_VALUES: what is shown */
    double *errors;  /* points.count */
    uint32_t *wrong; /* wrong_count indices of points */
    size_t wrong_count, seen_count;
    uint32_t *blamers; /* wrong_count: the candidate most to blame; PSPLAT_NONE: none is */
    uint32_t *blames;  /* by candidate: how many wrong points it is most to blame for */
    uint8_t *blamed;   /* by candidate: 1 where it is to be replaced */
    double limit;      /* of errors, in % */
    struct shares shares;
    int last; /* of psplat_mend_colors */
} mender;

static void free_round(mender *m) {
    psplat_measured_splats_free(&m->measured);
    psplat_samples_free(&m->points);
    free(m->looks);
    free(m->errors);
    free(m->wrong);
    free(m->blamers);
    free(m->blames);
    free(m->blamed);
}

/* ---- what is shown --------------------------------------------------------------------------- */

static const psplat_material *material_of(const psplat_mesh *mesh, uint32_t triangle) {
    uint32_t group = mesh->groups ? mesh->groups[triangle] : 0;
    return group < mesh->source_material_count ? &mesh->source_materials[group].material
                                               : &mesh->material;
}

/* Prepares the candidates for blends of colours; their normals do not matter. */
static psplat_result measure_candidates(mender *m) {
    const psplat_selection *selection = &m->c->selection;
    size_t count = selection->count;
    m->measured = (psplat_measured_splats){.count = count, .tolerance = m->c->tolerance};
    m->measured.regions = malloc((count + 1) * sizeof *m->measured.regions);
    m->measured.fields = calloc(count + 1, sizeof *m->measured.fields);
    if (!m->measured.regions || !m->measured.fields) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        const psplat_candidate *candidate = &selection->candidates[i];
        psplat_blend_field *field = &m->measured.fields[i];
        m->measured.regions[i] = candidate->region;
        field->kernel = m->c->kernel;
        field->depth = HUGE_VAL;
        psplat_blend_field_paint(candidate->color, &candidate->finish,
                                 material_of(m->c->surface.mesh, candidate->triangle), field);
    }
    m->measured.region_tree = psplat_region_tree_create(
        m->measured.regions, count, PSPLAT_STEEPEST_REACH * m->measured.tolerance);
    return m->measured.region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

static psplat_point_blend blend_at(const mender *m, size_t point) {
    psplat_point_blend blend = {
        .measured = &m->measured, .reach = 2 * m->measured.tolerance, .limit = -HUGE_VAL};
    memcpy(blend.point, m->points.positions + 3 * point, sizeof blend.point);
    for (size_t k = 0; k < 3; ++k) blend.normal[k] = (double)m->points.normals[3 * point + k];
    normalize3(blend.normal);
    return blend;
}

static int add_to_blend(void *user, uint32_t candidate) {
    psplat_point_blend *blend = user;
    if (psplat_measured_splats_near(blend->measured, candidate, blend->point, blend->reach))
        psplat_point_blend_add(blend, candidate);
    return 0;
}

static void blend_points(mender *m) {
    long end = (long)m->points.count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1024)
#endif
    for (long i = 0; i < end; ++i) {
        psplat_point_blend blend = blend_at(m, (size_t)i);
        psplat_region_tree_visit(m->measured.region_tree, blend.point, add_to_blend, &blend);
        psplat_blended_look(&blend, m->looks + PSPLAT_LOOK_VALUES * (size_t)i);
    }
}

/* Finds which of at most so many points show what the surface does not look like. */
static psplat_result find_wrong(mender *m, size_t most, uint64_t seed, psplat_error *error) {
    const psplat_conversion *c = m->c;
    size_t wanted = psplat_color_point_count(&c->surface, c->tolerance);
    if (wanted > most) wanted = most;
    psplat_result result = psplat_fit_colors(&c->samples, !c->limits.constant_colors,
                                             c->selection.candidates, c->selection.count);
    if (!result) result = measure_candidates(m);
    if (!result) result = psplat_samples_draw_uniform(&c->surface, wanted, seed, &m->points, error);
    if (result) return result;
    psplat_samples_drop_apron(&m->points, &c->surface);
    m->looks = malloc((m->points.count + 1) * PSPLAT_LOOK_VALUES * sizeof *m->looks);
    m->errors = malloc((m->points.count + 1) * sizeof *m->errors);
    m->wrong = malloc((m->points.count + 1) * sizeof *m->wrong);
    if (!m->looks || !m->errors || !m->wrong) return PSPLAT_ERROR_MEMORY;
    blend_points(m);
    result = psplat_color_errors_find(&c->surface, &m->points, m->looks, c->tolerance, m->limit,
                                      m->errors);
    for (size_t i = 0; i < m->points.count && !result; ++i) {
        m->seen_count += m->errors[i] >= 0;
        if (m->errors[i] > m->limit) m->wrong[m->wrong_count++] = (uint32_t)i;
    }
    return result;
}

/* ---- who shows it ---------------------------------------------------------------------------- */

/* A wrong point that looks for the candidate to blame: of those that show another colour there, the
 * one that weighs most. */
typedef struct trial {
    const mender *m;
    size_t point;
    double weight; /* of the candidate */
    uint32_t candidate;
    float expected[PSPLAT_LOOK_VALUES];
} trial;

static int accuse(void *user, uint32_t candidate) {
    trial *t = user;
    float own[PSPLAT_LOOK_VALUES];
    psplat_point_blend blend = blend_at(t->m, t->point);
    add_to_blend(&blend, candidate);
    if (!(blend.weight > t->weight)) return 0;
    psplat_blended_look(&blend, own);
    if (!(psplat_look_difference(own, t->expected) > t->m->limit)) return 0;
    t->weight = blend.weight;
    t->candidate = candidate;
    return 0;
}

/* Finds whom each wrong point blames. */
static psplat_result find_blames(mender *m) {
    m->blamers = malloc((m->wrong_count + 1) * sizeof *m->blamers);
    m->blames = calloc(m->c->selection.count + 1, sizeof *m->blames);
    m->blamed = calloc(m->c->selection.count + 1, 1);
    if (!m->blamers || !m->blames || !m->blamed) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < m->wrong_count; ++i) {
        trial t = {.m = m, .point = m->wrong[i], .candidate = PSPLAT_NONE};
        psplat_expected_look(&m->c->surface, &m->points, t.point, t.expected);
        psplat_region_tree_visit(m->measured.region_tree, m->points.positions + 3 * t.point, accuse,
                                 &t);
        m->blamers[i] = t.candidate;
        if (t.candidate != PSPLAT_NONE) ++m->blames[t.candidate];
    }
    return PSPLAT_OK;
}

/* Chooses the candidates to replace: those that most points blame, until so few points are left as
 * are wanted. Keeps only the wrong points that blame them. */
static void choose_blamed(mender *m) {
    size_t left = m->wrong_count, kept = 0;
    size_t wanted = (size_t)(m->shares.wanted * (double)m->seen_count);
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
        if (m->blamers[i] != PSPLAT_NONE && m->blamed[m->blamers[i]])
            m->wrong[kept++] = m->wrong[i];
    m->wrong_count = kept;
}

/* ---- mending --------------------------------------------------------------------------------- */

/* Keeps one wrong point of each cube. Returns 0 when out of memory. */
static int thin_wrong_points(mender *m) {
    return psplat_thin_points(m->points.positions, cube_side_tolerances * m->c->tolerance, m->wrong,
                              &m->wrong_count);
}

/* Notes what candidates may show at the samples from index first on, which are these points. */
static psplat_result note_ranges(mender *m, size_t first, const uint32_t *chosen, size_t count) {
    psplat_conversion *c = m->c;
    float(*ranges)[16] = realloc(c->color_ranges, (first + count + 1) * sizeof *ranges);
    if (!ranges) return PSPLAT_ERROR_MEMORY;
    c->limits.color_ranges = (const float(*)[16])(c->color_ranges = ranges);
    for (size_t i = c->limits.color_range_count; i < first; ++i) ranges[i][0] = NAN;
    psplat_result result =
        psplat_color_ranges_find(&m->points, c->tolerance, chosen, count, ranges[first]);
    if (!result) c->limits.color_range_count = first + count;
    return result;
}

/* Appends points to the samples, at which candidates have to be right from now on. */
static psplat_result append_points(mender *m, psplat_error *error) {
    psplat_conversion *c = m->c;
    size_t first = c->samples.count, count = m->wrong_count;
    uint32_t *chosen = m->wrong;
    psplat_result result = PSPLAT_OK;
    double *points = malloc((count + 1) * 3 * sizeof *points);
    uint32_t *triangles = malloc((count + 1) * sizeof *triangles);
    if (!result) result = points && triangles ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; ++i) {
        memcpy(points + 3 * i, m->points.positions + 3 * (size_t)chosen[i], 3 * sizeof *points);
        triangles[i] = m->points.triangles[chosen[i]];
    }
    if (!result)
        result = psplat_samples_append(&c->samples, &c->surface, points, triangles, count, error);
    if (!result) result = note_ranges(m, first, chosen, count);
    free(points);
    free(triangles);
    return result;
}

/* Replaces the candidates that are to blame. */
static psplat_result replace(mender *m, psplat_error *error) {
    psplat_conversion *c = m->c;
    size_t first = c->samples.count;
    psplat_result result = find_blames(m);
    if (result) return result;
    choose_blamed(m);
    if (!thin_wrong_points(m)) return PSPLAT_ERROR_MEMORY;
    result = append_points(m, error);
    for (size_t i = 0; i < c->selection.count; ++i)
        if (m->blamed[i]) c->selection.candidates[i].taken = 0;
    psplat_selection_drop_untaken(&c->selection);
    if (!result) result = psplat_cover_samples(c, first, m->last, error);
    psplat_selection_drop_untaken(&c->selection);
    return result;
}

/* Returns a mender that has found nothing yet. */
static mender mender_of(psplat_conversion *c, int last) {
    return (mender){.c = c,
                    .limit = 100 * c->limits.color_tolerance,
                    .shares = shares[last != 0],
                    .last = last};
}

static int is_wrong(const mender *m, double part) {
    return (double)m->wrong_count > part * m->shares.spared * (double)m->seen_count;
}

/* Stores whether a few points are wrong so often that more have to tell. */
static psplat_result glance(psplat_conversion *c, int last, int *mends, psplat_error *error) {
    mender m = mender_of(c, last);
    psplat_result result =
        find_wrong(&m, glance_points, c->desc->seed + mend_seed - 1 - (uint64_t)(last != 0), error);
    *mends = is_wrong(&m, glance_part);
    free_round(&m);
    return result;
}

psplat_result psplat_mend_colors(psplat_conversion *c, int last, psplat_error *error) {
    int mends;
    if (!(c->limits.color_tolerance > 0) || !psplat_samples_have_look(&c->samples))
        return PSPLAT_OK;
    psplat_result result = glance(c, last, &mends, error);
    for (int round = 0; round < ROUNDS && mends && !result; ++round) {
        mender m = mender_of(c, last);
        if (psplat_conversion_interrupted(c->desc, "mending colours", (double)round / ROUNDS))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result =
            find_wrong(&m, SIZE_MAX,
                       c->desc->seed + mend_seed + (uint64_t)(round + ROUNDS * (last != 0)), error);
        mends = is_wrong(&m, 1);
        if (!result && mends) result = replace(&m, error);
        free_round(&m);
    }
    if (result && result != PSPLAT_ERROR_INTERRUPTED)
        psplat_fail(error, result, 0, "%s while mending colours", psplat_result_text(result));
    return result;
}
