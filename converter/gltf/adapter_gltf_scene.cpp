/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_scene.cpp - the scene graph of a glTF file: scenes, nodes, cameras, lights, names
 * and extras, with every index checked.
 */
#include "gltf/adapter_gltf.hpp"
#include "mesh/mesh.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>

namespace psplat_gltf {
namespace {

/* Converts an index of tinygltf, where -1 means none, and fails where it is out of range. */
uint32_t checked(int index, size_t count, const std::string &where) {
    if (index == -1) return PSPLAT_NO_INDEX;
    if (index < 0 || static_cast<size_t>(index) >= count)
        fail(PSPLAT_ERROR_RANGE, where + " " + std::to_string(index) + " does not exist (" +
                                     std::to_string(count) + " in the file)");
    return static_cast<uint32_t>(index);
}

/* ---- nodes --------------------------------------------------------------------------------- */

/* Returns the node's light, -1 where it has none, or -2 where its index is no index. */
int light_of(const tinygltf::Node &node) {
    auto extension = node.extensions.find("KHR_lights_punctual");
    if (extension == node.extensions.end() || !extension->second.Has("light")) return -1;
    const tinygltf::Value &light = extension->second.Get("light");
    return light.IsInt() && light.GetNumberAsInt() >= 0 ? light.GetNumberAsInt() : -2;
}

/* Reads the transform (glTF 2.0 section 3.5.3). Rotations become unit quaternions; the projective
 * row of a matrix is dropped. */
void read_transform(const tinygltf::Node &in, psplat_scene_node &out) {
    std::fill(out.scale, out.scale + 3, 1.0);
    out.rotation[3] = 1;
    out.has_matrix = in.matrix.size() == 16;
    if (out.has_matrix) {
        std::copy(in.matrix.begin(), in.matrix.end(), out.matrix);
        for (size_t column = 0; column < 4; ++column) out.matrix[4 * column + 3] = column == 3;
        return;
    }
    if (in.translation.size() == 3)
        std::copy(in.translation.begin(), in.translation.end(), out.translation);
    if (in.scale.size() == 3) std::copy(in.scale.begin(), in.scale.end(), out.scale);
    if (in.rotation.size() != 4) return;
    double length = 0;
    for (double value : in.rotation) length = std::hypot(length, value);
    for (size_t k = 0; k < 4 && length > 0; ++k)
        out.rotation[k] = std::fabs(length - 1) > 1e-9 ? in.rotation[k] / length : in.rotation[k];
}

void read_node(const tinygltf::Model &model, const tinygltf::Node &in, const std::string &name,
               psplat_scene_node &out) {
    describe(in, out);
    read_transform(in, out);
    out.mesh = checked(in.mesh, model.meshes.size(), name + ": mesh");
    out.camera = checked(in.camera, model.cameras.size(), name + ": camera");
    out.light = checked(light_of(in), model.lights.size(), name + ": light");
    allocate(out.children, out.child_count, in.children.size());
    for (size_t i = 0; i < in.children.size(); ++i) {
        if (in.children[i] < 0) fail(PSPLAT_ERROR_RANGE, name + ": a child is negative");
        out.children[i] = checked(in.children[i], model.nodes.size(), name + ": child");
    }
}

/* Returns the parent of each node. A node may have only one (glTF 2.0 section 3.5.2). */
std::vector<uint32_t> parents_of(const psplat_scene &scene) {
    std::vector<uint32_t> parents(scene.node_count, PSPLAT_NO_INDEX);
    for (size_t i = 0; i < scene.node_count; ++i)
        for (size_t k = 0; k < scene.nodes[i].child_count; ++k) {
            uint32_t child = scene.nodes[i].children[k];
            if (parents[child] != PSPLAT_NO_INDEX)
                fail(PSPLAT_ERROR_FORMAT, named("node", child) + ": is a child twice");
            parents[child] = static_cast<uint32_t>(i);
        }
    return parents;
}

/* Bounds the depth of nodes, so that later code may recurse. This finds cycles as well. */
void check_nesting(const std::vector<uint32_t> &parents) {
    for (size_t i = 0; i < parents.size(); ++i) {
        size_t depth = 1;
        for (uint32_t at = parents[i]; at != PSPLAT_NO_INDEX; at = parents[at])
            if (++depth > max_depth)
                fail(PSPLAT_ERROR_FORMAT,
                     named("node", i) + ": nested deeper than 64, or its own ancestor");
    }
}

/* ---- cameras, lights, scenes --------------------------------------------------------------- */

void read_camera(const tinygltf::Camera &in, psplat_scene_camera &out) {
    describe(in, out);
    out.is_orthographic = in.type == "orthographic";
    if (out.is_orthographic) {
        out.xmag = in.orthographic.xmag, out.ymag = in.orthographic.ymag;
        out.znear = in.orthographic.znear, out.zfar = in.orthographic.zfar;
    } else {
        out.aspect_ratio = in.perspective.aspectRatio, out.yfov = in.perspective.yfov;
        out.znear = in.perspective.znear, out.zfar = in.perspective.zfar;
    }
}

void read_light(const tinygltf::Light &in, const std::string &name, psplat_scene_light &out) {
    static const char *const types[] = {"directional", "point", "spot"};
    size_t type = 0;
    while (type < 3 && in.type != types[type]) ++type;
    if (type == 3)
        fail(PSPLAT_ERROR_FORMAT, name + ": type is '" + one_line(in.type).substr(0, 20) +
                                      "' instead of directional, point or spot");
    describe(in, out);
    out.type = static_cast<psplat_scene_light_type>(type);
    for (size_t k = 0; k < 3; ++k) out.color[k] = in.color.size() == 3 ? in.color[k] : 1;
    out.intensity = in.intensity;
    out.range = in.range;
    out.inner_cone = in.spot.innerConeAngle;
    out.outer_cone = in.spot.outerConeAngle;
}

void read_view(const tinygltf::Model &model, const tinygltf::Scene &in, const std::string &name,
               psplat_scene_view &out) {
    describe(in, out);
    allocate(out.roots, out.root_count, in.nodes.size());
    std::vector<bool> seen(model.nodes.size());
    for (size_t i = 0; i < in.nodes.size(); ++i) {
        if (in.nodes[i] < 0) fail(PSPLAT_ERROR_RANGE, name + ": a node is negative");
        uint32_t root = checked(in.nodes[i], model.nodes.size(), name + ": node");
        if (seen[root])
            fail(PSPLAT_ERROR_FORMAT, name + ": " + named("node", root) + " is in it twice");
        seen[root] = true;
        out.roots[i] = root;
    }
}

/* ---- roots that have a parent ---------------------------------------------------------------- */

std::vector<bool> roots_of(const psplat_scene &scene, const psplat_scene_view &view) {
    std::vector<bool> is_root(scene.node_count);
    for (size_t i = 0; i < view.root_count; ++i) is_root[view.roots[i]] = true;
    return is_root;
}

/* Returns whether a node is shown through an ancestor that is a root as well. */
bool has_root_above(uint32_t node, const std::vector<bool> &is_root,
                    const std::vector<uint32_t> &parents) {
    for (uint32_t at = parents[node]; at != PSPLAT_NO_INDEX; at = parents[at])
        if (is_root[at]) return true;
    return false;
}

void detach(psplat_scene &scene, uint32_t node, std::vector<uint32_t> &parents) {
    psplat_scene_node &parent = scene.nodes[parents[node]];
    uint32_t *end = std::remove(parent.children, parent.children + parent.child_count, node);
    parent.child_count = static_cast<size_t>(end - parent.children);
    parents[node] = PSPLAT_NO_INDEX;
}

/* Detaches roots whose parent their scene does not show, so that they keep only their own
 * transform. */
void detach_roots(psplat_scene &scene, size_t index, std::vector<uint32_t> &parents) {
    const psplat_scene_view &view = scene.scenes[index];
    const std::vector<bool> is_root = roots_of(scene, view);
    for (size_t i = 0; i < view.root_count; ++i) {
        uint32_t root = view.roots[i], parent = parents[root];
        if (parent == PSPLAT_NO_INDEX || has_root_above(root, is_root, parents)) continue;
        detach(scene, root, parents);
        psplat_scene_warn(
            &scene,
            "scene %zu has node %u as a root, a child of node %u: the node leaves its "
            "parent",
            index, root, parent);
    }
}

/* Drops roots that the scene shows below their parents anyway, so that nothing is shown twice. */
void drop_roots(psplat_scene &scene, size_t index, const std::vector<uint32_t> &parents) {
    psplat_scene_view &view = scene.scenes[index];
    const std::vector<bool> is_root = roots_of(scene, view);
    uint32_t *end = std::remove_if(view.roots, view.roots + view.root_count, [&](uint32_t root) {
        return has_root_above(root, is_root, parents);
    });
    size_t left = static_cast<size_t>(end - view.roots);
    if (left < view.root_count)
        psplat_scene_warn(&scene,
                          "%zu roots of scene %zu are children of nodes that it shows: they are "
                          "shown once, below their parents",
                          view.root_count - left, index);
    view.root_count = left;
}

/* A root has no parent (glTF 2.0 section 3.5.1), but some files list every node as one. All scenes
 * are rid of parents before any root is dropped, so that no node is lost. */
void settle_roots(psplat_scene &scene, std::vector<uint32_t> &parents) {
    bool any = false;
    for (size_t i = 0; i < scene.scene_count; ++i)
        for (size_t k = 0; k < scene.scenes[i].root_count; ++k)
            any |= parents[scene.scenes[i].roots[k]] != PSPLAT_NO_INDEX;
    if (!any) return;
    for (size_t i = 0; i < scene.scene_count; ++i) detach_roots(scene, i, parents);
    for (size_t i = 0; i < scene.scene_count; ++i) drop_roots(scene, i, parents);
}

/* ---- warnings ------------------------------------------------------------------------------ */

const char specular_glossiness[] = "KHR_materials_pbrSpecularGlossiness";

/* Warns where a texture of specular colours and glossiness becomes factors. */
void warn_of_specular_textures(const tinygltf::Model &model, psplat_scene &scene) {
    size_t count = 0;
    for (const tinygltf::Material &material : model.materials) {
        auto found = material.extensions.find(specular_glossiness);
        count += found != material.extensions.end() && found->second.IsObject() &&
                 found->second.Has("specularGlossinessTexture");
    }
    if (count)
        psplat_scene_warn(
            &scene,
            "the specular textures of %zu materials become their mean: 'gltf-transform "
            "metalrough' keeps them",
            count);
}

void warn_of_extensions(const tinygltf::Model &model, psplat_scene &scene) {
    static const char *const converted[] = {
        "KHR_draco_mesh_compression", "KHR_lights_punctual",   "KHR_materials_emissive_strength",
        "KHR_materials_unlit",        "KHR_mesh_quantization", "KHR_texture_transform",
        "EXT_meshopt_compression",    specular_glossiness};
    for (const std::string &name : model.extensionsUsed) {
        bool known = std::any_of(std::begin(converted), std::end(converted),
                                 [&](const char *one) { return name == one; });
        if (!known)
            psplat_scene_warn(&scene, "extension %s is not converted: what it says is dropped",
                              one_line(name).substr(0, 80).c_str());
    }
    warn_of_specular_textures(model, scene);
}

void warn_of_meshes(const tinygltf::Model &model, psplat_scene &scene) {
    size_t others = 0, morphed = 0, described = 0;
    for (const tinygltf::Mesh &mesh : model.meshes)
        for (const tinygltf::Primitive &primitive : mesh.primitives) {
            others += !is_drawn_as_triangles(primitive);
            morphed += !primitive.targets.empty();
            described += !primitive.extras_json_string.empty();
        }
    if (others)
        psplat_scene_warn(&scene,
                          "%zu primitives of points or lines are dropped: splats are made "
                          "of triangles",
                          others);
    if (morphed)
        psplat_scene_warn(&scene,
                          "morph targets are dropped: %zu primitives keep the shape that "
                          "their mesh's own weights give",
                          morphed);
    if (described)
        psplat_scene_warn(&scene,
                          "extras of %zu primitives are dropped: splats make primitives of "
                          "their own",
                          described);
}

void warn_of_dropped(const tinygltf::Model &model, psplat_scene &scene) {
    if (!model.skins.empty())
        psplat_scene_warn(&scene,
                          "%zu skins are dropped: meshes keep the shape that they were "
                          "bound in",
                          model.skins.size());
    warn_of_meshes(model, scene);
    warn_of_extensions(model, scene);
}

} // namespace

void read_graph(const tinygltf::Model &model, psplat_scene &scene) {
    allocate(scene.nodes, scene.node_count, model.nodes.size());
    for (size_t i = 0; i < model.nodes.size(); ++i)
        read_node(model, model.nodes[i], named("node", i), scene.nodes[i]);
    std::vector<uint32_t> parents = parents_of(scene);
    check_nesting(parents);
    allocate(scene.cameras, scene.camera_count, model.cameras.size());
    for (size_t i = 0; i < model.cameras.size(); ++i)
        read_camera(model.cameras[i], scene.cameras[i]);
    allocate(scene.lights, scene.light_count, model.lights.size());
    for (size_t i = 0; i < model.lights.size(); ++i)
        read_light(model.lights[i], named("light", i), scene.lights[i]);
    allocate(scene.scenes, scene.scene_count, model.scenes.size());
    for (size_t i = 0; i < model.scenes.size(); ++i)
        read_view(model, model.scenes[i], named("scene", i), scene.scenes[i]);
    settle_roots(scene, parents);
    scene.default_scene = checked(model.defaultScene, model.scenes.size(), "scene");
    scene.copyright = text_of(model.asset.copyright);
    scene.asset_extras = text_of(model.asset.extras_json_string);
    /* tinygltf stores the text null where the root has no extras. */
    if (model.extras_json_string != "null") scene.extras = text_of(model.extras_json_string);
    read_animations(model, scene);
    warn_of_dropped(model, scene);
}

void read_meshes(const tinygltf::Model &model, psplat_scene &scene) {
    size_t infinite = 0;
    allocate(scene.meshes, scene.mesh_count, model.meshes.size());
    for (size_t i = 0; i < model.meshes.size(); ++i) {
        Soup soup;
        add_mesh(soup, model, model.meshes[i], identity());
        describe(model.meshes[i], scene.meshes[i]);
        if (soup.triangles.empty()) continue;
        psplat_mesh &mesh = scene.meshes[i].mesh;
        store(soup, true, mesh);
        infinite += soup.infinite_uvs;
        for (size_t t = 0; t < mesh.triangle_count; ++t) {
            if (soup.materials[t] != -1) element(model.materials, soup.materials[t], "material");
            mesh.groups[t] = group_of(model, soup.materials[t]);
        }
        mesh.material = material_of(model, -1); /* replaced by the triangles' materials */
    }
    if (infinite)
        psplat_scene_warn(&scene, "%zu texture coordinates are no numbers: they count as 0",
                          infinite);
}

} // namespace psplat_gltf
