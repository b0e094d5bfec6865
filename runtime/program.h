/* SPDX-License-Identifier: MIT
 *
 * program.h - shader programs, specialised by what a batch, a view and a shading need, made when
 * first needed and kept.
 */
#ifndef PHONGSPLAT_PROGRAM_H
#define PHONGSPLAT_PROGRAM_H

#include "gl_api.h"
#include "layout.h"

#include <phongsplat/phongsplat.h>

/* X(name, value): variants, or-ed together, each a macro of the shaders. */
#define PSPLAT_OPTIONS(X)                                                                          \
    /* of the splat passes: */                                                                     \
    X(WIDE, 1)       /* splats take one texel more (layout.h) */                                   \
    X(COLOR, 2)      /* and have their colours there */                                            \
    X(GAMMA, 4)      /* and a gamma */                                                             \
    X(FIELD, 8)      /* the linear field, not the normal of the centre */                          \
    X(NEAR, 16)      /* the near plane may cut the batch */                                        \
    X(TWO_SIDED, 32) /* backs are seen */                                                          \
    X(POWER, 64)     /* kernel exponent other than 2 */                                            \
    X(FILTER, 128)   /* the screen-space filter (spec 5.8) */                                      \
    X(COUNT, 256)    /* weights are 1 */                                                           \
    /* what goes through the targets: */                                                           \
    X(COLORS, 512)                                                                                 \
    X(MATERIALS, 1024) /* comes with COLORS */                                                     \
    /* of programs that shade: */                                                                  \
    X(PUNCTUAL, 2048) /* some light is not directional */                                          \
    X(ENVIRONMENT, 4096)                                                                           \
    X(SHADOWS, 8192)                                                                               \
    /* of the resolve pass: */                                                                     \
    X(ENCODE, 16384) /* to sRGB */                                                                 \
    X(AS_IS, 32768)  /* what was summed is a colour: no shading */                                 \
    /* of splats, and of what goes through the targets, where materials vary (spec 3.10): */       \
    X(FINISH, 65536)                                                                               \
    X(OCCLUSION, 131072) /* comes with MATERIALS */

enum {
#define PSPLAT_OPTION_ENUM(name, value) PSPLAT_OPTION_##name = value,
    PSPLAT_OPTIONS(PSPLAT_OPTION_ENUM)
#undef PSPLAT_OPTION_ENUM
        PSPLAT_OPTIONS_TARGETS =
            PSPLAT_OPTION_COLORS | PSPLAT_OPTION_MATERIALS | PSPLAT_OPTION_OCCLUSION,
    PSPLAT_OPTIONS_LIGHT =
        PSPLAT_OPTION_PUNCTUAL | PSPLAT_OPTION_ENVIRONMENT | PSPLAT_OPTION_SHADOWS
};

typedef struct psplat_program_key {
    unsigned options;
    int is_resolve;
    int pass;        /* PSPLAT_PASS_VISIBILITY ... */
    int clip_count;  /* 0 ... PSPLAT_MAX_CLIP_LINES */
    int shading;     /* PSPLAT_SHADING_LIT ... */
    int light_count; /* 0 ... PSPLAT_MAX_LIGHTS */
} psplat_program_key;

#define PSPLAT_UNIFORMS(X)                                                                         \
    X(clip_matrix)                                                                                 \
    X(projection)                                                                                  \
    X(modelview)                                                                                   \
    X(normal_matrix)                                                                               \
    X(shift)                                                                                       \
    X(view_direction)                                                                              \
    X(half_viewport)                                                                               \
    X(first_index)                                                                                 \
    X(finish)                                                                                      \
    X(kernel)                                                                                      \
    X(base_color)                                                                                  \
    X(emissive)                                                                                    \
    X(surface)                                                                                     \
    X(ray)                                                                                         \
    X(unproject)                                                                                   \
    X(ambient)                                                                                     \
    X(light_position)                                                                              \
    X(light_color)                                                                                 \
    X(light_axis)                                                                                  \
    X(light_cone)                                                                                  \
    X(shadow_scale)                                                                                \
    X(shadow_matrix)                                                                               \
    X(eye_to_scene)                                                                                \
    X(glossy_levels)                                                                               \
    X(planes)                                                                                      \
    X(to_host)                                                                                     \
    X(origin)

/* Locations are -1 where a variant has no use for the uniform; GL ignores writes to it. */
typedef struct psplat_program {
    psplat_program_key key;
    GLuint id;
#define PSPLAT_UNIFORM_MEMBER(name) GLint name;
    PSPLAT_UNIFORMS(PSPLAT_UNIFORM_MEMBER)
#undef PSPLAT_UNIFORM_MEMBER
} psplat_program;

typedef struct psplat_programs {
    psplat_program *list; /* in the order of their first use */
    size_t count, capacity;
} psplat_programs;

/* The key without what its program has no use for, so that equal programs have equal keys. */
psplat_program_key psplat_program_key_reduce(psplat_program_key key);

/* The program of a key, made and left current where it did not exist; valid until the next call.
 * Errors: GRAPHICS with what the compiler says, MEMORY. */
psplat_result psplat_programs_find(psplat_programs *programs, const psplat_gl *gl,
                                   const psplat_allocator *allocator, psplat_program_key key,
                                   const psplat_program **program, psplat_error *error);
void psplat_programs_destroy(psplat_programs *programs, const psplat_gl *gl,
                             const psplat_allocator *allocator);

/* Whether a shading looks at base colours, and whether at materials and lights as well. */
int psplat_shading_reads_color(int shading);
int psplat_shading_reads_light(int shading);

/* Compiles and links a pair of sources, each preceded by the version line of the context, the
 * defines and layout.h; the fragment shader also by head and followed by tail (each may be ""). 0
 * on failure. */
GLuint psplat_program_build(const psplat_gl *gl, const char *defines, const char *vertex,
                            const char *head, const char *fragment, const char *tail,
                            psplat_error *error);

#endif
