/* SPDX-License-Identifier: MIT
 *
 * texture.h - every texture of the runtime is made and deleted here, so that what each part of it
 * takes of the GPU's memory is known (psplat_renderer_memory) and running out of it is noticed.
 */
#ifndef PHONGSPLAT_TEXTURE_H
#define PHONGSPLAT_TEXTURE_H

#include "gl_api.h"

/* What a texel holds. Each is a row of the table in texture.c. */
typedef enum psplat_texel {
    PSPLAT_TEXEL_RGBA32F = 0,
    PSPLAT_TEXEL_RGB32F,
    PSPLAT_TEXEL_RG32F,
    PSPLAT_TEXEL_R32F,
    PSPLAT_TEXEL_RGBA16F,
    PSPLAT_TEXEL_RG16F,
    PSPLAT_TEXEL_R16F,
    PSPLAT_TEXEL_DEPTH32F,
    PSPLAT_TEXEL_COUNT
} psplat_texel;

/* Zeros are the defaults of all but texel and size. Coordinates are clamped to the edge. */
typedef struct psplat_texture_desc {
    psplat_texel texel;
    GLsizei width, height; /* of level 0 */
    int levels;            /* each half as large as the one before; 0: 1 */
    int is_cube;           /* six faces: GL_TEXTURE_CUBE_MAP instead of GL_TEXTURE_2D */
    int is_linear;         /* filtered linearly, between levels too; 0: nearest */
    int compares;          /* of depth: sampling compares (GL_LEQUAL), filtered where is_linear */
} psplat_texture_desc;

typedef struct psplat_texture {
    GLuint id;      /* 0: none */
    size_t bytes;   /* as asked of GL, all levels and faces; drivers may round up */
    size_t *ledger; /* the sum that bytes are part of */
} psplat_texture;

/* Makes a texture whose texels are undefined, adds its bytes to *ledger (a member of
 * psplat_renderer.memory) and leaves it bound to unit 0, which is left active. Between
 * psplat_gl_state_take and _restore only. On failure the texture is zero and nothing is left
 * behind. Errors: MEMORY, GRAPHICS (the context is lost). */
psplat_result psplat_texture_create(psplat_gl *gl, size_t *ledger, const psplat_texture_desc *desc,
                                    psplat_texture *texture, psplat_error *error);

/* Subtracts its bytes and leaves it zero, which is accepted. */
void psplat_texture_delete(const psplat_gl *gl, psplat_texture *texture);

#endif
