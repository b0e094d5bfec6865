/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * slivers.h - triangles that are too thin to say where the surface faces.
 */
#ifndef PHONGSPLAT_FEATURES_SLIVERS_H
#define PHONGSPLAT_FEATURES_SLIVERS_H

#include <phongsplat/splat.h>

#include "features/surface.h"

/* Gives slivers the normal of the surface beside them, in a surface whose faces have been measured
 * and whose neighbours are known. A sliver is a triangle whose least altitude is less than height,
 * a length, and than a fifth of its longest side. All of it lies within that height of triangles
 * beside it, but its own normal may be any: simplified meshes have slivers that stand on the
 * surface or are folded over it, along lines where vertices had to stay, and CAD programs make them
 * where curves meet. With their own normals they would be walls between creases, each of which
 * needs a splat, and which no splat may cover that faces as the surface does. Only edges of at
 * least half of a sliver's longest side count: wires whose faces are slivers keep their normals,
 * and so do slivers beside nothing else. Does nothing where height is 0. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_slivers_settle(psplat_surface *surface, double height);

#endif
