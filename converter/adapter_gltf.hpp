/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.hpp - what the parts of the glTF reader share. tinygltf parses and decodes; it
 * checks few of the numbers that it passes on, so every index, offset and length is checked here
 * before it is used. Its headers stay inside the adapters, and what is thrown ends in
 * adapter_gltf.cpp.
 */
#ifndef PHONGSPLAT_ADAPTER_GLTF_HPP
#define PHONGSPLAT_ADAPTER_GLTF_HPP

#include "scenes.h"
#include "source.h"
#include "texture.h"

#include <tiny_gltf.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace psplat_gltf {

/* ---- failures: adapter_gltf.cpp catches them ------------------------------------------------- */

/* Leaves a stage early with what psplat_fail needs. */
struct Failure {
    psplat_result code;
    std::string text;
};

[[noreturn]] inline void fail(psplat_result code, const std::string &text) {
    throw Failure{code, text};
}

inline std::string named(const char *what, size_t index) {
    return std::string(what) + " " + std::to_string(index);
}

template <typename T> const T &element(const std::vector<T> &list, int index, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= list.size())
        fail(PSPLAT_ERROR_RANGE, std::string(what) + " " + std::to_string(index) +
                                     " does not exist (" + std::to_string(list.size()) +
                                     " in the file)");
    return list[static_cast<size_t>(index)];
}

/* ---- what goes to C: malloc'ed, and owned by the scene at once ------------------------------- */

/* Zeroed room for an array; NULL for none. */
template <typename T> void allocate(T *&list, size_t &count, size_t wanted) {
    list = wanted ? static_cast<T *>(std::calloc(wanted, sizeof(T))) : nullptr;
    if (wanted && !list) throw std::bad_alloc();
    count = wanted;
}

/* NULL where text is empty. */
inline char *text_of(const std::string &text) {
    if (text.empty()) return nullptr;
    char *copy = static_cast<char *>(std::malloc(text.size() + 1));
    if (!copy) throw std::bad_alloc();
    std::memcpy(copy, text.c_str(), text.size() + 1);
    return copy;
}

template <typename In, typename Out> void describe(const In &in, Out &out) {
    out.name = text_of(in.name);
    out.extras = text_of(in.extras_json_string);
}

/* ---- adapter_gltf_document.cpp: JSON and buffers --------------------------------------------- */

constexpr size_t max_depth = 64; /* of nested JSON and of nested nodes */

/* text for messages: control characters become spaces. */
std::string one_line(std::string text);

/* The whole document, its buffers loaded; images are left to who needs them. */
void read_document(const psplat_source &source, tinygltf::Model &model);

/* ---- adapter_gltf_meshopt.cpp: EXT_meshopt_compression --------------------------------------- */

/* Where the document has buffers without bytes that compression makes needless, the text with small
 * ones in their place. Returns whether it has. */
bool replace_fallbacks(const char *text, size_t size, std::string &replaced);

/* Decodes all compressed buffer views, each into a buffer of its own. */
void decompress(tinygltf::Model &model);

/* ---- adapter_gltf_accessor.cpp: numbers in buffers ------------------------------------------- */

/* An accessor whose every element is known to lie inside its buffer, or in bytes of its own where
 * it is sparse. */
struct View {
    std::shared_ptr<std::vector<unsigned char>> own;
    const unsigned char *data;
    size_t count, stride;
    int component_type, components;
    bool normalized;
};

View view_of(const tinygltf::Model &model, int accessor);

/* A component as a number, normalised as glTF 2.0 section 3.6.2.2 says. */
double component(const View &view, size_t row, size_t column);

/* ---- adapter_gltf_node.cpp: the graph -------------------------------------------------------- */

using Matrix = std::array<double, 16>; /* column-major */

Matrix identity();

/* Cofactors of the upper left 3 x 3, column-major: M^-T times det M, so that no division is needed
 * and a mirroring M turns normals as it turns the winding. Returns det M. */
double cofactors(const Matrix &m, std::array<double, 9> &c);

struct Soup;

/* The triangles of the default scene, where its nodes put them; of a file without scenes, all. */
void add_scene(Soup &soup, const tinygltf::Model &model);

/* ---- adapter_gltf_mesh.cpp: triangles -------------------------------------------------------- */

/* A mesh under construction. What lives on corners is either of all corners so far or empty: the
 * first primitive that has an attribute gives those before it the value that stands for none. */
struct Soup {
    std::vector<double> positions;
    std::vector<uint32_t> triangles;
    std::vector<float> normals, colors, tangents; /* 3, 4 and 4 a corner */
    std::vector<float> uvs[PSPLAT_TEXCOORDS];     /* 2 a corner */
    std::vector<int> materials;                   /* of each triangle, -1: the default material */
};

bool is_drawn_as_triangles(const tinygltf::Primitive &primitive);

/* The mesh's triangles where m puts them, morphed by the mesh's own weights. */
void add_mesh(Soup &soup, const tinygltf::Model &model, const tinygltf::Mesh &mesh,
              const Matrix &m);

/* Gives every corner a value, where some have none. */
void pad(std::vector<float> &values, size_t corners, const std::vector<float> &value);

/* Soup as a mesh; its materials, and the groups for which it makes room, are the caller's. */
void store(const Soup &soup, bool groups, psplat_mesh &mesh);

/* ---- adapter_gltf_scene.cpp: the file as it stands ------------------------------------------- */

/* Nodes, cameras, lights, scenes and all that they are called, and warnings of what is dropped. */
void read_graph(const tinygltf::Model &model, psplat_scene &scene);

/* Each mesh in its own coordinates, raw; those without triangles stay empty. */
void read_meshes(const tinygltf::Model &model, psplat_scene &scene);

/* ---- adapter_gltf_material.cpp: what surfaces look like -------------------------------------- */

/* Factors of a material; a negative index is the default one. */
psplat_material material_of(const tinygltf::Model &model, int index);

/* All materials, and behind them the default one of triangles that name none; the images that their
 * textures show. palette is the caller's to free, also where it fails. */
void read_palette(const tinygltf::Model &model, psplat_palette &palette);

/* The group of triangles of a material: its index, and one beyond for the default material. */
inline uint32_t group_of(const tinygltf::Model &model, int material) {
    return material < 0 ? static_cast<uint32_t>(model.materials.size())
                        : static_cast<uint32_t>(material);
}

} // namespace psplat_gltf

#endif
