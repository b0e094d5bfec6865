/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_cgal_distance.cpp - point-to-mesh distances by CGAL's AABB tree.
 *
 * No exception and no C++ type leaves this file.
 */
#include "mesh/cgal_distance.h"

#include "mesh/mesh.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>
#include <iterator>
#include <new>
#include <vector>

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Iterator = std::vector<Triangle>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Point point(const double *p) {
    return Point(p[0], p[1], p[2]);
}

void store_corners(const Triangle &triangle, double corners[9]) {
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) corners[3 * i + k] = triangle.vertex(i)[k];
}

} // namespace

struct psplat_cgal_distance {
    std::vector<Triangle> triangles;
    Tree tree;
};

extern "C" psplat_cgal_distance *psplat_cgal_distance_create(const psplat_mesh *mesh) try {
    auto *distance = new psplat_cgal_distance;
    try {
        distance->triangles.reserve(mesh->triangle_count);
        for (size_t t = 0; t < mesh->triangle_count; ++t) {
            const uint32_t *corner = mesh->triangles + 3 * t;
            distance->triangles.emplace_back(point(mesh->positions + 3 * size_t{corner[0]}),
                                             point(mesh->positions + 3 * size_t{corner[1]}),
                                             point(mesh->positions + 3 * size_t{corner[2]}));
        }
        distance->tree.insert(distance->triangles.begin(), distance->triangles.end());
        /* Both parts of the tree are built here. CGAL would build them in the first query, which is
         * not safe when several threads query. */
        distance->tree.build();
        distance->tree.accelerate_distance_queries();
        return distance;
    } catch (...) {
        delete distance;
        throw;
    }
} catch (...) {
    return nullptr;
}

extern "C" psplat_result psplat_cgal_distance_query(const psplat_cgal_distance *distance,
                                                    const double *points, size_t count,
                                                    double *result) try {
    /* The nearest point of one query is a good first guess for the next. */
    Point nearest;
    for (size_t i = 0; i < count; ++i) {
        const Point query = point(points + 3 * i);
        nearest =
            i ? distance->tree.closest_point(query, nearest) : distance->tree.closest_point(query);
        result[i] = std::sqrt(CGAL::squared_distance(query, nearest));
    }
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" psplat_result psplat_cgal_distance_nearest(const psplat_cgal_distance *distance,
                                                      const double point_[3], double nearest[3],
                                                      uint32_t *triangle) try {
    const auto found = distance->tree.closest_point_and_primitive(point(point_));
    for (int k = 0; k < 3; ++k) nearest[k] = found.first[k];
    *triangle = static_cast<uint32_t>(found.second - distance->triangles.begin());
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" psplat_result psplat_cgal_distance_meets(const psplat_cgal_distance *distance,
                                                    const double from[3], const double to[3],
                                                    int *meets) try {
    const Kernel::Segment_3 segment(point(from), point(to));
    const Kernel::Vector_3 way = segment.to_vector();
    std::vector<Iterator> met;
    distance->tree.all_intersected_primitives(segment, std::back_inserter(met));
    *meets = 0;
    for (const Iterator &triangle : met)
        *meets |= CGAL::cross_product(triangle->vertex(1) - triangle->vertex(0),
                                      triangle->vertex(2) - triangle->vertex(0)) *
                      way <
                  0;
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" psplat_result psplat_cgal_distance_within(const psplat_cgal_distance *distance,
                                                     const double *points, size_t count,
                                                     double tolerance, int *within) try {
    *within = 1;
    for (size_t i = 0; i < count && *within; ++i) {
        const Point query = point(points + 3 * i);
        /* The guess, just beyond the tolerance, bounds the search. It comes back as the result if
         * no point of the mesh is nearer. */
        const Point guess(query.x() + tolerance * 1.0000001, query.y(), query.z());
        const Point nearest = distance->tree.closest_point(query, guess);
        *within =
            nearest != guess && CGAL::squared_distance(query, nearest) <= tolerance * tolerance;
    }
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" psplat_result
psplat_cgal_distance_visit_box(const psplat_cgal_distance *distance, const double low[3],
                               const double high[3],
                               int (*visit)(void *user, const double corners[9]), void *user) try {
    /* The box is widened by what rounding in CGAL's tests may cut off. */
    double from[3], to[3], slack = 0;
    for (int k = 0; k < 3; ++k)
        slack = std::fmax(slack, 1e-9 * (std::fabs(low[k]) + std::fabs(high[k])));
    for (int k = 0; k < 3; ++k) from[k] = low[k] - slack, to[k] = high[k] + slack;
    const CGAL::Bbox_3 box(from[0], from[1], from[2], to[0], to[1], to[2]);
    std::vector<Iterator> met;
    distance->tree.all_intersected_primitives(box, std::back_inserter(met));
    for (const Iterator &triangle : met) {
        double corners[9];
        store_corners(*triangle, corners);
        if (visit(user, corners)) break;
    }
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" void psplat_cgal_distance_triangle(const psplat_cgal_distance *distance,
                                              uint32_t triangle, double corners[9]) {
    store_corners(distance->triangles[triangle], corners);
}

extern "C" void psplat_cgal_distance_destroy(psplat_cgal_distance *distance) {
    delete distance;
}
