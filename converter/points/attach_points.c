/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * attach_points.c - the mesh of a reconstructed point set, with a triangle for every point.
 *
 * A point on the front gets a triangle that it is a corner of, a point beside it the nearest
 * triangle of its neighbours, and an isolated point a small disc of its own.
 */
#include "points/attach_points.h"

#include "base/angle.h"
#include "base/eigen.h"
#include "base/vector.h"
#include "mesh/mesh.h"
#include "points/point_cloud.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Chosen by hand. The greatest distance from the front of a point that belongs to it, in spacings
 * (distances to the farthest of the neighbours). */
static const double max_front_distance_spacings = 0.5;
/* The radius of discs, in distances to the nearest neighbour. */
static const double disc_radius_neighbors = 0.5;
/* A corner normal whose cosine with the triangle is less than this (40 degrees) belongs to the
 * other side of a crease. */
static const double same_side_cosine = 0.766;
/* That test is made if the noise is below this, in spacings. Noise turns triangles as far. */
static const double max_crease_noise_spacings = 0.03;

enum { DISC_TRIANGLES = 3 };

typedef struct attachment {
    const psplat_point_cloud *cloud;
    psplat_mesh *mesh;
    uint32_t *starts, *fans; /* triangles of kept point i: fans[starts[i] ... starts[i + 1] - 1] */
    uint32_t *owned;         /* triangle of each kept point */
    uint32_t *discs;         /* kept points that get a disc */
    size_t disc_count;
} attachment;

/* ---- triangles of points --------------------------------------------------------------------- */

static int find_fans(attachment *a) {
    const psplat_point_cloud *cloud = a->cloud;
    size_t count = cloud->kept_count, corners = 3 * cloud->triangle_count;
    a->starts = calloc(count + 2, sizeof(uint32_t));
    a->fans = malloc((corners + 1) * sizeof(uint32_t));
    if (!a->starts || !a->fans) return 0;
    uint32_t *ends = a->starts + 1; /* shifted by one, so that filling makes starts right */
    for (size_t c = 0; c < corners; ++c) ends[cloud->triangles[c] + 1]++;
    for (size_t i = 0; i < count; ++i) ends[i + 1] += ends[i];
    for (size_t c = 0; c < corners; ++c) a->fans[ends[cloud->triangles[c]]++] = (uint32_t)(c / 3);
    return 1;
}

static double segment_distance(const double p[3], const double a[3], const double b[3]) {
    double ab[3], ap[3];
    sub3(ab, b, a);
    sub3(ap, p, a);
    double squared = dot3(ab, ab), t = squared > 0 ? dot3(ap, ab) / squared : 0;
    mad3(ap, -min2(max2(t, 0), 1), ab);
    return length3(ap);
}

static double triangle_distance(const psplat_point_cloud *cloud, uint32_t triangle,
                                const double p[3]) {
    double corners[3][3], ab[3], ac[3], n[3], least = HUGE_VAL;
    int inside = 1;
    for (int k = 0; k < 3; ++k)
        memcpy(corners[k],
               cloud->kept_positions +
                   3 * (size_t)cloud->triangles[3 * (size_t)triangle + (size_t)k],
               sizeof corners[k]);
    sub3(ab, corners[1], corners[0]);
    sub3(ac, corners[2], corners[0]);
    cross3(n, ab, ac);
    for (int k = 0; k < 3; ++k) {
        double edge[3], inwards[3], d[3];
        sub3(edge, corners[(k + 1) % 3], corners[k]);
        cross3(inwards, n, edge);
        sub3(d, p, corners[k]);
        inside &= dot3(d, inwards) >= 0;
        least = min2(least, segment_distance(p, corners[k], corners[(k + 1) % 3]));
    }
    if (!inside) return least;
    normalize3(n);
    sub3(ab, p, corners[0]);
    return fabs(dot3(n, ab));
}

/* Updates *distance and *triangle if a triangle around a kept point is nearer. */
static void nearest_of_fan(const attachment *a, uint32_t point, const double p[3], double *distance,
                           uint32_t *triangle) {
    for (uint32_t i = a->starts[point]; i < a->starts[point + 1]; ++i) {
        double d = triangle_distance(a->cloud, a->fans[i], p);
        if (d >= *distance) continue;
        *distance = d;
        *triangle = a->fans[i];
    }
}

static void assign_kept_points(attachment *a) {
    const psplat_point_cloud *cloud = a->cloud;
    for (uint32_t i = 0; i < cloud->kept_count; ++i) {
        a->owned[i] = PSPLAT_NONE;
        const double *p = cloud->kept_positions + 3 * (size_t)i;
        double distance = max_front_distance_spacings * cloud->spacings[i];
        nearest_of_fan(a, i, p, &distance, &a->owned[i]);
        if (a->owned[i] != PSPLAT_NONE) continue;
        for (int k = 0; k < PSPLAT_NEIGHBORS; ++k) {
            uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)i + (size_t)k];
            if (other != PSPLAT_NO_POINT) nearest_of_fan(a, other, p, &distance, &a->owned[i]);
        }
        if (a->owned[i] != PSPLAT_NONE) continue;
        a->owned[i] = (uint32_t)(cloud->triangle_count + DISC_TRIANGLES * a->disc_count);
        a->discs[a->disc_count++] = i;
    }
}

static void assign_all_points(const attachment *a) {
    const psplat_point_cloud *cloud = a->cloud;
    for (size_t i = 0; i < cloud->points->count; ++i) {
        uint32_t owner = cloud->owners[i], triangle = a->owned[owner];
        double distance = HUGE_VAL;
        nearest_of_fan(a, owner, cloud->positions + 3 * i, &distance, &triangle);
        a->mesh->point_triangles[i] = triangle;
    }
}

/* ---- the mesh ------------------------------------------------------------------------------- */

static void store_position(const attachment *a, size_t vertex, const double p[3]) {
    for (size_t k = 0; k < 3; ++k) a->mesh->positions[3 * vertex + k] = a->cloud->unit * p[k];
}

static void store_corner(const attachment *a, size_t corner, uint32_t vertex, uint32_t kept,
                         const float normal[3]) {
    a->mesh->triangles[corner] = vertex;
    if (a->mesh->corner_normals)
        memcpy(a->mesh->corner_normals + 3 * corner, normal, 3 * sizeof *normal);
    if (a->mesh->corner_colors)
        memcpy(a->mesh->corner_colors + 4 * corner,
               a->cloud->points->colors + 4 * (size_t)a->cloud->kept[kept], 4 * sizeof(float));
}

static void front_normal(const psplat_point_cloud *cloud, uint32_t triangle, double n[3]) {
    const uint32_t *corners = cloud->triangles + 3 * (size_t)triangle;
    const double *p = cloud->kept_positions + 3 * (size_t)corners[0];
    double ab[3], ac[3];
    sub3(ab, cloud->kept_positions + 3 * (size_t)corners[1], p);
    sub3(ac, cloud->kept_positions + 3 * (size_t)corners[2], p);
    cross3(n, ab, ac);
}

/* Turns the normal of a point to the side that the front faces there. */
static void turn_normal(const attachment *a, uint32_t kept, double normal[3]) {
    double sum[3] = {0, 0, 0};
    for (uint32_t f = a->starts[kept]; f < a->starts[kept + 1]; ++f) {
        double n[3];
        front_normal(a->cloud, a->fans[f], n);
        mad3(sum, 1, n);
    }
    double side = dot3(sum, normal) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) normal[k] *= side;
}

/* Stores a corner of the front with the normal of its point, unless the file's normal belongs to
 * the other side of a crease. */
static void store_front_corner(const attachment *a, size_t corner, uint32_t vertex, uint32_t kept,
                               const double normal[3]) {
    static const float unknown[3] = {0, 0, 0};
    float stored[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
    double face[3];
    front_normal(a->cloud, (uint32_t)(corner / 3), face);
    normalize3(face);
    int across = a->cloud->normals && a->cloud->noise < max_crease_noise_spacings &&
                 dot3(face, normal) < same_side_cosine;
    store_corner(a, corner, vertex, kept, across ? unknown : stored);
}

static void store_front(const attachment *a) {
    const psplat_point_cloud *cloud = a->cloud;
    uint32_t used = 0;
    for (uint32_t i = 0; i < cloud->kept_count; ++i) {
        double normal[3] = {0, 0, 0};
        if (a->starts[i] == a->starts[i + 1]) continue;
        for (size_t k = 0; k < 3 && cloud->kept_normals; ++k)
            normal[k] = (double)cloud->kept_normals[3 * (size_t)i + k];
        turn_normal(a, i, normal);
        store_position(a, used, cloud->kept_positions + 3 * (size_t)i);
        for (uint32_t f = a->starts[i]; f < a->starts[i + 1]; ++f)
            for (uint32_t c = 3 * a->fans[f]; c < 3 * a->fans[f] + 3; ++c)
                if (cloud->triangles[c] == i) store_front_corner(a, c, used, i, normal);
        ++used;
    }
}

/* Computes the normal of an isolated point: the file's, or that of the plane through its
 * neighbours. */
static void disc_normal(const psplat_point_cloud *cloud, uint32_t kept, double normal[3]) {
    const double *p = cloud->kept_positions + 3 * (size_t)kept;
    double moments[6] = {0}, values[3], vectors[3][3];
    for (int k = 0; k < 3; ++k)
        normal[k] =
            cloud->kept_normals ? (double)cloud->kept_normals[3 * (size_t)kept + (size_t)k] : 0;
    if (normalize3(normal) > 0) return;
    for (int i = 0; i < PSPLAT_NEIGHBORS; ++i) {
        uint32_t other = cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)kept + (size_t)i];
        double d[3];
        if (other == PSPLAT_NO_POINT) break;
        sub3(d, cloud->kept_positions + 3 * (size_t)other, p);
        moments[0] += d[0] * d[0], moments[1] += d[0] * d[1], moments[2] += d[0] * d[2];
        moments[3] += d[1] * d[1], moments[4] += d[1] * d[2], moments[5] += d[2] * d[2];
    }
    psplat_eigen(moments, values, vectors);
    memcpy(normal, vectors[0], sizeof vectors[0]);
    if (dot3(normal, p) < 0)
        for (int k = 0; k < 3; ++k) normal[k] = -normal[k];
}

/* Stores a disc: three triangles around its point. */
static void store_disc(const attachment *a, size_t disc, size_t first_vertex) {
    const psplat_point_cloud *cloud = a->cloud;
    uint32_t kept = a->discs[disc];
    const double *p = cloud->kept_positions + 3 * (size_t)kept;
    double normal[3], u[3], v[3], nearest[3];
    disc_normal(cloud, kept, normal);
    perpendicular3(u, normal);
    cross3(v, normal, u);
    sub3(nearest,
         cloud->kept_positions + 3 * (size_t)cloud->neighbors[PSPLAT_NEIGHBORS * (size_t)kept], p);
    double radius = disc_radius_neighbors * length3(nearest);
    store_position(a, first_vertex, p);
    for (size_t k = 0; k < DISC_TRIANGLES; ++k) {
        double angle = 2 * PSPLAT_PI / DISC_TRIANGLES * (double)k, q[3];
        memcpy(q, p, sizeof q);
        mad3(q, radius * cos(angle), u);
        mad3(q, radius * sin(angle), v);
        store_position(a, first_vertex + 1 + k, q);
    }
    float stored[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
    size_t corner = 3 * (cloud->triangle_count + DISC_TRIANGLES * disc);
    for (uint32_t k = 0; k < DISC_TRIANGLES; ++k, corner += 3) {
        uint32_t centre = (uint32_t)first_vertex;
        store_corner(a, corner, centre, kept, stored);
        store_corner(a, corner + 1, centre + 1 + k, kept, stored);
        store_corner(a, corner + 2, centre + 1 + (k + 1) % DISC_TRIANGLES, kept, stored);
    }
}

static psplat_result store_mesh(attachment *a, psplat_error *error) {
    const psplat_point_cloud *cloud = a->cloud;
    size_t used = 0, count = cloud->points->count;
    unsigned parts = (cloud->kept_normals ? PSPLAT_MESH_NORMALS : 0u) |
                     (cloud->points->colors ? PSPLAT_MESH_COLORS : 0u);
    for (size_t i = 0; i < cloud->kept_count; ++i) used += a->starts[i] < a->starts[i + 1];
    psplat_result result =
        psplat_mesh_allocate(a->mesh, used + (DISC_TRIANGLES + 1) * a->disc_count,
                             cloud->triangle_count + DISC_TRIANGLES * a->disc_count, parts, error);
    if (result) return result;
    a->mesh->points = malloc(count * 3 * sizeof(double));
    a->mesh->point_triangles = malloc(count * sizeof(uint32_t));
    if (!a->mesh->points || !a->mesh->point_triangles)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu points", count);
    a->mesh->point_count = count;
    memcpy(a->mesh->origin, cloud->origin, sizeof cloud->origin);
    for (size_t i = 0; i < 3 * count; ++i) a->mesh->points[i] = cloud->unit * cloud->positions[i];
    store_front(a);
    for (size_t i = 0; i < a->disc_count; ++i) store_disc(a, i, used + (DISC_TRIANGLES + 1) * i);
    assign_all_points(a);
    a->mesh->material.double_sided = !cloud->closed || a->disc_count > 0;
    return PSPLAT_OK;
}

psplat_result psplat_points_attach(const psplat_point_cloud *cloud, psplat_mesh *mesh,
                                   psplat_error *error) {
    size_t count = cloud->kept_count;
    attachment a = {.cloud = cloud, .mesh = mesh};
    a.owned = malloc(count * sizeof(uint32_t));
    a.discs = malloc(count * sizeof(uint32_t));
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (a.owned && a.discs && find_fans(&a)) {
        assign_kept_points(&a);
        result = store_mesh(&a, error);
    } else {
        psplat_fail(error, result, 0, "%zu points do not fit into memory", cloud->points->count);
    }
    free(a.starts);
    free(a.fans);
    free(a.owned);
    free(a.discs);
    return result;
}
