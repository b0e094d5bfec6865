/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * adapter_gltf_animation.cpp - animations of nodes: translation, rotation and scale over time (glTF
 * 2.0 section 3.11), with every index and number checked.
 */
#include "gltf/adapter_gltf.hpp"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace psplat_gltf {
namespace {

/* ---- tracks ---------------------------------------------------------------------------------- */

/* What an accessor is read as. Rotations of splines have tangents between them. */
enum class Use { times, vectors, rotations, spline_rotations };

struct Track {
    size_t components;
    std::vector<float> values;
};

/* The tracks read so far. Each accessor is read once for each use. */
struct Tracks {
    std::vector<Track> list;
    std::map<std::pair<int, Use>, uint32_t> found;
};

View checked_view(const tinygltf::Model &model, int accessor, Use use) {
    View view = view_of(model, accessor);
    int components = use == Use::times ? 1 : use == Use::vectors ? 3 : 4;
    bool is_float = view.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    bool is_packed = components == 4 && view.normalized &&
                     view.component_type >= TINYGLTF_COMPONENT_TYPE_BYTE &&
                     view.component_type <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    if (view.components != components || !(is_float || is_packed))
        fail(PSPLAT_ERROR_FORMAT,
             named("accessor", static_cast<size_t>(accessor)) + ": " +
                 (use == Use::times     ? "times are not scalars of floats"
                  : use == Use::vectors ? "values are not vectors of three floats"
                                        : "rotations are not vectors of four floats or "
                                          "normalized integers"));
    return view;
}

void check_times(const std::vector<float> &times, const std::string &name) {
    if (times.front() < 0) fail(PSPLAT_ERROR_RANGE, name + ": the first time is negative");
    for (size_t i = 1; i < times.size(); ++i)
        if (!(times[i] > times[i - 1]))
            fail(PSPLAT_ERROR_RANGE,
                 name + ": time " + std::to_string(i) + " is not after the time before it");
}

double length_of(const float *q) {
    return std::sqrt(static_cast<double>(q[0]) * static_cast<double>(q[0]) +
                     static_cast<double>(q[1]) * static_cast<double>(q[1]) +
                     static_cast<double>(q[2]) * static_cast<double>(q[2]) +
                     static_cast<double>(q[3]) * static_cast<double>(q[3]));
}

/* Divides quaternions by their lengths, each with its tangents: `group` is 3 where there are any,
 * and the quaternion is the one in the middle. Rounded ones stay as they are in a file of floats,
 * so that what is converted twice does not change. */
void normalise(std::vector<float> &values, size_t group, const std::string &name) {
    for (size_t at = 0; at + 4 * group <= values.size(); at += 4 * group) {
        double length = length_of(&values[at + 4 * (group / 2)]);
        if (!(length > 0))
            fail(PSPLAT_ERROR_RANGE,
                 name + ": rotation " + std::to_string(at / (4 * group)) + " is 0");
        for (size_t k = at; std::fabs(length - 1) > 1e-6 && k < at + 4 * group; ++k)
            values[k] = static_cast<float>(static_cast<double>(values[k]) / length);
    }
}

Track read_track(const tinygltf::Model &model, int accessor, Use use) {
    View view = checked_view(model, accessor, use);
    const std::string name = named("accessor", static_cast<size_t>(accessor));
    Track track{static_cast<size_t>(view.components), {}};
    track.values.reserve(view.count * track.components);
    for (size_t row = 0; row < view.count; ++row)
        for (size_t column = 0; column < track.components; ++column) {
            double value = component(view, row, column);
            if (!std::isfinite(value))
                fail(PSPLAT_ERROR_RANGE,
                     name + ": element " + std::to_string(row) + " is not finite");
            track.values.push_back(static_cast<float>(value));
        }
    if (use == Use::times) check_times(track.values, name);
    if (use == Use::rotations) normalise(track.values, 1, name);
    if (use == Use::spline_rotations) normalise(track.values, 3, name);
    return track;
}

uint32_t track_of(const tinygltf::Model &model, Tracks &tracks, int accessor, Use use) {
    auto known = tracks.found.find({accessor, use});
    if (known != tracks.found.end()) return known->second;
    tracks.list.push_back(read_track(model, accessor, use));
    uint32_t index = static_cast<uint32_t>(tracks.list.size() - 1);
    tracks.found[{accessor, use}] = index;
    return index;
}

/* Forgets the tracks from `count` on, which only an animation has that is dropped. */
void forget(Tracks &tracks, size_t count) {
    tracks.list.resize(count);
    for (auto at = tracks.found.begin(); at != tracks.found.end();)
        at = at->second < count ? std::next(at) : tracks.found.erase(at);
}

/* ---- one animation --------------------------------------------------------------------------- */

struct Animation {
    std::vector<psplat_scene_sampler> samplers;
    std::vector<psplat_scene_channel> channels;
};

psplat_scene_interpolation interpolation_of(const std::string &text) {
    if (text == "LINEAR") return PSPLAT_SCENE_LINEAR;
    if (text == "STEP") return PSPLAT_SCENE_STEP;
    if (text == "CUBICSPLINE") return PSPLAT_SCENE_CUBICSPLINE;
    fail(PSPLAT_ERROR_FORMAT, "interpolation '" + one_line(text).substr(0, 20) +
                                  "' is none of LINEAR, STEP and CUBICSPLINE");
}

psplat_scene_sampler read_sampler(const tinygltf::Model &model, Tracks &tracks,
                                  const tinygltf::AnimationSampler &in, psplat_scene_path path) {
    psplat_scene_sampler out{};
    out.interpolation = interpolation_of(in.interpolation);
    bool is_spline = out.interpolation == PSPLAT_SCENE_CUBICSPLINE;
    Use use = path != PSPLAT_SCENE_ROTATION ? Use::vectors
              : is_spline                   ? Use::spline_rotations
                                            : Use::rotations;
    out.times = track_of(model, tracks, in.input, Use::times);
    out.values = track_of(model, tracks, in.output, use);
    size_t times = tracks.list[out.times].values.size();
    size_t values = tracks.list[out.values].values.size() / tracks.list[out.values].components;
    if (values != (is_spline ? 3 * times : times))
        fail(PSPLAT_ERROR_RANGE,
             std::to_string(values) + " values for " + std::to_string(times) + " times");
    return out;
}

/* Returns the path, or -1 where it is none of those that move nodes. */
int path_of(const std::string &text) {
    static const char *const paths[] = {"translation", "rotation", "scale"};
    for (int i = 0; i < 3; ++i)
        if (text == paths[i]) return i;
    return -1;
}

/* What all animations of a file have in common. */
struct Context {
    const tinygltf::Model &model;
    const psplat_scene &scene;
    std::vector<bool> is_bare; /* for each node: a joint of a skin, below which nothing shows */
    size_t foreign = 0, bare = 0, empty = 0; /* channels and animations that are dropped */
};

void read_channel(Context &context, const tinygltf::Animation &in,
                  const tinygltf::AnimationChannel &channel, Tracks &tracks,
                  std::map<int, uint32_t> &samplers, Animation &out) {
    int path = path_of(channel.target_path);
    if (path < 0 || channel.target_node < 0) {
        ++context.foreign;
        return;
    }
    element(context.model.nodes, channel.target_node, "node");
    uint32_t node = static_cast<uint32_t>(channel.target_node);
    if (context.is_bare[node]) {
        ++context.bare;
        return;
    }
    if (context.scene.nodes[node].has_matrix)
        fail(PSPLAT_ERROR_FORMAT, named("node", node) + " has a matrix, which cannot be animated");
    auto known = samplers.find(channel.sampler);
    if (known == samplers.end()) {
        const tinygltf::AnimationSampler &sampler =
            element(in.samplers, channel.sampler, "sampler");
        try {
            out.samplers.push_back(
                read_sampler(context.model, tracks, sampler, static_cast<psplat_scene_path>(path)));
        } catch (const Failure &failure) {
            fail(failure.code,
                 named("sampler", static_cast<size_t>(channel.sampler)) + ": " + failure.text);
        }
        known = samplers.emplace(channel.sampler, out.samplers.size() - 1).first;
    }
    size_t components = path == PSPLAT_SCENE_ROTATION ? 4 : 3;
    if (tracks.list[out.samplers[known->second].values].components != components)
        fail(PSPLAT_ERROR_FORMAT, named("sampler", static_cast<size_t>(channel.sampler)) +
                                      ": turns one node and moves another");
    out.channels.push_back({known->second, node, static_cast<psplat_scene_path>(path)});
}

Animation read_animation(Context &context, const tinygltf::Animation &in, Tracks &tracks) {
    Animation out;
    std::map<int, uint32_t> samplers;
    std::set<std::pair<uint32_t, int>> moved;
    for (const tinygltf::AnimationChannel &channel : in.channels) {
        size_t count = out.channels.size();
        read_channel(context, in, channel, tracks, samplers, out);
        if (out.channels.size() == count) continue;
        const psplat_scene_channel &last = out.channels.back();
        if (!moved.insert({last.node, last.path}).second)
            fail(PSPLAT_ERROR_FORMAT, "two channels have the " + channel.target_path + " of " +
                                          named("node", last.node));
    }
    return out;
}

/* ---- joints ---------------------------------------------------------------------------------- */

/* Returns whether a node or one below it has a mesh, a camera or a light. Nodes are at most 64
 * deep. */
bool shows_something(const psplat_scene &scene, uint32_t index) {
    const psplat_scene_node &node = scene.nodes[index];
    bool shows = node.mesh != PSPLAT_NO_INDEX || node.camera != PSPLAT_NO_INDEX ||
                 node.light != PSPLAT_NO_INDEX;
    for (size_t i = 0; i < node.child_count && !shows; ++i)
        shows = shows_something(scene, node.children[i]);
    return shows;
}

std::vector<bool> bare_joints(const tinygltf::Model &model, const psplat_scene &scene) {
    std::vector<bool> is_joint(scene.node_count);
    for (const tinygltf::Skin &skin : model.skins)
        for (int joint : skin.joints)
            if (joint >= 0 && static_cast<size_t>(joint) < scene.node_count)
                is_joint[static_cast<size_t>(joint)] = true;
    for (uint32_t i = 0; i < scene.node_count; ++i)
        is_joint[i] = is_joint[i] && !shows_something(scene, i);
    return is_joint;
}

/* ---- all animations -------------------------------------------------------------------------- */

template <typename T> void copy(const std::vector<T> &from, T *&list, size_t &count) {
    allocate(list, count, from.size());
    std::copy(from.begin(), from.end(), list);
}

void store_tracks(const Tracks &tracks, psplat_scene &scene) {
    allocate(scene.tracks, scene.track_count, tracks.list.size());
    for (size_t i = 0; i < tracks.list.size(); ++i) {
        psplat_scene_track &out = scene.tracks[i];
        size_t values = 0;
        out.components = tracks.list[i].components;
        copy(tracks.list[i].values, out.values, values);
        out.count = values / out.components;
    }
}

void warn(const Context &context, psplat_scene &scene) {
    if (context.foreign)
        psplat_scene_warn(&scene,
                          "%zu channels of animations are dropped: splats follow the translation, "
                          "rotation and scale of nodes alone",
                          context.foreign);
    if (context.bare)
        psplat_scene_warn(&scene,
                          "%zu channels of animations are dropped: they move joints that show "
                          "nothing without their skin",
                          context.bare);
    if (context.empty)
        psplat_scene_warn(&scene, "%zu animations are dropped: they move no nodes", context.empty);
}

} // namespace

void read_animations(const tinygltf::Model &model, psplat_scene &scene) {
    Context context{model, scene, bare_joints(model, scene)};
    Tracks tracks;
    size_t capacity = 0;
    allocate(scene.animations, capacity, model.animations.size());
    for (size_t i = 0; i < model.animations.size(); ++i) {
        const tinygltf::Animation &in = model.animations[i];
        size_t before = tracks.list.size();
        Animation read;
        try {
            read = read_animation(context, in, tracks);
        } catch (const Failure &failure) {
            forget(tracks, before);
            psplat_scene_warn(
                &scene, "animation %zu%s is dropped: %s", i,
                in.name.empty() ? "" : (" '" + one_line(in.name).substr(0, 60) + "'").c_str(),
                failure.text.c_str());
            continue;
        }
        context.empty += read.channels.empty();
        if (read.channels.empty()) continue;
        psplat_scene_animation &out = scene.animations[scene.animation_count++];
        describe(in, out);
        copy(read.samplers, out.samplers, out.sampler_count);
        copy(read.channels, out.channels, out.channel_count);
        for (const psplat_scene_channel &channel : read.channels)
            scene.nodes[channel.node].is_animated = 1;
    }
    store_tracks(tracks, scene);
    warn(context, scene);
}

} // namespace psplat_gltf
