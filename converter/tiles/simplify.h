/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * simplify.h - a mesh of fewer triangles with the same border, proven to be near its source and its
 * source near it.
 */
#ifndef PHONGSPLAT_TILES_SIMPLIFY_H
#define PHONGSPLAT_TILES_SIMPLIFY_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Simplifies a welded mesh (mesh/weld.h). Of the result, all vertices are some of the source's, the
 * edges that belong to an odd number of triangles are exactly the source's, so that meshes that
 * fitted together still do, and *deviation (a length, at most `most` > 0) bounds the distance of
 * each of its points from the source and of each point of the source from it, up to rounding of
 * some 1e-12 of the coordinates. Where nothing simpler can be proven, triangles stay; *deviation is
 * 0 if all do. Vertices keep their colours. Normals, groups and texture
 * coordinates are not kept. psplat_mesh_free frees *simple. Equal input gives equal results. Fails
 * only with PSPLAT_ERROR_MEMORY; *simple is then empty. */
psplat_result psplat_tile_simplify(const psplat_mesh *source, double most, psplat_mesh *simple,
                                   double *deviation);

#endif
