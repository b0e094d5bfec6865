/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tiles_input.h - tilesets as inputs of commands that draw: all that a view wants is read before it
 * is drawn.
 */
#ifndef PHONGSPLAT_CLI_TILES_INPUT_H
#define PHONGSPLAT_CLI_TILES_INPUT_H

#include <phongsplat/tiles.h>

/* A tileset and the directory of its files. Zeros are none. */
typedef struct psplat_tiles_input {
    psplat_tiles *tiles;
    char *directory; /* with a slash at the end, or "" */
} psplat_tiles_input;

/* Returns whether a path is that of a tileset: a directory, or a name that ends with .json or
 * .3tz. */
int psplat_tiles_input_expected(const char *path);

/* Opens a tileset; of a directory its tileset.json. The caller closes it, also after an error.
 * Errors: those of psplat_tiles_open. */
psplat_result psplat_tiles_input_open(const char *path, psplat_tiles_input *input,
                                      psplat_error *error);

/* Reads and uploads tiles until psplat_tiles_items are the coarsest whose errors are at most
 * view->pixels, with none missing. Errors: READ (error->text names the tile's file), and those of
 * psplat_tiles_select, psplat_tiles_supply and psplat_tiles_upload. */
psplat_result psplat_tiles_input_load(const psplat_tiles_input *input, psplat_renderer *renderer,
                                      const psplat_tiles_view *view, psplat_error *error);

/* Closes what was opened. renderer may be NULL where nothing was loaded. */
void psplat_tiles_input_close(psplat_tiles_input *input, psplat_renderer *renderer);

#endif
