/* SPDX-License-Identifier: MIT
 *
 * pose.c - evaluates animations (glTF 2.0 appendix C): keys become transforms of nodes, and these
 * the transforms of batches. All of it is in double precision, and nothing is allocated but when a
 * pose is made.
 */
#include "asset/animation.h"
#include "core/matrix.h"

#include <math.h>
#include <string.h>

struct psplat_pose {
    psplat_arena arena; /* also holds this struct */
    const psplat_asset *asset;
    psplat_transform *transforms; /* of the nodes that move */
    double (*world)[16];          /* of the rig's nodes */
    double (*models)[16];         /* of the asset's batches */
};

/* ---- one channel ----------------------------------------------------------------------------- */

/* Returns the last key whose time is at most t, which is not before the first. */
static size_t find_key(const psplat_keys *keys, double t) {
    size_t low = 0, high = keys->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if ((double)keys->times[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Returns the value of a key, without its tangents. */
static const float *value_of(const psplat_keys *keys, size_t key, size_t components) {
    if (keys->interpolation == PSPLAT_CUBICSPLINE) key = 3 * key + 1;
    return keys->values + key * components;
}

/* Turns from a to b by the part f of the shorter of both ways. Close to each other they are
 * interpolated linearly, which is the same to rounding. */
static void slerp(const float *a, const float *b, double f, double out[4]) {
    double cosine = 0, from = 1 - f, to = f;
    for (int k = 0; k < 4; ++k) cosine += (double)a[k] * (double)b[k];
    double sign = cosine < 0 ? -1 : 1;
    if (fabs(cosine) < 1 - 1e-9) {
        double angle = acos(fabs(cosine));
        from = sin((1 - f) * angle) / sin(angle);
        to = sin(f * angle) / sin(angle);
    }
    for (int k = 0; k < 4; ++k) out[k] = from * (double)a[k] + sign * to * (double)b[k];
}

/* Follows the cubic Hermite spline between two keys that are `span` seconds apart. */
static void follow_spline(const psplat_keys *keys, size_t key, size_t components, double f,
                          double span, double *out) {
    const float *from = value_of(keys, key, components), *to = from + 3 * components;
    const float *leaving = from + components, *arriving = to - components;
    double f2 = f * f, f3 = f2 * f;
    for (size_t k = 0; k < components; ++k)
        out[k] = (2 * f3 - 3 * f2 + 1) * (double)from[k] +
                 span * (f3 - 2 * f2 + f) * (double)leaving[k] + (3 * f2 - 2 * f3) * (double)to[k] +
                 span * (f3 - f2) * (double)arriving[k];
}

static void interpolate(const psplat_keys *keys, double t, size_t components, double *out) {
    size_t last = keys->count - 1, key = t >= (double)keys->times[0] ? find_key(keys, t) : 0;
    const float *from = value_of(keys, key, components);
    for (size_t k = 0; k < components; ++k) out[k] = (double)from[k];
    if (key == last || !(t > (double)keys->times[key]) || keys->interpolation == PSPLAT_STEP)
        return;
    double span = (double)keys->times[key + 1] - (double)keys->times[key];
    double f = (t - (double)keys->times[key]) / span;
    const float *to = value_of(keys, key + 1, components);
    if (keys->interpolation == PSPLAT_CUBICSPLINE)
        follow_spline(keys, key, components, f, span, out);
    else if (components == 4)
        slerp(from, to, f, out);
    else
        for (size_t k = 0; k < components; ++k)
            out[k] = (double)from[k] + f * ((double)to[k] - (double)from[k]);
}

/* A spline may lead a quaternion through 0, where it has no direction: then it is that of the key
 * before. */
static void set_rotation(const psplat_keys *keys, double t, double rotation[4]) {
    interpolate(keys, t, 4, rotation);
    double length = sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] +
                         rotation[2] * rotation[2] + rotation[3] * rotation[3]);
    if (length > 1e-6 && isfinite(length)) {
        for (int k = 0; k < 4; ++k) rotation[k] /= length;
        return;
    }
    const float *q = value_of(keys, find_key(keys, t), 4);
    for (int k = 0; k < 4; ++k) rotation[k] = (double)q[k];
}

static void move(const psplat_channel *channel, double t, psplat_transform *transform) {
    if (channel->path == PSPLAT_PATH_ROTATION)
        set_rotation(&channel->keys, t, transform->rotation);
    else if (channel->path == PSPLAT_PATH_TRANSLATION)
        interpolate(&channel->keys, t, 3, transform->translation);
    else
        interpolate(&channel->keys, t, 3, transform->scale);
}

/* ---- the pose -------------------------------------------------------------------------------- */

static void place_nodes(const psplat_rig *rig, psplat_pose *pose) {
    for (size_t i = 0; i < rig->node_count; ++i) {
        const psplat_rig_node *node = &rig->nodes[i];
        double local[16];
        memcpy(local, node->matrix, sizeof local);
        if (node->animated != PSPLAT_NONE)
            psplat_transform_compose(&pose->transforms[node->animated], local);
        if (node->parent == PSPLAT_NONE)
            memcpy(pose->world[i], local, sizeof local);
        else
            psplat_matrix_multiply(pose->world[node->parent], local, pose->world[i]);
    }
}

void psplat_pose_rest(psplat_pose *pose) {
    for (size_t i = 0; pose && i < psplat_asset_all_batch_count(pose->asset); ++i)
        memcpy(pose->models[i], psplat_asset_batch(pose->asset, i)->model, sizeof pose->models[i]);
}

/* Returns whether a batch has not left what a double can hold. Its box alone would not show a NaN,
 * which fmin and fmax ignore. */
static int is_finite(const psplat_pose *pose, size_t batch) {
    double min[3] = {INFINITY, INFINITY, INFINITY}, max[3] = {-INFINITY, -INFINITY, -INFINITY};
    int all = 1;
    psplat_asset_enlarge(psplat_asset_batch(pose->asset, batch), pose->models[batch], min, max);
    for (int i = 0; i < 16; ++i) all &= isfinite(pose->models[batch][i]);
    for (int i = 0; i < 3; ++i) all &= isfinite(min[i]) && isfinite(max[i]);
    return all;
}

psplat_result psplat_pose_set(psplat_pose *pose, size_t animation, double time,
                              psplat_error *error) {
    if (!pose || !isfinite(time))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a pose is required and a time that is finite");
    const psplat_rig *rig = psplat_asset_rig(pose->asset);
    if (animation >= rig->animation_count)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "there are %zu animations, not %zu",
                           rig->animation_count, animation);
    const psplat_rig_animation *played = &rig->animations[animation];
    if (rig->animated_count)
        memcpy(pose->transforms, rig->rest, rig->animated_count * sizeof *rig->rest);
    for (size_t i = 0; i < played->channel_count; ++i)
        move(&played->channels[i], time, &pose->transforms[played->channels[i].animated]);
    place_nodes(rig, pose);
    int all_finite = 1;
    for (size_t i = 0; i < psplat_asset_all_batch_count(pose->asset); ++i) {
        psplat_asset_place(pose->asset, i, pose->world[psplat_asset_rig_node(pose->asset, i)],
                           pose->models[i]);
        all_finite &= is_finite(pose, i);
    }
    if (all_finite) return PSPLAT_OK;
    psplat_pose_rest(pose);
    return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                       "at %g seconds animation %zu moves splats beyond what a double can hold",
                       time, animation);
}

psplat_result psplat_pose_create(const psplat_asset *asset, psplat_pose **out,
                                 psplat_error *error) {
    if (out) *out = NULL;
    if (!asset || !out)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "asset and pose are required");
    const psplat_rig *rig = psplat_asset_rig(asset);
    psplat_arena arena = {.allocator = psplat_asset_allocator(asset)};
    psplat_pose *pose = psplat_arena_take(&arena, 1, sizeof *pose);
    void *transforms = psplat_arena_take(&arena, rig->animated_count, sizeof *pose->transforms);
    void *world = psplat_arena_take(&arena, rig->node_count, sizeof *pose->world);
    void *models =
        psplat_arena_take(&arena, psplat_asset_all_batch_count(asset), sizeof *pose->models);
    if (!pose || !transforms || !world || !models) {
        psplat_arena_release(&arena);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a pose");
    }
    *pose = (psplat_pose){arena, asset, transforms, world, models};
    psplat_pose_rest(pose);
    *out = pose;
    return PSPLAT_OK;
}

void psplat_pose_destroy(psplat_pose *pose) {
    if (!pose) return;
    /* The pose lies in its own arena, so that the arena is copied out before it is released. */
    psplat_arena arena = pose->arena;
    psplat_arena_release(&arena);
}

const double *psplat_pose_matrix(const psplat_pose *pose, size_t batch) {
    return pose && batch < psplat_asset_all_batch_count(pose->asset) ? pose->models[batch] : NULL;
}

void psplat_pose_bounds(const psplat_pose *pose, double min[3], double max[3]) {
    for (int i = 0; i < 3; ++i) {
        min[i] = INFINITY;
        max[i] = -INFINITY;
    }
    for (size_t i = 0; pose && i < psplat_asset_batch_count(pose->asset); ++i)
        psplat_asset_enlarge(psplat_asset_batch(pose->asset, i), pose->models[i], min, max);
}
