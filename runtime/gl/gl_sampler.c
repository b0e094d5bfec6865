/* SPDX-License-Identifier: MIT
 *
 * gl_sampler.c - samplers are made when they are first needed, and kept.
 */
#include "gl/gl_sampler.h"

#include <string.h>

enum { MAX_ANISOTROPY = 8 };

static const GLint wraps[] = {[PSPLAT_WRAP_REPEAT] = GL_REPEAT,
                              [PSPLAT_WRAP_CLAMP] = GL_CLAMP_TO_EDGE,
                              [PSPLAT_WRAP_MIRROR] = GL_MIRRORED_REPEAT};

GLuint psplat_gl_samplers_find(psplat_gl_samplers *samplers, const psplat_gl *gl,
                               const psplat_texture *use) {
    int most = gl->max_anisotropy < MAX_ANISOTROPY ? gl->max_anisotropy : MAX_ANISOTROPY;
    GLuint *name = &samplers->names[use->wrap[0]][use->wrap[1]][!!use->nearest];
    if (*name) return *name;
    gl->GenSamplers(1, name);
    gl->SamplerParameteri(*name, GL_TEXTURE_WRAP_S, wraps[use->wrap[0]]);
    gl->SamplerParameteri(*name, GL_TEXTURE_WRAP_T, wraps[use->wrap[1]]);
    gl->SamplerParameteri(*name, GL_TEXTURE_MAG_FILTER, use->nearest ? GL_NEAREST : GL_LINEAR);
    gl->SamplerParameteri(*name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    if (most > 1) gl->SamplerParameteri(*name, GL_TEXTURE_MAX_ANISOTROPY, most);
    return *name;
}

void psplat_gl_samplers_delete(psplat_gl_samplers *samplers, const psplat_gl *gl) {
    GLuint *names = &samplers->names[0][0][0];
    for (size_t i = 0; i < sizeof samplers->names / sizeof *names; ++i)
        if (names[i]) gl->DeleteSamplers(1, &names[i]);
    memset(samplers, 0, sizeof *samplers);
}
