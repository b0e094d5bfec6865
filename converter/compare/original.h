/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * original.h - what is inside a psplat_original, for the files beside it.
 */
#ifndef PHONGSPLAT_ORIGINAL_H
#define PHONGSPLAT_ORIGINAL_H

#include "compare.h"
#include "stages.h"

struct psplat_original {
    const psplat_mesh *mesh; /* the caller's */
    psplat_surface surface;
    psplat_distance *distance;
    double center[3], radius; /* a sphere around it, in the coordinates of the file */
};

#endif
