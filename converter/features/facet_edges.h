/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facet_edges.h - edges of facets that are large beside the tolerance, though they are shaded as
 * smooth: those of models of few polygons.
 */
#ifndef PHONGSPLAT_FEATURES_FACET_EDGES_H
#define PHONGSPLAT_FEATURES_FACET_EDGES_H

#include <phongsplat/splat.h>

#include "features/surface.h"

#include <stddef.h>

/* Marks edges between facets, as far as they bound nothing yet, as PSPLAT_BOUND_FACET, and fills in
 * facet_edges of a surface whose faces, neighbours and other bounds are known. tolerance is the
 * greatest distance of splats from the surface, a length; where it is 0, none are marked.
 *
 * A parabola across an edge at which the surface turns by an angle t, and whose triangles are h
 * wide, is at least t h / 16 off. The edge is marked where that is a twentieth of the tolerance or
 * more. */
void psplat_facet_edges_mark(psplat_surface *surface, double tolerance);

/* Counts the parts of the surface that psplat_facet_edges_mark would leave between all bounds.
 * *count is 0 where it would mark no edge, or less than half of those that bend by more than 0.01
 * radians: parts are facets only where most of such edges are between two. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_facets_count(const psplat_surface *surface, double tolerance, size_t *count);

#endif
