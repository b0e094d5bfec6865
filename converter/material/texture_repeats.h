/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_repeats.h - how far texture coordinates may move without changing what a material shows.
 */
#ifndef PHONGSPLAT_MATERIAL_TEXTURE_REPEATS_H
#define PHONGSPLAT_MATERIAL_TEXTURE_REPEATS_H

#include <phongsplat/splat.h>

/* Stores how far the coordinates of the image move along s and t where those before the texture's
 * transform grow by 1 along an axis: 0 for s, 1 for t. */
void psplat_texture_move(const psplat_texture *texture, int axis, double move[2]);

/* Returns the whole number of units of an axis by which texture coordinates may be moved without a
 * change of any of the textures: 1 where all of them repeat, 2 where some mirror, or their
 * transforms ask for it, and 0 where there is none. Textures without an image are passed over. */
int psplat_textures_repeat(const psplat_texture textures[PSPLAT_TEXTURE_SLOTS], int axis);

#endif
