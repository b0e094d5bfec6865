/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_tinygltf.cpp - glTF and GLB through tinygltf: the triangles of the default scene, its
 * nodes' transforms applied in double. tinygltf parses and decodes; it checks few of the numbers
 * that it passes on, so every index, offset and length is checked here before it is used.
 */
#include "source.h"

#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>

namespace {

using Matrix = std::array<double, 16>; /* column-major */

constexpr size_t max_depth = 64; /* of nested JSON and of nested nodes */

/* Leaves a stage early with what psplat_fail needs; caught in psplat_mesh_read_tinygltf. */
struct Failure {
    psplat_result code;
    std::string text;
};

[[noreturn]] void fail(psplat_result code, const std::string &text) {
    throw Failure{code, text};
}

std::string named(const char *what, size_t index) {
    return std::string(what) + " " + std::to_string(index);
}

/* ---- parsing ------------------------------------------------------------------------------ */

/* tinygltf recurses into extras and extensions: bound the depth before it does. */
void check_depth(const char *text, size_t size) {
    size_t depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < size; ++i) {
        char c = text[i];
        if (in_string && c == '\\') {
            ++i;
        } else if (c == '"') {
            in_string = !in_string;
        } else if (!in_string && (c == '{' || c == '[')) {
            if (++depth > max_depth)
                fail(PSPLAT_ERROR_RANGE, named("byte", i) + ": JSON nested deeper than 64");
        } else if (!in_string && (c == '}' || c == ']') && depth > 0) {
            --depth;
        }
    }
}

uint32_t read_u32(const char *data) {
    const unsigned char *b = reinterpret_cast<const unsigned char *>(data);
    return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

/* The two headers of a GLB (glTF 2.0 section 4.4), where tinygltf's message has no place. */
void check_glb(const psplat_source &source) {
    if (source.size < 20)
        fail(PSPLAT_ERROR_FORMAT, named("byte", source.size) + ": the file ends inside its header");
    if (read_u32(source.data + 4) != 2)
        fail(PSPLAT_ERROR_UNSUPPORTED,
             "byte 4: " + named("GLB version", read_u32(source.data + 4)) + "; 2 is read");
    if (read_u32(source.data + 8) != source.size)
        fail(PSPLAT_ERROR_FORMAT, "byte 8: the header says " +
                                      std::to_string(read_u32(source.data + 8)) +
                                      " bytes, the file has " + std::to_string(source.size));
    size_t json = read_u32(source.data + 12);
    if (json > source.size - 20)
        fail(PSPLAT_ERROR_FORMAT, "byte 12: the JSON chunk is longer than the file");
    check_depth(source.data + 20, json);
}

bool ignore_image(tinygltf::Image *, const int, std::string *, std::string *, int, int,
                  const unsigned char *, int, void *) {
    return true;
}

/* Left to the reading, so that tinygltf looks nowhere but beside the source. */
bool always_exists(const std::string &, void *) {
    return true;
}

/* tinygltf's own passes the path through a shell's expansion. */
std::string same_path(const std::string &path, void *) {
    return path;
}

/* Whether a part of the path between slashes is two dots. */
bool has_parent_segment(const std::string &path) {
    return ("/" + path + "/").find("/../") != std::string::npos;
}

/* directory is where all files have to be: a downloaded model reads none of the user's. */
bool read_beside(std::vector<unsigned char> *out, std::string *message, const std::string &path,
                 void *directory) {
    char *data = nullptr;
    size_t size = 0;
    psplat_error error;
    if (has_parent_segment(path.substr(static_cast<std::string *>(directory)->size()))) {
        if (message) *message += "it leaves its directory";
        return false;
    }
    if (psplat_source_read_file(path.c_str(), &data, &size, &error)) {
        if (message) *message += error.text;
        return false;
    }
    out->assign(data, data + size);
    std::free(data);
    return true;
}

std::string one_line(std::string text) {
    for (char &c : text)
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

/* glTF 2.0 section 3.2: minor versions stay readable unless minVersion says otherwise. */
void check_version(const tinygltf::Asset &asset) {
    bool needs_more = !asset.minVersion.empty() && asset.minVersion != "2.0";
    if (asset.version.compare(0, 2, "2.") == 0 && !needs_more) return;
    fail(PSPLAT_ERROR_UNSUPPORTED,
         "asset: version " + one_line(needs_more ? asset.minVersion : asset.version).substr(0, 20) +
             "; 2.0 is read");
}

void check_extensions(const tinygltf::Model &model) {
    /* Required, but of no effect on shape; materials fall back to their core factors. */
    static const char *const known[] = {"KHR_mesh_quantization", "KHR_texture_transform",
                                        "KHR_lights_punctual",   "KHR_texture_basisu",
                                        "EXT_texture_webp",      "KHR_materials_"};
    for (const std::string &name : model.extensionsRequired) {
        bool is_known = false;
        for (const char *prefix : known)
            is_known = is_known || name.compare(0, std::strlen(prefix), prefix) == 0;
        if (!is_known)
            fail(PSPLAT_ERROR_UNSUPPORTED,
                 "extensionsRequired: " + one_line(name).substr(0, 80) + " is not supported");
    }
}

void parse(const psplat_source &source, tinygltf::Model &model) {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(ignore_image, nullptr);
    std::string path = source.file;
    size_t slash = path.rfind('/');
    std::string directory = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    loader.SetFsCallbacks({always_exists, same_path, read_beside, nullptr, &directory});
    std::string error, warning;
    unsigned int size = static_cast<unsigned int>(source.size); /* <= PSPLAT_MAX_SOURCE_BYTES */
    bool ok = false;
    if (source.format == PSPLAT_SOURCE_GLB) {
        check_glb(source);
        ok = loader.LoadBinaryFromMemory(&model, &error, &warning,
                                         reinterpret_cast<unsigned char *>(source.data), size,
                                         directory);
    } else {
        check_depth(source.data, source.size);
        ok = loader.LoadASCIIFromString(&model, &error, &warning, source.data, size, directory);
    }
    if (!ok) fail(PSPLAT_ERROR_FORMAT, error.empty() ? "tinygltf cannot read it" : one_line(error));
    check_version(model.asset);
    check_extensions(model);
}

/* ---- accessors ---------------------------------------------------------------------------- */

/* An accessor whose every element is known to lie inside its buffer. */
struct View {
    const unsigned char *data;
    size_t count, stride;
    int component_type, components;
    bool normalized;
};

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

template <typename T> const T &element(const std::vector<T> &list, int index, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= list.size())
        fail(PSPLAT_ERROR_RANGE, std::string(what) + " " + std::to_string(index) +
                                     " does not exist (" + std::to_string(list.size()) +
                                     " in the file)");
    return list[static_cast<size_t>(index)];
}

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

template <typename T> T load(const unsigned char *bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/* Component as a number, normalised as glTF 2.0 section 3.6.2.2 says. */
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

/* ---- transforms ---------------------------------------------------------------------------- */

Matrix multiply(const Matrix &a, const Matrix &b) {
    Matrix c{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row)
            for (size_t k = 0; k < 4; ++k)
                c[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
    return c;
}

Matrix identity() {
    return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

/* Translation x rotation x scale (glTF 2.0 section 3.5.3), or the node's matrix. */
Matrix local_of(const tinygltf::Node &node) {
    Matrix m = identity();
    if (node.matrix.size() == 16) {
        std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
        return m;
    }
    if (node.rotation.size() == 4) {
        double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2],
               w = node.rotation[3];
        double s = x * x + y * y + z * z + w * w;
        s = s > 0 ? 2 / s : 0;
        m = {1 - s * (y * y + z * z),
             s * (x * y + z * w),
             s * (x * z - y * w),
             0,
             s * (x * y - z * w),
             1 - s * (x * x + z * z),
             s * (y * z + x * w),
             0,
             s * (x * z + y * w),
             s * (y * z - x * w),
             1 - s * (x * x + y * y),
             0,
             0,
             0,
             0,
             1};
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        for (size_t row = 0; row < 3 && node.scale.size() == 3; ++row)
            m[axis * 4 + row] *= node.scale[axis];
        if (node.translation.size() == 3) m[12 + axis] = node.translation[axis];
    }
    return m;
}

/* Cofactors of the upper left 3 x 3, column-major: M^-T times det M, so that no division is needed
 * and a mirroring M turns normals as it turns the winding. Returns det M. */
double cofactors(const Matrix &m, std::array<double, 9> &c) {
    for (size_t column = 0; column < 3; ++column)
        for (size_t row = 0; row < 3; ++row) {
            size_t c1 = (column + 1) % 3 * 4, c2 = (column + 2) % 3 * 4;
            size_t r1 = (row + 1) % 3, r2 = (row + 2) % 3;
            c[column * 3 + row] = m[c1 + r1] * m[c2 + r2] - m[c1 + r2] * m[c2 + r1];
        }
    return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

/* ---- scene --------------------------------------------------------------------------------- */

/* The mesh under construction; arrays of corners are filled for all triangles or stay empty. */
struct Scene {
    std::vector<double> positions;
    std::vector<uint32_t> triangles;
    std::vector<float> normals, colors;
    std::vector<int> materials; /* of each triangle, -1: the default material */
    bool has_normals = false, has_colors = false;
};

bool is_drawn_as_triangles(const tinygltf::Primitive &primitive) {
    int mode = primitive.mode == -1 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
           mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

std::vector<uint32_t> indices_of(const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                                 size_t vertex_count) {
    std::vector<uint32_t> indices;
    if (primitive.indices < 0) {
        indices.resize(vertex_count);
        for (size_t i = 0; i < vertex_count; ++i) indices[i] = static_cast<uint32_t>(i);
        return indices;
    }
    View view = view_of(model, primitive.indices);
    if (view.components != 1 || view.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT ||
        view.component_type == TINYGLTF_COMPONENT_TYPE_BYTE ||
        view.component_type == TINYGLTF_COMPONENT_TYPE_SHORT)
        fail(PSPLAT_ERROR_FORMAT, named("accessor", static_cast<size_t>(primitive.indices)) +
                                      ": not a type for indices");
    view.normalized = false;
    indices.resize(view.count);
    for (size_t i = 0; i < view.count; ++i) {
        indices[i] = static_cast<uint32_t>(component(view, i, 0));
        if (indices[i] >= vertex_count)
            fail(PSPLAT_ERROR_RANGE, named("accessor", static_cast<size_t>(primitive.indices)) +
                                         ": " + named("index", i) + " is vertex " +
                                         std::to_string(indices[i]) + " of " +
                                         std::to_string(vertex_count));
    }
    return indices;
}

/* Lists, strips and fans as lists (glTF 2.0 section 3.7.2.1). */
std::vector<uint32_t> list_of(const std::vector<uint32_t> &in, int mode) {
    if (mode == TINYGLTF_MODE_TRIANGLES || mode == -1)
        return std::vector<uint32_t>(in.begin(), in.end() - static_cast<long>(in.size() % 3));
    std::vector<uint32_t> out;
    for (size_t i = 0; i + 2 < in.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
            out.insert(out.end(), {in[i + 1], in[i + 2], in[0]});
        else
            out.insert(out.end(), {in[i], in[i + 1 + i % 2], in[i + 2 - i % 2]});
    }
    return out;
}

View attribute(const tinygltf::Model &model, const tinygltf::Primitive &primitive, const char *name,
               size_t count, int least, int most) {
    View view = view_of(model, primitive.attributes.at(name));
    if ((count && view.count != count) || view.components < least || view.components > most)
        fail(PSPLAT_ERROR_FORMAT,
             std::string("attribute ") + name + ": its type or count is wrong");
    return view;
}

/* Corners are new vertices here; welding joins them again. */
void add_positions(Scene &scene, const View &view, const Matrix &m) {
    for (size_t i = 0; i < view.count; ++i) {
        double p[3] = {component(view, i, 0), component(view, i, 1), component(view, i, 2)};
        for (size_t row = 0; row < 3; ++row)
            scene.positions.push_back(m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] +
                                      m[12 + row]);
    }
}

void add_normals(Scene &scene, const View *view, const std::vector<uint32_t> &list,
                 const std::array<double, 9> &c, double sign) {
    for (uint32_t vertex : list) {
        double n[3] = {0, 0, 0}, out[3], longest = 0;
        for (size_t k = 0; k < 3 && view; ++k) n[k] = component(*view, vertex, k);
        for (size_t row = 0; row < 3; ++row) {
            out[row] = sign * (c[row] * n[0] + c[3 + row] * n[1] + c[6 + row] * n[2]);
            longest = std::fmax(longest, std::fabs(out[row]));
        }
        /* Scaled, since cofactors of a tiny node would vanish in single precision. */
        for (double value : out)
            scene.normals.push_back(longest > 0 ? static_cast<float>(value / longest) : 0.0f);
    }
}

/* Linear as stored (glTF 2.0 section 3.7.2.1); white where the primitive has none. */
void add_colors(Scene &scene, const View *view, const std::vector<uint32_t> &list) {
    for (uint32_t vertex : list)
        for (size_t k = 0; k < 4; ++k) {
            double value = 1;
            if (view && k < static_cast<size_t>(view->components))
                value = component(*view, vertex, k);
            scene.colors.push_back(std::isfinite(value)
                                       ? static_cast<float>(std::fmin(std::fmax(value, 0), 1))
                                       : 1.0f);
        }
}

void add_primitive(Scene &scene, const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                   const Matrix &m) {
    if (!is_drawn_as_triangles(primitive)) return;
    if (!primitive.attributes.count("POSITION")) return; /* glTF 2.0 3.7.2.1: nothing is drawn */
    View points = attribute(model, primitive, "POSITION", 0, 3, 3);
    std::vector<uint32_t> list =
        list_of(indices_of(model, primitive, points.count), primitive.mode);
    size_t first = scene.positions.size() / 3;
    if (first + points.count > PSPLAT_MAX_VERTICES ||
        (scene.triangles.size() + list.size()) / 3 > PSPLAT_MAX_TRIANGLES)
        fail(PSPLAT_ERROR_RANGE, "more vertices or triangles than are read");
    std::array<double, 9> c;
    bool mirrored = cofactors(m, c) < 0;
    /* Outward must stay outward (glTF 2.0 section 3.7.4). */
    for (size_t i = 0; mirrored && i + 2 < list.size(); i += 3) std::swap(list[i + 1], list[i + 2]);
    View normals{}, colors{};
    bool has_normals = primitive.attributes.count("NORMAL") != 0;
    bool has_colors = primitive.attributes.count("COLOR_0") != 0;
    if (has_normals) normals = attribute(model, primitive, "NORMAL", points.count, 3, 3);
    if (has_colors) colors = attribute(model, primitive, "COLOR_0", points.count, 3, 4);
    add_positions(scene, points, m);
    add_normals(scene, has_normals ? &normals : nullptr, list, c, mirrored ? -1 : 1);
    add_colors(scene, has_colors ? &colors : nullptr, list);
    for (uint32_t vertex : list) scene.triangles.push_back(static_cast<uint32_t>(first) + vertex);
    scene.materials.insert(scene.materials.end(), list.size() / 3, primitive.material);
    scene.has_normals = scene.has_normals || has_normals;
    scene.has_colors = scene.has_colors || has_colors;
}

/* visits counts nodes, since a malformed file may give a node many parents. */
void add_node(Scene &scene, const tinygltf::Model &model, int index, const Matrix &parent,
              size_t depth, size_t &visits) {
    const tinygltf::Node &node = element(model.nodes, index, "node");
    if (depth > max_depth || ++visits > model.nodes.size())
        fail(PSPLAT_ERROR_FORMAT, named("node", static_cast<size_t>(index)) +
                                      ": nodes are nested deeper than 64 or have two parents");
    Matrix global = multiply(parent, local_of(node));
    for (double value : global)
        if (!std::isfinite(value))
            fail(PSPLAT_ERROR_RANGE,
                 named("node", static_cast<size_t>(index)) + ": its transform is not finite");
    if (node.mesh >= 0)
        for (const auto &primitive : element(model.meshes, node.mesh, "mesh").primitives)
            add_primitive(scene, model, primitive, global);
    for (int child : node.children) add_node(scene, model, child, global, depth + 1, visits);
}

void add_scene(Scene &scene, const tinygltf::Model &model) {
    size_t visits = 0;
    if (model.scenes.empty()) {
        /* A file without scenes is a library of meshes: take them as they are. */
        for (const tinygltf::Mesh &mesh : model.meshes)
            for (const auto &primitive : mesh.primitives)
                add_primitive(scene, model, primitive, identity());
        return;
    }
    int index = model.defaultScene < 0 ? 0 : model.defaultScene;
    for (int node : element(model.scenes, index, "scene").nodes)
        add_node(scene, model, node, identity(), 0, visits);
}

/* ---- materials ----------------------------------------------------------------------------- */

float factor(double value, double low, double high) {
    return static_cast<float>(value > low ? std::fmin(value, high) : low);
}

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

/* One material: its factors as they are. Several: base colours go into the corners, the rest is the
 * first one's, seen from both sides where any of them is. */
void apply_materials(const tinygltf::Model &model, Scene &scene, psplat_mesh &mesh) {
    mesh.material = material_of(model, scene.materials.front());
    bool differ = false;
    for (int index : scene.materials) differ = differ || index != scene.materials.front();
    if (!differ) return;
    std::vector<psplat_material> materials;
    for (int index = -1; index < static_cast<int>(model.materials.size()); ++index)
        materials.push_back(material_of(model, index));
    for (size_t t = 0; t < scene.materials.size(); ++t) {
        int index = scene.materials[t];
        if (index < -1 || index >= static_cast<int>(model.materials.size()))
            element(model.materials, index, "material");
        const psplat_material &material = materials[static_cast<size_t>(index + 1)];
        if (mesh.groups) mesh.groups[t] = static_cast<uint32_t>(index + 1);
        for (size_t i = 0; i < 12; ++i) scene.colors[t * 12 + i] *= material.base_color[i % 4];
        mesh.material.double_sided = mesh.material.double_sided || material.double_sided;
    }
    for (float &value : mesh.material.base_color) value = 1;
    scene.has_colors = true;
}

psplat_result store(const tinygltf::Model &model, Scene &scene, psplat_mesh &mesh,
                    psplat_error *error) {
    if (scene.triangles.empty()) fail(PSPLAT_ERROR_NO_SPLATS, "the scene has no triangles");
    bool differ = false;
    for (int index : scene.materials) differ = differ || index != scene.materials.front();
    psplat_result result =
        psplat_mesh_allocate(&mesh, scene.positions.size() / 3, scene.triangles.size() / 3,
                             scene.has_normals, scene.has_colors || differ, differ, error);
    if (result) return result;
    apply_materials(model, scene, mesh);
    std::copy(scene.positions.begin(), scene.positions.end(), mesh.positions);
    std::copy(scene.triangles.begin(), scene.triangles.end(), mesh.triangles);
    if (mesh.corner_normals)
        std::copy(scene.normals.begin(), scene.normals.end(), mesh.corner_normals);
    if (mesh.corner_colors) std::copy(scene.colors.begin(), scene.colors.end(), mesh.corner_colors);
    return PSPLAT_OK;
}

} // namespace

psplat_result psplat_mesh_read_tinygltf(const psplat_source *source, psplat_mesh *mesh,
                                        psplat_error *error) {
    try {
        tinygltf::Model model;
        Scene scene;
        parse(*source, model);
        add_scene(scene, model);
        return store(model, scene, *mesh, error);
    } catch (const Failure &failure) {
        return psplat_fail(error, failure.code, 0, "%s: %s", source->path, failure.text.c_str());
    } catch (const std::bad_alloc &) {
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    } catch (const std::exception &exception) {
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: tinygltf: %s", source->path,
                           exception.what());
    }
}
