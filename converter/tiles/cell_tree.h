/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cell_tree.h - the cells of a block that a mesh meets, and the cut through them that a level
 * makes: which splats and which triangles each tile gets.
 */
#ifndef PHONGSPLAT_TILES_CELL_TREE_H
#define PHONGSPLAT_TILES_CELL_TREE_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "mesh/mesh.h"
#include "tiles/cell.h"

#include <stdint.h>

/* The cells below a block's that triangles of its mesh meet. It grows with each cut. */
typedef struct psplat_cell_tree psplat_cell_tree;

/* Makes the tree of a mesh, which must live as long, below a cell. Returns NULL when out of memory.
 */
psplat_cell_tree *psplat_cell_tree_create(const psplat_mesh *mesh, const psplat_tile_cell *block);

void psplat_cell_tree_destroy(psplat_cell_tree *tree); /* NULL is accepted */

/* What a cut distributes. Positions are relative to the mesh's origin. */
typedef struct psplat_cut_desc {
    const psplat_region *regions; /* of the splats, region_count */
    size_t region_count;
    double margin; /* a cell gets the splats that reach this near to it: a length */
    size_t most;   /* a cell that more splats reach is halved, if that helps; 0: none is that the
                      last cut has not halved */
    const float *triangles; /* triangle_count x 3 x 3: of a simplified mesh, by the cells that they
                               meet; NULL: none */
    size_t triangle_count;
    int (*may_halve)(void *user, const psplat_tile_cell *cell); /* NULL: every cell may be */
    void *user;
} psplat_cut_desc;

/* What a cell of a cut gets. */
typedef struct psplat_tile_part {
    psplat_tile_cell cell;
    uint32_t *splats, *triangles; /* indices, ascending; owned */
    size_t splat_count, triangle_count;
} psplat_tile_part;

/* Cuts the tree where the last cut did or below. Every cell of the cut gets at least one splat, the
 * nearest one where none reaches it. Stores its cells, by path. psplat_tile_parts_free frees
 * *parts. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_cell_tree_cut(psplat_cell_tree *tree, const psplat_cut_desc *desc,
                                   psplat_tile_part **parts, size_t *count);

/* Returns the index, among the parts of the last cut, of the cell that holds a point of the mesh,
 * rounding aside; SIZE_MAX where none does. */
size_t psplat_cell_tree_part(const psplat_cell_tree *tree, const double point[3]);

void psplat_tile_parts_free(psplat_tile_part *parts, size_t count);

#endif
