/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rays.c - whether rays from outside that meet the visible source meet the tested surface there.
 * Each ray has random numbers of its own, and counts are sums, so that the result does not depend
 * on the number of threads.
 */
#include "compare/rays.h"

#include "base/angle.h"
#include "base/random.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/tested_surface.h"
#include "features/samples.h"
#include "measure/ray_meeting.h"
#include "mesh/distance.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DEFAULT_RAYS = 100000, BLOCK_RAYS = 256 }; /* a thread measures a block at a time */

/* How far a ray runs, in diagonals: out of the box. */
static const double way_diagonals = 1.5;
/* What single precision may cut off at rims, in units of u and v. */
static const double rim_slack = 2e-6;

typedef enum ray_state {
    RAY_BLOCKED = 0,
    RAY_MET,
    RAY_HIDDEN,
    RAY_OUTLINE,
    RAY_MISSED,
    RAY_OPEN
} ray_state;

typedef struct ray {
    psplat_sight sight;
    double cosine;
    ray_state state;
} ray;

/* The state of one measurement. */
typedef struct measurement {
    const psplat_source_mesh *source;
    const psplat_tested_surface *target;
    psplat_samples samples;
    ray *rays;
    double reach; /* a length */
} measurement;

double psplat_rays_missed_percent(const psplat_ray_errors *errors) {
    return errors->count ? 100 * (double)errors->missed / (double)errors->count : 0;
}

double psplat_rays_least_cosine(int range) {
    return PSPLAT_LEAST_RAY_COSINE + (1 - PSPLAT_LEAST_RAY_COSINE) * range / PSPLAT_RAY_RANGES;
}

/* ---- one ray --------------------------------------------------------------------------------- */

/* Chooses a direction uniformly among those with enough of a cosine to a unit normal. */
static void choose_direction(const double normal[3], uint64_t random, ray *r) {
    double u[3], v[3], angle = 2 * PSPLAT_PI * psplat_random_unit(&random);
    r->cosine =
        PSPLAT_LEAST_RAY_COSINE + (1 - PSPLAT_LEAST_RAY_COSINE) * psplat_random_unit(&random);
    double sine = sqrt(max2(1 - r->cosine * r->cosine, 0));
    perpendicular3(u, normal);
    cross3(v, normal, u);
    memset(r->sight.direction, 0, sizeof r->sight.direction);
    mad3(r->sight.direction, r->cosine, normal);
    mad3(r->sight.direction, sine * cos(angle), u);
    mad3(r->sight.direction, sine * sin(angle), v);
}

/* The search for a front or a wall within reach of the point, and before it. */
typedef struct search {
    const psplat_measured_splats *splats;
    const psplat_sight *sight;
    double reach;
    int met, hidden, behind;
} search;

static int visit_splat(void *user, uint32_t splat) {
    search *s = user;
    double height, uv[2], wall = s->splats->fields[splat].depth / 4; /* spec 5.1 */
    if (!psplat_sight_meets(s->sight, &s->splats->regions[splat], wall, rim_slack, &height, uv))
        return 0;
    s->met |= fabs(height) <= s->reach;
    s->hidden |= height > s->reach;
    s->behind |= height < -s->reach;
    return s->met;
}

static ray_state meet_splats(const psplat_placed_splats *placed, const psplat_sight *sight,
                             double reach, double way) {
    search s = {&placed->splats, sight, reach, 0, 0, 0};
    double a[3], b[3], low[3], high[3];
    for (int all = 0; all < 2 && !s.met; ++all) { /* near the point, and then on all of the line */
        along3(a, sight->point, all ? -way : -reach, sight->direction);
        along3(b, sight->point, all ? way : reach, sight->direction);
        for (int k = 0; k < 3; ++k) low[k] = min2(a[k], b[k]), high[k] = max2(a[k], b[k]);
        psplat_region_tree_visit_box(placed->region_tree, low, high, visit_splat, &s);
    }
    return s.met ? RAY_MET : s.hidden ? RAY_HIDDEN : s.behind ? RAY_MISSED : RAY_OPEN;
}

static psplat_result meet_mesh(const psplat_tested_surface *target, const psplat_sight *sight,
                               double reach, double way, ray_state *state) {
    const psplat_distance *distance = target->mesh->distance;
    double there[3], far[3], from[3], to[3], end[3];
    int met = 0, hidden = 0, behind = 0;
    along3(there, sight->point, 1, target->shift);
    along3(far, there, way, sight->direction);
    along3(from, there, reach, sight->direction);
    along3(to, there, -reach, sight->direction);
    along3(end, there, -way, sight->direction);
    psplat_result result = psplat_distance_meets(distance, from, to, &met);
    if (!result && !met) result = psplat_distance_meets(distance, far, from, &hidden);
    if (!result && !met) result = psplat_distance_meets(distance, to, end, &behind);
    *state = met ? RAY_MET : hidden ? RAY_HIDDEN : behind ? RAY_MISSED : RAY_OPEN;
    return result;
}

static psplat_result measure_ray(measurement *m, size_t i, uint64_t seed) {
    ray *r = &m->rays[i];
    const psplat_source_mesh *source = m->source;
    const double *normal = source->surface.face_normals + 3 * (size_t)m->samples.triangles[i];
    double way = way_diagonals * source->surface.diagonal;
    int is_seen, is_inner = 1;
    uint64_t random = seed ^ i;
    memcpy(r->sight.point, m->samples.positions + 3 * i, sizeof r->sight.point);
    choose_direction(normal, psplat_random_next(&random), r);
    psplat_result result = psplat_sight_is_free(&r->sight, source->distance, way, &is_seen);
    if (result || !is_seen) return result;
    double reach = m->reach / r->cosine;
    if (m->target->mesh)
        result = meet_mesh(m->target, &r->sight, reach, way, &r->state);
    else
        r->state = meet_splats(&m->target->placed, &r->sight, reach, way);
    if (result || r->state < RAY_MISSED) return result;
    result =
        psplat_sight_is_inner(&r->sight, normal, r->cosine, source->distance, m->reach, &is_inner);
    if (!is_inner) r->state = RAY_OUTLINE;
    return result;
}

/* ---- all rays -------------------------------------------------------------------------------- */

static psplat_result measure_rays(measurement *m, uint64_t seed) {
    long end = (long)m->samples.count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, BLOCK_RAYS) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) failed |= measure_ray(m, (size_t)i, seed) != PSPLAT_OK;
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* Keeps a missed ray among those that are most straight on. */
static void keep_place(const measurement *m, const ray *r, psplat_ray_errors *errors) {
    size_t at = errors->place_count;
    if (at == PSPLAT_RAY_PLACES) {
        if (errors->places[--at].cosine >= r->cosine) return;
    } else {
        ++errors->place_count;
    }
    for (; at && errors->places[at - 1].cosine < r->cosine; --at)
        errors->places[at] = errors->places[at - 1];
    psplat_ray_place *place = &errors->places[at];
    along3(place->point, r->sight.point, 1, m->source->mesh->origin);
    memcpy(place->direction, r->sight.direction, sizeof place->direction);
    place->cosine = r->cosine;
}

static void sum_up(const measurement *m, psplat_ray_errors *errors) {
    for (size_t i = 0; i < m->samples.count; ++i) {
        const ray *r = &m->rays[i];
        if (r->state == RAY_BLOCKED) continue;
        double part = (r->cosine - PSPLAT_LEAST_RAY_COSINE) / (1 - PSPLAT_LEAST_RAY_COSINE);
        size_t range = (size_t)min2(PSPLAT_RAY_RANGES * part, PSPLAT_RAY_RANGES - 1);
        ++errors->count;
        ++errors->range_count[range];
        errors->hidden += r->state == RAY_HIDDEN;
        errors->outline += r->state == RAY_OUTLINE;
        if (r->state < RAY_MISSED) continue;
        ++errors->missed;
        errors->open += r->state == RAY_OPEN;
        ++errors->range_missed[range];
        keep_place(m, r, errors);
    }
}

static psplat_result compare(const psplat_source_mesh *source, const psplat_tested_surface *target,
                             const psplat_ray_desc *desc, psplat_ray_errors *errors,
                             psplat_error *error) {
    measurement m = {.source = source, .target = target, .reach = target->reach / 4};
    *errors = (psplat_ray_errors){0};
    if (error) *error = (psplat_error){0};
    if (desc->reach > 0) m.reach = desc->reach / 100 * source->surface.diagonal;
    errors->reach = 100 * m.reach / source->surface.diagonal;
    psplat_result result = psplat_samples_draw_uniform(
        &source->surface, desc->rays ? desc->rays : DEFAULT_RAYS, desc->seed, &m.samples, error);
    if (!result) {
        m.rays = calloc(m.samples.count + 1, sizeof *m.rays);
        if (!m.rays) result = PSPLAT_ERROR_MEMORY;
    }
    uint64_t seed = desc->seed;
    if (!result) result = measure_rays(&m, psplat_random_next(&seed));
    if (!result) sum_up(&m, errors);
    free(m.rays);
    psplat_samples_free(&m.samples);
    if (result) psplat_fail(error, result, 0, "out of memory while casting rays");
    return result;
}

static const psplat_ray_desc defaults;

psplat_result psplat_rays_compare(const psplat_source_mesh *source, const psplat_asset *asset,
                                  const psplat_ray_desc *desc, psplat_ray_errors *errors,
                                  psplat_error *error) {
    return psplat_rays_compare_assets(source, &asset, 1, desc, errors, error);
}

psplat_result psplat_rays_compare_assets(const psplat_source_mesh *source,
                                         const psplat_asset *const *assets, size_t count,
                                         const psplat_ray_desc *desc, psplat_ray_errors *errors,
                                         psplat_error *error) {
    psplat_tested_surface target;
    psplat_result result = psplat_tested_surface_assets(source, assets, count, 0, &target, error);
    if (result) return result;
    result = compare(source, &target, desc ? desc : &defaults, errors, error);
    psplat_tested_surface_free(&target);
    return result;
}

psplat_result psplat_rays_compare_mesh(const psplat_source_mesh *source,
                                       const psplat_source_mesh *mesh, const psplat_ray_desc *desc,
                                       psplat_ray_errors *errors, psplat_error *error) {
    psplat_tested_surface target;
    psplat_tested_surface_mesh(source, mesh, 0, &target);
    return compare(source, &target, desc ? desc : &defaults, errors, error);
}
