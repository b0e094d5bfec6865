/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_material.cpp - materials (glTF 2.0 section 3.9).
 */
#include "adapter_gltf.hpp"

#include <cmath>

namespace psplat_gltf {
namespace {

float factor(double value, double low, double high) {
    return static_cast<float>(value > low ? std::fmin(value, high) : low);
}

} // namespace

psplat_material material_of(const tinygltf::Model &model, int index) {
    psplat_material out = {{1, 1, 1, 1}, {0, 0, 0}, 1, 1, 0, 0};
    if (index < 0) return out;
    const tinygltf::Material &in = element(model.materials, index, "material");
    const tinygltf::PbrMetallicRoughness &pbr = in.pbrMetallicRoughness;
    for (size_t k = 0; k < 4 && pbr.baseColorFactor.size() == 4; ++k)
        out.base_color[k] = factor(pbr.baseColorFactor[k], 0, 1);
    for (size_t k = 0; k < 3 && in.emissiveFactor.size() == 3; ++k)
        out.emissive[k] = factor(in.emissiveFactor[k], 0, 1e6);
    out.metallic = factor(pbr.metallicFactor, 0, 1);
    out.roughness = factor(pbr.roughnessFactor, 0, 1);
    out.double_sided = in.doubleSided;
    out.unlit = in.extensions.count("KHR_materials_unlit") != 0;
    return out;
}

void read_palette(const tinygltf::Model &model, psplat_palette &palette) {
    allocate(palette.appearances, palette.appearance_count, model.materials.size() + 1);
    for (size_t i = 0; i < model.materials.size(); ++i) {
        describe(model.materials[i], palette.appearances[i]);
        palette.appearances[i].material = material_of(model, static_cast<int>(i));
    }
    palette.appearances[model.materials.size()].material = material_of(model, -1);
}

bool materials_differ(const Soup &soup) {
    for (int index : soup.materials)
        if (index != soup.materials.front()) return true;
    return false;
}

psplat_material bake_materials(const tinygltf::Model &model, Soup &soup) {
    psplat_material out = material_of(model, soup.materials.front());
    if (!materials_differ(soup)) return out;
    pad(soup.colors, soup.triangles.size(), {1, 1, 1, 1});
    std::vector<psplat_material> materials;
    for (int index = -1; index < static_cast<int>(model.materials.size()); ++index)
        materials.push_back(material_of(model, index));
    for (size_t t = 0; t < soup.materials.size(); ++t) {
        int index = soup.materials[t];
        if (index != -1) element(model.materials, index, "material");
        const psplat_material &material = materials[static_cast<size_t>(index + 1)];
        for (size_t i = 0; i < 12; ++i) soup.colors[t * 12 + i] *= material.base_color[i % 4];
        out.double_sided = out.double_sided || material.double_sided;
    }
    for (float &value : out.base_color) value = 1;
    return out;
}

} // namespace psplat_gltf
