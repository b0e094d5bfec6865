/* SPDX-License-Identifier: MIT
 *
 * renderer.h - the members of the renderer, of models and of environments, which the files of this
 * directory share.
 */
#ifndef PHONGSPLAT_RENDERER_RENDERER_H
#define PHONGSPLAT_RENDERER_RENDERER_H

#include "core/chunk.h"
#include "gl/gl_api.h"
#include "gl/gl_program.h"
#include "gl/gl_sampler.h"
#include "renderer/instances.h"
#include "renderer/shadow.h"
#include "renderer/render_target.h"
#include "gl/gl_texture.h"

#include <phongsplat/phongsplat.h>

struct psplat_renderer {
    psplat_gl gl;
    psplat_allocator allocator;
    psplat_images images;
    psplat_state_policy state;
    psplat_programs programs;
    psplat_render_targets targets;
    psplat_shadows shadows;
    psplat_memory memory;        /* the ledgers of gl_texture.h */
    psplat_gl_samplers samplers; /* of textures of materials */
    psplat_instances instances;  /* of the pass that is drawn, with memory for the next ones */
    GLuint vertex_array;         /* of the instances */
    uint64_t batch_count;        /* batches of all models that were ever made, for their numbers */
};

/* An uploaded psplat_batch. */
typedef struct psplat_model_batch {
    psplat_gl_texture splats;    /* packed as layout.h says */
    psplat_gl_texture clips;     /* zero where clip_count is 0 */
    psplat_gl_texture finishes;  /* zero where finish is 0 */
    psplat_gl_texture texcoords; /* zero where textures is 0 */
    psplat_chunk *chunks;        /* psplat_chunk_count(splat_count) of them, around walls, too */
    float *spheres; /* centre and radius around each splat and its wall; NULL where there are many
                       splats */
    int is_owner;   /* 0: an earlier batch of the same primitive owns the textures and chunks */
    uint32_t primitive;
    uint32_t level, last_level; /* as in psplat_batch */
    uint64_t number; /* of the owner; differs between all batches of a renderer that own textures */
    GLsizei splat_count;
    GLsizei uncut_count; /* of them by psplat_packed_uncut; 0 where clip_count is 0 */
    uint32_t clip_count;
    uint32_t seam_lines; /* as in psplat_batch */
    int has_color, has_gamma, is_curved, has_shape, has_bends;
    unsigned finish;   /* PSPLAT_FINISH_ bits */
    unsigned textures; /* PSPLAT_OPTION_ bits of what spec 3.11 asks of fragments; 0: nothing */
    GLuint maps[PSPLAT_MAP_COUNT]; /* by psplat_texture_slot: names of textures, 0 where unused */
    GLuint samplers[PSPLAT_MAP_COUNT];
    double model[16];
    int shares_place; /* 1: the batch before has the same model matrix */
    psplat_kernel kernel;
    float depth_tolerance;
    float wall; /* how far down the walls of curved splats reach, object space; 0: there are none */
    psplat_material material;           /* no transform of a texture is all zeros */
    float sagitta;                      /* psplat_packed_sagitta of all splats, object space */
    float bounds_min[3], bounds_max[3]; /* of the patches, of their walls, and of the tangent
                                           ellipses at their centres */
} psplat_model_batch;

struct psplat_environment {
    psplat_gl_texture diffuse;   /* cube map of the irradiance for each normal */
    psplat_gl_texture glossy;    /* cube map of the mean radiance for each reflected direction;
                                    each mipmap level is for a greater roughness */
    psplat_gl_texture split_sum; /* table of a and b of eq. (9) by n.e and roughness */
    float glossy_levels;         /* the level of glossy is roughness times this */
};

/* An image of a model: a texture of our own or one of the host's. Both are 0 where no batch uses
 * the image. */
typedef struct psplat_model_image {
    psplat_gl_texture texture;
    psplat_pixels host;
} psplat_model_image;

struct psplat_model {
    psplat_model_batch *batches;
    size_t batch_count;
    psplat_level *levels;
    size_t level_count;
    double bounds_min[3], bounds_max[3]; /* psplat_asset_bounds */
    psplat_model_image *images; /* image_count: each of the asset's as other numbers, as colours */
    size_t image_count;
};

#endif
