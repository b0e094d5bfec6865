/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_in.c - a coarse mesh for viewers that know no splats, by libmeshoptimizer.
 *
 * Corners that differ in anything are vertices of their own, and the simplifier moves vertices of
 * one place together or not at all: so creases and the borders of materials stay where they are.
 */
#include "stand_in.h"
#include "paint.h"
#include "stages.h"

#include <meshoptimizer.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is worked on: all corners, then what is left of them. */
typedef struct work {
    const psplat_mesh *mesh;
    psplat_conversion conversion; /* as far as its beginning */
    psplat_stand_in_vertex *vertices;
    uint32_t *indices, *spare;
    size_t vertex_count, index_count;
} work;

/* ---- corners --------------------------------------------------------------------------------- */

static void fill_color(const work *w, size_t triangle, size_t corner, const float normal[3],
                       float color[4]) {
    double barycentric[3] = {0, 0, 0};
    psplat_shade shade;
    barycentric[corner] = 1;
    psplat_paint_shade(&w->conversion.paint, (uint32_t)triangle, barycentric, normal, &shade);
    memcpy(color, shade.color, sizeof shade.color);
}

static void fill_corner(const work *w, size_t triangle, size_t corner,
                        psplat_stand_in_vertex *vertex) {
    size_t index = 3 * triangle + corner;
    const double *position = w->mesh->positions + 3 * (size_t)w->mesh->triangles[index];
    *vertex = (psplat_stand_in_vertex){.color = {1, 1, 1, 1}};
    for (size_t k = 0; k < 3; ++k) vertex->position[k] = (float)position[k];
    memcpy(vertex->normal, w->conversion.surface.corner_normals + 3 * index, sizeof vertex->normal);
    if (w->mesh->appearances && w->mesh->groups) vertex->group = w->mesh->groups[triangle];
    if (w->conversion.paint.has_color)
        fill_color(w, triangle, corner, vertex->normal, vertex->color);
}

static psplat_result fail_memory(const psplat_mesh *mesh, psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0,
                       "no memory to simplify a mesh of %zu triangles", mesh->triangle_count);
}

static psplat_result fill_corners(work *w, psplat_error *error) {
    size_t count = 3 * w->mesh->triangle_count;
    w->vertices = malloc((count + 1) * sizeof *w->vertices);
    w->indices = malloc((count + 1) * sizeof *w->indices);
    w->spare = malloc((count + 1) * sizeof *w->spare);
    if (!w->vertices || !w->indices || !w->spare) return fail_memory(w->mesh, error);
    for (size_t i = 0; i < count; ++i) fill_corner(w, i / 3, i % 3, &w->vertices[i]);
    w->vertex_count = w->index_count = count;
    return PSPLAT_OK;
}

typedef struct mean {
    float color[4], count;
} mean;

/* Colours are means over a triangle's surroundings, so that those of a vertex differ a little from
 * triangle to triangle: they become one where no colour is far from their mean. */
static psplat_result join_colors(work *w, psplat_error *error) {
    static const float far = 0.1f;
    size_t count = w->vertex_count;
    const struct meshopt_Stream streams[] = {
        {w->vertices[0].position, offsetof(psplat_stand_in_vertex, color), sizeof *w->vertices},
        {&w->vertices[0].group, sizeof w->vertices[0].group, sizeof *w->vertices}};
    mean *means = calloc(count + 1, sizeof *means);
    if (!means) return fail_memory(w->mesh, error);
    meshopt_generateVertexRemapMulti(w->spare, NULL, count, count, streams, 2);
    for (size_t i = 0; i < count; ++i) {
        mean *m = &means[w->spare[i]];
        for (int k = 0; k < 4; ++k) m->color[k] += w->vertices[i].color[k];
        ++m->count;
    }
    for (size_t i = 0; i < count; ++i) {
        const mean *m = &means[w->spare[i]];
        float *color = w->vertices[i].color, distance = 0;
        for (int k = 0; k < 4; ++k)
            distance = fmaxf(distance, fabsf(color[k] - m->color[k] / m->count));
        for (int k = 0; k < 4 && distance < far; ++k) color[k] = m->color[k] / m->count;
    }
    free(means);
    return PSPLAT_OK;
}

/* Makes one vertex of equal corners. */
static void weld_corners(work *w) {
    size_t count = w->vertex_count, size = sizeof *w->vertices;
    w->vertex_count = meshopt_generateVertexRemap(w->spare, NULL, count, w->vertices, count, size);
    meshopt_remapIndexBuffer(w->indices, NULL, count, w->spare);
    meshopt_remapVertexBuffer(w->vertices, w->vertices, count, size, w->spare);
}

/* ---- triangles ------------------------------------------------------------------------------- */

/* The simplifier's errors are relative to the largest side of the box. It ends before nothing can
 * be left out any more: what one run leaves another goes on with. What would vanish altogether
 * stays. */
static void simplify(work *w, double tolerance) {
    enum { MOST_RUNS = 4 };
    const float *positions = w->vertices[0].position;
    size_t size = sizeof *w->vertices, before = SIZE_MAX;
    float scale = meshopt_simplifyScale(positions, w->vertex_count, size);
    float error = scale > 0 ? (float)(tolerance / (double)scale) : 0;
    for (int i = 0; i < MOST_RUNS && w->index_count < before; ++i) {
        uint32_t *all = w->indices;
        before = w->index_count;
        size_t left = meshopt_simplify(w->spare, all, before, positions, w->vertex_count, size, 3,
                                       error, 0, NULL);
        if (!left) break;
        w->index_count = left;
        w->indices = w->spare;
        w->spare = all;
    }
}

static uint32_t group_of(const work *w, size_t triangle) {
    return w->vertices[w->indices[3 * triangle]].group;
}

static uint32_t greatest_group(const work *w) {
    uint32_t greatest = 0;
    for (size_t t = 0; t < w->index_count / 3; ++t)
        if (group_of(w, t) > greatest) greatest = group_of(w, t);
    return greatest;
}

/* Triangles of a group one after another, in spare; counts and firsts by group. */
static void sort_groups(work *w, size_t *firsts, size_t group_count) {
    for (size_t t = 0; t < w->index_count / 3; ++t) firsts[group_of(w, t) + 1] += 3;
    for (size_t g = 0; g < group_count; ++g) firsts[g + 1] += firsts[g];
    for (size_t t = 0; t < w->index_count / 3; ++t) {
        size_t *end = &firsts[group_of(w, t)];
        memcpy(w->spare + *end, w->indices + 3 * t, 3 * sizeof *w->indices);
        *end += 3;
    }
}

/* Adds area times what varies of the look in a triangle's middle. */
static double add_look(const work *w, uint32_t triangle, double finish[2], double emissive[3]) {
    static const double middle[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    double area = w->conversion.surface.face_areas[triangle];
    psplat_shade shade;
    psplat_paint_shade(&w->conversion.paint, triangle, middle,
                       w->conversion.surface.corner_normals + 9 * (size_t)triangle, &shade);
    for (int k = 0; k < 2; ++k) finish[k] += area * (double)shade.finish[k + 1];
    for (int k = 0; k < 3; ++k) emissive[k] += area * (double)shade.emissive[k];
    return area;
}

/* Triangles of viewers have one roughness, one metalness and one emission for all of a material:
 * the mean over the source. */
static psplat_material material_of(const work *w, uint32_t group) {
    const psplat_mesh *mesh = w->mesh;
    psplat_material m = mesh->appearances ? mesh->appearances[group].material : mesh->material;
    double finish[2] = {0, 0}, emissive[3] = {0, 0, 0}, area = 0;
    if (!w->conversion.paint.has_finish && !w->conversion.paint.has_emissive) return m;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        if (!mesh->groups || !mesh->appearances || mesh->groups[t] == group)
            area += add_look(w, t, finish, emissive);
    if (!(area > 0)) return m;
    m.roughness *= (float)(finish[0] / area);
    m.metallic *= (float)(finish[1] / area);
    for (int k = 0; k < 3; ++k) m.emissive[k] *= (float)(emissive[k] / area);
    return m;
}

static void add_part(work *w, psplat_stand_in *stand_in, uint32_t group, size_t first, size_t end) {
    if (end == first) return;
    stand_in->parts[stand_in->part_count++] = (psplat_stand_in_part){
        .group = group, .first = first, .count = end - first, .material = material_of(w, group)};
    meshopt_optimizeVertexCache(w->indices + first, w->spare + first, end - first, w->vertex_count);
}

static psplat_result divide(work *w, psplat_stand_in *stand_in, psplat_error *error) {
    size_t group_count = (size_t)greatest_group(w) + 1, first = 0;
    size_t *ends = calloc(group_count + 1, sizeof *ends);
    stand_in->parts = calloc(group_count, sizeof *stand_in->parts);
    if (!ends || !stand_in->parts) {
        free(ends);
        return fail_memory(w->mesh, error);
    }
    sort_groups(w, ends, group_count);
    for (size_t g = 0; g < group_count; ++g) {
        add_part(w, stand_in, (uint32_t)g, first, ends[g]);
        first = ends[g];
    }
    free(ends);
    return PSPLAT_OK;
}

/* Drops the vertices that no triangle has, and hands the rest over. */
static void adopt(work *w, psplat_stand_in *stand_in) {
    stand_in->vertex_count = meshopt_optimizeVertexFetch(
        w->vertices, w->indices, w->index_count, w->vertices, w->vertex_count, sizeof *w->vertices);
    stand_in->index_count = w->index_count;
    stand_in->vertices = w->vertices;
    stand_in->indices = w->indices;
    stand_in->has_color = w->conversion.paint.has_color;
    memcpy(stand_in->origin, w->mesh->origin, sizeof stand_in->origin);
    w->vertices = NULL;
    w->indices = NULL;
}

static psplat_result make(work *w, psplat_stand_in *stand_in, psplat_error *error) {
    psplat_result result = psplat_conversion_begin(&w->conversion, w->mesh, error);
    if (!result) result = fill_corners(w, error);
    if (!result && w->conversion.paint.has_color) result = join_colors(w, error);
    if (result) return result;
    weld_corners(w);
    simplify(w, w->conversion.tolerance);
    result = divide(w, stand_in, error);
    if (!result) adopt(w, stand_in);
    return result;
}

psplat_result psplat_stand_in_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                   psplat_stand_in *stand_in, psplat_error *error) {
    work w = {.mesh = mesh, .conversion = {.desc = desc}};
    *stand_in = (psplat_stand_in){0};
    psplat_result result = make(&w, stand_in, error);
    psplat_conversion_free(&w.conversion);
    free(w.vertices);
    free(w.indices);
    free(w.spare);
    if (result) psplat_stand_in_free(stand_in);
    return result;
}

void psplat_stand_in_free(psplat_stand_in *stand_in) {
    free(stand_in->vertices);
    free(stand_in->indices);
    free(stand_in->parts);
    *stand_in = (psplat_stand_in){0};
}
