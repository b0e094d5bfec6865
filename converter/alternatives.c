/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * alternatives.c - what a scene's meshes are for viewers that know no splats: coarse meshes, and
 * Gaussians.
 */
#include "gaussian.h"
#include "scenes.h"
#include "stand_in.h"

#include <stdlib.h>

void psplat_scene_stand_ins_free(const psplat_scene *scene, psplat_stand_in *stand_ins) {
    for (size_t i = 0; stand_ins && i < scene->mesh_count; ++i) psplat_stand_in_free(&stand_ins[i]);
    free(stand_ins);
}

static psplat_result make_stand_ins(const psplat_scene *scene, psplat_convert_desc desc,
                                    const double *lengths, psplat_stand_in *made,
                                    psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    desc.progress = NULL;
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
        desc.diagonal = lengths[i];
        if (scene->meshes[i].mesh.triangle_count)
            result = psplat_stand_in_make(&scene->meshes[i].mesh, &desc, &made[i], error);
    }
    return result;
}

psplat_result psplat_scene_stand_ins(const psplat_scene *scene, const psplat_convert_desc *desc,
                                     psplat_stand_in **stand_ins, psplat_error *error) {
    double *lengths = malloc((scene->mesh_count + 1) * sizeof *lengths), diagonal;
    psplat_stand_in *made = calloc(scene->mesh_count + 1, sizeof *made);
    psplat_result result =
        lengths && made ? psplat_scene_lengths(scene, lengths, &diagonal, error)
                        : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for coarse meshes");
    if (!result) result = make_stand_ins(scene, *desc, lengths, made, error);
    free(lengths);
    *stand_ins = result ? NULL : made;
    if (result) psplat_scene_stand_ins_free(scene, made);
    return result;
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
        result = psplat_gaussians_make(&splats[i], &made[i], error);
    *gaussians = result ? NULL : made;
    if (result) psplat_scene_gaussians_free(scene, made);
    return result;
}
