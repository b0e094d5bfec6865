/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_levels.c - levels of detail as further meshes of a scene, which the writer treats as all
 * others.
 */
#include "export/mesh_levels.h"

#include "scene/scene.h"
#include "splats/splats.h"

#include <stdlib.h>
#include <string.h>

static size_t count_coarser(const psplat_mesh_levels *levels, size_t meshes) {
    size_t count = 0;
    for (size_t i = 0; levels && i < meshes; ++i)
        count += levels[i].count ? levels[i].count - 1 : 0;
    return count;
}

size_t psplat_leveled_scene_mesh(const psplat_mesh_levels *levels, size_t finest_count, size_t mesh,
                                 size_t level) {
    return finest_count + count_coarser(levels, mesh) + level - 1;
}

psplat_result psplat_leveled_scene_make(const psplat_scene *scene, const psplat_splats *splats,
                                        const psplat_mesh_levels *levels,
                                        psplat_leveled_scene *leveled, psplat_error *error) {
    size_t own = scene->mesh_count, count = own + count_coarser(levels, own);
    *leveled = (psplat_leveled_scene){.scene = *scene, .finest_count = own};
    leveled->scene.meshes = calloc(count + 1, sizeof *leveled->scene.meshes);
    leveled->scene.mesh_count = count;
    leveled->splats = calloc(count + 1, sizeof *leveled->splats);
    if (!leveled->scene.meshes || !leveled->splats)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu meshes", count);
    if (own) memcpy(leveled->scene.meshes, scene->meshes, own * sizeof *scene->meshes);
    if (own) memcpy(leveled->splats, splats, own * sizeof *splats);
    for (size_t i = 0, at = own; levels && i < own; ++i)
        for (size_t k = 1; k < levels[i].count; ++k)
            leveled->splats[at++] = levels[i].list[k].splats;
    return PSPLAT_OK;
}

void psplat_leveled_scene_free(psplat_leveled_scene *leveled) {
    free(leveled->scene.meshes);
    free(leveled->splats);
    *leveled = (psplat_leveled_scene){.splats = NULL};
}
