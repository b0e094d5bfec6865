/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tested_surface.c - the tested surface of a comparison: splats, or another mesh.
 */
#include "compare/tested_surface.h"

#include "base/region_distance.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "compare/placed_splats.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/surface_points.h"
#include "features/surface.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "mesh/distance.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <string.h>

/* The reach for meshes and for assets whose depth tolerance is 0, % of the diagonal. */
static const double default_reach_percent = 1;

psplat_result psplat_tested_surface_splats(const psplat_source_mesh *source,
                                           const psplat_asset *asset, double percent,
                                           psplat_tested_surface *target, psplat_error *error) {
    return psplat_tested_surface_assets(source, &asset, 1, percent, target, error);
}

psplat_result psplat_tested_surface_assets(const psplat_source_mesh *source,
                                           const psplat_asset *const *assets, size_t count,
                                           double percent, psplat_tested_surface *target,
                                           psplat_error *error) {
    *target = (psplat_tested_surface){0};
    psplat_result result = psplat_placed_splats_create_all(assets, count, source->mesh->origin,
                                                           &target->placed, error);
    if (result) return result;
    double diagonal = source->surface.diagonal;
    target->reach = percent > 0 ? percent / 100 * diagonal : 2 * target->placed.depth;
    if (!(target->reach > 0)) target->reach = default_reach_percent / 100 * diagonal;
    result = psplat_placed_splats_reach(&target->placed, target->reach);
    if (!result) return PSPLAT_OK;
    psplat_tested_surface_free(target);
    return psplat_fail(error, result, 0, "no memory for the splats");
}

void psplat_tested_surface_mesh(const psplat_source_mesh *source, const psplat_source_mesh *mesh,
                                double percent, psplat_tested_surface *target) {
    percent = percent > 0 ? percent : default_reach_percent;
    *target =
        (psplat_tested_surface){.mesh = mesh, .reach = percent / 100 * source->surface.diagonal};
    sub3(target->shift, source->mesh->origin, mesh->mesh->origin);
}

void psplat_tested_surface_free(psplat_tested_surface *target) {
    psplat_placed_splats_free(&target->placed);
    *target = (psplat_tested_surface){0};
}

size_t psplat_tested_surface_elements(const psplat_tested_surface *target) {
    return target->mesh ? target->mesh->mesh->triangle_count : target->placed.splats.count;
}

psplat_result psplat_tested_surface_distance(const psplat_tested_surface *target,
                                             const double point[3], double *distance) {
    double there[3];
    along3(there, point, 1, target->shift);
    if (target->mesh) return psplat_distance_query(target->mesh->distance, there, 1, distance);
    const psplat_placed_splats *placed = &target->placed;
    /* The search starts with an eighth of the reach, which most points are nearer than. */
    *distance = psplat_region_nearest_distance(placed->splats.regions, placed->splats.count,
                                               placed->region_tree, target->reach / 8, point);
    return PSPLAT_OK;
}

/* The splats that a point's normal meets. More than these are met in places where splats crowd,
 * and are then looked for again. */
enum { MOST_MET = 64 };
typedef struct met_splats {
    psplat_point_blend blend;
    uint32_t splats[MOST_MET];
    size_t count;
} met_splats;

static int visit_limit(void *user, uint32_t splat) {
    met_splats *met = user;
    if (!psplat_point_blend_limit(&met->blend, splat)) return 0;
    if (met->count < MOST_MET) met->splats[met->count] = splat;
    ++met->count;
    return 0;
}

static int visit_add(void *user, uint32_t splat) {
    met_splats *met = user;
    psplat_point_blend_add(&met->blend, splat);
    return 0;
}

static void splat_normal(const psplat_tested_surface *target, const double point[3],
                         const double normal[3], double seen[3]) {
    const psplat_measured_splats *splats = &target->placed.splats;
    met_splats met = {.blend = {.measured = splats, .reach = target->reach, .limit = -HUGE_VAL}};
    memcpy(met.blend.point, point, sizeof met.blend.point);
    memcpy(met.blend.normal, normal, sizeof met.blend.normal);
    psplat_region_tree_visit(splats->region_tree, point, visit_limit, &met);
    if (met.count > MOST_MET)
        psplat_region_tree_visit(splats->region_tree, point, visit_add, &met);
    else
        for (size_t i = 0; i < met.count; ++i) visit_add(&met, met.splats[i]);
    memcpy(seen, met.blend.blended, sizeof met.blend.blended);
}

/* Finds the normal at the nearest point, since a simplified mesh has no other correspondence. */
static psplat_result mesh_normal(const psplat_tested_surface *target, const double point[3],
                                 const double normal[3], double seen[3]) {
    const psplat_source_mesh *mesh = target->mesh;
    double there[3], from[3], to[3], nearest[3], weights[3];
    uint32_t triangle, guess = PSPLAT_NONE;
    float at[3];
    int meets;
    memset(seen, 0, 3 * sizeof *seen);
    along3(there, point, 1, target->shift);
    along3(from, there, target->reach, normal);
    along3(to, there, -target->reach, normal);
    psplat_result result = psplat_distance_meets(mesh->distance, from, to, &meets);
    if (result || !meets) return result;
    result = psplat_distance_nearest(mesh->distance, there, &guess, nearest, &triangle);
    if (result) return result;
    psplat_surface_barycentric(&mesh->surface, triangle, nearest, weights);
    psplat_surface_normal(&mesh->surface, triangle, weights, at);
    for (int k = 0; k < 3; ++k) seen[k] = (double)at[k];
    return PSPLAT_OK;
}

psplat_result psplat_tested_surface_normal(const psplat_tested_surface *target,
                                           const double point[3], const double normal[3],
                                           double seen[3]) {
    if (target->mesh) return mesh_normal(target, point, normal, seen);
    splat_normal(target, point, normal, seen);
    return PSPLAT_OK;
}

psplat_result psplat_tested_surface_points(const psplat_tested_surface *target, size_t count,
                                           uint64_t seed, psplat_surface_points *cloud,
                                           psplat_error *error) {
    if (target->mesh)
        return psplat_surface_points_of_mesh(target->mesh, target->shift, count, seed, cloud,
                                             error);
    const psplat_measured_splats *splats = &target->placed.splats;
    return psplat_surface_points_of_regions(splats->regions, splats->count, count, seed, cloud,
                                            error);
}
