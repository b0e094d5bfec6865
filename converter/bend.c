/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * bend.c - whether the bend at one edge is a crease, judged by its surroundings.
 *
 * Where there is next to no noise the crease angle decides, if bends are of two kinds, large and
 * small: of a coarse mesh nothing else is known. Elsewhere the normals of the two sides, continued
 * linearly to the edge, must still differ by most of the bend: along the rims and folds of a round
 * shape they meet. Where there is noise this is asked of normals without it, and the edge must
 * stand out from the roughness that they have left. (Hubeli, Gross 2001 compare such operators;
 * that smooth and noisy bends differ by what continues across scales is also the ground of Jiao,
 * Bayyana 2008.)
 */
#include "stages.h"
#include "vector.h"

#include <string.h>

/* Triangles of a side: enough to average over, and so few that they do not run around a cylinder
 * whose facets are two triangles each. */
enum { SIDE_TRIANGLES = 16, NEAR_TRIANGLES = 6 };

/* What an edge's bend must exceed noise, roughness and the bends beside it by. Chosen so that scans
 * (bunny, armadillo) have no creases, and parts keep theirs under noise of a tenth of their edges.
 */
static const double noise_contrast = 12;
static const double facet_contrast = 6;
static const double roughness_contrast = 10;
static const double weak_contrast = 3;
/* Roughness below this part of the crease angle is none. */
static const double least_roughness = 0.05;
/* Part of the crease angle below which a weak edge is faint. */
static const double nearly = 2.0 / 3.0;
/* Part of the bend that is to be left between the continued normals. */
static const double sharp_jump = 0.7;
static const double weak_jump = 0.5;
/* Sides end where the surface bends by this part of it: at other creases. */
static const double most_beside = 0.9;

/* The two sides of an edge: triangles reached from either without meeting the other. */
typedef struct edge_sides {
    uint32_t triangles[2][SIDE_TRIANGLES];
    size_t counts[2], most;
    double greatest; /* bend inside a side */
} edge_sides;

static int side_holds(const edge_sides *sides, uint32_t triangle) {
    for (int side = 0; side < 2; ++side)
        for (size_t i = 0; i < sides->counts[side]; ++i)
            if (sides->triangles[side][i] == triangle) return 1;
    return 0;
}

static void side_expand(const psplat_surface *surface, const psplat_relief *relief,
                        edge_sides *sides, int side, size_t at, double limit) {
    uint32_t triangle = sides->triangles[side][at];
    for (uint32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge) {
        uint32_t next = surface->neighbors[edge];
        if (next == PSPLAT_NONE || sides->counts[side] == sides->most) continue;
        double bend = fabs((double)relief->calm_bends[edge]);
        if (bend >= limit || side_holds(sides, next)) continue;
        sides->greatest = max2(sides->greatest, bend);
        sides->triangles[side][sides->counts[side]++] = next;
    }
}

/* Grows both sides in turn, so that neither runs around the edge's end into the other. */
static void find_sides(const psplat_surface *surface, const psplat_relief *relief, uint32_t edge,
                       double limit, size_t most, edge_sides *sides) {
    *sides = (edge_sides){
        .triangles = {{edge / 3}, {surface->neighbors[edge]}}, .counts = {1, 1}, .most = most};
    for (size_t at = 0; at < most; ++at)
        for (int side = 0; side < 2; ++side)
            if (at < sides->counts[side]) side_expand(surface, relief, sides, side, at, limit);
}

/* Angle from a to b about an axis, with its sign. */
static double angle_about(const double a[3], const double b[3], const double axis[3]) {
    double c[3];
    cross3(c, a, b);
    double angle = atan2(length3(c), dot3(a, b));
    return dot3(c, axis) < 0 ? -angle : angle;
}

/* How far a triangle's centroid lies from the edge's line. */
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

/* A side's mean normal, and its normal at the edge by linear regression over the distance from it,
 * weighted by area. */
static void side_normals(const psplat_surface *surface, const psplat_relief *relief,
                         const edge_sides *sides, int side, const double *start,
                         const double along[3], double mean[3], double continued[3]) {
    double weight = 0, first = 0, second = 0, product[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) mean[k] = 0;
    for (size_t i = 0; i < sides->counts[side]; ++i) {
        uint32_t t = sides->triangles[side][i];
        double area = surface->face_areas[t];
        double x = distance_from(surface->mesh, t, start, along);
        const double *normal = relief->normals + 3 * (size_t)t;
        weight += area, first += area * x, second += area * x * x;
        mad3(mean, area, normal);
        mad3(product, area * x, normal);
    }
    double spread = weight * second - first * first;
    int flat = !(spread > 1e-6 * weight * second); /* one distance only */
    for (int k = 0; k < 3; ++k)
        continued[k] = flat ? mean[k] : second * mean[k] - first * product[k];
}

/* Angles between the sides: of their mean normals, and of those continued to the edge. */
static void side_angles(const psplat_surface *surface, const psplat_relief *relief, uint32_t edge,
                        const edge_sides *sides, double *mean, double *jump) {
    const double *start = surface->mesh->positions + 3 * (size_t)surface->mesh->triangles[edge];
    double along[3], means[2][3], continued[2][3];
    psplat_edge_vector(surface->mesh, edge, along);
    normalize3(along);
    for (int side = 0; side < 2; ++side)
        side_normals(surface, relief, sides, side, start, along, means[side], continued[side]);
    double sign = relief->calm_bends[edge] < 0 ? -1 : 1;
    *mean = sign * angle_about(means[0], means[1], along);
    *jump = sign * angle_about(continued[0], continued[1], along);
}

/* Whether the sides, grown up to bends of limit, still differ by a part of the bend at the edge. */
static int is_jump(const psplat_surface *surface, const psplat_relief *relief, uint32_t edge,
                   double limit, size_t most, double part) {
    edge_sides sides;
    double mean, jump;
    find_sides(surface, relief, edge, limit, most, &sides);
    side_angles(surface, relief, edge, &sides, &mean, &jump);
    return jump >= part * fabs((double)relief->calm_bends[edge]);
}

/* Mean of a value of the two triangles at an edge, but not less than what counts as none. */
static double at_edge(const psplat_surface *surface, const float *values, uint32_t edge,
                      double crease_angle) {
    double here = (double)values[edge / 3], there = (double)values[surface->neighbors[edge]];
    return max2((here + there) / 2, least_roughness * crease_angle);
}

psplat_bend psplat_bend_judge(const psplat_surface *surface, const psplat_relief *relief,
                              uint32_t edge, double crease_angle, double weak_angle) {
    double bend = fabs((double)relief->bends[edge]), calm = fabs((double)relief->calm_bends[edge]);
    double noise = at_edge(surface, relief->noise, edge, crease_angle);
    double roughness = at_edge(surface, relief->roughness, edge, crease_angle);
    if (bend >= crease_angle && bend >= noise_contrast * noise) {
        int certain = noise <= least_roughness * crease_angle;
        if (bend >= facet_contrast * roughness ||
            is_jump(surface, relief, edge, crease_angle, SIDE_TRIANGLES, sharp_jump))
            return certain ? PSPLAT_BEND_SHARP : PSPLAT_BEND_LIKELY;
    }
    if (calm >= crease_angle && calm >= roughness_contrast * roughness &&
        is_jump(surface, relief, edge, most_beside * calm, SIDE_TRIANGLES, sharp_jump))
        return PSPLAT_BEND_LIKELY;
    return calm >= weak_angle ? PSPLAT_BEND_OPEN : PSPLAT_BEND_SMOOTH;
}

psplat_bend psplat_bend_judge_weak(const psplat_surface *surface, const psplat_relief *relief,
                                   uint32_t edge, double crease_angle, double weak_angle) {
    double bend = fabs((double)relief->calm_bends[edge]), mean, jump;
    edge_sides sides;
    find_sides(surface, relief, edge, min2(bend, crease_angle), SIDE_TRIANGLES, &sides);
    side_angles(surface, relief, edge, &sides, &mean, &jump);
    if (bend < weak_contrast * sides.greatest || mean < weak_angle) return PSPLAT_BEND_SMOOTH;
    if (!is_jump(surface, relief, edge, crease_angle, NEAR_TRIANGLES, weak_jump))
        return PSPLAT_BEND_SMOOTH;
    return bend >= nearly * crease_angle ? PSPLAT_BEND_WEAK : PSPLAT_BEND_FAINT;
}
