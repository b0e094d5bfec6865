// SPDX-License-Identifier: MIT
//
// test_cpp.cpp - tests a C++17 program that embeds the runtime: it uses every function of the
// public headers and initialises structs without designators. The list of functions is checked
// against the headers.
#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>
#include <phongsplat/reference.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#define FUNCTIONS(X)                                                                               \
    X(psplat_asset_all_batch_count)                                                                \
    X(psplat_asset_animation_count)                                                                \
    X(psplat_asset_batch)                                                                          \
    X(psplat_asset_batch_count)                                                                    \
    X(psplat_asset_bounds)                                                                         \
    X(psplat_asset_destroy)                                                                        \
    X(psplat_asset_get_animation)                                                                  \
    X(psplat_asset_get_image)                                                                      \
    X(psplat_asset_get_level)                                                                      \
    X(psplat_asset_image_count)                                                                    \
    X(psplat_asset_level_count)                                                                    \
    X(psplat_asset_open)                                                                           \
    X(psplat_asset_open_memory)                                                                    \
    X(psplat_draw)                                                                                 \
    X(psplat_environment_create)                                                                   \
    X(psplat_environment_destroy)                                                                  \
    X(psplat_fail)                                                                                 \
    X(psplat_host_begin)                                                                           \
    X(psplat_host_create)                                                                          \
    X(psplat_host_destroy)                                                                         \
    X(psplat_host_get_proc)                                                                        \
    X(psplat_host_make_current)                                                                    \
    X(psplat_host_read_depth)                                                                      \
    X(psplat_host_read_float)                                                                      \
    X(psplat_host_read_rgba8)                                                                      \
    X(psplat_host_renderer)                                                                        \
    X(psplat_host_version)                                                                         \
    X(psplat_level_error)                                                                          \
    X(psplat_model_choose_level)                                                                   \
    X(psplat_model_create)                                                                         \
    X(psplat_model_describe)                                                                       \
    X(psplat_model_destroy)                                                                        \
    X(psplat_pose_bounds)                                                                          \
    X(psplat_pose_create)                                                                          \
    X(psplat_pose_destroy)                                                                         \
    X(psplat_pose_matrix)                                                                          \
    X(psplat_pose_rest)                                                                            \
    X(psplat_pose_set)                                                                             \
    X(psplat_reference_draw)                                                                       \
    X(psplat_renderer_create)                                                                      \
    X(psplat_renderer_destroy)                                                                     \
    X(psplat_renderer_memory)                                                                      \
    X(psplat_result_text)

namespace {

int failures = 0;

void expect(bool holds, const char *what) {
    if (holds) return;
    std::fprintf(stderr, "failed: %s\n", what);
    ++failures;
}

// Takes the address of each function, so that each is linked.
std::set<std::string> linked() {
    std::set<std::string> names;
#define LINK(name)                                                                                 \
    expect(reinterpret_cast<void (*)()>(&name) != nullptr, #name);                                 \
    names.insert(#name);
    FUNCTIONS(LINK)
#undef LINK
    return names;
}

// Finds the names before a parenthesis, outside comments and macros.
std::set<std::string> declared(const std::string &path) {
    std::ifstream file(path);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    expect(!text.empty(), path.c_str());
    std::string code;
    for (std::size_t at = 0; at < text.size();) {
        std::size_t comment = text.find("/*", at);
        code += text.substr(at, comment - at);
        at = comment == std::string::npos ? comment : text.find("*/", comment) + 2;
    }
    std::set<std::string> names;
    for (std::size_t at = 0; (at = code.find("psplat_", at)) != std::string::npos;) {
        std::size_t end = code.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_", at);
        bool is_call = end != std::string::npos && code[end] == '(';
        bool starts = at == 0 || std::string(" *\n").find(code[at - 1]) != std::string::npos;
        if (is_call && starts) names.insert(code.substr(at, end - at));
        at = end;
    }
    return names;
}

void test_functions() {
    const std::set<std::string> known = linked();
    std::set<std::string> found;
    for (const char *header : {"splat", "phongsplat", "reference", "host"})
        for (const std::string &name : declared(
                 std::string(PSPLAT_SOURCE_DIR "/runtime/include/phongsplat/") + header + ".h"))
            found.insert(name);
    for (const std::string &name : found) expect(known.count(name) == 1, name.c_str());
    expect(found == known, "the list holds what the headers declare");
}

struct Destroy {
    psplat_renderer *renderer = nullptr;
    void operator()(psplat_host *host) const {
        psplat_host_destroy(host);
    }
    void operator()(psplat_renderer *r) const {
        psplat_renderer_destroy(r);
    }
    void operator()(psplat_asset *asset) const {
        psplat_asset_destroy(asset);
    }
    void operator()(psplat_model *model) const {
        psplat_model_destroy(renderer, model);
    }
};

template <class T> using Owned = std::unique_ptr<T, Destroy>;

void *get_proc(void *user, const char *name) {
    return psplat_host_get_proc(user, name);
}

// Draws the specification's minimal file, held in std::vector and std::unique_ptr.
void test_drawing() {
    psplat_error error = {};
    psplat_host *host = nullptr;
    expect(psplat_host_create(PSPLAT_API_GL, 1, &host, &error) == PSPLAT_OK, error.text);
    Owned<psplat_host> owned_host(host);

    psplat_renderer_desc desc = {};
    desc.get_proc = get_proc;
    desc.user = host;
    psplat_renderer *renderer = nullptr;
    expect(psplat_renderer_create(&desc, &renderer, &error) == PSPLAT_OK, error.text);
    Owned<psplat_renderer> owned_renderer(renderer);

    psplat_asset_desc asset_desc = {};
    psplat_asset *asset = nullptr;
    expect(psplat_asset_open(PSPLAT_SOURCE_DIR "/schema/minimal.gltf", &asset_desc, &asset,
                             &error) == PSPLAT_OK,
           error.text);
    Owned<psplat_asset> owned_asset(asset);
    psplat_model *model = nullptr;
    expect(psplat_model_create(renderer, asset, &model, &error) == PSPLAT_OK, error.text);
    Owned<psplat_model> owned_model(model, Destroy{renderer});

    psplat_view view = {};
    view.width = view.height = 64;
    for (int i = 0; i < 16; i += 5) view.view[i] = view.projection[i] = 1;
    double min[3], max[3], extent = 0;
    psplat_asset_bounds(asset, min, max);
    for (int i = 0; i < 3; ++i) extent = std::fmax(extent, max[i] - min[i]);
    for (int i = 0; i < 3; ++i) {
        view.projection[5 * i] = (i == 2 ? -1 : 2) / extent;
        view.view[12 + i] = -0.5 * (min[i] + max[i]);
        view.ambient[i] = 1;
    }
    psplat_item item = {};
    item.model = model;
    const float black[4] = {};
    std::vector<uint8_t> rgba(64 * 64 * 4);
    expect(psplat_host_begin(host, 64, 64, 0, black, &error) == PSPLAT_OK, error.text);
    expect(psplat_draw(renderer, &view, &item, 1, &error) == PSPLAT_OK, error.text);
    expect(psplat_host_read_rgba8(host, rgba.data(), &error) == PSPLAT_OK, error.text);
    int covered = 0;
    for (std::size_t i = 3; i < rgba.size(); i += 4) covered += rgba[i] == 255;
    expect(covered > 100, "splats are drawn");
}

} // namespace

int main() {
    test_functions();
    test_drawing();
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
