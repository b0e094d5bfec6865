/* SPDX-License-Identifier: MIT
 *
 * phongsplat/phongsplat.h - the runtime: opens an asset, uploads it and draws it.
 *
 * The runtime has no globals, prints nothing, never exits, opens no window and links no GL: the
 * host provides an allocator, file access and a GL loader. An asset may be opened on any thread. A
 * renderer and its models belong to the thread whose GL context was current when they were created.
 * Matrices are column-major (m[column * 4 + row]) and act on column vectors, as in GL and glTF.
 * Descriptions (structs called ..._desc), views and items are zero-initialised by the caller; a
 * member that is 0 has its default, which its comment states. They need not outlive the call, but
 * what an allocator's user points to must outlive everything that was created with it.
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

/* An allocator. Where it is zero-initialised, the C library is used.
 *
 * resize(user, NULL, 0, n) allocates n bytes, aligned for any type. resize(user, p, old, 0) frees p
 * and returns NULL. resize(user, p, old, n) changes the size of p from old to n bytes and returns
 * the block, which may have moved. Where memory runs out it returns NULL and p stays valid. */
typedef struct psplat_allocator {
    void *(*resize)(void *user, void *memory, size_t old_size, size_t new_size);
    void *user;
} psplat_allocator;

/* File access. Where it is zero-initialised, stdio is used.
 *
 * read() loads a whole file into memory taken from allocator, stores the block in *data and its
 * size in *size, and returns PSPLAT_OK. The block has exactly *size bytes and is NULL where *size
 * is 0; the caller of read() owns it. On failure read() leaves both outputs alone and returns
 * PSPLAT_ERROR_READ, PSPLAT_ERROR_MEMORY, or PSPLAT_ERROR_RANGE where the file is larger than
 * max_size bytes. */
typedef struct psplat_files {
    psplat_result (*read)(void *user, const psplat_allocator *allocator, const char *path,
                          size_t max_size, void **data, size_t *size);
    void *user;
} psplat_files;

/* ---- asset ------------------------------------------------------------------------------ */

/* An opened asset: the sets of splats that the default scene of a glTF file shows. */
typedef struct psplat_asset psplat_asset;

/* The parameters of psplat_asset_open. Zeros are the defaults. */
typedef struct psplat_asset_desc {
    psplat_allocator allocator;
    psplat_files files;
    const char *base_path; /* directory of external buffers and images, for
                              psplat_asset_open_memory alone; NULL: those are refused */
    size_t max_file_size;  /* bytes that all files together and their decompressed data may have,
                              a splat of a stream (spec 3.12) 132 of them; 0 means 2 GiB */
    int measures;          /* 1: psplat_attribute.stored is computed for compressed data too */
    int only_draws;        /* 1: the asset is for psplat_model_create alone, takes less memory and
                              opens faster; psplat_batch.splats, finishes and texcoords are NULL */
} psplat_asset_desc;

/* The storage of one attribute of a batch in its file (spec 3.2), for tools that show it. */
typedef struct psplat_attribute {
    const char *name;        /* without a leading underscore; a constant string */
    uint32_t component_type; /* as in glTF: 5126 is float, 5123 is unsigned short, ...; 0 where it
                                is in a coded stream (spec 3.12), of which floats are made */
    uint32_t components;     /* numbers of each splat, 1 ... 4 */
    int is_compressed;       /* 1: by EXT_meshopt_compression, or in a stream */
    size_t bytes;            /* of all splats, uncompressed and without padding between them */
    size_t stored;           /* bytes that the file takes for them: the same, or where they are
                                compressed their part of the compressed bytes. In the second case
                                it is 0 unless psplat_asset_desc.measures was 1 */
} psplat_attribute;

/* The splats of one primitive of one mesh, as one node of the default scene places them (spec 3.1).
 * All of them have the same number of clip lines. */
typedef struct psplat_batch {
    const psplat_splat *splats;    /* splat_count of them, shared between instances of a mesh; NULL
                                      where psplat_asset_desc.only_draws was 1 */
    const psplat_finish *finishes; /* splat_count of them; NULL where the file stores none or
                                      psplat_asset_desc.only_draws was 1 */
    const psplat_texcoord *texcoords; /* splat_count of them; NULL where the file stores none or
                                         psplat_asset_desc.only_draws was 1 */
    size_t splat_count;               /* >= 1 */
    uint32_t clip_count;              /* clip lines of every splat in this batch, 0 ... 4 */
    uint32_t seam_lines; /* the last so many of a splat's lines are seams (spec 3.6): beyond them
                            the splat goes on, its material does not */
    uint32_t primitive;  /* batches with the same number share their splats */
    uint32_t level; /* of detail, at which the batch is drawn first; 0 is the finest. Where a */
    uint32_t last_level; /* mesh has fewer levels than others, its coarsest stands for the rest */
    double model[16];    /* affine transform from object space to the scene, composed in double */
    psplat_kernel kernel;
    float depth_tolerance; /* depthTolerance of spec 5.3, in the units of psplat_splat.center */
    psplat_material material;
    float bounds_min[3]; /* axis-aligned bounding box of the unclipped splats, object space */
    float bounds_max[3];
    int has_color;          /* 0: color is 1 1 1 1 in every splat */
    int has_gamma;          /* 0: gradient[2] is 0 in every splat */
    int is_curved;          /* 0: shape is 0 in every splat */
    int has_shape;          /* 0: in a curved batch, shape is that of the normal field */
    int has_bends;          /* 0: bend is 0 in every splat */
    int has_color_gradient; /* 0: color_u and color_v are 0 in every finish */
    int has_surface;        /* 0: occlusion, roughness and metallic are 1 in every finish */
    int has_emissive;       /* 0: emissive is 1 in every finish */
    int has_texcoord;      /* 0: the splats have no texture coordinates, the material no textures */
    int has_texcoord_bend; /* 0: texture coordinates are linear over every splat */
    const psplat_attribute *attributes; /* attribute_count of them, in the order of spec 3.2 */
    size_t attribute_count;
} psplat_batch;

/* Opens a .glb file, or a .gltf file with .bin files beside it or with data URIs; open_memory opens
 * the bytes of such a file, which are not needed after it returns. Images are taken from the file,
 * from data URIs or from files beside it, where textures of splats need them, and are not decoded.
 * desc may be NULL. Every count, offset, stride, type and range of what is used is checked. On
 * success *asset belongs to the caller, who destroys it. On failure *asset is NULL, and error
 * (which may be NULL) says what is wrong and where. Errors: ARGUMENT, MEMORY, READ, FORMAT, RANGE,
 * UNSUPPORTED, NO_SPLATS, RESCALED. */
PSPLAT_EXPORT psplat_result psplat_asset_open(const char *path, const psplat_asset_desc *desc,
                                              psplat_asset **asset, psplat_error *error);
PSPLAT_EXPORT psplat_result psplat_asset_open_memory(const void *data, size_t size,
                                                     const psplat_asset_desc *desc,
                                                     psplat_asset **asset, psplat_error *error);

/* Frees an asset with all of its batches. NULL is accepted. */
PSPLAT_EXPORT void psplat_asset_destroy(psplat_asset *asset);

/* Return the number of batches of the finest level and one batch, in drawing order: those without
 * clip lines come first (BSK04 section 4.1). A batch is valid until the asset is destroyed. Batches
 * of coarser levels (psplat_asset_level_count) follow, level by level; psplat_asset_all_batch_count
 * counts them too. An asset that is NULL has no batches, and psplat_asset_batch returns NULL where
 * index is not below the number of all. */
PSPLAT_EXPORT size_t psplat_asset_batch_count(const psplat_asset *asset);
PSPLAT_EXPORT size_t psplat_asset_all_batch_count(const psplat_asset *asset);
PSPLAT_EXPORT const psplat_batch *psplat_asset_batch(const psplat_asset *asset, size_t index);

/* A level of detail of an asset: by how much it differs from the surface that the finest one was
 * made of (spec 3.13), where that is worst among the meshes of the scene. Errors are 0 where the
 * file states none. */
typedef struct psplat_level {
    double distance;    /* proven, both ways, scene units */
    double normal;      /* root mean square, degrees */
    double outline;     /* mean distance between outlines from all sides, scene units */
    size_t splat_count; /* of its batches */
} psplat_level;

/* Return the number of levels of detail and one of them; 0 is the finest. Most files have one. An
 * asset that is NULL has none, and psplat_asset_get_level returns NULL where index is not below the
 * number. What a level shows are the batches with psplat_batch.level <= index <= last_level. */
PSPLAT_EXPORT size_t psplat_asset_level_count(const psplat_asset *asset);
PSPLAT_EXPORT const psplat_level *psplat_asset_get_level(const psplat_asset *asset, size_t index);

/* An image that materials of splats with texture coordinates use, still encoded as PNG, JPEG or
 * whatever else the file holds (WebP, KTX 2 and DDS where EXT_texture_webp, KHR_texture_basisu or
 * MSFT_texture_dds name them and a texture has no other source). It is valid until the asset is
 * destroyed. */
typedef struct psplat_asset_image {
    const void *data; /* size bytes */
    size_t size;
    const char *mime_type; /* "image/png", "image/jpeg", ... as the file states it or its first
                              bytes show it; "" where neither does */
    const char *name;      /* the file's name for it or its path, for messages; "" without one */
} psplat_asset_image;

/* Return the number of images and one of them. psplat_texture.image is 1 + such an index. Images of
 * the file that no splat shows are not among them. An asset that is NULL has no images, and
 * psplat_asset_get_image returns NULL where index is not below the number. */
PSPLAT_EXPORT size_t psplat_asset_image_count(const psplat_asset *asset);
PSPLAT_EXPORT const psplat_asset_image *psplat_asset_get_image(const psplat_asset *asset,
                                                               size_t index);

/* Computes an axis-aligned box around all batches of the finest level in scene space, at rest. */
PSPLAT_EXPORT void psplat_asset_bounds(const psplat_asset *asset, double min[3], double max[3]);

/* ---- animations ------------------------------------------------------------------------- */

/* An animation of an asset: it moves nodes of the scene, and with them the batches that they place.
 * Splats are rigid. It is valid until the asset is destroyed. */
typedef struct psplat_animation {
    const char *name;     /* "" where the file gives none */
    double duration;      /* the time of its last key, seconds; the first may be later than 0 */
    size_t channel_count; /* that move the translation, the rotation or the scale of a node with
                             splats, or of one above it; the others count for nothing */
} psplat_animation;

/* Return the number of animations and one of them, in the order of the file. An asset that is NULL
 * has none, and psplat_asset_get_animation returns NULL where index is not below the number. */
PSPLAT_EXPORT size_t psplat_asset_animation_count(const psplat_asset *asset);
PSPLAT_EXPORT const psplat_animation *psplat_asset_get_animation(const psplat_asset *asset,
                                                                 size_t index);

/* Where all batches of an asset are at one time of one of its animations. An item is drawn in its
 * pose, so that one model may be in many poses at once. */
typedef struct psplat_pose psplat_pose;

/* Makes a pose of an asset, which must outlive it; models need not be there. It begins at rest, as
 * the file's nodes stand: batches are where psplat_batch.model says. On success *pose belongs to
 * the caller, who destroys it; on failure it is NULL. A pose is for one thread at a time, and poses
 * of one asset are independent. Errors: ARGUMENT, MEMORY. */
PSPLAT_EXPORT psplat_result psplat_pose_create(const psplat_asset *asset, psplat_pose **pose,
                                               psplat_error *error);

/* Destroys a pose. NULL is accepted. */
PSPLAT_EXPORT void psplat_pose_destroy(psplat_pose *pose);

/* Moves everything to where it is at a time of an animation, seconds (glTF 2.0 appendix C): what
 * the animation does not move is at rest. Before its first key a channel has the value of that key,
 * after its last key the value of that one; a host that wants a loop passes fmod(time, duration).
 * Nothing is allocated. Errors: ARGUMENT (there is no such animation, or time is not finite), RANGE
 * (the file's numbers are so large that something leaves what a double can hold; then the pose is
 * at rest). */
PSPLAT_EXPORT psplat_result psplat_pose_set(psplat_pose *pose, size_t animation, double time,
                                            psplat_error *error);

/* Moves everything back to rest. */
PSPLAT_EXPORT void psplat_pose_rest(psplat_pose *pose);

/* Returns the matrix of a batch, 16 numbers, that stands for psplat_batch.model in this pose, or
 * NULL where there is no such batch. It is valid until the pose is destroyed, and follows it. A
 * matrix may be singular, where a scale is 0: then the batch is not drawn. */
PSPLAT_EXPORT const double *psplat_pose_matrix(const psplat_pose *pose, size_t batch);

/* Computes an axis-aligned box around all batches in scene space, in this pose. */
PSPLAT_EXPORT void psplat_pose_bounds(const psplat_pose *pose, double min[3], double max[3]);

/* ---- renderer --------------------------------------------------------------------------- */

/* A renderer: GL objects of one context. It belongs to the thread of that context. */
typedef struct psplat_renderer psplat_renderer;

/* An asset uploaded to the GPU. It belongs to the renderer that it was created with. */
typedef struct psplat_model psplat_model;

/* The pixels of a decoded image, or a texture of the host's that holds them. */
typedef struct psplat_pixels {
    const uint8_t *rgba; /* height x width x 4 as the image stores them, the first row at the top;
                            NULL where texture is not 0 */
    uint32_t width, height; /* 1 ... GL_MAX_TEXTURE_SIZE */
    unsigned texture; /* the name of a 2D texture, complete with its mipmaps, whose first row is
                         the top of the image; 0: rgba is uploaded */
    void *user;       /* for release */
} psplat_pixels;

/* Decoding of images, which the host provides: the runtime has no decoder. load() is called once
 * for each image and each of its uses as colours (is_srgb 1: a host's texture has to return linear
 * light) and as other numbers (is_srgb 0); it fills *pixels and returns PSPLAT_OK, or fills error
 * and returns the result with which the model's creation is to fail. release() is called once for
 * each load() that succeeded: right after the upload, or for a texture when the model is destroyed.
 * It may be NULL. Where load is NULL, splats are drawn without textures. */
typedef struct psplat_images {
    psplat_result (*load)(void *user, const psplat_asset_image *image, int is_srgb,
                          psplat_pixels *pixels, psplat_error *error);
    void (*release)(void *user, psplat_pixels *pixels);
    void *user;
} psplat_images;

/* Chooses how psplat_draw treats the GL state of the host (see there). */
typedef enum psplat_state_policy {
    PSPLAT_STATE_RESTORED = 0, /* what a frame changes is read before and put back after it */
    PSPLAT_STATE_HOST_RESETS   /* a frame reads no state and leaves GL's initial values behind */
} psplat_state_policy;

/* The parameters of psplat_renderer_create. get_proc is required and returns the address of a GL
 * function, or NULL where there is none: eglGetProcAddress, glfwGetProcAddress or the engine's
 * own. The context must be GL >= 3.3 core, GLES >= 3.0 or WebGL 2, and it must be current during
 * every call below. GLES and WebGL 2 need EXT_color_buffer_float (GLES before 3.2) and
 * EXT_float_blend. Without the second, or with EXT_color_buffer_half_float instead of the first,
 * sums are kept in 16 bits: then colours lose precision where many splats meet, depth is that of
 * the nearest splat plus its tolerance (spec 5.3), and PSPLAT_MODE_PARAMETERS rounds to 11 bits.
 *
 * Renderers are independent of each other, in one context or several. Where the context is lost,
 * as glGetGraphicsResetStatus or glGetError say, the call returns PSPLAT_ERROR_GRAPHICS, and so
 * does every later call with that renderer. Its destroy functions then free memory and leave GL
 * alone, so it does not matter which context is current, if any; the host creates a new renderer
 * in another context. After any other error the renderer is as usable as before. Under
 * PSPLAT_STATE_HOST_RESETS frames do not ask whether the context is lost (see psplat_draw). */
typedef struct psplat_renderer_desc {
    void *(*get_proc)(void *user, const char *name);
    void *user; /* passed to get_proc */
    psplat_allocator allocator;
    psplat_images images;
    psplat_state_policy state;
    int half_targets; /* not 0: sums are kept in 16 bits although the context can keep them in 32.
                         GPUs blend them faster: on an NVIDIA H200 frames took 18 to 35 % less
                         time. Software rasterisers are slower with them */
} psplat_renderer_desc;

/* Creates a renderer in the current context. On success *renderer belongs to the caller, who
 * destroys it; on failure it is NULL. Errors: ARGUMENT, MEMORY, GRAPHICS (the context lacks a
 * function, version or extension, which the text names). */
PSPLAT_EXPORT psplat_result psplat_renderer_create(const psplat_renderer_desc *desc,
                                                   psplat_renderer **renderer, psplat_error *error);

/* Destroys a renderer. Its models and environments must be destroyed before. NULL is accepted. */
PSPLAT_EXPORT void psplat_renderer_destroy(psplat_renderer *renderer);

/* Bytes of textures on the GPU, as asked of GL. Drivers may round them up, and shader programs
 * come on top. */
typedef struct psplat_memory {
    size_t models;
    size_t targets; /* render targets, for the last size of view and, while both are in use,
                       for the one before; they are freed with the renderer */
    size_t environments;
    size_t shadows; /* shadow maps of the last size asked for; freed with the renderer */
} psplat_memory;

/* Returns what the renderer and everything created with it hold now, or zeros where renderer is
 * NULL. */
PSPLAT_EXPORT psplat_memory psplat_renderer_memory(const psplat_renderer *renderer);

/* Uploads an asset, which is not needed after the call but for poses. On success *model belongs to
 * the caller, who destroys it; on failure it is NULL. Errors: ARGUMENT, MEMORY (of the allocator or
 * of GL), RANGE (a primitive has more splats, or an image more pixels, than GL's largest texture
 * holds), GRAPHICS, and those of psplat_images.load. */
PSPLAT_EXPORT psplat_result psplat_model_create(psplat_renderer *renderer,
                                                const psplat_asset *asset, psplat_model **model,
                                                psplat_error *error);

/* Destroys a model of this renderer. NULL is accepted for either. */
PSPLAT_EXPORT void psplat_model_destroy(psplat_renderer *renderer, psplat_model *model);

/* Numbers about a model. */
typedef struct psplat_model_info {
    size_t splat_count; /* that are drawn of the finest level: the splats of a mesh count once for
                           each of its nodes */
    size_t batch_count; /* of the finest level */
    size_t bytes;       /* of the textures of all levels, a part of psplat_memory.models */
    size_t level_count; /* as psplat_asset_level_count */
} psplat_model_info;

/* Returns the numbers of a model, or zeros where model is NULL. */
PSPLAT_EXPORT psplat_model_info psplat_model_describe(const psplat_model *model);

/* Chooses how splats are blended and lit. GAUSSIAN and FLAT are for comparison (spec 5.7). */
typedef enum psplat_mode {
    PSPLAT_MODE_PHONG = 0, /* linear normal fields are blended, and each pixel is lit once */
    PSPLAT_MODE_GAUSSIAN,  /* splats are lit with the normal of their centre, and colours blended */
    PSPLAT_MODE_FLAT,      /* splats are lit with the normal of their centre; the nearest wins */
    PSPLAT_MODE_PARAMETERS, /* debug: (u, v, index in draw order, 1) of the nearest splat, never
                               encoded; the index is a float, exact below 2^24 */
    PSPLAT_MODE_COUNT
} psplat_mode;

/* Chooses which of the splats that are seen from behind are left out. */
typedef enum psplat_culling {
    PSPLAT_CULL_BY_MATERIAL = 0, /* those whose material is not doubleSided */
    PSPLAT_CULL_NEVER,           /* none */
    PSPLAT_CULL_ALWAYS           /* all */
} psplat_culling;

/* Lists the shadings, the ways in which the resolve pass turns a pixel's normal, colour and depth
 * into its final colour: X(name, file, what it reads). The code is shaders/resolve_<file>.glsl.
 * Attributes that a shading does not read are not drawn.
 *
 *     LIT       the material under the view's lights (spec 5.6)
 *     UNLIT     the base colour (albedo) without light
 *     TOON      light in three steps, with black contours where depth or normal jump (BHZK05
 *               section 6)
 *     NORMAL    the normal in eye space, 1/2 + n/2
 *     DEPTH     white at the near plane, black at the far one, linear in between
 *     OVERDRAW  the number of splats blended into a pixel: 1 is blue, 8 green, 16 yellow, 32 red,
 *               64 white; the number itself where linear_output is 1
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

/* The greatest number of lights of a view, and of those among them that cast shadows. */
#define PSPLAT_MAX_LIGHTS 8
#define PSPLAT_MAX_SHADOWS 4

typedef enum psplat_light_type {
    PSPLAT_LIGHT_DIRECTIONAL = 0,
    PSPLAT_LIGHT_POINT,
    PSPLAT_LIGHT_SPOT
} psplat_light_type;

/* A light with the units and the falloff of KHR_lights_punctual (spec 5.6). Directional lights
 * ignore position and range, point lights ignore direction, and only spot lights use the angles. */
typedef struct psplat_light {
    psplat_light_type type;
    float color[3];     /* linear colour times intensity, each >= 0: in lux for directional lights
                           (pi lux light a white surface that faces the light to 1), in candela for
                           point and spot lights */
    float direction[3]; /* in which it shines, scene space, any length > 0 */
    double position[3]; /* scene space */
    float range;        /* distance at which its light ends, scene units; 0: it ends nowhere */
    float inner_angle;  /* radians from the axis up to which a spot light shines fully, >= 0 */
    float outer_angle;  /* radians from the axis beyond which it does not shine: inner < outer <=
                           pi / 2; 0 means pi / 4 */
    int casts_shadow;   /* 1: it casts shadows, if it is directional or a spot light and one of the
                           first PSPLAT_MAX_SHADOWS of a view that do */
} psplat_light;

/* An environment map: light from all directions as a cube map, prefiltered for diffuse and glossy
 * reflection. It belongs to the renderer that it was created with. */
typedef struct psplat_environment psplat_environment;

typedef struct psplat_environment_desc {
    const float *radiance; /* 6 x size x size x 3 finite linear values >= 0: faces +x -x +y -y +z
                              -z in scene space, each laid out as a face of a GL cube map */
    int size;              /* texels along an edge, 1 ... 1024 */
} psplat_environment_desc;

/* Prefilters a cube map and uploads it, which takes some tenths of a second. The radiance is not
 * needed after it returns. On success *environment belongs to the caller, who destroys it; on
 * failure it is NULL. Errors: ARGUMENT, MEMORY, GRAPHICS. */
PSPLAT_EXPORT psplat_result psplat_environment_create(psplat_renderer *renderer,
                                                      const psplat_environment_desc *desc,
                                                      psplat_environment **environment,
                                                      psplat_error *error);

/* Destroys an environment of this renderer. NULL is accepted for either. */
PSPLAT_EXPORT void psplat_environment_destroy(psplat_renderer *renderer,
                                              psplat_environment *environment);

/* The greatest number of texture units that the renderer uses, 0 ... PSPLAT_HOST_UNIT - 1. The
 * units from PSPLAT_HOST_UNIT on are the host's: no function of the renderer touches them. */
#define PSPLAT_HOST_UNIT 14

/* Chooses what of a pixel a host's resolve function reads. What it does not read is not drawn, and
 * undefined. */
typedef enum psplat_reads {
    PSPLAT_READS_MATERIAL = 0, /* all of Pixel; shade() lights it with the lights of the view */
    PSPLAT_READS_COLOR,        /* window, normal, color */
    PSPLAT_READS_NORMAL        /* window, normal */
} psplat_reads;

/* A resolve function of the host's, in GLSL, which takes the place of a shading: it is called once
 * for each pixel that splats cover, after blending, and writes what it likes to as many outputs as
 * the host's framebuffer has. So a deferred engine gets splats into its G-buffer and lights them
 * with everything else, and a forward one lights them with its own code:
 *
 *     layout(location = 0) out vec4 o_normal;
 *     layout(location = 1) out vec4 o_albedo;
 *     void resolve(Pixel pixel) {
 *         o_normal = vec4(0.5 + 0.5 * normalize(pixel.normal), pixel.surface.y);
 *         o_albedo = vec4(pixel.color, pixel.surface.x);
 *     }
 *
 * source is valid in GLSL 3.30 and GLSL ES 3.00, has no #version, declares its outputs with
 * locations and defines void resolve(Pixel pixel). It follows shaders/shading.glsl and
 * shaders/resolve.frag, and may use what these define; names that begin with u_ or v_ are theirs,
 * as are target_at and names in capitals.
 *
 *     struct Pixel {
 *         vec3 window;   // pixel x and y in the view (its centres are at 1/2), window depth
 *         vec3 normal;   // in eye space, of any length
 *         float weight;  // sum of the weights of the pixel's splats, > 0
 *         vec3 color;    // base colour, linear
 *         vec3 emissive; // linear
 *         vec4 surface;  // metallic, roughness, unlit, occlusion, 0 ... 1 each
 *     };
 *     Pixel pixel_at(ivec2 pixel);     // a pixel of the view, at most 16 from this one to each
 *                                      // side; its weight is 0 where nothing is
 *     vec3 position_of(vec3 window);   // the place of a Pixel.window in eye space
 *     vec3 view_direction(vec2 pixel); // from there to the eye, unit length, eye space
 *     vec3 shade(vec3 normal, vec3 window, vec3 color, vec3 emissive, vec4 surface);
 *                                      // radiance under the view's lights (spec 5.6)
 *     vec3 encode(vec3 linear);        // to sRGB, unless linear_output is 1
 *
 * Depth is written as with a shading, and where it fails the depth test so do the outputs. Window
 * depths of a Pixel are those of the renderer's own fitted range and mean something to position_of
 * alone. */
typedef struct psplat_resolve {
    const char *source; /* zero-terminated; compared by content, so it may be another copy in each
                           frame. The programs of the 16 sources that were used last are kept */
    psplat_reads reads;
    int filters_light; /* 1: source also defines float light_part(int light, vec3 position, vec3
                          normal), and shade() multiplies the light of number `light` in the view by
                          it: a lookup in the host's shadow map, a cookie. position and normal (of
                          unit length) are in eye space */
    /* Called before each pass with source's program, which is current, to set uniforms and bind
     * textures (to units from PSPLAT_HOST_UNIT on); may be NULL. It must leave the program current,
     * and other state alone. is_new is 1 where the program was just made, so that the host looks up
     * the locations of uniforms once: several variants of one source may exist, each a program with
     * uniforms of its own. After that a name stands for the same program until is_new is 1 again.
     */
    void (*use)(void *user, unsigned program, int is_new);
    void *user; /* passed to use */
} psplat_resolve;

/* What a frame has to know of the host's state under PSPLAT_STATE_HOST_RESETS, where it is not read
 * from GL. */
typedef struct psplat_host_state {
    unsigned framebuffer; /* that is bound for drawing; 0: the default framebuffer */
    int scissor_test;     /* 1: GL_SCISSOR_TEST is enabled for what the frame draws into it */
    float depth_range[2]; /* of glDepthRange; 0 0 means 0 1 */
} psplat_host_state;

/* A camera and how to draw. All matrices are double: they are composed in double and only their
 * product becomes float, so that models far from the origin do not jitter. Lengths in eye space may
 * be from 1e-18 to 1e18. Surfaces that are closer to each other than 2e-6 of their distance from
 * the eye blend (spec 5.3). Zeros are the defaults of all members except the matrices, width and
 * height, which the caller must set. */
typedef struct psplat_view {
    double view[16];       /* from scene to eye space; rigid: a rotation and a translation */
    double projection[16]; /* from eye to clip space with GL's conventions (z from -w to w). The
                              distance between its near and far planes does not affect splats, which
                              are compared in a depth buffer fitted to what the view shows */
    int x, y;              /* lower left corner in the bound framebuffer, pixels */
    int width, height;     /* pixels, 1 ... GL_MAX_TEXTURE_SIZE */
    psplat_mode mode;
    psplat_shading shading; /* PSPLAT_MODE_PARAMETERS ignores it */
    psplat_culling culling;
    psplat_light lights[PSPLAT_MAX_LIGHTS];
    int light_count;                       /* lights that are used, 0 ... PSPLAT_MAX_LIGHTS */
    float ambient[3];                      /* constant radiance from all directions, linear */
    const psplat_environment *environment; /* of the same renderer; NULL: there is none */
    int shadow_size;   /* edge of a shadow map in texels, 16 ... 8192 and at most a quarter of
                          GL_MAX_TEXTURE_SIZE; 0 means 1024 or that quarter */
    int no_filter;     /* 1: the screen-space filter of spec 5.8 is off, and splats smaller than a
                          pixel may not be drawn */
    int linear_output; /* 0: colours are sRGB-encoded; 1: they stay linear, for a framebuffer that
                          has floats or encodes colours itself */
    const psplat_resolve *resolve; /* takes the place of shading; NULL: there is none.
                                      PSPLAT_MODE_PARAMETERS ignores it, and PSPLAT_MODE_GAUSSIAN
                                      blends the normals of centres with it */
    int depth_only; /* 1: splats are drawn in one pass into the framebuffer's depth buffer alone, at
                       the depths of a shadow map: moved away from the eye by epsilon of spec 5.3,
                       the bias that keeps them from shading themselves. mode, shading, resolve,
                       lights and colours must be valid but do not matter; shadows want
                       PSPLAT_CULL_NEVER */
    psplat_host_state host; /* matters under PSPLAT_STATE_HOST_RESETS alone */
} psplat_view;

/* One model to draw. Any number of items may have the same model: they are drawn with the same
 * calls of GL. transform is applied after the asset's own node transforms and may be any
 * invertible affine matrix; all zeros mean the identity.
 *
 * fade cross-fades an item and its replacement, as a tile of a level of detail and its children:
 * with fade t of the old and 1 - t of the new both are drawn, and pixels that both cover turn from
 * one into the other while t grows, as far as they lie within the tolerances of spec 5.3: what lies
 * deeper is hidden, faded or not. Weights fade, coverage and depths do not: where splats of faded
 * items are alone in a pixel they are as without a fade, and outlines change when an item comes and
 * when it goes. Where there are no weights (depth_only, shadows of lights, PSPLAT_MODE_FLAT,
 * PSPLAT_MODE_PARAMETERS, the shading `splats`), and in what the shading `overdraw` counts, items
 * of a fade below 1 are whole. */
typedef struct psplat_item {
    psplat_model *model;
    double transform[16];
    const psplat_pose *pose; /* of the model's asset; NULL: at rest */
    float fade; /* 0: whole; between 0 and 1 the weights of its splats in blending (spec 5.4) are
                   multiplied by 1 - fade; 1 or more: it is not drawn, and casts no shadow */
    uint32_t level; /* of detail; 0: the finest. One that the model has not stands for its coarsest.
                       psplat_model_choose_level finds one that looks right */
} psplat_item;

/* Returns the error of a level of detail as it is seen, in pixels, where a scene unit is so many
 * pixels: the greater of a quarter of the distance, and of the outline times (normal / 5
 * degrees)^1.5. Over seven models at 16 to 400 pixels across, normals and outline together tell
 * best how like the source a level looks (tests/bench/bench_levels.c); the distance, which alone is
 * proven, bounds what they average over. */
PSPLAT_EXPORT double psplat_level_error(const psplat_level *level, double pixels);

/* The parameters of psplat_model_choose_level. Zeros are the defaults. */
typedef struct psplat_level_choice {
    double tau; /* greatest psplat_level_error, pixels; 0 means 0.5, at which levels of six models
                   at 16 to 200 pixels across had an SSIM of 0.88 to 0.97 against their sources,
                   0.93 on average; at 0.25 it was 0.94 to 0.97 */
    double hysteresis; /* 0 ... 1: by this part of tau less must a level err that is coarser than
                          current, so that levels do not flicker where a distance trembles; 0: none.
                          0.1 is a good value */
    uint32_t current;  /* the level that was drawn last; matters with hysteresis alone */
} psplat_level_choice;

/* Chooses a level of detail for an item: the coarsest whose error in pixels, at the point of the
 * model's box that is nearest to the eye, is at most tau. transform is as psplat_item.transform, or
 * NULL for the identity; of view, which may be orthographic, view, projection, width and height
 * matter. The result is 0 where the eye is between the planes through the nearest and the farthest
 * corner of the box, or in it, and the coarsest where all of the box is behind the eye, or where
 * the transform makes it a point. A model in a pose that leaves its box at rest gets what the box
 * at rest gets. It touches no GL and changes nothing, so that any thread may call it. */
PSPLAT_EXPORT uint32_t psplat_model_choose_level(const psplat_model *model, const psplat_view *view,
                                                 const double transform[16],
                                                 const psplat_level_choice *choice);

/* Draws items into the framebuffer that is bound for drawing, which may have any colour and depth
 * format. Colour (to draw buffer 0, with alpha 1) and depth of covered pixels are written where
 * they pass the depth test against what is there already (GL_LEQUAL); other pixels stay as they
 * are, and the host clears. So splats and the host's geometry hide each other pixel by pixel,
 * whichever is drawn first. Of the host's own state only the scissor test, the depth range and
 * GL_FRAMEBUFFER_SRGB (see linear_output) apply.
 *
 * In a framebuffer with several samples a pixel all samples get the pixel's one colour and depth:
 * edges of the host's geometry in front of and behind splats stay smooth, and edges of splats are
 * not smoothed. In GL it is undefined what draw buffers other than 0 receive in covered pixels; in
 * WebGL there must be none. After the first frame of its kind nothing is allocated, as long as
 * views have no more than two sizes.
 *
 * items has item_count entries, which may be 0. One call with all items of a view is far cheaper
 * than a call for each, which would clear and resolve render targets every time. Errors: ARGUMENT
 * (a pointer is NULL, a value of the view or of a light is out of range, a fade is negative or NaN,
 * or a pose has not as many batches as its model; that of another asset with as many is not
 * noticed), MEMORY, GRAPHICS. What the framebuffer holds after an error is undefined.
 *
 * A resolve function of the host's writes to as many draw buffers as it has outputs, with what the
 * framebuffer makes of it; the rest of the above holds for all of them.
 *
 * The GL state that is changed is restored, here and in every function above: framebuffer, program,
 * vertex array, array buffer, viewport, scissor box, capabilities, blending, masks, depth function,
 * culling, polygon mode, pixel unpacking, and of the texture units 0 ... 8 the 2D texture, the cube
 * map and the sampler, where materials have textures of the units 9 ... 13 too. State of several
 * draw buffers or viewports (glEnablei, glColorMaski, glViewportIndexed) is read and restored as
 * that of number 0. Two things are not restored:
 *
 *     glGetError                its flags are read where something is made or fails. Flags that the
 *                               host left are dropped, and no call fails because of them
 *     glGetGraphicsResetStatus  is asked once in each call, where the context has it
 *
 * Under PSPLAT_STATE_HOST_RESETS this function reads no state, so that nothing waits for the GPU
 * or, in a browser, for another process. psplat_view.host tells what it has to know. In a frame
 * that makes nothing new (programs, targets, shadow maps, room for more instances than ever) it
 * calls no glGet... and no glIsEnabled. It leaves this behind, whatever it draws and also where it
 * fails while drawing; with no items, or where arguments are refused, it changes nothing:
 *
 *     glBindFramebuffer         psplat_view.host.framebuffer for drawing; that for reading is as
 *                               before
 *     glViewport                x, y, width, height of the view
 *     GL_SCISSOR_TEST           psplat_view.host.scissor_test
 *     glScissor                 as before where the test is enabled, else that of the viewport
 *     glUseProgram, glBindVertexArray 0
 *     GL_DITHER                                                     enabled
 *     GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_POLYGON_OFFSET_FILL,
 *     GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SAMPLE_COVERAGE, in GLES 3.1 and GL
 *     GL_SAMPLE_MASK, in GL GL_COLOR_LOGIC_OP, GL_DEPTH_CLAMP, GL_POLYGON_SMOOTH,
 *     GL_PRIMITIVE_RESTART, GL_TEXTURE_CUBE_MAP_SEAMLESS, GL_CLIP_DISTANCE0 ... 7   disabled
 *     glBlendFunc GL_ONE GL_ZERO, glBlendEquation GL_FUNC_ADD, glColorMask and glDepthMask GL_TRUE
 *     (all of these for every draw buffer), glDepthFunc GL_LESS, glCullFace GL_BACK, glFrontFace
 *     GL_CCW, in GL glPolygonMode GL_FILL
 *     glActiveTexture           GL_TEXTURE0
 *     glBindTexture of 2D and cube maps, glBindSampler              0 on units 0 ... 8; where
 *                               materials have textures on units 0 ... 13
 *     GL_ARRAY_BUFFER and GL_PIXEL_UNPACK_BUFFER 0, GL_UNPACK_ALIGNMENT 4
 *     GL_UNPACK_ROW_LENGTH, _SKIP_ROWS, _SKIP_PIXELS and in GL _SWAP_BYTES 0
 *
 * These are GL's initial values, but for the first three and what the host says. All other state is
 * as before. Nothing is asked of a lost context either: a host that learns of a loss, or wants to,
 * calls psplat_draw with no items, which asks GL and returns PSPLAT_ERROR_GRAPHICS after a loss.
 * The functions that make and destroy things restore state under both policies.
 *
 * This state must be at its default: glClipControl, conditional rendering, transform feedback, and
 * what extensions add to rasterisation (EXT_depth_bounds_test, in GLES EXT_clip_cull_distance); in
 * WebGL also UNPACK_FLIP_Y and UNPACK_PREMULTIPLY_ALPHA. A depth buffer that is reversed (greater
 * is nearer) cannot be shared. Active queries count what is drawn here too. */
PSPLAT_EXPORT psplat_result psplat_draw(psplat_renderer *renderer, const psplat_view *view,
                                        const psplat_item *items, size_t item_count,
                                        psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
