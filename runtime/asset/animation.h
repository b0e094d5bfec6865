/* SPDX-License-Identifier: MIT
 *
 * animation.h - what of a file moves: the nodes that lead to splats, and the channels of animations
 * that move them (glTF 2.0 section 3.11). animation.c reads it, pose.c evaluates it.
 */
#ifndef PHONGSPLAT_ASSET_ANIMATION_H
#define PHONGSPLAT_ASSET_ANIMATION_H

#include "asset/gltf.h"

/* A node on the way from a root to splats. */
typedef struct psplat_rig_node {
    size_t parent;     /* an index below the node's own, or PSPLAT_NONE */
    size_t animated;   /* index of its transform among those that move, or PSPLAT_NONE */
    double matrix[16]; /* its own transform at rest */
} psplat_rig_node;

typedef enum psplat_interpolation {
    PSPLAT_LINEAR = 0,
    PSPLAT_STEP,
    PSPLAT_CUBICSPLINE
} psplat_interpolation;

/* The keys of a channel. Rotations are quaternions of length 1. */
typedef struct psplat_keys {
    const float *times;  /* count of them, at least 1, which increase from 0 or more */
    const float *values; /* of 3 or 4 components, for each time one, or with CUBICSPLINE three:
                            tangent before, value, tangent after */
    size_t count;
    psplat_interpolation interpolation;
} psplat_keys;

typedef enum psplat_path {
    PSPLAT_PATH_TRANSLATION = 0,
    PSPLAT_PATH_ROTATION,
    PSPLAT_PATH_SCALE
} psplat_path;

typedef struct psplat_channel {
    psplat_keys keys;
    size_t animated; /* index of the transform that it moves */
    psplat_path path;
} psplat_channel;

typedef struct psplat_rig_animation {
    psplat_animation info;
    psplat_channel *channels; /* of nodes that lead to splats: some of those of the info */
    size_t channel_count;
} psplat_rig_animation;

/* All that moves in an asset. Without animations there is nothing in it. */
typedef struct psplat_rig {
    psplat_rig_node *nodes; /* parents before children */
    size_t node_count;
    psplat_transform *rest; /* animated_count transforms at rest, of the nodes that move; room for
                               all */
    size_t animated_count;
    psplat_rig_animation *animations;
    size_t animation_count;
    size_t *index_of; /* in gltf.scratch: of each node of the file, or PSPLAT_NONE */
} psplat_rig;

/* Reads the animations, after meshes and nodes. All but index_of belongs to gltf->kept. Errors:
 * FORMAT, RANGE, UNSUPPORTED, MEMORY, and those of loading buffers. */
psplat_result psplat_animations_parse(psplat_gltf *gltf, psplat_rig *rig);

/* ---- asset.c --------------------------------------------------------------------------------- */

const psplat_rig *psplat_asset_rig(const psplat_asset *asset);

/* Returns the node of the rig that places a batch. There is a rig only where there are
 * animations. */
size_t psplat_asset_rig_node(const psplat_asset *asset, size_t batch);

/* Computes the matrix of a batch whose node has this one: the same, but for coarser levels, which
 * have a place of their own in it. */
void psplat_asset_place(const psplat_asset *asset, size_t batch, const double world[16],
                        double model[16]);

psplat_allocator psplat_asset_allocator(const psplat_asset *asset);

/* Enlarges a box by that of a batch which a matrix places. */
void psplat_asset_enlarge(const psplat_batch *batch, const double matrix[16], double min[3],
                          double max[3]);

#endif
