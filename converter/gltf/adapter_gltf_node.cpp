/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_node.cpp - the node hierarchy: triangles with the transforms of their nodes applied,
 * in double (glTF 2.0 section 3.5).
 */
#include "gltf/adapter_gltf.hpp"

#include <algorithm>
#include <cmath>

namespace psplat_gltf {
namespace {

Matrix multiply(const Matrix &a, const Matrix &b) {
    Matrix c{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row)
            for (size_t k = 0; k < 4; ++k)
                c[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
    return c;
}

/* Returns the node's matrix, or translation x rotation x scale (glTF 2.0 section 3.5.3). */
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

} // namespace

Matrix identity() {
    return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

double cofactors(const Matrix &m, std::array<double, 9> &c) {
    for (size_t column = 0; column < 3; ++column)
        for (size_t row = 0; row < 3; ++row) {
            size_t c1 = (column + 1) % 3 * 4, c2 = (column + 2) % 3 * 4;
            size_t r1 = (row + 1) % 3, r2 = (row + 2) % 3;
            c[column * 3 + row] = m[c1 + r1] * m[c2 + r2] - m[c1 + r2] * m[c2 + r1];
        }
    return m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
}

namespace {

/* Adds the meshes of a node and its children. visits counts the nodes met and bounds the work,
 * since a malformed file may give a node many parents. */
void add_node(Soup &soup, const tinygltf::Model &model, int index, const Matrix &parent,
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
    if (node.mesh >= 0) add_mesh(soup, model, element(model.meshes, node.mesh, "mesh"), global);
    for (int child : node.children) add_node(soup, model, child, global, depth + 1, visits);
}

/* Marks all nodes below one; depth bounds cycles, which add_node refuses. */
void mark_below(const tinygltf::Model &model, int index, size_t depth, std::vector<bool> &below) {
    if (depth > max_depth || index < 0 || static_cast<size_t>(index) >= below.size()) return;
    for (int child : model.nodes[static_cast<size_t>(index)].children) {
        if (child < 0 || static_cast<size_t>(child) >= below.size()) continue;
        if (below[static_cast<size_t>(child)]) continue;
        below[static_cast<size_t>(child)] = true;
        mark_below(model, child, depth + 1, below);
    }
}

/* Returns the roots of a scene that are not below others of it, as adapter_gltf_scene.cpp does. */
std::vector<int> topmost(const tinygltf::Model &model, const std::vector<int> &roots) {
    std::vector<bool> below(model.nodes.size());
    std::vector<int> top;
    for (int root : roots) mark_below(model, root, 0, below);
    for (int root : roots)
        if (root < 0 || static_cast<size_t>(root) >= below.size() ||
            !below[static_cast<size_t>(root)])
            top.push_back(root);
    return top.empty() ? roots : top; /* all are below each other: a cycle */
}

/* Returns the root nodes of the default scene; in a file without scenes, all nodes without a
 * parent. */
std::vector<int> roots_of(const tinygltf::Model &model) {
    int index = model.defaultScene < 0 ? 0 : model.defaultScene;
    if (!model.scenes.empty()) return topmost(model, element(model.scenes, index, "scene").nodes);
    std::vector<bool> is_child(model.nodes.size());
    for (const tinygltf::Node &node : model.nodes)
        for (int child : node.children)
            if (child >= 0 && static_cast<size_t>(child) < is_child.size())
                is_child[static_cast<size_t>(child)] = true;
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    return roots;
}

} // namespace

void add_scene(Soup &soup, const tinygltf::Model &model) {
    size_t visits = 0;
    for (int node : roots_of(model)) add_node(soup, model, node, identity(), 0, visits);
    /* A file without scenes and nodes is a library of meshes, which are read untransformed. */
    if (model.scenes.empty() && model.nodes.empty())
        for (const tinygltf::Mesh &mesh : model.meshes) add_mesh(soup, model, mesh, identity());
}

} // namespace psplat_gltf
