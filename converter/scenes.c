/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * scenes.c - all that a file holds, owned in one place: reading, warnings, freeing.
 */
#define _XOPEN_SOURCE 700

#include "source.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WARNING_SIZE = 400 };

static void free_strings(char *name, char *extras) {
    free(name);
    free(extras);
}

static void free_graph(psplat_scene *scene) {
    for (size_t i = 0; i < scene->node_count; ++i) {
        free_strings(scene->nodes[i].name, scene->nodes[i].extras);
        free(scene->nodes[i].children);
    }
    for (size_t i = 0; i < scene->camera_count; ++i)
        free_strings(scene->cameras[i].name, scene->cameras[i].extras);
    for (size_t i = 0; i < scene->light_count; ++i)
        free_strings(scene->lights[i].name, scene->lights[i].extras);
    for (size_t i = 0; i < scene->scene_count; ++i) {
        free_strings(scene->scenes[i].name, scene->scenes[i].extras);
        free(scene->scenes[i].roots);
    }
    free(scene->nodes);
    free(scene->cameras);
    free(scene->lights);
    free(scene->scenes);
}

void psplat_scene_free(psplat_scene *scene) {
    if (!scene) return;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        psplat_mesh_free(&scene->meshes[i].mesh);
        free_strings(scene->meshes[i].name, scene->meshes[i].extras);
    }
    for (size_t i = 0; i < scene->warning_count; ++i) free(scene->warnings[i]);
    free(scene->meshes);
    free(scene->warnings);
    psplat_palette_free(&scene->palette);
    free_graph(scene);
    free_strings(scene->copyright, scene->extras);
    free(scene->asset_extras);
    *scene = (psplat_scene){0};
}

void psplat_scene_warn(psplat_scene *scene, const char *format, ...) {
    char text[WARNING_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < scene->warning_count; ++i)
        if (!strcmp(scene->warnings[i], text)) return;
    char **warnings =
        realloc(scene->warnings, (scene->warning_count + 1) * sizeof *scene->warnings);
    if (!warnings) return;
    scene->warnings = warnings;
    warnings[scene->warning_count] = strdup(text);
    if (warnings[scene->warning_count]) ++scene->warning_count;
}

/* ---- a graph for files that have none ---------------------------------------------------------
 */

static const psplat_scene_node no_node = {.rotation = {0, 0, 0, 1},
                                          .scale = {1, 1, 1},
                                          .mesh = PSPLAT_NO_INDEX,
                                          .camera = PSPLAT_NO_INDEX,
                                          .light = PSPLAT_NO_INDEX};

/* One node for each mesh, all in one scene. */
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
        scene->nodes[i] = no_node;
        scene->nodes[i].mesh = roots[i] = i;
        if (scene->meshes[i].name) scene->nodes[i].name = strdup(scene->meshes[i].name);
    }
    return PSPLAT_OK;
}

/* ---- reading -----------------------------------------------------------------------------------
 */

void psplat_scene_label(const psplat_scene *scene, size_t mesh, char label[PSPLAT_SHOWN_PATH]) {
    const char *name = scene->meshes[mesh].name;
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(name ? name : "", shown);
    snprintf(label, PSPLAT_SHOWN_PATH, "mesh %zu%s%.60s%s", mesh, name ? " '" : "", shown,
             name ? "'" : "");
}

/* A mesh of no area is none, unless all are like it. */
static psplat_result clean_meshes(psplat_scene *scene, const char *path, psplat_error *error) {
    char label[PSPLAT_SHOWN_PATH], place[2 * PSPLAT_SHOWN_PATH + 2];
    size_t left = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        psplat_mesh *mesh = &scene->meshes[i].mesh;
        mesh->appearances = scene->palette.appearances;
        mesh->appearance_count = scene->palette.appearance_count;
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
    if (result || !mesh->palette) return result;
    scene->palette = *mesh->palette; /* whose appearances stay where they are */
    free(mesh->palette);
    mesh->palette = NULL;
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

/* Appearances that are not drawn as the file says. */
static void warn_of_palette(psplat_scene *scene) {
    const psplat_palette *palette = &scene->palette;
    size_t blended = 0;
    if (palette->problem) psplat_scene_warn(scene, "materials: %s", palette->problem);
    for (size_t i = 0; i < palette->image_count; ++i)
        if (palette->images[i].problem)
            psplat_scene_warn(scene, "%s; the material's factor stands alone",
                              palette->images[i].problem);
    for (size_t i = 0; i < palette->appearance_count; ++i)
        blended += palette->appearances[i].is_blended != 0;
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
    if (!result) warn_of_palette(scene);
    if (result) psplat_scene_free(scene);
    psplat_source_free(&source);
    return result;
}
