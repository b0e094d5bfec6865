/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_point_cloud.cpp - nearest neighbours and advancing front surface reconstruction by CGAL.
 *
 * No exception and no C++ type leaves this file.
 */
#include "points/point_cloud.h"

#include "base/random.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Search_traits_adapter.h>
#include <CGAL/property_map.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <iterator>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

std::vector<Point> points_of(const double *positions, size_t count) {
    std::vector<Point> points;
    points.reserve(count);
    for (size_t i = 0; i < count; ++i)
        points.emplace_back(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    return points;
}

/* Silences std::cerr, where CGAL prints warnings about points that it handles all the same. */
class Silence {
  public:
    Silence() : buffer_(std::cerr.rdbuf(nullptr)) {
    }
    ~Silence() {
        std::cerr.rdbuf(buffer_);
        std::cerr.clear();
    }
    Silence(const Silence &) = delete;
    Silence &operator=(const Silence &) = delete;

  private:
    std::streambuf *buffer_;
};

/* Returns a number 0 ... 1 for a triangle that does not depend on the order of its corners. */
double tie_breaker(uint64_t a, uint64_t b, uint64_t c) {
    uint64_t state = (a + b + c) * 0x9e3779b97f4a7c15u ^ (a * b + b * c + c * a);
    return psplat_random_unit(&state);
}

/* The priority of triangles: small Delaunay spheres come first, as is the default of CGAL. Edges
 * beyond the reach of their ends are refused, since wider gaps are holes of the scan. Edges between
 * normals that face away from each other are refused, since their ends are on two sides of a sheet.
 * Equal spheres, of which grids are full, would be taken in the order of their addresses in memory;
 * a change of up to one millionth of the radius makes the order deterministic. */
struct Priority {
    const double *reach;
    const float *normals; /* or nullptr */

    template <typename Front, typename Cell>
    double operator()(const Front &front, Cell &cell, const int &index) const {
        double radius = front.smallest_radius_delaunay_sphere(cell, index);
        if (radius == front.infinity()) return radius;
        const auto &a = *cell->vertex((index + 1) & 3);
        const auto &b = *cell->vertex((index + 2) & 3);
        const auto &c = *cell->vertex((index + 3) & 3);
        if (are_apart(a, b) || are_apart(b, c) || are_apart(c, a)) return front.infinity();
        return radius * (1 + 1e-6 * tie_breaker(a.id(), b.id(), c.id()));
    }

  private:
    template <typename Vertex> bool are_apart(const Vertex &a, const Vertex &b) const {
        auto i = static_cast<size_t>(a.id()), k = static_cast<size_t>(b.id());
        if (CGAL::squared_distance(a.point(), b.point()) > reach[i] * reach[k]) return true;
        if (!normals) return false;
        const float *m = normals + 3 * i, *n = normals + 3 * k;
        return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < -0.5f;
    }
};

/* Sorts triangles and their corners, since the front orders them by addresses in memory. */
void sort_faces(std::vector<std::array<size_t, 3>> &faces) {
    for (auto &face : faces) std::sort(face.begin(), face.end());
    std::sort(faces.begin(), faces.end());
}

} // namespace

extern "C" psplat_result psplat_points_neighbors(const double *positions, size_t count,
                                                 uint32_t *neighbors) try {
    using Base = CGAL::Search_traits_3<Kernel>;
    using Map = CGAL::Pointer_property_map<Point>::const_type;
    using Traits = CGAL::Search_traits_adapter<uint32_t, Map, Base>;
    using Search = CGAL::Orthogonal_k_neighbor_search<Traits>;
    const std::vector<Point> points = points_of(positions, count);
    std::vector<uint32_t> indices(count);
    for (uint32_t i = 0; i < count; ++i) indices[i] = i;
    Map map = CGAL::make_property_map(points);
    Search::Tree tree(indices.begin(), indices.end(), Search::Splitter(), Traits(map));
    Search::Distance distance(map);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t *own = neighbors + size_t{i} * PSPLAT_NEIGHBORS;
        size_t found = 0;
        Search search(tree, points[i], PSPLAT_NEIGHBORS + 1, 0, true, distance);
        for (const auto &neighbor : search)
            if (neighbor.first != i && found < PSPLAT_NEIGHBORS) own[found++] = neighbor.first;
        while (found < PSPLAT_NEIGHBORS) own[found++] = PSPLAT_NO_POINT;
    }
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}

extern "C" psplat_result psplat_points_front(const double *positions, const double *reach,
                                             const float *normals, size_t count,
                                             uint32_t **triangles, size_t *triangle_count) try {
    const std::vector<Point> points = points_of(positions, count);
    std::vector<std::array<size_t, 3>> faces;
    {
        Silence silence;
        CGAL::advancing_front_surface_reconstruction(
            points.begin(), points.end(), std::back_inserter(faces), Priority{reach, normals});
    }
    sort_faces(faces);
    *triangle_count = faces.size();
    *triangles = static_cast<uint32_t *>(std::malloc((3 * faces.size() + 1) * sizeof(uint32_t)));
    if (!*triangles) return PSPLAT_ERROR_MEMORY;
    uint32_t *target = *triangles;
    for (const auto &face : faces)
        for (size_t corner : face) *target++ = static_cast<uint32_t>(corner);
    return PSPLAT_OK;
} catch (...) {
    return PSPLAT_ERROR_MEMORY;
}
