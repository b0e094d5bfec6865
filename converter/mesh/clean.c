/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clean.c - mesh cleaning: checked, welded, oriented, without degenerate triangles, and centred.
 *
 * The positions become relative to the middle of the bounding box, so that sums of them keep their
 * precision far from the origin of the file.
 */
#include "mesh/clean.h"

#include "mesh/mesh.h"
#include "mesh/orientation.h"
#include "mesh/shells.h"
#include "mesh/stitch_borders.h"
#include "mesh/weld.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Refuses indices without a vertex and coordinates that are not finite, whatever the adapters let
 * through. Nothing after this checks them again. */
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

/* Moves the origin to the middle of the bounding box of the vertices in use. */
static void center(psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i)
        for (size_t axis = 0; axis < 3; ++axis) {
            double value = mesh->positions[(size_t)mesh->triangles[i] * 3 + axis];
            if (value < low[axis]) low[axis] = value;
            if (value > high[axis]) high[axis] = value;
        }
    if (mesh->triangle_count == 0) return;
    for (size_t axis = 0; axis < 3; ++axis) {
        double centre = low[axis] / 2 + high[axis] / 2;
        mesh->origin[axis] += centre;
        for (size_t v = 0; v < mesh->vertex_count; ++v) mesh->positions[v * 3 + axis] -= centre;
    }
}

/* Makes the normals of corners unit length. A normal that is zero or not finite becomes 0 0 0,
 * which stands for no normal. */
static void normalise_normals(psplat_mesh *mesh) {
    for (size_t corner = 0; mesh->corner_normals && corner < mesh->triangle_count * 3; ++corner) {
        float *normal = mesh->corner_normals + corner * 3;
        double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        int usable = isfinite(length) && length > 0;
        for (int k = 0; k < 3; ++k) normal[k] = usable ? (float)(n[k] / length) : 0.0f;
    }
}

void psplat_mesh_hoist_uniform_color(psplat_mesh *mesh) {
    float *colors = mesh->corner_colors;
    if (!colors || mesh->source_materials) return;
    for (size_t corner = 1; corner < mesh->triangle_count * 3; ++corner)
        if (memcmp(colors, colors + corner * 4, 4 * sizeof(float)) != 0) return;
    for (int k = 0; k < 4; ++k) mesh->material.base_color[k] *= colors[k];
    free(colors);
    mesh->corner_colors = NULL;
}

psplat_material psplat_mesh_usual_material(const psplat_mesh *mesh) {
    float grey = mesh->corner_colors ? 1.0f : 0.8f;
    return (psplat_material){.base_color = {grey, grey, grey, 1.0f}, .roughness = 0.5f};
}

void psplat_mesh_set_usual_material(psplat_mesh *mesh, int closed) {
    mesh->material = psplat_mesh_usual_material(mesh);
    mesh->material.double_sided = !closed;
    for (size_t i = 0; mesh->materials && i < mesh->materials->source_material_count; ++i)
        mesh->materials->source_materials[i].material.double_sided = !closed;
}

/* Drops triangles without area and vertices that are no longer in use, and centres the mesh.
 * Centring may round vertices onto each other, so that welding drops more triangles; it is repeated
 * until nothing is dropped. */
static psplat_result drop_flat_and_center(psplat_mesh *mesh, psplat_error *error) {
    psplat_result result;
    size_t dropped;
    do {
        psplat_mesh_drop_flat(mesh);
        center(mesh);
        dropped = mesh->dropped;
        result = psplat_mesh_weld(mesh, error);
    } while (!result && mesh->dropped > dropped);
    return result;
}

psplat_result psplat_mesh_clean(psplat_mesh *mesh, const char *label, int has_material,
                                psplat_error *error) {
    int closed = 0, consistent = 0, turned = 0, two_sides = 0;
    psplat_result result = check_raw(mesh, label, error);
    normalise_normals(mesh);
    if (!result) result = psplat_mesh_weld(mesh, error);
    if (!result) result = psplat_mesh_drop_repeated(mesh, has_material, &turned, &two_sides, error);
    /* Whether the mesh is closed is found before flat triangles are dropped, since a flat triangle
     * may be all that closes a T-junction. */
    if (!result) result = psplat_mesh_stitch_borders(mesh, &closed, error);
    if (!result) result = psplat_mesh_orient(mesh, &consistent, error);
    if (!result) result = psplat_mesh_turn_shells(mesh, error);
    if (!result) result = drop_flat_and_center(mesh, error);
    if (result) return result;
    if (mesh->triangle_count == 0)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: no triangle has an area", label);
    /* Who writes both sides of a sheet wants each to be seen from its own. */
    if (!has_material)
        psplat_mesh_set_usual_material(mesh, two_sides || (closed && consistent && !turned));
    mesh->material.double_sided |= turned;
    psplat_mesh_hoist_uniform_color(mesh);
    return PSPLAT_OK;
}
