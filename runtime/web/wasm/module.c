/* SPDX-License-Identifier: MIT
 *
 * module.c - the runtime as a WebAssembly module: what phong-splats.js calls. The module is a host
 * like any other. An instance has one canvas and one GL context; its GL functions, and the textures
 * that the browser has decoded, are imports, which gl.js provides.
 *
 * Pointers that go to JavaScript are numbers there. Nothing is freed but by the functions below.
 */
#include "gl/gl_api.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT(name) __attribute__((used, export_name(#name)))

/* The GL functions, imported as env.glName. */
#define DECLARE(type, name, parameters) extern type gl##name parameters;
PSPLAT_GL_FUNCTIONS(DECLARE)
#undef DECLARE
extern GLenum glGetGraphicsResetStatusEXT(void);

/* Returns the name of the texture that JavaScript has made of an image, whose encoded bytes begin
 * at data; is_srgb as in psplat_images.load. 0: the browser cannot decode it. */
extern unsigned ps_find_texture(const void *data, int is_srgb);

/* Says that the module needs the texture no more. */
extern void ps_drop_texture(unsigned texture);

/* Returns the number that a text is, as JavaScript reads it. */
extern double ps_parse_number(const char *text);

/* JavaScript's Math. */
extern double ps_sin(double x);
extern double ps_cos(double x);
extern double ps_tan(double x);
extern double ps_exp(double x);

typedef struct module {
    psplat_renderer *renderer;
    psplat_error error; /* of the last function that failed */
} module;

/* ---- what the runtime asks of its host ---------------------------------------------------- */

/* ISO C has no cast from function to object pointers; the bytes are copied, as gl_api.c does. */
static void *get_proc(void *user, const char *name) {
    void *address = NULL;
    (void)user;
#define FIND(type, function, parameters)                                                           \
    if (!strcmp(name, "gl" #function)) {                                                           \
        type(*pointer) parameters = gl##function;                                                  \
        memcpy(&address, &pointer, sizeof address);                                                \
    }
    PSPLAT_GL_FUNCTIONS(FIND)
    FIND(GLenum, GetGraphicsResetStatusEXT, (void))
#undef FIND
    return address;
}

static psplat_result load_image(void *user, const psplat_asset_image *image, int is_srgb,
                                psplat_pixels *pixels, psplat_error *error) {
    (void)user;
    pixels->texture = ps_find_texture(image->data, is_srgb);
    if (pixels->texture) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0, "image %.100s %.20s cannot be decoded",
                       image->name, image->mime_type);
}

static void release_image(void *user, psplat_pixels *pixels) {
    (void)user;
    ps_drop_texture(pixels->texture);
}

/* ---- what the browser has, in place of the C library, which every visitor would have to fetch ---
 */

/* The library's numbers of 128 bits are 14 kB of code. This reads decimal numbers alone, which
 * those of JSON are. */
double strtod(const char *restrict text, char **restrict end) {
    if (end) *end = (char *)(uintptr_t)(text + strspn(text, "+-.0123456789eE"));
    return ps_parse_number(text);
}

double sin(double x) {
    return ps_sin(x);
}

double cos(double x) {
    return ps_cos(x);
}

double tan(double x) {
    return ps_tan(x);
}

double exp(double x) {
    return ps_exp(x);
}

/* A page has no files: what an asset refers to is not found. */
FILE *fopen(const char *restrict path, const char *restrict mode) {
    (void)path;
    (void)mode;
    return NULL;
}

/* ---- what JavaScript calls ---------------------------------------------------------------- */

/* Returns memory for JavaScript to write to, or NULL. */
EXPORT(ps_allocate) void *ps_allocate(size_t size) {
    return malloc(size);
}

EXPORT(ps_free) void ps_free(void *memory) {
    free(memory);
}

/* Returns the text of the last error, and its code. */
EXPORT(ps_error) const char *ps_error(const module *m) {
    return m->error.text;
}

EXPORT(ps_error_code) int ps_error_code(const module *m) {
    return (int)m->error.code;
}

/* Makes a module without a renderer. Returns NULL where there is no memory. */
EXPORT(ps_create) module *ps_create(void) {
    return calloc(1, sizeof(module));
}

/* Makes the renderer. Returns 0 where it cannot be. */
EXPORT(ps_start) int ps_start(module *m) {
    const psplat_renderer_desc desc = {.get_proc = get_proc,
                                       .images = {.load = load_image, .release = release_image}};
    return !psplat_renderer_create(&desc, &m->renderer, &m->error);
}

/* Frees the module; its models were destroyed before. */
EXPORT(ps_destroy) void ps_destroy(module *m) {
    psplat_renderer_destroy(m->renderer);
    free(m);
}

/* Opens an asset of size bytes at data, which ps_allocate gave, and stores its bounds: min, max.
 * Returns NULL where the file is refused. */
EXPORT(ps_open) psplat_asset *ps_open(module *m, const void *data, size_t size, double bounds[6]) {
    const psplat_asset_desc desc = {.only_draws = 1};
    psplat_asset *asset = NULL;
    if (psplat_asset_open_memory(data, size, &desc, &asset, &m->error)) return NULL;
    psplat_asset_bounds(asset, bounds, bounds + 3);
    return asset;
}

EXPORT(ps_image_count) size_t ps_image_count(const psplat_asset *asset) {
    return psplat_asset_image_count(asset);
}

/* Return the encoded bytes of an image, how many there are, and its media type. */
EXPORT(ps_image_data) const void *ps_image_data(const psplat_asset *asset, size_t index) {
    return psplat_asset_get_image(asset, index)->data;
}

EXPORT(ps_image_size) size_t ps_image_size(const psplat_asset *asset, size_t index) {
    return psplat_asset_get_image(asset, index)->size;
}

EXPORT(ps_image_type) const char *ps_image_type(const psplat_asset *asset, size_t index) {
    return psplat_asset_get_image(asset, index)->mime_type;
}

EXPORT(ps_animation_count) size_t ps_animation_count(const psplat_asset *asset) {
    return psplat_asset_animation_count(asset);
}

/* Return the name of an animation and its duration, seconds. */
EXPORT(ps_animation_name) const char *ps_animation_name(const psplat_asset *asset, size_t index) {
    return psplat_asset_get_animation(asset, index)->name;
}

EXPORT(ps_animation_duration)
double ps_animation_duration(const psplat_asset *asset, size_t index) {
    return psplat_asset_get_animation(asset, index)->duration;
}

/* Makes a pose of an asset, at rest. Returns NULL where that fails. */
EXPORT(ps_pose_create) psplat_pose *ps_pose_create(module *m, const psplat_asset *asset) {
    psplat_pose *pose = NULL;
    return psplat_pose_create(asset, &pose, &m->error) ? NULL : pose;
}

/* Moves a pose to a time of an animation, seconds. Returns 0 where that fails. */
EXPORT(ps_pose_set)
int ps_pose_set(module *m, psplat_pose *pose, size_t animation, double time) {
    return !psplat_pose_set(pose, animation, time, &m->error);
}

EXPORT(ps_pose_rest) void ps_pose_rest(psplat_pose *pose) {
    psplat_pose_rest(pose);
}

EXPORT(ps_pose_destroy) void ps_pose_destroy(psplat_pose *pose) {
    psplat_pose_destroy(pose);
}

/* Frees an asset; NULL is accepted. */
EXPORT(ps_close) void ps_close(psplat_asset *asset) {
    psplat_asset_destroy(asset);
}

/* Uploads an asset. Returns NULL where that fails. */
EXPORT(ps_model_create) psplat_model *ps_model_create(module *m, const psplat_asset *asset) {
    psplat_model *model = NULL;
    return psplat_model_create(m->renderer, asset, &model, &m->error) ? NULL : model;
}

EXPORT(ps_model_destroy) void ps_model_destroy(module *m, psplat_model *model) {
    psplat_model_destroy(m->renderer, model);
}

EXPORT(ps_splat_count) size_t ps_splat_count(const psplat_model *model) {
    return psplat_model_describe(model).splat_count;
}

/* A view as JavaScript writes it: numbers of one type, so that no layout of C is known there. */
enum {
    VIEW = 0,
    PROJECTION = 16,
    WIDTH = 32,
    HEIGHT,
    SHADING,
    SHADOW_SIZE,
    AMBIENT,
    LIGHT_COUNT = AMBIENT + 3,
    LIGHTS, /* type, color, direction, position, range, inner and outer angle, casts_shadow */
    LIGHT_NUMBERS = 14
};

static psplat_light read_light(const double *n) {
    psplat_light light = {.type = (psplat_light_type)n[0],
                          .range = (float)n[10],
                          .inner_angle = (float)n[11],
                          .outer_angle = (float)n[12],
                          .casts_shadow = (int)n[13]};
    for (int i = 0; i < 3; ++i) {
        light.color[i] = (float)n[1 + i];
        light.direction[i] = (float)n[4 + i];
        light.position[i] = n[7 + i];
    }
    return light;
}

/* Draws a model in a pose, or in NULL, with a transform of 16 numbers, or all zeros, for each item.
 * numbers is a view as above. Returns 0 where that fails. */
EXPORT(ps_draw)
int ps_draw(module *m, const double *numbers, psplat_model *const *models,
            const psplat_pose *const *poses, const double *transforms, size_t count) {
    psplat_view view = {.width = (int)numbers[WIDTH],
                        .height = (int)numbers[HEIGHT],
                        .shading = (psplat_shading)numbers[SHADING],
                        .shadow_size = (int)numbers[SHADOW_SIZE],
                        .light_count = (int)numbers[LIGHT_COUNT]};
    psplat_item *items = calloc(count + 1, sizeof *items);
    if (!items)
        return !psplat_fail(&m->error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu items", count);
    memcpy(view.view, numbers + VIEW, sizeof view.view);
    memcpy(view.projection, numbers + PROJECTION, sizeof view.projection);
    for (int i = 0; i < 3; ++i) view.ambient[i] = (float)numbers[AMBIENT + i];
    for (int i = 0; i < view.light_count && i < PSPLAT_MAX_LIGHTS; ++i)
        view.lights[i] = read_light(numbers + LIGHTS + i * LIGHT_NUMBERS);
    for (size_t i = 0; i < count; ++i) {
        items[i].model = models[i];
        items[i].pose = poses[i];
        memcpy(items[i].transform, transforms + 16 * i, sizeof items[i].transform);
    }
    psplat_result result = psplat_draw(m->renderer, &view, items, count, &m->error);
    free(items);
    return !result;
}
