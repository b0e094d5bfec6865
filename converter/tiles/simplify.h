/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * simplify.h - a mesh of fewer triangles with the same border, proven to be near its source and its
 * source near it.
 */
#ifndef PHONGSPLAT_TILES_SIMPLIFY_H
#define PHONGSPLAT_TILES_SIMPLIFY_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Simplifies a welded mesh (mesh/weld.h). All vertices of the result are some of the source's. With
 * keeps_border 1, the edges that belong to an odd number of triangles are exactly the source's, so
 * that meshes that fitted together still do. With 0, borders are simplified like the rest, and such
 * edges join vertices of the source's borders: where a border keeps all its edges, slivers stay
 * beside it that stand on the surface or are folded over, and few splats face as they do.
 * *deviation (a length, at most `most` > 0) bounds the distance of each point of the result from
 * the source and of each point of the source from the result, up to rounding of some 1e-12 of the
 * coordinates. Where nothing simpler can be proven, triangles stay; *deviation is 0 if all do. So
 * they do where a simplified triangle higher than most faces otherwise than the source beside it,
 * in some rounds at least: where two sheets are nearer than most to each other, it may.
 * Vertices keep their colours. Normals, groups and texture coordinates are not kept.
 * psplat_mesh_free frees *simple. Equal input gives equal results. Fails only with
 * PSPLAT_ERROR_MEMORY; *simple is then empty. */
psplat_result psplat_tile_simplify(const psplat_mesh *source, double most, int keeps_border,
                                   psplat_mesh *simple, double *deviation);

#endif
