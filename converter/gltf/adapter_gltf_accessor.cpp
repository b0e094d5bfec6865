/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_accessor.cpp - accessors: numbers in buffers, with bounds checked before anything is
 * read.
 */
#include "gltf/adapter_gltf.hpp"

#include <cmath>
#include <cstring>

namespace psplat_gltf {
namespace {

size_t component_size(int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

template <typename T> T load(const unsigned char *bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

struct Range {
    const unsigned char *data;
    size_t stride;
};

/* Returns the bytes of a buffer view from offset on and fails unless count elements of `packed`
 * bytes fit, each stride bytes after the one before. A stride of 0 means that of the view, or else
 * no gaps between elements. */
Range range_of(const tinygltf::Model &model, int index, size_t offset, size_t count, size_t packed,
               size_t stride, const std::string &name) {
    const tinygltf::BufferView &view =
        element(model.bufferViews, index, (name + ": bufferView").c_str());
    const tinygltf::Buffer &buffer =
        element(model.buffers, view.buffer, (name + ": buffer").c_str());
    if (!stride) stride = view.byteStride ? view.byteStride : packed;
    size_t total = buffer.data.size();
    if (view.byteOffset > total || view.byteLength > total - view.byteOffset)
        fail(PSPLAT_ERROR_RANGE, name + ": its bufferView ends beyond its buffer of " +
                                     std::to_string(total) + " bytes");
    if (stride < packed || stride > 252 + packed || offset > view.byteLength)
        fail(PSPLAT_ERROR_RANGE, name + ": byteStride or byteOffset out of range");
    size_t room = view.byteLength - offset;
    if (count == 0 || room < packed || (room - packed) / stride < count - 1)
        fail(PSPLAT_ERROR_RANGE,
             name + ": " + std::to_string(count) + " elements do not fit into its bufferView");
    return {buffer.data.data() + view.byteOffset + offset, stride};
}

/* Gives an accessor without a buffer view its zeros (glTF 2.0 section 3.6.2.1). It may not have
 * more elements than the file has bytes, or else a small file could fill the memory. */
void add_zeros(const tinygltf::Model &model, size_t packed, const std::string &name, View &view) {
    size_t bytes = 0;
    for (const tinygltf::Buffer &buffer : model.buffers) bytes += buffer.data.size();
    if (view.count == 0 || view.count > bytes)
        fail(PSPLAT_ERROR_RANGE, name + ": " + std::to_string(view.count) +
                                     " elements without a bufferView; the file has " +
                                     std::to_string(bytes) + " bytes");
    view.own = std::make_shared<std::vector<unsigned char>>(view.count * packed);
}

size_t sparse_index(const unsigned char *bytes, int type) {
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *bytes;
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? load<uint16_t>(bytes)
                                                          : load<uint32_t>(bytes);
}

/* Replaces the sparse elements (glTF 2.0 section 3.6.2.3) in view.own. */
void add_sparse(const tinygltf::Model &model, const tinygltf::Accessor &accessor, size_t packed,
                const std::string &name, View &view) {
    const auto &sparse = accessor.sparse;
    int type = sparse.indices.componentType;
    bool is_index = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                    type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                    type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (sparse.count < 1 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
        !is_index)
        fail(PSPLAT_ERROR_FORMAT, name + ": its sparse elements make no sense");
    size_t count = static_cast<size_t>(sparse.count), size = component_size(type);
    Range indices =
        range_of(model, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset),
                 count, size, size, name);
    Range values =
        range_of(model, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
                 count, packed, packed, name);
    for (size_t i = 0; i < count; ++i) {
        size_t index = sparse_index(indices.data + i * size, type);
        if (index >= view.count)
            fail(PSPLAT_ERROR_RANGE,
                 name + ": sparse element " + std::to_string(index) + " does not exist");
        std::memcpy(view.own->data() + index * packed, values.data + i * packed, packed);
    }
}

/* Copies the view's elements without gaps into view.own, where they may be changed. */
void copy_rows(size_t packed, View &view) {
    view.own = std::make_shared<std::vector<unsigned char>>(view.count * packed);
    for (size_t i = 0; i < view.count; ++i)
        std::memcpy(view.own->data() + i * packed, view.data + i * view.stride, packed);
}

} // namespace

View view_of(const tinygltf::Model &model, int index) {
    const tinygltf::Accessor &accessor = element(model.accessors, index, "accessor");
    std::string name = "accessor " + std::to_string(index);
    size_t size = component_size(accessor.componentType);
    int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    if (size == 0 || components < 1 || components > 4)
        fail(PSPLAT_ERROR_FORMAT, name + ": unknown type or component type");
    size_t packed = size * static_cast<size_t>(components);
    View view{nullptr,
              nullptr,
              accessor.count,
              packed,
              accessor.componentType,
              components,
              accessor.normalized};
    if (accessor.bufferView == -1) {
        add_zeros(model, packed, name, view);
    } else {
        Range range = range_of(model, accessor.bufferView, accessor.byteOffset, accessor.count,
                               packed, 0, name);
        view.data = range.data, view.stride = range.stride;
        if (accessor.sparse.isSparse) copy_rows(packed, view);
    }
    if (accessor.sparse.isSparse) add_sparse(model, accessor, packed, name, view);
    if (view.own) view.data = view.own->data(), view.stride = packed;
    return view;
}

double component(const View &view, size_t row, size_t column) {
    const unsigned char *at =
        view.data + row * view.stride + column * component_size(view.component_type);
    double scale = 1;
    double value = 0;
    switch (view.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        value = load<int8_t>(at), scale = 127;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        value = load<uint8_t>(at), scale = 255;
        break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        value = load<int16_t>(at), scale = 32767;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        value = load<uint16_t>(at), scale = 65535;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        value = load<uint32_t>(at), scale = 4294967295.0;
        break;
    default:
        return static_cast<double>(load<float>(at));
    }
    return view.normalized ? std::fmax(value / scale, -1.0) : value;
}

} // namespace psplat_gltf
