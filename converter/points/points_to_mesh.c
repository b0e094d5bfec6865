/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * points_to_mesh.c - surface reconstruction: from a point set to a mesh through its points.
 *
 * Points are thinned to a number that can be connected, smoothed if they are noisy, connected by
 * the advancing front of CGAL (point_cloud.h), oriented, and given normals. Then every point is
 * assigned a triangle (attach_points.c).
 */
#include "base/vector.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/orientation.h"
#include "points/attach_points.h"
#include "points/normal_estimate.h"
#include "points/point_cloud.h"
#include "points/points.h"
#include "points/poisson_thin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points closer than this, in diagonals, are merged, since single precision hardly tells them
 * apart. If there are too many points, the thinning radius starts at the second value, in
 * diagonals, and grows at least by this factor. */
static const double merge_distance_diagonals = 1e-7;
static const double first_radius_diagonals = 5e-4;
static const double min_radius_growth = 1.1;
/* The most points that are connected. Three-dimensional Delaunay triangulations take 30
 * microseconds and 1.4 kB a point, and splats are larger than the gaps between so many. */
enum { MAX_CONNECTED = 200000 };
/* The longest edge, in distances to the farthest of the neighbours, which is 1.4 times the spacing
 * of a grid. Chosen by hand. */
static const double max_edge_neighbors = 3;
/* Neighbours are level if one is this close to the tangent plane of the other, in parts of their
 * distance. If more than this fraction of level neighbours have opposed normals, the normals are
 * noise or lines without direction. Chosen by hand. */
static const double max_level_height = 0.05;
static const double max_opposed_fraction = 0.05;
/* Coordinates below this, in spacings, are set to 0 for the front. It divides by squared lengths
 * that would underflow where three points are this close to a line. */
static const double min_coordinate_spacings = 1e-30;
/* How far points of one side of a sheet are moved from the other side while they are connected, in
 * spacings, and the passes that smooth these offsets. */
static const double sheet_offset_spacings = 1.5;
enum { SHEET_SMOOTHING_PASSES = 5 };

static void cloud_free(psplat_point_cloud *cloud) {
    free(cloud->positions);
    free(cloud->normals);
    free(cloud->kept);
    free(cloud->owners);
    free(cloud->kept_positions);
    free(cloud->kept_normals);
    free(cloud->neighbors);
    free(cloud->spacings);
    free(cloud->triangles);
}

void psplat_points_free(psplat_points *points) {
    if (!points) return;
    free(points->positions);
    free(points->normals);
    free(points->colors);
    *points = (psplat_points){0};
}

static psplat_result check_points(const psplat_points *points, psplat_error *error) {
    if (points->count == 0) return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "no points");
    if (points->count > PSPLAT_MAX_VERTICES)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%zu points; at most %u are read",
                           points->count, PSPLAT_MAX_VERTICES);
    for (size_t i = 0; i < 3 * points->count; ++i)
        if (!isfinite(points->positions[i]))
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                               "point %zu: a coordinate is not finite", i / 3);
    return PSPLAT_OK;
}

/* Centres the points and scales them to a diagonal of 1. */
static psplat_result centre(psplat_point_cloud *cloud, psplat_error *error) {
    const psplat_points *points = cloud->points;
    double low[3], high[3], extent[3];
    memcpy(low, points->positions, sizeof low);
    memcpy(high, points->positions, sizeof high);
    for (size_t i = 0; i < 3 * points->count; ++i) {
        low[i % 3] = min2(low[i % 3], points->positions[i]);
        high[i % 3] = max2(high[i % 3], points->positions[i]);
    }
    sub3(extent, high, low);
    cloud->unit = hypot(hypot(extent[0], extent[1]), extent[2]);
    if (!(cloud->unit > 0) || !isfinite(cloud->unit))
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "all points are at one place");
    for (int k = 0; k < 3; ++k) cloud->origin[k] = low[k] / 2 + high[k] / 2;
    for (size_t i = 0; i < 3 * points->count; ++i)
        cloud->positions[i] = (points->positions[i] - cloud->origin[i % 3]) / cloud->unit;
    return PSPLAT_OK;
}

static void normalise(psplat_point_cloud *cloud) {
    for (size_t i = 0; i < cloud->points->count && cloud->normals; ++i) {
        const float *from = cloud->points->normals + 3 * i;
        double n[3] = {(double)from[0], (double)from[1], (double)from[2]};
        double length = normalize3(n);
        for (size_t k = 0; k < 3; ++k)
            cloud->normals[3 * i + k] = isfinite(length) && length > 0 ? (float)n[k] : 0;
    }
}

/* ---- thinning -------------------------------------------------------------------------------- */

/* Chooses the points that are connected: all but near duplicates, or a thinned set of at most
 * MAX_CONNECTED. Returns 0 when out of memory. */
static int thin(psplat_point_cloud *cloud, const float *normals) {
    double radius =
        cloud->points->count > MAX_CONNECTED ? first_radius_diagonals : merge_distance_diagonals;
    do {
        cloud->kept_count = psplat_poisson_thin(cloud->positions, normals, cloud->points->count,
                                                radius, cloud->kept, cloud->owners);
        double radius_ratio = sqrt((double)cloud->kept_count / MAX_CONNECTED);
        radius = max2(first_radius_diagonals, radius * max2(min_radius_growth, 0.9 * radius_ratio));
    } while (cloud->kept_count > MAX_CONNECTED);
    return cloud->kept_count > 0;
}

static double distance(const double *positions, uint32_t a, uint32_t b) {
    double d[3];
    sub3(d, positions + 3 * (size_t)a, positions + 3 * (size_t)b);
    return length3(d);
}

/* Copies the kept points and finds their neighbours and spacings. */
static psplat_result find_neighbors(psplat_point_cloud *cloud) {
    size_t count = cloud->kept_count;
    for (size_t i = 0; i < count; ++i) {
        memcpy(cloud->kept_positions + 3 * i, cloud->positions + 3 * (size_t)cloud->kept[i],
               3 * sizeof(double));
        if (cloud->normals)
            memcpy(cloud->kept_normals + 3 * i, cloud->normals + 3 * (size_t)cloud->kept[i],
                   3 * sizeof(float));
    }
    psplat_result result = psplat_points_neighbors(cloud->kept_positions, count, cloud->neighbors);
    if (result) return result;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t *own = cloud->neighbors + PSPLAT_NEIGHBORS * (size_t)i;
        cloud->spacings[i] = 0;
        for (int k = 0; k < PSPLAT_NEIGHBORS && own[k] != PSPLAT_NO_POINT; ++k)
            cloud->spacings[i] = distance(cloud->kept_positions, i, own[k]);
    }
    return PSPLAT_OK;
}

static double normals_dot(const psplat_point_cloud *cloud, uint32_t a, uint32_t b) {
    const float *m = cloud->kept_normals + 3 * (size_t)a, *n = cloud->kept_normals + 3 * (size_t)b;
    return (double)(m[0] * n[0] + m[1] * n[1] + m[2] * n[2]);
}

/* Returns the distance of b from the tangent plane of a, in parts of their distance. */
static double relative_height(const psplat_point_cloud *cloud, uint32_t a, uint32_t b) {
    const float *n = cloud->kept_normals + 3 * (size_t)a;
    double d[3];
    sub3(d, cloud->kept_positions + 3 * (size_t)b, cloud->kept_positions + 3 * (size_t)a);
    double length = normalize3(d);
    double height = (double)n[0] * d[0] + (double)n[1] * d[1] + (double)n[2] * d[2];
    return length > 0 ? fabs(height) : 0;
}

/* Returns whether the normals agree about which side is outside. Those of two close sheets do as
 * well. */
static int normals_agree(const psplat_point_cloud *cloud) {
    size_t level = 0, opposed = 0;
    for (uint32_t i = 0; i < cloud->kept_count; ++i)
        for (int k = 0; k < PSPLAT_NEIGHBORS; ++k) {
            uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)i + (size_t)k];
            if (other == PSPLAT_NO_POINT) break;
            if (relative_height(cloud, i, other) > max_level_height) continue;
            ++level;
            opposed += normals_dot(cloud, i, other) < 0;
        }
    return (double)opposed <= max_opposed_fraction * (double)level;
}

/* Thins the points, separately for the two sides of sheets if the normals agree about the outside;
 * *sides is set then. */
static psplat_result choose_points(psplat_point_cloud *cloud, int *sides) {
    *sides = 0;
    if (!thin(cloud, cloud->normals)) return PSPLAT_ERROR_MEMORY;
    psplat_result result = find_neighbors(cloud);
    if (result || !cloud->normals) return result;
    *sides = normals_agree(cloud);
    if (*sides || cloud->kept_count == cloud->points->count) return PSPLAT_OK;
    if (!thin(cloud, NULL)) return PSPLAT_ERROR_MEMORY;
    return find_neighbors(cloud);
}

/* ---- the front ---------------------------------------------------------------------------- */

/* Scales the cloud to a median spacing of 1, since the front of CGAL has absolute thresholds.
 * Returns 0 when out of memory. */
static int rescale(psplat_point_cloud *cloud) {
    size_t count = cloud->kept_count;
    double *sorted = malloc((count + 1) * sizeof *sorted);
    if (!sorted) return 0;
    memcpy(sorted, cloud->spacings, count * sizeof *sorted);
    double median = psplat_points_median(sorted, count);
    free(sorted);
    if (!(median > 0)) return 1;
    cloud->unit *= median;
    for (size_t i = 0; i < 3 * cloud->points->count; ++i) cloud->positions[i] /= median;
    for (size_t i = 0; i < 3 * count; ++i) cloud->kept_positions[i] /= median;
    for (size_t i = 0; i < count; ++i) cloud->spacings[i] /= median;
    return 1;
}

/* Returns whether a neighbour faces the other way. */
static int is_opposed(const psplat_point_cloud *cloud, uint32_t point) {
    for (int k = 0; k < PSPLAT_NEIGHBORS; ++k) {
        uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)point + (size_t)k];
        if (other != PSPLAT_NO_POINT && normals_dot(cloud, point, other) < -0.5) return 1;
    }
    return 0;
}

static double mean_of_neighbors(const psplat_point_cloud *cloud, const double *values,
                                uint32_t point) {
    double sum = values[point], count = 1;
    for (int k = 0; k < PSPLAT_NEIGHBORS; ++k) {
        uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)point + (size_t)k];
        if (other != PSPLAT_NO_POINT) sum += values[other], ++count;
    }
    return sum / count;
}

/* Moves points that have neighbours on the other side of a thin sheet along their normals, so that
 * the front follows either side instead of running between them. The offset fades out around them.
 * Returns 0 when out of memory. */
static int separate_sheets(const psplat_point_cloud *cloud, double *positions) {
    size_t count = cloud->kept_count;
    double *shifts = malloc(2 * count * sizeof *shifts), *smooth = shifts + count;
    if (!shifts) return 0;
    for (uint32_t i = 0; i < count; ++i)
        shifts[i] = is_opposed(cloud, i) ? sheet_offset_spacings * cloud->spacings[i] : 0;
    for (int pass = 0; pass < SHEET_SMOOTHING_PASSES; ++pass) {
        for (uint32_t i = 0; i < count; ++i) smooth[i] = mean_of_neighbors(cloud, shifts, i);
        memcpy(shifts, smooth, count * sizeof *shifts);
    }
    for (size_t i = 0; i < 3 * count; ++i)
        positions[i] += shifts[i / 3] * (double)cloud->kept_normals[i];
    free(shifts);
    return 1;
}

/* Drops triangles whose corners are on a line up to the precision of double. */
static void drop_flat(psplat_point_cloud *cloud) {
    size_t kept = 0;
    for (size_t t = 0; t < cloud->triangle_count; ++t) {
        const uint32_t *corners = cloud->triangles + 3 * t;
        const double *a = cloud->kept_positions + 3 * (size_t)corners[0];
        double ab[3], ac[3], n[3];
        sub3(ab, cloud->kept_positions + 3 * (size_t)corners[1], a);
        sub3(ac, cloud->kept_positions + 3 * (size_t)corners[2], a);
        cross3(n, ab, ac);
        if (length3(n) <= 1e-12 * (dot3(ab, ab) + dot3(ac, ac))) continue;
        memmove(cloud->triangles + 3 * kept++, corners, 3 * sizeof *corners);
    }
    cloud->triangle_count = kept;
}

/* Orients the triangles by the normals if these agree, and outwards otherwise. */
static psplat_result orient(psplat_point_cloud *cloud, int sides) {
    size_t corners = 3 * cloud->triangle_count, borders = 0;
    psplat_mesh front = {.positions = cloud->kept_positions,
                         .triangles = cloud->triangles,
                         .vertex_count = cloud->kept_count,
                         .triangle_count = cloud->triangle_count,
                         .point_count = cloud->points->count};
    uint32_t *pairs = malloc((corners + 1) * sizeof *pairs);
    if (sides) front.corner_normals = malloc((corners + 1) * 3 * sizeof(float));
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (pairs && (!sides || front.corner_normals)) {
        for (size_t c = 0; c < corners && sides; ++c)
            memcpy(front.corner_normals + 3 * c,
                   cloud->kept_normals + 3 * (size_t)cloud->triangles[c], 3 * sizeof(float));
        int consistent = 0;
        result = psplat_mesh_orient(&front, &consistent, NULL);
        if (!result) result = psplat_edge_pairs(&front, pairs, &borders);
        cloud->closed = consistent && !borders;
    }
    free(front.corner_normals);
    free(pairs);
    return result;
}

static psplat_result estimate_normals(psplat_point_cloud *cloud) {
    cloud->kept_normals = malloc((3 * cloud->kept_count + 1) * sizeof(float));
    if (!cloud->kept_normals) return PSPLAT_ERROR_MEMORY;
    return psplat_points_estimate_normals(cloud, cloud->kept_normals);
}

/* Connects the kept points by triangles and estimates missing normals. */
static psplat_result connect(psplat_point_cloud *cloud, int sides) {
    size_t count = cloud->kept_count;
    if (count < 3) return PSPLAT_OK;
    double *positions = malloc(3 * count * sizeof(double));
    double *reaches = malloc(count * sizeof(double));
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (positions && reaches && rescale(cloud)) {
        result = psplat_points_smooth(cloud, sides);
        memcpy(positions, cloud->kept_positions, 3 * count * sizeof(double));
        for (size_t i = 0; i < 3 * count; ++i)
            if (fabs(positions[i]) < min_coordinate_spacings) positions[i] = 0;
        for (size_t i = 0; i < count; ++i) reaches[i] = max_edge_neighbors * cloud->spacings[i];
        if (!result && sides && !separate_sheets(cloud, positions)) result = PSPLAT_ERROR_MEMORY;
        if (!result)
            result = psplat_points_front(positions, reaches, sides ? cloud->kept_normals : NULL,
                                         count, &cloud->triangles, &cloud->triangle_count);
    }
    free(positions);
    free(reaches);
    if (result) return result;
    drop_flat(cloud);
    result = orient(cloud, sides);
    return result || cloud->normals ? result : estimate_normals(cloud);
}

static int cloud_allocate(psplat_point_cloud *cloud) {
    size_t count = cloud->points->count;
    cloud->positions = malloc(count * 3 * sizeof(double));
    cloud->kept = malloc(count * sizeof(uint32_t));
    cloud->owners = malloc(count * sizeof(uint32_t));
    cloud->kept_positions = malloc(count * 3 * sizeof(double));
    cloud->neighbors = malloc(count * PSPLAT_NEIGHBORS * sizeof(uint32_t));
    cloud->spacings = malloc(count * sizeof(double));
    if (cloud->points->normals) {
        cloud->normals = malloc(count * 3 * sizeof(float));
        cloud->kept_normals = malloc(count * 3 * sizeof(float));
        if (!cloud->normals || !cloud->kept_normals) return 0;
    }
    return cloud->positions && cloud->kept && cloud->owners && cloud->kept_positions &&
           cloud->neighbors && cloud->spacings;
}

/* Does all steps for a cloud that has no memory yet; the caller frees it. */
static psplat_result make_mesh(psplat_point_cloud *cloud, psplat_mesh *mesh, psplat_error *error) {
    psplat_result result = PSPLAT_ERROR_MEMORY;
    int sides;
    if (cloud_allocate(cloud)) {
        result = centre(cloud, error);
        if (result) return result;
        normalise(cloud);
        result = choose_points(cloud, &sides);
        if (!result) result = connect(cloud, sides);
    }
    if (result)
        return psplat_fail(error, result, 0, "%zu points do not fit into memory",
                           cloud->points->count);
    if (cloud->triangle_count == 0 && !cloud->normals)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0,
                           "%zu different points without normals span no surface",
                           cloud->kept_count);
    return psplat_points_attach(cloud, mesh, error);
}

psplat_result psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                      psplat_error *error) {
    *mesh = (psplat_mesh){0};
    psplat_point_cloud cloud = {.points = points};
    psplat_result result = check_points(points, error);
    if (!result) result = make_mesh(&cloud, mesh, error);
    cloud_free(&cloud);
    if (result) psplat_mesh_free(mesh);
    return result;
}
