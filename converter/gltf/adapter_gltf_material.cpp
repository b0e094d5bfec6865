/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_material.cpp - materials and their textures (glTF 2.0 section 3.9,
 * KHR_texture_transform, KHR_materials_unlit, KHR_materials_emissive_strength).
 */
#include "gltf/adapter_gltf.hpp"
#include "material/image.h"
#include "material/source_materials.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace psplat_gltf {
namespace {

/* Clamps to low ... high; not-a-number becomes low. */
float factor(double value, double low, double high) {
    return static_cast<float>(value > low ? std::fmin(value, high) : low);
}

/* These read a member of an extension; the value stays as it is where there is no such member. */
void read_number(const tinygltf::Value &object, const char *name, double &value) {
    if (!object.Has(name) || !object.Get(name).IsNumber()) return;
    double number = object.Get(name).GetNumberAsDouble();
    if (std::isfinite(number)) value = number;
}

void read_pair(const tinygltf::Value &object, const char *name, double pair[2]) {
    if (!object.Has(name) || !object.Get(name).IsArray()) return;
    const tinygltf::Value &array = object.Get(name);
    for (int k = 0; k < 2 && array.ArrayLen() == 2; ++k) {
        const tinygltf::Value &item = array.Get(k);
        if (item.IsNumber() && std::isfinite(item.GetNumberAsDouble()))
            pair[k] = item.GetNumberAsDouble();
    }
}

psplat_material factors_of(const tinygltf::Material &in) {
    psplat_material out = {};
    std::fill_n(out.base_color, 4, 1.0f);
    const tinygltf::PbrMetallicRoughness &pbr = in.pbrMetallicRoughness;
    for (size_t k = 0; k < 4 && pbr.baseColorFactor.size() == 4; ++k)
        out.base_color[k] = factor(pbr.baseColorFactor[k], 0, 1);
    double strength = 1;
    auto extension = in.extensions.find("KHR_materials_emissive_strength");
    if (extension != in.extensions.end())
        read_number(extension->second, "emissiveStrength", strength);
    for (size_t k = 0; k < 3 && in.emissiveFactor.size() == 3; ++k)
        out.emissive[k] = factor(in.emissiveFactor[k] * strength, 0, 1e6);
    out.metallic = factor(pbr.metallicFactor, 0, 1);
    out.roughness = factor(pbr.roughnessFactor, 0, 1);
    out.double_sided = in.doubleSided;
    out.unlit = in.extensions.count("KHR_materials_unlit") != 0;
    return out;
}

/* ---- images --------------------------------------------------------------------------------- */

struct Bytes {
    const unsigned char *data;
    size_t size;
};

/* Returns the bytes of an image file. Where there are none, problem says why. */
Bytes bytes_of(const tinygltf::Model &model, const tinygltf::Image &image, std::string &problem) {
    if (image.bufferView < 0) {
        if (image.image.empty())
            problem = "'" + one_line(image.uri).substr(0, 80) + "' beside the file cannot be read";
        return {image.image.data(), image.image.size()};
    }
    const tinygltf::BufferView &view = element(model.bufferViews, image.bufferView, "bufferView");
    const tinygltf::Buffer &buffer = element(model.buffers, view.buffer, "buffer");
    size_t total = buffer.data.size();
    if (view.byteOffset > total || view.byteLength > total - view.byteOffset) {
        problem = "its bufferView ends beyond its buffer";
        return {nullptr, 0};
    }
    return {buffer.data.data() + view.byteOffset, view.byteLength};
}

/* Returns the name of an image or else its path; data: URIs name nothing. */
std::string name_of(const tinygltf::Image &image) {
    if (!image.name.empty() || image.uri.compare(0, 5, "data:") == 0) return image.name;
    return image.uri;
}

/* Reads an image once; what goes wrong becomes its problem, which is a warning later. */
void decode(const tinygltf::Model &model, size_t index, psplat_image &out) {
    if (out.pixels || out.problem) return;
    std::string problem;
    Bytes bytes = bytes_of(model, model.images[index], problem);
    psplat_error error;
    if (problem.empty()) {
        psplat_result result = psplat_image_read(bytes.data, bytes.size, &out, &error);
        if (result == PSPLAT_ERROR_MEMORY) throw std::bad_alloc();
        if (result) problem = one_line(error.text);
    }
    if (!problem.empty()) out.problem = text_of(named("image", index) + ": " + problem);
    if (out.pixels) out.name = text_of(name_of(model.images[index]));
}

/* ---- textures ------------------------------------------------------------------------------- */

psplat_wrap wrap_of(int wrap) {
    if (wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return PSPLAT_WRAP_CLAMP;
    return wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? PSPLAT_WRAP_MIRROR : PSPLAT_WRAP_REPEAT;
}

/* Reads KHR_texture_transform as the rows of translation x rotation x scale. */
void read_transform(const tinygltf::ExtensionMap &extensions, psplat_texture_info &texture) {
    auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end() || !found->second.IsObject()) return;
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0, texcoord = texture.texcoord;
    read_pair(found->second, "offset", offset);
    read_pair(found->second, "scale", scale);
    read_number(found->second, "rotation", rotation);
    read_number(found->second, "texCoord", texcoord);
    double c = std::cos(rotation), s = std::sin(rotation);
    const double rows[6] = {c * scale[0],  s * scale[1], offset[0],
                            -s * scale[0], c * scale[1], offset[1]};
    std::copy_n(rows, 6, texture.transform);
    texture.texcoord = texcoord >= 0 && texcoord < 1e6 ? static_cast<uint32_t>(texcoord) : 0;
}

/* Reads the texture of a material. Info is a template since tinygltf has three structs for it. */
template <typename Info>
psplat_texture_info texture_of(const tinygltf::Model &model, const Info &info, double strength,
                               psplat_source_materials &materials) {
    psplat_texture_info out = {};
    if (info.index < 0) return out;
    const tinygltf::Texture &in = element(model.textures, info.index, "texture");
    if (in.source < 0) return out; /* its image is that of an extension which is not read */
    element(model.images, in.source, "image");
    out.image = &materials.images[in.source];
    decode(model, static_cast<size_t>(in.source), materials.images[in.source]);
    if (in.sampler >= 0) {
        const tinygltf::Sampler &sampler = element(model.samplers, in.sampler, "sampler");
        out.wrap[0] = wrap_of(sampler.wrapS);
        out.wrap[1] = wrap_of(sampler.wrapT);
        out.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    out.texcoord = info.texCoord < 0 ? 0 : static_cast<uint32_t>(info.texCoord);
    out.strength = factor(strength, -1e6, 1e6);
    read_transform(info.extensions, out);
    return out;
}

psplat_source_material source_material_of(const tinygltf::Model &model,
                                          const tinygltf::Material &in,
                                          psplat_source_materials &materials) {
    psplat_source_material out = {};
    const tinygltf::PbrMetallicRoughness &pbr = in.pbrMetallicRoughness;
    out.material = factors_of(in);
    out.base_color = texture_of(model, pbr.baseColorTexture, 1, materials);
    out.metallic_roughness = texture_of(model, pbr.metallicRoughnessTexture, 1, materials);
    out.normal = texture_of(model, in.normalTexture, in.normalTexture.scale, materials);
    out.occlusion = texture_of(model, in.occlusionTexture,
                               std::fmin(std::fmax(in.occlusionTexture.strength, 0), 1), materials);
    out.emissive = texture_of(model, in.emissiveTexture, 1, materials);
    out.is_masked = in.alphaMode == "MASK";
    out.is_blended = in.alphaMode == "BLEND";
    out.alpha_cutoff = factor(in.alphaCutoff, 0, 1e6);
    return out;
}

} // namespace

psplat_material material_of(const tinygltf::Model &model, int index) {
    return factors_of(index < 0 ? tinygltf::Material()
                                : element(model.materials, index, "material"));
}

void read_materials(const tinygltf::Model &model, psplat_source_materials &materials) {
    allocate(materials.images, materials.image_count, model.images.size());
    allocate(materials.source_materials, materials.source_material_count,
             model.materials.size() + 1);
    for (size_t i = 0; i < model.materials.size(); ++i) {
        materials.source_materials[i] = source_material_of(model, model.materials[i], materials);
        describe(model.materials[i], materials.source_materials[i]);
    }
    materials.source_materials[model.materials.size()].material = material_of(model, -1);
    psplat_source_materials_describe_textures(&materials);
}

} // namespace psplat_gltf
