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

/* What a material keeps of its textures: those that use the set of coordinates that splats keep. */
typedef struct psplat_kept_textures {
    psplat_texture textures[PSPLAT_TEXTURE_SLOTS]; /* image 0: baked, or none */
    double texels[2]; /* of the largest of them, per unit of s and of t, with its transform; 0 where
                         the material keeps none, so that its triangles have no coordinates */
    int repeats[2];   /* whole numbers by which coordinates may differ along s and t without a
                         change: 1 where all repeat, 2 where all repeat or mirror, 0: none */
} psplat_kept_textures;

/* A mesh whose textures are ready to be sampled. */
typedef struct psplat_appearance {
    const psplat_mesh *mesh;
    psplat_material_textures *material_textures; /* of each material of the mesh: what is baked */
    psplat_mipmap *mipmaps;
    size_t mipmap_count;
    double diameter; /* of the disc that textures are averaged over, in units of the mesh */
    /* Which values of psplat_baked_point vary over the mesh, since textures that are baked or
     * corner colours say so: */
    int has_color, has_normals, has_finish, has_emissive;
    /* The set of texture coordinates that splats keep, or PSPLAT_NONE: all textures are baked. */
    uint32_t kept_set;
    psplat_kept_textures
        *kept; /* of each material of the mesh; NULL where kept_set is PSPLAT_NONE */
} psplat_appearance;

/* Returns whether a texture of a material shows and can be read, so that splats may keep it. */
int psplat_appearance_may_keep(const psplat_mesh *mesh, const psplat_source_material *material,
                               psplat_texture_slot slot);

/* Returns the set of texture coordinates that splats of the mesh keep: that of the base colours of
 * most triangles, else that of the other textures of most, else PSPLAT_NONE. Only textures that
 * their material describes in psplat_material.textures can be kept. */
uint32_t psplat_appearance_set_to_keep(const psplat_mesh *mesh);

/* Decides which textures of the mesh's groups are kept (those of one set of coordinates; with
 * keeps_textures 0, none), and builds the mipmaps of the rest, which is baked. The mesh must live
 * as long. diameter may be changed later. Fails only with PSPLAT_ERROR_MEMORY; call
 * psplat_appearance_free also then. */
psplat_result psplat_appearance_build(const psplat_mesh *mesh, double diameter, int keeps_textures,
                                      psplat_appearance *appearance);
void psplat_appearance_free(psplat_appearance *appearance);

/* Returns the textures that a triangle's material keeps, or NULL where it keeps none, so that the
 * triangle has no coordinates. */
const psplat_kept_textures *psplat_appearance_kept(const psplat_appearance *appearance,
                                                   uint32_t triangle);

/* Returns whether the textures that a triangle's material keeps show the same at two places, in the
 * coordinates of the mesh: no channel of any image differs there by more than an eye sees. 0 where
 * an image has no pixels to tell. */
int psplat_appearance_shows_same(const psplat_appearance *appearance, uint32_t triangle,
                                 const double a[2], const double b[2]);

/* Makes the textures of a material of the mesh, the group-th or that of the whole mesh, those that
 * it keeps. */
void psplat_appearance_settle_textures(const psplat_appearance *appearance, size_t group,
                                       psplat_material *material);

/* The baked values at one point of a mesh. */
typedef struct psplat_baked_point {
    float color[4];    /* linear RGBA, relative to the base colour factor */
    float normal[3];   /* unit: that of the surface, turned by the normal map */
    float finish[3];   /* occlusion; roughness and metallic, relative to their factors */
    float emissive[3]; /* relative to the emissive factor */
} psplat_baked_point;

/* Bakes what of the appearance of the mesh is not kept: its mean over a disc of the appearance's
 * diameter around a point of a triangle, in the triangle's plane. normal is the unit normal of the
 * surface at the point. */
void psplat_appearance_bake(const psplat_appearance *appearance, uint32_t triangle,
                            const double barycentric[3], const float normal[3],
                            psplat_baked_point *baked);

/* Returns how many baked values there are on the surface, about: for each triangle the texels of
 * the largest texture that is baked there, or one if only its corners have colours. */
double psplat_appearance_texels(const psplat_appearance *appearance);

/* Returns the mean alpha over the same disc, times its factor, or 1 if the material of the triangle
 * has no mask. A base colour texture that is kept counts as opaque. */
double psplat_appearance_alpha(const psplat_appearance *appearance, uint32_t triangle,
                               const double barycentric[3]);

#endif
