/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * paint.h - what a mesh looks like at each of its points: textures, vertex colours, normal maps.
 * Everything is relative to the factors of the materials, which stay factors. Internal.
 */
#ifndef PSPLAT_PAINT_H
#define PSPLAT_PAINT_H

#include "texture.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The textures of one appearance; NULL: none, or none that could be read. */
typedef struct psplat_coat {
    const psplat_pyramid *base_color, *metallic_roughness, *normal, *occlusion, *emissive;
} psplat_coat;

typedef struct psplat_paint {
    const psplat_mesh *mesh;
    psplat_coat *coats; /* of each appearance */
    psplat_pyramid *pyramids;
    size_t pyramid_count;
    double diameter; /* that textures are averaged over: what a sample stands for */
    /* What differs between points of the mesh, by its file: */
    int has_color, has_normals, has_finish, has_emissive;
} psplat_paint;

/* Makes the textures that the mesh's groups use ready to be read. diameter may be set anew later.
 * MEMORY is the only failure; psplat_paint_free also then. */
psplat_result psplat_paint_build(const psplat_mesh *mesh, double diameter, psplat_paint *paint);
void psplat_paint_free(psplat_paint *paint);

/* The look of one place. */
typedef struct psplat_shade {
    float color[4];    /* linear RGBA, times the base colour factor */
    float normal[3];   /* unit: the surface's, turned by the normal map */
    float finish[3];   /* occlusion; roughness and metallic, times their factors */
    float emissive[3]; /* times the emissive factor */
} psplat_shade;

/* The mean look of the mesh over a disc about a point of a triangle, in the triangle's plane.
 * normal: the surface's there, unit. */
void psplat_paint_shade(const psplat_paint *paint, uint32_t triangle, const double barycentric[3],
                        const float normal[3], psplat_shade *shade);
/* The mean alpha there, with its factor; 1 where the triangle's appearance has no mask. */
double psplat_paint_alpha(const psplat_paint *paint, uint32_t triangle,
                          const double barycentric[3]);

#ifdef __cplusplus
}
#endif
#endif
