/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_tree.c - searches in a tree of triangles, from the root down, nearest parts first.
 *
 * Boxes are tested in single precision. What that rounds is added to the query's own size, so that
 * no box is missed. Triangles are tested in double precision.
 */
#include "mesh/triangle_tree.h"

#include "base/vector.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* What rounding may change of coordinates of size 1, in units of the tree; and what it may change
 * of a product, as a factor. Both are some roundings of single precision, generously. */
static const float unit_slack = 0x1p-20f, product_slack = 1 + 0x1p-18f;

/* The least component of a segment's way, in units of the tree. Less is far below the slack. */
static const double least_way = 1e-12;

/* Queries farther away, in units of the tree, are moved to this coordinate, so that squares stay
 * finite. Every box is nearer to them then. */
static const double farthest = 1e15;

/* A triangle whose height is less than this part of its longest edge counts as its edges, since its
 * normal is mostly rounding. */
static const double flat_height = 1e-8;

/* Nodes or leaves to look at: the index within the level, or for a leaf its first place. */
typedef struct entry {
    float least2; /* the squared distance of its box, in units of the tree */
    int level;    /* -1: a leaf */
    uint32_t index;
} entry;

enum { STACK = PSPLAT_TREE_LEVELS * PSPLAT_TREE_PARTS };

/* Returns the part k of a node. */
static entry part_of(const entry *node, int k, float least2) {
    uint32_t index = PSPLAT_TREE_PARTS * node->index + (uint32_t)k;
    if (!node->level) index *= PSPLAT_TREE_LEAF;
    return (entry){least2, node->level - 1, index};
}

static const psplat_tree_node *node_at(const psplat_triangle_tree *tree, const entry *at) {
    return &tree->nodes[tree->first[at->level] + at->index];
}

static uint32_t leaf_end(const psplat_triangle_tree *tree, uint32_t begin) {
    size_t end = (size_t)begin + PSPLAT_TREE_LEAF;
    return (uint32_t)(end < tree->triangle_count ? end : tree->triangle_count);
}

/* ---- distances ------------------------------------------------------------------------------ */

/* Takes the point of a segment that is nearest to p, if it is nearer than *least. */
static void try_segment(const double p[3], const double a[3], const double b[3], double *least,
                        double at[3]) {
    double ab[3], ap[3], foot[3];
    sub3(ab, b, a);
    sub3(ap, p, a);
    double length2 = dot3(ab, ab), t = length2 > 0 ? dot3(ap, ab) / length2 : 0;
    along3(foot, a, min2(max2(t, 0), 1), ab);
    double distance2 = distance2_3(p, foot);
    if (distance2 >= *least) return;
    *least = distance2;
    memcpy(at, foot, sizeof foot);
}

/* Returns the squared distance of p to a triangle, and stores the nearest point of it. */
static double nearest_in_triangle(const double p[3], const double *corners[3], double at[3]) {
    double edges[3][3], d[3], n[3], least = HUGE_VAL, longest2 = 0;
    int outside[3];
    for (int k = 0; k < 3; ++k) {
        sub3(edges[k], corners[(k + 1) % 3], corners[k]);
        longest2 = max2(longest2, dot3(edges[k], edges[k]));
    }
    cross3(n, edges[0], edges[1]);
    double area2 = dot3(n, n), flat = flat_height * longest2;
    int is_flat = !(area2 > flat * flat), any = is_flat;
    for (int k = 0; k < 3; ++k) {
        double side[3];
        sub3(d, p, corners[k]);
        cross3(side, edges[k], d);
        any |= outside[k] = is_flat || dot3(side, n) < 0;
    }
    if (!any) {
        double height = dot3(d, n) / area2;
        along3(at, p, -height, n);
        return height * height * area2;
    }
    for (int k = 0; k < 3; ++k)
        if (outside[k]) try_segment(p, corners[k], corners[(k + 1) % 3], &least, at);
    return least;
}

/* A point and what is known of the triangle nearest to it. */
typedef struct search {
    const psplat_triangle_tree *tree;
    const double *point;
    float low[3], high[3]; /* the point in the tree's units, widened by rounding */
    float most2;           /* of a box that may hold something nearer, in the tree's units */
    psplat_tree_nearest *nearest;
} search;

static void set_most(search *s, double distance2) {
    double most2 = distance2 * (s->tree->scale * s->tree->scale);
    s->most2 = most2 < FLT_MAX / 2 ? (float)most2 * product_slack : FLT_MAX;
}

static search search_of(const psplat_triangle_tree *tree, const double point[3],
                        psplat_tree_nearest *nearest) {
    search s = {.tree = tree, .point = point, .nearest = nearest};
    double q[3], size = 1;
    for (int k = 0; k < 3; ++k) {
        q[k] = (point[k] - tree->origin[k]) * tree->scale;
        q[k] = min2(max2(q[k], -farthest), farthest);
        size = max2(size, fabs(q[k]));
    }
    for (int k = 0; k < 3; ++k) {
        s.low[k] = (float)(q[k] - (double)unit_slack * size);
        s.high[k] = (float)(q[k] + (double)unit_slack * size);
    }
    set_most(&s, nearest->distance2);
    return s;
}

/* Stores the squared distances of the boxes of a node, or less. */
static void box_distances(const search *s, const psplat_tree_node *node,
                          float distances2[PSPLAT_TREE_PARTS]) {
    for (int i = 0; i < PSPLAT_TREE_PARTS; ++i) distances2[i] = 0;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < PSPLAT_TREE_PARTS; ++i) {
            float below = node->low[k][i] - s->high[k], above = s->low[k] - node->high[k][i];
            float d = below > above ? below : above;
            d = d > 0 ? d : 0;
            distances2[i] += d * d;
        }
}

/* Measures a triangle. Of triangles at one distance, that with the least index is taken. */
static void try_triangle(search *s, uint32_t place) {
    const psplat_triangle_tree *tree = s->tree;
    psplat_tree_nearest *nearest = s->nearest;
    const double *corners[3];
    double at[3];
    for (int k = 0; k < 3; ++k) corners[k] = psplat_tree_corner(tree, place, k);
    double distance2 = nearest_in_triangle(s->point, corners, at);
    if (!(distance2 <= nearest->distance2)) return;
    if (distance2 == nearest->distance2 && nearest->place != PSPLAT_NONE &&
        tree->triangles[place] > tree->triangles[nearest->place])
        return;
    if (distance2 < nearest->distance2) set_most(s, distance2);
    nearest->distance2 = distance2;
    nearest->place = place;
    memcpy(nearest->point, at, sizeof at);
}

/* Pushes the parts of a node that may hold something nearer, the nearest last. */
static size_t push_parts(const search *s, const entry *node, entry *stack, size_t count) {
    float distances2[PSPLAT_TREE_PARTS];
    box_distances(s, node_at(s->tree, node), distances2);
    size_t begin = count;
    for (int k = 0; k < PSPLAT_TREE_PARTS; ++k) {
        if (!(distances2[k] <= s->most2)) continue;
        entry part = part_of(node, k, distances2[k]);
        size_t i = count++;
        for (; i > begin && stack[i - 1].least2 < part.least2; --i) stack[i] = stack[i - 1];
        stack[i] = part;
    }
    return count;
}

/* Searches the tree. Ends at the first triangle that is found where is_any is set. */
static void search_tree(search *s, int is_any) {
    entry stack[STACK];
    size_t count = 0;
    if (s->tree->level_count) stack[count++] = (entry){0, s->tree->level_count - 1, 0};
    while (count && !(is_any && s->nearest->place != PSPLAT_NONE)) {
        const entry top = stack[--count];
        if (!(top.least2 <= s->most2)) continue;
        if (top.level >= 0) {
            count = push_parts(s, &top, stack, count);
            continue;
        }
        uint32_t end = leaf_end(s->tree, top.index);
        for (uint32_t place = top.index; place < end; ++place) try_triangle(s, place);
    }
}

/* Measures the triangle that is likely near, in place of none. */
static search begin_search(const psplat_triangle_tree *tree, const double point[3],
                           psplat_tree_nearest *nearest) {
    search s = search_of(tree, point, nearest);
    uint32_t guess = nearest->place;
    nearest->place = PSPLAT_NONE;
    if (guess != PSPLAT_NONE) try_triangle(&s, guess);
    return s;
}

void psplat_triangle_tree_nearest(const psplat_triangle_tree *tree, const double point[3],
                                  psplat_tree_nearest *nearest) {
    search s = begin_search(tree, point, nearest);
    search_tree(&s, 0);
}

int psplat_triangle_tree_is_within(const psplat_triangle_tree *tree, const double point[3],
                                   double distance, uint32_t *place) {
    psplat_tree_nearest nearest = {.distance2 = distance * distance, .place = *place};
    search s = begin_search(tree, point, &nearest);
    search_tree(&s, 1);
    if (nearest.place == PSPLAT_NONE) return 0;
    *place = nearest.place;
    return 1;
}

/* ---- segments ------------------------------------------------------------------------------- */

typedef struct segment {
    const double *from;
    double way[3];
    float start[3], inverse[3], slack; /* in the tree's units; the inverse is that of the way */
} segment;

static segment segment_of(const psplat_triangle_tree *tree, const double from[3],
                          const double to[3]) {
    segment s = {.from = from};
    double size = 1;
    sub3(s.way, to, from);
    for (int k = 0; k < 3; ++k) {
        double start = (from[k] - tree->origin[k]) * tree->scale, way = s.way[k] * tree->scale;
        size = max2(size, max2(fabs(start), fabs(way)));
        if (fabs(way) < least_way) way = copysign(least_way, way);
        s.start[k] = (float)start;
        s.inverse[k] = (float)(1 / way);
    }
    s.slack = (float)((double)unit_slack * size);
    return s;
}

/* Stores when a segment is within the boxes of a node, by its times between parallel planes. Parts
 * that do not exist are left before they are entered. */
static void box_times(const segment *s, const psplat_tree_node *node,
                      float begin[PSPLAT_TREE_PARTS], float end[PSPLAT_TREE_PARTS]) {
    for (int i = 0; i < PSPLAT_TREE_PARTS; ++i) begin[i] = 0, end[i] = 1;
    for (int k = 0; k < 3; ++k) {
        float start = s->start[k], inverse = s->inverse[k];
        float slack = inverse > 0 ? s->slack : -s->slack;
        const float *near = inverse > 0 ? node->low[k] : node->high[k];
        const float *far = inverse > 0 ? node->high[k] : node->low[k];
        for (int i = 0; i < PSPLAT_TREE_PARTS; ++i) {
            float first = (near[i] - slack - start) * inverse;
            float last = (far[i] + slack - start) * inverse;
            begin[i] = first > begin[i] ? first : begin[i];
            end[i] = last < end[i] ? last : end[i];
        }
    }
}

/* Returns whether a segment meets a triangle from its front, by the signs of the volumes that it
 * spans with the edges. Two triangles find the same volume at their common edge, but for its sign.
 */
static int meets_triangle(const segment *s, const double *corners[3]) {
    double d[3][3], edges[2][3], side[3], n[3];
    for (int k = 0; k < 3; ++k) sub3(d[k], corners[k], s->from);
    sub3(edges[0], corners[1], corners[0]);
    sub3(edges[1], corners[2], corners[0]);
    cross3(n, edges[0], edges[1]);
    double fall = dot3(n, s->way), depth = dot3(n, d[0]);
    if (!(fall < 0) || depth > 0 || depth < fall) return 0;
    for (int k = 0; k < 3; ++k) {
        cross3(side, d[(k + 1) % 3], d[k]);
        if (dot3(side, s->way) < 0) return 0;
    }
    return 1;
}

static int meets_leaf(const psplat_triangle_tree *tree, const segment *s, uint32_t begin) {
    const double *corners[3];
    uint32_t end = leaf_end(tree, begin);
    for (uint32_t place = begin; place < end; ++place) {
        for (int k = 0; k < 3; ++k) corners[k] = psplat_tree_corner(tree, place, k);
        if (meets_triangle(s, corners)) return 1;
    }
    return 0;
}

int psplat_triangle_tree_meets(const psplat_triangle_tree *tree, const double from[3],
                               const double to[3]) {
    segment s = segment_of(tree, from, to);
    entry stack[STACK];
    size_t count = 0;
    if (tree->level_count) stack[count++] = (entry){0, tree->level_count - 1, 0};
    while (count) {
        const entry top = stack[--count];
        if (top.level < 0) {
            if (meets_leaf(tree, &s, top.index)) return 1;
            continue;
        }
        float begin[PSPLAT_TREE_PARTS], end[PSPLAT_TREE_PARTS];
        box_times(&s, node_at(tree, &top), begin, end);
        for (int k = 0; k < PSPLAT_TREE_PARTS; ++k)
            if (begin[k] <= end[k] * product_slack) stack[count++] = part_of(&top, k, 0);
    }
    return 0;
}

/* ---- boxes ---------------------------------------------------------------------------------- */

static int box_meets(const float low[3], const float high[3], const psplat_tree_node *node,
                     int part) {
    for (int k = 0; k < 3; ++k)
        if (!(node->low[k][part] <= high[k] && node->high[k][part] >= low[k])) return 0;
    return 1;
}

static int triangle_box_meets(const psplat_triangle_tree *tree, uint32_t place, const double low[3],
                              const double high[3]) {
    for (int k = 0; k < 3; ++k) {
        double a = psplat_tree_corner(tree, place, 0)[k], b = psplat_tree_corner(tree, place, 1)[k],
               c = psplat_tree_corner(tree, place, 2)[k];
        if (min2(min2(a, b), c) > high[k] || max2(max2(a, b), c) < low[k]) return 0;
    }
    return 1;
}

void psplat_triangle_tree_visit_box(const psplat_triangle_tree *tree, const double low[3],
                                    const double high[3], int (*visit)(void *user, uint32_t place),
                                    void *user) {
    psplat_tree_nearest none = {HUGE_VAL, PSPLAT_NONE, {0, 0, 0}};
    search from = search_of(tree, low, &none), to = search_of(tree, high, &none);
    entry stack[STACK];
    size_t count = 0;
    if (tree->level_count) stack[count++] = (entry){0, tree->level_count - 1, 0};
    while (count) {
        const entry top = stack[--count];
        if (top.level >= 0) {
            for (int k = PSPLAT_TREE_PARTS - 1; k >= 0; --k)
                if (box_meets(from.low, to.high, node_at(tree, &top), k))
                    stack[count++] = part_of(&top, k, 0);
            continue;
        }
        uint32_t end = leaf_end(tree, top.index);
        for (uint32_t place = top.index; place < end; ++place)
            if (triangle_box_meets(tree, place, low, high) && visit(user, place)) return;
    }
}
