/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * normal_estimate.c - normal estimation and smoothing of point sets by quadrics (osculating jets).
 *
 * A quadric is fitted by least squares to the height over a plane of the points around each point
 * (Cazals, Pouget 2005). Its gradient gives the normal, and its distance from the points the noise.
 */
#include "points/normal_estimate.h"

#include "base/eigen.h"
#include "base/vector.h"
#include "points/point_cloud.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The coefficients of a quadric, and the numbers of points that it is fitted to. Rings of edges are
 * added until there are RING_POINTS, or NOISY_POINTS where there is noise. */
enum { TERMS = 6, MIN_POINTS = 9, RING_POINTS = 16, NOISY_POINTS = 60, MAX_POINTS = 96 };

/* Limits of the root mean square distance of a quadric from its points, in spacings. Over the
 * first, the quadric is fitted again to more points against noise. Over the second, and over this
 * multiple of the median of the set, it runs across a crease. The median is 0.028 for the vertices
 * of the bunny and 0.07 for those of the armadillo. */
static const double noisy_residual_spacings = 0.03;
static const double crease_residual_spacings = 0.06;
static const double crease_residual_medians = 2.5;
/* A set with a greater median, in spacings, is smoothed in this many passes. A front through points
 * with a noise of a third of their spacing crumples. */
static const double smoothing_noise_spacings = 0.1;
enum { SMOOTHING_PASSES = 2 };

typedef struct jet_state {
    const psplat_point_cloud *cloud;
    uint32_t *starts, *links; /* neighbours of point i: links[starts[i] ... starts[i + 1] - 1] */
    uint32_t *marks, mark;    /* marks[i] is mark if this search has met point i */
    uint32_t near[MAX_POINTS];
    size_t near_count;
    double *normals; /* x 3: sums over the fans of triangles, of any length */
} jet_state;

static void jet_free(jet_state *jet) {
    free(jet->starts);
    free(jet->links);
    free(jet->marks);
    free(jet->normals);
}

static int allocate(jet_state *jet, size_t links) {
    size_t count = jet->cloud->kept_count;
    jet->starts = calloc(count + 2, sizeof(uint32_t));
    jet->links = malloc((links + 1) * sizeof(uint32_t));
    jet->marks = calloc(count, sizeof(uint32_t));
    jet->normals = calloc(3 * count, sizeof(double));
    return jet->starts && jet->links && jet->marks && jet->normals;
}

/* Links the points that the edges of the front connect. Returns 0 when out of memory. */
static int link_front(jet_state *jet) {
    const psplat_point_cloud *cloud = jet->cloud;
    size_t count = cloud->kept_count, corners = 3 * cloud->triangle_count;
    if (!allocate(jet, 2 * corners)) return 0;
    uint32_t *ends = jet->starts + 1; /* shifted by one, so that filling makes starts right */
    for (size_t c = 0; c < corners; ++c) ends[cloud->triangles[c] + 1] += 2;
    for (size_t i = 0; i < count; ++i) ends[i + 1] += ends[i];
    for (size_t c = 0; c < corners; ++c) {
        const uint32_t *t = cloud->triangles + c - c % 3;
        uint32_t *end = &ends[t[c % 3]];
        jet->links[(*end)++] = t[(c + 1) % 3];
        jet->links[(*end)++] = t[(c + 2) % 3];
    }
    return 1;
}

/* Sums the area-weighted normals of the triangles around each point. */
static void sum_fans(jet_state *jet) {
    const psplat_point_cloud *cloud = jet->cloud;
    for (size_t t = 0; t < cloud->triangle_count; ++t) {
        const uint32_t *corners = cloud->triangles + 3 * t;
        const double *a = cloud->kept_positions + 3 * (size_t)corners[0];
        double ab[3], ac[3], n[3];
        sub3(ab, cloud->kept_positions + 3 * (size_t)corners[1], a);
        sub3(ac, cloud->kept_positions + 3 * (size_t)corners[2], a);
        cross3(n, ab, ac);
        for (int k = 0; k < 3; ++k) mad3(jet->normals + 3 * (size_t)corners[k], 1, n);
    }
}

/* Gathers rings of points around a point until there are as many as wanted. */
static void gather(jet_state *jet, uint32_t point, size_t wanted) {
    size_t ring = 0;
    jet->near[0] = point;
    jet->near_count = 1;
    jet->marks[point] = ++jet->mark;
    while (ring < jet->near_count && jet->near_count < wanted) {
        size_t end = jet->near_count;
        for (; ring < end; ++ring) {
            uint32_t from = jet->near[ring];
            for (uint32_t l = jet->starts[from]; l < jet->starts[from + 1]; ++l) {
                uint32_t other = jet->links[l];
                if (jet->marks[other] == jet->mark || jet->near_count == MAX_POINTS) continue;
                jet->marks[other] = jet->mark;
                jet->near[jet->near_count++] = other;
            }
        }
    }
}

/* Solves the symmetric system matrix x = right in place by Cholesky decomposition. Returns 0 if the
 * points do not determine the solution. */
static int solve(double matrix[TERMS][TERMS], double right[TERMS]) {
    for (int j = 0; j < TERMS; ++j) {
        double pivot = matrix[j][j];
        for (int k = 0; k < j; ++k) pivot -= matrix[j][k] * matrix[j][k];
        if (!(pivot > 1e-9 * matrix[j][j])) return 0;
        matrix[j][j] = sqrt(pivot);
        for (int i = j + 1; i < TERMS; ++i) {
            for (int k = 0; k < j; ++k) matrix[i][j] -= matrix[i][k] * matrix[j][k];
            matrix[i][j] /= matrix[j][j];
        }
    }
    for (int i = 0; i < TERMS; ++i) {
        for (int k = 0; k < i; ++k) right[i] -= matrix[i][k] * right[k];
        right[i] /= matrix[i][i];
    }
    for (int i = TERMS - 1; i >= 0; --i) {
        for (int k = i + 1; k < TERMS; ++k) right[i] -= matrix[k][i] * right[k];
        right[i] /= matrix[i][i];
    }
    return 1;
}

static void terms_of(const double d[3], const double u[3], const double v[3], double terms[TERMS]) {
    double s = dot3(d, u), t = dot3(d, v);
    terms[0] = 1, terms[1] = s, terms[2] = t;
    terms[3] = s * s, terms[4] = s * t, terms[5] = t * t;
}

/* Fits a quadric over the plane of a normal, turns the normal to that of the quadric at the point,
 * and stores the height of the quadric there. Returns the root mean square distance of the quadric
 * from the points, or a negative number if the points determine none. */
static double fit(const jet_state *jet, double normal[3], double *height_there) {
    double u[3], v[3], matrix[TERMS][TERMS] = {{0}}, right[TERMS] = {0}, squares = 0, fitted = 0;
    perpendicular3(u, normal);
    cross3(v, normal, u);
    const double *origin = jet->cloud->kept_positions + 3 * (size_t)jet->near[0];
    if (jet->near_count < MIN_POINTS) return -1;
    double sums[TERMS] = {0};
    for (size_t i = 0; i < jet->near_count; ++i) {
        double d[3], terms[TERMS];
        sub3(d, jet->cloud->kept_positions + 3 * (size_t)jet->near[i], origin);
        terms_of(d, u, v, terms);
        double height = dot3(d, normal);
        squares += height * height;
        for (int a = 0; a < TERMS; ++a) {
            right[a] += height * terms[a];
            for (int b = 0; b <= a; ++b) matrix[a][b] += terms[a] * terms[b];
        }
    }
    memcpy(sums, right, sizeof sums);
    if (!solve(matrix, right)) return -1;
    for (int a = 0; a < TERMS; ++a) fitted += right[a] * sums[a];
    mad3(normal, -right[1], u);
    mad3(normal, -right[2], v);
    normalize3(normal);
    *height_there = right[0];
    return sqrt(max2(squares - fitted, 0) / (double)jet->near_count);
}

/* Stores the normal of a point, or 0 0 0 at a crease, where each side has a normal of its own. */
static void find_normal(jet_state *jet, uint32_t point, float *result) {
    double normal[3], refined[3], height;
    memcpy(normal, jet->normals + 3 * (size_t)point, sizeof normal);
    if (normalize3(normal) > 0) {
        gather(jet, point, RING_POINTS);
        memcpy(refined, normal, sizeof refined);
        double residual = fit(jet, refined, &height) / jet->cloud->spacings[point];
        if (residual >
            max2(crease_residual_spacings, crease_residual_medians * jet->cloud->noise)) {
            memset(refined, 0, sizeof refined);
        } else if (residual > noisy_residual_spacings) {
            gather(jet, point, NOISY_POINTS);
            fit(jet, refined, &height);
        }
        if (residual >= 0) memcpy(normal, refined, sizeof normal);
    }
    for (int k = 0; k < 3; ++k) result[k] = (float)normal[k];
}

psplat_result psplat_points_estimate_normals(const psplat_point_cloud *cloud, float *normals) {
    jet_state jet = {.cloud = cloud};
    int ok = link_front(&jet);
    if (ok) sum_fans(&jet);
    for (uint32_t i = 0; ok && i < cloud->kept_count; ++i)
        find_normal(&jet, i, normals + 3 * (size_t)i);
    jet_free(&jet);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* ---- noise ---------------------------------------------------------------------------------- */

static int is_opposed(const psplat_point_cloud *cloud, uint32_t a, uint32_t b) {
    const float *m = cloud->kept_normals + 3 * (size_t)a, *n = cloud->kept_normals + 3 * (size_t)b;
    return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < 0;
}

/* Links the nearest points, only those on the same side of a sheet if sides is set. Returns 0 when
 * out of memory. */
static int link_nearest(jet_state *jet, int sides) {
    const psplat_point_cloud *cloud = jet->cloud;
    size_t links = 0;
    if (!allocate(jet, cloud->kept_count * PSPLAT_NEIGHBORS)) return 0;
    for (uint32_t i = 0; i < cloud->kept_count; ++i) {
        for (int k = 0; k < PSPLAT_NEIGHBORS; ++k) {
            uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)i + (size_t)k];
            if (other == PSPLAT_NO_POINT || (sides && is_opposed(cloud, i, other))) continue;
            jet->links[links++] = other;
        }
        jet->starts[i + 1] = (uint32_t)links;
    }
    return 1;
}

/* Computes the normal of the least-squares plane through the points gathered. */
static void fit_plane(const jet_state *jet, double normal[3]) {
    double mean[3] = {0, 0, 0}, moments[6] = {0}, values[3], vectors[3][3];
    const double *positions = jet->cloud->kept_positions;
    for (size_t i = 0; i < jet->near_count; ++i)
        mad3(mean, 1 / (double)jet->near_count, positions + 3 * (size_t)jet->near[i]);
    for (size_t i = 0; i < jet->near_count; ++i) {
        double d[3];
        sub3(d, positions + 3 * (size_t)jet->near[i], mean);
        moments[0] += d[0] * d[0], moments[1] += d[0] * d[1], moments[2] += d[0] * d[2];
        moments[3] += d[1] * d[1], moments[4] += d[1] * d[2], moments[5] += d[2] * d[2];
    }
    psplat_eigen(moments, values, vectors);
    memcpy(normal, vectors[0], sizeof vectors[0]);
}

/* Fits a quadric around every point. Stores its distance from the points, in spacings, in
 * residuals, and the point moved onto it in smooth. */
static void fit_all(jet_state *jet, size_t wanted, double *residuals, double *smooth) {
    const psplat_point_cloud *cloud = jet->cloud;
    for (uint32_t i = 0; i < cloud->kept_count; ++i) {
        double normal[3], plane[3], height = 0;
        gather(jet, i, wanted);
        fit_plane(jet, normal);
        memcpy(plane, normal, sizeof plane);
        double residual = fit(jet, normal, &height);
        residuals[i] = max2(residual, 0) / cloud->spacings[i];
        memcpy(smooth + 3 * (size_t)i, cloud->kept_positions + 3 * (size_t)i, 3 * sizeof(double));
        /* A quadric farther away than the neighbours is a bad fit and is not used. */
        if (residual >= 0 && fabs(height) < cloud->spacings[i])
            mad3(smooth + 3 * (size_t)i, height, plane);
    }
}

psplat_result psplat_points_smooth(psplat_point_cloud *cloud, int sides) {
    jet_state jet = {.cloud = cloud};
    size_t count = cloud->kept_count;
    double *residuals = malloc(count * sizeof *residuals);
    double *smooth = malloc(3 * count * sizeof *smooth);
    int ok = residuals && smooth && link_nearest(&jet, sides);
    if (ok) {
        fit_all(&jet, RING_POINTS, residuals, smooth);
        cloud->noise = psplat_points_median(residuals, count);
        int passes = cloud->noise > smoothing_noise_spacings ? SMOOTHING_PASSES : 0;
        for (int pass = 0; pass < passes; ++pass) {
            fit_all(&jet, NOISY_POINTS, residuals, smooth);
            memcpy(cloud->kept_positions, smooth, 3 * count * sizeof *smooth);
        }
    }
    free(residuals);
    free(smooth);
    jet_free(&jet);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
