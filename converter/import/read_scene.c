/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * read_scene.c - the scene import: a file of any supported format as a scene. Every mesh is
 * cleaned, a file without a node graph gets one, and warnings say what is not drawn as the file
 * asks.
 */
#define _XOPEN_SOURCE 700

#include "import/read_scene.h"

#include "base/path.h"
#include "gltf/read_gltf.h"
#include "import/read_mesh.h"
#include "material/source_materials.h"
#include "mesh/clean.h"
#include "mesh/mesh.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "source/source_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const psplat_scene_node empty_node = {.rotation = {0, 0, 0, 1},
                                             .scale = {1, 1, 1},
                                             .mesh = PSPLAT_NO_INDEX,
                                             .camera = PSPLAT_NO_INDEX,
                                             .light = PSPLAT_NO_INDEX};

/* Makes one node for each mesh, all in one scene. */
static psplat_result make_graph(psplat_scene *scene, psplat_error *error) {
    size_t count = scene->mesh_count;
    scene->nodes = calloc(count + 1, sizeof *scene->nodes);
    scene->scenes = calloc(1, sizeof *scene->scenes);
    uint32_t *roots = calloc(count + 1, sizeof *roots);
    if (!scene->nodes || !scene->scenes || !roots) {
        free(roots);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu nodes", count);
    }
    scene->is_made = 1;
    scene->node_count = count;
    scene->scene_count = 1;
    scene->default_scene = 0;
    scene->scenes[0] = (psplat_scene_view){.roots = roots, .root_count = count};
    for (uint32_t i = 0; i < count; ++i) {
        scene->nodes[i] = empty_node;
        scene->nodes[i].mesh = roots[i] = i;
        if (scene->meshes[i].name) scene->nodes[i].name = strdup(scene->meshes[i].name);
    }
    return PSPLAT_OK;
}

/* ---- shells that face inwards ---------------------------------------------------------------- */

typedef struct box {
    double low[3], high[3];
} box;

/* Returns the box of a mesh where an instance stands. */
static box box_of(const psplat_mesh *mesh, const double m[16]) {
    box b = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const double *p = mesh->positions + 3 * v;
        for (int k = 0; k < 3; ++k) {
            double at = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
            b.low[k] = fmin(b.low[k], at);
            b.high[k] = fmax(b.high[k], at);
        }
    }
    return b;
}

static int is_inside(const box *inner, const box *outer) {
    for (int k = 0; k < 3; ++k)
        if (!(inner->low[k] >= outer->low[k] && inner->high[k] <= outer->high[k])) return 0;
    return 1;
}

/* Marks meshes in whose box another mesh of the shown scene stands: they may be rooms. A graph that
 * has no instances yet marks none. */
static void mark_rooms(psplat_scene *scene) {
    psplat_instance *instances = NULL;
    size_t count = 0;
    if (scene->mesh_count < 2 || !scene->node_count ||
        psplat_scene_instances(scene, psplat_scene_shown(scene), &instances, &count, NULL))
        return;
    box *boxes = malloc((count + 1) * sizeof *boxes);
    for (size_t i = 0; i < count && boxes; ++i)
        boxes[i] = box_of(&scene->meshes[instances[i].mesh].mesh, instances[i].matrix);
    for (size_t i = 0; i < count && boxes; ++i)
        for (size_t k = 0; k < count; ++k)
            if (instances[k].mesh != instances[i].mesh && is_inside(&boxes[k], &boxes[i]))
                scene->meshes[instances[i].mesh].mesh.holds_parts = 1;
    free(boxes);
    free(instances);
}

/* Says which shells were turned, and which were not. */
static void warn_of_shells(psplat_scene *scene, size_t index) {
    const psplat_mesh *mesh = &scene->meshes[index].mesh;
    char label[PSPLAT_SHOWN_PATH + 2] = "";
    if (scene->mesh_count > 1) {
        psplat_scene_label(scene, index, label);
        strcat(label, ": ");
    }
    if (mesh->turned_shells)
        psplat_scene_warn(scene, "%s%zu closed shells faced inwards and are turned (%zu triangles)",
                          label, mesh->turned_shells, mesh->turned_triangles);
    if (mesh->kept_rooms)
        psplat_scene_warn(scene,
                          "%s%zu closed shells face inwards and hold other parts: they stay, as "
                          "rooms that are seen from inside",
                          label, mesh->kept_rooms);
}

/* Cleans every mesh. A mesh without area is emptied with a warning; it is an error if all are. */
static psplat_result clean_meshes(psplat_scene *scene, const char *path, psplat_error *error) {
    char label[PSPLAT_SHOWN_PATH], place[2 * PSPLAT_SHOWN_PATH + 2];
    size_t left = 0;
    mark_rooms(scene);
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        psplat_mesh *mesh = &scene->meshes[i].mesh;
        mesh->source_materials = scene->materials.source_materials;
        mesh->source_material_count = scene->materials.source_material_count;
        psplat_result result = PSPLAT_ERROR_NO_SPLATS;
        psplat_scene_label(scene, i, label);
        snprintf(place, sizeof place, "%s: %s", path, label);
        if (mesh->triangle_count) result = psplat_mesh_clean(mesh, place, 1, error);
        if (result && result != PSPLAT_ERROR_NO_SPLATS) return result;
        left += !result;
        if (!result) continue;
        psplat_mesh_free(mesh);
        psplat_scene_warn(scene, "%s has no triangle with an area and is dropped", label);
    }
    if (left) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: no triangle has an area", path);
}

static psplat_result read_single(psplat_source *source, const char *name, psplat_scene *scene,
                                 psplat_error *error) {
    scene->meshes = calloc(1, sizeof *scene->meshes);
    if (!scene->meshes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    scene->mesh_count = 1;
    if (name && *name) scene->meshes[0].name = strdup(name);
    psplat_mesh *mesh = &scene->meshes[0].mesh;
    psplat_result result = psplat_mesh_from_source(source, mesh, error);
    if (result || !mesh->materials) return result;
    scene->materials = *mesh->materials; /* the arrays themselves do not move */
    free(mesh->materials);
    mesh->materials = NULL;
    return PSPLAT_OK;
}

static psplat_result read_scene(psplat_source *source, const char *name, psplat_scene *scene,
                                psplat_error *error) {
    psplat_result result;
    if (psplat_source_is_gltf(source)) {
        result = psplat_scene_read_gltf(source, scene, error);
        if (!result) result = clean_meshes(scene, source->path, error);
    } else {
        result = read_single(source, name, scene, error);
    }
    if (!result && !scene->node_count && !scene->scene_count) result = make_graph(scene, error);
    return result ? result : psplat_scene_check(scene, source->path, error);
}

/* Warns of materials that are not drawn as the file asks. */
static void warn_of_materials(psplat_scene *scene) {
    const psplat_source_materials *materials = &scene->materials;
    size_t blended = 0;
    if (materials->problem) psplat_scene_warn(scene, "materials: %s", materials->problem);
    for (size_t i = 0; i < materials->image_count; ++i)
        if (materials->images[i].problem)
            psplat_scene_warn(scene, "%s; the material's factor stands alone",
                              materials->images[i].problem);
    for (size_t i = 0; i < materials->source_material_count; ++i)
        blended += materials->source_materials[i].is_blended != 0;
    if (blended)
        psplat_scene_warn(scene, "%zu materials are transparent and drawn opaque", blended);
}

psplat_result psplat_scene_read(const char *path, const char *name, psplat_scene *scene,
                                psplat_error *error) {
    if (!path || !scene)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "psplat_scene_read: path or scene is NULL");
    *scene = (psplat_scene){.default_scene = PSPLAT_NO_INDEX};
    psplat_source source;
    psplat_result result = psplat_source_load(path, &source, error);
    if (result) return result;
    result = read_scene(&source, name, scene, error);
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) warn_of_shells(scene, i);
    if (!result) warn_of_materials(scene);
    if (result) psplat_scene_free(scene);
    psplat_source_free(&source);
    return result;
}
