/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * block_mesh.h - the meshes of blocks: gathered from triangles and from simplified meshes of other
 * blocks, and kept in files.
 */
#ifndef PHONGSPLAT_TILES_BLOCK_MESH_H
#define PHONGSPLAT_TILES_BLOCK_MESH_H

#include <phongsplat/splat.h>

#include "import/triangle_stream.h"
#include "mesh/mesh.h"
#include "tiles/cell.h"

#include <stddef.h>
#include <stdint.h>

/* Triangles that are gathered, three vertices each. Zero-initialise it, and set what they have. */
typedef struct psplat_tile_soup {
    int has_normals, has_colors;
    const psplat_tile_cell *reach; /* takes triangles that meet it alone; NULL: all */
    psplat_mesh mesh;
    size_t capacity; /* of mesh, triangles */
} psplat_tile_soup;

/* Adds a triangle (a psplat_take_triangle; user is the soup). Returns other than 0 when out of
 * memory. */
int psplat_tile_soup_add(void *user, const psplat_stream_triangle *triangle);

/* Add a triangle of a mesh, or all of them, with its colours. They fail only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_soup_add_triangle(psplat_tile_soup *soup, const psplat_mesh *mesh,
                                            uint32_t triangle);
psplat_result psplat_tile_soup_add_mesh(psplat_tile_soup *soup, const psplat_mesh *mesh);

void psplat_tile_soup_free(psplat_tile_soup *soup);

/* Writes positions, triangles and colours of a mesh, and its deviation from the source, to a file,
 * which is whole or not there. Errors: PSPLAT_ERROR_WRITE, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_mesh_write(const psplat_mesh *mesh, double deviation, const char *path,
                                     psplat_error *error);

/* Reads such a file. psplat_mesh_free frees *mesh. Errors: PSPLAT_ERROR_READ, PSPLAT_ERROR_FORMAT
 * (it is not whole), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_mesh_read(const char *path, psplat_mesh *mesh, double *deviation,
                                    psplat_error *error);

#endif
