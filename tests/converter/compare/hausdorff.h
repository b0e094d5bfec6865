/* SPDX-License-Identifier: MIT
 *
 * hausdorff.h - one-sided Hausdorff distances between triangles as CGAL computes them.
 */
#ifndef PHONGSPLAT_TESTS_HAUSDORFF_H
#define PHONGSPLAT_TESTS_HAUSDORFF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Triangles; vertices may belong to several. */
typedef struct hausdorff_soup {
    const double *points; /* point_count x 3 */
    size_t point_count;
    const uint32_t *triangles; /* triangle_count x 3 */
    size_t triangle_count;
} hausdorff_soup;

/* The greatest distance of a point of one to the other: at least what is returned, and more by at
 * most bound; where it is less than bound, bound is returned (Polygon_mesh_processing::
 * bounded_error_Hausdorff_distance). Negative: CGAL failed. */
double hausdorff_bounded(const hausdorff_soup *from, const hausdorff_soup *to, double bound);
/* The same of points that CGAL spreads over one: count by area, and its vertices
 * (approximate_Hausdorff_distance). */
double hausdorff_sampled(const hausdorff_soup *from, const hausdorff_soup *to, size_t count);

#ifdef __cplusplus
}
#endif
#endif
