/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fallback_mesh.c - the fallback mesh of a conversion, simplified by libmeshoptimizer.
 *
 * Corners that differ in normal, colour, texture coordinates or group become separate vertices. The
 * simplifier collapses edges only where all vertices at one position go the same way, so creases
 * and the borders of materials stay where they are.
 */
#include "export/fallback_mesh.h"

#include "appearance/appearance.h"
#include "mesh/mesh.h"
#include "select/conversion.h"

#include <meshoptimizer.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The mesh that is being simplified. */
typedef struct work {
    const psplat_mesh *mesh;
    psplat_conversion conversion; /* as psplat_conversion_begin leaves it */
    psplat_fallback_vertex *vertices;
    uint32_t *indices, *spare; /* spare is scratch memory of the same size */
    size_t vertex_count, index_count;
    int is_whole; /* 1: nothing is simplified */
} work;

/* ---- corners --------------------------------------------------------------------------------- */

static void fill_color(const work *w, size_t triangle, size_t corner, const float normal[3],
                       float color[4]) {
    double barycentric[3] = {0, 0, 0};
    psplat_baked_point shade;
    barycentric[corner] = 1;
    psplat_appearance_bake(&w->conversion.appearance, (uint32_t)triangle, barycentric, normal,
                           &shade);
    memcpy(color, shade.color, sizeof shade.color);
}

static void fill_corner(const work *w, size_t triangle, size_t corner,
                        psplat_fallback_vertex *vertex) {
    size_t index = 3 * triangle + corner;
    const double *position = w->mesh->positions + 3 * (size_t)w->mesh->triangles[index];
    *vertex = (psplat_fallback_vertex){.color = {1, 1, 1, 1}};
    for (size_t k = 0; k < 3; ++k) vertex->position[k] = (float)position[k];
    memcpy(vertex->normal, w->conversion.surface.corner_normals + 3 * index, sizeof vertex->normal);
    if (w->mesh->source_materials && w->mesh->groups) vertex->group = w->mesh->groups[triangle];
    if (psplat_appearance_kept(&w->conversion.appearance, (uint32_t)triangle))
        memcpy(vertex->texcoord, w->mesh->corner_uvs[w->conversion.appearance.kept_set] + 2 * index,
               sizeof vertex->texcoord);
    if (w->conversion.appearance.has_color)
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
    float color[4], count; /* sum of colours and their number */
} mean;

/* The colour of a corner is a mean over its triangle's surroundings, so the corners of a vertex
 * differ a little. They get their common mean if they are within merge_difference of it: otherwise
 * each of them would be a vertex of its own, and no edge could be collapsed. */
static psplat_result join_colors(work *w, psplat_error *error) {
    static const float merge_difference = 0.1f; /* of a linear colour component in 0 ... 1 */
    size_t count = w->vertex_count;
    const struct meshopt_Stream streams[] = {
        {w->vertices[0].position, offsetof(psplat_fallback_vertex, color), sizeof *w->vertices},
        {&w->vertices[0].group, sizeof w->vertices[0].group + sizeof w->vertices[0].texcoord,
         sizeof *w->vertices}};
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
        for (int k = 0; k < 4 && distance < merge_difference; ++k)
            color[k] = m->color[k] / m->count;
    }
    free(means);
    return PSPLAT_OK;
}

/* Merges equal corners into one vertex. */
static void weld_corners(work *w) {
    size_t count = w->vertex_count, size = sizeof *w->vertices;
    w->vertex_count = meshopt_generateVertexRemap(w->spare, NULL, count, w->vertices, count, size);
    meshopt_remapIndexBuffer(w->indices, NULL, count, w->spare);
    meshopt_remapVertexBuffer(w->vertices, w->vertices, count, size, w->spare);
}

/* ---- triangles ------------------------------------------------------------------------------- */

/* Collapses edges while the error stays below tolerance, a length. The simplifier takes errors
 * relative to the largest side of the bounding box, and one run may stop early, so it runs again
 * until nothing changes. A mesh that would vanish altogether is kept as it is. */
static void simplify(work *w, double tolerance) {
    enum { MAX_RUNS = 4 };
    const float *positions = w->vertices[0].position;
    size_t size = sizeof *w->vertices, before = SIZE_MAX;
    float scale = meshopt_simplifyScale(positions, w->vertex_count, size);
    float error = scale > 0 ? (float)(tolerance / (double)scale) : 0;
    for (int i = 0; i < MAX_RUNS && w->index_count < before; ++i) {
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

/* Copies the triangles into spare, sorted by group (counting sort). firsts, with group_count + 1
 * zeros, holds afterwards where the triangles of each group end. */
static void sort_groups(work *w, size_t *firsts, size_t group_count) {
    for (size_t t = 0; t < w->index_count / 3; ++t) firsts[group_of(w, t) + 1] += 3;
    for (size_t g = 0; g < group_count; ++g) firsts[g + 1] += firsts[g];
    for (size_t t = 0; t < w->index_count / 3; ++t) {
        size_t *end = &firsts[group_of(w, t)];
        memcpy(w->spare + *end, w->indices + 3 * t, 3 * sizeof *w->indices);
        *end += 3;
    }
}

/* Adds a triangle's area times roughness, metalness and emission at its centroid, as fractions of
 * the material's factors. Returns the area. */
static double add_material_sample(const work *w, uint32_t triangle, double finish[2],
                                  double emissive[3]) {
    static const double middle[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    double area = w->conversion.surface.face_areas[triangle];
    psplat_baked_point shade;
    psplat_appearance_bake(&w->conversion.appearance, triangle, middle,
                           w->conversion.surface.corner_normals + 9 * (size_t)triangle, &shade);
    for (int k = 0; k < 2; ++k) finish[k] += area * (double)shade.finish[k + 1];
    for (int k = 0; k < 3; ++k) emissive[k] += area * (double)shade.emissive[k];
    return area;
}

/* Returns the material of a group, with the textures that it keeps. Roughness, metalness and
 * emission are multiplied by the area-weighted means over the source of those that are baked. */
static psplat_material material_of(const work *w, uint32_t group) {
    const psplat_mesh *mesh = w->mesh;
    psplat_material m =
        mesh->source_materials ? mesh->source_materials[group].material : mesh->material;
    m.double_sided |= psplat_mesh_shows_both_sides(mesh, group);
    psplat_appearance_settle_textures(&w->conversion.appearance, group, &m);
    double finish[2] = {0, 0}, emissive[3] = {0, 0, 0}, area = 0;
    if (!w->conversion.appearance.has_finish && !w->conversion.appearance.has_emissive) return m;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        if (!mesh->groups || !mesh->source_materials || mesh->groups[t] == group)
            area += add_material_sample(w, t, finish, emissive);
    if (!(area > 0)) return m;
    m.roughness *= (float)(finish[0] / area);
    m.metallic *= (float)(finish[1] / area);
    for (int k = 0; k < 3; ++k) m.emissive[k] *= (float)(emissive[k] / area);
    return m;
}

static void add_primitive(work *w, psplat_fallback_mesh *fallback, uint32_t group, size_t first,
                          size_t end) {
    if (end == first) return;
    psplat_fallback_primitive *primitive = &fallback->primitives[fallback->primitive_count++];
    *primitive = (psplat_fallback_primitive){
        .group = group, .first = first, .count = end - first, .material = material_of(w, group)};
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        primitive->has_texcoord |= primitive->material.textures[slot].image != 0;
    fallback->has_texcoord |= primitive->has_texcoord;
    meshopt_optimizeVertexCache(w->indices + first, w->spare + first, end - first, w->vertex_count);
}

static psplat_result split_by_group(work *w, psplat_fallback_mesh *fallback, psplat_error *error) {
    size_t group_count = (size_t)greatest_group(w) + 1, first = 0;
    size_t *ends = calloc(group_count + 1, sizeof *ends);
    fallback->primitives = calloc(group_count, sizeof *fallback->primitives);
    if (!ends || !fallback->primitives) {
        free(ends);
        return fail_memory(w->mesh, error);
    }
    sort_groups(w, ends, group_count);
    for (size_t g = 0; g < group_count; ++g) {
        add_primitive(w, fallback, (uint32_t)g, first, ends[g]);
        first = ends[g];
    }
    free(ends);
    return PSPLAT_OK;
}

/* Drops the vertices that no triangle uses and moves the arrays into *fallback. */
static void hand_over(work *w, psplat_fallback_mesh *fallback) {
    fallback->vertex_count = meshopt_optimizeVertexFetch(
        w->vertices, w->indices, w->index_count, w->vertices, w->vertex_count, sizeof *w->vertices);
    fallback->index_count = w->index_count;
    fallback->vertices = w->vertices;
    fallback->indices = w->indices;
    fallback->has_color = w->conversion.appearance.has_color;
    memcpy(fallback->origin, w->mesh->origin, sizeof fallback->origin);
    w->vertices = NULL;
    w->indices = NULL;
}

static psplat_result make(work *w, psplat_fallback_mesh *fallback, psplat_error *error) {
    psplat_result result = psplat_conversion_begin(&w->conversion, w->mesh, error);
    w->mesh = w->conversion.surface.mesh; /* without what masks hide */
    if (!result) result = fill_corners(w, error);
    if (!result && w->conversion.appearance.has_color) result = join_colors(w, error);
    if (result) return result;
    weld_corners(w);
    if (!w->is_whole) simplify(w, w->conversion.tolerance);
    result = split_by_group(w, fallback, error);
    if (!result) hand_over(w, fallback);
    return result;
}

/* Makes the mesh and frees what it took. */
static psplat_result finish(work *w, psplat_fallback_mesh *fallback, psplat_error *error) {
    *fallback = (psplat_fallback_mesh){0};
    psplat_result result = make(w, fallback, error);
    psplat_conversion_free(&w->conversion);
    free(w->vertices);
    free(w->indices);
    free(w->spare);
    if (result) psplat_fallback_mesh_free(fallback);
    return result;
}

psplat_result psplat_fallback_mesh_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                        psplat_fallback_mesh *fallback, psplat_error *error) {
    work w = {.mesh = mesh, .conversion = {.desc = desc}};
    return finish(&w, fallback, error);
}

psplat_result psplat_whole_mesh_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                     psplat_fallback_mesh *whole, psplat_error *error) {
    work w = {.mesh = mesh, .conversion = {.desc = desc}, .is_whole = 1};
    return finish(&w, whole, error);
}

void psplat_fallback_mesh_free(psplat_fallback_mesh *fallback) {
    free(fallback->vertices);
    free(fallback->indices);
    free(fallback->primitives);
    *fallback = (psplat_fallback_mesh){0};
}
