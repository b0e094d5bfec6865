/* SPDX-License-Identifier: MIT
 *
 * gl_texture.h - creation and deletion of every texture of the runtime. They go through one place
 * so that the GPU memory of each part is known (psplat_renderer_memory) and running out of it is
 * noticed.
 */
#ifndef PHONGSPLAT_GL_GL_TEXTURE_H
#define PHONGSPLAT_GL_GL_TEXTURE_H

#include "gl/gl_api.h"

/* The formats of texels. Each is a row of the table in gl_texture.c. */
typedef enum psplat_texel {
    PSPLAT_TEXEL_RGBA32F = 0,
    PSPLAT_TEXEL_RGB32F,
    PSPLAT_TEXEL_RG32F,
    PSPLAT_TEXEL_R32F,
    PSPLAT_TEXEL_RGBA16F,
    PSPLAT_TEXEL_RG16F,
    PSPLAT_TEXEL_R16F,
    PSPLAT_TEXEL_DEPTH32F,
    PSPLAT_TEXEL_RGBA8,
    PSPLAT_TEXEL_SRGB8_ALPHA8, /* colours are decoded to linear light where they are sampled */
    PSPLAT_TEXEL_COUNT
} psplat_texel;

/* Zeros are the defaults of all but texel and size. Coordinates are clamped to the edge. */
typedef struct psplat_gl_texture_desc {
    psplat_texel texel;
    GLsizei width, height; /* of level 0 */
    int levels;            /* mipmap levels, each half as large as the one before; 0 means 1 */
    int is_cube;           /* 1: GL_TEXTURE_CUBE_MAP with six faces instead of GL_TEXTURE_2D */
    int is_linear;         /* 1: filtered linearly, between levels too; 0: the nearest texel */
    int compares;          /* 1: sampling compares depths (GL_LEQUAL); is_linear filters results */
} psplat_gl_texture_desc;

typedef struct psplat_gl_texture {
    GLuint id;      /* 0: there is no texture */
    size_t bytes;   /* of all levels and faces as asked of GL; drivers may round up */
    size_t *ledger; /* the sum that bytes are part of; NULL where there is no texture */
} psplat_gl_texture;

/* Makes a texture whose texels are undefined, adds its bytes to *ledger (a member of
 * psplat_renderer.memory) and leaves it bound to unit 0, which is left active. It may be called
 * between psplat_gl_state_take and psplat_gl_state_restore only. On failure *texture is zero and
 * nothing is left behind. The caller deletes the texture. Errors: MEMORY, GRAPHICS (the context is
 * lost). */
psplat_result psplat_gl_texture_create(psplat_gl *gl, size_t *ledger,
                                       const psplat_gl_texture_desc *desc,
                                       psplat_gl_texture *texture, psplat_error *error);

/* Binds the texture to a unit, which is left active. target is GL_TEXTURE_2D or
 * GL_TEXTURE_CUBE_MAP. */
void psplat_gl_texture_bind(const psplat_gl *gl, GLenum unit, const psplat_gl_texture *texture,
                            GLenum target);

/* Deletes a texture, subtracts its bytes from its ledger and sets it to zero. A texture that is
 * zero is accepted. */
void psplat_gl_texture_delete(const psplat_gl *gl, psplat_gl_texture *texture);

#endif
