/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * polygon.h - triangulation of polygons by ear clipping.
 */
#ifndef PHONGSPLAT_BASE_POLYGON_H
#define PHONGSPLAT_BASE_POLYGON_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PSPLAT_MAX_CORNERS 4096u /* the most corners of one polygon */

/* Splits the polygon with corners at points (count x 3) into count - 2 triangles of corner numbers.
 * Concave polygons are handled. triangles has room for (count - 2) x 3. Errors: PSPLAT_ERROR_RANGE
 * (count is not 3 ... PSPLAT_MAX_CORNERS), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_polygon_triangulate(const double *points, size_t count, uint32_t *triangles,
                                         psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
