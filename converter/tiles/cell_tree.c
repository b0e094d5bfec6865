/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cell_tree.c - the cells of a block that a mesh meets, and the cuts through them.
 *
 * A tile gets each splat that may reach its cell, whoever else gets it. So within a cell all is as
 * the conversion of the block has made it, and cells of different levels meet without a crack: each
 * covers its own part of the surface by itself.
 */
#include "tiles/cell_tree.h"

#include "base/vector.h"
#include "tiles/splat_extent.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What both halves of a cell may get together, as a part of what it has: a cell whose splats reach
 * all over it is not worth halving. Chosen by hand. */
static const double greatest_overlap = 1.75;

typedef struct index_list {
    uint32_t *items;
    size_t count;
} index_list;

typedef struct tree_node {
    psplat_tile_cell cell;
    index_list triangles;        /* of the mesh that meet the cell; empty once it is halved */
    struct tree_node *halves[2]; /* NULL: no triangle meets that one, or it is not halved */
    int is_halved;               /* the halves are known */
    int is_cut;                  /* the last cut passes below */
    size_t part;                 /* of the last cut; SIZE_MAX: none */
} tree_node;

struct psplat_cell_tree {
    const psplat_mesh *mesh;
    tree_node root;
};

/* Chooses items for a cell. Returns 0 when out of memory. */
static int choose(index_list from, const psplat_tile_cell *cell,
                  int (*meets)(const void *of, uint32_t item, const psplat_tile_cell *cell),
                  const void *of, index_list *chosen) {
    chosen->count = 0;
    chosen->items = malloc((from.count + 1) * sizeof *chosen->items);
    for (size_t i = 0; chosen->items && i < from.count; ++i)
        if (meets(of, from.items[i], cell)) chosen->items[chosen->count++] = from.items[i];
    return chosen->items != NULL;
}

static index_list all_items(size_t count) {
    index_list list = {malloc((count + 1) * sizeof *list.items), count};
    for (size_t i = 0; list.items && i < count; ++i) list.items[i] = (uint32_t)i;
    return list;
}

/* ---- the tree -------------------------------------------------------------------------------- */

static int meets_triangle(const void *of, uint32_t triangle, const psplat_tile_cell *cell) {
    const psplat_mesh *mesh = of;
    double corners[9];
    for (int i = 0; i < 3; ++i)
        along3(corners + 3 * i, mesh->origin, 1, psplat_mesh_corner(mesh, triangle, i));
    return psplat_tile_cell_meets_triangle(cell, corners);
}

static void node_free(tree_node *node) {
    for (int i = 0; i < 2; ++i)
        if (node->halves[i]) {
            node_free(node->halves[i]);
            free(node->halves[i]);
        }
    free(node->triangles.items);
}

/* Halves a node, whose triangles go to its halves. Returns 0 when out of memory. */
static int halve(const psplat_cell_tree *tree, tree_node *node) {
    if (node->is_halved) return 1;
    for (int i = 0; i < 2; ++i) {
        tree_node half = {.cell = psplat_tile_cell_half(&node->cell, i)};
        if (!choose(node->triangles, &half.cell, meets_triangle, tree->mesh, &half.triangles))
            return 0;
        if (!half.triangles.count) {
            free(half.triangles.items);
            continue;
        }
        node->halves[i] = malloc(sizeof half);
        if (!node->halves[i]) {
            free(half.triangles.items);
            return 0;
        }
        *node->halves[i] = half;
    }
    node->is_halved = 1;
    free(node->triangles.items);
    node->triangles = (index_list){0};
    return 1;
}

psplat_cell_tree *psplat_cell_tree_create(const psplat_mesh *mesh, const psplat_tile_cell *block) {
    psplat_cell_tree *tree = calloc(1, sizeof *tree);
    index_list all = all_items(mesh->triangle_count);
    int ok = tree && all.items;
    if (ok) {
        tree->mesh = mesh;
        tree->root.cell = *block;
        ok = choose(all, block, meets_triangle, mesh, &tree->root.triangles);
    }
    free(all.items);
    if (ok) return tree;
    free(tree);
    return NULL;
}

void psplat_cell_tree_destroy(psplat_cell_tree *tree) {
    if (tree) node_free(&tree->root);
    free(tree);
}

/* ---- cuts ------------------------------------------------------------------------------------ */

/* A box that holds a splat. */
typedef struct splat_box {
    double low[3], high[3];
    int is_empty;
} splat_box;

typedef struct cutter {
    psplat_cell_tree *tree;
    const psplat_cut_desc *desc;
    splat_box *boxes; /* of the splats */
    psplat_tile_part *parts;
    size_t count, capacity;
} cutter;

/* What a cell has while the cut goes down. */
typedef struct share {
    index_list splats, triangles;
} share;

static void share_free(share *s) {
    free(s->splats.items);
    free(s->triangles.items);
    *s = (share){0};
}

/* Returns whether a splat may reach as near to a cell as the margin. */
static int reaches(const void *of, uint32_t splat, const psplat_tile_cell *cell) {
    const cutter *c = of;
    const splat_box *box = &c->boxes[splat];
    double low[3], high[3];
    int inside = 1;
    if (box->is_empty) return 0;
    for (int k = 0; k < 3; ++k) {
        low[k] = cell->low[k] - c->tree->mesh->origin[k] - c->desc->margin;
        high[k] = cell->high[k] - c->tree->mesh->origin[k] + c->desc->margin;
        if (box->high[k] < low[k] || box->low[k] > high[k]) return 0;
        inside &= box->low[k] >= low[k] && box->high[k] <= high[k];
    }
    return inside || psplat_splat_extent_meets(&c->desc->regions[splat], low, high);
}

static int meets_simplified(const void *of, uint32_t triangle, const psplat_tile_cell *cell) {
    const cutter *c = of;
    double corners[9];
    for (size_t i = 0; i < 9; ++i)
        corners[i] =
            c->tree->mesh->origin[i % 3] + (double)c->desc->triangles[9 * (size_t)triangle + i];
    return psplat_tile_cell_meets_triangle(cell, corners);
}

/* Gives a cell that no splat reaches the one whose centre is nearest to the middle of the cell. */
static void take_nearest(const cutter *c, const psplat_tile_cell *cell, index_list from,
                         index_list *chosen) {
    double middle[3], least = HUGE_VAL;
    for (int k = 0; k < 3; ++k)
        middle[k] = 0.5 * cell->low[k] + 0.5 * cell->high[k] - c->tree->mesh->origin[k];
    for (size_t i = 0; i < from.count; ++i) {
        double distance2 = distance2_3(c->desc->regions[from.items[i]].center, middle);
        if (!(distance2 < least)) continue;
        least = distance2;
        chosen->items[0] = from.items[i];
        chosen->count = 1;
    }
}

/* Finds what one half of a node gets. Returns 0 when out of memory. */
static int share_half(const cutter *c, const tree_node *half, const share *all, share *s) {
    if (!half) return 1;
    if (!choose(all->splats, &half->cell, reaches, c, &s->splats) ||
        !choose(all->triangles, &half->cell, meets_simplified, c, &s->triangles))
        return 0;
    if (!s->splats.count) take_nearest(c, &half->cell, all->splats, &s->splats);
    return 1;
}

/* Appends a part, which takes over what the share has. Returns 0 when out of memory. */
static int push_part(cutter *c, tree_node *node, share *s) {
    if (c->count == c->capacity) {
        size_t capacity = 2 * c->capacity + 16;
        psplat_tile_part *parts = realloc(c->parts, capacity * sizeof *parts);
        if (!parts) return 0;
        c->parts = parts;
        c->capacity = capacity;
    }
    node->part = c->count;
    c->parts[c->count++] = (psplat_tile_part){.cell = node->cell,
                                              .splats = s->splats.items,
                                              .splat_count = s->splats.count,
                                              .triangles = s->triangles.items,
                                              .triangle_count = s->triangles.count};
    *s = (share){0};
    return 1;
}

/* Returns whether too many splats reach a cell that may be halved. */
static int is_too_full(const cutter *c, const tree_node *node, const share *s) {
    return c->desc->most && s->splats.count > c->desc->most &&
           node->cell.depth < PSPLAT_MOST_CELL_DEPTH &&
           (!c->desc->may_halve || c->desc->may_halve(c->desc->user, &node->cell));
}

static int is_worth_halving(const tree_node *node, const share *all, const share halves[2]) {
    size_t sum = halves[0].splats.count + halves[1].splats.count;
    return !node->halves[0] || !node->halves[1] ||
           (double)sum <= greatest_overlap * (double)all->splats.count;
}

/* Goes down from a node with what its cell gets, which is used up. Returns 0 when out of memory. */
static int cut(cutter *c, tree_node *node, share *s) {
    share halves[2] = {{{0}, {0}}, {{0}, {0}}};
    int must = node->is_cut, ok = 1, goes_down = must || is_too_full(c, node, s);
    node->part = SIZE_MAX;
    if (goes_down) {
        ok = halve(c->tree, node);
        for (int i = 0; i < 2 && ok; ++i) ok = share_half(c, node->halves[i], s, &halves[i]);
        if (ok && !must && !is_worth_halving(node, s, halves)) goes_down = 0;
        node->is_cut = goes_down;
    }
    if (ok && !goes_down) {
        ok = push_part(c, node, s);
    } else {
        share_free(s);
        for (int i = 0; i < 2 && ok; ++i)
            if (node->halves[i]) ok = cut(c, node->halves[i], &halves[i]);
    }
    for (int i = 0; i < 2; ++i) share_free(&halves[i]);
    share_free(s);
    return ok;
}

static int make_boxes(cutter *c) {
    c->boxes = malloc((c->desc->region_count + 1) * sizeof *c->boxes);
    for (size_t i = 0; c->boxes && i < c->desc->region_count; ++i)
        c->boxes[i].is_empty =
            !psplat_splat_extent_box(&c->desc->regions[i], c->boxes[i].low, c->boxes[i].high);
    return c->boxes != NULL;
}

psplat_result psplat_cell_tree_cut(psplat_cell_tree *tree, const psplat_cut_desc *desc,
                                   psplat_tile_part **parts, size_t *count) {
    cutter c = {.tree = tree, .desc = desc};
    share all = {all_items(desc->region_count), all_items(desc->triangle_count)}, s = {{0}, {0}};
    int ok = all.splats.items && all.triangles.items && make_boxes(&c) &&
             share_half(&c, &tree->root, &all, &s) && cut(&c, &tree->root, &s);
    share_free(&all);
    share_free(&s);
    free(c.boxes);
    *parts = c.parts;
    *count = c.count;
    if (ok) return PSPLAT_OK;
    psplat_tile_parts_free(c.parts, c.count);
    *parts = NULL;
    *count = 0;
    return PSPLAT_ERROR_MEMORY;
}

size_t psplat_cell_tree_part(const psplat_cell_tree *tree, const double point[3]) {
    const tree_node *node = &tree->root;
    double p[3], extent = 0;
    along3(p, tree->mesh->origin, 1, point);
    for (int k = 0; k < 3; ++k) extent = max2(extent, fabs(tree->mesh->origin[k]) + fabs(point[k]));
    psplat_tile_cell_settle(&node->cell, extent, p);
    if (!psplat_tile_cell_holds(&node->cell, p)) return SIZE_MAX;
    while (node && node->part == SIZE_MAX && node->is_cut) {
        int axis = psplat_tile_cell_axis(&node->cell);
        double middle = 0.5 * node->cell.low[axis] + 0.5 * node->cell.high[axis];
        node = node->halves[p[axis] >= middle];
    }
    return node ? node->part : SIZE_MAX;
}

void psplat_tile_parts_free(psplat_tile_part *parts, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        free(parts[i].splats);
        free(parts[i].triangles);
    }
    free(parts);
}
