/* SPDX-License-Identifier: MIT
 *
 * Meshes as the converter reads them: its corners, equal ones united.
 */
#include "mesh.h"

#include "stages.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double crease_angle = 3.14159265358979323846 / 6; /* the converter's default */

typedef struct corner {
    uint32_t vertex, index; /* index of the corner in the mesh */
    float normal[3], color[4];
} corner;

static void fail(const char *path, const char *why) {
    fprintf(stderr, "bench: %s: %s\n", path, why);
    exit(1);
}

static int compare(const void *left, const void *right) {
    const corner *a = left, *b = right;
    if (a->vertex != b->vertex) return a->vertex < b->vertex ? -1 : 1;
    int normals = memcmp(a->normal, b->normal, sizeof a->normal);
    return normals ? normals : memcmp(a->color, b->color, sizeof a->color);
}

static corner *take_corners(const psplat_mesh *source, const psplat_surface *surface) {
    size_t count = 3 * source->triangle_count;
    corner *corners = malloc(count * sizeof *corners);
    if (!corners) fail("mesh", "out of memory");
    for (size_t i = 0; i < count; ++i) {
        corners[i] = (corner){source->triangles[i], (uint32_t)i, {0}, {1, 1, 1, 1}};
        memcpy(corners[i].normal, surface->corner_normals + 3 * i, sizeof corners[i].normal);
        if (source->corner_colors)
            memcpy(corners[i].color, source->corner_colors + 4 * i, sizeof corners[i].color);
    }
    qsort(corners, count, sizeof *corners, compare);
    return corners;
}

static void unite(mesh *m, const psplat_mesh *source, const corner *corners) {
    size_t count = 3 * source->triangle_count;
    m->vertices = malloc(count * sizeof *m->vertices);
    m->indices = malloc(count * sizeof *m->indices);
    if (!m->vertices || !m->indices) fail("mesh", "out of memory");
    for (size_t i = 0; i < count; ++i) {
        const corner *c = &corners[i];
        if (!i || compare(c - 1, c)) {
            mesh_vertex *vertex = &m->vertices[m->vertex_count++];
            for (int k = 0; k < 3; ++k)
                vertex->position[k] = (float)source->positions[3 * (size_t)c->vertex + (size_t)k];
            memcpy(vertex->normal, c->normal, sizeof vertex->normal);
            memcpy(vertex->color, c->color, sizeof vertex->color);
        }
        m->indices[c->index] = (uint32_t)(m->vertex_count - 1);
    }
}

mesh mesh_read(const char *path) {
    psplat_mesh source = {0};
    psplat_surface surface = {0};
    psplat_error error;
    if (psplat_mesh_read(path, &source, &error)) fail(path, error.text);
    if (psplat_surface_build(&source, crease_angle, &surface, &error)) fail(path, error.text);
    mesh m = {.triangle_count = source.triangle_count, .material = source.material};
    memcpy(m.origin, source.origin, sizeof m.origin);
    corner *corners = take_corners(&source, &surface);
    unite(&m, &source, corners);
    free(corners);
    psplat_surface_free(&surface);
    psplat_mesh_free(&source);
    return m;
}
