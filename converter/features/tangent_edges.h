/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tangent_edges.h - tangent edges: where a straight part of a surface goes over into a round one.
 */
#ifndef PHONGSPLAT_FEATURES_TANGENT_EDGES_H
#define PHONGSPLAT_FEATURES_TANGENT_EDGES_H

#include <phongsplat/splat.h>

#include "features/surface.h"

#include <stdint.h>

/* Marks the edges along which the curvature jumps, as far as they bound nothing yet, as
 * PSPLAT_BOUND_TANGENT, and fills in tangent_edges of a surface whose neighbours, creases and
 * borders of charts are known. authored comes from psplat_authored_read. tolerance is the greatest
 * distance of splats from the surface, a length; where it is 0, none are marked. Fails only with
 * PSPLAT_ERROR_MEMORY.
 *
 * At a jump by k, one over a length, splats within the tolerance e reach over the edge by
 * sqrt(2 e / k), where their normals are off by sqrt(2 e k). An edge is marked where that is 8
 * degrees or more, where the surface on one side of it is straight across the edge for twice that
 * reach, where it turns at one rate on the other side, and where such edges follow each other for
 * six times the reach. Only meshes whose edges run along the jump have them, as those of CAD
 * programs do; scans have none.
 *
 * Where the file's normals go on over an edge, it is marked as well where on one side of it they
 * are within a degree of the face's for two tolerances, where on the other side they turn by 16
 * degrees or more over at most three tolerances, up to a crease or until they are straight again
 * for two, and where such edges follow each other for six tolerances: a narrow bevel. */
psplat_result psplat_tangent_edges_mark(psplat_surface *surface, const uint8_t *authored,
                                        double tolerance);

#endif
