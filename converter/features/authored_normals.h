/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * authored_normals.h - creases and smooth edges that the file's normals define.
 */
#ifndef PHONGSPLAT_FEATURES_AUTHORED_NORMALS_H
#define PHONGSPLAT_FEATURES_AUTHORED_NORMALS_H

#include <phongsplat/splat.h>

#include "features/surface.h"

#include <stdint.h>

/* Flags of a corner and of the edge that starts at it. */
enum {
    PSPLAT_AUTHORED_NORMAL = 1, /* the corner has a credible normal */
    PSPLAT_AUTHORED_SMOOTH = 2, /* the normals of both triangles agree at both ends of the edge */
    PSPLAT_AUTHORED_HALF_HARD = 4, /* they differ at one end */
    PSPLAT_AUTHORED_HARD = 8       /* they differ at both ends */
};

/* Stores the flags of all corners and edges in authored (triangle_count x 3). The neighbours of the
 * surface must be known. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_authored_read(const psplat_surface *surface, uint8_t *authored);

#endif
