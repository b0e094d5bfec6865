/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_classify.c - classification of one edge as crease, weak or smooth, by the surface around
 * it.
 *
 * An edge whose dihedral angle reaches the crease angle and stands out from the noise is a crease
 * if it also stands out from the roughness around it: of a coarse mesh nothing else is known.
 * Otherwise the normals of the two sides, extrapolated linearly to the edge, must still differ by
 * most of the angle. Along the rims and folds of a round shape they meet. Where noise hides the
 * angle, the test is made with normals without noise, and the edge must stand out from the
 * roughness that they have left. (Hubeli, Gross 2001 compare such operators. Jiao, Bayyana 2008
 * also tell creases from noise by what continues across scales.)
 */
#include "features/crease_classify.h"

#include "base/vector.h"
#include "features/curvature.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

/* The most triangles of a side: enough to average over, and so few that they do not run around a
 * cylinder whose facets are two triangles each. Weak edges have a second test with fewer. */
enum { SIDE_TRIANGLES = 16, NEAR_SIDE_TRIANGLES = 6 };

/* The least ratios: of an edge's angle to the noise, of its angle to the roughness, of its angle
 * without noise to the roughness, and of a weak edge's angle to the greatest beside it. Tuned so
 * that scans (bunny, armadillo) have no creases, and parts keep theirs under noise of a tenth of
 * the length of their edges. */
static const double min_noise_ratio = 12;
static const double min_facet_ratio = 6;
static const double min_roughness_ratio = 10;
static const double min_weak_ratio = 3;
/* Noise and roughness count as at least this fraction of the crease angle. */
static const double min_roughness_fraction = 0.05;
/* A weak edge below this fraction of the crease angle must continue a crease collinearly. */
static const double collinear_angle_fraction = 2.0 / 3.0;
/* The least angle between the extrapolated normals, as a fraction of the angle of the edge. */
static const double min_sharp_jump_fraction = 0.7;
static const double min_weak_jump_fraction = 0.5;
/* Sides end at edges of at least this fraction of the angle, which may be other creases. */
static const double side_limit_fraction = 0.9;

/* The two sides of an edge: the triangles that are reached from either of its triangles. No
 * triangle belongs to both. */
typedef struct edge_sides {
    uint32_t triangles[2][SIDE_TRIANGLES];
    size_t counts[2], max_count;
    double greatest_angle; /* of an edge inside a side, radians */
} edge_sides;

static int side_holds(const edge_sides *sides, uint32_t triangle) {
    for (int side = 0; side < 2; ++side)
        for (size_t i = 0; i < sides->counts[side]; ++i)
            if (sides->triangles[side][i] == triangle) return 1;
    return 0;
}

/* Adds the neighbours of triangle `at` of a side across edges of less than limit radians. */
static void side_expand(const psplat_surface *surface, const psplat_curvature *curvature,
                        edge_sides *sides, int side, size_t at, double limit) {
    uint32_t triangle = sides->triangles[side][at];
    for (uint32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge) {
        uint32_t next = surface->neighbors[edge];
        if (next == PSPLAT_NONE || sides->counts[side] == sides->max_count) continue;
        double angle = fabs((double)curvature->smooth_angles[edge]);
        if (angle >= limit || side_holds(sides, next)) continue;
        sides->greatest_angle = max2(sides->greatest_angle, angle);
        sides->triangles[side][sides->counts[side]++] = next;
    }
}

/* Grows both sides in turn, so that neither runs around the end of the edge into the other. */
static void find_sides(const psplat_surface *surface, const psplat_curvature *curvature,
                       uint32_t edge, double limit, size_t max_count, edge_sides *sides) {
    *sides = (edge_sides){.triangles = {{edge / 3}, {surface->neighbors[edge]}},
                          .counts = {1, 1},
                          .max_count = max_count};
    for (size_t at = 0; at < max_count; ++at)
        for (int side = 0; side < 2; ++side)
            if (at < sides->counts[side]) side_expand(surface, curvature, sides, side, at, limit);
}

/* Returns the angle from a to b, negative if it turns against the axis. */
static double angle_about(const double a[3], const double b[3], const double axis[3]) {
    double c[3];
    cross3(c, a, b);
    double angle = atan2(length3(c), dot3(a, b));
    return dot3(c, axis) < 0 ? -angle : angle;
}

/* Returns the distance of a triangle's centroid from the line of the edge. */
static double distance_from(const psplat_mesh *mesh, uint32_t triangle, const double *start,
                            const double along[3]) {
    double offset[3] = {0, 0, 0};
    for (size_t k = 0; k < 3; ++k) {
        double d[3];
        sub3(d, mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + k], start);
        mad3(offset, 1.0 / 3, d);
    }
    mad3(offset, -dot3(offset, along), along);
    return length3(offset);
}

/* Computes the mean normal of a side, and its normal extrapolated to the edge by linear regression
 * over the distance from the edge. Both are weighted by area, and of any length. */
static void side_normals(const psplat_surface *surface, const psplat_curvature *curvature,
                         const edge_sides *sides, int side, const double *start,
                         const double along[3], double mean[3], double extrapolated[3]) {
    double weight = 0, first = 0, second = 0, product[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) mean[k] = 0;
    for (size_t i = 0; i < sides->counts[side]; ++i) {
        uint32_t t = sides->triangles[side][i];
        double area = surface->face_areas[t];
        double x = distance_from(surface->mesh, t, start, along);
        const double *normal = curvature->smooth_normals + 3 * (size_t)t;
        weight += area, first += area * x, second += area * x * x;
        mad3(mean, area, normal);
        mad3(product, area * x, normal);
    }
    double spread = weight * second - first * first;
    int flat = !(spread > 1e-6 * weight * second); /* all centroids have the same distance */
    for (int k = 0; k < 3; ++k)
        extrapolated[k] = flat ? mean[k] : second * mean[k] - first * product[k];
}

/* Computes the angles between the mean normals of the sides, and between those extrapolated to the
 * edge, positive if they have the sign of the edge's angle. */
static void side_angles(const psplat_surface *surface, const psplat_curvature *curvature,
                        uint32_t edge, const edge_sides *sides, double *mean, double *jump) {
    const double *start = surface->mesh->positions + 3 * (size_t)surface->mesh->triangles[edge];
    double along[3], means[2][3], extrapolated[2][3];
    psplat_edge_vector(surface->mesh, edge, along);
    normalize3(along);
    for (int side = 0; side < 2; ++side)
        side_normals(surface, curvature, sides, side, start, along, means[side],
                     extrapolated[side]);
    double sign = curvature->smooth_angles[edge] < 0 ? -1 : 1;
    *mean = sign * angle_about(means[0], means[1], along);
    *jump = sign * angle_about(extrapolated[0], extrapolated[1], along);
}

/* Whether the extrapolated normals of the sides, which end at edges of limit radians, still differ
 * by a fraction of the angle of the edge. */
static int is_jump(const psplat_surface *surface, const psplat_curvature *curvature, uint32_t edge,
                   double limit, size_t max_count, double fraction) {
    edge_sides sides;
    double mean, jump;
    find_sides(surface, curvature, edge, limit, max_count, &sides);
    side_angles(surface, curvature, edge, &sides, &mean, &jump);
    return jump >= fraction * fabs((double)curvature->smooth_angles[edge]);
}

/* Returns the mean of a value of the two triangles at an edge, but not less than the minimum. */
static double mean_at_edge(const psplat_surface *surface, const float *values, uint32_t edge,
                           double crease_angle) {
    double here = (double)values[edge / 3], there = (double)values[surface->neighbors[edge]];
    return max2((here + there) / 2, min_roughness_fraction * crease_angle);
}

psplat_edge_kind psplat_crease_classify(const psplat_surface *surface,
                                        const psplat_curvature *curvature, uint32_t edge,
                                        double crease_angle, double weak_angle) {
    double angle = fabs((double)curvature->angles[edge]);
    double smooth_angle = fabs((double)curvature->smooth_angles[edge]);
    double noise = mean_at_edge(surface, curvature->noise, edge, crease_angle);
    double roughness = mean_at_edge(surface, curvature->roughness, edge, crease_angle);
    if (angle >= crease_angle && angle >= min_noise_ratio * noise) {
        int is_noiseless = noise <= min_roughness_fraction * crease_angle;
        if (angle >= min_facet_ratio * roughness ||
            is_jump(surface, curvature, edge, crease_angle, SIDE_TRIANGLES,
                    min_sharp_jump_fraction))
            return is_noiseless ? PSPLAT_EDGE_SHARP : PSPLAT_EDGE_PROBABLE;
    }
    if (smooth_angle >= crease_angle && smooth_angle >= min_roughness_ratio * roughness &&
        is_jump(surface, curvature, edge, side_limit_fraction * smooth_angle, SIDE_TRIANGLES,
                min_sharp_jump_fraction))
        return PSPLAT_EDGE_PROBABLE;
    return smooth_angle >= weak_angle ? PSPLAT_EDGE_UNTESTED : PSPLAT_EDGE_SMOOTH;
}

psplat_edge_kind psplat_crease_classify_weak(const psplat_surface *surface,
                                             const psplat_curvature *curvature, uint32_t edge,
                                             double crease_angle, double weak_angle) {
    double angle = fabs((double)curvature->smooth_angles[edge]), mean, jump;
    edge_sides sides;
    find_sides(surface, curvature, edge, min2(angle, crease_angle), SIDE_TRIANGLES, &sides);
    side_angles(surface, curvature, edge, &sides, &mean, &jump);
    if (angle < min_weak_ratio * sides.greatest_angle || mean < weak_angle)
        return PSPLAT_EDGE_SMOOTH;
    if (!is_jump(surface, curvature, edge, crease_angle, NEAR_SIDE_TRIANGLES,
                 min_weak_jump_fraction))
        return PSPLAT_EDGE_SMOOTH;
    return angle >= collinear_angle_fraction * crease_angle ? PSPLAT_EDGE_WEAK
                                                            : PSPLAT_EDGE_COLLINEAR;
}
