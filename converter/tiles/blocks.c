/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * blocks.c - the triangles of a file, sorted into blocks by counting.
 *
 * The cells of one depth, in the order of their paths, are the counters: the cells of any lesser
 * depth are ranges of them. Cells of that depth with too many triangles are counted again, some
 * levels deeper, until none has. A block is found for a centroid by walking down a tree that ends
 * at the blocks, with the very halvings that make cells.
 */
#define _XOPEN_SOURCE 700 /* pread, pwrite, fsync */

#include "tiles/blocks.h"

#include "base/path.h"
#include "base/vector.h"
#include "tiles/cell.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The bytes that wait for being written, of all blocks and the most and least of one. */
enum { ALL_BUFFERS = 1 << 26, MOST_BUFFER = 1 << 18, LEAST_BUFFER = 1 << 12 };
/* The cells that a pass counts in each that has too many triangles, and about in all, as powers of
 * 2, and the most cells of the first pass. */
enum { CELL_LEVELS = 12, ALL_LEVELS = 20, FIRST_LEVELS = 22 };
/* The longest side of the smallest cells that are halved, in that of the root: surfaces much
 * smaller than that have no area beside the whole, so that blocks above them have no tiles. */
static const double least_side = 0x1p-22;
/* The bytes that are read from the store at a time. */
enum { READ_BUFFER = 1 << 20 };

/* A node of the tree of blocks; the tree is full. */
typedef struct tree_node {
    psplat_tile_cell cell;
    int axis; /* of its halving, if it has one, and the place */
    double middle;
    uint32_t children; /* the lower one; the upper follows. 0: this is a block */
    uint32_t leaf;
    uint64_t count; /* its triangles, where it is a block */
} tree_node;

/* A halving on the way to the counted cells, in the order of a heap: that of halving i's halves are
 * 2 i + 1 and 2 i + 2. Cells of one depth may differ in the axis, where sides are as good as equal.
 */
typedef struct halving {
    double middle;
    int axis;
} halving;

/* Counters of the cells some levels below one. */
typedef struct counted {
    uint32_t node; /* that has too many triangles */
    halving *halvings;
    uint64_t *before; /* of each cell, the triangles in all before it, and of all at the end */
} counted;

/* A block while it is filled. */
typedef struct filling {
    uint64_t at; /* the triangles before what waits, in the store */
    size_t used; /* bytes that wait */
    int is_met;  /* a triangle meets its cell */
} filling;

typedef struct sorter {
    psplat_triangle_stream *stream;
    psplat_tile_leaves *leaves;
    uint64_t most;
    int levels;       /* between a node that is counted and the cells below it */
    counted *counted; /* by node */
    size_t counted_count;
    tree_node *nodes;
    size_t node_count, node_capacity;
    filling *fillings;
    size_t stride, buffer_size;
    char *buffers;
    int file;
    char shown[PSPLAT_SHOWN_PATH];
} sorter;

static psplat_result fail_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while sorting triangles");
}

static void centroid_of(const psplat_stream_triangle *t, double c[3]) {
    for (int k = 0; k < 3; ++k)
        c[k] = (t->positions[k] + t->positions[3 + k] + t->positions[6 + k]) / 3;
}

/* ---- the box, and whether the surface is closed ---------------------------------------------- */

static uint64_t mix(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

static uint64_t hash_point(const double p[3]) {
    uint64_t hash = 0x9e3779b97f4a7c15u;
    for (int k = 0; k < 3; ++k) {
        double value = p[k] + 0.0; /* -0 becomes 0 */
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        hash = mix(hash ^ bits);
    }
    return hash;
}

/* Returns a number of the edge that changes its sign with the direction. Over all edges of a closed
 * surface that is oriented one way they add up to 0. */
static uint64_t edge_number(uint64_t from, uint64_t to) {
    return from < to ? mix(from + 3 * to) : 0 - mix(to + 3 * from);
}

static psplat_result find_box(sorter *s, psplat_error *error) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    psplat_stream_triangle t;
    uint64_t sum = 0;
    for (int got = 1; got;) {
        psplat_result result = psplat_triangle_stream_next(s->stream, &t, &got, error);
        if (result) return result;
        if (!got) break;
        uint64_t hashes[3];
        for (int i = 0; i < 3; ++i) {
            hashes[i] = hash_point(t.positions + 3 * i);
            for (int k = 0; k < 3; ++k) {
                low[k] = min2(low[k], t.positions[3 * i + k]);
                high[k] = max2(high[k], t.positions[3 * i + k]);
            }
        }
        for (int i = 0; i < 3; ++i) sum += edge_number(hashes[i], hashes[(i + 1) % 3]);
        ++s->leaves->triangles;
    }
    if (!s->leaves->triangles)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: no triangle", s->shown);
    s->leaves->root = psplat_tile_cell_root(low, high);
    s->leaves->is_closed = sum == 0;
    return PSPLAT_OK;
}

/* ---- counting -------------------------------------------------------------------------------- */

static void fill_halvings(halving *halvings, size_t i, const psplat_tile_cell *cell, int levels) {
    if (!levels) return;
    psplat_tile_cell lower = psplat_tile_cell_half(cell, 0);
    psplat_tile_cell upper = psplat_tile_cell_half(cell, 1);
    int axis = psplat_tile_cell_axis(cell);
    halvings[i] = (halving){upper.low[axis], axis};
    fill_halvings(halvings, 2 * i + 1, &lower, levels - 1);
    fill_halvings(halvings, 2 * i + 2, &upper, levels - 1);
}

static size_t cell_of(const halving *halvings, size_t cells, const double point[3]) {
    size_t i = 0;
    while (i < cells - 1) {
        const halving *h = &halvings[i];
        i = 2 * i + 1 + (point[h->axis] >= h->middle);
    }
    return i - (cells - 1);
}

static uint32_t node_of(const sorter *s, const double point[3]) {
    uint32_t i = 0;
    while (s->nodes[i].children)
        i = s->nodes[i].children + (point[s->nodes[i].axis] >= s->nodes[i].middle);
    return i;
}

/* Finds the counters of a node. Nodes are added in order, so that counters are sorted by them. */
static counted *counters_of(const sorter *s, uint32_t node) {
    size_t begin = 0, end = s->counted_count;
    while (begin < end) {
        size_t middle = begin + (end - begin) / 2;
        if (s->counted[middle].node < node) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return begin < s->counted_count && s->counted[begin].node == node ? &s->counted[begin] : NULL;
}

/* Counts the triangles of all cells that have counters. */
static psplat_result count(sorter *s, psplat_error *error) {
    size_t cells = (size_t)1 << s->levels;
    psplat_stream_triangle t;
    uint64_t seen = 0;
    psplat_triangle_stream_rewind(s->stream);
    for (int got = 1; got;) {
        double centroid[3];
        psplat_result result = psplat_triangle_stream_next(s->stream, &t, &got, error);
        if (result) return result;
        if (!got) break;
        centroid_of(&t, centroid);
        counted *c = counters_of(s, node_of(s, centroid));
        if (c) ++c->before[cell_of(c->halvings, cells, centroid) + 1];
        ++seen;
    }
    for (size_t k = 0; k < s->counted_count; ++k)
        for (size_t i = 0; i < cells; ++i) s->counted[k].before[i + 1] += s->counted[k].before[i];
    if (seen == s->leaves->triangles) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: changed while it was read", s->shown);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

static int add_node(sorter *s, const psplat_tile_cell *cell, uint64_t count) {
    if (s->node_count == s->node_capacity) {
        size_t capacity = 2 * s->node_capacity + 64;
        tree_node *larger = realloc(s->nodes, capacity * sizeof *larger);
        if (!larger) return 0;
        s->nodes = larger;
        s->node_capacity = capacity;
    }
    s->nodes[s->node_count++] = (tree_node){.cell = *cell, .count = count};
    return 1;
}

/* Returns whether a node has too many triangles and can be halved. */
static int is_heavy(const sorter *s, const tree_node *n) {
    const psplat_tile_cell *root = &s->nodes[0].cell;
    int axis = psplat_tile_cell_axis(&n->cell), longest = psplat_tile_cell_axis(root);
    return !n->children && n->count > s->most && n->cell.depth < PSPLAT_MOST_BLOCK_DEPTH &&
           n->cell.high[axis] - n->cell.low[axis] >
               least_side * (root->high[longest] - root->low[longest]);
}

/* Splits the node of counters, whose cell number index of `level` levels below the counted one it
 * has, until each part has few enough triangles or is a counted cell. Returns 0 when out of memory.
 */
static int split_node(sorter *s, const counted *c, uint32_t node, int level, size_t index) {
    const psplat_tile_cell cell = s->nodes[node].cell;
    size_t cells = (size_t)1 << (s->levels - level), begin = index * cells;
    if (level == s->levels || !is_heavy(s, &s->nodes[node])) return 1;
    const psplat_tile_cell halves[2] = {psplat_tile_cell_half(&cell, 0),
                                        psplat_tile_cell_half(&cell, 1)};
    uint64_t lower = c->before[begin + cells / 2] - c->before[begin];
    uint32_t first = (uint32_t)s->node_count;
    s->nodes[node].axis = psplat_tile_cell_axis(&cell);
    s->nodes[node].middle = halves[1].low[s->nodes[node].axis];
    s->nodes[node].children = first;
    return add_node(s, &halves[0], lower) &&
           add_node(s, &halves[1], s->nodes[node].count - lower) &&
           split_node(s, c, first, level + 1, 2 * index) &&
           split_node(s, c, first + 1, level + 1, 2 * index + 1);
}

static void free_counted(sorter *s) {
    for (size_t i = 0; i < s->counted_count; ++i) {
        free(s->counted[i].halvings);
        free(s->counted[i].before);
    }
    free(s->counted);
    s->counted = NULL;
    s->counted_count = 0;
}

/* Makes counters for all nodes that have too many triangles, about as many of each as of all others
 * and no more in all, however many nodes there are. Returns 0 when out of memory. */
static int begin_counting(sorter *s, int levels) {
    size_t heavy = 0, deepest = 0;
    for (size_t i = 0; i < s->node_count; ++i) {
        const tree_node *n = &s->nodes[i];
        if (!is_heavy(s, n)) continue;
        ++heavy;
        if (n->cell.depth > deepest) deepest = n->cell.depth;
    }
    if (levels > PSPLAT_MOST_BLOCK_DEPTH - (int)deepest)
        levels = PSPLAT_MOST_BLOCK_DEPTH - (int)deepest;
    while (levels > 1 && heavy << levels > (size_t)1 << ALL_LEVELS && heavy > 1) --levels;
    s->levels = levels;
    s->counted = calloc(heavy + 1, sizeof *s->counted);
    if (!s->counted) return 0;
    for (size_t i = 0; i < s->node_count; ++i) {
        const tree_node *n = &s->nodes[i];
        if (!is_heavy(s, n)) continue;
        counted *c = &s->counted[s->counted_count++];
        c->node = (uint32_t)i;
        c->halvings = malloc(((size_t)1 << levels) * sizeof *c->halvings);
        c->before = calloc(((size_t)1 << levels) + 1, sizeof *c->before);
        if (!c->halvings || !c->before) return 0;
        fill_halvings(c->halvings, 0, &n->cell, levels);
    }
    return 1;
}

/* Returns by how many levels the first pass counts: enough that all blocks but those of very uneven
 * triangles are above them, and no more, since each level doubles the counters. */
static int first_levels(uint64_t triangles, uint64_t most) {
    int levels = CELL_LEVELS;
    while (levels < FIRST_LEVELS && triangles >> (levels - CELL_LEVELS) > most) ++levels;
    return levels;
}

/* Splits the root until no block has too many triangles, or only such as cannot be split. */
static psplat_result split_cells(sorter *s, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    int levels = first_levels(s->leaves->triangles, s->most), is_split = 0;
    if (!add_node(s, &s->leaves->root, s->leaves->triangles)) return fail_memory(error);
    while (!result && !is_split) {
        int has_memory = begin_counting(s, levels);
        is_split = has_memory && !s->counted_count;
        levels = CELL_LEVELS;
        if (!is_split && has_memory) result = count(s, error);
        for (size_t i = 0; i < s->counted_count && has_memory && !result; ++i)
            has_memory = split_node(s, &s->counted[i], s->counted[i].node, 0, 0);
        if (!has_memory) result = fail_memory(error);
        free_counted(s);
    }
    for (size_t i = 0; i < s->node_count; ++i) s->leaves->count += !s->nodes[i].children;
    return result;
}

/* Numbers the blocks in the order of their paths, which is that of their triangles. */
static void number_blocks(sorter *s, uint32_t node, size_t *next, uint64_t *before) {
    tree_node *n = &s->nodes[node];
    if (n->children) {
        number_blocks(s, n->children, next, before);
        number_blocks(s, n->children + 1, next, before);
        return;
    }
    psplat_tile_leaf *leaf = &s->leaves->leaves[*next];
    n->leaf = (uint32_t)(*next)++;
    memcpy(leaf->path, n->cell.path, n->cell.depth + 1);
    leaf->first = *before;
    leaf->count = n->count;
    *before += n->count;
    for (int k = 0; k < 3; ++k) leaf->low[k] = HUGE_VAL, leaf->high[k] = -HUGE_VAL;
    s->fillings[n->leaf].at = leaf->first;
}

static psplat_result make_blocks(sorter *s, psplat_error *error) {
    size_t next = 0;
    uint64_t before = 0;
    psplat_result result = split_cells(s, error);
    if (result) return result;
    size_t count = s->leaves->count, share = ALL_BUFFERS / count;
    s->buffer_size = share < LEAST_BUFFER  ? LEAST_BUFFER
                     : share > MOST_BUFFER ? MOST_BUFFER
                                           : share;
    s->leaves->leaves = calloc(count, sizeof *s->leaves->leaves);
    s->fillings = calloc(count, sizeof *s->fillings);
    s->buffers = malloc(count * s->buffer_size);
    if (!s->leaves->leaves || !s->fillings || !s->buffers) return fail_memory(error);
    number_blocks(s, 0, &next, &before);
    return PSPLAT_OK;
}

/* ---- writing --------------------------------------------------------------------------------- */

static psplat_result fail_store(const sorter *s, const char *what, psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: %s: %s", s->shown, what, strerror(errno));
}

/* Writes what waits of a block. */
static psplat_result flush_block(sorter *s, size_t leaf, psplat_error *error) {
    filling *f = &s->fillings[leaf];
    const char *data = s->buffers + leaf * s->buffer_size;
    size_t size = f->used, at = (size_t)f->at * s->stride;
    while (size) {
        ssize_t written = pwrite(s->file, data, size, (off_t)at);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return fail_store(s, "cannot be written", error);
        data += written;
        at += (size_t)written;
        size -= (size_t)written;
    }
    f->at += f->used / s->stride;
    f->used = 0;
    return PSPLAT_OK;
}

static char *put(char *to, const void *from, size_t size) {
    memcpy(to, from, size);
    return to + size;
}

/* Appends a triangle to its block. */
static psplat_result store_triangle(sorter *s, size_t leaf, const psplat_stream_triangle *t,
                                    psplat_error *error) {
    filling *f = &s->fillings[leaf];
    psplat_tile_leaf *block = &s->leaves->leaves[leaf];
    char *to = s->buffers + leaf * s->buffer_size + f->used;
    for (size_t i = 0; i < 9; ++i) {
        float single = (float)t->positions[i];
        to = s->leaves->is_single ? put(to, &single, sizeof single)
                                  : put(to, &t->positions[i], sizeof(double));
        block->low[i % 3] = min2(block->low[i % 3], t->positions[i]);
        block->high[i % 3] = max2(block->high[i % 3], t->positions[i]);
    }
    if (s->leaves->has_normals) to = put(to, t->normals, sizeof t->normals);
    if (s->leaves->has_colors) put(to, t->colors, sizeof t->colors);
    f->used += s->stride;
    return f->used + s->stride > s->buffer_size ? flush_block(s, leaf, error) : PSPLAT_OK;
}

static uint32_t leaf_of(const sorter *s, const double point[3]) {
    return s->nodes[node_of(s, point)].leaf;
}

/* Marks the blocks that a triangle meets: where only others' triangles reach into a cell, it has a
 * block all the same. */
static void mark_met(sorter *s, uint32_t node, const psplat_stream_triangle *t) {
    const tree_node *n = &s->nodes[node];
    if (!n->children && s->fillings[n->leaf].is_met) return;
    if (!psplat_tile_cell_meets_triangle(&n->cell, t->positions)) return;
    if (!n->children) {
        s->fillings[n->leaf].is_met = 1;
        return;
    }
    mark_met(s, n->children, t);
    mark_met(s, n->children + 1, t);
}

/* Returns whether all corners of a triangle lie in the cell of a block. */
static int is_inside(const sorter *s, uint32_t leaf, const psplat_stream_triangle *t) {
    for (int i = 0; i < 3; ++i)
        if (leaf_of(s, t->positions + 3 * i) != leaf) return 0;
    return 1;
}

static psplat_result take_triangle(sorter *s, const psplat_stream_triangle *t,
                                   psplat_error *error) {
    double centroid[3];
    centroid_of(t, centroid);
    uint32_t leaf = leaf_of(s, centroid);
    const psplat_tile_leaf *block = &s->leaves->leaves[leaf];
    const filling *f = &s->fillings[leaf];
    if (f->at + f->used / s->stride == block->first + block->count)
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: changed while it was read", s->shown);
    if (is_inside(s, leaf, t)) {
        s->fillings[leaf].is_met = 1;
    } else {
        mark_met(s, 0, t);
    }
    return store_triangle(s, leaf, t, error);
}

static psplat_result fill_store(sorter *s, psplat_error *error) {
    psplat_stream_triangle t;
    psplat_result result = PSPLAT_OK;
    psplat_triangle_stream_rewind(s->stream);
    for (int got = 1; got && !result;) {
        result = psplat_triangle_stream_next(s->stream, &t, &got, error);
        if (!result && got) result = take_triangle(s, &t, error);
    }
    for (size_t i = 0; i < s->leaves->count && !result; ++i) result = flush_block(s, i, error);
    if (!result && fsync(s->file) && errno != EINVAL)
        result = fail_store(s, "cannot be written", error);
    return result;
}

/* Drops blocks that no triangle meets. */
static void drop_unmet(sorter *s) {
    size_t kept = 0;
    for (size_t i = 0; i < s->leaves->count; ++i)
        if (s->fillings[i].is_met) s->leaves->leaves[kept++] = s->leaves->leaves[i];
    s->leaves->count = kept;
}

static psplat_result write_store(sorter *s, const char *store, psplat_error *error) {
    size_t length = strlen(store) + 5;
    char *temporary = malloc(length);
    if (!temporary) return fail_memory(error);
    snprintf(temporary, length, "%s.tmp", store);
    psplat_path_shorten(store, s->shown);
    s->file = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    psplat_result result =
        s->file < 0 ? fail_store(s, "cannot be created", error) : fill_store(s, error);
    if (s->file >= 0 && close(s->file) && !result)
        result = fail_store(s, "cannot be written", error);
    if (!result && rename(temporary, store))
        result = fail_store(s, "cannot be put in place", error);
    if (result && s->file >= 0) unlink(temporary);
    free(temporary);
    return result;
}

psplat_result psplat_tile_leaves_sort(psplat_triangle_stream *stream, uint64_t most,
                                      const char *store, psplat_tile_leaves *leaves,
                                      psplat_error *error) {
    const psplat_stream_content *content = psplat_triangle_stream_content(stream);
    *leaves = (psplat_tile_leaves){.is_single = content->is_single,
                                   .has_normals = content->has_normals,
                                   .has_colors = content->has_colors};
    sorter s = {.stream = stream, .leaves = leaves, .most = most, .file = -1};
    psplat_path_shorten("the input", s.shown);
    s.stride = psplat_tile_leaves_stride(leaves);
    psplat_triangle_stream_rewind(stream);
    psplat_result result = find_box(&s, error);
    if (!result) result = make_blocks(&s, error);
    if (!result) result = write_store(&s, store, error);
    if (!result) drop_unmet(&s);
    free(s.nodes);
    free(s.fillings);
    free(s.buffers);
    if (result) psplat_tile_leaves_free(leaves);
    return result;
}

void psplat_tile_leaves_free(psplat_tile_leaves *leaves) {
    free(leaves->leaves);
    *leaves = (psplat_tile_leaves){0};
}

/* ---- reading --------------------------------------------------------------------------------- */

size_t psplat_tile_leaves_stride(const psplat_tile_leaves *leaves) {
    size_t stride = 9 * (leaves->is_single ? sizeof(float) : sizeof(double));
    if (leaves->has_normals) stride += 9 * sizeof(float);
    if (leaves->has_colors) stride += 12 * sizeof(float);
    return stride;
}

static const char *get(void *to, const char *from, size_t size) {
    memcpy(to, from, size);
    return from + size;
}

static void read_triangle(const psplat_tile_leaves *leaves, const char *from,
                          psplat_stream_triangle *t) {
    for (size_t i = 0; i < 9; ++i) {
        float single = 0;
        from = leaves->is_single ? get(&single, from, sizeof single)
                                 : get(&t->positions[i], from, sizeof(double));
        if (leaves->is_single) t->positions[i] = (double)single;
    }
    if (leaves->has_normals) from = get(t->normals, from, sizeof t->normals);
    if (leaves->has_colors) get(t->colors, from, sizeof t->colors);
}

/* Reads size bytes of the store. Returns how many there were, or -1. */
static ssize_t read_bytes(int file, char *to, size_t size, uint64_t at) {
    size_t got = 0;
    while (got < size) {
        ssize_t part = pread(file, to + got, size - got, (off_t)(at + got));
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) return -1;
        if (!part) break;
        got += (size_t)part;
    }
    return (ssize_t)got;
}

static psplat_result read_block(const psplat_tile_leaves *leaves, const psplat_tile_leaf *leaf,
                                int file, char *buffer, const char *shown,
                                psplat_take_triangle *take, void *user, psplat_error *error) {
    size_t stride = psplat_tile_leaves_stride(leaves), fit = READ_BUFFER / stride;
    psplat_stream_triangle t = {0};
    for (uint64_t done = 0; done < leaf->count;) {
        size_t part = leaf->count - done < fit ? (size_t)(leaf->count - done) : fit;
        ssize_t got = read_bytes(file, buffer, part * stride, (leaf->first + done) * stride);
        if (got < 0)
            return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: cannot be read: %s", shown,
                               strerror(errno));
        if ((size_t)got < part * stride)
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                               "%s: ends before the triangles of block '%s'", shown, leaf->path);
        for (size_t i = 0; i < part; ++i) {
            read_triangle(leaves, buffer + i * stride, &t);
            if (take(user, &t)) return fail_memory(error);
        }
        done += part;
    }
    return PSPLAT_OK;
}

psplat_result psplat_tile_leaf_read(const psplat_tile_leaves *leaves, size_t leaf,
                                    const char *store, psplat_take_triangle *take, void *user,
                                    psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(store, shown);
    int file = open(store, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: cannot be opened: %s", shown,
                           strerror(errno));
    char *buffer = malloc(READ_BUFFER);
    psplat_result result =
        buffer ? read_block(leaves, &leaves->leaves[leaf], file, buffer, shown, take, user, error)
               : fail_memory(error);
    free(buffer);
    close(file);
    return result;
}
