/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cloud.c - points all over a mesh or over splats.
 */
#include "cloud.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Sides of an outline; each line adds a corner to it. */
enum { LEAST_SIDES = 8, MOST_SIDES = 64, OUTLINE = MOST_SIDES + PSPLAT_MAX_CLIP_LINES };

void psplat_cloud_free(psplat_cloud *cloud) {
    free(cloud->points);
    free(cloud->normals);
    *cloud = (psplat_cloud){0};
}

static psplat_result allocate(psplat_cloud *cloud, size_t count, size_t normals,
                              psplat_error *error) {
    *cloud = (psplat_cloud){.points = malloc((count + 1) * 3 * sizeof *cloud->points),
                            .normals = malloc((normals + 1) * 3 * sizeof *cloud->normals)};
    if (cloud->points && cloud->normals) return PSPLAT_OK;
    psplat_cloud_free(cloud);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu points", count);
}

static void push(psplat_cloud *cloud, const double point[3]) {
    memcpy(cloud->points + 3 * cloud->count++, point, 3 * sizeof *point);
}

/* ---- of a mesh ------------------------------------------------------------------------------- */

/* Vertices of triangles, at most `most` of them. */
static int push_vertices(const psplat_mesh *mesh, size_t most, psplat_cloud *cloud) {
    uint8_t *used = calloc(mesh->vertex_count + 1, 1);
    size_t count = 0, met = 0;
    if (!used) return 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        count += !used[mesh->triangles[i]];
        used[mesh->triangles[i]] = 1;
    }
    size_t stride = most ? (count + most - 1) / most : count + 1;
    for (size_t v = 0; v < mesh->vertex_count; ++v)
        if (used[v] && met++ % stride == 0) push(cloud, mesh->positions + 3 * v);
    free(used);
    return 1;
}

psplat_result psplat_cloud_of_mesh(const psplat_original *mesh, const double shift[3], size_t count,
                                   uint64_t seed, psplat_cloud *cloud, psplat_error *error) {
    psplat_samples samples = {0};
    *cloud = (psplat_cloud){0};
    psplat_result result =
        psplat_samples_draw_uniform(&mesh->surface, count, seed, &samples, error);
    if (!result) result = allocate(cloud, samples.count + count, samples.count, error);
    if (!result) {
        cloud->count = cloud->uniform = samples.count;
        memcpy(cloud->points, samples.positions, 3 * samples.count * sizeof(double));
        memcpy(cloud->normals, samples.normals, 3 * samples.count * sizeof(float));
        if (!push_vertices(mesh->mesh, count, cloud))
            result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for vertices");
        for (size_t i = 0; i < cloud->count; ++i) mad3(cloud->points + 3 * i, -1, shift);
    }
    psplat_samples_free(&samples);
    if (result) psplat_cloud_free(cloud);
    return result;
}

/* ---- of splats ------------------------------------------------------------------------------- */

/* The outline around a region: its area is exact but for what the sides leave of the ellipse, which
 * sampling finds out. */
typedef struct outline {
    double corners[OUTLINE][2];
    size_t count;
    double areas[OUTLINE]; /* of the fan around corner 0, added up */
    double area;
} outline;

static void find_outline(const psplat_region *region, outline *o) {
    o->count = psplat_region_polygon(region, 0, o->corners, OUTLINE);
    o->area = 0;
    for (size_t i = 2; i < o->count; ++i) {
        const double *p = o->corners[0], *a = o->corners[i - 1], *b = o->corners[i];
        double twice = (a[0] - p[0]) * (b[1] - p[1]) - (a[1] - p[1]) * (b[0] - p[0]);
        o->area += max2(twice / 2, 0) * region->radius[0] * region->radius[1];
        o->areas[i] = o->area;
    }
}

static void region_point(const psplat_region *region, const double uv[2], double point[3]) {
    memcpy(point, region->center, 3 * sizeof(double));
    mad3(point, uv[0] * region->radius[0], region->u);
    mad3(point, uv[1] * region->radius[1], region->v);
}

/* A random point of the outline; those beyond the ellipse are left out. */
static void push_random(const psplat_region *region, const outline *o, uint64_t *random,
                        psplat_cloud *cloud) {
    double at = psplat_random_unit(random) * o->area, uv[2], point[3];
    size_t i = 2;
    while (i + 1 < o->count && o->areas[i] < at) ++i;
    const double *p = o->corners[0], *a = o->corners[i - 1], *b = o->corners[i];
    double s = sqrt(psplat_random_unit(random)), t = psplat_random_unit(random);
    for (int k = 0; k < 2; ++k) uv[k] = (1 - s) * p[k] + s * ((1 - t) * a[k] + t * b[k]);
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1) return;
    region_point(region, uv, point);
    push(cloud, point);
}

/* Each region gets its share of the points, up to one. */
static void push_all(const psplat_region *regions, size_t region_count, size_t count, double area,
                     uint64_t seed, psplat_cloud *cloud) {
    outline o;
    double below = psplat_random_unit(&seed), pushed = 0;
    for (size_t i = 0; i < region_count && area > 0; ++i) {
        find_outline(&regions[i], &o);
        below += o.area / area * (double)count;
        for (; pushed + 1 <= below && pushed < (double)count; ++pushed)
            push_random(&regions[i], &o, &seed, cloud);
    }
}

static void push_corners(const psplat_region *region, size_t sides, psplat_cloud *cloud) {
    double corners[OUTLINE][2], point[3];
    size_t count = psplat_region_polygon(region, 1, corners, sides + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i) {
        region_point(region, corners[i], point);
        push(cloud, point);
    }
}

psplat_result psplat_cloud_of_regions(const psplat_region *regions, size_t region_count,
                                      size_t count, uint64_t seed, psplat_cloud *cloud,
                                      psplat_error *error) {
    size_t sides = region_count ? count / region_count : 0;
    sides = sides < LEAST_SIDES ? LEAST_SIDES : sides > MOST_SIDES ? MOST_SIDES : sides;
    size_t most = count + region_count * (sides + 2 * PSPLAT_MAX_CLIP_LINES);
    psplat_result result = allocate(cloud, most, 0, error);
    if (result) return result;
    outline o;
    double area = 0;
    for (size_t i = 0; i < region_count; ++i) {
        find_outline(&regions[i], &o);
        area += o.area;
    }
    push_all(regions, region_count, count, area, seed, cloud);
    cloud->uniform = cloud->count;
    for (size_t i = 0; i < region_count; ++i) push_corners(&regions[i], sides, cloud);
    return PSPLAT_OK;
}
