/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_follow.h - creases continued along weak edges (hysteresis).
 */
#ifndef PHONGSPLAT_FEATURES_CREASE_FOLLOW_H
#define PHONGSPLAT_FEATURES_CREASE_FOLLOW_H

#include <phongsplat/splat.h>

#include "features/curvature.h"
#include "features/surface.h"

#include <stdint.h>

/* Sets what an edge bounds (PSPLAT_BOUND_..., or 0), on both of its triangles. */
void psplat_crease_set(psplat_surface *surface, uint32_t edge, uint8_t value);

/* Marks weak edges that touch creases, and collinear edges that continue them, as creases. kinds
 * holds a psplat_edge_kind for each edge; untested ones are classified when a crease reaches them.
 * Angles in radians. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_follow(psplat_surface *surface, const psplat_curvature *curvature,
                                   double crease_angle, double weak_angle, uint8_t *kinds);

#endif
