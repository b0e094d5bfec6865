/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_material.cpp - materials and their textures (glTF 2.0 section 3.9,
 * KHR_texture_transform, KHR_materials_unlit, KHR_materials_emissive_strength,
 * KHR_materials_pbrSpecularGlossiness).
 */
#include "gltf/adapter_gltf.hpp"
#include "material/image.h"
#include "material/mipmap.h"
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

/* Reads as many numbers, or none. */
void read_numbers(const tinygltf::Value &object, const char *name, double *numbers, size_t count) {
    if (!object.Has(name) || !object.Get(name).IsArray()) return;
    const tinygltf::Value &array = object.Get(name);
    if (array.ArrayLen() != count) return;
    for (size_t k = 0; k < count; ++k) {
        const tinygltf::Value &item = array.Get(static_cast<int>(k));
        if (item.IsNumber() && std::isfinite(item.GetNumberAsDouble()))
            numbers[k] = item.GetNumberAsDouble();
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
    read_numbers(found->second, "offset", offset, 2);
    read_numbers(found->second, "scale", scale, 2);
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

/* ---- specular-glossiness ---------------------------------------------------------------------
 */

/* The reflectance of what is not metal (glTF 2.0 appendix B). */
const double dielectric = 0.04;

/* Returns a texture of an extension, as tinygltf reads those of materials; its index is -1 where
 * there is none. */
tinygltf::TextureInfo info_of(const tinygltf::Value &object, const char *name) {
    tinygltf::TextureInfo info;
    if (!object.Has(name) || !object.Get(name).IsObject()) return info;
    const tinygltf::Value &in = object.Get(name);
    double index = -1, texcoord = 0;
    read_number(in, "index", index);
    read_number(in, "texCoord", texcoord);
    info.index = index >= 0 && index < 1e6 ? static_cast<int>(index) : -1;
    info.texCoord = texcoord >= 0 && texcoord < 1e6 ? static_cast<int>(texcoord) : 0;
    if (!in.Has("extensions") || !in.Get("extensions").IsObject()) return info;
    for (const std::string &key : in.Get("extensions").Keys())
        info.extensions[key] = in.Get("extensions").Get(key);
    return info;
}

/* Multiplies a colour and a number by the mean of a texture: R, G and B in linear light, and alpha.
 */
void multiply_by_mean(const psplat_texture_info &texture, double color[3], double &number) {
    if (!texture.image || !texture.image->pixels) return;
    const psplat_image &image = *texture.image;
    double sums[4] = {0, 0, 0, 0}, count = static_cast<double>(image.width) * image.height;
    float linear[256];
    for (int i = 0; i < 256; ++i) linear[i] = psplat_linear_of_srgb(static_cast<float>(i) / 255);
    for (size_t i = 0; i < static_cast<size_t>(image.width) * image.height; ++i) {
        const uint8_t *pixel = image.pixels + 4 * i;
        for (int k = 0; k < 3; ++k) sums[k] += static_cast<double>(linear[pixel[k]]);
        sums[3] += pixel[3] / 255.0;
    }
    for (int k = 0; k < 3; ++k) color[k] *= sums[k] / count;
    number *= sums[3] / count;
}

double brightness_of(const double color[3]) {
    return std::sqrt(0.299 * color[0] * color[0] + 0.587 * color[1] * color[1] +
                     0.114 * color[2] * color[2]);
}

/* Returns how metallic a material is whose base colour, blended between what diffuse and what
 * specular light say of it, gives both: the root of a quadratic equation. */
double metallic_of(double diffuse, double specular, double not_reflected) {
    if (specular < dielectric) return 0;
    double b = diffuse * not_reflected / (1 - dielectric) + specular - 2 * dielectric;
    double square = std::fmax(b * b - 4 * dielectric * (dielectric - specular), 0);
    return std::fmin(std::fmax((std::sqrt(square) - b) / (2 * dielectric), 0), 1);
}

/* Reads KHR_materials_pbrSpecularGlossiness, which replaces metallic-roughness where a material has
 * both, as the metallic-roughness that looks most like it: by the method of the extension's own
 * examples, for the means of its textures. Base colours are those of diffuse light, with their
 * texture, or of specular light where most of the material is metal; but the alpha of that texture
 * is glossiness, which would cut and blend. Where it cannot be read nothing is said to be metal. */
void read_specular(const tinygltf::Model &model, const tinygltf::Value &extension, bool is_opaque,
                   psplat_source_materials &materials, psplat_source_material &out) {
    const double least = 1e-6;
    double diffuse[4] = {1, 1, 1, 1}, specular[3] = {1, 1, 1}, glossiness = 1, opacity = 1;
    read_numbers(extension, "diffuseFactor", diffuse, 4);
    read_numbers(extension, "specularFactor", specular, 3);
    read_number(extension, "glossinessFactor", glossiness);
    psplat_texture_info textures[2] = {
        texture_of(model, info_of(extension, "diffuseTexture"), 1, materials),
        texture_of(model, info_of(extension, "specularGlossinessTexture"), 1, materials)};
    double seen[3], reflected[3];
    std::copy_n(diffuse, 3, seen);
    std::copy_n(specular, 3, reflected);
    multiply_by_mean(textures[0], seen, opacity);
    multiply_by_mean(textures[1], reflected, glossiness);
    if (textures[1].image && !textures[1].image->pixels) std::fill_n(reflected, 3, dielectric);
    double left = 1 - std::fmax(reflected[0], std::fmax(reflected[1], reflected[2]));
    double metallic = metallic_of(brightness_of(seen), brightness_of(reflected), left);
    bool is_metal = metallic >= 0.5 && textures[1].image && is_opaque;
    for (int k = 0; k < 3; ++k) {
        double dull = diffuse[k] * left / (1 - dielectric) / std::fmax(1 - metallic, least);
        double shiny = (specular[k] - dielectric * (1 - metallic)) / std::fmax(metallic, least);
        double part = is_metal ? 1 : textures[0].image ? 0 : metallic * metallic;
        out.material.base_color[k] = factor(dull + part * (shiny - dull), 0, 1);
    }
    out.material.base_color[3] = factor(diffuse[3], 0, 1);
    out.material.metallic = factor(metallic, 0, 1);
    out.material.roughness = factor(1 - glossiness, 0, 1);
    out.base_color = textures[is_metal];
    out.metallic_roughness = psplat_texture_info{};
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
    auto specular = in.extensions.find("KHR_materials_pbrSpecularGlossiness");
    if (specular != in.extensions.end() && specular->second.IsObject())
        read_specular(model, specular->second, in.alphaMode == "OPAQUE", materials, out);
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
