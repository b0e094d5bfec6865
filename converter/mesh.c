/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh.c - from a file of any supported format to a clean mesh: checked, welded, without flat
 * triangles, centred at the origin of its own coordinates.
 */
#include "source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Formats without materials get a light grey with a soft highlight; coloured ones their colours. */
#define DEFAULT_GREY 0.8f
#define DEFAULT_ROUGHNESS 0.5f

size_t psplat_mesh_corners(const psplat_mesh *mesh, psplat_corners arrays[PSPLAT_CORNER_ARRAYS]) {
    const psplat_corners all[PSPLAT_CORNER_ARRAYS] = {
        {mesh->corner_normals, 3}, {mesh->corner_colors, 4}, {mesh->corner_tangents, 4},
        {mesh->corner_uvs[0], 2},  {mesh->corner_uvs[1], 2},
    };
    size_t count = 0;
    for (size_t i = 0; i < PSPLAT_CORNER_ARRAYS; ++i)
        if (all[i].values) arrays[count++] = all[i];
    return count;
}

/* Room for the corners of all triangles; NULL where it is not wanted or, counted in failed, where
 * there is none. */
static float *allocate_corners(const psplat_mesh *mesh, unsigned wanted, size_t components,
                               int *failed) {
    if (!wanted) return NULL;
    float *values = calloc(mesh->triangle_count + 1, 3 * components * sizeof *values);
    if (!values) ++*failed;
    return values;
}

psplat_result psplat_mesh_allocate(psplat_mesh *mesh, size_t vertex_count, size_t triangle_count,
                                   unsigned parts, psplat_error *error) {
    int failed = 0;
    *mesh = (psplat_mesh){.vertex_count = vertex_count, .triangle_count = triangle_count};
    if (vertex_count > PSPLAT_MAX_VERTICES || triangle_count > PSPLAT_MAX_TRIANGLES)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%zu vertices and %zu triangles; at most %u and %u are read",
                           vertex_count, triangle_count, PSPLAT_MAX_VERTICES, PSPLAT_MAX_TRIANGLES);
    mesh->positions = calloc(vertex_count + 1, 3 * sizeof(double));
    mesh->triangles = calloc(triangle_count + 1, 3 * sizeof(uint32_t));
    if (parts & PSPLAT_MESH_GROUPS) mesh->groups = calloc(triangle_count + 1, sizeof(uint32_t));
    mesh->corner_normals = allocate_corners(mesh, parts & PSPLAT_MESH_NORMALS, 3, &failed);
    mesh->corner_colors = allocate_corners(mesh, parts & PSPLAT_MESH_COLORS, 4, &failed);
    mesh->corner_tangents = allocate_corners(mesh, parts & PSPLAT_MESH_TANGENTS, 4, &failed);
    for (unsigned i = 0; i < PSPLAT_TEXCOORDS; ++i)
        mesh->corner_uvs[i] = allocate_corners(mesh, parts & PSPLAT_MESH_UVS << i, 2, &failed);
    if (mesh->positions && mesh->triangles && (!(parts & PSPLAT_MESH_GROUPS) || mesh->groups) &&
        !failed)
        return PSPLAT_OK;
    psplat_mesh_free(mesh);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu triangles",
                       triangle_count);
}

void psplat_mesh_free(psplat_mesh *mesh) {
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    if (!mesh) return;
    size_t count = psplat_mesh_corners(mesh, arrays);
    for (size_t i = 0; i < count; ++i) free(arrays[i].values);
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->groups);
    free(mesh->points);
    free(mesh->point_triangles);
    psplat_palette_free(mesh->palette);
    free(mesh->palette);
    *mesh = (psplat_mesh){0};
}

static psplat_result check(psplat_source *source, psplat_error *error) {
    switch (source->format) {
    case PSPLAT_SOURCE_OBJ:
        return psplat_check_obj(source, error);
    case PSPLAT_SOURCE_OFF:
        return psplat_check_off(source, error);
    case PSPLAT_SOURCE_PLY:
        return psplat_check_ply(source, error);
    case PSPLAT_SOURCE_STL_TEXT:
    case PSPLAT_SOURCE_STL_BINARY:
        return psplat_check_stl(source, error);
    default:
        return PSPLAT_OK; /* the glTF reader checks as it reads */
    }
}

int psplat_source_is_gltf(const psplat_source *source) {
    return source->format == PSPLAT_SOURCE_GLTF || source->format == PSPLAT_SOURCE_GLB;
}

/* The last line of defence behind the adapters: nothing after this checks an index again. */
static psplat_result check_raw(const psplat_mesh *mesh, const char *label, psplat_error *error) {
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
        uint32_t vertex = mesh->triangles[i];
        if (vertex >= mesh->vertex_count)
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                               "%s: triangle %zu: vertex %u of %zu does not exist", label, i / 3,
                               vertex, mesh->vertex_count);
        const double *p = mesh->positions + (size_t)vertex * 3;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                               "%s: vertex %u: a coordinate is not finite", label, vertex);
    }
    return PSPLAT_OK;
}

/* By the box of the vertices in use. */
static void recentre(psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i)
        for (size_t axis = 0; axis < 3; ++axis) {
            double value = mesh->positions[(size_t)mesh->triangles[i] * 3 + axis];
            low[axis] = fmin(low[axis], value);
            high[axis] = fmax(high[axis], value);
        }
    if (mesh->triangle_count == 0) return;
    for (size_t axis = 0; axis < 3; ++axis) {
        double centre = low[axis] / 2 + high[axis] / 2;
        mesh->origin[axis] += centre;
        for (size_t v = 0; v < mesh->vertex_count; ++v) mesh->positions[v * 3 + axis] -= centre;
    }
}

/* A normal of no length or no number is not an opinion: it becomes 0 0 0. */
static void normalise_normals(psplat_mesh *mesh) {
    for (size_t corner = 0; mesh->corner_normals && corner < mesh->triangle_count * 3; ++corner) {
        float *normal = mesh->corner_normals + corner * 3;
        double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        int usable = isfinite(length) && length > 0;
        for (int k = 0; k < 3; ++k) normal[k] = usable ? (float)(n[k] / length) : 0.0f;
    }
}

/* One colour on every corner is not worth a colour per splat: it joins the base colour, where that
 * is this mesh's own. */
static void fold_uniform_color(psplat_mesh *mesh) {
    float *colors = mesh->corner_colors;
    if (!colors || mesh->appearances) return;
    for (size_t corner = 1; corner < mesh->triangle_count * 3; ++corner)
        if (memcmp(colors, colors + corner * 4, 4 * sizeof(float)) != 0) return;
    for (int k = 0; k < 4; ++k) mesh->material.base_color[k] *= colors[k];
    free(colors);
    mesh->corner_colors = NULL;
}

static void default_material(psplat_mesh *mesh, int closed) {
    float grey = mesh->corner_colors ? 1.0f : DEFAULT_GREY;
    mesh->material = (psplat_material){.base_color = {grey, grey, grey, 1.0f},
                                       .roughness = DEFAULT_ROUGHNESS,
                                       .double_sided = !closed};
    for (size_t i = 0; mesh->palette && i < mesh->palette->appearance_count; ++i)
        mesh->palette->appearances[i].material.double_sided = !closed;
}

/* The first appearance that looks like this one. */
static uint32_t first_like(const psplat_palette *palette, uint32_t index) {
    psplat_appearance own = palette->appearances[index];
    own.name = NULL;
    for (uint32_t i = 0; i < index; ++i) {
        psplat_appearance other = palette->appearances[i];
        other.name = NULL;
        if (memcmp(&own, &other, sizeof own) == 0) return i;
    }
    return index;
}

/* Materials that look alike are one group: between them there is no edge to be seen. */
static psplat_result unite_groups(psplat_mesh *mesh) {
    size_t count = mesh->palette->appearance_count;
    uint32_t *first = malloc((count + 1) * sizeof *first);
    if (!first) return PSPLAT_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; ++i) first[i] = first_like(mesh->palette, i);
    for (size_t t = 0; t < mesh->triangle_count; ++t) mesh->groups[t] = first[mesh->groups[t]];
    free(first);
    return PSPLAT_OK;
}

/* The materials of an OBJ. */
static psplat_result read_library(const psplat_source *source, psplat_mesh *mesh,
                                  psplat_error *error) {
    float grey = mesh->corner_colors ? 1.0f : DEFAULT_GREY;
    const psplat_material base = {.base_color = {grey, grey, grey, 1.0f},
                                  .roughness = DEFAULT_ROUGHNESS};
    if (!mesh->groups) return PSPLAT_OK;
    mesh->palette = calloc(1, sizeof *mesh->palette);
    if (!mesh->palette)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    psplat_result result = psplat_mtl_read(source, &base, mesh->palette, error);
    mesh->appearances = mesh->palette->appearances;
    mesh->appearance_count = mesh->palette->appearance_count;
    if (!result && unite_groups(mesh))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    return result;
}

/* Drops what has no area and the vertices of all that was dropped. Recentring may round vertices
 * onto each other, so that welding has more to drop. */
static psplat_result settle(psplat_mesh *mesh, psplat_error *error) {
    psplat_result result;
    size_t dropped;
    do {
        psplat_mesh_drop_flat(mesh);
        recentre(mesh);
        dropped = mesh->dropped;
        result = psplat_mesh_weld(mesh, error);
    } while (!result && mesh->dropped > dropped);
    return result;
}

psplat_result psplat_mesh_clean(psplat_mesh *mesh, const char *label, int has_material,
                                psplat_error *error) {
    int closed = 0, consistent = 0, turned = 0;
    psplat_result result = check_raw(mesh, label, error);
    normalise_normals(mesh);
    if (!result) result = psplat_mesh_weld(mesh, error);
    if (!result) result = psplat_mesh_drop_repeated(mesh, &turned, error);
    /* Closed or not is asked before flat triangles go: they may be all that closes a T-junction. */
    if (!result) result = psplat_mesh_close_seams(mesh, &closed, error);
    if (!result) result = psplat_mesh_orient(mesh, &consistent, error);
    if (!result) result = settle(mesh, error);
    if (result) return result;
    if (mesh->triangle_count == 0)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: no triangle has an area", label);
    if (!has_material) default_material(mesh, closed && consistent && !turned);
    mesh->both_sides = turned;
    mesh->material.double_sided |= turned;
    fold_uniform_color(mesh);
    return PSPLAT_OK;
}

static psplat_result read_points(psplat_source *source, psplat_mesh *mesh, psplat_error *error) {
    psplat_points points = {0};
    psplat_error cause = {0};
    psplat_result result = source->format == PSPLAT_SOURCE_XYZ
                               ? psplat_points_read_xyz(source, &points, error)
                               : psplat_points_read_openmesh(source, &points, error);
    psplat_source_free(source); /* before the points take memory for their neighbours */
    if (!result) {
        result = psplat_mesh_from_points(&points, mesh, &cause);
        if (result) psplat_fail(error, result, cause.offset, "%s: %s", source->path, cause.text);
    }
    psplat_points_free(&points);
    if (result) return result;
    default_material(mesh, !mesh->material.double_sided);
    fold_uniform_color(mesh);
    return PSPLAT_OK;
}

psplat_result psplat_mesh_from_source(psplat_source *source, psplat_mesh *mesh,
                                      psplat_error *error) {
    psplat_result result = check(source, error);
    if (!result && source->is_point_set) return read_points(source, mesh, error);
    int gltf = psplat_source_is_gltf(source);
    if (!result)
        result = gltf ? psplat_mesh_read_gltf(source, mesh, error)
                      : psplat_mesh_read_openmesh(source, mesh, error);
    if (!result && !gltf) result = read_library(source, mesh, error);
    return result ? result : psplat_mesh_clean(mesh, source->path, gltf, error);
}

psplat_result psplat_mesh_read(const char *path, psplat_mesh *mesh, psplat_error *error) {
    if (!path || !mesh)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "psplat_mesh_read: path or mesh is NULL");
    *mesh = (psplat_mesh){0};
    psplat_source source;
    psplat_result result = psplat_source_load(path, &source, error);
    if (result) return result;
    result = psplat_mesh_from_source(&source, mesh, error);
    if (result) psplat_mesh_free(mesh);
    psplat_source_free(&source);
    return result;
}
