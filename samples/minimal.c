/* SPDX-License-Identifier: MIT
 *
 * minimal.c - the C API in one page: opens an asset, draws it without a window, writes a PPM.
 *
 *     minimal part.glb part.ppm
 */
#include "decode_image.h"

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 640, HEIGHT = 480 };

static int fail(const psplat_error *error) {
    fprintf(stderr, "minimal: %s\n", error->text);
    return 1;
}

/* Looks along -z at the asset's box from so far away that all of it is in the picture. */
static psplat_view front_view(const psplat_asset *asset) {
    double min[3], max[3], size = 0;
    psplat_asset_bounds(asset, min, max);
    for (int i = 0; i < 3; ++i) size += (max[i] - min[i]) * (max[i] - min[i]);
    double radius = 0.5 * sqrt(size), distance = 4 * radius;
    double near = distance - 1.1 * radius, far = distance + 1.1 * radius, zoom = 3.5;
    psplat_view view = {
        .view = {[0] = 1,
                 [5] = 1,
                 [10] = 1,
                 [12] = -0.5 * (min[0] + max[0]),
                 [13] = -0.5 * (min[1] + max[1]),
                 [14] = -0.5 * (min[2] + max[2]) - distance,
                 [15] = 1},
        .projection = {[0] = zoom * HEIGHT / WIDTH,
                       [5] = zoom,
                       [10] = (near + far) / (near - far),
                       [11] = -1,
                       [14] = 2 * near * far / (near - far)},
        .width = WIDTH,
        .height = HEIGHT,
        .lights = {{.direction = {1, -2, -2}, .color = {3, 3, 3}}},
        .light_count = 1,
        .ambient = {0.1f, 0.1f, 0.1f},
    };
    return view;
}

static int write_ppm(const char *path, const uint8_t *rgba) {
    FILE *file = fopen(path, "wb");
    if (!file) return perror(path), 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (int y = HEIGHT - 1; y >= 0; --y)
        for (int x = 0; x < WIDTH; ++x) fwrite(rgba + 4 * (y * WIDTH + x), 1, 3, file);
    if (fclose(file)) return perror(path), 1;
    return 0;
}

int main(int argc, char **argv) {
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const float white[4] = {1, 1, 1, 1};
    psplat_error error = {0};
    psplat_asset *asset = NULL;
    psplat_host *host = NULL;
    psplat_renderer *renderer = NULL;
    psplat_model *model = NULL;
    if (argc != 3) return fprintf(stderr, "usage: minimal IN.glb OUT.ppm\n"), 1;

    psplat_asset_desc asset_desc = {.only_draws = 1};
    if (psplat_asset_open(argv[1], &asset_desc, &asset, &error)) return fail(&error);
    if (psplat_host_create(PSPLAT_API_GL, 0, &host, &error)) return fail(&error);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = host, .images = decode_images()};
    if (psplat_renderer_create(&desc, &renderer, &error)) return fail(&error);
    if (psplat_model_create(renderer, asset, &model, &error)) return fail(&error);

    psplat_view view = front_view(asset);
    psplat_item item = {.model = model};
    if (psplat_host_begin(host, WIDTH, HEIGHT, 0, white, &error)) return fail(&error);
    if (psplat_draw(renderer, &view, &item, 1, &error)) return fail(&error);
    if (psplat_host_read_rgba8(host, rgba, &error)) return fail(&error);
    int result = write_ppm(argv[2], rgba);

    psplat_model_destroy(renderer, model);
    psplat_renderer_destroy(renderer);
    psplat_host_destroy(host);
    psplat_asset_destroy(asset);
    return result;
}
