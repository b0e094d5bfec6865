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

/* Triangles; a vertex may belong to several of them. */
typedef struct hausdorff_soup {
    const double *points; /* point_count x 3 */
    size_t point_count;
    const uint32_t *triangles; /* triangle_count x 3 */
    size_t triangle_count;
} hausdorff_soup;

/* Returns the greatest distance of a point of `from` to `to`. The exact value is at least the
 * returned one and at most `bound` more; where it is less than `bound`, `bound` is returned (CGAL's
 * Polygon_mesh_processing::bounded_error_Hausdorff_distance). Returns a negative number if CGAL
 * failed. */
double hausdorff_bounded(const hausdorff_soup *from, const hausdorff_soup *to, double bound);
/* Returns the greatest distance to `to` from the vertices of `from` and from `count` points that
 * CGAL spreads over it by area (approximate_Hausdorff_distance), or a negative number if CGAL
 * failed. */
double hausdorff_sampled(const hausdorff_soup *from, const hausdorff_soup *to, size_t count);

#ifdef __cplusplus
}
#endif
#endif
