/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * target.c - what is compared with a source: splats, or another mesh.
 */
#include "target.h"
#include "vector.h"

#include <string.h>

/* Where an asset does not say how far its splats lie apart, and for meshes: % of the diagonal. */
static const double default_reach = 1;

psplat_result psplat_target_splats(const psplat_original *source, const psplat_asset *asset,
                                   double percent, psplat_target *target, psplat_error *error) {
    *target = (psplat_target){0};
    psplat_result result =
        psplat_placed_create(asset, source->mesh->origin, &target->placed, error);
    if (result) return result;
    double diagonal = source->surface.diagonal;
    target->reach = percent > 0 ? percent / 100 * diagonal : 2 * target->placed.depth;
    if (!(target->reach > 0)) target->reach = default_reach / 100 * diagonal;
    result = psplat_placed_reach(&target->placed, target->reach);
    if (!result) return PSPLAT_OK;
    psplat_target_free(target);
    return psplat_fail(error, result, 0, "no memory for the splats");
}

void psplat_target_mesh(const psplat_original *source, const psplat_original *mesh, double percent,
                        psplat_target *target) {
    percent = percent > 0 ? percent : default_reach;
    *target = (psplat_target){.mesh = mesh, .reach = percent / 100 * source->surface.diagonal};
    sub3(target->shift, source->mesh->origin, mesh->mesh->origin);
}

void psplat_target_free(psplat_target *target) {
    psplat_placed_free(&target->placed);
    *target = (psplat_target){0};
}

size_t psplat_target_elements(const psplat_target *target) {
    return target->mesh ? target->mesh->mesh->triangle_count : target->placed.splats.count;
}

psplat_result psplat_target_distance(const psplat_target *target, const double point[3],
                                     double *distance) {
    double there[3];
    along3(there, point, 1, target->shift);
    if (target->mesh) return psplat_distance_query(target->mesh->distance, there, 1, distance);
    const psplat_placed *placed = &target->placed;
    /* Most points are nearer than a quarter of the reach, which is four tolerances. */
    *distance = psplat_nearest_distance(placed->splats.regions, placed->splats.count,
                                        placed->locator, target->reach / 8, point);
    return PSPLAT_OK;
}

static int visit_limit(void *user, uint32_t splat) {
    psplat_look_limit(user, splat);
    return 0;
}

static int visit_add(void *user, uint32_t splat) {
    psplat_look_add(user, splat);
    return 0;
}

static void splat_normal(const psplat_target *target, const double point[3], const double normal[3],
                         double seen[3]) {
    const psplat_measured *splats = &target->placed.splats;
    psplat_look look = {.measured = splats, .reach = target->reach, .limit = -HUGE_VAL};
    memcpy(look.point, point, sizeof look.point);
    memcpy(look.normal, normal, sizeof look.normal);
    psplat_locator_visit(splats->locator, point, visit_limit, &look);
    psplat_locator_visit(splats->locator, point, visit_add, &look);
    memcpy(seen, look.blended, sizeof look.blended);
}

/* The normal at the nearest point: simplifiers keep no other correspondence. */
static psplat_result mesh_normal(const psplat_target *target, const double point[3],
                                 const double normal[3], double seen[3]) {
    const psplat_original *mesh = target->mesh;
    double there[3], from[3], to[3], nearest[3], weights[3];
    uint32_t triangle;
    float at[3];
    int meets;
    memset(seen, 0, 3 * sizeof *seen);
    along3(there, point, 1, target->shift);
    along3(from, there, target->reach, normal);
    along3(to, there, -target->reach, normal);
    psplat_result result = psplat_distance_meets(mesh->distance, from, to, &meets);
    if (result || !meets) return result;
    result = psplat_distance_nearest(mesh->distance, there, nearest, &triangle);
    if (result) return result;
    psplat_surface_barycentric(&mesh->surface, triangle, nearest, weights);
    psplat_surface_normal(&mesh->surface, triangle, weights, at);
    for (int k = 0; k < 3; ++k) seen[k] = (double)at[k];
    return PSPLAT_OK;
}

psplat_result psplat_target_normal(const psplat_target *target, const double point[3],
                                   const double normal[3], double seen[3]) {
    if (target->mesh) return mesh_normal(target, point, normal, seen);
    splat_normal(target, point, normal, seen);
    return PSPLAT_OK;
}

psplat_result psplat_target_points(const psplat_target *target, size_t count, uint64_t seed,
                                   psplat_cloud *cloud, psplat_error *error) {
    if (target->mesh)
        return psplat_cloud_of_mesh(target->mesh, target->shift, count, seed, cloud, error);
    const psplat_measured *splats = &target->placed.splats;
    return psplat_cloud_of_regions(splats->regions, splats->count, count, seed, cloud, error);
}
