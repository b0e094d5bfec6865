/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * edges.h - edges of a triangle mesh: pairs of half-edges, vertices and vectors.
 *
 * Edge 3 t + k of triangle t runs from its corner k to its corner (k + 1) % 3.
 */
#ifndef PHONGSPLAT_MESH_EDGES_H
#define PHONGSPLAT_MESH_EDGES_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#include <stdint.h>

/* Stores for each edge the one other edge with the same end vertices, in either direction, or
 * PSPLAT_NONE if there is none or more than one; in a sheet that has triangles on both sides
 * (mesh/weld.h), and where one ends at another surface, the one of its own side. pairs:
 * triangle_count x 3. *borders is the number of edges that belong to one triangle only. Fails only
 * with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_edge_pairs(const psplat_mesh *mesh, uint32_t *pairs, size_t *borders);

/* Stores the vector from the start of an edge to its end. */
void psplat_edge_vector(const psplat_mesh *mesh, uint32_t edge, double vector[3]);

/* Returns the vertex at which an edge starts (end 0) or ends (end 1). */
uint32_t psplat_edge_vertex(const psplat_mesh *mesh, uint32_t edge, int end);

#endif
