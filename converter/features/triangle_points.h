/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_points.h - uniform random points of a triangle.
 */
#ifndef PHONGSPLAT_FEATURES_TRIANGLE_POINTS_H
#define PHONGSPLAT_FEATURES_TRIANGLE_POINTS_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Stores count uniform random points of the triangle a b c in points (count x 3). They depend on
 * seed alone (CGAL::Random_points_in_triangle_3). Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_triangle_points(const double a[3], const double b[3], const double c[3],
                                     size_t count, uint32_t seed, double *points);

#ifdef __cplusplus
}
#endif
#endif
