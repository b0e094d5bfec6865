/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * chart_borders.c - the borders of charts: edges at which texture coordinates jump or mirror.
 *
 * A splat has one polynomial of texture coordinates, so it has to end where they do not go on.
 * Unlike a crease such an edge says nothing about the shape: normals are averaged across it, and it
 * counts neither as noise nor as the begin of a crease.
 */
#include "features/chart_borders.h"

#include "appearance/appearance.h"
#include "base/vector.h"
#include "features/crease_follow.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* How far, in texels, coordinates may differ across an edge inside a chart: what rounding in a file
 * does to them, and no more than filtering hides. Chosen by hand. */
static const double greatest_jump_texels = 0.5;

static uint32_t group_of(const psplat_surface *surface, uint32_t triangle) {
    return surface->mesh->groups ? surface->mesh->groups[triangle] : 0;
}

/* Finds the coordinates of a triangle's corners in texels. */
static void corners_in_texels(const psplat_surface *surface, uint32_t triangle,
                              const double texels[2], double corners[3][2]) {
    const float *uvs =
        surface->mesh->corner_uvs[surface->appearance->kept_set] + 6 * (size_t)triangle;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 2; ++k) corners[i][k] = (double)uvs[2 * i + k] * texels[k];
}

/* Returns 1 or -1 by the side of the image that a triangle shows, or 0 where it shows next to none
 * of it. */
static int sense_in_image(const double corners[3][2]) {
    double area = ((corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                   (corners[1][1] - corners[0][1]) * (corners[2][0] - corners[0][0])) /
                  2;
    return area > PSPLAT_LEAST_CHART_TEXELS ? 1 : area < -PSPLAT_LEAST_CHART_TEXELS ? -1 : 0;
}

/* Returns whether coordinates of two triangles differ at the vertex at a corner of the first one.
 */
static int jumps(const psplat_mesh *mesh, uint32_t triangle, const double here[3][2], size_t corner,
                 uint32_t other, const double there[3][2]) {
    uint32_t vertex = mesh->triangles[3 * (size_t)triangle + corner];
    for (size_t k = 0; k < 3; ++k)
        if (mesh->triangles[3 * (size_t)other + k] == vertex)
            return !(norm2(here[corner][0] - there[k][0], here[corner][1] - there[k][1]) <=
                     greatest_jump_texels);
    return 1;
}

/* Returns whether an edge that has a neighbour bounds charts. */
static int bounds_chart(const psplat_surface *surface, uint32_t edge) {
    uint32_t triangle = edge / 3, other = surface->neighbors[edge], group;
    double here[3][2], there[3][2];
    int keeps = psplat_surface_keeps_textures(surface, triangle);
    group = group_of(surface, triangle);
    if (keeps != psplat_surface_keeps_textures(surface, other)) return 1;
    if (!keeps) return 0;
    if (group != group_of(surface, other)) return 1;
    const double *texels = surface->appearance->kept[group].texels;
    corners_in_texels(surface, triangle, texels, here);
    corners_in_texels(surface, other, texels, there);
    for (size_t end = 0; end < 2; ++end)
        if (jumps(surface->mesh, triangle, (const double(*)[2])here, (edge % 3 + end) % 3, other,
                  (const double(*)[2])there))
            return 1;
    return sense_in_image((const double(*)[2])here) * sense_in_image((const double(*)[2])there) < 0;
}

/* Finds the change of a triangle's coordinates with the position on its plane. */
static void find_slopes(const psplat_surface *surface, uint32_t triangle, float slopes[6]) {
    const psplat_mesh *mesh = surface->mesh;
    const float *uvs = mesh->corner_uvs[surface->appearance->kept_set] + 6 * (size_t)triangle;
    double edges[2][3], across[2][3], twice_area = 2 * surface->face_areas[triangle];
    const double *normal = surface->face_normals + 3 * (size_t)triangle;
    for (int k = 0; k < 2; ++k)
        sub3(edges[k], psplat_mesh_corner(mesh, triangle, k + 1),
             psplat_mesh_corner(mesh, triangle, 0));
    /* The barycentric coordinates of corners 1 and 2 change by these. */
    cross3(across[0], edges[1], normal);
    cross3(across[1], normal, edges[0]);
    for (size_t k = 0; k < 2; ++k) {
        double slope[3] = {0, 0, 0};
        for (size_t i = 0; i < 2 && twice_area > 0; ++i)
            mad3(slope, ((double)uvs[2 * (i + 1) + k] - (double)uvs[k]) / twice_area, across[i]);
        for (size_t c = 0; c < 3; ++c) /* Those of slivers may not fit into a float. */
            slopes[3 * k + c] = fabs(slope[c]) < (double)FLT_MAX ? (float)slope[c] : 0;
    }
}

psplat_result psplat_chart_borders_mark(psplat_surface *surface) {
    uint32_t triangles = (uint32_t)surface->mesh->triangle_count;
    surface->chart_border_edges = 0;
    if (!psplat_surface_has_texcoords(surface)) return PSPLAT_OK;
    surface->texcoord_slopes = malloc(6 * (size_t)triangles * sizeof *surface->texcoord_slopes);
    if (!surface->texcoord_slopes) return PSPLAT_ERROR_MEMORY;
    for (uint32_t t = 0; t < triangles; ++t)
        find_slopes(surface, t, surface->texcoord_slopes + 6 * (size_t)t);
    for (uint32_t e = 0; e < 3 * triangles; ++e) {
        if (surface->neighbors[e] == PSPLAT_NONE || surface->creases[e]) continue;
        if (e / 3 > surface->neighbors[e] || !bounds_chart(surface, e)) continue;
        psplat_crease_set(surface, e, PSPLAT_BOUND_CHART);
        ++surface->chart_border_edges;
    }
    return PSPLAT_OK;
}
