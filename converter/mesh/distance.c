/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distance.c - point-to-mesh distances, by whichever tree there is.
 */
#include "mesh/distance.h"

#include "mesh/cgal_distance.h"
#include "mesh/morton_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One of the three is not NULL. */
struct psplat_distance {
    psplat_triangle_tree *tree;
    psplat_cgal_distance *cgal;
    psplat_morton_tree *morton;
};

/* Takes what one of the trees is in. */
static psplat_distance *create(psplat_distance trees) {
    psplat_distance *distance = malloc(sizeof *distance);
    if (distance && (trees.tree || trees.cgal || trees.morton)) {
        *distance = trees;
        return distance;
    }
    psplat_triangle_tree_destroy(trees.tree);
    psplat_cgal_distance_destroy(trees.cgal);
    psplat_morton_tree_destroy(trees.morton);
    free(distance);
    return NULL;
}

psplat_distance *psplat_distance_create(const psplat_mesh *mesh) {
    return psplat_distance_create_connected(mesh, NULL);
}

psplat_distance *psplat_distance_create_connected(const psplat_mesh *mesh,
                                                  const uint32_t *neighbors) {
    return create((psplat_distance){.tree = psplat_triangle_tree_create(mesh, neighbors)});
}

psplat_distance *psplat_distance_create_cgal(const psplat_mesh *mesh) {
    return create((psplat_distance){.cgal = psplat_cgal_distance_create(mesh)});
}

psplat_distance *psplat_distance_create_check(const psplat_mesh *mesh) {
    return create((psplat_distance){.morton = psplat_morton_tree_create(mesh)});
}

const psplat_triangle_tree *psplat_distance_tree(const psplat_distance *distance) {
    return distance->tree;
}

psplat_result psplat_distance_query(const psplat_distance *distance, const double *points,
                                    size_t count, double *result) {
    if (distance->cgal) return psplat_cgal_distance_query(distance->cgal, points, count, result);
    psplat_tree_nearest nearest = {.place = PSPLAT_NONE};
    for (size_t i = 0; i < count; ++i) {
        if (distance->morton) {
            result[i] = psplat_morton_tree_nearest(distance->morton, points + 3 * i, HUGE_VAL,
                                                   nearest.point, &nearest.place);
            continue;
        }
        nearest.distance2 =
            HUGE_VAL; /* The nearest triangle of one point is a guess for the next. */
        psplat_triangle_tree_nearest(distance->tree, points + 3 * i, &nearest);
        result[i] = sqrt(nearest.distance2);
    }
    return PSPLAT_OK;
}

psplat_result psplat_distance_nearest(const psplat_distance *distance, const double point[3],
                                      uint32_t *guess, double nearest[3], uint32_t *triangle) {
    if (distance->cgal)
        return psplat_cgal_distance_nearest(distance->cgal, point, nearest, triangle);
    if (distance->morton) {
        psplat_morton_tree_nearest(distance->morton, point, HUGE_VAL, nearest, triangle);
        return PSPLAT_OK;
    }
    psplat_tree_nearest found = {.distance2 = HUGE_VAL, .place = *guess};
    psplat_triangle_tree_nearest(distance->tree, point, &found);
    memcpy(nearest, found.point, sizeof found.point);
    *guess = found.place;
    *triangle = found.place == PSPLAT_NONE ? PSPLAT_NONE : distance->tree->triangles[found.place];
    return PSPLAT_OK;
}

static void store_corners(const psplat_triangle_tree *tree, uint32_t place, double corners[9]) {
    for (int k = 0; k < 3; ++k)
        memcpy(corners + 3 * k, psplat_tree_corner(tree, place, k), 3 * sizeof *corners);
}

static void store_mesh_corners(const psplat_mesh *mesh, uint32_t triangle, double corners[9]) {
    for (size_t k = 0; k < 3; ++k)
        memcpy(corners + 3 * k,
               mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + k],
               3 * sizeof *corners);
}

/* Finds the nearest point in a tree of our own, and the corners of its triangle. Returns 0 where
 * there is no triangle, or the point is not finite. */
static int find_own(const psplat_distance *distance, const double point[3], uint32_t *guess,
                    double nearest[3], double corners[9]) {
    uint32_t triangle;
    if (distance->morton) {
        psplat_morton_tree_nearest(distance->morton, point, HUGE_VAL, nearest, &triangle);
        if (triangle == PSPLAT_NONE) return 0;
        store_mesh_corners(psplat_morton_tree_mesh(distance->morton), triangle, corners);
        return 1;
    }
    psplat_tree_nearest found = {.distance2 = HUGE_VAL, .place = *guess};
    psplat_triangle_tree_nearest(distance->tree, point, &found);
    if (found.place == PSPLAT_NONE) return 0;
    *guess = found.place;
    memcpy(nearest, found.point, sizeof found.point);
    store_corners(distance->tree, found.place, corners);
    return 1;
}

psplat_result psplat_distance_nearest_corners(const psplat_distance *distance,
                                              const double point[3], uint32_t *guess,
                                              double nearest[3], double corners[9]) {
    uint32_t triangle;
    if (!distance->cgal) {
        if (!find_own(distance, point, guess, nearest, corners))
            for (int k = 0; k < 9; ++k) nearest[k % 3] = corners[k] = HUGE_VAL;
        return PSPLAT_OK;
    }
    psplat_result result = psplat_cgal_distance_nearest(distance->cgal, point, nearest, &triangle);
    if (!result) psplat_cgal_distance_triangle(distance->cgal, triangle, corners);
    return result;
}

psplat_result psplat_distance_meets(const psplat_distance *distance, const double from[3],
                                    const double to[3], int *meets) {
    if (distance->cgal) return psplat_cgal_distance_meets(distance->cgal, from, to, meets);
    *meets = distance->morton ? psplat_morton_tree_meets(distance->morton, from, to)
                              : psplat_triangle_tree_meets(distance->tree, from, to);
    return PSPLAT_OK;
}

psplat_result psplat_distance_is_within(const psplat_distance *distance, const double point[3],
                                        double tolerance, uint32_t *guess, int *within) {
    if (distance->cgal)
        return psplat_cgal_distance_within(distance->cgal, point, 1, tolerance, within);
    double at[3];
    *within = distance->morton
                  ? psplat_morton_tree_nearest(distance->morton, point, tolerance * (1 + 1e-12), at,
                                               guess) <= tolerance
                  : psplat_triangle_tree_is_within(distance->tree, point, tolerance, guess);
    return PSPLAT_OK;
}

psplat_result psplat_distance_within(const psplat_distance *distance, const double *points,
                                     size_t count, double tolerance, int *within) {
    if (distance->cgal)
        return psplat_cgal_distance_within(distance->cgal, points, count, tolerance, within);
    uint32_t guess = PSPLAT_NONE;
    psplat_result result = PSPLAT_OK;
    *within = 1;
    for (size_t i = 0; i < count && *within && !result; ++i)
        result = psplat_distance_is_within(distance, points + 3 * i, tolerance, &guess, within);
    return result;
}

/* What a visit of a box hands on. */
typedef struct visitor {
    const psplat_distance *distance;
    int (*visit)(void *user, const double corners[9]);
    void *user;
} visitor;

static int visit_place(void *user, uint32_t place) {
    const visitor *v = user;
    double corners[9];
    store_corners(v->distance->tree, place, corners);
    return v->visit(v->user, corners);
}

static int visit_triangle(void *user, uint32_t triangle) {
    const visitor *v = user;
    double corners[9];
    store_mesh_corners(psplat_morton_tree_mesh(v->distance->morton), triangle, corners);
    return v->visit(v->user, corners);
}

psplat_result psplat_distance_visit_box(const psplat_distance *distance, const double low[3],
                                        const double high[3],
                                        int (*visit)(void *user, const double corners[9]),
                                        void *user) {
    if (distance->cgal)
        return psplat_cgal_distance_visit_box(distance->cgal, low, high, visit, user);
    visitor v = {distance, visit, user};
    if (distance->morton)
        psplat_morton_tree_visit_box(distance->morton, low, high, visit_triangle, &v);
    else
        psplat_triangle_tree_visit_box(distance->tree, low, high, visit_place, &v);
    return PSPLAT_OK;
}

void psplat_distance_destroy(psplat_distance *distance) {
    if (!distance) return;
    psplat_triangle_tree_destroy(distance->tree);
    psplat_cgal_distance_destroy(distance->cgal);
    psplat_morton_tree_destroy(distance->morton);
    free(distance);
}
