/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tileset.h - tilesets: a tree of tiles as JSON of 3D Tiles 1.1 (OGC 22-025r4).
 */
#ifndef PHONGSPLAT_TILES_TILESET_H
#define PHONGSPLAT_TILES_TILESET_H

#include <phongsplat/splat.h>

#include "tiles/tile.h"

#include <stddef.h>

/* About the most tiles of one file of JSON, which names further files for what is below. */
enum { PSPLAT_MOST_TILES_OF_FILE = 1000 };

/* Makes a tree of tiles: the parent of a tile is, of the tiles of coarser levels whose cells hold
 * its cell, the one of the finest level. Sorts them by level and path, and raises the errors of
 * parents to those of their children. parents has room for count, and gets the index of each
 * tile's parent, and SIZE_MAX for the root, which comes first. Errors: ARGUMENT (no tile or several
 * without a parent, or two of one cell and level), MEMORY. */
psplat_result psplat_tileset_arrange(psplat_tile *tiles, size_t count, size_t *parents,
                                     psplat_error *error);

/* Takes a file of a tileset: its name, relative to the first one, and its text. */
typedef psplat_result psplat_take_tileset(void *user, const char *name, const char *text,
                                          size_t size, psplat_error *error);

/* Writes tiles that are arranged, with these parents, as "tileset.json" and further files
 * "tileset-N.json" beside it with about `most` tiles each (0: PSPLAT_MOST_TILES_OF_FILE). Boxes
 * are in the coordinates of 3D Tiles, with Z up. Errors: MEMORY, and those of take. */
psplat_result psplat_tileset_write(const psplat_tile *tiles, size_t count, const size_t *parents,
                                   size_t most, psplat_take_tileset *take, void *user,
                                   psplat_error *error);

#endif
