/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_json.cpp - the checks of a glTF's JSON before tinygltf reads it, so that errors say
 * what is wrong and where in words of their own: the syntax, the members that every file needs, and
 * the extensions that the file requires.
 */
#include "gltf/adapter_gltf.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace psplat_gltf {
namespace {

using Json = nlohmann::json;

/* ---- syntax ---------------------------------------------------------------------------------- */

/* The JSON text, and where it begins in a GLB. */
struct Text {
    std::string_view json;
    bool is_glb;
};

/* Finds the first error. The parser knows where it is, its exceptions do not always. */
struct ErrorFinder : nlohmann::json_sax<Json> {
    size_t position = 0;      /* of the last byte that was read, from 1 */
    bool is_overflow = false; /* a number beyond double precision */

    bool null() override {
        return true;
    }
    bool boolean(bool) override {
        return true;
    }
    bool number_integer(number_integer_t) override {
        return true;
    }
    bool number_unsigned(number_unsigned_t) override {
        return true;
    }
    bool number_float(number_float_t, const string_t &) override {
        return true;
    }
    bool string(string_t &) override {
        return true;
    }
    bool binary(binary_t &) override {
        return true;
    }
    bool start_object(std::size_t) override {
        return true;
    }
    bool key(string_t &) override {
        return true;
    }
    bool end_object() override {
        return true;
    }
    bool start_array(std::size_t) override {
        return true;
    }
    bool end_array() override {
        return true;
    }
    bool parse_error(std::size_t at, const std::string &,
                     const nlohmann::detail::exception &error) override {
        position = at;
        is_overflow = error.id == 406;
        return false;
    }
};

/* Returns where a byte is: its line and column in a text, its offset in a GLB. */
std::string place_of(const Text &text, size_t at) {
    if (text.is_glb) return named("byte", glb_header_bytes + at);
    std::string_view before = text.json.substr(0, at);
    size_t line = static_cast<size_t>(std::count(before.begin(), before.end(), '\n')) + 1;
    size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return named("line", line) + ", " + named("column", at - start + 1);
}

/* Returns whether a byte lies inside a string. */
bool is_in_string(std::string_view json, size_t at) {
    bool inside = false;
    for (size_t i = 0; i < at; ++i) {
        if (inside && json[i] == '\\')
            ++i;
        else if (json[i] == '"')
            inside = !inside;
    }
    return inside;
}

std::string cause_of(const Text &text, size_t at, bool is_overflow) {
    if (is_overflow) return "a number is too large";
    if (at >= text.json.size()) return "the JSON ends before it is complete";
    unsigned char c = static_cast<unsigned char>(text.json[at]);
    if (is_in_string(text.json, at)) {
        if (c < ' ') return "a string has no end, or a control character inside";
        return c < 0x80 ? "a string has an escape that JSON does not know"
                        : "a string is not UTF-8";
    }
    if (c > ' ' && c < 0x7f) return std::string("'") + char(c) + "' does not belong here in JSON";
    return "a byte of value " + std::to_string(c) + " does not belong here in JSON";
}

[[noreturn]] void fail_syntax(const Text &text) {
    ErrorFinder finder;
    Json::sax_parse(text.json, &finder);
    size_t at = finder.position > 0 ? finder.position - 1 : 0;
    fail(PSPLAT_ERROR_FORMAT, place_of(text, at) + ": " + cause_of(text, at, finder.is_overflow));
}

Json parse(const Text &text) {
    Json json;
    try {
        json = Json::parse(text.json);
    } catch (const Json::exception &) {
        fail_syntax(text);
    }
    if (!json.is_object())
        fail(PSPLAT_ERROR_FORMAT, place_of(text, 0) + ": the JSON is not an object");
    return json;
}

/* ---- members --------------------------------------------------------------------------------- */

enum Kind { COUNT, TEXT, ARRAY };

/* The members without which tinygltf reads nothing. */
struct Member {
    const char *list, *name;
    Kind kind;
};

constexpr Member members[] = {
    {"buffers", "byteLength", COUNT},     {"bufferViews", "buffer", COUNT},
    {"bufferViews", "byteLength", COUNT}, {"accessors", "componentType", COUNT},
    {"accessors", "count", COUNT},        {"accessors", "type", TEXT},
    {"meshes", "primitives", ARRAY},      {"cameras", "type", TEXT},
};

constexpr const char *lists[] = {"accessors", "animations", "bufferViews", "buffers", "cameras",
                                 "images",    "materials",  "meshes",      "nodes",   "samplers",
                                 "scenes",    "skins",      "textures"};

void check_member(const Json &object, const Member &member, const std::string &where) {
    static const char *const kinds[] = {"a whole number from 0 on", "a text", "an array"};
    auto found = object.find(member.name);
    if (found == object.end()) fail(PSPLAT_ERROR_FORMAT, where + ": has no " + member.name);
    bool fits = member.kind == COUNT  ? found->is_number_unsigned()
                : member.kind == TEXT ? found->is_string()
                                      : found->is_array();
    if (!fits)
        fail(PSPLAT_ERROR_FORMAT, where + ": " + member.name + " is not " + kinds[member.kind]);
}

void check_primitives(const Json &mesh, const std::string &where) {
    size_t index = 0;
    for (const Json &primitive : mesh["primitives"]) {
        std::string place = where + ".primitives[" + std::to_string(index++) + "]";
        if (!primitive.is_object()) fail(PSPLAT_ERROR_FORMAT, place + ": is not an object");
        auto attributes = primitive.find("attributes");
        if (attributes == primitive.end() || !attributes->is_object())
            fail(PSPLAT_ERROR_FORMAT, place + ": has no attributes");
    }
}

void check_list(const Json &json, const char *name) {
    auto list = json.find(name);
    if (list == json.end()) return;
    if (!list->is_array()) fail(PSPLAT_ERROR_FORMAT, std::string(name) + ": is not an array");
    size_t index = 0;
    for (const Json &object : *list) {
        std::string where = std::string(name) + "[" + std::to_string(index++) + "]";
        if (!object.is_object()) fail(PSPLAT_ERROR_FORMAT, where + ": is not an object");
        for (const Member &member : members)
            if (!std::strcmp(member.list, name)) check_member(object, member, where);
        if (!std::strcmp(name, "meshes")) check_primitives(object, where);
    }
}

void check_members(const Json &json) {
    auto asset = json.find("asset");
    if (asset == json.end() || !asset->is_object() || !asset->contains("version") ||
        !(*asset)["version"].is_string())
        fail(PSPLAT_ERROR_FORMAT, "asset: has no version, so this is no glTF 2.0");
    for (const char *list : lists) check_list(json, list);
}

/* ---- extensions ------------------------------------------------------------------------------ */

void check_extensions(const Json &json) {
    /* Some of these are not read: they do not change the shape, and factors replace what they say.
     */
    static const char *const known[] = {"KHR_mesh_quantization",   "KHR_texture_transform",
                                        "KHR_lights_punctual",     "KHR_texture_basisu",
                                        "EXT_texture_webp",        "KHR_materials_",
                                        "EXT_meshopt_compression", "KHR_draco_mesh_compression"};
    auto required = json.find("extensionsRequired");
    if (required == json.end() || !required->is_array()) return;
    for (const Json &one : *required) {
        std::string name = one.is_string() ? one.get<std::string>() : std::string();
        bool is_known = std::any_of(std::begin(known), std::end(known), [&](const char *prefix) {
            return name.compare(0, std::strlen(prefix), prefix) == 0;
        });
        if (!is_known)
            fail(PSPLAT_ERROR_UNSUPPORTED, "extensionsRequired: " + one_line(name).substr(0, 80) +
                                               " is not supported; export the model without it");
    }
}

/* ---- what tinygltf drops --------------------------------------------------------------------- */

/* Returns why tinygltf leaves out a channel of an animation, or NULL where it does not. */
const char *cause_of_loss(const Json &channel) {
    if (!channel.is_object()) return "it is not an object";
    auto sampler = channel.find("sampler"), target = channel.find("target");
    if (sampler == channel.end() || !sampler->is_number_integer()) return "it has no sampler";
    if (target == channel.end() || !target->is_object()) return nullptr;
    auto node = target->find("node"), path = target->find("path");
    if (node == target->end() || !node->is_number_integer()) return "its target is no node";
    if (path == target->end() || !path->is_string()) return "its target has no path";
    return nullptr;
}

/* Returns a warning of the channels of an animation that are lost, or "". It names the first. */
std::string warning_of_loss(const Json &animation, size_t index) {
    std::string first;
    size_t count = 0, at = 0;
    auto channels = animation.find("channels"), name = animation.find("name");
    if (channels == animation.end() || !channels->is_array()) return "";
    for (const Json &channel : *channels) {
        const char *cause = cause_of_loss(channel);
        if (cause && !count++) first = named("channel", at) + " is dropped: " + cause;
        ++at;
    }
    if (!count) return "";
    bool has_name = name != animation.end() && name->is_string();
    return named("animation", index) +
           (has_name ? " '" + one_line(name->get<std::string>()).substr(0, 60) + "'" : "") + ": " +
           first + (count > 1 ? ", and " + std::to_string(count - 1) + " more like it" : "");
}

std::vector<std::string> warnings_of_loss(const Json &json) {
    std::vector<std::string> warnings;
    auto animations = json.find("animations");
    if (animations == json.end()) return warnings;
    for (size_t i = 0; i < animations->size(); ++i) {
        std::string warning = warning_of_loss((*animations)[i], i);
        if (!warning.empty()) warnings.push_back(std::move(warning));
    }
    return warnings;
}

} // namespace

std::vector<std::string> check_json(const char *text, size_t size, bool is_glb) {
    const Json json = parse({std::string_view(text, size), is_glb});
    check_extensions(json);
    check_members(json);
    return warnings_of_loss(json);
}

} // namespace psplat_gltf
