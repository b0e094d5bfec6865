/* SPDX-License-Identifier: MIT
 *
 * phongsplat/phongsplat.h - the runtime: open an asset, upload it, draw it.
 *
 * The runtime has no globals, prints nothing, never exits, opens no window and links no GL: the
 * host hands in an allocator, file access and the GL loader. An asset may be opened on any thread;
 * a renderer and its models belong to the thread whose GL context was current at their creation.
 * Matrices are column-major (m[column * 4 + row]) and act on column vectors, as in GL and glTF.
 *
 *     psplat_asset *asset = NULL;
 *     psplat_error error;
 *     if (psplat_asset_open("part.glb", NULL, &asset, &error)) return fail(error.text);
 *     psplat_renderer *renderer = NULL;
 *     psplat_renderer_desc desc = {.get_proc = my_get_proc};
 *     psplat_renderer_create(&desc, &renderer, &error);
 *     psplat_model *model = NULL;
 *     psplat_model_create(renderer, asset, &model, &error);
 *     // every frame, with the host's framebuffer bound and cleared:
 *     psplat_draw(renderer, &view, &(psplat_item){.model = model}, 1, &error);
 */
#ifndef PHONGSPLAT_PHONGSPLAT_H
#define PHONGSPLAT_PHONGSPLAT_H

#include "splat.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PSPLAT_VERSION_MAJOR 0
#define PSPLAT_VERSION_MINOR 1
#define PSPLAT_VERSION_PATCH 0

/* ---- memory and files ------------------------------------------------------------------- */

/* Zero-initialised: the C library. resize(NULL, 0, n) allocates n bytes, resize(p, old, 0) frees
 * and returns NULL, otherwise reallocates; it returns NULL when out of memory (p stays valid). */
typedef struct psplat_allocator {
    void *(*resize)(void *user, void *memory, size_t old_size, size_t new_size);
    void *user;
} psplat_allocator;

/* Zero-initialised: stdio. read() loads a whole file into memory taken from allocator, stores the
 * block and its size (the block is exactly *size bytes; NULL where *size is 0) and returns
 * PSPLAT_OK, or returns PSPLAT_ERROR_READ, _MEMORY or _RANGE and leaves the outputs alone. The
 * caller of read() owns the block. Files larger than max_size are refused with _RANGE. */
typedef struct psplat_files {
    psplat_result (*read)(void *user, const psplat_allocator *allocator, const char *path,
                          size_t max_size, void **data, size_t *size);
    void *user;
} psplat_files;

/* ---- asset ------------------------------------------------------------------------------ */

typedef struct psplat_asset psplat_asset;

/* Zeros are the defaults. */
typedef struct psplat_asset_desc {
    psplat_allocator allocator;
    psplat_files files;
    const char *base_path; /* memory input only: directory of external buffers; NULL refuses them */
    size_t max_file_size;  /* bytes, of all files and of what comes out of compressed ones; 0 means
                              2 GiB */
    int measures;          /* 1: find psplat_attribute.stored */
    int only_draws; /* 1: for psplat_model_create alone, with less memory and time: splats and
                       finishes of batches are NULL */
} psplat_asset_desc;

/* How a file stores one attribute of a batch (spec 3.2), for tools that show it. */
typedef struct psplat_attribute {
    const char *name;        /* without a leading underscore; constant */
    uint32_t component_type; /* as in glTF: 5126 is float, 5123 unsigned short, ... */
    uint32_t components;     /* of each splat, 1 ... 4 */
    int is_compressed;       /* by EXT_meshopt_compression */
    size_t bytes;            /* of all splats, without padding between them, uncompressed */
    size_t stored;           /* what the file takes for them: bytes, or their share of what was
                                compressed, 0 there unless psplat_asset_desc.measures */
} psplat_attribute;

/* Splats of one clip class of one mesh as one node of the default scene places them (spec 3.1). */
typedef struct psplat_batch {
    const psplat_splat *splats;    /* splat_count of them; shared between instances of a mesh;
                                      NULL in assets that only draw, as the next */
    const psplat_finish *finishes; /* splat_count of them, or NULL: none is stored */
    size_t splat_count;            /* >= 1 */
    uint32_t clip_count;           /* clip lines of every splat in this batch, 0 ... 4 */
    uint32_t primitive;            /* batches with the same number share their splats */
    double model[16]; /* affine: the node's transform to the scene, composed in double */
    psplat_kernel kernel;
    float depth_tolerance; /* epsilon of the visibility pass (spec 5.3), in the units of center */
    psplat_material material;
    float bounds_min[3]; /* box around the unclipped ellipses, object space */
    float bounds_max[3];
    int has_color;          /* 0: color is 1 1 1 1 in every splat */
    int has_gamma;          /* 0: gradient[2] is 0 in every splat */
    int has_color_gradient; /* 0: color_u and color_v are 0 in every finish */
    int has_surface;        /* 0: occlusion, roughness and metallic are 1 in every finish */
    int has_emissive;       /* 0: emissive is 1 in every finish */
    const psplat_attribute *attributes; /* attribute_count of them, in the order of spec 3.2 */
    size_t attribute_count;
} psplat_batch;

/* Opens a .glb, or a .gltf with .bin files beside it or data URIs. desc may be NULL. Checks every
 * count, offset, stride, type and range of what it uses. On success *asset is owned by the caller;
 * on failure *asset is NULL and error (may be NULL) says what and where. The bytes of _memory are
 * not needed after it returns. */
psplat_result psplat_asset_open(const char *path, const psplat_asset_desc *desc,
                                psplat_asset **asset, psplat_error *error);
psplat_result psplat_asset_open_memory(const void *data, size_t size, const psplat_asset_desc *desc,
                                       psplat_asset **asset, psplat_error *error);
void psplat_asset_destroy(psplat_asset *asset); /* NULL is accepted */

/* Batches in drawing order: unclipped first (BSK04 section 4.1). Valid until the asset is
 * destroyed. batch() returns NULL when index >= count. */
size_t psplat_asset_batch_count(const psplat_asset *asset);
const psplat_batch *psplat_asset_batch(const psplat_asset *asset, size_t index);

/* Box of all batches in scene space. */
void psplat_asset_bounds(const psplat_asset *asset, double min[3], double max[3]);

/* ---- renderer --------------------------------------------------------------------------- */

typedef struct psplat_renderer psplat_renderer;
typedef struct psplat_model psplat_model;

/* get_proc is required: eglGetProcAddress, glfwGetProcAddress or the engine's own. The context
 * must be GL >= 3.3 core or GLES >= 3.0 and current during every call below. GLES and WebGL 2 need
 * EXT_color_buffer_float (GLES before 3.2) and EXT_float_blend; without the second, or with only
 * EXT_color_buffer_half_float, sums are kept in 16 bits: colours lose precision where many splats
 * meet, and depth is that of the nearest splat plus its tolerance.
 *
 * Renderers, in one context or several, know nothing of each other. Where a context is lost, as
 * glGetGraphicsResetStatus or glGetError say, the call returns GRAPHICS and so does every later one
 * with that renderer. Its destroy functions then free memory and leave GL alone, so that it does
 * not matter which context is current, if any; start anew in another context. Errors other than a
 * lost context leave the renderer as usable as before. */
typedef struct psplat_renderer_desc {
    void *(*get_proc)(void *user, const char *name);
    void *user;
    psplat_allocator allocator;
} psplat_renderer_desc;

psplat_result psplat_renderer_create(const psplat_renderer_desc *desc, psplat_renderer **renderer,
                                     psplat_error *error);
/* Destroy models first. NULL is accepted. */
void psplat_renderer_destroy(psplat_renderer *renderer);

/* Bytes of textures on the GPU, as asked of GL; drivers may round up, and keep programs beside.
 * Targets and shadow maps go with the renderer. */
typedef struct psplat_memory {
    size_t models;
    size_t targets; /* of the last size of view, and of the one before while both are in use */
    size_t environments;
    size_t shadows; /* of the last size asked for */
} psplat_memory;

/* What the renderer and all that belongs to it hold now; zeros for NULL. */
psplat_memory psplat_renderer_memory(const psplat_renderer *renderer);

/* Uploads an asset; the asset may be destroyed afterwards. */
psplat_result psplat_model_create(psplat_renderer *renderer, const psplat_asset *asset,
                                  psplat_model **model, psplat_error *error);
void psplat_model_destroy(psplat_renderer *renderer, psplat_model *model);

typedef struct psplat_model_info {
    size_t splat_count; /* drawn: splats of a mesh count as often as nodes place it */
    size_t batch_count;
    size_t bytes; /* of its textures, part of psplat_memory.models */
} psplat_model_info;

/* Zeros for NULL. */
psplat_model_info psplat_model_describe(const psplat_model *model);

typedef enum psplat_mode {
    PSPLAT_MODE_PHONG = 0,  /* linear normal fields blended, lit once per pixel */
    PSPLAT_MODE_GAUSSIAN,   /* splats lit with their centre normal, colours blended */
    PSPLAT_MODE_FLAT,       /* splats lit with their centre normal, nearest one wins */
    PSPLAT_MODE_PARAMETERS, /* debug: nearest splat's (u, v, index in draw order, 1), unencoded;
                               indices as a float, exact below 2^24 */
    PSPLAT_MODE_COUNT
} psplat_mode;

typedef enum psplat_culling {
    PSPLAT_CULL_BY_MATERIAL = 0, /* as the material's doubleSided says */
    PSPLAT_CULL_NEVER,
    PSPLAT_CULL_ALWAYS
} psplat_culling;

/* What the resolve pass makes of a pixel's normal, colour and depth: X(name, file, what it reads),
 * the file being shaders/resolve_<file>.glsl. What a shading does not read is not drawn.
 *
 *     LIT       the material under the view's lights (spec 5.6)
 *     UNLIT     the base colour alone, the albedo
 *     TOON      light in three steps, black contours where depth or normal jump (BHZK05 section 6)
 *     NORMAL    the normal in eye space, 1/2 + n/2
 *     DEPTH     white at the near plane, black at the far one, linear in between
 *     OVERDRAW  splats blended into a pixel: 1 blue, 8 green, 16 yellow, 32 red, 64 white; the
 *               number itself where linear_output is set
 *     SPLATS    the nearest splat alone, each in a colour of its own */
#define PSPLAT_SHADINGS(X)                                                                         \
    X(LIT, lit, LIGHT)                                                                             \
    X(UNLIT, unlit, COLOR)                                                                         \
    X(TOON, toon, LIGHT)                                                                           \
    X(NORMAL, normal, NOTHING)                                                                     \
    X(DEPTH, depth, NOTHING)                                                                       \
    X(OVERDRAW, overdraw, NOTHING)                                                                 \
    X(SPLATS, splats, NOTHING)

typedef enum psplat_shading {
#define PSPLAT_SHADING_ENUM(name, file, reads) PSPLAT_SHADING_##name,
    PSPLAT_SHADINGS(PSPLAT_SHADING_ENUM)
#undef PSPLAT_SHADING_ENUM
        PSPLAT_SHADING_COUNT
} psplat_shading;

#define PSPLAT_MAX_LIGHTS 8
#define PSPLAT_MAX_SHADOWS 4

typedef enum psplat_light_type {
    PSPLAT_LIGHT_DIRECTIONAL = 0,
    PSPLAT_LIGHT_POINT,
    PSPLAT_LIGHT_SPOT
} psplat_light_type;

/* A light with the units and the falloff of KHR_lights_punctual (spec 5.6). */
typedef struct psplat_light {
    psplat_light_type type;
    float color[3];     /* linear colour times intensity, >= 0: lux (directional; pi lights white to
                           1 where it falls in squarely) or candela (point, spot) */
    float direction[3]; /* in which it shines, scene space, any length > 0; not of point lights */
    double position[3]; /* scene space; not of directional lights */
    float range; /* where its light ends, scene units; 0: nowhere; not of directional lights */
    float inner_angle; /* spot: radians from the axis up to which it shines fully, */
    float outer_angle; /* and from which on not at all: inner < outer <= pi / 2; 0: pi / 4 */
    int casts_shadow;  /* directional and spot lights; the first PSPLAT_MAX_SHADOWS of a view */
} psplat_light;

/* Light from all around: a cube map, prefiltered for diffuse and glossy reflection. It belongs to
 * the renderer's context. */
typedef struct psplat_environment psplat_environment;

typedef struct psplat_environment_desc {
    const float *radiance; /* 6 size size 3 linear values >= 0: faces +x -x +y -y +z -z in scene
                              space, laid out as GL's cube maps */
    int size;              /* texels along an edge, 1 ... 1024 */
} psplat_environment_desc;

/* Takes some tenths of a second. The radiance is not needed after it returns. */
psplat_result psplat_environment_create(psplat_renderer *renderer,
                                        const psplat_environment_desc *desc,
                                        psplat_environment **environment, psplat_error *error);
/* NULL is accepted. */
void psplat_environment_destroy(psplat_renderer *renderer, psplat_environment *environment);

/* A camera and how to draw. All matrices are double: they are composed in double and only
 * their product becomes float, so that models far from the origin do not tremble. Lengths in eye
 * space may be from 1e-18 to 1e18; surfaces closer than 2e-6 of their distance from the eye blend
 * (spec 5.3). Zeros are the defaults of all but the matrices and the size. */
typedef struct psplat_view {
    double view[16];       /* scene to eye; rigid */
    double projection[16]; /* eye to clip, GL conventions (z from -w to w); how far apart its near
                              and far planes are makes no difference to splats, which are compared
                              in a depth buffer fitted to what the view shows */
    int x, y;              /* lower left corner in the bound framebuffer, pixels */
    int width, height;     /* pixels, >= 1 */
    psplat_mode mode;
    psplat_shading shading; /* not of PSPLAT_MODE_PARAMETERS */
    psplat_culling culling;
    psplat_light lights[PSPLAT_MAX_LIGHTS];
    int light_count;                       /* of lights that shine */
    float ambient[3];                      /* radiance from everywhere, linear */
    const psplat_environment *environment; /* NULL: none */
    int shadow_size; /* edge of a shadow map, texels: 16 ... 8192, and at most a quarter of GL's
                        largest texture; 0: 1024 or that quarter */
    int no_filter;   /* 1: without the screen-space filter of spec 5.8, splats below a pixel may be
                        missed */
    int linear_output; /* 0: sRGB-encode colours; 1: the framebuffer is float or encodes itself */
} psplat_view;

/* One model to draw. transform is applied after the asset's own node transforms; all zeros mean
 * the identity. It may be any invertible affine matrix. */
typedef struct psplat_item {
    psplat_model *model;
    double transform[16];
} psplat_item;

/* Draws into the framebuffer bound for drawing, of any colour and depth format: colour (alpha 1, to
 * draw buffer 0) and depth of covered pixels are written where the depth test against what is there
 * already passes (GL_LEQUAL); other pixels are left as they are; the host clears. So splats and the
 * host's geometry hide each other pixel by pixel, whichever is drawn first. Of the host's own state
 * the scissor test, the depth range and GL_FRAMEBUFFER_SRGB (see linear_output) apply, and nothing
 * else. In a framebuffer of several samples a pixel all samples take the pixel's one colour and
 * depth: the host's edges before and behind splats stay smooth, those of splats are as without.
 * What draw buffers other than 0 receive in covered pixels is undefined in GL; in WebGL there must
 * be none. After the first frame of its kind nothing is allocated, as long as frames have views of
 * no more than two sizes.
 *
 * State that is set is put back, here and in every function above: framebuffer, program, vertex
 * array, viewport, capabilities, blending, masks, depth function, culling, polygon mode, pixel
 * unpacking, and of the texture units 0 ... 8 the 2D texture, the cube map and the sampler. State
 * of several draw buffers or viewports (glEnablei, glColorMaski, glViewportIndexed) is read and put
 * back as that of number 0. Not put back:
 *
 *     glGetError                the flags are read where something is made or fails; what the host
 *                               left there is dropped and fails nothing
 *     glGetGraphicsResetStatus  is asked once a call, where the context has it
 *
 * and to be at its default: glClipControl, conditional rendering, transform feedback, and what
 * extensions add to rasterisation (EXT_depth_bounds_test, in GLES EXT_clip_cull_distance); in WebGL
 * UNPACK_FLIP_Y and UNPACK_PREMULTIPLY_ALPHA. Depth that is reversed (greater is nearer) cannot be
 * shared. Active queries count what is drawn here too. */
psplat_result psplat_draw(psplat_renderer *renderer, const psplat_view *view,
                          const psplat_item *items, size_t item_count, psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
