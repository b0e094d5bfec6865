/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trim_splats.h - the removal of splats that are not needed, and the shrinking of those whose rims
 * stand off more than they have to.
 */
#ifndef PHONGSPLAT_FINISH_TRIM_SPLATS_H
#define PHONGSPLAT_FINISH_TRIM_SPLATS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Leaves out splats of which others cover all samples, and makes others up to a tenth smaller where
 * a rim stands off outwards by half the tolerance or more, and where other splats cover what is
 * left: outlines are drawn by rims. Splats are added only for holes that no old one closes. Of the
 * rays that are tried, while seams are still open, none that met a splat passes between them
 * afterwards, unless another splat hides that (ray_holes.h). Candidates that stay keep their order,
 * and are recorded to cover what one that does not was. All candidates of the selection have to be
 * taken, on the grid where the limits have a precision, and all are taken afterwards. Errors:
 * MEMORY, INTERRUPTED, RANGE (too many samples). */
psplat_result psplat_trim_splats(psplat_conversion *c, psplat_error *error);

#endif
