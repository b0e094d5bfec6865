/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * scene.c - the scene graph of a source file: releasing it, warnings, and names for messages.
 */
#define _XOPEN_SOURCE 700

#include "scene/scene.h"

#include "base/path.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The size in bytes of a warning; the rest is cut off. */
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
    for (size_t i = 0; i < scene->animation_count; ++i) {
        free_strings(scene->animations[i].name, scene->animations[i].extras);
        free(scene->animations[i].samplers);
        free(scene->animations[i].channels);
    }
    for (size_t i = 0; i < scene->track_count; ++i) free(scene->tracks[i].values);
    free(scene->animations);
    free(scene->tracks);
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
    psplat_source_materials_free(&scene->materials);
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

void psplat_scene_label(const psplat_scene *scene, size_t mesh, char label[PSPLAT_SHOWN_PATH]) {
    const char *name = scene->meshes[mesh].name;
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(name ? name : "", shown);
    snprintf(label, PSPLAT_SHOWN_PATH, "mesh %zu%s%.60s%s", mesh, name ? " '" : "", shown,
             name ? "'" : "");
}
