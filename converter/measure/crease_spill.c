/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_spill.c - whether what a splat shows beyond a crease can be seen to be wrong.
 *
 * From places along a crease inside a splat, its surface is followed away from the crease, square
 * to it, in steps of half a tolerance or more and to its very end. At each step the triangles
 * nearby are asked whether one of them is what the splat shows there. All triangles near a splat
 * are gathered once.
 */
#include "measure/crease_spill.h"

#include "base/block_boxes.h"
#include "base/region.h"
#include "base/vector.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The places on either side of a crossing's deepest point, and the most steps away from the crease
 * at each. Chosen by hand. */
enum { PLACES = 8, STEPS = 32, BISECTIONS = 24 };
/* The cosine of the angle from which an edge is a crease, unless the user chose another. */
static const double least_cosine = 0.8660254037844387;

/* The triangles near one splat. */
typedef struct spill {
    const psplat_surface *surface;
    const psplat_region *region;
    uint32_t material;
    double tolerance;
    psplat_block_boxes blocks; /* of the mesh's triangles */
    uint32_t *triangles;       /* room for all of the mesh */
    size_t count;
} spill;

static psplat_result begin(spill *s, const psplat_mesh *mesh) {
    psplat_result result = psplat_block_boxes_create(mesh->triangle_count, &s->blocks);
    s->triangles = malloc((mesh->triangle_count + 1) * sizeof *s->triangles);
    if (result || !s->triangles) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        psplat_block_boxes_add(&s->blocks, i / 3, mesh->positions + 3 * (size_t)mesh->triangles[i]);
    return PSPLAT_OK;
}

/* Gathers the triangles of the splat's material whose box meets the sphere around the splat. */
static void gather(spill *s) {
    const psplat_mesh *mesh = s->surface->mesh;
    double reach = psplat_region_reach(s->region) + s->tolerance;
    s->count = 0;
    for (size_t t = psplat_block_boxes_next(&s->blocks, 0, s->region->center, reach);
         t < mesh->triangle_count;
         t = psplat_block_boxes_next(&s->blocks, t + 1, s->region->center, reach)) {
        const uint32_t *corners = mesh->triangles + 3 * t;
        int meets = psplat_mesh_material_of(mesh, t) == s->material;
        for (size_t k = 0; k < 3 && meets; ++k) {
            double low = HUGE_VAL, high = -HUGE_VAL;
            for (int i = 0; i < 3; ++i) {
                double x = mesh->positions[3 * (size_t)corners[i] + k];
                low = min2(low, x), high = max2(high, x);
            }
            meets = low <= s->region->center[k] + reach && high >= s->region->center[k] - reach;
        }
        if (meets) s->triangles[s->count++] = (uint32_t)t;
    }
}

/* Returns whether a triangle within the tolerance of the splat's point at (u, v) faces its way. */
static int is_surface(const spill *s, const double uv[2]) {
    const psplat_mesh *mesh = s->surface->mesh;
    double point[3], normal[3];
    psplat_region_point(s->region, uv, point);
    psplat_region_normal(s->region, uv, normal);
    for (size_t i = 0; i < s->count; ++i) {
        const size_t t = s->triangles[i];
        const uint32_t *c = mesh->triangles + 3 * t;
        if (dot3(normal, s->surface->face_normals + 3 * t) < least_cosine) continue;
        if (point_triangle_distance2(
                point, mesh->positions + 3 * (size_t)c[0], mesh->positions + 3 * (size_t)c[1],
                mesh->positions + 3 * (size_t)c[2]) <= s->tolerance * s->tolerance)
            return 1;
    }
    return 0;
}

/* A direction away from a crease in a splat's plane, from a point of the crease. */
typedef struct ray {
    double uv[2], rate[2]; /* the point, and the change of u and v for each unit of length */
} ray;

static int keeps(const spill *s, const ray *r, double along, double uv[2]) {
    for (int k = 0; k < 2; ++k) uv[k] = r->uv[k] + along * r->rate[k];
    return psplat_region_contains(s->region, uv, 1, 0);
}

/* Returns whether the splat's last point along a ray, between a place that it keeps and one that it
 * does not, is surface. */
static int end_is_surface(const spill *s, const ray *r, double kept, double beyond) {
    double uv[2];
    for (int i = 0; i < BISECTIONS; ++i) {
        double middle = (kept + beyond) / 2;
        if (keeps(s, r, middle, uv))
            kept = middle;
        else
            beyond = middle;
    }
    keeps(s, r, kept, uv);
    return is_surface(s, uv);
}

/* Returns whether all that the splat shows beyond a point of a crease is surface, along a direction
 * away from the crease. */
static int hides_spill(const spill *s, const double point[3], const double outward[3]) {
    const psplat_region *region = s->region;
    double uvh[3], uv[2], rate[2] = {dot3(outward, region->u), dot3(outward, region->v)};
    double length = hypot(rate[0], rate[1]),
           step = max2(s->tolerance / 2, 2 * region->radius[0] / STEPS);
    if (!(length > 0)) return 1;
    psplat_region_local(region, point, uvh);
    ray r = {.uv = {uvh[0], uvh[1]}};
    for (int k = 0; k < 2; ++k) r.rate[k] = rate[k] / length / region->radius[k];
    for (int i = 0, was_kept = 0; i <= STEPS; ++i) {
        double along = s->tolerance + i * step;
        int is_kept = keeps(s, &r, along, uv);
        if (is_kept && !is_surface(s, uv)) return 0;
        if (was_kept && !is_kept && !end_is_surface(s, &r, along - step, along)) return 0;
        was_kept = is_kept;
    }
    return 1;
}

/* Returns whether what a splat shows beyond a crease can be seen to be wrong. */
static int is_seen(const spill *s, const psplat_crease_crossing *crossing) {
    const psplat_mesh *mesh = s->surface->mesh;
    size_t triangle = crossing->edge / 3, side = crossing->edge % 3;
    const double *a = mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + side];
    const double *b = mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + (side + 1) % 3];
    double along[3], outward[3], d[3];
    sub3(along, b, a);
    sub3(d, crossing->point, a);
    double length = normalize3(along), at = dot3(d, along);
    cross3(outward, along, s->surface->face_normals + 3 * triangle);
    for (int i = -PLACES; i <= PLACES; ++i) {
        double place = at + i * s->region->radius[0] / PLACES, point[3], uvh[3];
        if (place < 0 || place > length) continue;
        memcpy(point, a, sizeof point);
        mad3(point, place, along);
        psplat_region_local(s->region, point, uvh);
        if (fabs(uvh[2]) > s->tolerance || !psplat_region_contains(s->region, uvh, 1, 0)) continue;
        if (!hides_spill(s, point, outward)) return 1;
    }
    return 0;
}

psplat_result psplat_drop_unseen_crossings(const psplat_surface *surface,
                                           const psplat_measured_splats *measured,
                                           psplat_crease_crossing *crossings, size_t *count) {
    size_t kept = 0;
    spill s = {.surface = surface, .tolerance = measured->tolerance};
    if (!*count) return PSPLAT_OK;
    psplat_result result = begin(&s, surface->mesh);
    for (size_t i = 0; i < *count && !result; ++i) {
        if (!i || crossings[i].splat != crossings[i - 1].splat || !s.region) {
            s.region = &measured->regions[crossings[i].splat];
            s.material = measured->materials ? measured->materials[crossings[i].splat] : 0;
            gather(&s);
        }
        if (is_seen(&s, &crossings[i])) crossings[kept++] = crossings[i];
    }
    if (!result) *count = kept;
    psplat_block_boxes_free(&s.blocks);
    free(s.triangles);
    return result;
}
