/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf.hpp - declarations that the files of the glTF reader share.
 *
 * tinygltf parses and decodes, but checks few of the numbers that it passes on. So every index,
 * offset and length is checked here before it is used. tinygltf's headers stay inside the adapters,
 * and exceptions end in adapter_gltf.cpp.
 */
#ifndef PHONGSPLAT_GLTF_ADAPTER_GLTF_HPP
#define PHONGSPLAT_GLTF_ADAPTER_GLTF_HPP

#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "scene/scene.h"
#include "source/source_file.h"

#include <tiny_gltf.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

namespace psplat_gltf {

/* ---- failures -------------------------------------------------------------------------------- */

/* The exception of this reader: an error code and its text. */
struct Failure {
    psplat_result code;
    std::string text;
};

[[noreturn]] inline void fail(psplat_result code, const std::string &text) {
    throw Failure{code, text};
}

/* Returns text such as "node 3" for messages. */
inline std::string named(const char *what, size_t index) {
    return std::string(what) + " " + std::to_string(index);
}

/* Returns list[index]; fails where there is no such element. */
template <typename T> const T &element(const std::vector<T> &list, int index, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= list.size())
        fail(PSPLAT_ERROR_RANGE, std::string(what) + " " + std::to_string(index) +
                                     " does not exist (" + std::to_string(list.size()) +
                                     " in the file)");
    return list[static_cast<size_t>(index)];
}

/* ---- memory that C code frees: it is stored in the scene once it is allocated ---------------- */

/* Allocates a zeroed array and sets its count; an array of none is NULL. */
template <typename T> void allocate(T *&list, size_t &count, size_t wanted) {
    list = wanted ? static_cast<T *>(std::calloc(wanted, sizeof(T))) : nullptr;
    if (wanted && !list) throw std::bad_alloc();
    count = wanted;
}

/* Returns a copy of the text, or NULL where it is empty. */
inline char *text_of(const std::string &text) {
    if (text.empty()) return nullptr;
    char *copy = static_cast<char *>(std::malloc(text.size() + 1));
    if (!copy) throw std::bad_alloc();
    std::memcpy(copy, text.c_str(), text.size() + 1);
    return copy;
}

/* Copies name and extras. */
template <typename In, typename Out> void describe(const In &in, Out &out) {
    out.name = text_of(in.name);
    out.extras = text_of(in.extras_json_string);
}

/* ---- adapter_gltf_document.cpp: JSON and buffers --------------------------------------------- */

constexpr size_t max_depth = 64; /* levels of nested JSON and of nested nodes */

/* Returns the text for a message: control characters become spaces. */
std::string one_line(std::string text);

/* Parses the document and loads its buffers. Images are not decoded. Returns warnings of what
 * tinygltf leaves out of the model without a word. */
std::vector<std::string> read_document(const psplat_source &source, tinygltf::Model &model);

/* ---- adapter_gltf_json.cpp: the JSON before it is read ----------------------------------------
 */

constexpr size_t glb_header_bytes = 20; /* the headers of a GLB and of its JSON chunk */

/* Checks syntax, the members that every file needs, and the extensions that the file requires.
 * Fails with the line and column of a text, the byte of a GLB, or the name of the member. Returns
 * the warnings of read_document. */
std::vector<std::string> check_json(const char *text, size_t size, bool is_glb);

/* ---- adapter_gltf_meshopt.cpp: EXT_meshopt_compression --------------------------------------- */

/* tinygltf wants bytes for every buffer, but a compressed file may have fallback buffers without
 * any. Stores the JSON text with all of these replaced by buffers of one byte; returns whether
 * there were any. */
bool replace_fallbacks(std::string_view text, std::string &replaced);

/* Decodes all compressed buffer views, each into a new buffer of the model. */
void decompress(tinygltf::Model &model);

/* ---- adapter_gltf_draco.cpp: KHR_draco_mesh_compression -------------------------------------- */

/* tinygltf wants a buffer view for the indices of every primitive, but those of compressed ones
 * have none. Stores the JSON text without these indices; returns whether there were any. */
bool leave_out_indices(std::string_view text, std::string &replaced);

/* Decodes all compressed primitives: these get new accessors of the model. A primitive that has its
 * attributes without compression, too, in a file that does not require the extension, stays as it
 * is. */
void decode_draco(tinygltf::Model &model);

/* ---- adapter_gltf_accessor.cpp: numbers in buffers ------------------------------------------- */

/* The elements of an accessor. All of them lie inside its buffer, or in `own` if the accessor is
 * sparse or has no buffer view. */
struct View {
    std::shared_ptr<std::vector<unsigned char>> own;
    const unsigned char *data;
    size_t count, stride;
    int component_type, components;
    bool normalized;
};

/* Checks the accessor and returns its elements. */
View view_of(const tinygltf::Model &model, int accessor);

/* Returns a component as a number, normalized as glTF 2.0 section 3.6.2.2 says. */
double component(const View &view, size_t row, size_t column);

/* ---- adapter_gltf_node.cpp: the graph -------------------------------------------------------- */

using Matrix = std::array<double, 16>; /* column-major */

Matrix identity();

/* Stores the cofactors of the upper left 3 x 3, column-major, and returns its determinant. The
 * cofactor matrix is det M times the inverse transpose, which transforms normals; unlike that it
 * needs no division, and it flips normals where M mirrors, as the winding flips. */
double cofactors(const Matrix &m, std::array<double, 9> &c);

struct Soup;

/* Adds the triangles of the default scene with the transforms of its nodes applied. In a file
 * without scenes all nodes are shown, in one without nodes all meshes. */
void add_scene(Soup &soup, const tinygltf::Model &model);

/* ---- adapter_gltf_mesh.cpp: triangles -------------------------------------------------------- */

/* A triangle soup: the mesh under construction. An attribute of corners either is empty or has a
 * value for every corner so far: when a primitive is the first to have an attribute, the corners
 * before it get a neutral value. */
struct Soup {
    std::vector<double> positions;
    std::vector<uint32_t> triangles;
    std::vector<float> normals, colors, tangents; /* 3, 4 and 4 for a corner */
    std::vector<float> uvs[PSPLAT_TEXCOORDS];     /* 2 for a corner */
    std::vector<int> materials;                   /* of each triangle, -1: the default material */
    size_t infinite_uvs = 0;                      /* corners whose coordinates were no numbers */
};

bool is_drawn_as_triangles(const tinygltf::Primitive &primitive);

/* Adds the mesh's triangles, morphed by the mesh's own weights and transformed by m. */
void add_mesh(Soup &soup, const tinygltf::Model &model, const tinygltf::Mesh &mesh,
              const Matrix &m);

/* Appends the value until every one of the corners has one. */
void pad(std::vector<float> &values, size_t corners, const std::vector<float> &value);

/* Stores the soup as a mesh. With groups it allocates mesh.groups, which the caller fills, as it
 * does the materials. */
void store(const Soup &soup, bool groups, psplat_mesh &mesh);

/* ---- adapter_gltf_scene.cpp: the whole scene ------------------------------------------------- */

/* Reads nodes, cameras, lights, scenes, animations and their names and extras, and adds warnings of
 * what is dropped. */
void read_graph(const tinygltf::Model &model, psplat_scene &scene);

/* Reads each mesh raw, in its own coordinates; meshes without triangles stay empty. */
void read_meshes(const tinygltf::Model &model, psplat_scene &scene);

/* ---- adapter_gltf_animation.cpp: animations -------------------------------------------------- */

/* Reads the animations of nodes, which must have been read. What is wrong with an animation, or
 * does not move nodes, is dropped with a warning: what the file shows at rest is not harmed by
 * it. */
void read_animations(const tinygltf::Model &model, psplat_scene &scene);

/* ---- adapter_gltf_material.cpp: materials and textures --------------------------------------- */

/* Returns the factors of a material; a negative index means glTF's default material. */
psplat_material material_of(const tinygltf::Model &model, int index);

/* Reads all materials, the default material of triangles without one as the last, and the images of
 * their textures. The caller frees materials, also where this throws. */
void read_materials(const tinygltf::Model &model, psplat_source_materials &materials);

/* Returns the group of a material's triangles: its index, or one beyond the last for the default
 * material. */
inline uint32_t group_of(const tinygltf::Model &model, int material) {
    return material < 0 ? static_cast<uint32_t>(model.materials.size())
                        : static_cast<uint32_t>(material);
}

} // namespace psplat_gltf

#endif
