// SPDX-License-Identifier: MIT
//
// hausdorff.cpp - CGAL's Hausdorff distances behind C functions, which hausdorff.h documents.
#include "hausdorff.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Surface_mesh.h>

#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace processing = CGAL::Polygon_mesh_processing;

// Returns the mesh with separate vertices for each triangle, since shared vertices do not affect
// distances.
Mesh mesh_of(const hausdorff_soup &soup) {
    Mesh mesh;
    for (std::size_t t = 0; t < soup.triangle_count; ++t) {
        Mesh::Vertex_index corners[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const double *p = soup.points + 3 * std::size_t{soup.triangles[3 * t + k]};
            corners[k] = mesh.add_vertex(Kernel::Point_3(p[0], p[1], p[2]));
        }
        mesh.add_face(corners[0], corners[1], corners[2]);
    }
    return mesh;
}

} // namespace

extern "C" double hausdorff_bounded(const hausdorff_soup *from, const hausdorff_soup *to,
                                    double bound) try {
    return processing::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(mesh_of(*from),
                                                                              mesh_of(*to), bound);
} catch (...) {
    return -1;
}

extern "C" double hausdorff_sampled(const hausdorff_soup *from, const hausdorff_soup *to,
                                    std::size_t count) try {
    return processing::approximate_Hausdorff_distance<CGAL::Sequential_tag>(
        mesh_of(*from), mesh_of(*to),
        CGAL::parameters::random_seed(1).number_of_points_on_faces(count).do_sample_edges(false));
} catch (...) {
    return -1;
}
