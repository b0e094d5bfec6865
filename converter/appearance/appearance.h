/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * appearance.h - baking of textures, vertex colours and normal maps at points of a mesh.
 *
 * All baked values are relative to the factors of the materials, which stay factors.
 */
#ifndef PHONGSPLAT_APPEARANCE_APPEARANCE_H
#define PHONGSPLAT_APPEARANCE_APPEARANCE_H

#include "material/mipmap.h"
#include "mesh/mesh.h"

#include <phongsplat/splat.h>

/* The mipmaps of the textures of one material; NULL where it has none that could be read. */
typedef struct psplat_material_textures {
    const psplat_mipmap *base_color, *metallic_roughness, *normal, *occlusion, *emissive;
} psplat_material_textures;

/* A mesh whose textures are ready to be sampled. */
typedef struct psplat_appearance {
    const psplat_mesh *mesh;
    psplat_material_textures *material_textures; /* of each material of the mesh */
    psplat_mipmap *mipmaps;
    size_t mipmap_count;
    double diameter; /* of the disc that textures are averaged over, in units of the mesh */
    /* Which values of psplat_baked_point vary over the mesh, since textures or corner colours say
     * so: */
    int has_color, has_normals, has_finish, has_emissive;
} psplat_appearance;

/* Builds the mipmaps of the textures that the mesh's groups use. The mesh must live as long.
 * diameter may be changed later. Fails only with PSPLAT_ERROR_MEMORY; call psplat_appearance_free
 * also then. */
psplat_result psplat_appearance_build(const psplat_mesh *mesh, double diameter,
                                      psplat_appearance *appearance);
void psplat_appearance_free(psplat_appearance *appearance);

/* The baked values at one point of a mesh. */
typedef struct psplat_baked_point {
    float color[4];    /* linear RGBA, relative to the base colour factor */
    float normal[3];   /* unit: that of the surface, turned by the normal map */
    float finish[3];   /* occlusion; roughness and metallic, relative to their factors */
    float emissive[3]; /* relative to the emissive factor */
} psplat_baked_point;

/* Bakes the mean appearance of the mesh over a disc of the appearance's diameter around a point of
 * a triangle, in the triangle's plane. normal is the unit normal of the surface at the point. */
void psplat_appearance_bake(const psplat_appearance *appearance, uint32_t triangle,
                            const double barycentric[3], const float normal[3],
                            psplat_baked_point *baked);

/* Returns the mean alpha over the same disc, times its factor, or 1 if the material of the triangle
 * has no mask. */
double psplat_appearance_alpha(const psplat_appearance *appearance, uint32_t triangle,
                               const double barycentric[3]);

#endif
