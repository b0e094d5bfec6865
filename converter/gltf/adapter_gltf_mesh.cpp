/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_mesh.cpp - the primitives of a glTF mesh as a triangle soup: lists, strips and fans
 * of any index type, with normals, tangents, colours and texture coordinates on their corners.
 */
#include "gltf/adapter_gltf.hpp"
#include "material/source_materials.h"
#include "mesh/mesh.h"

#include <algorithm>
#include <cmath>

namespace psplat_gltf {
namespace {

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

/* Converts a triangle list, strip or fan to a list (glTF 2.0 section 3.7.2.1). */
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

/* Returns an attribute of least to most components and count elements; 0 accepts any count. */
View attribute(const tinygltf::Model &model, int accessor, const char *name, size_t count,
               int least, int most) {
    View view = view_of(model, accessor);
    if ((count && view.count != count) || view.components < least || view.components > most)
        fail(PSPLAT_ERROR_FORMAT,
             std::string("attribute ") + name + ": its type or count is wrong");
    return view;
}

View attribute(const tinygltf::Model &model, const tinygltf::Primitive &primitive, const char *name,
               size_t count, int least, int most) {
    return attribute(model, primitive.attributes.at(name), name, count, least, most);
}

/* Adds the vertices of a primitive. Vertices at one position are welded later. */
void add_positions(Soup &soup, const View &view, const Matrix &m) {
    for (size_t i = 0; i < view.count; ++i) {
        double p[3] = {component(view, i, 0), component(view, i, 1), component(view, i, 2)};
        for (size_t row = 0; row < 3; ++row)
            soup.positions.push_back(m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] +
                                     m[12 + row]);
    }
}

/* Adds normals, transformed by the cofactors. A length of zero means that there is no normal. */
void add_normals(Soup &soup, const View &view, const std::vector<uint32_t> &list,
                 const std::array<double, 9> &c, double sign) {
    for (uint32_t vertex : list) {
        double n[3], out[3], longest = 0;
        for (size_t k = 0; k < 3; ++k) n[k] = component(view, vertex, k);
        for (size_t row = 0; row < 3; ++row) {
            out[row] = sign * (c[row] * n[0] + c[3 + row] * n[1] + c[6 + row] * n[2]);
            longest = std::fmax(longest, std::fabs(out[row]));
        }
        /* They are scaled, since cofactors of a tiny node would vanish in single precision. */
        for (double value : out)
            soup.normals.push_back(longest > 0 ? static_cast<float>(value / longest) : 0.0f);
    }
}

/* Adds tangents. They are directions in the surface, so M itself transforms them; where M mirrors,
 * the handedness w changes its sign. */
void add_tangents(Soup &soup, const View &view, const std::vector<uint32_t> &list, const Matrix &m,
                  double sign) {
    for (uint32_t vertex : list) {
        double t[3], out[3], longest = 0;
        for (size_t k = 0; k < 3; ++k) t[k] = component(view, vertex, k);
        for (size_t row = 0; row < 3; ++row) {
            out[row] = m[row] * t[0] + m[4 + row] * t[1] + m[8 + row] * t[2];
            longest = std::fmax(longest, std::fabs(out[row]));
        }
        for (double value : out)
            soup.tangents.push_back(longest > 0 ? static_cast<float>(value / longest) : 0.0f);
        soup.tangents.push_back(component(view, vertex, 3) < 0 ? static_cast<float>(-sign)
                                                               : static_cast<float>(sign));
    }
}

/* Adds colours, which are stored linear (glTF 2.0 section 3.7.2.1). */
void add_colors(Soup &soup, const View &view, const std::vector<uint32_t> &list) {
    for (uint32_t vertex : list)
        for (size_t k = 0; k < 4; ++k) {
            bool stored = k < static_cast<size_t>(view.components);
            double value = stored ? component(view, vertex, k) : 1;
            soup.colors.push_back(std::isfinite(value)
                                      ? static_cast<float>(std::fmin(std::fmax(value, 0), 1))
                                      : 1.0f);
        }
}

/* Adds texture coordinates, 0 0 where one of both is not a finite number. Returns how many corners
 * have such. */
size_t add_uvs(std::vector<float> &uvs, const View &view, const std::vector<uint32_t> &list) {
    size_t infinite = 0;
    for (uint32_t vertex : list) {
        float uv[2];
        for (size_t k = 0; k < 2; ++k) uv[k] = static_cast<float>(component(view, vertex, k));
        bool finite = std::isfinite(uv[0]) && std::isfinite(uv[1]);
        for (float value : uv) uvs.push_back(finite ? value : 0.0f);
        infinite += !finite;
    }
    return infinite;
}

/* Adds the corner attributes of a primitive; the corners before it get neutral values if they have
 * none. */
void add_corners(Soup &soup, const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                 const std::vector<uint32_t> &list, size_t vertices, const Matrix &m) {
    size_t first = soup.triangles.size();
    std::array<double, 9> c;
    double sign = cofactors(m, c) < 0 ? -1 : 1;
    if (primitive.attributes.count("NORMAL")) {
        pad(soup.normals, first, {0, 0, 0});
        add_normals(soup, attribute(model, primitive, "NORMAL", vertices, 3, 3), list, c, sign);
    }
    if (primitive.attributes.count("TANGENT")) {
        pad(soup.tangents, first, {0, 0, 0, 0});
        add_tangents(soup, attribute(model, primitive, "TANGENT", vertices, 4, 4), list, m, sign);
    }
    if (primitive.attributes.count("COLOR_0")) {
        pad(soup.colors, first, {1, 1, 1, 1});
        add_colors(soup, attribute(model, primitive, "COLOR_0", vertices, 3, 4), list);
    }
    for (size_t set = 0; set < PSPLAT_TEXCOORDS; ++set) {
        std::string name = "TEXCOORD_" + std::to_string(set);
        if (!primitive.attributes.count(name)) continue;
        pad(soup.uvs[set], first, {0, 0});
        soup.infinite_uvs +=
            add_uvs(soup.uvs[set], attribute(model, primitive, name.c_str(), vertices, 2, 2), list);
    }
}

/* Gives the new corners neutral values for attributes that their primitive lacks. */
void pad_soup(Soup &soup) {
    size_t corners = soup.triangles.size();
    if (!soup.normals.empty()) pad(soup.normals, corners, {0, 0, 0});
    if (!soup.tangents.empty()) pad(soup.tangents, corners, {0, 0, 0, 0});
    if (!soup.colors.empty()) pad(soup.colors, corners, {1, 1, 1, 1});
    for (std::vector<float> &uvs : soup.uvs)
        if (!uvs.empty()) pad(uvs, corners, {0, 0});
}

/* Moves the primitive's vertices, which are the last of the soup, by its morph targets (glTF 2.0
 * section 3.7.2.2). Normals stay those of the base shape. */
void morph(Soup &soup, const tinygltf::Model &model, const tinygltf::Primitive &primitive,
           const std::vector<double> &weights, size_t vertices, const Matrix &m) {
    size_t first = soup.positions.size() - 3 * vertices;
    for (size_t t = 0; t < primitive.targets.size() && t < weights.size(); ++t) {
        auto position = primitive.targets[t].find("POSITION");
        if (weights[t] == 0 || position == primitive.targets[t].end()) continue;
        View view = attribute(model, position->second, "POSITION of a target", vertices, 3, 3);
        for (size_t i = 0; i < vertices; ++i)
            for (size_t k = 0; k < 3; ++k)
                for (size_t row = 0; row < 3; ++row)
                    soup.positions[first + 3 * i + row] +=
                        weights[t] * m[4 * k + row] * component(view, i, k);
    }
}

void add_primitive(Soup &soup, const tinygltf::Model &model, const tinygltf::Primitive &primitive,
                   const std::vector<double> &weights, const Matrix &m) {
    if (!is_drawn_as_triangles(primitive)) return;
    if (!primitive.attributes.count("POSITION")) return; /* glTF 2.0 3.7.2.1: nothing is drawn */
    View points = attribute(model, primitive, "POSITION", 0, 3, 3);
    std::vector<uint32_t> list =
        list_of(indices_of(model, primitive, points.count), primitive.mode);
    size_t first = soup.positions.size() / 3;
    if (first + points.count > PSPLAT_MAX_VERTICES ||
        (soup.triangles.size() + list.size()) / 3 > PSPLAT_MAX_TRIANGLES)
        fail(PSPLAT_ERROR_RANGE, "more vertices or triangles than are read");
    std::array<double, 9> c;
    /* A mirroring transform flips the winding, so that the outside stays outside (glTF 2.0 section
     * 3.7.4). */
    if (cofactors(m, c) < 0)
        for (size_t i = 0; i + 2 < list.size(); i += 3) std::swap(list[i + 1], list[i + 2]);
    add_positions(soup, points, m);
    morph(soup, model, primitive, weights, points.count, m);
    add_corners(soup, model, primitive, list, points.count, m);
    for (uint32_t vertex : list) soup.triangles.push_back(static_cast<uint32_t>(first) + vertex);
    soup.materials.insert(soup.materials.end(), list.size() / 3, primitive.material);
    pad_soup(soup);
}

void copy_floats(const std::vector<float> &from, float *to) {
    if (to) std::copy(from.begin(), from.end(), to);
}

} // namespace

bool is_drawn_as_triangles(const tinygltf::Primitive &primitive) {
    int mode = primitive.mode == -1 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    return mode == TINYGLTF_MODE_TRIANGLES || mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
           mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

void pad(std::vector<float> &values, size_t corners, const std::vector<float> &value) {
    while (values.size() < corners * value.size())
        values.insert(values.end(), value.begin(), value.end());
}

void add_mesh(Soup &soup, const tinygltf::Model &model, const tinygltf::Mesh &mesh,
              const Matrix &m) {
    for (const tinygltf::Primitive &primitive : mesh.primitives)
        add_primitive(soup, model, primitive, mesh.weights, m);
}

void store(const Soup &soup, bool groups, psplat_mesh &mesh) {
    unsigned parts = groups ? PSPLAT_MESH_GROUPS : 0;
    if (!soup.normals.empty()) parts |= PSPLAT_MESH_NORMALS;
    if (!soup.tangents.empty()) parts |= PSPLAT_MESH_TANGENTS;
    if (!soup.colors.empty()) parts |= PSPLAT_MESH_COLORS;
    for (unsigned set = 0; set < PSPLAT_TEXCOORDS; ++set)
        if (!soup.uvs[set].empty()) parts |= PSPLAT_MESH_UVS << set;
    psplat_error error;
    psplat_result result = psplat_mesh_allocate(&mesh, soup.positions.size() / 3,
                                                soup.triangles.size() / 3, parts, &error);
    if (result) fail(result, error.text);
    std::copy(soup.positions.begin(), soup.positions.end(), mesh.positions);
    std::copy(soup.triangles.begin(), soup.triangles.end(), mesh.triangles);
    copy_floats(soup.normals, mesh.corner_normals);
    copy_floats(soup.tangents, mesh.corner_tangents);
    copy_floats(soup.colors, mesh.corner_colors);
    for (size_t set = 0; set < PSPLAT_TEXCOORDS; ++set)
        copy_floats(soup.uvs[set], mesh.corner_uvs[set]);
}

} // namespace psplat_gltf
