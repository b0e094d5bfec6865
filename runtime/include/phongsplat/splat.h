/* SPDX-License-Identifier: MIT
 *
 * phongsplat/splat.h - the basic types: a splat, its kernel and its material, and how errors are
 * reported.
 *
 * Everything else (asset, renderer, reference rasteriser, converter) includes this header, and it
 * includes no other header of the project. The normative text is schema/README.md, whose sections
 * and equations are cited as "spec 4.2" and "eq. (5)". BSK04 is Botsch, Spornat, Kobbelt: Phong
 * Splatting, 2004; BHZK05 is Botsch, Hornung, Zwicker, Kobbelt: High-Quality Surface Splatting on
 * Today's GPUs, 2005.
 */
#ifndef PHONGSPLAT_SPLAT_H
#define PHONGSPLAT_SPLAT_H

#include <stddef.h>
#include <stdint.h>

/* Marks a function of the API. The libraries are compiled so that all other symbols are hidden. */
#if defined(__GNUC__)
#define PSPLAT_EXPORT __attribute__((visibility("default")))
#else
#define PSPLAT_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The greatest number of clip lines of a splat (spec 3.6). */
#define PSPLAT_MAX_CLIP_LINES 4

/* One Phong splat (BSK04): an elliptical disc (surfel) in object space, flat or curved, with a
 * linear field of normals, cut by up to four clip lines.
 *
 * The unit axes U, V, N are the rotated x, y and z axes. A point q of the splat's plane has
 *
 *     u = U.(q - center) / radius[0]       v = V.(q - center) / radius[1]      (BSK04 eq. 1)
 *
 * and belongs to the splat where u*u + v*v <= 1 and, for each clip line (a, b, c) of bend k,
 * a*u + b*v + c + k*(a*v - b*u)^2/2 >= 0. Lines that are seams (psplat_batch.seam_lines) cut only
 * its material, not its shape. The splat's surface has there the height above that plane
 *
 *     h(u, v) = -r_u (x u + alpha u^2/2 + gamma q u v + q y v + q beta v^2/2)     (spec eq. 1a)
 *
 * with x, y, alpha, beta, gamma = shape, and its normal, of any length, is
 *
 *     n(u, v) = N + (x + gradient[0]*u + gradient[2]*q*v) U
 *                 + (y + gradient[2]*u + gradient[1]*v) V                      (BSK04 eq. 2)
 *
 * where x = normal.U / normal.N, y = normal.V / normal.N and q = radius[1] / radius[0]. Where shape
 * equals (x, y, gradient), that is the normal of the surface itself. */
typedef struct psplat_splat {
    float center[3];   /* in the units of the asset's POSITION */
    float rotation[4]; /* unit quaternion x, y, z, w */
    float radius[2];   /* radius[0] >= radius[1] > 0, in the units of center */
    float normal[3];   /* unit normal at u = v = 0; normal.N > 0 */
    float gradient[3]; /* alpha and beta of BSK04, the change of x with u and of y with v; gamma,
                          the change of y with u, which times q is that of x with v (spec 3.5) */
    float color[4];    /* linear RGBA, multiplies the material's base colour; 1 where unstored */
    float clip[PSPLAT_MAX_CLIP_LINES][3]; /* a, b, c; rows from clip_count on are 0 */
    float bend[PSPLAT_MAX_CLIP_LINES];    /* kappa of each clip line (spec 3.6); 0: straight */
    uint32_t clip_count;                  /* 0 ... PSPLAT_MAX_CLIP_LINES */
    float shape[5]; /* x, y, alpha, beta, gamma of the surface (spec 3.4); all 0: flat */
} psplat_splat;

/* The parts of a material that vary from splat to splat beyond one colour each; only sets of splats
 * that store some of them have finishes (spec 3.10). The colour at (u, v) is
 * color + u color_u + v color_v, clamped to 0 ... 1. */
typedef struct psplat_finish {
    float color_u[3], color_v[3]; /* 0 where unstored */
    float occlusion;              /* 0 ... 1: the part of ambient and environment light that
                                     arrives; 1 where unstored */
    float roughness, metallic;    /* 0 ... 1: multiply the material's factors; 1 where unstored */
    float emissive[3];            /* 0 ... 1: multiplies the material's; 1 where unstored */
} psplat_finish;

/* The texture coordinates of one splat, a polynomial of its parameters (spec 3.11):
 *
 *     T(u, v) = at + u along_u + v along_v + u^2 along_uu + u v along_uv + v^2 along_vv
 *
 * in the space of glTF's TEXCOORD_0, (0, 0) at the upper left corner of an image, before a
 * texture's own transform. */
typedef struct psplat_texcoord {
    float at[2];
    float along_u[2], along_v[2];
    float along_uu[2], along_uv[2], along_vv[2]; /* 0 where unstored: the coordinates are linear */
} psplat_texcoord;

/* Blending kernel psi(r) = exp(-sharpness * r^exponent) for r = sqrt(u*u + v*v) in 0 ... 1, and 0
 * beyond (Pajarola, Sainz, Guidotti 2003, section 4.2, with the support radius b at 1). */
typedef struct psplat_kernel {
    float sharpness; /* a > 0 */
    float exponent;  /* n > 0; 2 is a Gaussian */
} psplat_kernel;

/* The kernel of an asset that states none (spec 3.7) is a Gaussian with psi(1) = exp(-2) = 0.135.
 */
#define PSPLAT_DEFAULT_KERNEL_SHARPNESS 2.0f
#define PSPLAT_DEFAULT_KERNEL_EXPONENT 2.0f

/* How a texture goes on beyond its image. */
typedef enum psplat_wrap {
    PSPLAT_WRAP_REPEAT = 0,
    PSPLAT_WRAP_CLAMP,
    PSPLAT_WRAP_MIRROR
} psplat_wrap;

/* The use of an image by a material. All zeros mean no texture. */
typedef struct psplat_texture {
    uint32_t image;      /* 1 + the index of the image; 0: no texture */
    psplat_wrap wrap[2]; /* of s and t */
    int nearest;         /* 1: magnified without interpolation */
    float transform[6];  /* KHR_texture_transform: rows of a 2 x 3 matrix of (s, t, 1), which turns
                            T into the image's coordinates; all zeros mean the identity */
    float strength;      /* normal scale or occlusion strength; unused in the other slots */
} psplat_texture;

/* The textures of a material. */
typedef enum psplat_texture_slot {
    PSPLAT_TEXTURE_BASE_COLOR = 0,
    PSPLAT_TEXTURE_METALLIC_ROUGHNESS,
    PSPLAT_TEXTURE_NORMAL,
    PSPLAT_TEXTURE_OCCLUSION,
    PSPLAT_TEXTURE_EMISSIVE,
    PSPLAT_TEXTURE_SLOTS
} psplat_texture_slot;

/* The part of a glTF material that splats use. All factors are linear and as in glTF 2.0. */
typedef struct psplat_material {
    float base_color[4]; /* 0 ... 1; glTF default 1 1 1 1 */
    float emissive[3];   /* >= 0 */
    float metallic;      /* 0 ... 1 */
    float roughness;     /* 0 ... 1 */
    int double_sided;    /* 0: splats seen from behind are culled */
    int unlit;           /* 1: KHR_materials_unlit, the base colour is shown without light */
    float alpha_cutoff;  /* alphaMode MASK: what is less opaque is not there; 0: all is opaque */
    psplat_texture textures[PSPLAT_TEXTURE_SLOTS]; /* by slot; splats without texture coordinates
                                                      have none (spec 3.11) */
} psplat_material;

/* The result of every function that can fail. 0 is success. Comments of functions list the errors
 * that they return without the prefix PSPLAT_ERROR_. */
typedef enum psplat_result {
    PSPLAT_OK = 0,
    PSPLAT_ERROR_ARGUMENT, /* an argument is not allowed: NULL, zero size, unknown enum */
    PSPLAT_ERROR_MEMORY,   /* an allocation failed */
    PSPLAT_ERROR_READ,     /* a file cannot be opened or read */
    PSPLAT_ERROR_WRITE,    /* a file cannot be created or written, or already exists */
    PSPLAT_ERROR_FORMAT,   /* bytes are not what the format requires: magic, chunk, JSON, syntax */
    PSPLAT_ERROR_RANGE,    /* a count, offset, index, length or value is outside its range */
    PSPLAT_ERROR_UNSUPPORTED, /* the input is well-formed, but this version does not read it */
    PSPLAT_ERROR_NO_SPLATS,   /* the input is a valid glTF without splats, or a mesh without area */
    PSPLAT_ERROR_RESCALED,    /* another tool changed POSITION but not SCALE (spec 6.2) */
    PSPLAT_ERROR_GRAPHICS,    /* GL or EGL: function missing, shader refused, context unusable */
    PSPLAT_ERROR_INTERRUPTED, /* the caller asked a long operation to stop */
    PSPLAT_RESULT_COUNT
} psplat_result;

/* A description of what went wrong, for people. It is filled only on failure, and every function
 * accepts NULL for it. */
typedef struct psplat_error {
    psplat_result code;
    size_t offset;  /* byte offset in the input that the text is about; 0 where there is none */
    char text[240]; /* one English sentence without a newline, always terminated by a zero */
} psplat_error;

/* Returns a short constant description of a result ("out of memory"), never NULL. */
PSPLAT_EXPORT const char *psplat_result_text(psplat_result result);

/* Fills error (which may be NULL) with a text in the style of printf and returns code, so that a
 * failing function can `return psplat_fail(error, PSPLAT_ERROR_RANGE, offset, "...")`. */
PSPLAT_EXPORT psplat_result psplat_fail(psplat_error *error, psplat_result code, size_t offset,
                                        const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

#ifdef __cplusplus
}
#endif
#endif
