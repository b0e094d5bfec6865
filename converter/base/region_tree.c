/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_tree.c - axis-aligned bounding box tree (AABB tree) over splat regions.
 *
 * Each node is split at the median of its longest axis, so that the depth is the logarithm of the
 * number of regions.
 */
#include "base/region_tree.h"

#include "base/region.h"
#include "base/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The regions of a leaf, room for the nodes that wait to be visited, and the sides of the polygon
 * whose corners bound a region. */
enum { LEAF_REGIONS = 4, MAX_STACK = 64, POLYGON_SIDES = 16 };

typedef struct box {
    double low[3], high[3];
} box;

/* Inner nodes have their children at child and child + 1; leaves hold order[begin ... end). */
typedef struct node {
    box bounds;
    uint32_t begin, end, child;
} node;

struct psplat_region_tree {
    box *boxes;
    uint32_t *order;
    node *nodes;
    uint32_t node_count;
};

/* The heights of a region's surface beyond those of its slopes at the corners of a polygon, as the
 * sum of a convex function and a concave one. */
typedef struct bow {
    double convex[POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES];  /* at least 0 */
    double concave[POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES]; /* at most 0 */
    double least_convex, most_concave;                     /* over the polygon */
} bow;

/* Splits the quadratic part of the heights along its principal directions in (u, v): one square
 * times half a number for each, which is convex or concave by that number's sign. A square is least
 * where the polygon comes nearest to 0 in that direction. */
static bow bow_of(const psplat_region *r, double (*outline)[2], size_t count) {
    bow result = {{0}, {0}, 0, 0};
    double a = r->hessian[0] * r->radius[0] * r->radius[0];
    double b = r->hessian[1] * r->radius[0] * r->radius[1];
    double c = r->hessian[2] * r->radius[1] * r->radius[1];
    double angle = 0.5 * atan2(2 * b, a - c), x = cos(angle), y = sin(angle);
    for (int k = 0; k < 2; ++k) {
        double half = ((a + c) / 2 + (k ? -1 : 1) * hypot((a - c) / 2, b)) / 2;
        double *part = half > 0 ? result.convex : result.concave, low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t i = 0; i < count; ++i) {
            double along =
                k ? outline[i][1] * x - outline[i][0] * y : outline[i][0] * x + outline[i][1] * y;
            part[i] += half * along * along;
            low = min2(low, along);
            high = max2(high, along);
        }
        double nearest = max2(max2(low, -high), 0);
        *(half > 0 ? &result.least_convex : &result.most_concave) += half * nearest * nearest;
    }
    return result;
}

/* Returns the box around the surface over the circumscribed polygon, cut by the clip lines, which
 * may leave little of a large ellipse. A convex function is greatest at a corner; so along each
 * axis the slopes and the convex part are bounded together, and the concave part by itself. */
static box region_box(const psplat_region *region, double reach) {
    double outline[POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES][2];
    size_t count = psplat_region_polygon(region, 0, outline, POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES);
    bow bow = {{0}, {0}, 0, 0};
    box result;
    if (psplat_region_is_curved(region)) bow = bow_of(region, outline, count);
    for (int k = 0; k < 3; ++k) {
        double low = count ? HUGE_VAL : 0, high = -low, up = region->n[k];
        const double *rising = up > 0 ? bow.convex : bow.concave;
        const double *falling = up > 0 ? bow.concave : bow.convex;
        double s = region->u[k] + up * region->slope[0], t = region->v[k] + up * region->slope[1];
        for (size_t i = 0; i < count; ++i) {
            double along =
                outline[i][0] * region->radius[0] * s + outline[i][1] * region->radius[1] * t;
            low = min2(low, along + up * falling[i]);
            high = max2(high, along + up * rising[i]);
        }
        if (count) low += up * (up > 0 ? bow.least_convex : bow.most_concave);
        if (count) high += up * (up > 0 ? bow.most_concave : bow.least_convex);
        result.low[k] = region->center[k] + low - reach;
        result.high[k] = region->center[k] + high + reach;
    }
    return result;
}

static box bounds_of(const psplat_region_tree *tree, uint32_t begin, uint32_t end) {
    box result = tree->boxes[tree->order[begin]];
    for (uint32_t i = begin + 1; i < end; ++i)
        for (int k = 0; k < 3; ++k) {
            result.low[k] = min2(result.low[k], tree->boxes[tree->order[i]].low[k]);
            result.high[k] = max2(result.high[k], tree->boxes[tree->order[i]].high[k]);
        }
    return result;
}

/* Returns twice the middle of a box along an axis. */
static double box_middle(const psplat_region_tree *tree, uint32_t i, int axis) {
    return tree->boxes[tree->order[i]].low[axis] + tree->boxes[tree->order[i]].high[axis];
}

/* Moves the entry that sorting would put at `at` there, and lesser ones before it, by Hoare's
 * selection. */
static void select_median(psplat_region_tree *tree, uint32_t begin, uint32_t end, uint32_t at,
                          int axis) {
    while (end - begin > 1) {
        double pivot = box_middle(tree, begin + (end - 1 - begin) / 2, axis);
        uint32_t i = begin, j = end - 1;
        for (;;) {
            while (box_middle(tree, i, axis) < pivot) ++i;
            while (box_middle(tree, j, axis) > pivot) --j;
            if (i >= j) break;
            uint32_t swap = tree->order[i];
            tree->order[i++] = tree->order[j];
            tree->order[j--] = swap;
        }
        if (at <= j)
            end = j + 1;
        else
            begin = j + 1;
    }
}

static void build(psplat_region_tree *tree, uint32_t index, uint32_t begin, uint32_t end) {
    node *n = &tree->nodes[index];
    *n = (node){bounds_of(tree, begin, end), begin, end, 0};
    if (end - begin <= LEAF_REGIONS) return;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (n->bounds.high[k] - n->bounds.low[k] > n->bounds.high[axis] - n->bounds.low[axis])
            axis = k;
    uint32_t split = begin + (end - begin) / 2;
    select_median(tree, begin, end, split, axis);
    n->child = tree->node_count;
    tree->node_count += 2;
    uint32_t child = n->child;
    build(tree, child, begin, split);
    build(tree, child + 1, split, end);
}

/* How much wider boxes of what regions cover are, in radii: corners between lines move farther out
 * than the slack of these (rounding_slack in measured_splats.c). */
static const double covering_slack = 1e-5;

/* Returns the greatest slope of a surface over the circumscribed polygon, cut by the clip lines:
 * since slopes are linear, it is at a corner. */
static double steepest_slope(const psplat_region *region) {
    double outline[POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES][2], steepest2 = 0;
    if (!psplat_region_is_curved(region)) return 0;
    size_t count = psplat_region_polygon(region, 0, outline, POLYGON_SIDES + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i) {
        double slope[2];
        psplat_region_slope(region, outline[i], slope);
        steepest2 = max2(steepest2, slope[0] * slope[0] + slope[1] * slope[1]);
    }
    return sqrt(steepest2);
}

/* Returns the box around all that a region covers: the height over its plane is that over its
 * surface times the root of 1 + slope^2. */
static box covering_box(const psplat_region *region, double tolerance) {
    double slope = steepest_slope(region), high = tolerance * sqrt(1 + slope * slope);
    double slack = covering_slack * ((region->radius[0] + region->radius[1]) * (1 + slope) + high);
    box result = region_box(region, 0);
    for (int k = 0; k < 3; ++k) {
        double away = fabs(region->n[k]) * high + slack;
        result.low[k] -= away;
        result.high[k] += away;
    }
    return result;
}

/* Builds a tree of boxes that a function makes of regions and a length. */
static psplat_region_tree *create(const psplat_region *regions, size_t count, double length,
                                  box (*box_of)(const psplat_region *region, double length)) {
    psplat_region_tree *tree = calloc(1, sizeof *tree);
    if (!tree) return NULL;
    tree->boxes = malloc((count + 1) * sizeof *tree->boxes);
    tree->order = malloc((count + 1) * sizeof *tree->order);
    tree->nodes = malloc((2 * count + 1) * sizeof *tree->nodes);
    if (!tree->boxes || !tree->order || !tree->nodes) {
        psplat_region_tree_destroy(tree);
        return NULL;
    }
    for (uint32_t i = 0; i < count; ++i) {
        tree->boxes[i] = box_of(&regions[i], length);
        tree->order[i] = i;
    }
    if (!count) return tree;
    tree->node_count = 1;
    build(tree, 0, 0, (uint32_t)count);
    return tree;
}

psplat_region_tree *psplat_region_tree_create(const psplat_region *regions, size_t count,
                                              double reach) {
    return create(regions, count, reach, region_box);
}

psplat_region_tree *psplat_region_tree_create_covering(const psplat_region *regions, size_t count,
                                                       double tolerance) {
    return create(regions, count, tolerance, covering_box);
}

static int meets(const box *b, const double low[3], const double high[3]) {
    for (int k = 0; k < 3; ++k)
        if (high[k] < b->low[k] || low[k] > b->high[k]) return 0;
    return 1;
}

void psplat_region_tree_visit_box(const psplat_region_tree *tree, const double low[3],
                                  const double high[3], int (*visit)(void *user, uint32_t region),
                                  void *user) {
    uint32_t stack[MAX_STACK], depth = 0;
    if (tree->node_count) stack[depth++] = 0;
    while (depth) {
        const node *n = &tree->nodes[stack[--depth]];
        if (!meets(&n->bounds, low, high)) continue;
        if (n->child) {
            stack[depth++] = n->child + 1;
            stack[depth++] = n->child;
            continue;
        }
        for (uint32_t i = n->begin; i < n->end; ++i)
            if (meets(&tree->boxes[tree->order[i]], low, high) && visit(user, tree->order[i]))
                return;
    }
}

/* A segment, by its middle and half of the way along it. */
typedef struct segment {
    double middle[3], half[3], size[3]; /* size: |half| */
    double grown;                       /* how much larger boxes are taken to be */
} segment;

/* Returns whether a segment meets a box: no axis separates them, those of the box nor those across
 * both (Gottschalk, Lin and Manocha, "OBBTree", 1996). */
static int meets_segment(const box *b, const segment *s) {
    double to[3], half[3];
    for (int k = 0; k < 3; ++k) {
        to[k] = s->middle[k] - (b->low[k] + b->high[k]) / 2;
        half[k] = (b->high[k] - b->low[k]) / 2 + s->grown;
        if (fabs(to[k]) > half[k] + s->size[k]) return 0;
    }
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        if (fabs(to[i] * s->half[j] - to[j] * s->half[i]) >
            half[i] * s->size[j] + half[j] * s->size[i])
            return 0;
    }
    return 1;
}

/* What rounding may make of lengths and coordinates, in parts of them. */
static const double rounding = 1e-12;

void psplat_region_tree_visit_segment(const psplat_region_tree *tree, const double from[3],
                                      const double to[3], double length,
                                      int (*visit)(void *user, uint32_t region), void *user) {
    uint32_t stack[MAX_STACK], depth = 0;
    segment s = {.grown = length};
    for (int k = 0; k < 3; ++k) {
        s.middle[k] = from[k] / 2 + to[k] / 2;
        s.half[k] = to[k] / 2 - from[k] / 2;
        s.size[k] = fabs(s.half[k]);
        s.grown += rounding * (length + fabs(s.middle[k]) + s.size[k]);
    }
    if (tree->node_count) stack[depth++] = 0;
    while (depth) {
        const node *n = &tree->nodes[stack[--depth]];
        if (!meets_segment(&n->bounds, &s)) continue;
        if (n->child) {
            stack[depth++] = n->child + 1;
            stack[depth++] = n->child;
            continue;
        }
        for (uint32_t i = n->begin; i < n->end; ++i)
            if (meets_segment(&tree->boxes[tree->order[i]], &s) && visit(user, tree->order[i]))
                return;
    }
}

void psplat_region_tree_visit(const psplat_region_tree *tree, const double point[3],
                              int (*visit)(void *user, uint32_t region), void *user) {
    psplat_region_tree_visit_box(tree, point, point, visit, user);
}

void psplat_region_tree_destroy(psplat_region_tree *tree) {
    if (!tree) return;
    free(tree->boxes);
    free(tree->order);
    free(tree->nodes);
    free(tree);
}
