/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * morton_tree.c - a small tree of boxes over the triangles of a mesh, with which splats are
 * checked.
 *
 * Triangles are sorted by the Morton codes of their middles, and boxes hold four neighbours in that
 * order, then four such boxes, and so on (a linear bounding volume hierarchy, Lauterbach et al.
 * 2009). So nothing but boxes and the order is stored.
 */
#include "mesh/morton_tree.h"

#include "base/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The children of a node and the triangles of a leaf; levels for 2^32 triangles. */
enum { WIDTH = 4, LEVELS = 17, STACK = WIDTH * LEVELS };

/* The bits of a Morton code for each axis, and those of a digit of the sort. */
enum { AXIS_BITS = 16, DIGIT_BITS = 8, DIGITS = 3 * AXIS_BITS / DIGIT_BITS };

/* The squared sine of a corner below which barycentric coordinates of a triangle lose too many
 * digits, and that below which its plane does. */
static const double thin_part = 1e-6, flat_part = 1e-16;

typedef struct box {
    float low[3], high[3]; /* rounded outwards */
} box;

struct psplat_morton_tree {
    const psplat_mesh *mesh;
    uint32_t *order; /* triangles by their codes */
    box *boxes;
    size_t first[LEVELS + 1]; /* the first box of each level, leaves first */
    int levels;               /* the last one has one box; 0 without triangles */
};

/* A triangle and the code of its middle. */
typedef struct coded {
    uint64_t code;
    uint32_t triangle;
} coded;

static const double *corner_of(const psplat_mesh *mesh, uint32_t triangle, size_t k) {
    return mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + k];
}

/* ---- building ------------------------------------------------------------------------------- */

/* Spreads the lowest 16 bits, so that two zeros follow each. */
static uint64_t spread(uint64_t x) {
    x = (x | x << 16) & 0x0000ff0000ffu;
    x = (x | x << 8) & 0x00f00f00f00fu;
    x = (x | x << 4) & 0x0c30c30c30c3u;
    return (x | x << 2) & 0x249249249249u;
}

/* Finds the codes of all triangles, in the mesh's bounding cube. */
static void find_codes(const psplat_mesh *mesh, coded *items) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, size = 0;
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        for (int k = 0; k < 3; ++k) low[k] = min2(low[k], mesh->positions[3 * i + (size_t)k]);
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        for (int k = 0; k < 3; ++k) size = max2(size, mesh->positions[3 * i + (size_t)k] - low[k]);
    double scale = size > 0 ? ((1 << AXIS_BITS) - 1) / (3 * size) : 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const double *a = corner_of(mesh, t, 0), *b = corner_of(mesh, t, 1);
        const double *c = corner_of(mesh, t, 2);
        items[t] = (coded){0, t};
        for (int k = 0; k < 3; ++k) {
            double along = (a[k] - low[k]) + (b[k] - low[k]) + (c[k] - low[k]);
            items[t].code |= spread((uint64_t)(along * scale)) << k;
        }
    }
}

/* Sorts items by their codes, equal ones by their indices, with as much memory beside them. */
static void sort_codes(coded *items, coded *other, size_t count) {
    for (int digit = 0; digit < DIGITS; ++digit) {
        size_t starts[(1 << DIGIT_BITS) + 1] = {0};
        int shift = digit * DIGIT_BITS;
        const uint64_t mask = (1u << DIGIT_BITS) - 1;
        for (size_t i = 0; i < count; ++i) ++starts[(items[i].code >> shift & mask) + 1];
        for (size_t i = 0; i < mask; ++i) starts[i + 1] += starts[i];
        for (size_t i = 0; i < count; ++i)
            other[starts[items[i].code >> shift & mask]++] = items[i];
        coded *swap = items;
        items = other, other = swap; /* The number of digits is even. */
    }
}

static void widen(box *b, const float low[3], const float high[3]) {
    for (int k = 0; k < 3; ++k) {
        if (low[k] < b->low[k]) b->low[k] = low[k];
        if (high[k] > b->high[k]) b->high[k] = high[k];
    }
}

static const box empty = {{HUGE_VALF, HUGE_VALF, HUGE_VALF}, {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF}};

/* Makes the box of some triangles in the order. */
static box box_of(const psplat_morton_tree *tree, size_t begin, size_t end) {
    box b = empty;
    for (size_t i = begin; i < end; ++i)
        for (size_t c = 0; c < 3; ++c) {
            const double *p = corner_of(tree->mesh, tree->order[i], c);
            float low[3], high[3];
            for (int k = 0; k < 3; ++k) {
                low[k] = nextafterf((float)p[k], -HUGE_VALF);
                high[k] = nextafterf((float)p[k], HUGE_VALF);
            }
            widen(&b, low, high);
        }
    return b;
}

/* Makes all boxes from the leaves up. Returns 0 when out of memory. */
static int make_boxes(psplat_morton_tree *tree) {
    size_t count = tree->mesh->triangle_count, total = 0, below = count;
    while (below && (below > 1 || !tree->levels)) {
        below = (below + WIDTH - 1) / WIDTH;
        tree->first[tree->levels++] = total;
        total += below;
    }
    tree->first[tree->levels] = total;
    tree->boxes = malloc((total + 1) * sizeof *tree->boxes);
    if (!tree->boxes) return 0;
    for (int level = 0; level < tree->levels; ++level) {
        size_t from = level ? tree->first[level - 1] : 0;
        size_t end = level ? tree->first[level] : count;
        for (size_t i = tree->first[level]; i < tree->first[level + 1]; ++i, from += WIDTH) {
            size_t stop = from + WIDTH < end ? from + WIDTH : end;
            tree->boxes[i] = level ? empty : box_of(tree, from, stop);
            for (size_t k = from; level && k < stop; ++k)
                widen(&tree->boxes[i], tree->boxes[k].low, tree->boxes[k].high);
        }
    }
    return 1;
}

psplat_morton_tree *psplat_morton_tree_create(const psplat_mesh *mesh) {
    size_t count = mesh->triangle_count;
    psplat_morton_tree *tree = calloc(1, sizeof *tree);
    coded *items = malloc((count + 1) * sizeof *items),
          *other = malloc((count + 1) * sizeof *other);
    if (tree) tree->order = malloc((count + 1) * sizeof *tree->order);
    int ok = tree && items && other && tree->order;
    if (ok) {
        tree->mesh = mesh;
        find_codes(mesh, items);
        sort_codes(items, other, count);
        for (size_t i = 0; i < count; ++i) tree->order[i] = items[i].triangle;
    }
    free(items);
    free(other);
    if (ok && make_boxes(tree)) return tree;
    psplat_morton_tree_destroy(tree);
    return NULL;
}

const psplat_mesh *psplat_morton_tree_mesh(const psplat_morton_tree *tree) {
    return tree->mesh;
}

void psplat_morton_tree_destroy(psplat_morton_tree *tree) {
    if (!tree) return;
    free(tree->order);
    free(tree->boxes);
    free(tree);
}

/* ---- searches ------------------------------------------------------------------------------- */

/* A node that is to be looked at: an index within its level, and how near it is. */
typedef struct entry {
    double distance2;
    size_t index;
    int level;
} entry;

/* Returns the range of what a node holds: boxes of the level below, or triangles of the order. */
static size_t children_of(const psplat_morton_tree *tree, const entry *node, size_t *end) {
    size_t begin = node->index * WIDTH;
    size_t count = node->level ? tree->first[node->level] - tree->first[node->level - 1]
                               : tree->mesh->triangle_count;
    *end = begin + WIDTH < count ? begin + WIDTH : count;
    return begin;
}

static double box_distance2(const box *b, const double p[3]) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        double away = max2(max2((double)b->low[k] - p[k], p[k] - (double)b->high[k]), 0);
        sum += away * away;
    }
    return sum;
}

/* Takes the point of a side that is nearest to p, where that is nearer than the best one. */
static void try_side(const double p[3], const double a[3], const double b[3], double *best,
                     double at[3]) {
    double way[3], foot[3];
    sub3(way, b, a);
    double length2 = dot3(way, way), along = dot3(way, p) - dot3(way, a);
    double t = length2 > 0 ? min2(max2(along / length2, 0), 1) : 0;
    for (int k = 0; k < 3; ++k) foot[k] = a[k] + t * way[k];
    double distance2 = distance2_3(p, foot);
    if (distance2 >= *best) return;
    *best = distance2;
    memcpy(at, foot, sizeof foot);
}

/* Takes the foot of p on the plane of a thin triangle, where that lies inside of all sides. */
static void try_foot(const double p[3], const double a[3], const double b[3], const double c[3],
                     const double n[3], double at[3]) {
    const double *corners[3] = {a, b, c};
    double foot[3], ap[3];
    sub3(ap, p, a);
    along3(foot, p, -dot3(ap, n) / dot3(n, n), n);
    for (int k = 0; k < 3; ++k) {
        double way[3], d[3], side[3];
        sub3(way, corners[(k + 1) % 3], corners[k]);
        sub3(d, foot, corners[k]);
        cross3(side, way, d);
        if (dot3(side, n) < 0) return;
    }
    memcpy(at, foot, sizeof foot);
}

/* Stores the point of a triangle that is nearest to p: above the triangle the foot on its plane,
 * else the nearest point of a side. */
static void nearest_of_triangle(const double p[3], const double a[3], const double b[3],
                                const double c[3], double at[3]) {
    double ab[3], ac[3], ap[3], n[3], best = HUGE_VAL;
    sub3(ab, b, a);
    sub3(ac, c, a);
    sub3(ap, p, a);
    cross3(n, ab, ac);
    double bb = dot3(ab, ab), bc = dot3(ab, ac), cc = dot3(ac, ac), area2 = dot3(n, n);
    double x = dot3(ap, ab), y = dot3(ap, ac), determinant = bb * cc - bc * bc;
    double s = cc * x - bc * y, t = bb * y - bc * x; /* barycentric, times the determinant */
    if (s >= 0 && t >= 0 && s + t <= determinant && area2 > thin_part * bb * cc) {
        along3(at, p, -dot3(ap, n) / area2, n);
        return;
    }
    try_side(p, a, b, &best, at);
    try_side(p, b, c, &best, at);
    try_side(p, c, a, &best, at);
    if (area2 > flat_part * bb * cc && area2 <= thin_part * bb * cc) try_foot(p, a, b, c, n, at);
}

/* The nearest point found so far. */
typedef struct found {
    double distance2, *nearest;
    uint32_t *triangle;
} found;

static void try_triangle(const psplat_mesh *mesh, uint32_t triangle, const double point[3],
                         found *f) {
    double at[3];
    nearest_of_triangle(point, corner_of(mesh, triangle, 0), corner_of(mesh, triangle, 1),
                        corner_of(mesh, triangle, 2), at);
    double distance2 = distance2_3(point, at);
    if (!(distance2 < f->distance2)) return;
    f->distance2 = distance2;
    *f->triangle = triangle;
    memcpy(f->nearest, at, sizeof at);
}

/* Pushes the boxes of a node that are near enough, so that the nearest one is taken first. */
static size_t push_near(const psplat_morton_tree *tree, const entry *node, const double point[3],
                        double most2, entry *stack, size_t count) {
    size_t end, begin = children_of(tree, node, &end), bottom = count;
    for (size_t i = begin; i < end; ++i) {
        const box *b = &tree->boxes[tree->first[node->level - 1] + i];
        entry new = {box_distance2(b, point), i, node->level - 1};
        if (!(new.distance2 < most2)) continue;
        size_t at = count++;
        for (; at > bottom && stack[at - 1].distance2 < new.distance2; --at)
            stack[at] = stack[at - 1];
        stack[at] = new;
    }
    return count;
}

double psplat_morton_tree_nearest(const psplat_morton_tree *tree, const double point[3],
                                  double most, double nearest[3], uint32_t *triangle) {
    found f = {most * most, nearest, triangle};
    entry stack[STACK];
    size_t count = 0;
    *triangle = PSPLAT_NONE;
    if (tree->levels) stack[count++] = (entry){0, 0, tree->levels - 1};
    while (count) {
        const entry node = stack[--count];
        if (!(node.distance2 < f.distance2)) continue;
        if (node.level) {
            count = push_near(tree, &node, point, f.distance2, stack, count);
            continue;
        }
        size_t end, begin = children_of(tree, &node, &end);
        for (size_t i = begin; i < end; ++i) try_triangle(tree->mesh, tree->order[i], point, &f);
    }
    return *triangle == PSPLAT_NONE ? HUGE_VAL : sqrt(f.distance2);
}

/* Returns whether a segment meets a box: none of the axes of either separates them (Gottschalk et
 * al.: OBBTree, 1996). The slack lets through what rounding decides. */
static int segment_meets_box(const double middle[3], const double half[3], const box *b) {
    double d[3], extent[3];
    for (int k = 0; k < 3; ++k) {
        double low = (double)b->low[k], high = (double)b->high[k];
        extent[k] = (high - low) / 2 * (1 + 1e-9) + 1e-12 * (fabs(low) + fabs(high));
        d[k] = middle[k] - (low + high) / 2;
        if (fabs(d[k]) > extent[k] + fabs(half[k])) return 0;
    }
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double reach = extent[i] * fabs(half[j]) + extent[j] * fabs(half[i]);
        double away = fabs(d[i] * half[j] - d[j] * half[i]);
        if (away > reach * (1 + 1e-9) + 1e-12 * (fabs(d[i] * half[j]) + fabs(d[j] * half[i])))
            return 0;
    }
    return 1;
}

/* Returns whether a segment meets a triangle from its front, its sides included. */
static int meets_triangle(const psplat_mesh *mesh, uint32_t triangle, const double from[3],
                          const double to[3]) {
    const double *corners[3];
    double way[3], ab[3], ac[3], n[3], away[3], beyond[3], r[3][3];
    for (size_t k = 0; k < 3; ++k) corners[k] = corner_of(mesh, triangle, k);
    sub3(way, to, from);
    sub3(ab, corners[1], corners[0]);
    sub3(ac, corners[2], corners[0]);
    cross3(n, ab, ac);
    sub3(away, from, corners[0]);
    sub3(beyond, to, corners[0]);
    if (!(dot3(n, way) < 0) || dot3(n, away) < 0 || dot3(n, beyond) > 0) return 0;
    for (int k = 0; k < 3; ++k) sub3(r[k], corners[k], from);
    for (int k = 0; k < 3; ++k) {
        double side[3];
        cross3(side, r[k], r[(k + 1) % 3]);
        if (dot3(side, way) > 0) return 0;
    }
    return 1;
}

int psplat_morton_tree_meets(const psplat_morton_tree *tree, const double from[3],
                             const double to[3]) {
    double middle[3], half[3];
    entry stack[STACK];
    size_t count = 0;
    for (int k = 0; k < 3; ++k) {
        middle[k] = (from[k] + to[k]) / 2;
        half[k] = (to[k] - from[k]) / 2;
    }
    if (tree->levels) stack[count++] = (entry){0, 0, tree->levels - 1};
    while (count) {
        const entry node = stack[--count];
        size_t end, begin = children_of(tree, &node, &end);
        for (size_t i = begin; i < end; ++i)
            if (!node.level) {
                if (meets_triangle(tree->mesh, tree->order[i], from, to)) return 1;
            } else if (segment_meets_box(middle, half,
                                         &tree->boxes[tree->first[node.level - 1] + i])) {
                stack[count++] = (entry){0, i, node.level - 1};
            }
    }
    return 0;
}

static int boxes_meet(const box *b, const double low[3], const double high[3]) {
    for (int k = 0; k < 3; ++k)
        if ((double)b->low[k] > high[k] || (double)b->high[k] < low[k]) return 0;
    return 1;
}

/* Returns whether the box of a triangle meets a box. */
static int triangle_in_box(const psplat_mesh *mesh, uint32_t triangle, const double low[3],
                           const double high[3]) {
    const double *a = corner_of(mesh, triangle, 0), *b = corner_of(mesh, triangle, 1);
    const double *c = corner_of(mesh, triangle, 2);
    for (int k = 0; k < 3; ++k)
        if (min2(min2(a[k], b[k]), c[k]) > high[k] || max2(max2(a[k], b[k]), c[k]) < low[k])
            return 0;
    return 1;
}

void psplat_morton_tree_visit_box(const psplat_morton_tree *tree, const double low[3],
                                  const double high[3], int (*visit)(void *user, uint32_t triangle),
                                  void *user) {
    entry stack[STACK];
    size_t count = 0;
    if (tree->levels) stack[count++] = (entry){0, 0, tree->levels - 1};
    while (count) {
        const entry node = stack[--count];
        size_t end, begin = children_of(tree, &node, &end);
        for (size_t i = begin; i < end; ++i)
            if (node.level) {
                if (boxes_meet(&tree->boxes[tree->first[node.level - 1] + i], low, high))
                    stack[count++] = (entry){0, i, node.level - 1};
            } else if (triangle_in_box(tree->mesh, tree->order[i], low, high) &&
                       visit(user, tree->order[i])) {
                return;
            }
    }
}
