/* SPDX-License-Identifier: MIT
 *
 * test_tinygltf.cpp - tests that tinygltf, a reader that does not know the extension, opens each
 * uncompressed .glb of the named directories without a warning, finds points where splats are, and
 * hands on the extension's objects.
 */
#include <tiny_gltf.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

static const char extension[] = "PSPLAT_surface_splats";

static int fail(const std::string &path, const std::string &why) {
    std::fprintf(stderr, "%s: %s\n", path.c_str(), why.c_str());
    return 1;
}

static int check_splats(const std::string &path, const tinygltf::Model &model,
                        const tinygltf::Primitive &primitive) {
    const tinygltf::Value &object = primitive.extensions.at(extension);
    if (primitive.mode != TINYGLTF_MODE_POINTS) return fail(path, "splats are no points");
    if (!object.Has("version") || object.Has("positionExtent") == object.Has("stream"))
        return fail(path, "lost an object");
    size_t count = model.accessors.at((size_t)primitive.attributes.at("POSITION")).count;
    for (const auto &[name, index] : primitive.attributes)
        if (model.accessors.at((size_t)index).count != count) return fail(path, name);
    return count == 0;
}

/* tinygltf 2.7 does not know that the fallback buffer of compressed files has no bytes in the file,
 * so that compressed files are left out. */
static int is_compressed(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    return bytes.find("EXT_meshopt_compression") != std::string::npos;
}

static int check(const std::string &path) {
    tinygltf::TinyGLTF reader;
    tinygltf::Model model;
    std::string error, warning;
    if (!reader.LoadBinaryFromFile(&model, &error, &warning, path) || !error.empty())
        return fail(path, error);
    if (!warning.empty()) return fail(path, warning);
    int failed = 0, splats = 0;
    for (const tinygltf::Mesh &mesh : model.meshes)
        for (const tinygltf::Primitive &primitive : mesh.primitives)
            if (primitive.extensions.count(extension)) {
                failed += check_splats(path, model, primitive);
                ++splats;
            }
    return failed + (splats ? 0 : fail(path, "no splats"));
}

int main(int argc, char **argv) {
    int failed = 0, files = 0;
    for (int i = 1; i < argc; ++i)
        for (const auto &entry : std::filesystem::directory_iterator(argv[i]))
            if (entry.path().extension() == ".glb" && !is_compressed(entry.path()))
                failed += check(entry.path()), ++files;
    std::printf("%d files\n", files);
    return failed || !files;
}
