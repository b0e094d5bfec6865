/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * weld.c - vertex welding, and dropping of degenerate and repeated triangles.
 *
 * Equal positions and equal triangles are found by hash tables with open addressing and linear
 * probing (Knuth, The Art of Computer Programming 3, section 6.4).
 */
#include "mesh/weld.h"

#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A triangle is flat if twice its area, in squares of its longest edge, is at most this. It is the
 * rounding error of the products that the area is made of, some 2^-50. */
static const double flat_double_area = 1e-15;

static uint64_t hash_position(const double p[3]) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        uint64_t bits;
        memcpy(&bits, &p[k], sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

static size_t table_size(size_t entries) {
    size_t size = 16;
    while (size < entries * 2) size *= 2;
    return size;
}

/* Returns the new number of position p, which is the next one if p is not in the table. */
static uint32_t vertex_number(uint32_t *table, size_t size, double *positions, size_t *count,
                              const double p[3]) {
    size_t slot = hash_position(p) & (size - 1);
    while (table[slot] != PSPLAT_NONE) {
        const double *q = positions + (size_t)table[slot] * 3;
        if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) return table[slot];
        slot = (slot + 1) & (size - 1);
    }
    table[slot] = (uint32_t)*count;
    memcpy(positions + *count * 3, p, 3 * sizeof(double));
    return (uint32_t)(*count)++;
}

static void move_triangle(psplat_mesh *mesh, size_t to, size_t from) {
    if (to == from) return;
    memcpy(mesh->triangles + to * 3, mesh->triangles + from * 3, 3 * sizeof(uint32_t));
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(mesh, arrays);
    for (size_t i = 0; i < count; ++i) {
        size_t floats = 3 * arrays[i].components;
        memcpy(arrays[i].values + to * floats, arrays[i].values + from * floats,
               floats * sizeof(float));
    }
    if (mesh->groups) mesh->groups[to] = mesh->groups[from];
}

/* Keeps the triangles for which keep returns other than 0, in order, and counts the others. */
static void filter(psplat_mesh *mesh, int (*keep)(const psplat_mesh *mesh, size_t triangle)) {
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (keep(mesh, t)) move_triangle(mesh, kept++, t);
    mesh->dropped += mesh->triangle_count - kept;
    mesh->triangle_count = kept;
}

static int has_three_vertices(const psplat_mesh *mesh, size_t triangle) {
    const uint32_t *t = mesh->triangles + triangle * 3;
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

/* Returns the length of a vector, also where its square leaves the range of doubles. */
static double safe_length(const double v[3]) {
    double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square > 1e-280 && square < 1e280) return sqrt(square);
    return hypot(hypot(v[0], v[1]), v[2]);
}

static int has_area(const psplat_mesh *mesh, size_t triangle) {
    const uint32_t *t = mesh->triangles + triangle * 3;
    double e[3][3], longest = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double *a = mesh->positions + (size_t)t[i] * 3;
        const double *b = mesh->positions + (size_t)t[(i + 1) % 3] * 3;
        for (int k = 0; k < 3; ++k) e[i][k] = b[k] - a[k];
        double length = safe_length(e[i]);
        if (length > longest) longest = length;
    }
    if (!(longest > 0)) return 0;
    /* Edges are scaled by the longest, so that models of no size under- or overflow. */
    for (size_t i = 0; i < 2; ++i)
        for (int k = 0; k < 3; ++k) e[i][k] /= longest;
    double x = e[0][1] * e[1][2] - e[0][2] * e[1][1];
    double y = e[0][2] * e[1][0] - e[0][0] * e[1][2];
    double z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return sqrt(x * x + y * y + z * z) > flat_double_area;
}

psplat_result psplat_mesh_weld(psplat_mesh *mesh, psplat_error *error) {
    size_t size = table_size(mesh->vertex_count);
    uint32_t *table = malloc(size * sizeof *table);
    double *positions = malloc((mesh->vertex_count + 1) * 3 * sizeof *positions);
    if (!table || !positions) {
        free(table);
        free(positions);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while welding");
    }
    memset(table, 0xff, size * sizeof *table);
    size_t count = 0;
    /* Vertices are numbered in the order of their first use. Those without use get no number. */
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
        const double *raw = mesh->positions + (size_t)mesh->triangles[i] * 3;
        double p[3] = {raw[0] + 0.0, raw[1] + 0.0, raw[2] + 0.0}; /* -0 becomes 0 */
        mesh->triangles[i] = vertex_number(table, size, positions, &count, p);
    }
    free(table);
    free(mesh->positions);
    mesh->positions = positions;
    mesh->vertex_count = count;
    filter(mesh, has_three_vertices);
    return PSPLAT_OK;
}

/* Returns 1 if two triangles have the same vertices in the same cyclic order, -1 if in the opposite
 * order, and 0 otherwise. */
static int compare_triangles(const uint32_t *a, const uint32_t *b) {
    for (int k = 0; k < 3; ++k) {
        if (a[0] != b[k]) continue;
        if (a[1] == b[(k + 1) % 3] && a[2] == b[(k + 2) % 3]) return 1;
        if (a[1] == b[(k + 2) % 3] && a[2] == b[(k + 1) % 3]) return -1;
    }
    return 0;
}

/* The hash does not depend on the order of the vertices. */
static uint64_t hash_triangle(const uint32_t *t) {
    uint64_t sum = (uint64_t)t[0] + t[1] + t[2], bits = t[0] ^ t[1] ^ t[2];
    uint64_t hash = (sum << 32 ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 32;
}

psplat_result psplat_mesh_drop_repeated(psplat_mesh *mesh, int *turned, psplat_error *error) {
    size_t size = table_size(mesh->triangle_count), kept = 0;
    uint32_t *table = malloc(size * sizeof *table);
    *turned = 0;
    if (!table)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for repeated triangles");
    memset(table, 0xff, size * sizeof *table);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *triangle = mesh->triangles + 3 * t;
        size_t slot = hash_triangle(triangle) & (size - 1);
        int match = 0;
        for (; table[slot] != PSPLAT_NONE && !match; slot = (slot + 1) & (size - 1))
            match = compare_triangles(triangle, mesh->triangles + 3 * (size_t)table[slot]);
        if (match < 0) *turned = 1;
        if (match) continue;
        table[slot] = (uint32_t)kept;
        move_triangle(mesh, kept++, t);
    }
    free(table);
    mesh->dropped += mesh->triangle_count - kept;
    mesh->triangle_count = kept;
    return PSPLAT_OK;
}

void psplat_mesh_drop_flat(psplat_mesh *mesh) {
    filter(mesh, has_area);
}
