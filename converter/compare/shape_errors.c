/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shape_errors.c - the errors of shape between a source mesh and a target: Hausdorff distance,
 * normals and coverage, measured on points of both. Points are measured in parallel, but their
 * values are summed in sorted order (statistics.c), so that the result does not depend on the
 * number of threads.
 */
#include "compare/shape_errors.h"

#include "base/angle.h"
#include "base/random.h"
#include "base/vector.h"
#include "compare/crease_zone.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/statistics.h"
#include "compare/surface_points.h"
#include "compare/tested_surface.h"
#include "measure/splat_distance.h"
#include "mesh/distance.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The least distance, in diagonals, to which the greatest one is refined. */
static const double least_refined = 1e-7;

enum { DEFAULT_SAMPLES = 200000, BLOCK_POINTS = 256 }; /* a thread measures a block at a time */

/* The state of one comparison. */
typedef struct comparison {
    const psplat_source_mesh *source;
    const psplat_tested_surface *target;
    psplat_surface_points here, there; /* points of the source and of the target */
    psplat_crease_zone crease_zone;
    double *outward, *inward; /* distances of all points of the source, and of the target */
    double farthest;          /* the greatest distance found of any point of the target */
    double *angles;       /* degrees, of the uniform points of the source; negative if uncovered */
    uint8_t *near_crease; /* of the same points: whether they lie in the crease zone */
    psplat_shape_errors *errors;
} comparison;

static double percent_of(const comparison *c, double length) {
    return 100 * length / c->source->surface.diagonal;
}

/* ---- one point ------------------------------------------------------------------------------- */

/* Finds the angle between the normal of the source and that of the target there, degrees; it is
 * negative where the target does not cover the point. */
static psplat_result find_angle(const psplat_tested_surface *target, const double point[3],
                                const double normal[3], double *angle) {
    double seen[3], across[3];
    psplat_result result = psplat_tested_surface_normal(target, point, normal, seen);
    *angle = -1;
    if (result || !(dot3(seen, seen) > 0)) return result;
    /* An arc cosine would resolve small angles only to 1e-6 degrees. */
    cross3(across, seen, normal);
    *angle = atan2(length3(across), dot3(seen, normal)) / PSPLAT_DEGREE;
    return PSPLAT_OK;
}

static psplat_result measure_point(comparison *c, size_t i) {
    const double *point = c->here.points + 3 * i;
    psplat_result result = psplat_tested_surface_distance(c->target, point, &c->outward[i]);
    if (result || i >= c->here.uniform) return result;
    double normal[3];
    for (size_t k = 0; k < 3; ++k) normal[k] = (double)c->here.normals[3 * i + k];
    normalize3(normal);
    c->near_crease[i] = (uint8_t)psplat_crease_zone_near(&c->crease_zone, point);
    return find_angle(c->target, point, normal, &c->angles[i]);
}

static double greatest(const double *values, size_t count) {
    double result = 0;
    for (size_t i = 0; i < count; ++i) result = max2(result, values[i]);
    return result;
}

/* ---- all points ------------------------------------------------------------------------------ */

static psplat_result measure_outward(comparison *c) {
    long end = (long)c->here.count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, BLOCK_POINTS) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) failed |= measure_point(c, (size_t)i) != PSPLAT_OK;
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

static psplat_result measure_inward(comparison *c) {
    long blocks = (long)((c->there.count + BLOCK_POINTS - 1) / BLOCK_POINTS);
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1) reduction(| : failed)
#endif
    for (long b = 0; b < blocks; ++b) {
        size_t begin = BLOCK_POINTS * (size_t)b, left = c->there.count - begin;
        failed |= psplat_distance_query(c->source->distance, c->there.points + 3 * begin,
                                        left < BLOCK_POINTS ? left : BLOCK_POINTS,
                                        c->inward + begin) != PSPLAT_OK;
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* Finds the greatest distance of all points of splats, within the 1 % of psplat_splat_distance.
 * Only splats that exceed the greatest distance of the points are searched in full. So the result
 * does not depend on how splats are sized, nor much on the number of points. */
static psplat_result refine_inward(comparison *c) {
    const psplat_measured_splats *splats = &c->target->placed.splats;
    c->farthest = greatest(c->inward, c->there.count);
    if (c->target->mesh) return PSPLAT_OK;
    const psplat_splat_distance_desc desc = {
        .tolerance = max2(c->farthest, least_refined * c->source->surface.diagonal)};
    double farthest = c->farthest;
    long end = (long)splats->count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 16) reduction(| : failed) reduction(max : farthest)
#endif
    for (long i = 0; i < end; ++i) {
        psplat_splat_distance far;
        failed |= psplat_splat_distance_find(&splats->regions[i], c->source->distance, &desc,
                                             &far) != PSPLAT_OK;
        farthest = max2(farthest, far.found);
    }
    c->farthest = farthest;
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* ---- statistics ------------------------------------------------------------------------------ */

static double percentage(size_t count, size_t all) {
    return all ? 100 * (double)count / (double)all : 0;
}

static psplat_statistics percent_statistics(const comparison *c, psplat_statistics s) {
    return (psplat_statistics){percent_of(c, s.max), percent_of(c, s.rms), percent_of(c, s.p95)};
}

static void summarize_distances(comparison *c) {
    psplat_shape_errors *e = c->errors;
    size_t outward = c->here.uniform, inward = c->there.uniform, beyond = 0;
    double reach = c->target->reach / 2;
    for (size_t i = 0; i < inward; ++i) beyond += c->inward[i] > reach;
    e->overhang_area = percentage(beyond, inward);
    /* Corners count for the greatest distance only, since they stand for no area. */
    double outward_max = greatest(c->outward, c->here.count);
    e->outward = percent_statistics(c, psplat_statistics_of(c->outward, outward, NULL));
    e->inward = percent_statistics(c, psplat_statistics_of(c->inward, inward, NULL));
    e->distance =
        percent_statistics(c, psplat_statistics_both(c->outward, outward, c->inward, inward));
    e->outward.max = percent_of(c, outward_max);
    e->inward.max = percent_of(c, c->farthest);
    e->distance.max = max2(e->outward.max, e->inward.max);
}

/* Returns the statistics of angles inside or outside the crease zone; scratch has room for all. */
static psplat_statistics zone_statistics(const comparison *c, int near_crease, double *scratch) {
    for (size_t i = 0; i < c->here.uniform; ++i)
        scratch[i] = c->near_crease[i] == near_crease ? c->angles[i] : -1;
    return psplat_statistics_of(scratch, c->here.uniform, NULL);
}

static psplat_result summarize_normals(comparison *c) {
    psplat_shape_errors *e = c->errors;
    size_t all = c->here.uniform, open = 0, near = 0;
    double *scratch = malloc((all + 1) * sizeof *scratch);
    if (!scratch) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < all; ++i) {
        open += c->angles[i] < 0;
        near += c->near_crease[i];
    }
    e->uncovered_area = percentage(open, all);
    e->crease_area = percentage(near, all);
    e->face_normal = zone_statistics(c, 0, scratch);
    e->crease_normal = zone_statistics(c, 1, scratch);
    e->normal = psplat_statistics_of(c->angles, all, NULL);
    free(scratch);
    return PSPLAT_OK;
}

/* ---- a comparison ---------------------------------------------------------------------------- */

static psplat_result prepare(comparison *c, const psplat_shape_desc *desc, psplat_error *error) {
    static const double here[3] = {0, 0, 0};
    size_t samples = desc->samples ? desc->samples : DEFAULT_SAMPLES;
    uint64_t seed = desc->seed, other = desc->seed + 1;
    psplat_shape_errors *e = c->errors;
    e->diagonal = c->source->surface.diagonal;
    e->elements = psplat_tested_surface_elements(c->target);
    e->reach = percent_of(c, c->target->reach);
    e->crease_width = desc->crease_width > 0 ? desc->crease_width : e->reach;
    psplat_result result = psplat_surface_points_of_mesh(
        c->source, here, samples, psplat_random_next(&seed), &c->here, error);
    if (!result)
        result = psplat_tested_surface_points(c->target, samples, psplat_random_next(&other),
                                              &c->there, error);
    if (result) return result;
    e->source_samples = c->here.count;
    e->target_samples = c->there.count;
    c->outward = malloc((c->here.count + 1) * sizeof *c->outward);
    c->inward = malloc((c->there.count + 1) * sizeof *c->inward);
    c->angles = malloc((c->here.uniform + 1) * sizeof *c->angles);
    c->near_crease = malloc(c->here.uniform + 1);
    int ok = c->outward && c->inward && c->angles && c->near_crease;
    if (ok)
        result = psplat_crease_zone_create(&c->source->surface, e->crease_width / 100 * e->diagonal,
                                           &c->crease_zone);
    return ok ? result : PSPLAT_ERROR_MEMORY;
}

static void finish(comparison *c) {
    psplat_surface_points_free(&c->here);
    psplat_surface_points_free(&c->there);
    psplat_crease_zone_free(&c->crease_zone);
    free(c->outward);
    free(c->inward);
    free(c->angles);
    free(c->near_crease);
}

static psplat_result compare(const psplat_source_mesh *source, const psplat_tested_surface *target,
                             const psplat_shape_desc *desc, psplat_shape_errors *errors,
                             psplat_error *error) {
    static const psplat_shape_desc defaults = {0};
    comparison c = {.source = source, .target = target, .errors = errors};
    *errors = (psplat_shape_errors){0};
    if (error) *error = (psplat_error){0};
    psplat_result result = prepare(&c, desc ? desc : &defaults, error);
    if (!result) result = measure_outward(&c);
    if (!result) result = measure_inward(&c);
    if (!result) result = refine_inward(&c);
    if (!result) result = summarize_normals(&c);
    if (!result) summarize_distances(&c);
    finish(&c);
    if (result == PSPLAT_ERROR_MEMORY)
        psplat_fail(error, result, 0, "out of memory while comparing");
    return result;
}

psplat_result psplat_shape_compare(const psplat_source_mesh *source, const psplat_asset *asset,
                                   const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                   psplat_error *error) {
    psplat_tested_surface target;
    psplat_result result =
        psplat_tested_surface_splats(source, asset, desc ? desc->reach : 0, &target, error);
    if (result) return result;
    result = compare(source, &target, desc, errors, error);
    psplat_tested_surface_free(&target);
    return result;
}

psplat_result psplat_shape_compare_mesh(const psplat_source_mesh *source,
                                        const psplat_source_mesh *mesh,
                                        const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                        psplat_error *error) {
    psplat_tested_surface target;
    psplat_tested_surface_mesh(source, mesh, desc ? desc->reach : 0, &target);
    return compare(source, &target, desc, errors, error);
}

/* ---- single points --------------------------------------------------------------------------- */

struct psplat_shape_probe {
    const psplat_source_mesh *source;
    psplat_tested_surface target;
};

static psplat_result create_probe(const psplat_source_mesh *source, psplat_shape_probe **probe,
                                  psplat_error *error) {
    *probe = calloc(1, sizeof **probe);
    if (!*probe) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a probe");
    (*probe)->source = source;
    return PSPLAT_OK;
}

psplat_result psplat_shape_probe_create(const psplat_source_mesh *source, const psplat_asset *asset,
                                        const psplat_shape_desc *desc, psplat_shape_probe **probe,
                                        psplat_error *error) {
    psplat_result result = create_probe(source, probe, error);
    if (result) return result;
    result = psplat_tested_surface_splats(source, asset, desc ? desc->reach : 0, &(*probe)->target,
                                          error);
    if (!result) return PSPLAT_OK;
    psplat_shape_probe_destroy(*probe);
    *probe = NULL;
    return result;
}

psplat_result psplat_shape_probe_create_mesh(const psplat_source_mesh *source,
                                             const psplat_source_mesh *mesh,
                                             const psplat_shape_desc *desc,
                                             psplat_shape_probe **probe, psplat_error *error) {
    psplat_result result = create_probe(source, probe, error);
    if (!result)
        psplat_tested_surface_mesh(source, mesh, desc ? desc->reach : 0, &(*probe)->target);
    return result;
}

void psplat_shape_probe_at(const psplat_shape_probe *probe, const double point[3],
                           const double normal[3], double *distance, double *angle) {
    double here[3], unit[3];
    sub3(here, point, probe->source->mesh->origin);
    memcpy(unit, normal, sizeof unit);
    *angle = -1;
    if (normalize3(unit) > 0 && find_angle(&probe->target, here, unit, angle)) *angle = -1;
    if (psplat_tested_surface_distance(&probe->target, here, distance)) *distance = HUGE_VAL;
    *distance *= 100 / probe->source->surface.diagonal;
}

void psplat_shape_probe_destroy(psplat_shape_probe *probe) {
    if (!probe) return;
    psplat_tested_surface_free(&probe->target);
    free(probe);
}
