/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.cpp - glTF and GLB through tinygltf: a whole scene, or the triangles of the
 * default one with its nodes' transforms applied.
 */
#include "adapter_gltf.hpp"

#include <cstdlib>
#include <exception>
#include <new>

using namespace psplat_gltf;

namespace {

/* Each group is a material; the first one's factors stand for the mesh where one has to. */
void paint(const tinygltf::Model &model, const Soup &soup, psplat_mesh &mesh) {
    const psplat_appearance *all = mesh.palette->appearances;
    mesh.appearances = all;
    mesh.appearance_count = mesh.palette->appearance_count;
    mesh.material = all[group_of(model, soup.materials.front())].material;
    for (size_t t = 0; t < soup.materials.size(); ++t)
        mesh.groups[t] = group_of(model, soup.materials[t]);
}

void read_flat(const tinygltf::Model &model, psplat_mesh &mesh) {
    Soup soup;
    add_scene(soup, model);
    if (soup.triangles.empty()) fail(PSPLAT_ERROR_NO_SPLATS, "the scene has no triangles");
    for (int material : soup.materials)
        if (material != -1) element(model.materials, material, "material");
    store(soup, true, mesh);
    mesh.palette = static_cast<psplat_palette *>(std::calloc(1, sizeof *mesh.palette));
    if (!mesh.palette) throw std::bad_alloc();
    read_palette(model, *mesh.palette);
    paint(model, soup, mesh);
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
