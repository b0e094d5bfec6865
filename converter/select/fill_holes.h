/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fill_holes.h - the search for holes between splats, and their covering.
 */
#ifndef PHONGSPLAT_SELECT_FILL_HOLES_H
#define PHONGSPLAT_SELECT_FILL_HOLES_H

#include <phongsplat/splat.h>

#include "measure/holes.h"
#include "select/conversion.h"

/* Finds the holes between the splats of the taken candidates, whose ellipses have to be grown, and
 * on the grid where the limits have a precision. Looks only where splats have changed since the
 * last search or that found holes; but everywhere with inside_seams, where what lies beyond seams
 * closes none. c->splats then holds these splats. psplat_holes_free frees *holes. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_find_holes(psplat_conversion *c, int inside_seams, psplat_holes *holes);

/* Finds holes between the splats of the taken candidates, appends points in them to the samples,
 * and covers these with candidates, until no hole is left or 32 rounds are over. Grows the ellipses
 * of taken candidates, and quantizes them where the limits have a precision. c->splats then holds
 * the splats of the last round whose holes were looked for. Errors: MEMORY, INTERRUPTED, RANGE (too
 * many samples). */
psplat_result psplat_fill_holes(psplat_conversion *c, psplat_error *error);

/* Covers the samples from index first on and all that no taken candidate covers, and fills the
 * holes that are left; last: 1 without exchanging candidates. Errors as above. */
psplat_result psplat_cover_samples(psplat_conversion *c, size_t first, int last,
                                   psplat_error *error);

/* Does the same without exchanging candidates: all that are taken stay, and others are added. For
 * the holes that are left when candidates have been moved for another reason. */
psplat_result psplat_fill_last_holes(psplat_conversion *c, psplat_error *error);

#endif
