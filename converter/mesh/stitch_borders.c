/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stitch_borders.c - stitching of borders that differ by rounding alone.
 *
 * A file in single precision may hold the two sides of an edge with coordinates that differ in
 * their last digit (1e-9 on one side, 0 on the other), so that exact welding leaves a slit.
 * Vertices on borders that nearly coincide are moved onto each other and welded. A closed mesh
 * stays as it is.
 */
#include "mesh/stitch_borders.h"

#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The distance per axis up to which border vertices are merged, in diagonals of the bounding box.
 * It is twice the rounding of single precision, which is 6e-8 of the largest coordinate. */
static const double merge_distance_diagonals = 1.2e-7;

/* ---- borders -------------------------------------------------------------------------------- */

/* Marks the ends of edges without a pair. *count is the number of these edges. */
static psplat_result find_borders(const psplat_mesh *mesh, uint8_t *border, size_t *count,
                                  psplat_error *error) {
    size_t edges = 3 * mesh->triangle_count, borders;
    uint32_t *pairs = malloc((edges + 1) * sizeof *pairs);
    psplat_result result = pairs ? psplat_edge_pairs(mesh, pairs, &borders) : PSPLAT_ERROR_MEMORY;
    memset(border, 0, mesh->vertex_count);
    *count = 0;
    for (size_t e = 0; !result && e < edges; ++e) {
        if (pairs[e] != PSPLAT_NONE) continue;
        border[mesh->triangles[e]] = border[mesh->triangles[e % 3 == 2 ? e - 2 : e + 1]] = 1;
        ++*count;
    }
    free(pairs);
    return result ? psplat_fail(error, result, 0, "out of memory for edges") : PSPLAT_OK;
}

/* ---- merging -------------------------------------------------------------------------------- */

/* A hash grid of border vertices whose cells are as wide as the tolerance. */
typedef struct vertex_grid {
    const psplat_mesh *mesh;
    uint32_t *table; /* vertices, or PSPLAT_NONE */
    size_t size;
    double low[3], tolerance;
} vertex_grid;

static size_t slot_of(const vertex_grid *c, const double p[3], const int step[3]) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        int64_t cell = (int64_t)floor((p[k] - c->low[k]) / c->tolerance) + step[k];
        hash = (hash ^ (uint64_t)cell) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash & (c->size - 1);
}

/* Returns a vertex of the grid within the tolerance of p on each axis, or PSPLAT_NONE. */
static uint32_t find_near(const vertex_grid *c, const double p[3]) {
    for (int i = 0; i < 27; ++i) {
        int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        for (size_t slot = slot_of(c, p, step); c->table[slot] != PSPLAT_NONE;
             slot = (slot + 1) & (c->size - 1)) {
            const double *q = c->mesh->positions + (size_t)c->table[slot] * 3;
            if (fabs(p[0] - q[0]) <= c->tolerance && fabs(p[1] - q[1]) <= c->tolerance &&
                fabs(p[2] - q[2]) <= c->tolerance)
                return c->table[slot];
        }
    }
    return PSPLAT_NONE;
}

static void insert(vertex_grid *c, uint32_t vertex) {
    static const int here[3] = {0, 0, 0};
    size_t slot = slot_of(c, c->mesh->positions + (size_t)vertex * 3, here);
    while (c->table[slot] != PSPLAT_NONE) slot = (slot + 1) & (c->size - 1);
    c->table[slot] = vertex;
}

/* Returns the diagonal of the bounding box and stores its lower corner. */
static double measure_diagonal(const psplat_mesh *mesh, double low[3]) {
    double high[3];
    memcpy(low, mesh->positions, 3 * sizeof *low);
    memcpy(high, mesh->positions, sizeof high);
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        double value = mesh->positions[i];
        if (value < low[i % 3]) low[i % 3] = value;
        if (value > high[i % 3]) high[i % 3] = value;
    }
    return hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
}

/* Moves each border vertex onto the first one near it, so that welding merges them. */
static psplat_result snap_borders(psplat_mesh *mesh, const uint8_t *border, psplat_error *error) {
    vertex_grid c = {.mesh = mesh, .size = 16};
    size_t count = 0;
    for (size_t v = 0; v < mesh->vertex_count; ++v) count += border[v];
    while (c.size < count * 2) c.size *= 2;
    c.tolerance = merge_distance_diagonals * measure_diagonal(mesh, c.low);
    if (!isfinite(c.tolerance) || !(c.tolerance > 0)) return PSPLAT_OK;
    c.table = malloc(c.size * sizeof *c.table);
    if (!c.table) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for borders");
    memset(c.table, 0xff, c.size * sizeof *c.table);
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        if (!border[v]) continue;
        double *p = mesh->positions + (size_t)v * 3;
        uint32_t near = find_near(&c, p);
        if (near == PSPLAT_NONE)
            insert(&c, v);
        else
            memcpy(p, mesh->positions + (size_t)near * 3, 3 * sizeof *p);
    }
    free(c.table);
    return PSPLAT_OK;
}

psplat_result psplat_mesh_stitch_borders(psplat_mesh *mesh, int *closed, psplat_error *error) {
    size_t count = 0;
    *closed = 0;
    if (mesh->triangle_count == 0) return PSPLAT_OK;
    uint8_t *border = malloc(mesh->vertex_count);
    if (!border) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for borders");
    psplat_result result = find_borders(mesh, border, &count, error);
    if (!result && count) {
        result = snap_borders(mesh, border, error);
        if (!result) result = psplat_mesh_weld(mesh, error);
        if (!result) result = find_borders(mesh, border, &count, error);
    }
    *closed = !result && count == 0 && mesh->triangle_count > 0;
    free(border);
    return result;
}
