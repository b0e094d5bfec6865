// SPDX-License-Identifier: MIT
//
// draco_encoder.cpp - libdraco's encoder behind a C function, which draco_encoder.h documents.
#include "draco_encoder.h"

#include <draco/compression/encode.h>

#include <cstring>
#include <memory>

namespace {

void add_attribute(draco::PointCloud &mesh, const draco_attribute &from, std::uint32_t vertices) {
    static const draco::GeometryAttribute::Type kinds[] = {
        draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL,
        draco::GeometryAttribute::COLOR, draco::GeometryAttribute::TEX_COORD,
        draco::GeometryAttribute::GENERIC};
    const std::size_t stride =
        static_cast<std::size_t>(from.components) * (from.are_bytes ? 1 : sizeof(float));
    draco::GeometryAttribute attribute;
    attribute.Init(kinds[from.kind], nullptr, static_cast<std::uint8_t>(from.components),
                   from.are_bytes ? draco::DT_UINT8 : draco::DT_FLOAT32, from.are_normalized != 0,
                   static_cast<std::int64_t>(stride), 0);
    const int id = mesh.AddAttribute(attribute, true, vertices);
    for (std::uint32_t i = 0; i < vertices; ++i)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                              static_cast<const char *>(from.values) + i * stride);
}

void fill(draco::PointCloud &mesh, const draco_mesh &from) {
    const auto vertices = static_cast<std::uint32_t>(from.vertex_count);
    mesh.set_num_points(vertices);
    for (int i = 0; i < from.attribute_count; ++i)
        add_attribute(mesh, from.attributes[i], vertices);
    if (!from.has_metadata) return;
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("name", "a mesh of a test");
    mesh.AddMetadata(std::move(metadata));
}

void fill_mesh(draco::Mesh &mesh, const draco_mesh &from) {
    mesh.SetNumFaces(from.triangle_count);
    for (std::uint32_t t = 0; t < from.triangle_count; ++t) {
        draco::Mesh::Face face;
        for (std::uint32_t k = 0; k < 3; ++k)
            face[k] = draco::PointIndex(from.triangles[3 * t + k]);
        mesh.SetFace(draco::FaceIndex(t), face);
    }
    fill(mesh, from);
}

} // namespace

extern "C" std::size_t draco_encode(const draco_mesh *mesh, unsigned char *bytes,
                                    std::size_t capacity) try {
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    encoder.SetEncodingMethod(mesh->is_edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                   : draco::MESH_SEQUENTIAL_ENCODING);
    if (mesh->position_bits)
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, mesh->position_bits);
    bool ok = false;
    if (mesh->is_cloud) {
        draco::PointCloud cloud;
        fill(cloud, *mesh);
        encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
        ok = encoder.EncodePointCloudToBuffer(cloud, &buffer).ok();
    } else {
        draco::Mesh source;
        fill_mesh(source, *mesh);
        ok = encoder.EncodeMeshToBuffer(source, &buffer).ok();
    }
    if (!ok || buffer.size() > capacity) return 0;
    std::memcpy(bytes, buffer.data(), buffer.size());
    return buffer.size();
} catch (...) {
    return 0;
}
