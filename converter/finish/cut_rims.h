/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cut_rims.h - clip lines that cut off where rims of splats show beside outlines.
 */
#ifndef PHONGSPLAT_FINISH_CUT_RIMS_H
#define PHONGSPLAT_FINISH_CUT_RIMS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Gives splats whose rims stand off outwards where the surface bends away another clip line, at
 * most one to each and to a quarter of all, where other splats cover what that cuts off, inside of
 * their seams. Rays through what this opens move lines out again, and holes take them away.
 * All candidates of the selection have to be taken, and their lines and seams are where they will
 * stay. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_cut_rims(psplat_conversion *c);

#endif
