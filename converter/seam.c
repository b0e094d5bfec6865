/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * seam.c - borders that are none: a file in single precision may hold the two sides of an edge with
 * coordinates that differ in their last digit (1e-9 here, 0 there), so that exact welding leaves a
 * slit. Only vertices on borders are looked at; a closed mesh passes unchanged.
 */
#include "source.h"
#include "stages.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EMPTY UINT32_MAX

/* Rounding of single precision is 6e-8 of the largest coordinate; twice that, of the diagonal. */
#define SEAM 1.2e-7

/* ---- borders -------------------------------------------------------------------------------- */

/* Marks the ends of edges that do not have two triangles. *count: how many edges these are. */
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

/* ---- joining -------------------------------------------------------------------------------- */

/* Border vertices by cell of a grid whose cells are as wide as the tolerance. */
typedef struct cells {
    const psplat_mesh *mesh;
    uint32_t *table;
    size_t size;
    double low[3], tolerance;
} cells;

static size_t slot_of(const cells *c, const double p[3], const int step[3]) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        int64_t cell = (int64_t)floor((p[k] - c->low[k]) / c->tolerance) + step[k];
        hash = (hash ^ (uint64_t)cell) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash & (c->size - 1);
}

/* An earlier vertex within the tolerance, or EMPTY. */
static uint32_t find_near(const cells *c, const double p[3]) {
    for (int i = 0; i < 27; ++i) {
        int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        for (size_t slot = slot_of(c, p, step); c->table[slot] != EMPTY;
             slot = (slot + 1) & (c->size - 1)) {
            const double *q = c->mesh->positions + (size_t)c->table[slot] * 3;
            if (fabs(p[0] - q[0]) <= c->tolerance && fabs(p[1] - q[1]) <= c->tolerance &&
                fabs(p[2] - q[2]) <= c->tolerance)
                return c->table[slot];
        }
    }
    return EMPTY;
}

static void insert(cells *c, uint32_t vertex) {
    static const int here[3] = {0, 0, 0};
    size_t slot = slot_of(c, c->mesh->positions + (size_t)vertex * 3, here);
    while (c->table[slot] != EMPTY) slot = (slot + 1) & (c->size - 1);
    c->table[slot] = vertex;
}

static double measure(const psplat_mesh *mesh, double low[3]) {
    double high[3];
    memcpy(low, mesh->positions, 3 * sizeof *low);
    memcpy(high, mesh->positions, sizeof high);
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        low[i % 3] = fmin(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    return hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
}

/* Moves each border vertex onto the first one near it; welding then joins them. */
static psplat_result snap(psplat_mesh *mesh, const uint8_t *border, psplat_error *error) {
    cells c = {.mesh = mesh, .size = 16};
    size_t count = 0;
    for (size_t v = 0; v < mesh->vertex_count; ++v) count += border[v];
    while (c.size < count * 2) c.size *= 2;
    c.tolerance = SEAM * measure(mesh, c.low);
    if (!isfinite(c.tolerance) || !(c.tolerance > 0)) return PSPLAT_OK;
    c.table = malloc(c.size * sizeof *c.table);
    if (!c.table) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for borders");
    memset(c.table, 0xff, c.size * sizeof *c.table);
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        if (!border[v]) continue;
        double *p = mesh->positions + (size_t)v * 3;
        uint32_t near = find_near(&c, p);
        if (near == EMPTY)
            insert(&c, v);
        else
            memcpy(p, mesh->positions + (size_t)near * 3, 3 * sizeof *p);
    }
    free(c.table);
    return PSPLAT_OK;
}

psplat_result psplat_mesh_close_seams(psplat_mesh *mesh, int *closed, psplat_error *error) {
    size_t count = 0;
    *closed = 0;
    if (mesh->triangle_count == 0) return PSPLAT_OK;
    uint8_t *border = malloc(mesh->vertex_count);
    if (!border) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for borders");
    psplat_result result = find_borders(mesh, border, &count, error);
    if (!result && count) {
        result = snap(mesh, border, error);
        if (!result) result = psplat_mesh_weld(mesh, error);
        if (!result) result = find_borders(mesh, border, &count, error);
    }
    *closed = !result && count == 0 && mesh->triangle_count > 0;
    free(border);
    return result;
}
