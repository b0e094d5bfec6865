/* SPDX-License-Identifier: MIT
 *
 * program.h - shader programs, specialised by what a batch needs, made when first needed and kept.
 */
#ifndef PHONGSPLAT_PROGRAM_H
#define PHONGSPLAT_PROGRAM_H

#include "gl_api.h"
#include "layout.h"

/* Variants of the splat programs, or-ed together. */
enum {
    PSPLAT_OPTION_COLOR = 1,     /* splats have colours */
    PSPLAT_OPTION_MATERIALS = 2, /* the material goes through the targets */
    PSPLAT_OPTION_NEAR = 4,      /* visibility: the near plane may cut the batch */
    PSPLAT_OPTION_POWER = 8,     /* kernel exponent other than 2 */
    PSPLAT_OPTION_GAMMA = 16,    /* normal fields have a gamma (spec 3.5) */
    PSPLAT_OPTION_SETS = 32
};

#define PSPLAT_UNIFORMS(X)                                                                         \
    X(modelview)                                                                                   \
    X(projection)                                                                                  \
    X(normal_matrix)                                                                               \
    X(shift)                                                                                       \
    X(two_sided)                                                                                   \
    X(first_index)                                                                                 \
    X(kernel)                                                                                      \
    X(base_color)                                                                                  \
    X(emissive)                                                                                    \
    X(surface)                                                                                     \
    X(ray)                                                                                         \
    X(light_direction)                                                                             \
    X(light_color)                                                                                 \
    X(ambient)                                                                                     \
    X(origin)                                                                                      \
    X(linear_output)

/* Locations are -1 where a variant has no use for the uniform; GL ignores writes to it. */
typedef struct psplat_program {
    GLuint id; /* 0: not made yet */
#define PSPLAT_UNIFORM_MEMBER(name) GLint name;
    PSPLAT_UNIFORMS(PSPLAT_UNIFORM_MEMBER)
#undef PSPLAT_UNIFORM_MEMBER
} psplat_program;

typedef struct psplat_programs {
    psplat_program splat[PSPLAT_PASS_COUNT][PSPLAT_MAX_CLIP_LINES + 1][PSPLAT_OPTION_SETS];
    psplat_program resolve[PSPLAT_PASS_COUNT][2]; /* without and with PSPLAT_OPTION_MATERIALS */
} psplat_programs;

/* The program of a pass, made and left current where it did not exist. NULL on failure: GRAPHICS
 * with what the compiler says. */
const psplat_program *psplat_programs_splat(psplat_programs *programs, const psplat_gl *gl,
                                            int pass, uint32_t clip_count, unsigned options,
                                            psplat_error *error);
const psplat_program *psplat_programs_resolve(psplat_programs *programs, const psplat_gl *gl,
                                              int pass, unsigned options, psplat_error *error);
void psplat_programs_destroy(psplat_programs *programs, const psplat_gl *gl);

/* Compiles and links a pair of sources, each preceded by the version line of the context, the
 * defines and layout.h; the fragment shader also by library (may be ""). 0 on failure. */
GLuint psplat_program_build(const psplat_gl *gl, const char *defines, const char *vertex,
                            const char *library, const char *fragment, psplat_error *error);

#endif
