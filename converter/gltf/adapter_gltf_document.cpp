/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_document.cpp - the JSON document and buffers of a glTF or GLB, parsed by tinygltf.
 * Checked here, because tinygltf does not: nesting, chunks, versions, and that buffers lie beside
 * the file. adapter_gltf_json.cpp checks the JSON itself.
 */
#include "base/file_bytes.h"
#include "gltf/adapter_gltf.hpp"
#include "source/source_file.h"

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

/* Bounds the depth of the JSON, since tinygltf recurses into extras and extensions. base is where
 * the text begins in the file. */
void check_depth(const char *text, size_t size, size_t base) {
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
                fail(PSPLAT_ERROR_RANGE, named("byte", base + i) + ": JSON nested deeper than 64");
        } else if (!in_string && (c == '}' || c == ']') && depth > 0) {
            --depth;
        }
    }
}

uint32_t read_u32(const char *data) {
    const unsigned char *b = reinterpret_cast<const unsigned char *>(data);
    return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

/* Checks the headers of a GLB and its chunks (glTF 2.0 section 4.4); tinygltf's own messages do not
 * say the byte. */
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
    check_depth(source.data + glb_header_bytes, json, glb_header_bytes);
    /* tinygltf 2.7 forgets the eight bytes of the second header and would read beyond the file. */
    size_t rest = source.size - 20 - json;
    if (rest >= 8 && read_u32(source.data + 20 + json) > rest - 8)
        fail(PSPLAT_ERROR_FORMAT,
             named("byte", 20 + json) + ": the BIN chunk is longer than the file");
}

/* Keeps the bytes of an image file undecoded. Those of an image in a buffer view are not touched,
 * since tinygltf has not checked that view. */
bool keep_image(tinygltf::Image *image, const int, std::string *, std::string *, int, int,
                const unsigned char *bytes, int size, void *) {
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

/* Says that every file exists, so that tinygltf tries no other directories; read_beside reports
 * those that do not. */
bool always_exists(const std::string &, void *) {
    return true;
}

/* Replaces tinygltf's own function, which passes the path through a shell's expansion. */
std::string keep_path(const std::string &path, void *) {
    return path;
}

/* Returns whether a segment of the path is "..". */
bool has_parent_segment(const std::string &path) {
    return ("/" + path + "/").find("/../") != std::string::npos;
}

/* Reads a file that must lie in the source's directory or below, so that a downloaded model cannot
 * read other files of the user. */
bool read_beside(std::vector<unsigned char> *out, std::string *message, const std::string &path,
                 void *directory) {
    char *data = nullptr;
    size_t size = 0;
    psplat_error error;
    if (has_parent_segment(path.substr(static_cast<std::string *>(directory)->size()))) {
        if (message) *message += "it leaves its directory";
        return false;
    }
    if (psplat_file_read(path.c_str(), &data, &size, &error)) {
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

/* Returns the GLB with another JSON chunk; size is that of its present one. */
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

/* Returns the JSON text as tinygltf accepts it, or nothing where it does so as it is. */
std::string replace_json(std::string_view json) {
    std::string replaced, again;
    if (replace_fallbacks(json, replaced)) json = replaced;
    return leave_out_indices(json, again) ? again : replaced;
}

/* Accepts every version 2.x unless minVersion asks for more (glTF 2.0 section 3.2). */
void check_version(const tinygltf::Asset &asset) {
    bool needs_more = !asset.minVersion.empty() && asset.minVersion != "2.0";
    if (asset.version.compare(0, 2, "2.") == 0 && !needs_more) return;
    fail(PSPLAT_ERROR_UNSUPPORTED,
         "asset: version " + one_line(needs_more ? asset.minVersion : asset.version).substr(0, 20) +
             "; 2.0 is read");
}

/* Returns the first of tinygltf's lines, of which each has an error. */
std::string first_line(const std::string &text) {
    return one_line(text.substr(0, text.find('\n')));
}

} // namespace

std::vector<std::string> read_document(const psplat_source &source, tinygltf::Model &model) {
    std::vector<std::string> lost;
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, nullptr);
    loader.SetStoreOriginalJSONForExtrasAndExtensions(true); /* extras are copied as text */
    std::string path = source.file;
    size_t slash = path.rfind('/');
    std::string directory = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    loader.SetFsCallbacks({always_exists, keep_path, read_beside, nullptr, &directory});
    std::string error, warning, replaced;
    bool ok = false;
    if (source.format == PSPLAT_SOURCE_GLB) {
        check_glb(source);
        size_t json = read_u32(source.data + 12);
        lost = check_json(source.data + glb_header_bytes, json, true);
        replaced = replace_json(std::string_view(source.data + glb_header_bytes, json));
        bool is_replaced = !replaced.empty();
        if (is_replaced) replaced = repack(source, json, std::move(replaced));
        ok = loader.LoadBinaryFromMemory(
            &model, &error, &warning,
            reinterpret_cast<const unsigned char *>(is_replaced ? replaced.data() : source.data),
            static_cast<unsigned int>(is_replaced ? replaced.size() : source.size), directory);
    } else {
        check_depth(source.data, source.size, 0);
        lost = check_json(source.data, source.size, false);
        replaced = replace_json(std::string_view(source.data, source.size));
        bool is_replaced = !replaced.empty();
        ok = loader.LoadASCIIFromString(
            &model, &error, &warning, is_replaced ? replaced.data() : source.data,
            static_cast<unsigned int>(is_replaced ? replaced.size() : source.size), directory);
    }
    if (!ok) fail(PSPLAT_ERROR_FORMAT, "not a valid glTF: " + first_line(error));
    check_version(model.asset);
    decompress(model);
    decode_draco(model);
    return lost;
}

} // namespace psplat_gltf
