/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_points.c - sample points on a mesh or on splats, uniform by area, with the corners added.
 * In the end they are sorted along a curve through space: the nearest triangle of a point is then
 * a good first guess for the next one, which spares most of a search for it.
 */
#include "compare/surface_points.h"

#include "base/morton.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "features/samples.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The sides of the polygon in place of an ellipse, and the least with bent lines; each clip line
 * adds one corner at most. */
enum {
    MIN_SIDES = 8,
    BENT_SIDES = PSPLAT_OUTLINE - PSPLAT_MAX_CLIP_LINES,
    MAX_SIDES = 64,
    MAX_CORNERS = MAX_SIDES + PSPLAT_MAX_CLIP_LINES
};

void psplat_surface_points_free(psplat_surface_points *cloud) {
    free(cloud->points);
    free(cloud->normals);
    *cloud = (psplat_surface_points){0};
}

static psplat_result allocate(psplat_surface_points *cloud, size_t count, size_t normals,
                              psplat_error *error) {
    *cloud = (psplat_surface_points){.points = malloc((count + 1) * 3 * sizeof *cloud->points),
                                     .normals = malloc((normals + 1) * 3 * sizeof *cloud->normals)};
    if (cloud->points && cloud->normals) return PSPLAT_OK;
    psplat_surface_points_free(cloud);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu points", count);
}

static void push(psplat_surface_points *cloud, const double point[3]) {
    memcpy(cloud->points + 3 * cloud->count++, point, 3 * sizeof *point);
}

/* ---- order ----------------------------------------------------------------------------------- */

/* The cells of the curve: 64 along each axis. A surface meets some 20,000 of them, so that about
 * ten of the points of a comparison share one. */
enum { DROPPED_BITS = 12, CELLS = 1 << (30 - DROPPED_BITS) };

/* Stores the cell of each point of begin ... end, in a box around these. */
static void find_cells(const psplat_surface_points *cloud, size_t begin, size_t end,
                       uint32_t *cells) {
    double low[3], high[3], middle[3], half = 0;
    for (int k = 0; k < 3; ++k) low[k] = HUGE_VAL, high[k] = -HUGE_VAL;
    for (size_t i = begin; i < end; ++i)
        for (int k = 0; k < 3; ++k) {
            low[k] = min2(low[k], cloud->points[3 * i + (size_t)k]);
            high[k] = max2(high[k], cloud->points[3 * i + (size_t)k]);
        }
    for (int k = 0; k < 3; ++k) {
        middle[k] = (low[k] + high[k]) / 2;
        half = max2(half, (high[k] - low[k]) / 2);
    }
    for (size_t i = begin; i < end; ++i)
        cells[i - begin] = psplat_morton_code(cloud->points + 3 * i, middle, half) >> DROPPED_BITS;
}

/* Stores where each of count points goes, so that their cells rise and points of a cell keep their
 * order. starts has room for all cells. */
static void find_places(const uint32_t *cells, size_t count, size_t *starts, size_t *places) {
    size_t sum = 0;
    memset(starts, 0, CELLS * sizeof *starts);
    for (size_t i = 0; i < count; ++i) ++starts[cells[i]];
    for (size_t c = 0; c < CELLS; ++c) {
        size_t size = starts[c];
        starts[c] = sum;
        sum += size;
    }
    for (size_t i = 0; i < count; ++i) places[i] = starts[cells[i]]++;
}

/* Sorts the points begin ... end, with their normals where they have some, along a Morton curve. */
static psplat_result arrange_range(psplat_surface_points *cloud, size_t begin, size_t end,
                                   int has_normals) {
    size_t count = end - begin;
    uint32_t *cells = malloc((count + 1) * sizeof *cells);
    size_t *starts = malloc(CELLS * sizeof *starts), *places = malloc((count + 1) * sizeof *places);
    double *points = malloc((count + 1) * 3 * sizeof *points);
    float *normals = malloc((count + 1) * 3 * sizeof *normals);
    int ok = cells && starts && places && points && normals;
    if (ok) {
        find_cells(cloud, begin, end, cells);
        find_places(cells, count, starts, places);
        for (size_t i = 0; i < count; ++i)
            memcpy(points + 3 * places[i], cloud->points + 3 * (begin + i), 3 * sizeof *points);
        memcpy(cloud->points + 3 * begin, points, 3 * count * sizeof *points);
        for (size_t i = 0; i < count && has_normals; ++i)
            memcpy(normals + 3 * places[i], cloud->normals + 3 * (begin + i), 3 * sizeof *normals);
        if (has_normals) memcpy(cloud->normals + 3 * begin, normals, 3 * count * sizeof *normals);
    }
    free(cells);
    free(starts);
    free(places);
    free(points);
    free(normals);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Sorts both kinds of points, each for itself. The cloud is freed where that fails. */
static psplat_result arrange(psplat_surface_points *cloud, int has_normals, psplat_error *error) {
    psplat_result result = arrange_range(cloud, 0, cloud->uniform, has_normals);
    if (!result) result = arrange_range(cloud, cloud->uniform, cloud->count, 0);
    if (!result) return PSPLAT_OK;
    size_t count = cloud->count;
    psplat_surface_points_free(cloud);
    return psplat_fail(error, result, 0, "no memory to sort %zu points", count);
}

/* ---- points of a mesh ------------------------------------------------------------------------ */

/* Adds the vertices that triangles use, or every n-th of them so that there are at most `most`. */
static int push_vertices(const psplat_mesh *mesh, size_t most, psplat_surface_points *cloud) {
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

psplat_result psplat_surface_points_of_mesh(const psplat_source_mesh *mesh, const double shift[3],
                                            size_t count, uint64_t seed,
                                            psplat_surface_points *cloud, psplat_error *error) {
    psplat_samples samples = {0};
    *cloud = (psplat_surface_points){0};
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
    if (!result) return arrange(cloud, 1, error);
    psplat_surface_points_free(cloud);
    return result;
}

/* ---- points of splats ------------------------------------------------------------------------ */

/* A convex polygon around a region, with a triangle fan for sampling by area. Random points between
 * the region and the polygon's sides are rejected. */
typedef struct outline {
    double corners[MAX_CORNERS][2];
    size_t count;
    double areas[MAX_CORNERS]; /* running sums of the fan around corner 0 */
    double stretch;            /* greatest ratio of an area on the surface to that in the plane */
    double area;               /* of the polygon, times stretch */
} outline;

/* Returns how much greater an area of the surface is than that below it in the plane. */
static double stretch_at(const psplat_region *region, const double uv[2]) {
    double slope[2];
    psplat_region_slope(region, uv, slope);
    return sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

/* Puts a straight line behind each clip line that bulges in, so that the outline is convex. */
static psplat_region convex_hull(const psplat_region *region) {
    psplat_region hull = *region;
    for (uint32_t i = 0; i < hull.line_count; ++i) {
        if (!(hull.bends[i] > 0)) continue;
        double square = hull.lines[i][0] * hull.lines[i][0] + hull.lines[i][1] * hull.lines[i][1],
               bend = hull.bends[i] * square;
        /* It is least far back where it meets the circle, which is quadratic in that. */
        double root = sqrt(max2(1 + hull.bends[i] * (2 * hull.lines[i][2] + bend), 0));
        hull.lines[i][2] = (2 * hull.lines[i][2] + bend) / (1 + root);
        hull.bends[i] = 0;
    }
    return hull;
}

static void find_outline(const psplat_region *region, outline *o) {
    psplat_region hull = convex_hull(region);
    o->count = psplat_region_polygon(&hull, 0, o->corners, MAX_CORNERS);
    o->area = 0;
    o->stretch = 1; /* The slope is linear, so that its length is greatest at a corner. */
    for (size_t i = 0; i < o->count; ++i)
        o->stretch = max2(o->stretch, stretch_at(region, o->corners[i]));
    for (size_t i = 2; i < o->count; ++i) {
        const double *p = o->corners[0], *a = o->corners[i - 1], *b = o->corners[i];
        double twice = (a[0] - p[0]) * (b[1] - p[1]) - (a[1] - p[1]) * (b[0] - p[0]);
        o->area += max2(twice / 2, 0) * region->radius[0] * region->radius[1];
        o->areas[i] = o->area;
    }
    o->area *= o->stretch;
}

/* Returns whether a region has a line whose outline is not that of the region itself. */
static int has_bends(const psplat_region *region) {
    for (uint32_t i = 0; i < region->line_count; ++i)
        if (region->bends[i] != 0) return 1;
    return 0;
}

/* Adds a random point of the outline unless it is outside the region; where the surface is less
 * stretched than elsewhere, also by chance. */
static void push_random(const psplat_region *region, const outline *o, uint64_t *random,
                        psplat_surface_points *cloud) {
    double at = psplat_random_unit(random) * (o->area / o->stretch), uv[2], point[3];
    size_t i = 2;
    while (i + 1 < o->count && o->areas[i] < at) ++i;
    const double *p = o->corners[0], *a = o->corners[i - 1], *b = o->corners[i];
    double s = sqrt(psplat_random_unit(random)), t = psplat_random_unit(random);
    for (int k = 0; k < 2; ++k) uv[k] = (1 - s) * p[k] + s * ((1 - t) * a[k] + t * b[k]);
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1) return;
    if (has_bends(region) && !psplat_region_contains(region, uv, 1, 0)) return;
    if (o->stretch > 1 && psplat_random_unit(random) * o->stretch > stretch_at(region, uv)) return;
    psplat_region_point(region, uv, point);
    push(cloud, point);
}

/* Gives each region points in proportion to its area, rounded up or down by one at most. */
static void push_all(const psplat_region *regions, size_t region_count, size_t count, double area,
                     uint64_t seed, psplat_surface_points *cloud) {
    outline o;
    double below = psplat_random_unit(&seed), pushed = 0;
    for (size_t i = 0; i < region_count && area > 0; ++i) {
        find_outline(&regions[i], &o);
        below += o.area / area * (double)count;
        for (; pushed + 1 <= below && pushed < (double)count; ++pushed)
            push_random(&regions[i], &o, &seed, cloud);
    }
}

static void push_corners(const psplat_region *region, size_t sides, psplat_surface_points *cloud) {
    double corners[MAX_CORNERS][2], point[3];
    if (has_bends(region) && sides < BENT_SIDES) sides = BENT_SIDES;
    size_t count = psplat_region_polygon(region, 1, corners, sides + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i) {
        psplat_region_point(region, corners[i], point);
        push(cloud, point);
    }
}

psplat_result psplat_surface_points_of_regions(const psplat_region *regions, size_t region_count,
                                               size_t count, uint64_t seed,
                                               psplat_surface_points *cloud, psplat_error *error) {
    size_t sides = region_count ? count / region_count : 0;
    sides = sides < MIN_SIDES ? MIN_SIDES : sides > MAX_SIDES ? MAX_SIDES : sides;
    size_t corners = (sides < BENT_SIDES ? BENT_SIDES : sides) + 2 * PSPLAT_MAX_CLIP_LINES;
    size_t most = count + region_count * corners;
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
    return arrange(cloud, 0, error);
}
