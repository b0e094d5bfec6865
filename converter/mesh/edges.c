/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * edges.c - edges of a triangle mesh: pairs of half-edges, vertices and vectors.
 *
 * Half-edges are sorted into buckets by their lesser vertex and within them by the other, so that
 * the half-edges of one edge are neighbours.
 */
#include "mesh/edges.h"

#include "base/vector.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

typedef struct half_edge {
    uint32_t other; /* the greater vertex of the edge; the lesser one is the bucket */
    uint32_t index; /* triangle * 3 + k */
} half_edge;

/* The most half-edges of a bucket that insertion sorts; most buckets have three. Chosen by hand. */
enum { FEW_EDGES = 24 };

static int compare_half_edges(const void *left, const void *right) {
    const half_edge *a = left, *b = right;
    if (a->other != b->other) return a->other < b->other ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Sorts half-edges by their greater vertex, those of one edge by index. */
static void sort_bucket(half_edge *edges, size_t count) {
    if (count > FEW_EDGES) {
        qsort(edges, count, sizeof *edges, compare_half_edges);
        return;
    }
    for (size_t i = 1; i < count; ++i) {
        half_edge edge = edges[i];
        size_t at = i;
        /* Buckets are filled in the order of indices, so that equal edges stay in it. */
        for (; at && edges[at - 1].other > edge.other; --at) edges[at] = edges[at - 1];
        edges[at] = edge;
    }
}

static void pair(uint32_t a, uint32_t b, uint32_t *pairs) {
    pairs[a] = b;
    pairs[b] = a;
}

/* Returns whether the triangles of two half-edges of one edge are the same and face opposite ways.
 */
static int are_twins(const psplat_mesh *mesh, uint32_t a, uint32_t b) {
    uint32_t third_of_a = mesh->triangles[a % 3 ? a - 1 : a + 2];
    uint32_t third_of_b = mesh->triangles[b % 3 ? b - 1 : b + 2];
    return third_of_a == third_of_b && mesh->triangles[a] != mesh->triangles[b];
}

/* Pairs the half-edges of an edge where a sheet that has triangles on both sides meets a surface
 * that has none: with the side that goes on in it. */
static void pair_end_of_sheet(const psplat_mesh *mesh, const half_edge *edges, uint32_t *pairs) {
    for (size_t k = 0; k < 3; ++k) {
        uint32_t wall = edges[k].index, a = edges[(k + 1) % 3].index, b = edges[(k + 2) % 3].index;
        if (!are_twins(mesh, a, b)) continue;
        pair(wall, mesh->triangles[a] != mesh->triangles[wall] ? a : b, pairs);
        return;
    }
}

/* Pairs the four half-edges of an edge inside a sheet that has triangles on both sides: each with
 * that which runs the other way and is not its twin's, so that either side is a surface of its own.
 * Does nothing where the triangles are others. */
static void pair_sheet(const psplat_mesh *mesh, const half_edge *edges, uint32_t *pairs) {
    for (size_t k = 1; k < 4; ++k) {
        uint32_t a = edges[0].index, twin = edges[k].index;
        uint32_t b = edges[k == 1 ? 2 : 1].index, c = edges[k == 3 ? 2 : 3].index;
        if (!are_twins(mesh, a, twin) || !are_twins(mesh, b, c)) continue;
        int is_b = mesh->triangles[a] != mesh->triangles[b];
        pair(a, is_b ? b : c, pairs);
        pair(twin, is_b ? c : b, pairs);
        return;
    }
}

/* Pairs the half-edges of a bucket. Returns how many edges of it belong to one triangle only. */
static size_t pair_bucket(const psplat_mesh *mesh, half_edge *edges, size_t count,
                          uint32_t *pairs) {
    size_t borders = 0;
    sort_bucket(edges, count);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && edges[end].other == edges[begin].other;) ++end;
        borders += end - begin == 1;
        if (end - begin == 2) pair(edges[begin].index, edges[begin + 1].index, pairs);
        if (end - begin == 3) pair_end_of_sheet(mesh, edges + begin, pairs);
        if (end - begin == 4) pair_sheet(mesh, edges + begin, pairs);
    }
    return borders;
}

static void edge_ends(const psplat_mesh *mesh, uint32_t edge, uint32_t *low, uint32_t *high) {
    uint32_t a = mesh->triangles[edge], b = mesh->triangles[edge % 3 == 2 ? edge - 2 : edge + 1];
    *low = a < b ? a : b;
    *high = a < b ? b : a;
}

/* Sorts half-edges into buckets by their lesser vertex. Leaves the ends of buckets in starts. */
static void fill_buckets(const psplat_mesh *mesh, size_t *starts, half_edge *edges) {
    uint32_t low, high, count = (uint32_t)(3 * mesh->triangle_count);
    for (uint32_t e = 0; e < count; ++e) {
        edge_ends(mesh, e, &low, &high);
        starts[low + 1]++;
    }
    for (size_t v = 0; v < mesh->vertex_count; ++v) starts[v + 1] += starts[v];
    for (uint32_t e = 0; e < count; ++e) {
        edge_ends(mesh, e, &low, &high);
        edges[starts[low]++] = (half_edge){high, e};
    }
}

psplat_result psplat_edge_pairs(const psplat_mesh *mesh, uint32_t *pairs, size_t *borders) {
    size_t edge_count = 3 * mesh->triangle_count, found = 0;
    size_t *starts = calloc(mesh->vertex_count + 1, sizeof *starts);
    half_edge *edges = malloc((edge_count + 1) * sizeof *edges);
    memset(pairs, 0xff, edge_count * sizeof *pairs);
    if (starts && edges) {
        fill_buckets(mesh, starts, edges);
#pragma omp parallel for reduction(+ : found) schedule(static)
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            size_t begin = v ? starts[v - 1] : 0;
            found += pair_bucket(mesh, edges + begin, starts[v] - begin, pairs);
        }
    }
    psplat_result result = starts && edges ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    *borders = found;
    free(starts);
    free(edges);
    return result;
}

void psplat_edge_vector(const psplat_mesh *mesh, uint32_t edge, double vector[3]) {
    uint32_t a = mesh->triangles[edge], b = mesh->triangles[edge % 3 == 2 ? edge - 2 : edge + 1];
    sub3(vector, mesh->positions + 3 * (size_t)b, mesh->positions + 3 * (size_t)a);
}

uint32_t psplat_edge_vertex(const psplat_mesh *mesh, uint32_t edge, int end) {
    uint32_t next = edge % 3 == 2 ? edge - 2 : edge + 1;
    return mesh->triangles[end ? next : edge];
}
