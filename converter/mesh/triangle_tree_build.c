/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_tree_build.c - the order of triangles in a tree, and its boxes.
 *
 * Triangles are halved again and again by a coordinate of their middles, until four are left: that
 * along which these are spread most or, where triangles reach far out of the box of their middles,
 * as a few always do, and many of the long ones of machined parts, that which leaves the smallest
 * boxes. Halves are powers of two, but for the last one of a level, so that no node has to say
 * where its parts are.
 */
#include "mesh/triangle_tree.h"

#include "base/vector.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far boxes are widened, in units of the tree, for the rounding of coordinates of at most 1. */
static const float box_slack = 0x1p-22f;

/* How much larger a box around triangles is than that around their middles, by area, where the axis
 * is worth a choice: less takes longer to build, and more saves searches less. Chosen by hand. */
static const float least_area_factor = 1.5f;

/* The least triangles that are ordered by a task of their own. Chosen by hand. */
enum { TASK_SIZE = 1 << 15 };

/* The middle of a triangle, in the tree's units, and the triangle's index in the mesh. */
typedef struct item {
    float middle[3];
    uint32_t triangle;
} item;

/* ---- order ---------------------------------------------------------------------------------- */

/* Returns whether a comes before b along an axis. Indices break ties, so that the order is one. */
static int is_before(const item *a, const item *b, int axis) {
    if (a->middle[axis] != b->middle[axis]) return a->middle[axis] < b->middle[axis];
    return a->triangle < b->triangle;
}

static void swap_items(item *a, item *b) {
    item c = *a;
    *a = *b, *b = c;
}

/* Moves the median of three of the items to the first place. */
static void choose_pivot(item *items, size_t count, int axis) {
    item *a = items, *b = items + count / 2, *c = items + count - 1;
    if (is_before(b, a, axis)) swap_items(a, b);
    if (is_before(c, b, axis)) swap_items(b, c);
    if (is_before(b, a, axis)) swap_items(a, b);
    swap_items(a, b);
}

/* Orders items so that the first n come before all others (Hoare's selection). */
static void select_first(item *items, size_t count, size_t n, int axis) {
    while (count > 1) {
        choose_pivot(items, count, axis);
        const item pivot = items[0];
        size_t low = 0, high = count;
        for (;;) {
            do ++low;
            while (low < count && is_before(&items[low], &pivot, axis));
            do --high;
            while (is_before(&pivot, &items[high], axis));
            if (low >= high) break;
            swap_items(&items[low], &items[high]);
        }
        swap_items(&items[0], &items[high]);
        if (n <= high) {
            count = high;
        } else {
            items += high + 1, n -= high + 1, count -= high + 1;
        }
        if (n == 0 || n == count) return;
    }
}

/* A box in the tree's units. */
typedef struct box {
    float low[3], high[3];
} box;

static const box nothing = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};

static void add_point(box *b, const float p[3]) {
    for (int k = 0; k < 3; ++k) {
        b->low[k] = p[k] < b->low[k] ? p[k] : b->low[k];
        b->high[k] = p[k] > b->high[k] ? p[k] : b->high[k];
    }
}

/* Returns half of the area of a box that holds something. */
static float area_of(const box *b) {
    float x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return x * y + y * z + z * x;
}

static box box_of_middles(const item *items, size_t count) {
    box b = nothing;
    for (size_t i = 0; i < count; ++i) add_point(&b, items[i].middle);
    return b;
}

/* Returns half of the area of the box around triangles. */
static float area_of_triangles(const psplat_triangle_tree *tree, const psplat_mesh *mesh,
                               const item *items, size_t count) {
    box b = nothing;
    for (size_t i = 0; i < count; ++i)
        for (int corner = 0; corner < 3; ++corner) {
            const double *from = psplat_mesh_corner(mesh, items[i].triangle, corner);
            float p[3];
            for (int k = 0; k < 3; ++k) p[k] = (float)((from[k] - tree->origin[k]) * tree->scale);
            add_point(&b, p);
        }
    return area_of(&b);
}

/* Orders items so that the first n come before all others along the axis that spares most searches:
 * as many enter a box as it has area, and look at what is in there (Goldsmith and Salmon: Automatic
 * creation of object hierarchies for ray tracing, 1987). */
static void halve_best(const psplat_triangle_tree *tree, const psplat_mesh *mesh, item *items,
                       size_t count, size_t n) {
    float least = FLT_MAX;
    int best = 2;
    for (int axis = 0; axis < 3; ++axis) {
        select_first(items, count, n, axis);
        float cost = (float)n * area_of_triangles(tree, mesh, items, n) +
                     (float)(count - n) * area_of_triangles(tree, mesh, items + n, count - n);
        if (cost < least) least = cost, best = axis;
    }
    if (best < 2) select_first(items, count, n, best);
}

/* Orders items so that the first n come before all others along an axis. */
static void halve(const psplat_triangle_tree *tree, const psplat_mesh *mesh, item *items,
                  size_t count, size_t n) {
    box middles = box_of_middles(items, count);
    int widest = 0;
    if (area_of_triangles(tree, mesh, items, count) > least_area_factor * area_of(&middles)) {
        halve_best(tree, mesh, items, count, n);
        return;
    }
    for (int k = 1; k < 3; ++k)
        if (middles.high[k] - middles.low[k] > middles.high[widest] - middles.low[widest])
            widest = k;
    select_first(items, count, n, widest);
}

/* Orders items that fill a part of the tree with room for `size`, a power of two. */
static void order_items(const psplat_triangle_tree *tree, const psplat_mesh *mesh, item *items,
                        size_t count, size_t size) {
    for (size_t half = size / 2; half >= PSPLAT_TREE_LEAF; half /= 2) {
        if (count <= half) continue;
        halve(tree, mesh, items, count, half);
#if defined(_OPENMP)
#pragma omp task if (half >= TASK_SIZE)
#endif
        order_items(tree, mesh, items, half, half);
        items += half, count -= half;
    }
}

static void find_order(const psplat_triangle_tree *tree, const psplat_mesh *mesh, item *items) {
    size_t size = PSPLAT_TREE_LEAF, count = tree->triangle_count;
    while (size < count) size *= 2;
#if defined(_OPENMP)
#pragma omp parallel if (count > TASK_SIZE)
#pragma omp single
#endif
    order_items(tree, mesh, items, count, size);
}

/* ---- triangles ------------------------------------------------------------------------------ */

/* Finds the units of the tree: the box of the mesh's triangles becomes that from -1 to 1. */
static void find_units(psplat_triangle_tree *tree, const psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double wide = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const double *p = mesh->positions + 3 * (size_t)mesh->triangles[i];
        for (int k = 0; k < 3; ++k) low[k] = min2(low[k], p[k]), high[k] = max2(high[k], p[k]);
    }
    for (int k = 0; k < 3; ++k) {
        tree->origin[k] = 0.5 * low[k] + 0.5 * high[k];
        wide = max2(wide, max2(high[k] - tree->origin[k], tree->origin[k] - low[k]));
    }
    tree->scale = wide > DBL_MIN ? 1 / wide : 1;
}

static void set_items(const psplat_triangle_tree *tree, const psplat_mesh *mesh, item *items) {
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corners = mesh->triangles + 3 * t;
        items[t].triangle = (uint32_t)t;
        for (int k = 0; k < 3; ++k) {
            double sum = 0;
            for (int i = 0; i < 3; ++i)
                sum += mesh->positions[3 * (size_t)corners[i] + (size_t)k] - tree->origin[k];
            items[t].middle[k] = (float)(sum * tree->scale / 3);
        }
    }
}

/* Copies triangles in the order of the items, and vertices in that of their first triangle. numbers
 * has room for an index of each vertex of the mesh. */
static void copy_triangles(psplat_triangle_tree *tree, const psplat_mesh *mesh, const item *items,
                           uint32_t *numbers) {
    uint32_t count = 0;
    memset(numbers, 0xff, mesh->vertex_count * sizeof *numbers);
    for (size_t i = 0; i < tree->triangle_count; ++i) {
        tree->triangles[i] = items[i].triangle;
        for (size_t k = 0; k < 3; ++k) {
            size_t vertex = mesh->triangles[3 * (size_t)items[i].triangle + k];
            if (numbers[vertex] == PSPLAT_NONE) {
                memcpy(tree->positions + 3 * (size_t)count, mesh->positions + 3 * vertex,
                       3 * sizeof(double));
                numbers[vertex] = count++;
            }
            tree->corners[3 * i + k] = numbers[vertex];
        }
    }
    tree->vertex_count = count;
}

/* Translates the neighbours into places. places has room for one of each triangle. */
static void copy_neighbors(psplat_triangle_tree *tree, const uint32_t *neighbors,
                           uint32_t *places) {
    for (uint32_t i = 0; i < tree->triangle_count; ++i) places[tree->triangles[i]] = i;
    for (size_t i = 0; i < tree->triangle_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            uint32_t other = neighbors[3 * (size_t)tree->triangles[i] + k];
            tree->neighbors[3 * i + k] = other == PSPLAT_NONE ? other : places[other];
        }
}

/* ---- boxes ---------------------------------------------------------------------------------- */

static void empty_box(psplat_tree_node *node, int part) {
    for (int k = 0; k < 3; ++k) node->low[k][part] = FLT_MAX, node->high[k][part] = -FLT_MAX;
}

static void add_position(const psplat_triangle_tree *tree, psplat_tree_node *node, int part,
                         const double p[3]) {
    for (int k = 0; k < 3; ++k) {
        float x = (float)((p[k] - tree->origin[k]) * tree->scale);
        node->low[k][part] = fminf(node->low[k][part], x - box_slack);
        node->high[k][part] = fmaxf(node->high[k][part], x + box_slack);
    }
}

/* Sets the boxes of a node of level 0: those of its leaves. */
static void box_leaves(const psplat_triangle_tree *tree, size_t index, psplat_tree_node *node) {
    for (int part = 0; part < PSPLAT_TREE_PARTS; ++part) {
        size_t begin = PSPLAT_TREE_LEAF * (PSPLAT_TREE_PARTS * index + (size_t)part);
        empty_box(node, part);
        for (size_t i = begin; i < begin + PSPLAT_TREE_LEAF && i < tree->triangle_count; ++i)
            for (int k = 0; k < 3; ++k)
                add_position(tree, node, part, psplat_tree_corner(tree, (uint32_t)i, k));
    }
}

/* Sets the boxes of a node whose parts are at most `count` nodes of the level below. */
static void box_nodes(const psplat_tree_node *below, size_t count, psplat_tree_node *node) {
    for (int part = 0; part < PSPLAT_TREE_PARTS; ++part) {
        empty_box(node, part);
        if ((size_t)part >= count) continue;
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < PSPLAT_TREE_PARTS; ++i) {
                node->low[k][part] = fminf(node->low[k][part], below[part].low[k][i]);
                node->high[k][part] = fmaxf(node->high[k][part], below[part].high[k][i]);
            }
    }
}

static void find_boxes(psplat_triangle_tree *tree) {
    size_t below = tree->triangle_count, end = 0;
    size_t parts = (size_t)PSPLAT_TREE_LEAF * PSPLAT_TREE_PARTS;
    for (int level = 0; level < tree->level_count; ++level, parts = PSPLAT_TREE_PARTS) {
        size_t count = (below + parts - 1) / parts, first = end;
        for (size_t i = 0; i < count; ++i) {
            size_t begin = PSPLAT_TREE_PARTS * i;
            if (!level)
                box_leaves(tree, i, &tree->nodes[i]);
            else
                box_nodes(&tree->nodes[tree->first[level - 1] + begin], below - begin,
                          &tree->nodes[first + i]);
        }
        tree->first[level] = first;
        end = first + count, below = count;
    }
}

/* ---- a tree --------------------------------------------------------------------------------- */

/* Returns the number of nodes, and sets that of levels. */
static size_t count_nodes(psplat_triangle_tree *tree) {
    size_t total = 0, parts = (size_t)PSPLAT_TREE_LEAF * PSPLAT_TREE_PARTS;
    for (size_t count = tree->triangle_count; count && (!tree->level_count || count > 1);
         parts = PSPLAT_TREE_PARTS) {
        count = (count + parts - 1) / parts;
        total += count;
        ++tree->level_count;
    }
    return total;
}

static int allocate(psplat_triangle_tree *tree, const psplat_mesh *mesh, int has_neighbors) {
    size_t count = tree->triangle_count = mesh->triangle_count;
    size_t vertices = mesh->vertex_count < 3 * count ? mesh->vertex_count : 3 * count;
    tree->positions = malloc((3 * vertices + 1) * sizeof *tree->positions);
    tree->corners = malloc((3 * count + 1) * sizeof *tree->corners);
    tree->triangles = malloc((count + 1) * sizeof *tree->triangles);
    tree->nodes = malloc((count_nodes(tree) + 1) * sizeof *tree->nodes);
    if (has_neighbors) tree->neighbors = malloc((3 * count + 1) * sizeof *tree->neighbors);
    return tree->positions && tree->corners && tree->triangles && tree->nodes &&
           (tree->neighbors || !has_neighbors);
}

/* Fills a tree whose arrays are allocated. Returns whether there was memory. */
static int fill(psplat_triangle_tree *tree, const psplat_mesh *mesh, const uint32_t *neighbors) {
    size_t most =
        mesh->vertex_count > tree->triangle_count ? mesh->vertex_count : tree->triangle_count;
    item *items = malloc((tree->triangle_count + 1) * sizeof *items);
    uint32_t *numbers = malloc((most + 1) * sizeof *numbers);
    if (items && numbers && tree->triangle_count) {
        find_units(tree, mesh);
        set_items(tree, mesh, items);
        find_order(tree, mesh, items);
        copy_triangles(tree, mesh, items, numbers);
        if (neighbors) copy_neighbors(tree, neighbors, numbers);
        find_boxes(tree);
    }
    free(items);
    free(numbers);
    return items && numbers;
}

psplat_triangle_tree *psplat_triangle_tree_create(const psplat_mesh *mesh,
                                                  const uint32_t *neighbors) {
    psplat_triangle_tree *tree = calloc(1, sizeof *tree);
    if (!tree) return NULL;
    if (allocate(tree, mesh, neighbors != NULL) && fill(tree, mesh, neighbors)) return tree;
    psplat_triangle_tree_destroy(tree);
    return NULL;
}

void psplat_triangle_tree_destroy(psplat_triangle_tree *tree) {
    if (!tree) return;
    free(tree->positions);
    free(tree->corners);
    free(tree->triangles);
    free(tree->neighbors);
    free(tree->nodes);
    free(tree);
}
