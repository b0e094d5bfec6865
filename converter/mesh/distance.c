/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distance.c - point-to-mesh distances, by whichever tree there is.
 */
#include "mesh/distance.h"

#include "mesh/cgal_distance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One of the two is not NULL. */
struct psplat_distance {
    psplat_triangle_tree *tree;
    psplat_cgal_distance *cgal;
};

static psplat_distance *create(psplat_triangle_tree *tree, psplat_cgal_distance *cgal) {
    psplat_distance *distance = malloc(sizeof *distance);
    if (distance && (tree || cgal)) {
        *distance = (psplat_distance){tree, cgal};
        return distance;
    }
    psplat_triangle_tree_destroy(tree);
    psplat_cgal_distance_destroy(cgal);
    free(distance);
    return NULL;
}

psplat_distance *psplat_distance_create(const psplat_mesh *mesh) {
    return psplat_distance_create_connected(mesh, NULL);
}

psplat_distance *psplat_distance_create_connected(const psplat_mesh *mesh,
                                                  const uint32_t *neighbors) {
    return create(psplat_triangle_tree_create(mesh, neighbors), NULL);
}

psplat_distance *psplat_distance_create_cgal(const psplat_mesh *mesh) {
    return create(NULL, psplat_cgal_distance_create(mesh));
}

const psplat_triangle_tree *psplat_distance_tree(const psplat_distance *distance) {
    return distance->tree;
}

psplat_result psplat_distance_query(const psplat_distance *distance, const double *points,
                                    size_t count, double *result) {
    if (distance->cgal) return psplat_cgal_distance_query(distance->cgal, points, count, result);
    psplat_tree_nearest nearest = {.place = PSPLAT_NONE};
    for (size_t i = 0; i < count; ++i) {
        nearest.distance2 =
            HUGE_VAL; /* The nearest triangle of one point is a guess for the next. */
        psplat_triangle_tree_nearest(distance->tree, points + 3 * i, &nearest);
        result[i] = sqrt(nearest.distance2);
    }
    return PSPLAT_OK;
}

psplat_result psplat_distance_nearest(const psplat_distance *distance, const double point[3],
                                      double nearest[3], uint32_t *triangle) {
    if (distance->cgal)
        return psplat_cgal_distance_nearest(distance->cgal, point, nearest, triangle);
    psplat_tree_nearest found = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
    psplat_triangle_tree_nearest(distance->tree, point, &found);
    memcpy(nearest, found.point, sizeof found.point);
    *triangle = found.place == PSPLAT_NONE ? PSPLAT_NONE : distance->tree->triangles[found.place];
    return PSPLAT_OK;
}

static void store_corners(const psplat_triangle_tree *tree, uint32_t place, double corners[9]) {
    for (int k = 0; k < 3; ++k)
        memcpy(corners + 3 * k, psplat_tree_corner(tree, place, k), 3 * sizeof *corners);
}

psplat_result psplat_distance_nearest_corners(const psplat_distance *distance,
                                              const double point[3], double nearest[3],
                                              double corners[9]) {
    psplat_tree_nearest found = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
    uint32_t triangle;
    if (!distance->cgal) {
        psplat_triangle_tree_nearest(distance->tree, point, &found);
        memcpy(nearest, found.point, sizeof found.point);
        if (found.place == PSPLAT_NONE) /* no triangle, or a point that is not finite */
            for (int k = 0; k < 9; ++k) nearest[k % 3] = corners[k] = HUGE_VAL;
        else
            store_corners(distance->tree, found.place, corners);
        return PSPLAT_OK;
    }
    psplat_result result = psplat_cgal_distance_nearest(distance->cgal, point, nearest, &triangle);
    if (!result) psplat_cgal_distance_triangle(distance->cgal, triangle, corners);
    return result;
}

psplat_result psplat_distance_meets(const psplat_distance *distance, const double from[3],
                                    const double to[3], int *meets) {
    if (distance->cgal) return psplat_cgal_distance_meets(distance->cgal, from, to, meets);
    *meets = psplat_triangle_tree_meets(distance->tree, from, to);
    return PSPLAT_OK;
}

psplat_result psplat_distance_within(const psplat_distance *distance, const double *points,
                                     size_t count, double tolerance, int *within) {
    if (distance->cgal)
        return psplat_cgal_distance_within(distance->cgal, points, count, tolerance, within);
    uint32_t place = PSPLAT_NONE;
    *within = 1;
    for (size_t i = 0; i < count && *within; ++i)
        *within = psplat_triangle_tree_is_within(distance->tree, points + 3 * i, tolerance, &place);
    return PSPLAT_OK;
}

/* What a visit of a box hands on. */
typedef struct visitor {
    const psplat_triangle_tree *tree;
    int (*visit)(void *user, const double corners[9]);
    void *user;
} visitor;

static int visit_place(void *user, uint32_t place) {
    const visitor *v = user;
    double corners[9];
    store_corners(v->tree, place, corners);
    return v->visit(v->user, corners);
}

psplat_result psplat_distance_visit_box(const psplat_distance *distance, const double low[3],
                                        const double high[3],
                                        int (*visit)(void *user, const double corners[9]),
                                        void *user) {
    if (distance->cgal)
        return psplat_cgal_distance_visit_box(distance->cgal, low, high, visit, user);
    visitor v = {distance->tree, visit, user};
    psplat_triangle_tree_visit_box(distance->tree, low, high, visit_place, &v);
    return PSPLAT_OK;
}

void psplat_distance_destroy(psplat_distance *distance) {
    if (!distance) return;
    psplat_triangle_tree_destroy(distance->tree);
    psplat_cgal_distance_destroy(distance->cgal);
    free(distance);
}
