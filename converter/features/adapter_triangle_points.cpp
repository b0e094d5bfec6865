/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_triangle_points.cpp - uniform random points of a triangle by CGAL.
 *
 * No exception and no C++ type leaves this file.
 */
#include "features/triangle_points.h"

#include <CGAL/Random.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/point_generators_3.h>

namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;

Point point(const double *p) {
    return Point(p[0], p[1], p[2]);
}

} // namespace

extern "C" psplat_result psplat_triangle_points(const double a[3], const double b[3],
                                                const double c[3], size_t count, uint32_t seed,
                                                double *points) try {
    CGAL::Random random(seed);
    CGAL::Random_points_in_triangle_3<Point> generator(point(a), point(b), point(c), random);
    for (size_t i = 0; i < count; ++i, ++generator)
        for (int k = 0; k < 3; ++k) points[3 * i + static_cast<size_t>(k)] = (*generator)[k];
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}
