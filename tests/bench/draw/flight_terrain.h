/* SPDX-License-Identifier: MIT
 *
 * flight_terrain.h - a terrain of any size as a tileset whose files are made when they are asked
 * for: a sum of waves over the unit square, in levels of tiles of 24 x 24 curved splats. A level
 * has four times the tiles of the one above, and half its errors.
 */
#ifndef PHONGSPLAT_BENCH_FLIGHT_TERRAIN_H
#define PHONGSPLAT_BENCH_FLIGHT_TERRAIN_H

#include <stddef.h>
#include <stdint.h>

enum { TERRAIN_MAX_LEVEL = 9, TERRAIN_SIDE = 24, TERRAIN_SPLATS = TERRAIN_SIDE * TERRAIN_SIDE };

typedef struct terrain {
    int finest;                           /* level, 1 ... TERRAIN_MAX_LEVEL */
    double errors[TERRAIN_MAX_LEVEL + 1]; /* greatest distance found between splats and surface */
} terrain;

terrain terrain_make(int finest);

/* Returns the height above a point of the unit square. */
double terrain_height(double x, double z);

/* Returns the number of splats of the finest level. */
size_t terrain_splats(const terrain *t);

/* Makes the file of a tileset, tileset.json or what it names. The caller frees it. Ends the program
 * where there is no such file. */
uint8_t *terrain_file(const terrain *t, const char *path, size_t *size);

/* Writes the surface as an OBJ of (side + 1)^2 vertices. Ends the program where that fails. */
void terrain_write_mesh(const char *path, int side);

#endif
