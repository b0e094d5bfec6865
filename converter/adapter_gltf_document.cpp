/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_document.cpp - a glTF or GLB as tinygltf parses it, once what it does not check
 * has been: nesting, chunks, versions, required extensions, and where buffers may lie.
 */
#include "adapter_gltf.hpp"

#include <cstdlib>
#include <cstring>

namespace psplat_gltf {

std::string one_line(std::string text) {
    for (char &c : text)
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

namespace {

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
    /* tinygltf 2.7 forgets the eight bytes of the second header, and reads so far beyond the file.
     */
    size_t rest = source.size - 20 - json;
    if (rest >= 8 && read_u32(source.data + 20 + json) > rest - 8)
        fail(PSPLAT_ERROR_FORMAT,
             named("byte", 20 + json) + ": the BIN chunk is longer than the file");
}

/* Keeps the file of an image as it is; of one in a buffer view nothing, since tinygltf has not
 * checked that view. */
bool keep_image(tinygltf::Image *image, const int, std::string *, std::string *, int, int,
                const unsigned char *bytes, int size, void *) {
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
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

void append_u32(std::string &bytes, size_t value) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
}

/* The GLB with another JSON chunk. size: that of its own. */
std::string repack(const psplat_source &source, size_t size, std::string json) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const char *rest = source.data + 20 + size;
    size_t rest_size = source.size - 20 - size;
    std::string glb(source.data, 8);
    if (20 + json.size() + rest_size > PSPLAT_MAX_SOURCE_BYTES)
        fail(PSPLAT_ERROR_RANGE, "larger than a GLB can be");
    append_u32(glb, 20 + json.size() + rest_size);
    append_u32(glb, json.size());
    glb.append(source.data + 16, 4).append(json).append(rest, rest_size);
    return glb;
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
    static const char *const known[] = {"KHR_mesh_quantization",  "KHR_texture_transform",
                                        "KHR_lights_punctual",    "KHR_texture_basisu",
                                        "EXT_texture_webp",       "KHR_materials_",
                                        "EXT_meshopt_compression"};
    for (const std::string &name : model.extensionsRequired) {
        bool is_known = false;
        for (const char *prefix : known)
            is_known = is_known || name.compare(0, std::strlen(prefix), prefix) == 0;
        if (!is_known)
            fail(PSPLAT_ERROR_UNSUPPORTED,
                 "extensionsRequired: " + one_line(name).substr(0, 80) + " is not supported");
    }
}

} // namespace

void read_document(const psplat_source &source, tinygltf::Model &model) {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, nullptr);
    loader.SetStoreOriginalJSONForExtrasAndExtensions(true); /* extras are kept as they are */
    std::string path = source.file;
    size_t slash = path.rfind('/');
    std::string directory = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    loader.SetFsCallbacks({always_exists, same_path, read_beside, nullptr, &directory});
    std::string error, warning, replaced;
    bool ok = false;
    if (source.format == PSPLAT_SOURCE_GLB) {
        check_glb(source);
        size_t json = read_u32(source.data + 12);
        bool is_replaced = replace_fallbacks(source.data + 20, json, replaced);
        if (is_replaced) replaced = repack(source, json, std::move(replaced));
        ok = loader.LoadBinaryFromMemory(
            &model, &error, &warning,
            reinterpret_cast<const unsigned char *>(is_replaced ? replaced.data() : source.data),
            static_cast<unsigned int>(is_replaced ? replaced.size() : source.size), directory);
    } else {
        check_depth(source.data, source.size);
        bool is_replaced = replace_fallbacks(source.data, source.size, replaced);
        ok = loader.LoadASCIIFromString(
            &model, &error, &warning, is_replaced ? replaced.data() : source.data,
            static_cast<unsigned int>(is_replaced ? replaced.size() : source.size), directory);
    }
    if (!ok) fail(PSPLAT_ERROR_FORMAT, error.empty() ? "tinygltf cannot read it" : one_line(error));
    check_version(model.asset);
    check_extensions(model);
    decompress(model);
}

} // namespace psplat_gltf
