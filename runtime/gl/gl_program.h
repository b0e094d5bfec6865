/* SPDX-License-Identifier: MIT
 *
 * gl_program.h - shader programs and their variants. Each variant has just what a batch, a view and
 * a shading need; it is compiled when it is first needed and then kept.
 */
#ifndef PHONGSPLAT_GL_GL_PROGRAM_H
#define PHONGSPLAT_GL_GL_PROGRAM_H

#include "gl/gl_api.h"
#include "gl/host_source.h"
#include "layout.h"

#include <phongsplat/phongsplat.h>

/* Lists the options of a variant: X(name, value). Values are or-ed together, and each option is a
 * macro of the shaders, 0 or 1. */
#define PSPLAT_OPTIONS(X)                                                                          \
    /* for the splat passes: */                                                                    \
    X(WIDE, 1)       /* splats have a fourth texel (layout.h) */                                   \
    X(COLOR, 2)      /* that texel has a colour */                                                 \
    X(GAMMA, 4)      /* that texel has a gamma */                                                  \
    X(FIELD, 8)      /* normals are the linear field, not the normal of the centre */              \
    X(NEAR, 16)      /* the near plane may cut the batch */                                        \
    X(TWO_SIDED, 32) /* backs are seen */                                                          \
    X(POWER, 64)     /* the kernel's exponent is not 2 */                                          \
    X(FILTER, 128)   /* the screen-space filter is on (spec 5.8) */                                \
    X(COUNT, 256)    /* weights are 1 */                                                           \
    /* for what render targets hold: */                                                            \
    X(COLORS, 512)     /* colours differ between splats */                                         \
    X(MATERIALS, 1024) /* metallic or roughness differ; implies COLORS */                          \
    /* for programs that shade: */                                                                 \
    X(PUNCTUAL, 2048)    /* some light is not directional */                                       \
    X(ENVIRONMENT, 4096) /* the view has an environment */                                         \
    X(SHADOWS, 8192)     /* some light casts shadows */                                            \
    /* for the resolve pass: */                                                                    \
    X(ENCODE, 16384) /* colours are encoded to sRGB */                                             \
    X(AS_IS, 32768)  /* the sum is a colour already, which is not shaded */                        \
    /* for both kinds of pass, where materials vary over a batch (spec 3.10): */                   \
    X(FINISH, 65536)     /* splats have a finish */                                                \
    X(OCCLUSION, 131072) /* occlusion varies; implies MATERIALS */                                 \
    X(EMISSIVE, 4194304) /* emission or unlit differ; implies MATERIALS */                         \
    /* for the splat passes, of curved splats and bent clip lines: */                              \
    X(CURVED, 262144)  /* the view ray is cut with the quadric */                                  \
    X(TANGENT, 524288) /* ellipses lie in the tangent plane at the centre; never with CURVED */    \
    X(SHAPE, 1048576)  /* splats have a shape of their own (layout.h) */                           \
    X(BENDS, 2097152)  /* clip lines are bent */                                                   \
    /* for the splat passes, of batches with texture coordinates (spec 3.11): */                   \
    X(MASK, 8388608)             /* fragments that are not opaque enough are dropped */            \
    X(BASE_MAP, 16777216)        /* the material has a texture of base colours, */                 \
    X(SURFACE_MAP, 33554432)     /* of metallic and roughness, */                                  \
    X(NORMAL_MAP, 67108864)      /* of normals, */                                                 \
    X(OCCLUSION_MAP, 134217728)  /* of occlusion, */                                               \
    X(EMISSIVE_MAP, 268435456)   /* of emission */                                                 \
    X(TEXCOORD_BEND, 536870912)  /* coordinates have a second order */                             \
    X(MAP_TRANSFORM, 1073741824) /* some texture has a transform of its own */

enum {
#define PSPLAT_OPTION_ENUM(name, value) PSPLAT_OPTION_##name = value,
    PSPLAT_OPTIONS(PSPLAT_OPTION_ENUM)
#undef PSPLAT_OPTION_ENUM
        PSPLAT_OPTIONS_TARGETS = PSPLAT_OPTION_COLORS | PSPLAT_OPTION_MATERIALS |
                                 PSPLAT_OPTION_OCCLUSION | PSPLAT_OPTION_EMISSIVE,
    PSPLAT_OPTIONS_LIGHT =
        PSPLAT_OPTION_PUNCTUAL | PSPLAT_OPTION_ENVIRONMENT | PSPLAT_OPTION_SHADOWS,
    PSPLAT_OPTIONS_MAPS = PSPLAT_OPTION_BASE_MAP | PSPLAT_OPTION_SURFACE_MAP |
                          PSPLAT_OPTION_NORMAL_MAP | PSPLAT_OPTION_OCCLUSION_MAP |
                          PSPLAT_OPTION_EMISSIVE_MAP,
    PSPLAT_OPTIONS_TEXTURED = PSPLAT_OPTION_MASK | PSPLAT_OPTIONS_MAPS /* any: macro TEXTURED */
};

/* Identifies a variant. */
typedef struct psplat_program_key {
    unsigned options; /* PSPLAT_OPTION_ bits */
    int is_resolve;   /* 1: the resolve pass; 0: a splat pass */
    int pass;         /* PSPLAT_PASS_VISIBILITY ... */
    int is_faded;     /* 1: weights are multiplied by a number of the item's; macro FADE */
    int part;         /* PSPLAT_PART_ALL ...: which splats of a curved batch are drawn */
    int is_boxed;     /* 1: flat splats are rectangles around what lines leave; macro BOX */
    int clip_count;   /* 0 ... PSPLAT_MAX_CLIP_LINES */
    int seam_count;   /* 0 ... clip_count: the last so many of these are seams */
    int shading;      /* PSPLAT_SHADING_LIT ... */
    int light_count;  /* 0 ... PSPLAT_MAX_LIGHTS */
    unsigned host;    /* 0, or the number of the host's resolve function, in place of the shading */
} psplat_program_key;

/* Lists the uniforms that are no samplers: X(name without u_). */
#define PSPLAT_UNIFORMS(X)                                                                         \
    X(projection)                                                                                  \
    X(shift)                                                                                       \
    X(view_direction)                                                                              \
    X(half_viewport)                                                                               \
    X(depth_range)                                                                                 \
    X(apart)                                                                                       \
    X(finish)                                                                                      \
    X(kernel)                                                                                      \
    X(base_color)                                                                                  \
    X(emissive)                                                                                    \
    X(surface)                                                                                     \
    X(map_transform)                                                                               \
    X(map_strength)                                                                                \
    X(mask)                                                                                        \
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

/* A linked program and the locations of its uniforms. A location is -1 where the variant does not
 * use the uniform; GL ignores writes to it. */
typedef struct psplat_program {
    psplat_program_key key;
    GLuint id;
    int is_new; /* 1: it was made by the call that found it */
#define PSPLAT_UNIFORM_MEMBER(name) GLint name;
    PSPLAT_UNIFORMS(PSPLAT_UNIFORM_MEMBER)
#undef PSPLAT_UNIFORM_MEMBER
} psplat_program;

typedef struct psplat_programs {
    psplat_program *list; /* in the order of their first use */
    size_t count, capacity;
    psplat_host_sources hosts;
} psplat_programs;

/* Returns 1 where the program of a key weighs splats, so that it has to know of its seams. */
int psplat_program_has_seams(const psplat_program_key *key);

/* Returns the key without what its program does not use, so that equal programs have equal keys. */
psplat_program_key psplat_program_key_reduce(psplat_program_key key);

/* Finds the program of a key, and compiles it where it does not exist yet. *program is valid until
 * the next call; which program is current afterwards is undefined. Errors: GRAPHICS with the
 * compiler's message, MEMORY. */
psplat_result psplat_programs_find(psplat_programs *programs, const psplat_gl *gl,
                                   const psplat_allocator *allocator, psplat_program_key key,
                                   const psplat_program **program, psplat_error *error);

/* Finds the number of a host's resolve function for psplat_program_key.host. It is valid at least
 * until the next call; a function that had to make room loses its programs. Errors: MEMORY. */
psplat_result psplat_programs_find_host(psplat_programs *programs, const psplat_gl *gl,
                                        const psplat_allocator *allocator,
                                        const psplat_resolve *resolve, unsigned *number,
                                        psplat_error *error);

/* Deletes all programs and sets programs to zero. */
void psplat_programs_destroy(psplat_programs *programs, const psplat_gl *gl,
                             const psplat_allocator *allocator);

/* Return 1 where a shading reads base colours, and where it reads materials and lights as well. */
int psplat_shading_reads_color(int shading);
int psplat_shading_reads_light(int shading);

enum { PSPLAT_MAX_SHADER_PARTS = 5 };

/* The texts of a program's two shaders, each in parts that follow one another; NULL ends a list. */
typedef struct psplat_program_source {
    const char *defines; /* comes first in both */
    const char *vertex[PSPLAT_MAX_SHADER_PARTS], *fragment[PSPLAT_MAX_SHADER_PARTS];
} psplat_program_source;

/* Compiles and links a vertex and a fragment shader. Each source follows the version line of the
 * context, the defines and layout.h. Returns 0 and fills error with PSPLAT_ERROR_GRAPHICS on
 * failure. The caller deletes the program. */
GLuint psplat_program_build(const psplat_gl *gl, const psplat_program_source *source,
                            psplat_error *error);

#endif
