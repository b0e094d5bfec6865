/* SPDX-License-Identifier: MIT
 *
 * show.h - from the tiles that were chosen to items: what is drawn, and how strongly.
 */
#ifndef PHONGSPLAT_TILESET_SHOW_H
#define PHONGSPLAT_TILESET_SHOW_H

#include "tileset/tile_view.h"
#include "tileset/tree.h"

/* Finds whether a tile is visible and how many pixels a unit of length has there, once a frame. */
void psplat_tile_look(psplat_tiles *tiles, const psplat_tile_camera *camera, uint32_t node);

/* Returns the error of a tile that was looked at, in pixels. */
double psplat_tile_pixels(const psplat_tiles *tiles, uint32_t node);

/* Makes the items of the tiles that were replaced in this frame and of those that fade out, and the
 * list of tiles that are drawn or stand above these, each after its parent. Errors: MEMORY. */
psplat_result psplat_tiles_show(psplat_tiles *tiles, const psplat_tile_camera *camera,
                                const psplat_tiles_view *view, psplat_error *error);

#endif
