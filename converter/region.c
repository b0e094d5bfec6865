/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region.c - a convex part of a plane, and a walk over the surface above it.
 *
 * The walk is what makes the tolerance a statement about the surface rather than about samples: it
 * meets every triangle that the region's column holds and that can be reached without crossing a
 * crease, and clips each exactly, so that greatest heights are those of the surface itself.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Sides of the polygon around the unit circle that a walk clips by (2 % larger in area), of the
 * finest outline, and room for its corners: each line adds one, and rounding may add some. */
enum { SIDES = 16, OUTLINE_SIDES = 64, CORNERS = OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES + 4 };

void psplat_region_local(const psplat_region *region, const double point[3], double uvh[3]) {
    double d[3];
    sub3(d, point, region->center);
    uvh[0] = dot3(d, region->u) / region->radius[0];
    uvh[1] = dot3(d, region->v) / region->radius[1];
    uvh[2] = dot3(d, region->n);
}

int psplat_region_contains(const psplat_region *region, const double uv[2], double scale,
                           double slack) {
    if (uv[0] * uv[0] + uv[1] * uv[1] > scale * scale) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        if (line[0] * uv[0] + line[1] * uv[1] + line[2] < -slack) return 0;
    }
    return 1;
}

/* ---- polygons ------------------------------------------------------------------------------ */

typedef double corner[3]; /* u, v, height */

static double line_distance(const double line[3], const double p[2]) {
    return line[0] * p[0] + line[1] * p[1] + line[2];
}

/* Keeps the part of a polygon with line >= 0 (Sutherland, Hodgman 1974). Returns its corners. */
static size_t clip_polygon(const double line[3], corner *in, size_t count, corner *out) {
    size_t result = 0;
    /* Rounding may make a corner more of a sliver than convexity allows: it does without. */
    for (size_t i = 0; i < count && result + 2 <= CORNERS; ++i) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        double da = line_distance(line, a), db = line_distance(line, b);
        if (da >= 0) memcpy(out[result++], a, sizeof(corner));
        if ((da >= 0) == (db >= 0)) continue;
        double t = da / (da - db);
        for (int k = 0; k < 3; ++k) out[result][k] = a[k] + t * (b[k] - a[k]);
        ++result;
    }
    return result;
}

/* How a polygon's corners lie to a line: 1 all kept, -1 none, 0 both. */
static int line_side(const double line[3], corner *polygon, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) kept += line_distance(line, polygon[i]) >= 0;
    return kept == count ? 1 : kept ? 0 : -1;
}

static size_t clip_step(const double line[3], corner *polygon, size_t count) {
    int side = line_side(line, polygon, count);
    if (side) return side > 0 ? count : 0;
    corner clipped[CORNERS];
    count = clip_polygon(line, polygon, count, clipped);
    memcpy(polygon, clipped, count * sizeof(corner));
    return count;
}

/* Outward directions of the polygon's sides: multiples of 22.5 degrees. */
#define C1 0.92387953251128674
#define C2 0.70710678118654752
#define C3 0.38268343236508977
static const double circle_sides[SIDES][2] = {
    {1, 0},  {C1, C3},   {C2, C2},   {C3, C1},   {0, 1},  {-C3, C1}, {-C2, C2}, {-C1, C3},
    {-1, 0}, {-C1, -C3}, {-C2, -C2}, {-C3, -C1}, {0, -1}, {C3, -C1}, {C2, -C2}, {C1, -C3}};
#undef C1
#undef C2
#undef C3

static size_t clip_circle(corner *polygon, size_t count) {
    int inside = 1;
    double low[2] = {2, 2}, high[2] = {-2, -2};
    for (size_t i = 0; i < count; ++i) {
        inside &= polygon[i][0] * polygon[i][0] + polygon[i][1] * polygon[i][1] <= 1;
        for (int k = 0; k < 2; ++k) {
            low[k] = min2(low[k], polygon[i][k]);
            high[k] = max2(high[k], polygon[i][k]);
        }
    }
    if (low[0] > 1 || low[1] > 1 || high[0] < -1 || high[1] < -1) return 0;
    for (size_t i = 0; i < SIDES && count && !inside; ++i) {
        const double line[3] = {-circle_sides[i][0], -circle_sides[i][1], 1};
        count = clip_step(line, polygon, count);
    }
    return count;
}

static size_t clip_region(const psplat_region *region, corner *polygon, size_t count) {
    for (uint32_t i = 0; i < region->line_count && count; ++i)
        count = clip_step(region->lines[i], polygon, count);
    return count ? clip_circle(polygon, count) : 0;
}

static double polygon_area(corner *polygon, size_t count) {
    double twice = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[i + 1 < count ? i + 1 : 0];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return 0.5 * twice;
}

size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity) {
    corner corners[CORNERS], clipped[CORNERS];
    size_t count = capacity - PSPLAT_MAX_CLIP_LINES;
    if (count > OUTLINE_SIDES) count = OUTLINE_SIDES;
    double radius = inscribed ? 1 : 1 / cos(3.141592653589793 / (double)count);
    for (size_t i = 0; i < count; ++i) {
        /* Circumscribed, its sides touch the circle where those of a walk do. */
        double angle = 6.283185307179586 * ((double)i + (inscribed ? 0 : 0.5)) / (double)count;
        corners[i][0] = radius * cos(angle), corners[i][1] = radius * sin(angle), corners[i][2] = 0;
    }
    for (uint32_t i = 0; i < region->line_count && count; ++i) {
        count = clip_polygon(region->lines[i], corners, count, clipped);
        memcpy(corners, clipped, count * sizeof(corner));
    }
    for (size_t i = 0; i < count; ++i) polygon[i][0] = corners[i][0], polygon[i][1] = corners[i][1];
    return count;
}

size_t psplat_region_points(const psplat_region *region, double (*points)[3]) {
    double polygon[CORNERS][2], middle[2] = {0, 0};
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    for (size_t i = 0; i < 2 * count + 1; ++i) {
        double t = i < count ? 1 : i < 2 * count ? 0.5 : 0;
        const double *corner = polygon[i % count];
        memcpy(points[i], region->center, sizeof points[i]);
        mad3(points[i], (middle[0] + t * (corner[0] - middle[0])) * region->radius[0], region->u);
        mad3(points[i], (middle[1] + t * (corner[1] - middle[1])) * region->radius[1], region->v);
    }
    return count ? 2 * count + 1 : 0;
}

psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near) {
    double points[PSPLAT_REGION_POINTS][3], distances[PSPLAT_REGION_POINTS];
    *near = 1;
    if (!distance) return PSPLAT_OK;
    size_t count = psplat_region_points(region, points);
    psplat_result result = psplat_distance_query(distance, &points[0][0], count, distances);
    for (size_t i = 0; i < count && !result; ++i) *near &= distances[i] <= tolerance;
    return result;
}

/* ---- walk ---------------------------------------------------------------------------------- */

void psplat_walk_free(psplat_walk *walk) {
    free(walk->stamps);
    free(walk->triangles);
    free(walk->segments);
    *walk = (psplat_walk){0};
}

static void extend(double range[2], corner *polygon, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        range[0] = min2(range[0], polygon[i][2]);
        range[1] = max2(range[1], polygon[i][2]);
    }
}

static int push_triangle(psplat_walk *walk, uint32_t triangle) {
    if (walk->triangle_count == walk->triangle_capacity) {
        size_t capacity = 2 * walk->triangle_capacity + 256;
        uint32_t *triangles = realloc(walk->triangles, capacity * sizeof *triangles);
        if (!triangles) return 0;
        walk->triangles = triangles;
        walk->triangle_capacity = capacity;
    }
    walk->triangles[walk->triangle_count++] = triangle;
    return 1;
}

static int push_segment(psplat_walk *walk, const psplat_segment *segment) {
    if (walk->segment_count == walk->segment_capacity) {
        size_t capacity = 2 * walk->segment_capacity + 64;
        psplat_segment *segments = realloc(walk->segments, capacity * sizeof *segments);
        if (!segments) return 0;
        walk->segments = segments;
        walk->segment_capacity = capacity;
    }
    walk->segments[walk->segment_count++] = *segment;
    return 1;
}

static int walk_begin(psplat_walk *walk, const psplat_surface *surface, uint32_t seed) {
    if (!walk->stamps) walk->stamps = calloc(surface->mesh->triangle_count, sizeof(uint32_t));
    if (!walk->stamps) return 0;
    if (++walk->stamp == 0) { /* wrapped around: forget all */
        memset(walk->stamps, 0, surface->mesh->triangle_count * sizeof(uint32_t));
        walk->stamp = 1;
    }
    walk->triangle_count = walk->segment_count = 0;
    walk->height[0] = walk->crease_height[0] = HUGE_VAL;
    walk->height[1] = walk->crease_height[1] = -HUGE_VAL;
    walk->area = 0;
    walk->aborted = 0;
    walk->stamps[seed] = walk->stamp;
    return push_triangle(walk, seed);
}

/* The part of crease edge k inside the region becomes a segment. */
static int meet_crease(psplat_walk *walk, const psplat_surface *surface,
                       const psplat_region *region, uint32_t triangle, uint32_t k,
                       corner corners[3]) {
    uint32_t next = (k + 1) % 3;
    corner edge[CORNERS];
    memcpy(edge[0], corners[k], sizeof(corner));
    memcpy(edge[1], corners[next], sizeof(corner));
    /* A polygon of two corners clips like any other. */
    size_t count = clip_region(region, edge, 2);
    if (count < 2) return 1;
    extend(walk->crease_height, edge, count);
    double along[2] = {corners[next][0] - corners[k][0], corners[next][1] - corners[k][1]};
    size_t first = 0, last = 0;
    for (size_t i = 1; i < count; ++i) {
        double t = along[0] * edge[i][0] + along[1] * edge[i][1];
        if (t < along[0] * edge[first][0] + along[1] * edge[first][1]) first = i;
        if (t > along[0] * edge[last][0] + along[1] * edge[last][1]) last = i;
    }
    const uint32_t *vertices = surface->mesh->triangles + 3 * (size_t)triangle;
    psplat_segment segment = {.vertex = {vertices[k], vertices[next]},
                              .across = surface->neighbors[3 * triangle + k]};
    memcpy(segment.a, edge[first], sizeof segment.a);
    memcpy(segment.b, edge[last], sizeof segment.b);
    return push_segment(walk, &segment);
}

/* Measures one triangle and queues the neighbours that its part inside the region may touch. */
static int walk_triangle(psplat_walk *walk, const psplat_surface *surface,
                         const psplat_region *region, uint32_t triangle) {
    corner corners[3], polygon[CORNERS];
    for (uint32_t k = 0; k < 3; ++k) {
        uint32_t v = surface->mesh->triangles[3 * (size_t)triangle + k];
        psplat_region_local(region, surface->mesh->positions + 3 * (size_t)v, corners[k]);
    }
    memcpy(polygon, corners, sizeof corners);
    size_t count = clip_region(region, polygon, 3);
    if (!count) return 0;
    extend(walk->height, polygon, count);
    walk->area += polygon_area(polygon, count);
    for (uint32_t k = 0; k < 3; ++k) {
        uint32_t edge = 3 * triangle + k, next = surface->neighbors[edge];
        if (surface->creases[edge]) {
            if (!meet_crease(walk, surface, region, triangle, k, corners)) walk->failed = 1;
        } else if (walk->stamps[next] != walk->stamp) {
            walk->stamps[next] = walk->stamp;
            if (!push_triangle(walk, next)) walk->failed = 1;
        }
    }
    return 1;
}

void psplat_walk_surface(psplat_walk *walk, const psplat_surface *surface,
                         const psplat_region *region, uint32_t seed_triangle, double range) {
    if (!walk_begin(walk, surface, seed_triangle)) {
        walk->failed = 1;
        return;
    }
    size_t kept = 0;
    for (size_t i = 0; i < walk->triangle_count && !walk->failed && !walk->aborted; ++i) {
        if (walk_triangle(walk, surface, region, walk->triangles[i]))
            walk->triangles[kept++] = walk->triangles[i];
        walk->aborted = walk->height[1] - walk->height[0] > range &&
                        (region->line_count || !walk->segment_count);
    }
    walk->triangle_count = kept;
}
