/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * wire_width.c - how wide the wires are of which a mesh consists.
 *
 * The integral of the mean curvature over a polyhedron is half the sum, over its edges, of length
 * times angle (Steiner's formula), positive where the edge is convex. Of a tube of length L that is
 * pi L however it bends, and its area is pi L times its diameter. Of a plate it is pi times the sum
 * of its length and its width, so that a quotient as small as its thickness never results.
 */
#include "mesh/wire_width.h"

#include "base/vector.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* How many times its width a wire is long at least, along the diagonal of its box. Of a ball that
 * is 3.5 and of a cube 2.7, of a thin plate 4.4 where it is square and 8 where it is four times as
 * long as wide. Chosen by hand. */
static const double least_length_widths = 8;

/* The least sum of curvatures as a part of the sum of their absolute values: a wire is convex but
 * for grooves and the insides of bends. Chosen by hand. */
static const double least_convex_part = 0.4;

/* The part of its area that a wire shows to one side more than to the other at most: it has a
 * surface all around, where a sheet has one side alone. Chosen by hand. */
static const double most_open_part = 0.5;

/* The cosine from which on two triangles are the sides of a sheet: rounding would tell which way
 * they turn, but a rim of it is convex. */
static const double back_cosine = -1 + 1e-9;

/* What is known of a component. */
typedef struct component {
    double area, curvature, absolute; /* the integral of the mean curvature, and of its absolute
                                         value; lengths */
    double facing[3];                 /* the sum of areas times normals */
    double low[3], high[3];           /* its box */
    double width;                     /* HUGE_VAL: it is no wire */
} component;

/* Components are trees of triangles, whose roots stand for them. */
typedef struct forest {
    const psplat_mesh *mesh;
    uint32_t *parents; /* by triangle */
    double *normals;   /* by triangle: unit, or 0 */
    component *components;
} forest;

static uint32_t root_of(const forest *f, uint32_t triangle) {
    uint32_t *parents = f->parents;
    while (parents[triangle] != triangle) {
        parents[triangle] = parents[parents[triangle]];
        triangle = parents[triangle];
    }
    return triangle;
}

/* Makes each triangle a component. */
static void begin_components(forest *f) {
    for (uint32_t t = 0; t < f->mesh->triangle_count; ++t) {
        double sides[2][3], *normal = f->normals + 3 * (size_t)t;
        component *c = &f->components[t];
        f->parents[t] = t;
        for (int k = 0; k < 2; ++k)
            sub3(sides[k], psplat_mesh_corner(f->mesh, t, k + 1),
                 psplat_mesh_corner(f->mesh, t, 0));
        cross3(normal, sides[0], sides[1]);
        *c = (component){.area = normalize3(normal) / 2};
        mad3(c->facing, c->area, normal);
        for (int k = 0; k < 3; ++k) {
            c->low[k] = HUGE_VAL, c->high[k] = -HUGE_VAL;
            for (int corner = 0; corner < 3; ++corner) {
                double x = psplat_mesh_corner(f->mesh, t, corner)[k];
                c->low[k] = min2(c->low[k], x), c->high[k] = max2(c->high[k], x);
            }
        }
    }
}

/* Joins the triangles at an edge, and adds its curvature to one of them. Triangles of which one is
 * turned over are two components. */
static void join_at(forest *f, uint32_t edge, uint32_t other) {
    if (f->mesh->triangles[edge] == f->mesh->triangles[other]) return;
    uint32_t t = edge / 3, across = other / 3;
    const double *n = f->normals + 3 * (size_t)t, *m = f->normals + 3 * (size_t)across;
    double along[3], turn[3];
    psplat_edge_vector(f->mesh, edge, along);
    cross3(turn, n, m);
    double angle = atan2(length3(turn), dot3(n, m));
    int is_concave = dot3(n, m) > back_cosine && dot3(turn, along) < 0;
    /* The edge runs with its triangle to the left, so that a convex one turns along it. */
    f->components[t].absolute += length3(along) * angle / 2;
    f->components[t].curvature += length3(along) * (is_concave ? -angle : angle) / 2;
    f->parents[root_of(f, t)] = root_of(f, across);
}

/* Adds up the triangles of components in the roots, and finds the widths of those that are wires.
 * Returns the whole area. */
static double finish_components(forest *f) {
    double area = 0;
    for (uint32_t t = 0; t < f->mesh->triangle_count; ++t) {
        component *c = &f->components[t], *root = &f->components[root_of(f, t)];
        c->width = HUGE_VAL;
        if (c == root) continue;
        root->area += c->area;
        root->curvature += c->curvature, root->absolute += c->absolute;
        mad3(root->facing, 1, c->facing);
        for (int k = 0; k < 3; ++k) {
            root->low[k] = min2(root->low[k], c->low[k]);
            root->high[k] = max2(root->high[k], c->high[k]);
        }
    }
    for (uint32_t t = 0; t < f->mesh->triangle_count; ++t) {
        component *c = &f->components[t];
        if (f->parents[t] != t) continue;
        area += c->area;
        int is_convex = c->curvature > least_convex_part * c->absolute;
        int is_around = length3(c->facing) <= most_open_part * c->area;
        double width = is_convex && is_around ? c->area / c->curvature : HUGE_VAL;
        if (sqrt(distance2_3(c->low, c->high)) >= least_length_widths * width) c->width = width;
    }
    return area;
}

static int compare_widths(const void *left, const void *right) {
    const component *a = left, *b = right;
    return a->width < b->width ? -1 : a->width > b->width;
}

/* Returns the width that the narrowest wires have which make up a part of the area. */
static double width_at(forest *f, double part) {
    size_t count = f->mesh->triangle_count, wires = 0;
    double sum = 0;
    for (size_t t = 0; t < count; ++t)
        if (f->components[t].width < HUGE_VAL) f->components[wires++] = f->components[t];
    qsort(f->components, wires, sizeof *f->components, compare_widths);
    for (size_t i = 0; i < wires; ++i) {
        sum += f->components[i].area;
        if (sum >= part) return f->components[i].width;
    }
    return HUGE_VAL;
}

psplat_result psplat_mesh_wire_width(const psplat_mesh *mesh, double *width) {
    size_t count = mesh->triangle_count, borders;
    uint32_t *pairs = malloc((3 * count + 1) * sizeof *pairs);
    forest f = {.mesh = mesh,
                .parents = malloc((count + 1) * sizeof *f.parents),
                .normals = malloc((3 * count + 1) * sizeof *f.normals),
                .components = malloc((count + 1) * sizeof *f.components)};
    psplat_result result =
        pairs && f.parents && f.normals && f.components ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    *width = HUGE_VAL;
    if (!result) result = psplat_edge_pairs(mesh, pairs, &borders);
    if (!result) {
        begin_components(&f);
        for (uint32_t e = 0; e < 3 * count; ++e)
            if (pairs[e] != PSPLAT_NONE && e < pairs[e]) join_at(&f, e, pairs[e]);
        *width = width_at(&f, finish_components(&f) / 2);
    }
    free(pairs);
    free(f.parents);
    free(f.normals);
    free(f.components);
    return result;
}
