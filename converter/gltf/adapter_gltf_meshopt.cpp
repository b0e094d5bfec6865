/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_meshopt.cpp - EXT_meshopt_compression: decodes compressed buffer views.
 *
 * libmeshoptimizer's decoders are safe with any bytes, but they assert their arguments and trust
 * the counts. So the counts are checked first against what the compressed bytes can hold. The
 * fallback buffers of uncompressed data, which need not exist, are never loaded.
 */
#include "gltf/adapter_gltf.hpp"

#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

namespace psplat_gltf {
namespace {

const char *const extension_name = "EXT_meshopt_compression";

/* The members of the extension's object of a buffer view. */
struct Stream {
    size_t buffer, offset, length; /* of the compressed bytes */
    size_t stride, count;
    std::string mode, filter;
    std::string view; /* its name in messages */
};

/* ---- the extension's object ------------------------------------------------------------------ */

size_t number_of(const tinygltf::Value &object, const char *name, bool required,
                 const std::string &view) {
    if (!object.Has(name)) {
        if (required) fail(PSPLAT_ERROR_FORMAT, view + ": compressed without " + name);
        return 0;
    }
    double value = object.Get(name).IsNumber() ? object.Get(name).GetNumberAsDouble() : -1;
    if (!(value >= 0 && value < 9e15) || value != static_cast<double>(static_cast<size_t>(value)))
        fail(PSPLAT_ERROR_FORMAT, view + ": its compressed " + name + " is not a count");
    return static_cast<size_t>(value);
}

std::string text_in(const tinygltf::Value &object, const char *name, const char *otherwise) {
    if (!object.Has(name)) return otherwise;
    return object.Get(name).IsString() ? object.Get(name).Get<std::string>() : std::string("?");
}

Stream stream_of(const tinygltf::Value &object, const std::string &view) {
    if (!object.IsObject()) fail(PSPLAT_ERROR_FORMAT, view + ": its extension is not an object");
    return {
        number_of(object, "buffer", true, view),     number_of(object, "byteOffset", false, view),
        number_of(object, "byteLength", true, view), number_of(object, "byteStride", true, view),
        number_of(object, "count", true, view),      text_in(object, "mode", ""),
        text_in(object, "filter", "NONE"),           view};
}

/* ---- checks ---------------------------------------------------------------------------------- */

bool filter_fits(const Stream &s) {
    if (s.filter == "NONE") return true;
    if (s.mode != "ATTRIBUTES") return false;
    if (s.filter == "OCTAHEDRAL") return s.stride == 4 || s.stride == 8;
    if (s.filter == "QUATERNION") return s.stride == 8;
    return s.filter == "EXPONENTIAL";
}

void check_kind(const Stream &s) {
    bool indices = s.mode == "TRIANGLES" || s.mode == "INDICES";
    if (!indices && s.mode != "ATTRIBUTES")
        fail(PSPLAT_ERROR_FORMAT, s.view + ": unknown compression mode");
    if (indices ? s.stride != 2 && s.stride != 4 : !s.stride || s.stride % 4 || s.stride > 256)
        fail(PSPLAT_ERROR_RANGE, s.view + ": its compressed byteStride is out of range");
    if (s.mode == "TRIANGLES" && s.count % 3)
        fail(PSPLAT_ERROR_RANGE, s.view + ": its compressed triangles are incomplete");
    if (!filter_fits(s))
        fail(PSPLAT_ERROR_FORMAT,
             s.view + ": its filter is unknown or not for its mode and stride");
}

/* Checks the counts before memory is allocated for them. The codecs cannot be better than this: a
 * byte for the three indices of a triangle (TRIANGLES) or for one index (INDICES), and two bits for
 * 16 elements of one byte each (ATTRIBUTES). */
void check_size(const Stream &s, const tinygltf::Model &model, const tinygltf::BufferView &view) {
    const tinygltf::Buffer &buffer =
        element(model.buffers, s.buffer < model.buffers.size() ? static_cast<int>(s.buffer) : -1,
                (s.view + ": compressed buffer").c_str());
    size_t total = buffer.data.size(), elements = s.length;
    if (s.offset > total || s.length > total - s.offset)
        fail(PSPLAT_ERROR_RANGE, s.view + ": its compressed bytes end beyond their buffer");
    if (s.mode == "TRIANGLES") elements *= 3;
    if (s.mode == "ATTRIBUTES") elements = elements * 64 / s.stride;
    if (s.count == 0 || s.count > elements)
        fail(PSPLAT_ERROR_RANGE, s.view + ": " + std::to_string(s.count) +
                                     " elements cannot be in " + std::to_string(s.length) +
                                     " compressed bytes");
    if (view.byteLength != s.count * s.stride)
        fail(PSPLAT_ERROR_RANGE, s.view + ": its byteLength is not that of its elements");
}

/* ---- decoding -------------------------------------------------------------------------------- */

bool decode(const Stream &s, const unsigned char *bytes, unsigned char *out) {
    if (s.mode == "TRIANGLES")
        return meshopt_decodeIndexBuffer(static_cast<void *>(out), s.count, s.stride, bytes,
                                         s.length) == 0;
    if (s.mode == "INDICES")
        return meshopt_decodeIndexSequence(static_cast<void *>(out), s.count, s.stride, bytes,
                                           s.length) == 0;
    if (meshopt_decodeVertexBuffer(out, s.count, s.stride, bytes, s.length) != 0) return false;
    if (s.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out, s.count, s.stride);
    if (s.filter == "QUATERNION") meshopt_decodeFilterQuat(out, s.count, s.stride);
    if (s.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out, s.count, s.stride);
    return true;
}

/* Decodes a buffer view into a new buffer and makes the view refer to it. */
void decompress_view(tinygltf::Model &model, const Stream &s, tinygltf::BufferView &view) {
    check_kind(s);
    check_size(s, model, view);
    tinygltf::Buffer decoded;
    decoded.data.resize(view.byteLength);
    if (!decode(s, model.buffers[s.buffer].data.data() + s.offset, decoded.data.data()))
        fail(PSPLAT_ERROR_FORMAT, s.view + ": its compressed bytes are damaged");
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteOffset = 0;
    model.buffers.push_back(std::move(decoded));
}

bool is_fallback(const nlohmann::json &buffer) {
    if (!buffer.is_object() || buffer.contains("uri") || !buffer.contains("extensions"))
        return false;
    const nlohmann::json &extensions = buffer["extensions"];
    if (!extensions.is_object() || !extensions.contains(extension_name)) return false;
    const nlohmann::json &object = extensions[extension_name];
    return object.is_object() && object.contains("fallback") && object["fallback"] == true;
}

} // namespace

bool replace_fallbacks(std::string_view text, std::string &replaced) {
    if (text.find(extension_name) == std::string_view::npos) return false;
    nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object() || !json.contains("buffers") || !json["buffers"].is_array()) return false;
    bool any = false;
    for (nlohmann::json &buffer : json["buffers"]) {
        if (!is_fallback(buffer)) continue;
        buffer = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
        any = true;
    }
    if (any) replaced = json.dump();
    return any;
}

void decompress(tinygltf::Model &model) {
    /* Compressed views together may not be longer than the buffers: a small file could otherwise
     * decode the same bytes again and again. */
    size_t budget = 0;
    for (const tinygltf::Buffer &buffer : model.buffers) budget += buffer.data.size();
    for (size_t i = 0; i < model.bufferViews.size(); ++i) {
        tinygltf::BufferView &view = model.bufferViews[i];
        auto extension = view.extensions.find(extension_name);
        if (extension == view.extensions.end()) continue;
        Stream stream = stream_of(extension->second, named("bufferView", i));
        if (stream.length > budget)
            fail(PSPLAT_ERROR_RANGE, stream.view + ": its compressed bytes are not its own");
        budget -= stream.length;
        decompress_view(model, stream, view);
    }
}

} // namespace psplat_gltf
