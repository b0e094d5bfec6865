/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_sampling.h - filtered texture lookup: trilinear and anisotropic.
 */
#ifndef PHONGSPLAT_MATERIAL_TEXTURE_SAMPLING_H
#define PHONGSPLAT_MATERIAL_TEXTURE_SAMPLING_H

#include "material/mipmap.h"
#include "material/source_materials.h"

/* Converts texture coordinates of a mesh to those of the image (KHR_texture_transform), which are
 * 0 ... 1 across it before wrapping. A transform of six zeros is the identity. */
void psplat_texture_transform(const psplat_texture_info *texture, const double uv[2], double st[2]);

/* Stores the mean of a texture, in linear light, over the ellipse about st in image coordinates.
 * axes[0] and axes[1] are conjugate half axes of the ellipse. Both may be 0; the texture is then
 * magnified by the filter of its sampler. The mipmap has at least one level. */
void psplat_texture_average(const psplat_texture_info *texture, const psplat_mipmap *mipmap,
                            const double st[2], const double axes[2][2], float rgba[4]);

/* Stores the values of a texture at st in image coordinates as the image stores them, 0 ... 1: no
 * light, but what an eye tells apart. Magnified, as by the filter of its sampler. The image has
 * pixels. */
void psplat_texture_stored(const psplat_texture_info *texture, const double st[2], float rgba[4]);

#endif
