/* SPDX-License-Identifier: MIT
 *
 * gl_texture.c - textures and the accounting of their bytes. Formats are the sized ones that GL 3.3
 * core, GLES 3.0 and WebGL 2 share. Storage is mutable, because glTexStorage2D is GL 4.2.
 */
#include "gl/gl_texture.h"

#include <string.h>

static const struct {
    GLint internal_format;
    GLenum format, type; /* of the texels that are uploaded */
    unsigned bytes;      /* of a texel on the GPU */
} texels[PSPLAT_TEXEL_COUNT] = {
    [PSPLAT_TEXEL_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16},
    [PSPLAT_TEXEL_RGB32F] = {GL_RGB32F, GL_RGB, GL_FLOAT, 12},
    [PSPLAT_TEXEL_RG32F] = {GL_RG32F, GL_RG, GL_FLOAT, 8},
    [PSPLAT_TEXEL_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 4},
    [PSPLAT_TEXEL_RG16F] = {GL_RG16F, GL_RG, GL_FLOAT, 4},
    [PSPLAT_TEXEL_R16F] = {GL_R16F, GL_RED, GL_FLOAT, 2},
    [PSPLAT_TEXEL_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_FLOAT, 8},
    [PSPLAT_TEXEL_DEPTH32F] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4},
    [PSPLAT_TEXEL_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4},
    [PSPLAT_TEXEL_SRGB8_ALPHA8] = {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, 4},
};

static GLsizei halved(GLsizei size, int times) {
    size >>= times;
    return size > 0 ? size : 1;
}

/* Allocates a level of all faces and returns its bytes. */
static size_t make_level(const psplat_gl *gl, const psplat_gl_texture_desc *desc, int level) {
    GLsizei width = halved(desc->width, level), height = halved(desc->height, level);
    GLenum faces = desc->is_cube ? 6 : 1;
    GLenum first = desc->is_cube ? GL_TEXTURE_CUBE_MAP_POSITIVE_X : GL_TEXTURE_2D;
    for (GLenum face = 0; face < faces; ++face)
        gl->TexImage2D(first + face, level, texels[desc->texel].internal_format, width, height, 0,
                       texels[desc->texel].format, texels[desc->texel].type, NULL);
    return (size_t)faces * (size_t)width * (size_t)height * texels[desc->texel].bytes;
}

static void set_sampling(const psplat_gl *gl, GLenum target, const psplat_gl_texture_desc *desc,
                         int levels) {
    GLint filter = desc->is_linear ? GL_LINEAR : GL_NEAREST;
    GLint between = desc->is_linear && levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : filter;
    gl->TexParameteri(target, GL_TEXTURE_MIN_FILTER, between);
    gl->TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    gl->TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, levels - 1);
    if (!desc->compares) return;
    gl->TexParameteri(target, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl->TexParameteri(target, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

psplat_result psplat_gl_texture_create(psplat_gl *gl, size_t *ledger,
                                       const psplat_gl_texture_desc *desc,
                                       psplat_gl_texture *texture, psplat_error *error) {
    GLenum target = desc->is_cube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D;
    int levels = desc->levels ? desc->levels : 1;
    *texture = (psplat_gl_texture){.ledger = ledger};
    gl->ActiveTexture(GL_TEXTURE0);
    gl->GenTextures(1, &texture->id);
    gl->BindTexture(target, texture->id);
    for (int level = 0; level < levels; ++level) texture->bytes += make_level(gl, desc, level);
    set_sampling(gl, target, desc, levels);
    *ledger += texture->bytes;

    psplat_result result = psplat_gl_errors(gl, error);
    if (result == PSPLAT_OK) return PSPLAT_OK;
    psplat_gl_texture_delete(gl, texture);
    return result;
}

void psplat_gl_texture_bind(const psplat_gl *gl, GLenum unit, const psplat_gl_texture *texture,
                            GLenum target) {
    gl->ActiveTexture(GL_TEXTURE0 + unit);
    gl->BindTexture(target, texture->id);
}

void psplat_gl_texture_delete(const psplat_gl *gl, psplat_gl_texture *texture) {
    if (!texture->ledger) return;
    gl->DeleteTextures(1, &texture->id);
    *texture->ledger -= texture->bytes;
    memset(texture, 0, sizeof *texture);
}
