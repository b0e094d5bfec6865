/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.cpp - glTF and GLB through tinygltf: a whole scene, or the triangles of the
 * default one with its nodes' transforms applied.
 */
#include "adapter_gltf.hpp"

#include <exception>
#include <new>

using namespace psplat_gltf;

namespace {

void read_flat(const tinygltf::Model &model, psplat_mesh &mesh) {
    Soup soup;
    add_scene(soup, model);
    if (soup.triangles.empty()) fail(PSPLAT_ERROR_NO_SPLATS, "the scene has no triangles");
    bool differ = materials_differ(soup);
    psplat_material material = bake_materials(model, soup);
    store(soup, differ, mesh);
    mesh.material = material;
    for (size_t t = 0; mesh.groups && t < mesh.triangle_count; ++t)
        mesh.groups[t] = group_of(model, soup.materials[t]);
}

/* Calls read(model) with the document; whatever is thrown ends here. */
template <typename Read>
psplat_result guard(const psplat_source *source, psplat_error *error, Read read) {
    try {
        tinygltf::Model model;
        read_document(*source, model);
        read(model);
        return PSPLAT_OK;
    } catch (const Failure &failure) {
        return psplat_fail(error, failure.code, 0, "%s: %s", source->path, failure.text.c_str());
    } catch (const std::bad_alloc &) {
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    } catch (const std::exception &exception) {
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: tinygltf: %s", source->path,
                           exception.what());
    }
}

} // namespace

psplat_result psplat_mesh_read_gltf(const psplat_source *source, psplat_mesh *mesh,
                                    psplat_error *error) {
    return guard(source, error, [&](const tinygltf::Model &model) { read_flat(model, *mesh); });
}

psplat_result psplat_scene_read_gltf(const psplat_source *source, psplat_scene *scene,
                                     psplat_error *error) {
    return guard(source, error, [&](const tinygltf::Model &model) {
        read_graph(model, *scene);
        read_palette(model, scene->palette);
        read_meshes(model, *scene);
    });
}
