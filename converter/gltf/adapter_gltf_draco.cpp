/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_draco.cpp - KHR_draco_mesh_compression: decodes compressed primitives.
 *
 * libdraco decodes them. Its decoder trusts the counts at the begin of the bytes and allocates for
 * them, so they are checked first against what the bytes can hold. What primitives say of counts is
 * replaced by what was decoded, since Draco merges and splits vertices, which a file may not say.
 * Two things cannot be checked before: damaged bytes may keep libdraco 1.5.5 busy for seconds, as
 * it reads as many bits for its prediction of texture coordinates as they say, up to 2^31; and a
 * mesh may have many attributes of all its vertices, each in a few bytes.
 */
#include "gltf/adapter_gltf.hpp"

#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <tuple>

namespace psplat_gltf {
namespace {

const char *const extension_name = "KHR_draco_mesh_compression";

/* The triangles or vertices that a byte may hold at most. Of a flat grid of a million triangles
 * with 11 bits a coordinate it holds 27, of other meshes one or less. */
constexpr size_t most_per_byte = 256;

/* How an attribute is to be stored: what the accessor of a primitive says of it. */
struct Form {
    unsigned id; /* of the attribute, in the Draco mesh */
    int component_type, type;
    bool normalized;

    bool operator<(const Form &other) const {
        return std::tie(id, component_type, type, normalized) <
               std::tie(other.id, other.component_type, other.type, other.normalized);
    }
};

/* A mesh that was decoded from a buffer view, and the accessors that were made of it: primitives
 * may share both. */
struct Decoded {
    std::unique_ptr<draco::Mesh> mesh;
    std::map<Form, int> attributes;
    int indices;
};

struct Reader {
    tinygltf::Model &model;
    size_t budget; /* the compressed bytes that may still be decoded */
    std::map<int, Decoded> decoded;
};

/* ---- the extension's object ------------------------------------------------------------------ */

int index_of(const tinygltf::Value &object, const std::string &name, const std::string &where) {
    double value =
        object.Has(name) && object.Get(name).IsNumber() ? object.Get(name).GetNumberAsDouble() : -1;
    if (!(value >= 0 && value <= 0x7fffffff) || value != static_cast<int>(value))
        fail(PSPLAT_ERROR_FORMAT, where + ": its compressed " + name + " is not an index");
    return static_cast<int>(value);
}

/* Returns whether an attribute is one of those that are read. Others stay compressed. */
bool is_read(const std::string &name) {
    for (size_t set = 0; set < PSPLAT_TEXCOORDS; ++set)
        if (name == "TEXCOORD_" + std::to_string(set)) return true;
    return name == "POSITION" || name == "NORMAL" || name == "TANGENT" || name == "COLOR_0";
}

/* Returns whether some attribute that is read has no bytes but the compressed ones. */
bool needs_decoding(const tinygltf::Model &model, const tinygltf::Primitive &primitive) {
    for (const auto &[name, index] : primitive.attributes) {
        const tinygltf::Accessor &accessor = element(model.accessors, index, "accessor");
        if (is_read(name) && accessor.bufferView == -1 && !accessor.sparse.isSparse) return true;
    }
    return primitive.indices == -1; /* they were left out */
}

/* Returns whether the primitive is to be decoded. It also may have all that it needs without, for
 * readers that do not know the extension, and then that is exact. */
bool is_compressed(const tinygltf::Model &model, const tinygltf::Primitive &primitive) {
    const std::vector<std::string> &required = model.extensionsRequired;
    if (!primitive.extensions.count(extension_name) || !is_drawn_as_triangles(primitive))
        return false;
    return std::find(required.begin(), required.end(), extension_name) != required.end() ||
           needs_decoding(model, primitive);
}

/* ---- bytes ----------------------------------------------------------------------------------- */

/* Fails unless the header and the counts behind it are those of a mesh that so many bytes can hold
 * (Draco bitstream specification 2.2: header, metadata, and the begin of the connectivity). */
void check_counts(const char *bytes, size_t length, const std::string &where) {
    enum { MESH = 1, EDGEBREAKER = 1, HAS_METADATA = 0x8000 };
    draco::DecoderBuffer buffer;
    draco::GeometryMetadata metadata;
    char magic[5];
    uint8_t major = 0, minor = 0, kind = 0, method = 0, traversal = 0;
    uint16_t flags = 0;
    uint32_t counts[2] = {0, 0};
    buffer.Init(bytes, length);
    if (!buffer.Decode(magic, sizeof magic) || std::memcmp(magic, "DRACO", sizeof magic) != 0)
        fail(PSPLAT_ERROR_FORMAT, where + ": its bytes are not those of Draco");
    bool ok = buffer.Decode(&major) && buffer.Decode(&minor) && buffer.Decode(&kind) &&
              buffer.Decode(&method) && buffer.Decode(&flags);
    if (ok && kind != MESH) fail(PSPLAT_ERROR_FORMAT, where + ": Draco has no mesh there");
    if (ok && (major != 2 || minor != 2))
        fail(PSPLAT_ERROR_UNSUPPORTED, where + ": Draco's version " + std::to_string(major) + "." +
                                           std::to_string(minor) + "; 2.2 is read");
    if (ok && (flags & HAS_METADATA)) {
        draco::MetadataDecoder decoder;
        ok = decoder.DecodeGeometryMetadata(&buffer, &metadata);
    }
    if (ok && method == EDGEBREAKER) ok = buffer.Decode(&traversal);
    for (uint32_t &count : counts) {
        ok = ok && draco::DecodeVarint(&count, &buffer);
        if (count / most_per_byte > length)
            fail(PSPLAT_ERROR_RANGE, where + ": " + std::to_string(count) +
                                         " triangles or vertices cannot be in " +
                                         std::to_string(length) + " compressed bytes");
    }
    if (!ok) fail(PSPLAT_ERROR_FORMAT, where + ": its compressed bytes end too early");
}

std::unique_ptr<draco::Mesh> decode(const char *bytes, size_t length, const std::string &where) {
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(bytes, length);
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok())
        fail(PSPLAT_ERROR_FORMAT, where + ": its compressed bytes are damaged: " +
                                      one_line(result.status().error_msg_string()).substr(0, 80));
    std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
    if (mesh->num_faces() == 0)
        fail(PSPLAT_ERROR_FORMAT, where + ": its compressed mesh has no triangles");
    return mesh;
}

/* ---- accessors ------------------------------------------------------------------------------- */

/* Adds an accessor to the model whose elements are the bytes. */
int add_accessor(tinygltf::Model &model, tinygltf::Accessor accessor,
                 std::vector<unsigned char> bytes, size_t count) {
    tinygltf::BufferView view;
    tinygltf::Buffer buffer;
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteLength = bytes.size();
    buffer.data = std::move(bytes);
    accessor.bufferView = static_cast<int>(model.bufferViews.size());
    accessor.byteOffset = 0;
    accessor.count = count;
    accessor.sparse.isSparse = false;
    model.buffers.push_back(std::move(buffer));
    model.bufferViews.push_back(std::move(view));
    model.accessors.push_back(std::move(accessor));
    return static_cast<int>(model.accessors.size()) - 1;
}

int add_indices(tinygltf::Model &model, const draco::Mesh &mesh) {
    tinygltf::Accessor accessor;
    size_t count = 3 * static_cast<size_t>(mesh.num_faces());
    std::vector<unsigned char> bytes(count * sizeof(uint32_t));
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = TINYGLTF_TYPE_SCALAR;
    for (size_t i = 0; i < count; ++i) {
        uint32_t index = mesh.face(draco::FaceIndex(static_cast<uint32_t>(i / 3)))[i % 3].value();
        std::memcpy(bytes.data() + i * sizeof index, &index, sizeof index);
    }
    return add_accessor(model, std::move(accessor), std::move(bytes), count);
}

/* Stores an attribute of every point as components of a type; returns whether it has them. */
template <typename T>
bool convert(const draco::PointAttribute &attribute, size_t points, int components,
             std::vector<unsigned char> &bytes) {
    size_t packed = sizeof(T) * static_cast<size_t>(components);
    if (!attribute.is_mapping_identity() && attribute.indices_map_size() < points) return false;
    bytes.resize(points * packed);
    for (size_t i = 0; i < points; ++i) {
        T values[4];
        auto at = attribute.mapped_index(draco::PointIndex(static_cast<uint32_t>(i)));
        if (!attribute.ConvertValue<T>(at, static_cast<int8_t>(components), values)) return false;
        std::memcpy(bytes.data() + i * packed, values, packed);
    }
    return true;
}

bool convert_to(int component_type, const draco::PointAttribute &attribute, size_t points,
                int components, std::vector<unsigned char> &bytes) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return convert<int8_t>(attribute, points, components, bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return convert<uint8_t>(attribute, points, components, bytes);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return convert<int16_t>(attribute, points, components, bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return convert<uint16_t>(attribute, points, components, bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return convert<uint32_t>(attribute, points, components, bytes);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return convert<float>(attribute, points, components, bytes);
    default:
        return false;
    }
}

int add_attribute(tinygltf::Model &model, const draco::Mesh &mesh, const Form &form,
                  const std::string &where) {
    const draco::PointAttribute *attribute = mesh.GetAttributeByUniqueId(form.id);
    int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(form.type));
    tinygltf::Accessor accessor;
    std::vector<unsigned char> bytes;
    accessor.componentType = form.component_type;
    accessor.type = form.type;
    accessor.normalized = form.normalized;
    if (!attribute || components < 1 || components > 4 || attribute->num_components() != components)
        fail(PSPLAT_ERROR_FORMAT, where + ": " + named("compressed attribute", form.id) +
                                      " is not there, or not as its accessor says");
    size_t points = mesh.num_points();
    if (!convert_to(form.component_type, *attribute, points, components, bytes))
        fail(PSPLAT_ERROR_FORMAT, where + ": values of " + named("compressed attribute", form.id) +
                                      " do not fit the type of its accessor");
    return add_accessor(model, std::move(accessor), std::move(bytes), points);
}

/* ---- primitives ------------------------------------------------------------------------------ */

/* Returns the mesh of a buffer view, which is decoded once. */
Decoded &decoded_of(Reader &reader, int index, const std::string &where) {
    auto found = reader.decoded.find(index);
    if (found != reader.decoded.end()) return found->second;
    const tinygltf::BufferView &view = element(reader.model.bufferViews, index, "bufferView");
    const tinygltf::Buffer &buffer =
        element(reader.model.buffers, view.buffer, (where + ": buffer").c_str());
    size_t total = buffer.data.size(), length = view.byteLength;
    if (view.byteOffset > total || length > total - view.byteOffset)
        fail(PSPLAT_ERROR_RANGE, where + ": its compressed bytes end beyond their buffer");
    if (length > reader.budget)
        fail(PSPLAT_ERROR_RANGE, where + ": its compressed bytes are not its own");
    reader.budget -= length;
    const char *bytes = reinterpret_cast<const char *>(buffer.data.data() + view.byteOffset);
    check_counts(bytes, length, where);
    Decoded decoded = {decode(bytes, length, where), {}, -1};
    decoded.indices = add_indices(reader.model, *decoded.mesh);
    return reader.decoded.emplace(index, std::move(decoded)).first->second;
}

void decode_primitive(Reader &reader, tinygltf::Primitive &primitive, const std::string &where) {
    const tinygltf::Value &object = primitive.extensions.at(extension_name);
    if (!object.IsObject() || !object.Has("attributes") || !object.Get("attributes").IsObject())
        fail(PSPLAT_ERROR_FORMAT, where + ": its compression has no attributes");
    int view = index_of(object, "bufferView", where);
    const std::string view_name = named("bufferView", static_cast<size_t>(view));
    Decoded &decoded = decoded_of(reader, view, view_name);
    const tinygltf::Value &ids = object.Get("attributes");
    for (auto &[name, index] : primitive.attributes) {
        if (!is_read(name) || !ids.Has(name)) continue;
        const tinygltf::Accessor &accessor = element(reader.model.accessors, index, "accessor");
        const Form form = {static_cast<unsigned>(index_of(ids, name, where)),
                           accessor.componentType, accessor.type, accessor.normalized};
        auto found = decoded.attributes.find(form);
        if (found == decoded.attributes.end())
            found = decoded.attributes
                        .emplace(form, add_attribute(reader.model, *decoded.mesh, form, view_name))
                        .first;
        index = found->second;
    }
    primitive.indices = decoded.indices;
    primitive.mode = TINYGLTF_MODE_TRIANGLES; /* Draco has no strips: these are its triangles. */
}

/* ---- indices that tinygltf would miss ---------------------------------------------------------
 */

/* Returns list[index], or NULL where there is no such object. */
const nlohmann::json *object_at(const nlohmann::json &json, const char *list,
                                const nlohmann::json &index) {
    if (!json.contains(list) || !json[list].is_array() || !index.is_number_unsigned())
        return nullptr;
    const nlohmann::json &all = json[list];
    size_t at = index.get<size_t>();
    return at < all.size() && all[at].is_object() ? &all[at] : nullptr;
}

bool lacks_indices(const nlohmann::json &json, const nlohmann::json &primitive) {
    if (!primitive.is_object() || !primitive.contains("extensions") ||
        !primitive.contains("indices") || !primitive["extensions"].is_object() ||
        !primitive["extensions"].contains(extension_name))
        return false;
    const nlohmann::json *accessor = object_at(json, "accessors", primitive["indices"]);
    return accessor && !accessor->contains("bufferView");
}

} // namespace

bool leave_out_indices(std::string_view text, std::string &replaced) {
    if (text.find(extension_name) == std::string_view::npos) return false;
    nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object() || !json.contains("meshes") || !json["meshes"].is_array()) return false;
    bool any = false;
    for (nlohmann::json &mesh : json["meshes"]) {
        if (!mesh.is_object() || !mesh.contains("primitives")) continue;
        for (nlohmann::json &primitive : mesh["primitives"]) {
            if (!lacks_indices(json, primitive)) continue;
            primitive.erase("indices");
            any = true;
        }
    }
    if (any) replaced = json.dump();
    return any;
}

void decode_draco(tinygltf::Model &model) {
    Reader reader = {model, 0, {}};
    for (const tinygltf::Buffer &buffer : model.buffers) reader.budget += buffer.data.size();
    for (size_t m = 0; m < model.meshes.size(); ++m)
        for (size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
            tinygltf::Primitive &primitive = model.meshes[m].primitives[p];
            if (is_compressed(model, primitive))
                decode_primitive(reader, primitive,
                                 "meshes[" + std::to_string(m) + "].primitives[" +
                                     std::to_string(p) + "]");
        }
}

} // namespace psplat_gltf
