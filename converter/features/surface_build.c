/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_build.c - the analysed mesh: neighbours, creases, smooth patches and corner normals.
 *
 * Any welded mesh is accepted. Edges of more than two triangles, or of two triangles that disagree
 * about their orientation, have no neighbour across and bound a patch. Normals are averaged around
 * each vertex from crease to crease (Thuermer, Wuethrich 1998).
 *
 * A normal that leans far away from its triangle's is turned back to a greatest angle. Planes are
 * fitted to samples whose normals lean by less than 60 degrees (base/covariance.c), and no splat on
 * the triangle covers what leans by more than 75.5 (fit/evaluate.h): such a triangle would take a
 * splat for each of its points.
 */
#include "features/surface_build.h"

#include "base/vector.h"
#include "features/authored_normals.h"
#include "features/crease.h"
#include "features/slivers.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The least cosine between the normal of a corner and its triangle's, at 58.7 degrees: a corner of
 * a cube that is shaded as a ball leans by 54.7. */
static const double least_corner_cosine = 0.52;
/* The least length, across the triangle's normal, of a normal that leans to some side; less is what
 * single precision leaves of one that faces backwards. */
static const double least_side = 1e-6;

/* Computes normals and areas of all triangles, and the diagonal of their bounding box. */
static void measure_faces(psplat_surface *surface) {
    const psplat_mesh *mesh = surface->mesh;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        double ab[3], ac[3], *normal = surface->face_normals + 3 * (size_t)t;
        const double *a = psplat_mesh_corner(mesh, t, 0);
        sub3(ab, psplat_mesh_corner(mesh, t, 1), a);
        sub3(ac, psplat_mesh_corner(mesh, t, 2), a);
        cross3(normal, ab, ac);
        surface->face_areas[t] = 0.5 * normalize3(normal);
        surface->area += surface->face_areas[t];
        for (int corner = 0; corner < 3; ++corner) {
            const double *p = psplat_mesh_corner(mesh, t, corner);
            for (int k = 0; k < 3; ++k) {
                if (p[k] < low[k]) low[k] = p[k];
                if (p[k] > high[k]) high[k] = p[k];
            }
        }
    }
    double extent[3];
    sub3(extent, high, low);
    surface->diagonal = length3(extent);
}

/* Finds the neighbours across edges. Triangles that disagree about their front are none. */
static psplat_result find_neighbors(psplat_surface *surface) {
    const uint32_t *triangles = surface->mesh->triangles;
    uint32_t *pairs = surface->neighbors; /* edges first, then the triangles that they belong to */
    psplat_result result = psplat_edge_pairs(surface->mesh, pairs, &surface->border_edges);
    if (result) return result;
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e) {
        uint32_t pair = pairs[e];
        if (pair == PSPLAT_NONE || pair < e) continue;
        int agree = triangles[e] != triangles[pair];
        pairs[e] = agree ? pair / 3 : PSPLAT_NONE;
        pairs[pair] = agree ? e / 3 : PSPLAT_NONE;
    }
    return PSPLAT_OK;
}

static double corner_angle(const psplat_mesh *mesh, uint32_t corner) {
    uint32_t triangle = corner / 3;
    int k = (int)(corner % 3);
    double a[3], b[3], c[3];
    sub3(a, psplat_mesh_corner(mesh, triangle, (k + 1) % 3), psplat_mesh_corner(mesh, triangle, k));
    sub3(b, psplat_mesh_corner(mesh, triangle, (k + 2) % 3), psplat_mesh_corner(mesh, triangle, k));
    cross3(c, a, b);
    return atan2(length3(c), dot3(a, b));
}

/* Returns the corner at the same vertex in the triangle across an edge of the corner's triangle, or
 * PSPLAT_NONE if the edge is a crease. */
static uint32_t corner_across(const psplat_surface *surface, uint32_t corner, uint32_t edge) {
    if (surface->creases[edge] == PSPLAT_BOUND_CREASE) return PSPLAT_NONE;
    uint32_t other = surface->neighbors[edge], vertex = surface->mesh->triangles[corner];
    for (uint32_t k = 0; k < 3; ++k)
        if (surface->mesh->triangles[3 * other + k] == vertex) return 3 * other + k;
    return PSPLAT_NONE;
}

static uint32_t corner_before(const psplat_surface *surface, uint32_t corner) {
    return corner_across(surface, corner, corner);
}

static uint32_t corner_after(const psplat_surface *surface, uint32_t corner) {
    return corner_across(surface, corner, corner % 3 ? corner - 1 : corner + 2);
}

/* Averages the normals of the fan of triangles around the vertex of a corner, from crease to
 * crease, weighted by their angles at the vertex. */
static void average_fan(psplat_surface *surface, uint8_t *done, uint32_t corner) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t begin = corner, before;
    while ((before = corner_before(surface, begin)) != PSPLAT_NONE && before != corner)
        begin = before;
    double sum[3] = {0, 0, 0};
    uint32_t c = begin;
    do {
        mad3(sum, corner_angle(mesh, c), surface->face_normals + 3 * (size_t)(c / 3));
        c = corner_after(surface, c);
    } while (c != PSPLAT_NONE && c != begin);
    int folded = normalize3(sum) < PSPLAT_LEAST_NORMAL;
    c = begin;
    do {
        const double *n = folded ? surface->face_normals + 3 * (size_t)(c / 3) : sum;
        for (int k = 0; k < 3; ++k)
            surface->corner_normals[3 * (size_t)c + (size_t)k] = (float)n[k];
        done[c] = 1;
        c = corner_after(surface, c);
    } while (c != PSPLAT_NONE && c != begin);
}

/* Turns the normal of a corner towards its triangle's where it leans too far away from that. */
static void limit_lean(psplat_surface *surface, size_t corner) {
    const double *face = surface->face_normals + 3 * (corner / 3);
    float *normal = surface->corner_normals + 3 * corner;
    double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    double along = dot3(n, face), least = least_corner_cosine;
    if (along >= least) return;
    mad3(n, -along, face);
    double across = normalize3(n) > least_side ? sqrt(1 - least * least) : 0;
    for (int k = 0; k < 3; ++k) n[k] = across * n[k] + least * face[k];
    normalize3(n);
    for (int k = 0; k < 3; ++k) normal[k] = (float)n[k];
}

/* Sets the corner normals: those of the file where they are credible, and averages elsewhere. None
 * leans too far. */
static psplat_result set_normals(psplat_surface *surface, const uint8_t *authored) {
    uint32_t corners = (uint32_t)(3 * surface->mesh->triangle_count);
    uint8_t *done = calloc(corners, 1);
    /* They are large, and not needed before, when creases need memory. */
    surface->corner_normals = malloc((size_t)corners * 3 * sizeof(float));
    if (!done || !surface->corner_normals) {
        free(done);
        return PSPLAT_ERROR_MEMORY;
    }
    for (uint32_t corner = 0; corner < corners; ++corner)
        if (!done[corner]) average_fan(surface, done, corner);
    free(done);
    for (size_t corner = 0; corner < corners; ++corner)
        if (authored[corner] & PSPLAT_AUTHORED_NORMAL)
            memcpy(surface->corner_normals + 3 * corner, surface->mesh->corner_normals + 3 * corner,
                   3 * sizeof(float));
    for (size_t corner = 0; corner < corners; ++corner) limit_lean(surface, corner);
    return PSPLAT_OK;
}

/* Finds neighbours, creases, patches and normals, after the faces have been measured. */
static psplat_result build(psplat_surface *surface, const psplat_patch_bounds *bounds) {
    uint8_t *authored = malloc(3 * surface->mesh->triangle_count);
    psplat_result result = authored ? find_neighbors(surface) : PSPLAT_ERROR_MEMORY;
    if (!result) result = psplat_slivers_settle(surface, bounds->sliver_height);
    if (!result) result = psplat_authored_read(surface, authored);
    if (!result) result = psplat_crease_find(surface, bounds, authored);
    if (!result) result = set_normals(surface, authored);
    free(authored);
    return result;
}

psplat_result psplat_surface_build(const psplat_mesh *mesh, double crease_angle,
                                   psplat_surface *surface, psplat_error *error) {
    const psplat_patch_bounds bounds = {.crease_angle = crease_angle};
    return psplat_surface_build_bounded(mesh, &bounds, surface, error);
}

psplat_result psplat_surface_build_bounded(const psplat_mesh *mesh,
                                           const psplat_patch_bounds *bounds,
                                           psplat_surface *surface, psplat_error *error) {
    size_t count = mesh->triangle_count;
    *surface = (psplat_surface){.mesh = mesh, .appearance = bounds->appearance};
    if (!count) return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "the mesh has no triangles");
    if (count > (PSPLAT_NONE - 1) / 3) /* edges are 3 times the triangle, plus 0, 1 or 2 */
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%zu triangles are too many", count);
    surface->face_normals = malloc(count * 3 * sizeof(double));
    surface->face_areas = malloc(count * sizeof(double));
    surface->neighbors = malloc(count * 3 * sizeof(uint32_t));
    surface->creases = calloc(count, 3);
    surface->patches = malloc(count * sizeof(uint32_t));
    int allocated = surface->face_normals && surface->face_areas && surface->neighbors &&
                    surface->creases && surface->patches;
    psplat_result result = allocated ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    if (!result) {
        measure_faces(surface);
        result = build(surface, bounds);
    }
    if (!result) return PSPLAT_OK;
    psplat_surface_free(surface);
    return psplat_fail(error, result, 0, "the surface of %zu triangles does not fit into memory",
                       count);
}
