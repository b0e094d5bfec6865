/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * proxy.c - a mesh of fewer triangles that is proven to lie near its source.
 *
 * meshoptimizer collapses edges while its estimate of the error, a mean over quadrics (Garland,
 * Heckbert: Surface Simplification Using Quadric Error Metrics, 1997), stays small. It bounds
 * nothing, so that each triangle of the result is proven by itself (proxy_bound.c). The triangles
 * of the source around those that cannot be proven, and those beside no triangle at all, are taken
 * as they are. The proxy may have gaps and overlaps as wide as its deviation; distances do not
 * mind.
 */
#include "mesh/proxy.h"

#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

/* The part of the greatest deviation that the simplifier may use by its own estimate. Chosen by
 * hand: with more, too many triangles cannot be proven. */
static const double simplified_part = 0.5;

/* What lies beside a triangle of the source. */
enum { PROVEN = 1, UNPROVEN = 2 };

typedef struct builder {
    const psplat_mesh *source;
    psplat_proxy_search search;
    uint32_t *neighbors; /* of search */
    double least_gain;
    uint32_t *indices; /* of the simplified triangles, which become the proven ones */
    size_t count;
    uint32_t *starts; /* of each vertex, a triangle of the source that has it */
    uint8_t *beside;  /* of each triangle of the source */
    psplat_proxy *proxy;
} builder;

/* ---- simplification -------------------------------------------------------------------------- */

/* Returns the positions in single precision, scaled into the box from 0 to 1; NULL when out of
 * memory. *size is the length of the longest side of the source's box. */
static float *unit_positions(const psplat_mesh *mesh, double *size) {
    float *positions = malloc((3 * mesh->vertex_count + 1) * sizeof *positions);
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    *size = 0;
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        double value = mesh->positions[i];
        if (value < low[i % 3]) low[i % 3] = value;
        if (value > high[i % 3]) high[i % 3] = value;
    }
    for (int k = 0; k < 3; ++k) *size = fmax(*size, high[k] - low[k]);
    for (size_t i = 0; positions && i < 3 * mesh->vertex_count; ++i)
        positions[i] = (float)((mesh->positions[i] - low[i % 3]) / *size);
    return positions;
}

/* Fills in indices and count. */
static psplat_result simplify(builder *b) {
    const psplat_mesh *mesh = b->source;
    size_t all = 3 * mesh->triangle_count;
    double size;
    float *positions = unit_positions(mesh, &size);
    b->indices = malloc(all * sizeof *b->indices);
    if (!positions || !b->indices) {
        free(positions);
        return PSPLAT_ERROR_MEMORY;
    }
    float error = (float)(simplified_part * b->search.most / size);
    b->count = meshopt_simplify(b->indices, mesh->triangles, all, positions, mesh->vertex_count,
                                3 * sizeof *positions, 0, error, 0, NULL) /
               3;
    free(positions);
    uint32_t *smaller = realloc(b->indices, (3 * b->count + 1) * sizeof *smaller);
    if (smaller) b->indices = smaller;
    return PSPLAT_OK;
}

/* ---- proofs ---------------------------------------------------------------------------------- */

static psplat_result find_neighbors(builder *b) {
    size_t borders, edges = 3 * b->source->triangle_count;
    b->search.neighbors = b->neighbors = malloc((edges + 1) * sizeof *b->neighbors);
    if (!b->neighbors) return PSPLAT_ERROR_MEMORY;
    psplat_result result = psplat_edge_pairs(b->source, b->neighbors, &borders);
    for (size_t e = 0; e < edges && !result; ++e)
        if (b->neighbors[e] != PSPLAT_NONE) b->neighbors[e] /= 3;
    return result;
}

static psplat_result prepare_search(builder *b) {
    const psplat_mesh *mesh = b->source;
    psplat_result result = find_neighbors(b);
    if (result) return result;
    b->search.visited = calloc(mesh->triangle_count, sizeof *b->search.visited);
    b->starts = malloc((mesh->vertex_count + 1) * sizeof *b->starts);
    b->beside = calloc(mesh->triangle_count, 1);
    if (!b->search.visited || !b->starts || !b->beside) return PSPLAT_ERROR_MEMORY;
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) b->starts[mesh->triangles[i]] = i / 3;
    return PSPLAT_OK;
}

/* Proves all simplified triangles, and leaves those that can be proven. */
static psplat_result prove(builder *b) {
    size_t kept = 0;
    for (size_t t = 0; t < b->count; ++t) {
        const uint32_t *corners = b->indices + 3 * t;
        double deviation;
        b->search.stamp = (uint32_t)t + 1;
        if (psplat_proxy_bound(&b->search, corners, b->starts[corners[0]], &deviation))
            return PSPLAT_ERROR_MEMORY;
        int is_proven = deviation <= b->search.most;
        for (size_t i = 0; i < b->search.count; ++i)
            b->beside[b->search.stack[i]] |= is_proven ? PROVEN : UNPROVEN;
        if (!is_proven) continue;
        memmove(b->indices + 3 * kept++, corners, 3 * sizeof *corners);
        b->proxy->deviation = fmax(b->proxy->deviation, deviation);
    }
    b->proxy->unproven = b->count - kept;
    b->count = kept;
    for (size_t t = 0; t < b->source->triangle_count; ++t) b->proxy->kept += b->beside[t] != PROVEN;
    return PSPLAT_OK;
}

/* ---- result ---------------------------------------------------------------------------------- */

/* Numbers the vertices in use. starts, which is no longer needed, becomes the new numbers. */
static void copy_vertex(builder *b, uint32_t vertex, uint32_t *copy) {
    psplat_mesh *mesh = &b->proxy->mesh;
    if (b->starts[vertex] == PSPLAT_NONE) {
        b->starts[vertex] = (uint32_t)mesh->vertex_count++;
        memcpy(mesh->positions + 3 * (size_t)b->starts[vertex],
               b->source->positions + 3 * (size_t)vertex, 3 * sizeof *mesh->positions);
    }
    *copy = b->starts[vertex];
}

static psplat_result store(builder *b) {
    psplat_mesh *mesh = &b->proxy->mesh;
    size_t total = b->count + b->proxy->kept, most = 3 * total;
    if (most > b->source->vertex_count) most = b->source->vertex_count;
    mesh->triangles = malloc((3 * total + 1) * sizeof *mesh->triangles);
    mesh->positions = malloc((3 * most + 1) * sizeof *mesh->positions);
    if (!mesh->triangles || !mesh->positions) return PSPLAT_ERROR_MEMORY;
    memset(b->starts, 0xff, b->source->vertex_count * sizeof *b->starts);
    uint32_t *to = mesh->triangles;
    for (size_t i = 0; i < 3 * b->count; ++i) copy_vertex(b, b->indices[i], to++);
    for (size_t t = 0; t < b->source->triangle_count; ++t)
        for (size_t k = 0; k < 3 && b->beside[t] != PROVEN; ++k)
            copy_vertex(b, b->source->triangles[3 * t + k], to++);
    mesh->triangle_count = total;
    return PSPLAT_OK;
}

static int pays(const builder *b, size_t count) {
    return b->least_gain * (double)count <= (double)b->source->triangle_count;
}

static psplat_result build(builder *b) {
    psplat_result result = simplify(b);
    if (result || !pays(b, b->count)) return result;
    result = prepare_search(b);
    if (!result) result = prove(b);
    if (!result && pays(b, b->count + b->proxy->kept)) result = store(b);
    return result;
}

psplat_result psplat_proxy_build(const psplat_mesh *source, double most, double least_gain,
                                 psplat_proxy *proxy) {
    *proxy = (psplat_proxy){0};
    builder b = {.source = source,
                 .proxy = proxy,
                 .least_gain = least_gain,
                 .search = {.source = source, .most = most}};
    if (source->point_count) return PSPLAT_OK;
    psplat_result result = build(&b);
    free(b.neighbors);
    free(b.indices);
    free(b.starts);
    free(b.beside);
    free(b.search.visited);
    free(b.search.stack);
    if (result) psplat_proxy_free(proxy);
    return result;
}

void psplat_proxy_free(psplat_proxy *proxy) {
    psplat_mesh_free(&proxy->mesh);
    *proxy = (psplat_proxy){0};
}
