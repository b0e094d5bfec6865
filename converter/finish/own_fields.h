/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * own_fields.h - normal fields of curved splats that are not those of their shapes.
 */
#ifndef PHONGSPLAT_FINISH_OWN_FIELDS_H
#define PHONGSPLAT_FINISH_OWN_FIELDS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Gives the curved splats of a selection, of which all are taken and none moves any more, normal
 * fields of their own (spec 3.4) where what splats blend to comes so much nearer to the shading
 * normals of the surface that it is worth the bytes: for all of them or for none. The fields of
 * flat splats are fitted anew then, too. All lie on the grid of c->splats->precision, whose steps
 * of fields and tilts follow from the error that is left. Shapes stay as they are. Where the file
 * has no normals, nothing changes if fits leave most of the tolerance unused or tangent edges bound
 * patches. Nor does it where splats are flat, hold floats, or have normals that are bounded,
 * constant, turned by maps or unlit. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_fit_own_fields(psplat_conversion *c);

#endif
