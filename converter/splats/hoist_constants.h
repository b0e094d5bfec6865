/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * hoist_constants.h - moves values that all splats of a material share into the material.
 */
#ifndef PHONGSPLAT_SPLATS_HOIST_CONSTANTS_H
#define PHONGSPLAT_SPLATS_HOIST_CONSTANTS_H

#include <phongsplat/splat.h>

#include "splats/splats.h"

/* Multiplies the factors of each material by the colours and finishes that all of its splats share,
 * and sets these to 1 in the splats. Frees the finishes and clears has_color where nothing is left
 * in them. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_hoist_constants(psplat_splats *splats);

#endif
