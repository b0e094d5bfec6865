/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.cpp - glTF and GLB through tinygltf: the triangles of the default scene, its
 * nodes' transforms applied.
 */
#include "adapter_gltf.hpp"

#include <exception>
#include <new>

using namespace psplat_gltf;

namespace {

psplat_result read_flat(const tinygltf::Model &model, psplat_mesh &mesh, psplat_error *error) {
    Soup soup;
    add_scene(soup, model);
    if (soup.triangles.empty()) fail(PSPLAT_ERROR_NO_SPLATS, "the scene has no triangles");
    bool differ = materials_differ(soup);
    psplat_material material = bake_materials(model, soup);
    psplat_result result = store(soup, differ, mesh, error);
    if (result) return result;
    mesh.material = material;
    for (size_t t = 0; mesh.groups && t < mesh.triangle_count; ++t)
        mesh.groups[t] = group_of(model, soup.materials[t]);
    return PSPLAT_OK;
}

} // namespace

psplat_result psplat_mesh_read_gltf(const psplat_source *source, psplat_mesh *mesh,
                                    psplat_error *error) {
    try {
        tinygltf::Model model;
        read_document(*source, model);
        return read_flat(model, *mesh, error);
    } catch (const Failure &failure) {
        return psplat_fail(error, failure.code, 0, "%s: %s", source->path, failure.text.c_str());
    } catch (const std::bad_alloc &) {
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    } catch (const std::exception &exception) {
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: tinygltf: %s", source->path,
                           exception.what());
    }
}
