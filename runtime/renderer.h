/* SPDX-License-Identifier: MIT
 *
 * renderer.h - what the files that draw share: the renderer's and the model's insides.
 */
#ifndef PHONGSPLAT_RENDERER_H
#define PHONGSPLAT_RENDERER_H

#include "gl_api.h"
#include "program.h"
#include "target.h"
#include "texture.h"

#include <phongsplat/phongsplat.h>

struct psplat_renderer {
    psplat_gl gl;
    psplat_allocator allocator;
    psplat_programs programs;
    psplat_target target;
    psplat_memory memory; /* ledgers of texture.h */
    GLuint vertex_array;  /* without attributes: GL core draws nothing without one */
};

/* An uploaded psplat_batch. */
typedef struct psplat_model_batch {
    psplat_texture splats, clips; /* layout.h; clips is zero where clip_count is */
    int owns_textures;            /* 0: they are those of an earlier batch of the same primitive */
    uint32_t primitive;
    GLsizei splat_count;
    uint32_t clip_count;
    int has_color, has_gamma;
    double model[16];
    psplat_kernel kernel;
    float depth_tolerance;
    psplat_material material;
    float bounds_min[3], bounds_max[3];
} psplat_model_batch;

struct psplat_model {
    psplat_model_batch *batches;
    size_t batch_count;
};

#endif
