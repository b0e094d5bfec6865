/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * read_mesh.c - the mesh import: a file of any supported format as one clean mesh. It is checked,
 * read by its format's reader, given materials or reconstructed from points, and cleaned
 * (mesh/clean.h).
 */
#include "import/read_mesh.h"

#include "gltf/read_gltf.h"
#include "import/check.h"
#include "import/mtl.h"
#include "import/obj_mesh.h"
#include "import/obj_points.h"
#include "import/openmesh.h"
#include "import/xyz.h"
#include "material/source_materials.h"
#include "mesh/clean.h"
#include "mesh/mesh.h"
#include "points/points.h"
#include "source/source_file.h"

#include <stdlib.h>
#include <string.h>

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

/* Returns the first material that differs from this one in its name at most. */
static uint32_t first_equal_material(const psplat_source_materials *materials, uint32_t index) {
    psplat_source_material own = materials->source_materials[index];
    own.name = NULL;
    for (uint32_t i = 0; i < index; ++i) {
        psplat_source_material other = materials->source_materials[i];
        other.name = NULL;
        if (memcmp(&own, &other, sizeof own) == 0) return i;
    }
    return index;
}

/* Makes one group of materials that look alike, since no edge is visible between them. */
static psplat_result unite_groups(psplat_mesh *mesh) {
    size_t count = mesh->materials->source_material_count;
    uint32_t *first = malloc((count + 1) * sizeof *first);
    if (!first) return PSPLAT_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; ++i) first[i] = first_equal_material(mesh->materials, i);
    for (size_t t = 0; t < mesh->triangle_count; ++t) mesh->groups[t] = first[mesh->groups[t]];
    free(first);
    return PSPLAT_OK;
}

/* Reads the materials of an OBJ, which is the only format here that has groups. */
static psplat_result read_library(const psplat_source *source, psplat_mesh *mesh,
                                  psplat_error *error) {
    const psplat_material base = psplat_mesh_usual_material(mesh);
    if (!mesh->groups) return PSPLAT_OK;
    mesh->materials = calloc(1, sizeof *mesh->materials);
    if (!mesh->materials)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    psplat_result result = psplat_mtl_read(source, &base, mesh->materials, error);
    mesh->source_materials = mesh->materials->source_materials;
    mesh->source_material_count = mesh->materials->source_material_count;
    if (!result && unite_groups(mesh))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    return result;
}

static psplat_result read_point_format(psplat_source *source, psplat_points *points,
                                       psplat_error *error) {
    switch (source->format) {
    case PSPLAT_SOURCE_XYZ:
        return psplat_points_read_xyz(source, points, error);
    case PSPLAT_SOURCE_OBJ:
        return psplat_points_read_obj(source, points, error);
    default:
        return psplat_points_read_openmesh(source, points, error);
    }
}

static psplat_result read_points(psplat_source *source, psplat_mesh *mesh, psplat_error *error) {
    psplat_points points = {0};
    psplat_error cause = {0};
    psplat_result result = read_point_format(source, &points, error);
    psplat_source_free(source); /* its memory is needed for the surface reconstruction */
    if (!result) {
        result = psplat_mesh_from_points(&points, mesh, &cause);
        if (result) psplat_fail(error, result, cause.offset, "%s: %s", source->path, cause.text);
    }
    psplat_points_free(&points);
    if (result) return result;
    psplat_mesh_set_usual_material(mesh, !mesh->material.double_sided);
    psplat_mesh_hoist_uniform_color(mesh);
    return PSPLAT_OK;
}

static psplat_result read_triangles(psplat_source *source, psplat_mesh *mesh, psplat_error *error) {
    if (psplat_source_is_gltf(source)) return psplat_mesh_read_gltf(source, mesh, error);
    int is_plain_obj = source->format == PSPLAT_SOURCE_OBJ && !source->has_colors;
    psplat_result result = is_plain_obj ? psplat_mesh_read_obj(source, mesh, error)
                                        : psplat_mesh_read_openmesh(source, mesh, error);
    if (!result) result = read_library(source, mesh, error);
    psplat_source_free(source); /* its memory is needed for cleaning */
    return result;
}

psplat_result psplat_mesh_from_source(psplat_source *source, psplat_mesh *mesh,
                                      psplat_error *error) {
    psplat_result result = check(source, error);
    if (!result && source->is_point_set) return read_points(source, mesh, error);
    int gltf = psplat_source_is_gltf(source);
    if (!result) result = read_triangles(source, mesh, error);
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
