/* SPDX-License-Identifier: MIT
 *
 * gl_sampler.h - the samplers with which materials use their textures (spec 3.11). A sampler's
 * parameters take the place of the texture's own, so that materials may use one image in several
 * ways, and textures of the host stay as they are.
 */
#ifndef PHONGSPLAT_GL_GL_SAMPLER_H
#define PHONGSPLAT_GL_GL_SAMPLER_H

#include "gl/gl_api.h"

/* Samplers by wrap of s, wrap of t and nearest; 0 where none was needed yet. */
typedef struct psplat_gl_samplers {
    GLuint names[3][3][2];
} psplat_gl_samplers;

/* Returns the sampler of a use of an image and makes it where it is the first such use: mipmaps,
 * and anisotropy up to 8 where the context has it. */
GLuint psplat_gl_samplers_find(psplat_gl_samplers *samplers, const psplat_gl *gl,
                               const psplat_texture *use);

/* Deletes all samplers and sets them to zero. */
void psplat_gl_samplers_delete(psplat_gl_samplers *samplers, const psplat_gl *gl);

#endif
