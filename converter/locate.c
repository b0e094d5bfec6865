/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * locate.c - which regions are near a point: a tree of boxes, split at the median of the longer
 * side.
 */
#include "stages.h"

#include "vector.h"
#include <stdlib.h>

enum { LEAF = 4, DEPTH = 64, SIDES = 16 };

typedef struct box {
    double low[3], high[3];
} box;

/* Inner nodes have their children at child and child + 1; leaves hold order[begin ... end). */
typedef struct node {
    box bounds;
    uint32_t begin, end, child;
} node;

struct psplat_locator {
    box *boxes;
    uint32_t *order;
    node *nodes;
    uint32_t node_count;
};

/* Around the outline: of a large ellipse its lines may leave little. */
static box region_box(const psplat_region *region, double reach) {
    double outline[SIDES + PSPLAT_MAX_CLIP_LINES][2];
    size_t count = psplat_region_polygon(region, 0, outline, SIDES + PSPLAT_MAX_CLIP_LINES);
    box result;
    for (int k = 0; k < 3; ++k) {
        double low = count ? HUGE_VAL : 0, high = -low;
        for (size_t i = 0; i < count; ++i) {
            double along = outline[i][0] * region->radius[0] * region->u[k] +
                           outline[i][1] * region->radius[1] * region->v[k];
            low = min2(low, along);
            high = max2(high, along);
        }
        result.low[k] = region->center[k] + low - reach;
        result.high[k] = region->center[k] + high + reach;
    }
    return result;
}

static box bounds_of(const psplat_locator *l, uint32_t begin, uint32_t end) {
    box result = l->boxes[l->order[begin]];
    for (uint32_t i = begin + 1; i < end; ++i)
        for (int k = 0; k < 3; ++k) {
            result.low[k] = min2(result.low[k], l->boxes[l->order[i]].low[k]);
            result.high[k] = max2(result.high[k], l->boxes[l->order[i]].high[k]);
        }
    return result;
}

static double middle(const psplat_locator *l, uint32_t i, int axis) {
    return l->boxes[l->order[i]].low[axis] + l->boxes[l->order[i]].high[axis];
}

/* Hoare's selection: the entry that sorting would put at `at` is there, lesser ones before it. */
static void select_median(psplat_locator *l, uint32_t begin, uint32_t end, uint32_t at, int axis) {
    while (end - begin > 1) {
        double pivot = middle(l, begin + (end - 1 - begin) / 2, axis);
        uint32_t i = begin, j = end - 1;
        for (;;) {
            while (middle(l, i, axis) < pivot) ++i;
            while (middle(l, j, axis) > pivot) --j;
            if (i >= j) break;
            uint32_t swap = l->order[i];
            l->order[i++] = l->order[j];
            l->order[j--] = swap;
        }
        if (at <= j)
            end = j + 1;
        else
            begin = j + 1;
    }
}

static void build(psplat_locator *l, uint32_t index, uint32_t begin, uint32_t end) {
    node *n = &l->nodes[index];
    *n = (node){bounds_of(l, begin, end), begin, end, 0};
    if (end - begin <= LEAF) return;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (n->bounds.high[k] - n->bounds.low[k] > n->bounds.high[axis] - n->bounds.low[axis])
            axis = k;
    uint32_t split = begin + (end - begin) / 2;
    select_median(l, begin, end, split, axis);
    n->child = l->node_count;
    l->node_count += 2;
    uint32_t child = n->child;
    build(l, child, begin, split);
    build(l, child + 1, split, end);
}

psplat_locator *psplat_locator_create(const psplat_region *regions, size_t count, double reach) {
    psplat_locator *l = calloc(1, sizeof *l);
    if (!l) return NULL;
    l->boxes = malloc((count + 1) * sizeof *l->boxes);
    l->order = malloc((count + 1) * sizeof *l->order);
    l->nodes = malloc((2 * count + 1) * sizeof *l->nodes);
    if (!l->boxes || !l->order || !l->nodes) {
        psplat_locator_destroy(l);
        return NULL;
    }
    for (uint32_t i = 0; i < count; ++i) {
        l->boxes[i] = region_box(&regions[i], reach);
        l->order[i] = i;
    }
    if (!count) return l;
    l->node_count = 1;
    build(l, 0, 0, (uint32_t)count);
    return l;
}

static int meets(const box *b, const double low[3], const double high[3]) {
    for (int k = 0; k < 3; ++k)
        if (high[k] < b->low[k] || low[k] > b->high[k]) return 0;
    return 1;
}

void psplat_locator_visit_box(const psplat_locator *l, const double low[3], const double high[3],
                              int (*visit)(void *user, uint32_t region), void *user) {
    uint32_t stack[DEPTH], depth = 0;
    if (l->node_count) stack[depth++] = 0;
    while (depth) {
        const node *n = &l->nodes[stack[--depth]];
        if (!meets(&n->bounds, low, high)) continue;
        if (n->child) {
            stack[depth++] = n->child + 1;
            stack[depth++] = n->child;
            continue;
        }
        for (uint32_t i = n->begin; i < n->end; ++i)
            if (meets(&l->boxes[l->order[i]], low, high) && visit(user, l->order[i])) return;
    }
}

void psplat_locator_visit(const psplat_locator *l, const double point[3],
                          int (*visit)(void *user, uint32_t region), void *user) {
    psplat_locator_visit_box(l, point, point, visit, user);
}

void psplat_locator_destroy(psplat_locator *l) {
    if (!l) return;
    free(l->boxes);
    free(l->order);
    free(l->nodes);
    free(l);
}
