/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * alternatives.c - fallback meshes and Gaussians of all meshes of a scene.
 *
 * A viewer that does not know PSPLAT_surface_splats shows one of the two instead of the splats.
 * This file loops over the scene; fallback_mesh.c and khr_gaussians.c make them for one mesh.
 */
#include "export/alternatives.h"

#include "export/fallback_mesh.h"
#include "export/khr_gaussians.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"

#include <stdlib.h>

void psplat_scene_fallback_meshes_free(const psplat_scene *scene, psplat_fallback_mesh *fallbacks) {
    for (size_t i = 0; fallbacks && i < scene->mesh_count; ++i)
        psplat_fallback_mesh_free(&fallbacks[i]);
    free(fallbacks);
}

/* psplat_fallback_mesh_make, or psplat_whole_mesh_make. */
typedef psplat_result (*make_mesh)(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                   psplat_fallback_mesh *made, psplat_error *error);

static psplat_result make_meshes(const psplat_scene *scene, psplat_convert_desc desc,
                                 make_mesh make, const double *lengths, psplat_fallback_mesh *made,
                                 psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    desc.progress = NULL;
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
        desc.diagonal = lengths[i];
        if (scene->meshes[i].mesh.triangle_count)
            result = make(&scene->meshes[i].mesh, &desc, &made[i], error);
    }
    return result;
}

static psplat_result make_all(const psplat_scene *scene, const psplat_convert_desc *desc,
                              make_mesh make, psplat_fallback_mesh **all, psplat_error *error) {
    double *lengths = malloc((scene->mesh_count + 1) * sizeof *lengths), diagonal;
    psplat_fallback_mesh *made = calloc(scene->mesh_count + 1, sizeof *made);
    psplat_result result =
        lengths && made ? psplat_scene_lengths(scene, lengths, &diagonal, error)
                        : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for coarse meshes");
    if (!result) result = make_meshes(scene, *desc, make, lengths, made, error);
    free(lengths);
    *all = result ? NULL : made;
    if (result) psplat_scene_fallback_meshes_free(scene, made);
    return result;
}

psplat_result psplat_scene_fallback_meshes(const psplat_scene *scene,
                                           const psplat_convert_desc *desc,
                                           psplat_fallback_mesh **fallbacks, psplat_error *error) {
    return make_all(scene, desc, psplat_fallback_mesh_make, fallbacks, error);
}

psplat_result psplat_scene_whole_meshes(const psplat_scene *scene, const psplat_convert_desc *desc,
                                        psplat_fallback_mesh **whole, psplat_error *error) {
    return make_all(scene, desc, psplat_whole_mesh_make, whole, error);
}

void psplat_scene_gaussians_free(const psplat_scene *scene, psplat_gaussian **gaussians) {
    for (size_t i = 0; gaussians && i < scene->mesh_count; ++i) free(gaussians[i]);
    free(gaussians);
}

psplat_result psplat_scene_gaussians(const psplat_scene *scene, const psplat_splats *splats,
                                     psplat_gaussian ***gaussians, psplat_error *error) {
    psplat_gaussian **made = calloc(scene->mesh_count + 1, sizeof *made);
    psplat_result result =
        made ? PSPLAT_OK : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for Gaussians");
    for (size_t i = 0; i < scene->mesh_count && !result; ++i)
        result = psplat_gaussians_make(&splats[i], &scene->materials, &made[i], error);
    *gaussians = result ? NULL : made;
    if (result) psplat_scene_gaussians_free(scene, made);
    return result;
}
