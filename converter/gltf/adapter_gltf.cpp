/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.cpp - the entry points of the glTF and GLB reader. One reads the file as a scene,
 * the other the triangles of its default scene as one mesh. Exceptions of the reader end here.
 */
#include "gltf/adapter_gltf.hpp"
#include "gltf/read_gltf.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "scene/scene.h"
#include "source/source_file.h"

#include <cstdlib>
#include <exception>
#include <new>

using namespace psplat_gltf;

namespace {

/* Gives every triangle the group of its material. The mesh as a whole gets the factors of the first
 * triangle's material, for users that need a single one. */
void set_materials(const tinygltf::Model &model, const Soup &soup, psplat_mesh &mesh) {
    const psplat_source_material *all = mesh.materials->source_materials;
    mesh.source_materials = all;
    mesh.source_material_count = mesh.materials->source_material_count;
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
    mesh.materials = static_cast<psplat_source_materials *>(std::calloc(1, sizeof *mesh.materials));
    if (!mesh.materials) throw std::bad_alloc();
    read_materials(model, *mesh.materials);
    set_materials(model, soup, mesh);
}

/* Reads the document, calls read(model, warnings) and turns exceptions into error codes. */
template <typename Read>
psplat_result catch_errors(const psplat_source *source, psplat_error *error, Read read) {
    try {
        tinygltf::Model model;
        const std::vector<std::string> lost = read_document(*source, model);
        read(model, lost);
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
    return catch_errors(source, error, [&](const tinygltf::Model &model, const auto &) {
        read_flat(model, *mesh);
    });
}

psplat_result psplat_scene_read_gltf(const psplat_source *source, psplat_scene *scene,
                                     psplat_error *error) {
    return catch_errors(source, error, [&](const tinygltf::Model &model, const auto &lost) {
        for (const std::string &warning : lost) psplat_scene_warn(scene, "%s", warning.c_str());
        read_graph(model, *scene);
        read_materials(model, scene->materials);
        read_meshes(model, *scene);
    });
}
