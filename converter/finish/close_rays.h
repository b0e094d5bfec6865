/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_rays.h - the closing of gaps that slanted rays find between splats of different heights.
 */
#ifndef PHONGSPLAT_FINISH_CLOSE_RAYS_H
#define PHONGSPLAT_FINISH_CLOSE_RAYS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Extends the ellipses of candidates to where rays pass between them, as far as the limits allow,
 * and adds candidates where one still sees through: in the end there are at most 10 % more of them,
 * unless that opens holes along normals, which psplat_fill_last_holes then fills. Every candidate
 * must be taken. Rays see the candidates as
 * psplat_close_seams will leave them, which has to follow, and so has psplat_close_cracks, to which
 * narrow cracks at clip lines are left. What a candidate is recorded to cover
 * stays, and with that its colour. Errors: MEMORY, INTERRUPTED, RANGE (too many samples). */
psplat_result psplat_close_rays(psplat_conversion *c, psplat_error *error);

#endif
