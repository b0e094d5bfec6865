/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_render.c - phongsplat render: draws an asset, a tileset or a mesh into a PNG.
 *
 * The picture is drawn larger than asked for into a float framebuffer and averaged in linear light.
 * Only this supersampling smooths silhouettes and creases, since a pixel is either inside a splat's
 * edge or outside.
 */
#define _XOPEN_SOURCE 700

#include "base/output.h"
#include "cli/command.h"
#include "cli/mesh_input.h"
#include "cli/options.h"
#include "cli/tiles_input.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "material/mipmap.h"
#include "picture/picture.h"
#include "picture/png_writer.h"
#include "picture/viewpoint.h"
#include "mesh/mesh.h"
#include "views/gl_context.h"
#include "views/image_loader.h"
#include "views/mesh_renderer.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* MAX_SIDE bounds the picture, pixels. A picture is drawn in tiles whose sides have
 * MAX_TILE_SAMPLES samples at most, so that memory and the sizes that GL allows do not limit it: a
 * sample takes 16 bytes here and a few times that in the driver. */
enum { MAX_SIDE = 16384, MAX_TILE_SAMPLES = 3072 };

typedef struct arguments {
    const char *input;
    const char *output;
    int size[2];
    psplat_viewpoint viewpoint;
    int mode, shading;
    int shadows, no_filter, level;
    float background[4]; /* sRGB-encoded */
    int supersample;
    int software;
    int overwrite;
    const char *animation; /* a name or an index, or NULL */
    double time;           /* seconds; NaN where it is not given */
    double pixels;         /* greatest error of tiles; NaN where it is not given */
} arguments;

/* What is drawn, an asset, a tileset or a mesh, and what draws it; free_scene frees everything. */
typedef struct scene {
    psplat_asset *asset;      /* or NULL */
    psplat_tiles_input tiles; /* or zeros */
    psplat_mesh mesh;
    psplat_source_mesh *source;
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_model *model;
    psplat_pose *pose; /* or NULL: at rest */
    double center[3], radius;
    psplat_mesh_renderer *mesh_renderer;
} scene;

/* A tile of the picture, in its pixels, row 0 on top. */
typedef struct tile {
    int x, y, width, height;
} tile;

static const char *const shading_names[] = {
#define SHADING_NAME(name, file, reads) #file,
    PSPLAT_SHADINGS(SHADING_NAME)
#undef SHADING_NAME
        NULL};

static psplat_parse parse(int argc, char **argv, arguments *a) {
    const psplat_option options[] = {
        {0, "size", PSPLAT_OPTION_SIZE, a->size, "WxH", "pixels of the picture (default 1024x768)",
         1, MAX_SIDE, NULL},
        {0, "azimuth", PSPLAT_OPTION_NUMBER, &a->viewpoint.azimuth_degrees, "DEG",
         "direction to look from, about +y: 0 is +z, 90 is +x\n(default 30)", -3600, 3600, NULL},
        {0, "elevation", PSPLAT_OPTION_NUMBER, &a->viewpoint.elevation_degrees, "DEG",
         "height to look from: 0 is level, 90 straight down\n(default 20)", -90, 90, NULL},
        {0, "distance", PSPLAT_OPTION_NUMBER, &a->viewpoint.distance, "F",
         "distance in multiples of the one at which the bounding\nsphere fits (default 1)", 1e-3,
         1e3, NULL},
        psplat_option_shared("mode", &a->mode),
        {0, "shading", PSPLAT_OPTION_CHOICE, &a->shading,
         "lit|unlit|toon|normal|depth|overdraw|splats", "what is made of them (default lit)", 0, 0,
         shading_names},
        {0, "shadows", PSPLAT_OPTION_FLAG, &a->shadows, NULL, "the light casts shadows", 0, 0,
         NULL},
        psplat_option_shared("no-filter", &a->no_filter),
        {0, "level", PSPLAT_OPTION_COUNT, &a->level, "N",
         "level of detail, 0 is the finest (default 0); the coarsest\nwhere the asset has not so "
         "many",
         0, 1e6, NULL},
        {0, "background", PSPLAT_OPTION_COLOR, a->background, "COLOR",
         "RRGGBB, R,G,B or transparent (default FFFFFF)", 0, 0, NULL},
        {0, "time", PSPLAT_OPTION_NUMBER, &a->time, "S",
         "draw the pose after S seconds of an animation (default:\nas the file's nodes stand, or 0 "
         "with --animation)",
         0, 1e9, NULL},
        {0, "animation", PSPLAT_OPTION_TEXT, &a->animation, "NAME|INDEX",
         "which animation --time is of (default: the first, 0)", 0, 0, NULL},
        {0, "supersample", PSPLAT_OPTION_COUNT, &a->supersample, "N",
         "draw N times as wide and high and average in linear\nlight (default 3)", 1, 8, NULL},
        {0, "pixels", PSPLAT_OPTION_NUMBER, &a->pixels, "N",
         "of a tileset: draw the coarsest tiles whose errors are\nat most N pixels (default 1)",
         0.01, 1e6, NULL},
        psplat_option_shared("software", &a->software),
        psplat_option_shared("overwrite", &a->overwrite),
    };
    const psplat_syntax syntax = {
        .command = "render",
        .operands = "A.glb OUT.png",
        .summary =
            "Draws an asset (.glb or .gltf) into a PNG, seen whole and lit from behind the\n"
            "camera. The scene's y axis points up. Instead of an asset, A.glb may be a mesh, or a\n"
            "tileset (3D Tiles), which is a tileset.json, its directory or a .3tz archive.",
        .notes =
            "A mesh is drawn as triangles under the same light, so that both can be seen side by\n"
            "side; it takes no --shading but lit and unlit, and no --mode, --shadows, "
            "--no-filter,\n--time or --animation. A tileset has no animations; all of its tiles "
            "that the picture\n"
            "wants are read before it is drawn.\n\n"
            "Pictures at all times of an animation have the same camera. After its end an\n"
            "animation shows its last pose. phongsplat inspect lists animations.\n\n"
            "OUT.png is written whole or not at all; - is standard output.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {&a->input, &a->output},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

/* Returns whether the colours of a shading stand for numbers and so are sRGB-encoded already. */
static int shows_numbers(int shading) {
    return shading != PSPLAT_SHADING_LIT && shading != PSPLAT_SHADING_UNLIT &&
           shading != PSPLAT_SHADING_TOON;
}

/* Returns the view of the whole picture before averaging. */
static psplat_view whole_view(const arguments *a, const scene *s) {
    psplat_view view = {
        .width = a->size[0] * a->supersample,
        .height = a->size[1] * a->supersample,
        .mode = (psplat_mode)a->mode,
        .shading = (psplat_shading)a->shading,
        .no_filter = a->no_filter,
        .linear_output = !shows_numbers(a->shading),
    };
    psplat_viewpoint_fit(&a->viewpoint, s->center, s->radius, &view);
    view.lights[0].casts_shadow = a->shadows;
    return view;
}

/* Reads the tiles of the whole picture. Errors are told in its pixels after averaging. */
static psplat_result load_tiles(const arguments *a, scene *s, psplat_error *error) {
    psplat_view whole = whole_view(a, s);
    double pixels = isnan(a->pixels) ? 1 : a->pixels;
    const psplat_tiles_view view = {.view = &whole, .pixels = pixels * a->supersample};
    return psplat_tiles_input_load(&s->tiles, s->renderer, &view, error);
}

static psplat_result prepare_mesh(scene *s, psplat_error *error) {
    const psplat_mesh_renderer_desc desc = {psplat_host_get_proc, s->host, s->source};
    psplat_result result = psplat_host_make_current(s->host, error);
    return result ? result : psplat_mesh_renderer_create(&desc, &s->mesh_renderer, error);
}

static psplat_result prepare(const arguments *a, scene *s, psplat_error *error) {
    psplat_result result = psplat_context_create(a->software, &s->host, error);
    if (result) return result;
    if (s->source) return prepare_mesh(s, error);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = s->host, .images = psplat_image_loader()};
    result = psplat_renderer_create(&desc, &s->renderer, error);
    if (result) return result;
    if (s->tiles.tiles) return load_tiles(a, s, error);
    return psplat_model_create(s->renderer, s->asset, &s->model, error);
}

static psplat_result draw_scene(const arguments *a, scene *s, const psplat_view *view,
                                psplat_error *error) {
    const psplat_item item = {.model = s->model, .pose = s->pose, .level = (uint32_t)a->level};
    const psplat_item *items = &item;
    size_t count = 1;
    if (s->mesh_renderer)
        return psplat_mesh_renderer_draw(s->mesh_renderer, view, PSPLAT_MESH_RENDERER_LIGHT, error);
    if (s->tiles.tiles) items = psplat_tiles_items(s->tiles.tiles, &count);
    return psplat_draw(s->renderer, view, items, count, error);
}

/* Draws a tile into rgba: (supersample * width) x (supersample * height) linear pixels. */
static psplat_result draw(const arguments *a, scene *s, const psplat_view *whole, const tile *t,
                          float *rgba, psplat_error *error) {
    psplat_view view = *whole;
    int n = a->supersample, bottom = a->size[1] - t->y - t->height;
    psplat_viewpoint_crop(&view, n * t->x, n * bottom, n * t->width, n * t->height);
    float clear[4] = {0, 0, 0, a->background[3]};
    for (int i = 0; i < 3; ++i)
        clear[i] =
            shows_numbers(a->shading) ? a->background[i] : psplat_linear_of_srgb(a->background[i]);
    psplat_result result = psplat_host_begin(s->host, view.width, view.height, 1, clear, error);
    if (!result) result = draw_scene(a, s, &view, error);
    if (!result) result = psplat_host_read_float(s->host, rgba, error);
    size_t samples = (size_t)view.width * (size_t)view.height;
    for (size_t i = 0; i < samples && !result && shows_numbers(a->shading); ++i)
        for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = psplat_linear_of_srgb(rgba[4 * i + c]);
    return result;
}

/* Returns 4, for straight alpha, if the background is transparent, else 3. */
static int channel_count(const arguments *a) {
    return a->background[3] < 1 ? 4 : 3;
}

static void copy_tile(const arguments *a, const tile *t, const uint8_t *tile_pixels,
                      uint8_t *pixels) {
    size_t channels = (size_t)channel_count(a), row = channels * (size_t)t->width;
    for (int y = 0; y < t->height; ++y) {
        size_t at = (size_t)(t->y + y) * (size_t)a->size[0] + (size_t)t->x;
        memcpy(pixels + channels * at, tile_pixels + row * (size_t)y, row);
    }
}

static int smaller(int a, int b) {
    return a < b ? a : b;
}

/* Draws all tiles. rgba and tile_pixels have room for the samples and the pixels of side x side. */
static psplat_result draw_tiles(const arguments *a, scene *s, int side, float *rgba,
                                uint8_t *tile_pixels, uint8_t *pixels, psplat_error *error) {
    psplat_view whole = whole_view(a, s);
    psplat_result result = PSPLAT_OK;
    for (int y = 0; y < a->size[1] && !result; y += side)
        for (int x = 0; x < a->size[0] && !result; x += side) {
            tile t = {x, y, smaller(side, a->size[0] - x), smaller(side, a->size[1] - y)};
            result = draw(a, s, &whole, &t, rgba, error);
            if (result) break;
            psplat_picture_reduce(rgba, t.width, t.height, a->supersample, channel_count(a),
                                  tile_pixels);
            copy_tile(a, &t, tile_pixels, pixels);
        }
    return result;
}

static psplat_result write_picture(const arguments *a, const uint8_t *pixels, psplat_error *error) {
    uint8_t *png = NULL;
    size_t size = 0;
    psplat_result result =
        psplat_png_encode(pixels, a->size[0], a->size[1], channel_count(a), &png, &size, error);
    if (!result) result = psplat_output_write(a->output, png, size, a->overwrite, error);
    free(png);
    return result;
}

static psplat_result render(const arguments *a, scene *s, psplat_error *error) {
    int side = MAX_TILE_SAMPLES / a->supersample;
    size_t pixel_count = (size_t)a->size[0] * (size_t)a->size[1];
    size_t tile_size = (size_t)smaller(side, a->size[0]) * (size_t)smaller(side, a->size[1]);
    size_t samples = tile_size * (size_t)(a->supersample * a->supersample);
    float *rgba = malloc(samples * 4 * sizeof *rgba);
    uint8_t *tile_pixels = malloc(tile_size * 4), *pixels = malloc(pixel_count * 4);
    psplat_result result =
        rgba && tile_pixels && pixels
            ? PSPLAT_OK
            : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu pixels", pixel_count);
    if (!result) result = prepare(a, s, error);
    if (!result) result = draw_tiles(a, s, side, rgba, tile_pixels, pixels, error);
    if (!result) result = write_picture(a, pixels, error);
    free(rgba);
    free(tile_pixels);
    free(pixels);
    return result;
}

static void free_scene(scene *s) {
    psplat_mesh_renderer_destroy(s->mesh_renderer);
    if (s->renderer) psplat_model_destroy(s->renderer, s->model);
    psplat_tiles_input_close(&s->tiles, s->renderer);
    psplat_renderer_destroy(s->renderer);
    psplat_pose_destroy(s->pose);
    psplat_host_destroy(s->host);
    psplat_asset_destroy(s->asset);
    psplat_source_mesh_destroy(s->source);
    psplat_mesh_free(&s->mesh);
}

/* Reads the input: a tileset, an asset, or else a mesh. */
static psplat_result read_input(const arguments *a, scene *s, psplat_error *error) {
    if (psplat_tiles_input_expected(a->input))
        return psplat_tiles_input_open(a->input, &s->tiles, error);
    psplat_result result = psplat_command_open(a->input, NULL, &s->asset, error);
    if (!psplat_mesh_input_expected(a->input, result)) return result;
    *error = (psplat_error){0};
    return psplat_mesh_input_read(a->input, 0, &s->mesh, &s->source, error);
}

/* ---- the pose -------------------------------------------------------------------------------- */

/* Returns the index of the animation of that name or, where none has it, of that index; the number
 * of animations where there is no such one. */
static size_t find_animation(const psplat_asset *asset, const char *text) {
    size_t count = psplat_asset_animation_count(asset);
    for (size_t i = 0; i < count; ++i)
        if (!strcmp(psplat_asset_get_animation(asset, i)->name, text)) return i;
    char *end;
    unsigned long index = strtoul(text, &end, 10);
    return strspn(text, "0123456789") && !*end && index < count ? index : count;
}

/* Finds the sphere around the box of a tileset. */
static void place_tiles(scene *s) {
    double min[3], max[3], square = 0;
    psplat_tiles_bounds(s->tiles.tiles, min, max);
    for (int i = 0; i < 3; ++i) {
        s->center[i] = 0.5 * (min[i] + max[i]);
        square += 0.25 * (max[i] - min[i]) * (max[i] - min[i]);
    }
    s->radius = square > 0 ? sqrt(square) : 1;
}

/* Poses the asset and finds a sphere around what is drawn. */
static psplat_result take_pose(const arguments *a, scene *s, psplat_error *error) {
    if (s->tiles.tiles) {
        place_tiles(s);
        return PSPLAT_OK;
    }
    if (!s->asset) {
        memcpy(s->center, s->source->center, sizeof s->center);
        s->radius = s->source->radius > 0 ? s->source->radius : 1;
        return PSPLAT_OK;
    }
    if (!a->animation && isnan(a->time)) {
        psplat_viewpoint_sphere(s->asset, s->center, &s->radius);
        return PSPLAT_OK;
    }
    size_t index = find_animation(s->asset, a->animation ? a->animation : "0");
    psplat_result result =
        psplat_viewpoint_sphere_over(s->asset, index, s->center, &s->radius, error);
    if (!result) result = psplat_pose_create(s->asset, &s->pose, error);
    if (!result) result = psplat_pose_set(s->pose, index, isnan(a->time) ? 0 : a->time, error);
    return result;
}

/* Returns whether an option asks for an animation that the asset has not. */
static int lacks_animation(const arguments *a, const scene *s) {
    if (s->source || (!a->animation && isnan(a->time))) return 0;
    return !s->asset || find_animation(s->asset, a->animation ? a->animation : "0") ==
                            psplat_asset_animation_count(s->asset);
}

/* Returns the option that does not go with a mesh, or NULL. */
static const char *option_of_splats(const arguments *a) {
    if (a->shading != PSPLAT_SHADING_LIT && a->shading != PSPLAT_SHADING_UNLIT) return "shading";
    if (a->mode != PSPLAT_MODE_PHONG) return "mode";
    if (a->shadows) return "shadows";
    if (!isnan(a->time)) return "time";
    if (a->animation) return "animation";
    if (a->level) return "level";
    return a->no_filter ? "no-filter" : NULL;
}

int psplat_command_render(int argc, char **argv) {
    arguments a = {
        .size = {1024, 768},
        .viewpoint = {.azimuth_degrees = 30, .elevation_degrees = 20},
        .background = {1, 1, 1, 1},
        .supersample = 3,
        .time = NAN,
        .pixels = NAN,
    };
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    scene s = {0};
    psplat_error error = {0};
    psplat_result result = psplat_output_check(a.input, a.output, a.overwrite, &error);
    if (result) return psplat_command_fail(NULL, &error);
    result = read_input(&a, &s, &error);
    const char *option = result || !s.source ? NULL : option_of_splats(&a);
    int is_no_tileset = !result && !s.tiles.tiles && !isnan(a.pixels);
    if (is_no_tileset) option = "pixels";
    if (!result && s.tiles.tiles && a.level) option = "level";
    int is_lacking = !result && lacks_animation(&a, &s);
    if (!result && !option && !is_lacking) result = take_pose(&a, &s, &error);
    if (!result && !option && !is_lacking) result = render(&a, &s, &error);
    free_scene(&s);
    if (is_lacking)
        return (int)psplat_options_refuse("render", a.animation ? "animation" : "time",
                                          "the file has no such animation (phongsplat inspect "
                                          "lists them)");
    if (option)
        return (int)psplat_options_refuse(
            "render", option, is_no_tileset ? "is for a tileset" : "is for splats, not for a mesh");
    return result ? psplat_command_fail(result == PSPLAT_ERROR_WRITE ? NULL : a.input, &error)
                  : PSPLAT_EXIT_SUCCESS;
}
