/* SPDX-License-Identifier: MIT
 *
 * renderer.h - what the files that draw share: the renderer's and the model's insides.
 */
#ifndef PHONGSPLAT_RENDERER_H
#define PHONGSPLAT_RENDERER_H

#include "chunk.h"
#include "gl_api.h"
#include "program.h"
#include "shadow.h"
#include "target.h"
#include "texture.h"

#include <phongsplat/phongsplat.h>

struct psplat_renderer {
    psplat_gl gl;
    psplat_allocator allocator;
    psplat_programs programs;
    psplat_targets targets;
    psplat_shadows shadows;
    psplat_memory memory; /* ledgers of texture.h */
    GLuint vertex_array;  /* without attributes: GL core draws nothing without one */
};

/* An uploaded psplat_batch. */
typedef struct psplat_model_batch {
    psplat_texture splats, clips, finishes; /* layout.h; zero where clip_count or finish is */
    psplat_chunk *chunks;                   /* psplat_chunk_count(splat_count) of them */
    int is_owner; /* 0: textures and chunks are those of an earlier batch of the same primitive */
    uint32_t primitive;
    GLsizei splat_count;
    uint32_t clip_count;
    int has_color, has_gamma;
    unsigned finish; /* PSPLAT_FINISH_ bits */
    double model[16];
    psplat_kernel kernel;
    float depth_tolerance;
    psplat_material material;
    float bounds_min[3], bounds_max[3];
} psplat_model_batch;

struct psplat_environment {
    psplat_texture diffuse;   /* cube: irradiance by normal */
    psplat_texture glossy;    /* cube: mean radiance by reflected direction, rougher by level */
    psplat_texture split_sum; /* a and b of eq. (9) by n.e and roughness */
    float glossy_levels;      /* roughness times this is the level */
};

struct psplat_model {
    psplat_model_batch *batches;
    size_t batch_count;
};

#endif
