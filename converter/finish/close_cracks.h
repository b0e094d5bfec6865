/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_cracks.h - the closing of cracks that clip lines leave between splats.
 */
#ifndef PHONGSPLAT_FINISH_CLOSE_CRACKS_H
#define PHONGSPLAT_FINISH_CLOSE_CRACKS_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "measure/ray_meeting.h"
#include "select/conversion.h"

/* The widest cracks that are closed, and the farthest that a line is moved in all, in tolerances.
 * close_seams.c may have moved it over its crease by 0.8 of one, and at 1 the promise of creases
 * breaks. Nine in ten cracks are narrower. */
#define PSPLAT_GREATEST_CRACK 0.15

/* The same where one sees through the crack a point of the patch that the splat grew from: there
 * its line stands behind the crease, by what the fit and rounding have left. Elsewhere along a bent
 * crease it may pass that by as much, which psplat_take_back_crossings bounds. */
#define PSPLAT_GREATEST_OWN_CRACK 0.4

/* Returns by how much, a length, the lines of a region would have to move out so that a sight meets
 * its front within the tolerance over the cosine; HUGE_VAL where its ellipse is in the way, too, or
 * where no line is. */
double psplat_crack_width(const psplat_sight *sight, double cosine, const psplat_region *region,
                          double tolerance);

/* Moves clip lines of the selection out to rays that pass between splats, by PSPLAT_GREATEST_CRACK
 * or PSPLAT_GREATEST_OWN_CRACK tolerances at most in all, and only as far as the splats stay within
 * the tolerance of the surface. psplat_close_seams must have been called, and all candidates have
 * to be taken. Errors: MEMORY. */
psplat_result psplat_close_cracks(psplat_conversion *c);

#endif
