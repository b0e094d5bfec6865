/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate_near.c - the check of the distance bound: whether all of a region lies within the
 * tolerance of the surface.
 *
 * In a draft, points of the outline are measured against the samples alone, which is quick. The
 * exact check measures points all over the region against the mesh or, where the whole region is to
 * be proven, its rim before that. Most of these are quickly found to be near their nearest sample
 * or its triangle; only for the others is the tree of the mesh or of its proxy searched.
 */
#include "base/region.h"
#include "base/vector.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

/* The points of a draft lie on two rings, which are the outline scaled by these factors. Chosen by
 * hand. */
enum { RINGS = 2 };
static const double ring_scales[RINGS] = {1, 0.6};

/* Samples that are looked at one by one only if one of them is near. */
enum { RUN = 16 };

/* ---- by samples ---------------------------------------------------------------------------- */

/* Returns whether one of some samples, the first of which is `first`, comes within the root of
 * most2 of a point. All are measured, so that compilers take several at once. */
static int is_any_within(const psplat_neighborhood *near, size_t first, size_t count,
                         const double q[3], double most2) {
    const double *x = near->along[0] + first, *y = near->along[1] + first;
    const double *z = near->along[2] + first;
    double distances2[RUN];
    int any = 0;
    for (size_t i = 0; i < count; ++i) {
        const double d[3] = {q[0] - x[i], q[1] - y[i], q[2] - z[i]};
        distances2[i] = dot3(d, d);
    }
    for (size_t i = 0; i < count; ++i) any |= distances2[i] <= most2;
    return any;
}

/* Returns whether a point of a region's surface (relative to the neighbourhood's origin) is no
 * farther than the greatest gap from a sample that is within the tolerance of the surface. Of a
 * flat splat it is the point that must be within the tolerance of the sample's tangent plane. A
 * curved one leaves these planes long before it leaves the surface between two samples. */
static int is_near_some(const psplat_fit_context *context, int curved, const double q[3]) {
    const psplat_scratch *s = context->scratch;
    double tolerance2 = context->limits->tolerance * context->limits->tolerance;
    double gap = PSPLAT_GREATEST_GAP * context->samples->spacing, gap2 = gap * gap;
    double most2 = tolerance2 + gap2;
    for (size_t i = 0; i < s->near_count; ++i) {
        size_t left = s->near_count - i;
        if (i % RUN == 0 && !is_any_within(&s->near, i, left < RUN ? left : RUN, q, most2)) {
            i += RUN - 1;
            continue;
        }
        double d[3];
        sub3(d, q, s->near.samples[i].p);
        double distance2 = dot3(d, d);
        if (distance2 > most2) continue;
        double height = curved ? s->uvh[i][2] : dot3(d, s->near.samples[i].n);
        double height2 = height * height;
        if (height2 <= tolerance2 && distance2 - height2 <= gap2) return 1;
    }
    return 0;
}

/* Finds the points of a region on the rings, relative to origin. Returns their number. */
static size_t outline_points(const psplat_region *region, const double origin[3],
                             double points[][3]) {
    double polygon[PSPLAT_OUTLINE][2], middle[2] = {0, 0};
    size_t count = psplat_region_polygon(region, 1, polygon, PSPLAT_OUTLINE), total = 0;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    for (int ring = 0; ring < RINGS; ++ring)
        for (size_t i = 0; i < count; ++i, ++total) {
            double uv[2];
            for (int k = 0; k < 2; ++k)
                uv[k] = middle[k] + ring_scales[ring] * (polygon[i][k] - middle[k]);
            psplat_region_point(region, uv, points[total]);
            sub3(points[total], points[total], origin);
        }
    return total;
}

static psplat_fit_status outline_nearness(const psplat_fit_context *context,
                                          const psplat_region *region) {
    double points[RINGS * PSPLAT_OUTLINE][3];
    size_t count = outline_points(region, context->scratch->near.origin, points);
    int curved = psplat_region_is_curved(region);
    for (size_t i = 0; i < count; ++i)
        if (!is_near_some(context, curved, points[i])) return PSPLAT_FIT_LEAVES_SURFACE;
    return PSPLAT_FIT_KEPT;
}

/* ---- by the mesh --------------------------------------------------------------------------- */

/* The samples around a region, in the cells of a grid over its parameters (u, v). Cells follow each
 * other row by row, so that neighbouring cells of a row are read in one go. */
enum { CELLS = 16 };
typedef struct cells {
    const psplat_region *region;        /* the widened one */
    const psplat_region *own;           /* that which is to be near */
    uint32_t first[CELLS * CELLS + 1];  /* the first sample of each cell */
    const psplat_celled_sample *sorted; /* nearest to the site first within a cell */
    uint32_t guess;                     /* for psplat_distance_is_within */
} cells;

/* Rounds down, as floor does, which is a call of a function on many machines. */
static int cell_along(double x) {
    double place = (x + 1) * (CELLS / 2.0);
    int truncated = (int)place;
    return truncated - (place < truncated);
}

/* Sorts the samples into the cells by their parameters, which the scratch holds. */
static void fill_cells(psplat_scratch *s, const psplat_region *region, cells *c) {
    uint32_t ends[CELLS * CELLS] = {0}, below = 0;
    for (size_t i = 0; i < s->near_count; ++i) {
        const double *uvh = s->uvh[i];
        s->cells[i] = PSPLAT_NONE;
        if (!(fabs(uvh[0]) < 1 && fabs(uvh[1]) < 1)) continue;
        s->cells[i] = (uint32_t)(cell_along(uvh[1]) * CELLS + cell_along(uvh[0]));
        ++ends[s->cells[i]];
    }
    *c = (cells){.region = region, .sorted = s->sorted, .guess = PSPLAT_NONE};
    for (size_t k = 0; k < CELLS * CELLS; ++k) {
        c->first[k] = below;
        below += ends[k];
        ends[k] = c->first[k];
    }
    c->first[CELLS * CELLS] = below;
    for (uint32_t i = 0; i < s->near_count; ++i) {
        if (s->cells[i] == PSPLAT_NONE) continue;
        psplat_celled_sample *to = &s->sorted[ends[s->cells[i]]++];
        memcpy(to->p, s->near.samples[i].p, sizeof to->p);
        to->near = i;
    }
}

/* Finds the sample nearest to a point in the cells around it, or the first one that is as near as
 * `enough`; PSPLAT_NONE where there is none. */
static uint32_t nearest_sample(const cells *c, const double uv[2], const double q[3], double enough,
                               double *distance2) {
    uint32_t nearest = PSPLAT_NONE;
    int column = cell_along(uv[0]), row = cell_along(uv[1]);
    int left = column > 0 ? column - 1 : 0, right = column + 2 < CELLS ? column + 2 : CELLS;
    *distance2 = HUGE_VAL;
    for (int y = row > 0 ? row - 1 : 0; y <= row + 1 && y < CELLS && left < right; ++y)
        for (uint32_t i = c->first[y * CELLS + left]; i < c->first[y * CELLS + right]; ++i) {
            double d2 = distance2_3(c->sorted[i].p, q);
            if (!(d2 < *distance2)) continue;
            *distance2 = d2, nearest = c->sorted[i].near;
            if (d2 <= enough) return nearest;
        }
    return nearest;
}

static int is_near_triangle(const psplat_fit_context *context, uint32_t triangle,
                            const double q[3]) {
    const psplat_mesh *mesh = context->surface->mesh;
    const uint32_t *vertices = mesh->triangles + 3 * (size_t)triangle;
    double tolerance = context->limits->tolerance;
    return point_triangle_distance2(q, mesh->positions + 3 * (size_t)vertices[0],
                                    mesh->positions + 3 * (size_t)vertices[1],
                                    mesh->positions + 3 * (size_t)vertices[2]) <=
           tolerance * tolerance;
}

/* Returns whether the triangle of a sample or one next to it is within the tolerance of a point. */
static int is_near_triangles(const psplat_fit_context *context, uint32_t sample,
                             const double q[3]) {
    uint32_t triangle = context->samples->triangles[sample];
    if (is_near_triangle(context, triangle, q)) return 1;
    for (size_t k = 0; k < 3; ++k) {
        uint32_t neighbor = context->surface->neighbors[3 * (size_t)triangle + k];
        if (neighbor != PSPLAT_NONE && is_near_triangle(context, neighbor, q)) return 1;
    }
    return 0;
}

/* Returns whether a sample connected with the site is as near to a point (relative to origin) as
 * one must be if this part of the surface is within the tolerance, given how far that one is which
 * was found by cells. Other parts of the surface do not count. */
static int is_near_sample(const psplat_fit_context *context, const double q[3],
                          double nearest_distance2) {
    const psplat_scratch *s = context->scratch;
    double most = context->limits->tolerance + PSPLAT_GREATEST_GAP * context->samples->spacing;
    if (nearest_distance2 <= most * most) return 1;
    for (size_t i = 0; i < s->near_count; ++i) {
        double d[3];
        sub3(d, q, s->near.samples[i].p);
        if (dot3(d, d) <= most * most) return 1;
    }
    return 0;
}

/* Returns whether a point of the widened region, at (u, v), is of the region itself. What lies
 * beyond a border of charts has no samples that are connected with the site. */
static int is_own(const cells *c, const double uv[2]) {
    return !c->own->chart_lines || psplat_region_contains(c->own, uv, 2, 0);
}

static psplat_fit_status point_nearness(const psplat_fit_context *context, cells *c,
                                        const double point[3]) {
    const psplat_limits *limits = context->limits;
    double uvh[3], q[3], distance2;
    int near;
    psplat_region_local(c->region, point, uvh);
    sub3(q, point, context->scratch->near.origin);
    double enough = limits->tolerance * limits->tolerance;
    uint32_t nearest = nearest_sample(c, uvh, q, enough, &distance2);
    if (distance2 <= enough) return PSPLAT_FIT_KEPT;
    if (nearest != PSPLAT_NONE &&
        is_near_triangles(context, context->scratch->near.samples[nearest].index, point))
        return PSPLAT_FIT_KEPT;
    if (!limits->distance || (is_own(c, uvh) && !is_near_sample(context, q, distance2)))
        return PSPLAT_FIT_LEAVES_SURFACE;
    if (psplat_limits_point_near(limits, point, &c->guess, &near)) return PSPLAT_FIT_MEMORY;
    return near ? PSPLAT_FIT_KEPT : PSPLAT_FIT_LEAVES_SURFACE;
}

/* Bounds the distance from all points of a region, which the points measured leave open. */
static psplat_fit_status proven_nearness(const psplat_limits *limits, const psplat_region *region) {
    int near;
    if (psplat_limits_region_near(limits, region, &near)) return PSPLAT_FIT_MEMORY;
    return near ? PSPLAT_FIT_KEPT : PSPLAT_FIT_LEAVES_SURFACE;
}

/* Measures the corners of a region's outline: of most regions that leave the surface, one of these
 * few points does. */
static psplat_fit_status corner_nearness(const psplat_fit_context *context, cells *c) {
    double polygon[PSPLAT_OUTLINE][2], point[3];
    size_t count = psplat_region_polygon(c->region, 1, polygon, PSPLAT_OUTLINE);
    psplat_fit_status status = PSPLAT_FIT_KEPT;
    for (size_t i = 0; i < count && !status; ++i) {
        psplat_region_point(c->region, polygon[i], point);
        status = point_nearness(context, c, point);
    }
    return status;
}

static psplat_fit_status mesh_nearness(const psplat_fit_context *context,
                                       const psplat_region *region) {
    double points[PSPLAT_REGION_POINTS][3];
    const psplat_region wide = psplat_region_beyond_charts(region);
    cells c;
    fill_cells(context->scratch, &wide, &c);
    c.own = region;
    psplat_fit_status status = corner_nearness(context, &c);
    if (status) return status;
    /* Before a proof only the rim is measured, which refuses most regions that are too large. A
     * flat region has no holes in it, but there may be some beyond borders of charts. */
    size_t count = context->limits->proven ? psplat_region_rim_points(&wide, points)
                   : wide.chart_lines      ? psplat_region_dense_points(&wide, points)
                                           : psplat_region_points(&wide, points);
    for (size_t i = 0; i < count && !status; ++i) status = point_nearness(context, &c, points[i]);
    return status || !context->limits->proven ? status : proven_nearness(context->limits, &wide);
}

psplat_fit_status psplat_evaluate_nearness(const psplat_fit_context *context,
                                           const psplat_region *region, int exact) {
    return exact ? mesh_nearness(context, region) : outline_nearness(context, region);
}
