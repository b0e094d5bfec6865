/* SPDX-License-Identifier: MIT
 *
 * fallback_link.c - the links of fallback meshes, which readers without the extension draw, to the
 * meshes of splats that they stand in for (spec 6.1).
 */
#include "asset/gltf.h"

psplat_result psplat_fallback_mesh_parse(psplat_gltf *gltf, psplat_json_value extensions,
                                         psplat_mesh_sets *sets) {
    static const char *const extension[] = {PSPLAT_EXTENSION}, *const member[] = {"mesh"};
    psplat_json_value object = 0;
    sets->splat_mesh = PSPLAT_NONE;
    if (!extensions) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, extensions, extension, 1, &object);
    if (result || !object) return result;
    result = psplat_json_members(&gltf->json, object, member, 1, &sets->json_splat_mesh);
    if (!result) result = psplat_gltf_require(gltf, object, sets->json_splat_mesh, member[0]);
    if (!result)
        result = psplat_gltf_index(gltf, sets->json_splat_mesh, member[0], gltf->mesh_count,
                                   &sets->splat_mesh);
    if (!result && sets->set_count)
        result = psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, object),
                             "a mesh that stands in for splats has splats itself");
    return result;
}

/* Links do not chain: the mesh that a fallback mesh stands in for stands in for no other mesh. */
psplat_result psplat_fallback_meshes_resolve(psplat_gltf *gltf) {
    for (size_t i = 0; i < gltf->mesh_count; ++i) {
        psplat_mesh_sets *sets = &gltf->meshes[i];
        if (sets->splat_mesh == PSPLAT_NONE) continue;
        const psplat_mesh_sets *splats = &gltf->meshes[sets->splat_mesh];
        if (splats->splat_mesh != PSPLAT_NONE || !splats->set_count)
            return psplat_fail(
                gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, sets->json_splat_mesh),
                "mesh %zu stands in for mesh %zu, which has no splats", i, sets->splat_mesh);
        sets->first_set = splats->first_set;
        sets->set_count = splats->set_count;
    }
    return PSPLAT_OK;
}
