/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_openmesh.cpp - the reader of OBJ, PLY, OFF and STL files, through OpenMesh.
 *
 * OpenMesh's file readers call a BaseImporter. OpenMesh's own importer builds a halfedge structure,
 * which refuses faces at non-manifold edges. The one here only collects vertices and faces, so no
 * face is lost, and it keeps the normals of each face's corners apart. The readers are global
 * objects, so only one thread may use them at a time.
 */
#include "import/openmesh.h"

#include "base/polygon.h"
#include "material/mipmap.h"
#include "mesh/mesh.h"
#include "points/points.h"
#include "source/obj_faces.h"
#include "source/source_file.h"

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <istream>
#include <new>
#include <streambuf>
#include <vector>

namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::Vec2f;
using OpenMesh::Vec3d;
using OpenMesh::Vec3f;
using OpenMesh::Vec3uc;
using OpenMesh::Vec4f;
using OpenMesh::Vec4uc;
using OpenMesh::VertexHandle;

/* The importer that collects vertices and polygons. With normals_per_face the normals set since the
 * last face belong to the corners of the next face only, as OBJReader sends them. */
class Collector : public OpenMesh::IO::BaseImporter {
  public:
    std::vector<Vec3f> points;
    std::vector<Vec3f> vertex_normals;
    std::vector<Vec4f> vertex_colors;
    std::vector<size_t> face_ends; /* one past each face's last element of corners */
    std::vector<uint32_t> corners;
    std::vector<Vec3f> corner_normals;
    bool has_normals = false;
    bool has_colors = false;

    explicit Collector(bool normals_per_face) : normals_per_face_(normals_per_face) {
    }

    VertexHandle add_vertex(const Vec3f &point) override {
        points.push_back(point);
        vertex_normals.emplace_back(0.0f, 0.0f, 0.0f);
        vertex_colors.emplace_back(1.0f, 1.0f, 1.0f, 1.0f);
        return VertexHandle(static_cast<int>(points.size()) - 1);
    }
    VertexHandle add_vertex() override {
        return add_vertex(Vec3f(0.0f, 0.0f, 0.0f));
    }
    FaceHandle add_face(const VHandles &handles) override {
        for (VertexHandle handle : handles) {
            size_t vertex = index(handle);
            corners.push_back(static_cast<uint32_t>(vertex));
            corner_normals.push_back(vertex_normals.at(vertex));
            if (normals_per_face_) vertex_normals[vertex] = Vec3f(0.0f, 0.0f, 0.0f);
        }
        face_ends.push_back(corners.size());
        return FaceHandle(static_cast<int>(face_ends.size()) - 1);
    }
    void set_point(VertexHandle vertex, const Vec3f &point) override {
        points.at(index(vertex)) = point;
    }
    void set_normal(VertexHandle vertex, const Vec3f &normal) override {
        vertex_normals.at(index(vertex)) = normal;
        has_normals = true;
    }
    void set_normal(VertexHandle vertex, const Vec3d &normal) override {
        set_normal(vertex, Vec3f(normal));
    }
    void set_color(VertexHandle vertex, const Vec3uc &color) override {
        set_color(vertex, Vec4uc(color[0], color[1], color[2], 255));
    }
    void set_color(VertexHandle vertex, const Vec4uc &color) override {
        set_color(vertex, Vec4f(color) / 255.0f);
    }
    void set_color(VertexHandle vertex, const Vec3f &color) override {
        set_color(vertex, Vec4f(color[0], color[1], color[2], 1.0f));
    }
    void set_color(VertexHandle vertex, const Vec4f &color) override {
        vertex_colors.at(index(vertex)) = color;
        has_colors = true;
    }
    size_t n_vertices() const override {
        return points.size();
    }
    size_t n_faces() const override {
        return face_ends.size();
    }
    size_t n_edges() const override {
        return 0;
    }

    /* These are called by readers of other formats or deliver data that is not used. */
    HalfedgeHandle add_edge(VertexHandle, VertexHandle) override {
        return HalfedgeHandle();
    }
    FaceHandle add_face(HalfedgeHandle) override {
        return FaceHandle();
    }
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec2f> &) override {
    }
    void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec3f> &) override {
    }
    void set_face_texindex(FaceHandle, int) override {
    }
    void set_halfedge(VertexHandle, HalfedgeHandle) override {
    }
    void set_texcoord(VertexHandle, const Vec2f &) override {
    }
    void set_texcoord(HalfedgeHandle, const Vec2f &) override {
    }
    void set_texcoord(VertexHandle, const Vec3f &) override {
    }
    void set_texcoord(HalfedgeHandle, const Vec3f &) override {
    }
    void set_status(VertexHandle, const OpenMesh::Attributes::StatusInfo &) override {
    }
    void set_status(HalfedgeHandle, const OpenMesh::Attributes::StatusInfo &) override {
    }
    void set_status(EdgeHandle, const OpenMesh::Attributes::StatusInfo &) override {
    }
    void set_status(FaceHandle, const OpenMesh::Attributes::StatusInfo &) override {
    }
    void set_next(HalfedgeHandle, HalfedgeHandle) override {
    }
    void set_face(HalfedgeHandle, FaceHandle) override {
    }
    void request_face_texcoords2D() override {
    }
    void set_color(EdgeHandle, const Vec3uc &) override {
    }
    void set_color(EdgeHandle, const Vec4uc &) override {
    }
    void set_color(EdgeHandle, const Vec3f &) override {
    }
    void set_color(EdgeHandle, const Vec4f &) override {
    }
    void set_normal(FaceHandle, const Vec3f &) override {
    }
    void set_normal(FaceHandle, const Vec3d &) override {
    }
    void set_color(FaceHandle, const Vec3uc &) override {
    }
    void set_color(FaceHandle, const Vec4uc &) override {
    }
    void set_color(FaceHandle, const Vec3f &) override {
    }
    void set_color(FaceHandle, const Vec4f &) override {
    }
    void add_texture_information(int, std::string) override {
    }

  private:
    bool normals_per_face_;

    static size_t index(VertexHandle handle) {
        return static_cast<size_t>(handle.idx()); /* negative becomes huge, and at() throws */
    }
};

/* A stream buffer that reads from memory without a copy. */
class MemoryBuffer : public std::streambuf {
  public:
    MemoryBuffer(char *data, size_t size) {
        setg(data, data, data + size);
    }

  protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir from,
                     std::ios_base::openmode) override {
        off_type base = from == std::ios_base::beg   ? 0
                        : from == std::ios_base::cur ? gptr() - eback()
                                                     : egptr() - eback();
        return seekpos(pos_type(base + offset), std::ios_base::in);
    }
    pos_type seekpos(pos_type position, std::ios_base::openmode) override {
        off_type offset = position;
        if (offset < 0 || offset > egptr() - eback()) return pos_type(off_type(-1));
        setg(eback(), eback() + offset, egptr());
        return position;
    }
};

/* Switches off OpenMesh's messages to std::cerr while it lives: errors are reported by
 * psplat_error. */
class MessagesOff {
  public:
    MessagesOff()
        : log_(omlog().is_enabled()), out_(omout().is_enabled()), err_(omerr().is_enabled()) {
        omlog().disable();
        omout().disable();
        omerr().disable();
    }
    ~MessagesOff() {
        if (log_) omlog().enable();
        if (out_) omout().enable();
        if (err_) omerr().enable();
    }

  private:
    bool log_, out_, err_;
};

bool parse(const psplat_source &source, Collector &collector) {
    using OpenMesh::IO::Options;
    MessagesOff silence;
    MemoryBuffer buffer(source.data, source.size);
    std::istream stream(&buffer);
    Options options(Options::VertexNormal);
    if (source.has_colors) options += Options::VertexColor;
    switch (source.format) {
    case PSPLAT_SOURCE_OBJ:
        return OpenMesh::IO::OBJReader().read(stream, collector, options);
    case PSPLAT_SOURCE_OFF: /* rewritten as PLY by check_off.c */
    case PSPLAT_SOURCE_PLY:
        return OpenMesh::IO::PLYReader().read(stream, collector, options);
    case PSPLAT_SOURCE_STL_BINARY:
        options += Options::Binary; /* fall through */
    default:
        return OpenMesh::IO::STLReader().read(stream, collector, options);
    }
}

/* Colours of these formats are sRGB; splats keep them linear. */
float linear_of_srgb(float value) {
    if (!(value > 0.0f)) return 0.0f;
    if (value >= 1.0f) return 1.0f;
    return psplat_linear_of_srgb(value);
}

void store_color(const Vec4f &color, float *linear) {
    for (size_t k = 0; k < 3; ++k) linear[k] = linear_of_srgb(color[k]);
    linear[3] = std::fmin(std::fmax(color[3], 0.0f), 1.0f);
}

void store_corner(const Collector &collector, size_t corner, psplat_mesh &mesh, size_t target) {
    uint32_t vertex = collector.corners[corner];
    mesh.triangles[target] = vertex;
    if (mesh.corner_normals)
        for (size_t k = 0; k < 3; ++k)
            mesh.corner_normals[target * 3 + k] = collector.corner_normals[corner][k];
    if (mesh.corner_colors)
        store_color(collector.vertex_colors[vertex], mesh.corner_colors + target * 4);
}

void store_positions(const Collector &collector, const psplat_source &source, psplat_mesh &mesh) {
    for (size_t i = 0; i < collector.points.size(); ++i)
        for (size_t k = 0; k < 3; ++k)
            mesh.positions[i * 3 + k] = source.positions
                                            ? source.positions[i * 3 + k]
                                            : static_cast<double>(collector.points[i][k]);
}

/* Stores texture coordinates and group of a corner; check_obj.c has kept them in this order. */
void store_extras(const psplat_obj_faces &obj, size_t face, size_t corner, psplat_mesh &mesh,
                  size_t target) {
    if (mesh.corner_uvs[0]) psplat_obj_uv(&obj, corner, mesh.corner_uvs[0] + 2 * target);
    if (mesh.groups)
        mesh.groups[target / 3] = std::min(obj.groups[face], static_cast<uint32_t>(obj.name_count));
}

psplat_result store_faces(const Collector &collector, const psplat_source &source,
                          psplat_mesh &mesh, psplat_error *error) {
    std::vector<double> outline;
    std::vector<uint32_t> split;
    size_t begin = 0, target = 0, face = 0;
    for (size_t end : collector.face_ends) {
        size_t count = end - begin;
        outline.clear();
        for (size_t corner = begin; corner < end; ++corner) {
            const double *point = mesh.positions + size_t(collector.corners[corner]) * 3;
            outline.insert(outline.end(), point, point + 3);
        }
        split.resize((count - 2) * 3);
        psplat_result result =
            psplat_polygon_triangulate(outline.data(), count, split.data(), error);
        if (result) return result;
        for (uint32_t corner : split) {
            store_extras(source.obj, face, begin + corner, mesh, target);
            store_corner(collector, begin + corner, mesh, target++);
        }
        begin = end;
        ++face;
    }
    return PSPLAT_OK;
}

psplat_result store(const Collector &collector, const psplat_source &source, psplat_mesh &mesh,
                    psplat_error *error) {
    size_t faces = collector.face_ends.size();
    bool is_stl = !source.positions; /* only there OpenMesh drops faces and welds vertices */
    if (is_stl ? faces > source.faces
               : faces != source.faces || collector.points.size() != source.vertices)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "%s: OpenMesh understood %zu of %zu faces and %zu of %zu vertices",
                           source.path, faces, source.faces, collector.points.size(),
                           source.vertices);
    const psplat_obj_faces &obj = source.obj;
    if (obj.corner_count && obj.corner_count != collector.corners.size())
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "%s: OpenMesh understood %zu of %zu corners", source.path,
                           collector.corners.size(), obj.corner_count);
    unsigned parts = (collector.has_normals ? PSPLAT_MESH_NORMALS : 0u) |
                     (collector.has_colors ? PSPLAT_MESH_COLORS : 0u);
    if (obj.library && obj.name_count) /* groups and uvs are useless without materials */
        parts |= PSPLAT_MESH_GROUPS | (obj.texcoord_count ? PSPLAT_MESH_UVS : 0u);
    psplat_result result = psplat_mesh_allocate(&mesh, collector.points.size(),
                                                collector.corners.size() - 2 * faces, parts, error);
    if (result) return result;
    mesh.dropped = source.dropped + source.faces - faces;
    store_positions(collector, source, mesh);
    return store_faces(collector, source, mesh, error);
}

float *float_array(size_t count) {
    auto *values = static_cast<float *>(std::malloc((count + 1) * sizeof(float)));
    if (!values) throw std::bad_alloc();
    return values;
}

/* Stores a point set; the caller frees it, also where this throws. */
void store_points(const Collector &collector, const psplat_source &source, psplat_points &points) {
    size_t count = points.count = source.vertices;
    points.positions = static_cast<double *>(std::malloc((3 * count + 1) * sizeof(double)));
    if (!points.positions) throw std::bad_alloc();
    std::copy(source.positions, source.positions + 3 * count, points.positions);
    if (collector.has_normals) {
        points.normals = float_array(3 * count);
        for (size_t i = 0; i < 3 * count; ++i)
            points.normals[i] = collector.vertex_normals[i / 3][i % 3];
    }
    if (collector.has_colors) {
        points.colors = float_array(4 * count);
        for (size_t i = 0; i < count; ++i)
            store_color(collector.vertex_colors[i], points.colors + 4 * i);
    }
}

/* Calls read() and turns exceptions into error codes. */
template <typename Read>
psplat_result catch_errors(const psplat_source &source, psplat_error *error, Read read) {
    try {
        return read();
    } catch (const std::bad_alloc &) {
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source.path);
    } catch (const std::exception &exception) {
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: OpenMesh: %s", source.path,
                           exception.what());
    }
}

} // namespace

psplat_result psplat_points_read_openmesh(const psplat_source *source, psplat_points *points,
                                          psplat_error *error) {
    return catch_errors(*source, error, [&] {
        Collector collector(false);
        if (!parse(*source, collector) || collector.points.size() != source->vertices)
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: OpenMesh cannot read it",
                               source->path);
        store_points(collector, *source, *points);
        return PSPLAT_OK;
    });
}

psplat_result psplat_mesh_read_openmesh(const psplat_source *source, psplat_mesh *mesh,
                                        psplat_error *error) {
    return catch_errors(*source, error, [&] {
        Collector collector(source->format == PSPLAT_SOURCE_OBJ);
        if (!parse(*source, collector))
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: OpenMesh cannot read it",
                               source->path);
        return store(collector, *source, *mesh, error);
    });
}
