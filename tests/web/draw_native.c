/* SPDX-License-Identifier: MIT
 *
 * draw_native.c - draws assets by the C runtime with a given camera into a PPM, for comparison
 * with what a browser draws. The background is black, the light that of `phongsplat render`.
 *
 *     draw_native A.glb[,B.glb...] OUT.ppm WIDTH HEIGHT SHADING VIEW (16 numbers) PROJECTION (16
 * numbers) [ANIMATION TIME | TAU]
 *
 * An animation and a time are an index and seconds, and draw the first asset in that pose. A number
 * alone draws the first asset at the level of detail that the runtime chooses with that tau, and
 * prints the level.
 */
#include "decode_image.h"

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FIXED_ARGUMENTS = 6,
    CAMERA_ARGUMENTS = FIXED_ARGUMENTS + 32,
    MAX_SIDE = 4096,
    MAX_ASSETS = 256
};

static const char *const shadings[] = {
#define NAME(name, file, reads) #file,
    PSPLAT_SHADINGS(NAME)
#undef NAME
};

static int fail(const psplat_error *error) {
    fprintf(stderr, "draw_native: %s\n", error->text);
    return 1;
}

/* Sets the light of `phongsplat render`: in eye space along (0.15, -0.65, -0.85), and ambient. */
static void set_light(psplat_view *view) {
    const double along[3] = {0.15, -0.65, -0.85};
    view->light_count = 1;
    for (int i = 0; i < 3; ++i) {
        double direction = 0;
        for (int k = 0; k < 3; ++k) direction += view->view[4 * i + k] * along[k];
        view->lights[0].direction[i] = (float)direction;
        view->lights[0].color[i] = 0.85f * 3.14159265f;
        view->ambient[i] = 0.12f;
    }
}

/* Reads the arguments after the first two. Returns 0 where one is wrong. */
static int read_view(char **argv, psplat_view *view) {
    view->width = atoi(argv[3]);
    view->height = atoi(argv[4]);
    int is_known = 0;
    for (int i = 0; i < PSPLAT_SHADING_COUNT; ++i) {
        if (strcmp(shadings[i], argv[5]) != 0) continue;
        view->shading = (psplat_shading)i;
        is_known = 1;
    }
    for (int i = 0; i < 16; ++i) {
        view->view[i] = atof(argv[FIXED_ARGUMENTS + i]);
        view->projection[i] = atof(argv[FIXED_ARGUMENTS + 16 + i]);
    }
    set_light(view);
    return is_known && view->width > 0 && view->width <= MAX_SIDE && view->height > 0 &&
           view->height <= MAX_SIDE;
}

static int write_ppm(const char *path, const psplat_view *view, const uint8_t *rgba) {
    FILE *file = fopen(path, "wb");
    if (!file) return perror(path), 1;
    fprintf(file, "P6 %d %d 255\n", view->width, view->height);
    for (int y = view->height - 1; y >= 0; --y)
        for (int x = 0; x < view->width; ++x)
            fwrite(rgba + 4 * ((size_t)y * (size_t)view->width + (size_t)x), 1, 3, file);
    if (fclose(file)) return perror(path), 1;
    return 0;
}

/* The models of the assets of a call, and what they came from. */
typedef struct scene {
    psplat_renderer *renderer;
    psplat_asset *assets[MAX_ASSETS];
    psplat_item items[MAX_ASSETS];
    size_t count;
    psplat_pose *pose; /* of the first one, or NULL */
} scene;

/* Opens the assets of a list that is separated by commas, which become zeros. */
static int open_scene(scene *s, char *list, psplat_error *error) {
    const psplat_asset_desc desc = {.only_draws = 1};
    int result = 0;
    for (char *path = list, *next; path && !result && s->count < MAX_ASSETS; path = next) {
        psplat_model *model = NULL;
        next = strchr(path, ',');
        if (next) *next++ = 0;
        result = psplat_asset_open(path, &desc, &s->assets[s->count], error) ||
                 psplat_model_create(s->renderer, s->assets[s->count], &model, error);
        s->items[s->count++].model = model;
    }
    return result;
}

static void close_scene(scene *s) {
    psplat_pose_destroy(s->pose);
    for (size_t i = 0; i < s->count; ++i) {
        psplat_model_destroy(s->renderer, (psplat_model *)s->items[i].model);
        psplat_asset_destroy(s->assets[i]);
    }
    psplat_renderer_destroy(s->renderer);
}

/* Poses the first asset at a time, or chooses its level, as `count` arguments behind the camera
 * say.
 */
static int place(scene *s, const psplat_view *view, char **arguments, int count,
                 psplat_error *error) {
    if (count == 1) {
        const psplat_level_choice choice = {.tau = atof(arguments[0])};
        s->items[0].level = psplat_model_choose_level(s->items[0].model, view, NULL, &choice);
        printf("%u\n", s->items[0].level);
        return 0;
    }
    if (!count) return 0;
    if (psplat_pose_create(s->assets[0], &s->pose, error)) return 1;
    s->items[0].pose = s->pose;
    return psplat_pose_set(s->pose, (size_t)atoi(arguments[0]), atof(arguments[1]), error) != 0;
}

static int draw(char *list, char **arguments, int count, const psplat_view *view, psplat_host *host,
                uint8_t *rgba, psplat_error *error) {
    const float black[4] = {0, 0, 0, 1};
    const psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = host, .images = decode_images()};
    scene s = {0};
    int result = psplat_renderer_create(&desc, &s.renderer, error) || open_scene(&s, list, error) ||
                 psplat_host_begin(host, view->width, view->height, 0, black, error);
    result = result || place(&s, view, arguments, count, error) ||
             psplat_draw(s.renderer, view, s.items, s.count, error) ||
             psplat_host_read_rgba8(host, rgba, error);
    close_scene(&s);
    return result;
}

int main(int argc, char **argv) {
    psplat_error error = {0};
    psplat_view view = {0};
    psplat_host *host = NULL;
    int more = argc - CAMERA_ARGUMENTS;
    if (more < 0 || more > 2 || !read_view(argv, &view))
        return fprintf(stderr,
                       "usage: draw_native A.glb[,B.glb...] OUT.ppm WIDTH HEIGHT SHADING VIEW "
                       "PROJECTION [ANIMATION TIME | TAU]\n"),
               1;
    uint8_t *rgba = malloc((size_t)view.width * (size_t)view.height * 4);
    if (!rgba) return fprintf(stderr, "draw_native: no memory\n"), 1;
    int result = psplat_host_create(PSPLAT_API_GL, 1, &host, &error) ||
                 draw(argv[1], argv + CAMERA_ARGUMENTS, more, &view, host, rgba, &error);
    result = result ? fail(&error) : write_ppm(argv[2], &view, rgba);
    psplat_host_destroy(host);
    free(rgba);
    return result;
}
