/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease.h - crease detection, and the smooth patches between creases.
 */
#ifndef PHONGSPLAT_FEATURES_CREASE_H
#define PHONGSPLAT_FEATURES_CREASE_H

#include <phongsplat/splat.h>

#include "features/surface.h"
#include "features/surface_build.h"

#include <stdint.h>

/* Fills in creases, patches, patch_count, crease_edges and roughness of a surface whose neighbours
 * are known. authored comes from psplat_authored_read. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_find(psplat_surface *surface, const psplat_patch_bounds *bounds,
                                 const uint8_t *authored);

#endif
