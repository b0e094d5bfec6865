/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface.c - points of an analysed mesh: barycentric coordinates and interpolated normals.
 */
#include "features/surface.h"

#include "appearance/appearance.h"
#include "base/vector.h"
#include "mesh/mesh.h"

#include <stdlib.h>

void psplat_surface_free(psplat_surface *surface) {
    free(surface->face_normals);
    free(surface->face_areas);
    free(surface->neighbors);
    free(surface->creases);
    free(surface->patches);
    free(surface->corner_normals);
    free(surface->texcoord_slopes);
    *surface = (psplat_surface){0};
}

static void interpolate(const float *corners, size_t components, const double weights[3],
                        double *result) {
    for (size_t k = 0; k < components; ++k) {
        result[k] = 0;
        for (size_t corner = 0; corner < 3; ++corner)
            result[k] += weights[corner] * (double)corners[corner * components + k];
    }
}

void psplat_surface_barycentric(const psplat_surface *surface, uint32_t triangle, const double p[3],
                                double weights[3]) {
    const double *corner = psplat_mesh_corner(surface->mesh, triangle, 0);
    double sides[2][3], across[3], total = 0;
    /* A sliver's face normal may be that of the triangle beside it, along which it has no area. */
    for (int k = 0; k < 2; ++k)
        sub3(sides[k], psplat_mesh_corner(surface->mesh, triangle, k + 1), corner);
    cross3(across, sides[0], sides[1]);
    for (int k = 0; k < 3; ++k) {
        double a[3], b[3], c[3];
        sub3(a, psplat_mesh_corner(surface->mesh, triangle, (k + 1) % 3), p);
        sub3(b, psplat_mesh_corner(surface->mesh, triangle, (k + 2) % 3), p);
        cross3(c, a, b);
        double twice_area = dot3(c, across);
        weights[k] = twice_area > 0 ? twice_area : 0;
        total += weights[k];
    }
    for (int k = 0; k < 3; ++k) weights[k] = total > 0 ? weights[k] / total : 1.0 / 3.0;
}

void psplat_surface_normal(const psplat_surface *surface, uint32_t triangle,
                           const double barycentric[3], float normal[3]) {
    double sum[3];
    interpolate(surface->corner_normals + 9 * (size_t)triangle, 3, barycentric, sum);
    const double *n =
        normalize3(sum) > PSPLAT_LEAST_NORMAL ? sum : surface->face_normals + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k) normal[k] = (float)n[k];
}

int psplat_surface_has_texcoords(const psplat_surface *surface) {
    return surface->appearance && surface->appearance->kept;
}

const psplat_kept_textures *psplat_surface_kept_textures(const psplat_surface *surface,
                                                         uint32_t triangle) {
    return surface->appearance ? psplat_appearance_kept(surface->appearance, triangle) : NULL;
}

int psplat_surface_keeps_textures(const psplat_surface *surface, uint32_t triangle) {
    return psplat_surface_kept_textures(surface, triangle) != NULL;
}

void psplat_surface_texcoord(const psplat_surface *surface, uint32_t triangle,
                             const double barycentric[3], float texcoord[2]) {
    double at[2] = {0, 0};
    if (psplat_surface_keeps_textures(surface, triangle))
        interpolate(surface->mesh->corner_uvs[surface->appearance->kept_set] + 6 * (size_t)triangle,
                    2, barycentric, at);
    for (int k = 0; k < 2; ++k) texcoord[k] = (float)at[k];
}
