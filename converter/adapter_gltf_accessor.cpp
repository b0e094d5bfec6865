/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_accessor.cpp - numbers in buffers, bounds checked before anything is read.
 */
#include "adapter_gltf.hpp"

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

} // namespace

View view_of(const tinygltf::Model &model, int index) {
    const tinygltf::Accessor &accessor = element(model.accessors, index, "accessor");
    std::string name = "accessor " + std::to_string(index);
    if (accessor.sparse.isSparse)
        fail(PSPLAT_ERROR_UNSUPPORTED, name + ": sparse accessors are not supported");
    const tinygltf::BufferView &view =
        element(model.bufferViews, accessor.bufferView, (name + ": bufferView").c_str());
    const tinygltf::Buffer &buffer =
        element(model.buffers, view.buffer, (name + ": buffer").c_str());
    size_t size = component_size(accessor.componentType);
    int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    if (size == 0 || components < 1 || components > 4)
        fail(PSPLAT_ERROR_FORMAT, name + ": unknown type or component type");
    size_t packed = size * static_cast<size_t>(components);
    size_t stride = view.byteStride ? view.byteStride : packed;
    size_t total = buffer.data.size();
    if (view.byteOffset > total || view.byteLength > total - view.byteOffset)
        fail(PSPLAT_ERROR_RANGE, name + ": its bufferView ends beyond its buffer of " +
                                     std::to_string(total) + " bytes");
    if (stride < packed || stride > 252 + packed || accessor.byteOffset > view.byteLength)
        fail(PSPLAT_ERROR_RANGE, name + ": byteStride or byteOffset out of range");
    size_t room = view.byteLength - accessor.byteOffset;
    if (accessor.count == 0 || room < packed || (room - packed) / stride < accessor.count - 1)
        fail(PSPLAT_ERROR_RANGE, name + ": " + std::to_string(accessor.count) +
                                     " elements do not fit into its bufferView");
    return {buffer.data.data() + view.byteOffset + accessor.byteOffset,
            accessor.count,
            stride,
            accessor.componentType,
            components,
            accessor.normalized};
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
