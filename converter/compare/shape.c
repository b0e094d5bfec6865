/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shape.c - distances, normals and coverage, measured on points of the source and of what is
 * compared with it. Values are found in parallel and summed in an order of their own, so that
 * nothing depends on the number of threads.
 */
#include "folds.h"
#include "spread.h"
#include "target.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SAMPLES = 200000, BLOCK = 256 };

static const double degree = 3.141592653589793 / 180;

/* What one comparison works with. */
typedef struct comparison {
    const psplat_original *source;
    const psplat_target *target;
    psplat_cloud here, there; /* points of the source and of the target */
    psplat_folds folds;
    double *outward, *inward; /* distances of all points */
    double *angles;     /* degrees, of the uniform points of the source; negative: uncovered */
    uint8_t *near_fold; /* the same points */
    psplat_shape_errors *errors;
} comparison;

static double percent_of(const comparison *c, double length) {
    return 100 * length / c->source->surface.diagonal;
}

/* ---- one point --------------------------------------------------------------------------------
 */

/* Degrees between the normal of the source and what is seen there; negative: nothing is. */
static psplat_result find_angle(const psplat_target *target, const double point[3],
                                const double normal[3], double *angle) {
    double seen[3], across[3];
    psplat_result result = psplat_target_normal(target, point, normal, seen);
    *angle = -1;
    if (result || !(dot3(seen, seen) > 0)) return result;
    cross3(across, seen, normal); /* an arc cosine would know small angles to 1e-6 degrees only */
    *angle = atan2(length3(across), dot3(seen, normal)) / degree;
    return PSPLAT_OK;
}

static psplat_result measure_point(comparison *c, size_t i) {
    const double *point = c->here.points + 3 * i;
    psplat_result result = psplat_target_distance(c->target, point, &c->outward[i]);
    if (result || i >= c->here.uniform) return result;
    double normal[3];
    for (size_t k = 0; k < 3; ++k) normal[k] = (double)c->here.normals[3 * i + k];
    normalize3(normal);
    c->near_fold[i] = (uint8_t)psplat_folds_near(&c->folds, point);
    return find_angle(c->target, point, normal, &c->angles[i]);
}

/* ---- all points --------------------------------------------------------------------------------
 */

static psplat_result measure_outward(comparison *c) {
    long end = (long)c->here.count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, BLOCK) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) failed |= measure_point(c, (size_t)i) != PSPLAT_OK;
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

static psplat_result measure_inward(comparison *c) {
    long blocks = (long)((c->there.count + BLOCK - 1) / BLOCK);
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1) reduction(| : failed)
#endif
    for (long b = 0; b < blocks; ++b) {
        size_t begin = BLOCK * (size_t)b, left = c->there.count - begin;
        failed |=
            psplat_distance_query(c->source->distance, c->there.points + 3 * begin,
                                  left < BLOCK ? left : BLOCK, c->inward + begin) != PSPLAT_OK;
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* ---- what they come down to ---------------------------------------------------------------------
 */

static double part(size_t count, size_t all) {
    return all ? 100 * (double)count / (double)all : 0;
}

static double greatest(const double *values, size_t count) {
    double result = 0;
    for (size_t i = 0; i < count; ++i) result = max2(result, values[i]);
    return result;
}

static psplat_spread spread_percent(const comparison *c, psplat_spread s) {
    return (psplat_spread){percent_of(c, s.max), percent_of(c, s.rms), percent_of(c, s.p95)};
}

static void sum_up_distances(comparison *c) {
    psplat_shape_errors *e = c->errors;
    size_t outward = c->here.uniform, inward = c->there.uniform, beyond = 0;
    double reach = c->target->reach / 2;
    for (size_t i = 0; i < inward; ++i) beyond += c->inward[i] > reach;
    e->overhang_area = part(beyond, inward);
    /* Corners are no area. */
    double outward_max = greatest(c->outward, c->here.count);
    double inward_max = greatest(c->inward, c->there.count);
    e->outward = spread_percent(c, psplat_spread_of(c->outward, outward, NULL));
    e->inward = spread_percent(c, psplat_spread_of(c->inward, inward, NULL));
    e->distance = spread_percent(c, psplat_spread_both(c->outward, outward, c->inward, inward));
    e->outward.max = percent_of(c, outward_max);
    e->inward.max = percent_of(c, inward_max);
    e->distance.max = max2(e->outward.max, e->inward.max);
}

/* Angles of the points on one side, the others negative, in scratch. */
static psplat_spread spread_side(const comparison *c, int near_fold, double *scratch) {
    for (size_t i = 0; i < c->here.uniform; ++i)
        scratch[i] = c->near_fold[i] == near_fold ? c->angles[i] : -1;
    return psplat_spread_of(scratch, c->here.uniform, NULL);
}

static psplat_result sum_up_normals(comparison *c) {
    psplat_shape_errors *e = c->errors;
    size_t all = c->here.uniform, open = 0, near = 0;
    double *scratch = malloc((all + 1) * sizeof *scratch);
    if (!scratch) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < all; ++i) {
        open += c->angles[i] < 0;
        near += c->near_fold[i];
    }
    e->uncovered_area = part(open, all);
    e->crease_area = part(near, all);
    e->face_normal = spread_side(c, 0, scratch);
    e->crease_normal = spread_side(c, 1, scratch);
    e->normal = psplat_spread_of(c->angles, all, NULL);
    free(scratch);
    return PSPLAT_OK;
}

/* ---- a comparison ------------------------------------------------------------------------------
 */

static psplat_result prepare(comparison *c, const psplat_shape_desc *desc, psplat_error *error) {
    static const double here[3] = {0, 0, 0};
    size_t samples = desc->samples ? desc->samples : DEFAULT_SAMPLES;
    uint64_t seed = desc->seed, other = desc->seed + 1;
    psplat_shape_errors *e = c->errors;
    e->diagonal = c->source->surface.diagonal;
    e->elements = psplat_target_elements(c->target);
    e->reach = percent_of(c, c->target->reach);
    e->crease_width = desc->crease_width > 0 ? desc->crease_width : e->reach;
    psplat_result result =
        psplat_cloud_of_mesh(c->source, here, samples, psplat_random_next(&seed), &c->here, error);
    if (!result)
        result =
            psplat_target_points(c->target, samples, psplat_random_next(&other), &c->there, error);
    if (result) return result;
    e->source_samples = c->here.count;
    e->target_samples = c->there.count;
    c->outward = malloc((c->here.count + 1) * sizeof *c->outward);
    c->inward = malloc((c->there.count + 1) * sizeof *c->inward);
    c->angles = malloc((c->here.uniform + 1) * sizeof *c->angles);
    c->near_fold = malloc(c->here.uniform + 1);
    int ok = c->outward && c->inward && c->angles && c->near_fold;
    if (ok)
        result = psplat_folds_create(&c->source->surface, e->crease_width / 100 * e->diagonal,
                                     &c->folds);
    return ok ? result : PSPLAT_ERROR_MEMORY;
}

static void finish(comparison *c) {
    psplat_cloud_free(&c->here);
    psplat_cloud_free(&c->there);
    psplat_folds_free(&c->folds);
    free(c->outward);
    free(c->inward);
    free(c->angles);
    free(c->near_fold);
}

static psplat_result compare(const psplat_original *source, const psplat_target *target,
                             const psplat_shape_desc *desc, psplat_shape_errors *errors,
                             psplat_error *error) {
    static const psplat_shape_desc defaults = {0};
    comparison c = {.source = source, .target = target, .errors = errors};
    *errors = (psplat_shape_errors){0};
    if (error) *error = (psplat_error){0};
    psplat_result result = prepare(&c, desc ? desc : &defaults, error);
    if (!result) result = measure_outward(&c);
    if (!result) result = measure_inward(&c);
    if (!result) result = sum_up_normals(&c);
    if (!result) sum_up_distances(&c);
    finish(&c);
    if (result == PSPLAT_ERROR_MEMORY)
        psplat_fail(error, result, 0, "out of memory while comparing");
    return result;
}

psplat_result psplat_shape_compare(const psplat_original *source, const psplat_asset *asset,
                                   const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                   psplat_error *error) {
    psplat_target target;
    psplat_result result =
        psplat_target_splats(source, asset, desc ? desc->reach : 0, &target, error);
    if (result) return result;
    result = compare(source, &target, desc, errors, error);
    psplat_target_free(&target);
    return result;
}

psplat_result psplat_shape_compare_mesh(const psplat_original *source, const psplat_original *mesh,
                                        const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                        psplat_error *error) {
    psplat_target target;
    psplat_target_mesh(source, mesh, desc ? desc->reach : 0, &target);
    return compare(source, &target, desc, errors, error);
}

/* ---- places ------------------------------------------------------------------------------------
 */

struct psplat_shape_probe {
    const psplat_original *source;
    psplat_target target;
};

static psplat_result create_probe(const psplat_original *source, psplat_shape_probe **probe,
                                  psplat_error *error) {
    *probe = calloc(1, sizeof **probe);
    if (!*probe) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a probe");
    (*probe)->source = source;
    return PSPLAT_OK;
}

psplat_result psplat_shape_probe_create(const psplat_original *source, const psplat_asset *asset,
                                        const psplat_shape_desc *desc, psplat_shape_probe **probe,
                                        psplat_error *error) {
    psplat_result result = create_probe(source, probe, error);
    if (result) return result;
    result = psplat_target_splats(source, asset, desc ? desc->reach : 0, &(*probe)->target, error);
    if (!result) return PSPLAT_OK;
    psplat_shape_probe_destroy(*probe);
    *probe = NULL;
    return result;
}

psplat_result psplat_shape_probe_create_mesh(const psplat_original *source,
                                             const psplat_original *mesh,
                                             const psplat_shape_desc *desc,
                                             psplat_shape_probe **probe, psplat_error *error) {
    psplat_result result = create_probe(source, probe, error);
    if (!result) psplat_target_mesh(source, mesh, desc ? desc->reach : 0, &(*probe)->target);
    return result;
}

void psplat_shape_probe_at(const psplat_shape_probe *probe, const double point[3],
                           const double normal[3], double *distance, double *angle) {
    double here[3], unit[3];
    sub3(here, point, probe->source->mesh->origin);
    memcpy(unit, normal, sizeof unit);
    *angle = -1;
    if (normalize3(unit) > 0 && find_angle(&probe->target, here, unit, angle)) *angle = -1;
    if (psplat_target_distance(&probe->target, here, distance)) *distance = HUGE_VAL;
    *distance *= 100 / probe->source->surface.diagonal;
}

void psplat_shape_probe_destroy(psplat_shape_probe *probe) {
    if (!probe) return;
    psplat_target_free(&probe->target);
    free(probe);
}
