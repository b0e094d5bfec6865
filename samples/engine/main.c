/* SPDX-License-Identifier: MIT
 *
 * engine - phongsplat in a host that has a loop, framebuffers, shaders, a shadow map and meshes of
 * its own. One asset stands in a ring of triangles, instances of another are sunk into the floor
 * around it.
 *
 *     engine [--deferred] A.glb B.glb OUT.ppm
 */
#include "background_loader.h"
#include "decode_image.h"
#include "deferred.h"
#include "forward.h"

#include <phongsplat/host.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { INSTANCES = 7, ITEMS = 1 + INSTANCES, FRAMES = 8 };

typedef struct engine {
    psplat_host *host; /* takes the place of a window */
    engine_gl gl;
    screen screen;
    frame frame;
    int is_deferred;
    forward forward; /* one of these is made */
    deferred deferred;
    mesh floor, plinth, ring;
    psplat_renderer *renderer;
    psplat_model *models[2];
    int model_count;
    psplat_item items[ITEMS];
    size_t item_count;
} engine;

static int fail(const char *text) {
    fprintf(stderr, "engine: %s\n", text);
    return 0;
}

static void make_meshes(engine *e) {
    static const float floor[][2] = {{7, 0}, {0, 0}};
    static const float plinth[][2] = {{1.2f, 0}, {1.2f, 0.25f}, {1, 0.35f}, {0, 0.35f}};
    float ring[25][2];
    for (int i = 0; i < 25; ++i) {
        double angle = 6.283185307179586 * i / 24;
        ring[i][0] = (float)(0.75 + 0.13 * cos(angle));
        ring[i][1] = (float)(1.1 + 0.13 * sin(angle));
    }
    e->floor = mesh_lathe(&e->gl, floor, 2);
    e->plinth = mesh_lathe(&e->gl, plinth, 4);
    e->ring = mesh_lathe(&e->gl, (const float(*)[2])ring, 25);
}

/* The forward way mixes phongsplat with meshes in one pass and wants its state kept; the deferred
 * way sets all of its state in each pass, so that phongsplat need not ask GL for it. */
static int start(engine *e) {
    psplat_error error = {0};
    if (psplat_host_create(PSPLAT_API_GL, 0, &e->host, &error)) return fail(error.text);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = e->host, .images = decode_images()};
    if (e->is_deferred) desc.state = PSPLAT_STATE_HOST_RESETS;
    if (psplat_renderer_create(&desc, &e->renderer, &error)) return fail(error.text);
    if (!engine_gl_load(&e->gl, psplat_host_get_proc, e->host)) return fail("GL lacks a function");
    e->screen = screen_make(&e->gl);
    make_meshes(e);
    if (!shadow_map_make(&e->frame.shadows, &e->gl)) return fail("GL refuses the shadow map");
    if (e->is_deferred && !deferred_make(&e->deferred, &e->gl, &e->frame))
        return fail("GL refuses a shader");
    if (!e->is_deferred && !forward_make(&e->forward, &e->gl, &e->frame, e->renderer, &error))
        return fail(error.text);
    return 1;
}

static void stop(engine *e) {
    for (int i = 0; i < e->model_count; ++i) psplat_model_destroy(e->renderer, e->models[i]);
    forward_free(&e->forward, e->renderer);
    psplat_renderer_destroy(e->renderer);
    psplat_host_destroy(e->host);
}

/* Places an instance of the last model: its box is scaled to a height and centred on (x, y, z). */
static void place(engine *e, const psplat_asset *asset, double height, double x, double y, double z,
                  double turn, double stretch) {
    double min[3], max[3];
    psplat_asset_bounds(asset, min, max);
    double scale = height / (max[1] - min[1] > 0 ? max[1] - min[1] : 1);
    matrix to_origin =
        matrix_move(-0.5 * (min[0] + max[0]), -0.5 * (min[1] + max[1]), -0.5 * (min[2] + max[2]));
    matrix size = matrix_scale(scale * stretch, scale, scale), about = matrix_turn(turn);
    matrix there = matrix_move(x, y, z), m = matrix_multiply(&size, &to_origin);
    m = matrix_multiply(&about, &m);
    m = matrix_multiply(&there, &m);
    psplat_item *item = &e->items[e->item_count++];
    item->model = e->models[e->model_count - 1];
    memcpy(item->transform, m.m, sizeof item->transform);
}

/* Places the first asset in the ring and instances of the second around it: all turned, one
 * stretched, one mirrored. */
static int add_model(engine *e, const psplat_asset *asset) {
    psplat_error error = {0};
    psplat_model **model = &e->models[e->model_count];
    if (psplat_model_create(e->renderer, asset, model, &error)) return fail(error.text);
    if (++e->model_count == 1) {
        place(e, asset, 1.6, 0, 1.05, 0, 0.6, 1);
        return 1;
    }
    for (int i = 0; i < INSTANCES; ++i) {
        double angle = 6.283185307179586 * (i + 0.5) / INSTANCES;
        double stretch = i == 1 ? 1.6 : i == 2 ? -1 : 1;
        place(e, asset, 1.1, 2.6 * sin(angle), 0.1, 2.6 * cos(angle), 2 * angle, stretch);
    }
    return 1;
}

/* Takes the assets that the loader has opened meanwhile. */
static int take_models(engine *e, loader *l) {
    psplat_error error = {0};
    psplat_asset *asset = loader_take(l, &error);
    if (error.code) return fail(error.text);
    int is_fine = !asset || add_model(e, asset);
    psplat_asset_destroy(asset); /* the model has its own copy */
    return is_fine;
}

static void aim(engine *e, int number) {
    static const float sun_direction[3] = {0.9f, -1, -0.45f}, sun[3] = {2.3f, 2.3f, 2.2f};
    double angle = 0.5 + 0.02 * number;
    const double eye[3] = {6.2 * sin(angle), 3.4, 6.2 * cos(angle)}, target[3] = {0, 0.55, 0};
    e->frame.view = matrix_look(eye, target);
    e->frame.projection = matrix_perspective(2.2, (double)SCREEN_WIDTH / SCREEN_HEIGHT, 1, 20);
    memcpy(e->frame.sun_direction, sun_direction, sizeof sun_direction);
    memcpy(e->frame.sun, sun, sizeof sun);
    shadow_map_aim(&e->frame.shadows, sun_direction);
}

static const float stone[3] = {0.42f, 0.40f, 0.37f}, slate[3] = {0.16f, 0.18f, 0.22f},
                   brass[3] = {0.75f, 0.45f, 0.10f};

static void draw_ground(const engine *e, const paint *p) {
    mesh_draw(&e->floor, &e->gl, p, slate);
    mesh_draw(&e->plinth, &e->gl, p, stone);
}

static psplat_result draw_shadows(const engine *e, psplat_error *error) {
    const shadow_map *map = &e->frame.shadows;
    shadow_map_begin(map, &e->gl);
    draw_ground(e, &map->paint);
    mesh_draw(&e->ring, &e->gl, &map->paint, brass);
    return shadow_map_draw_splats(map, e->renderer, e->items, e->item_count, error);
}

/* Meshes are drawn before the splats and after them: each hides the other pixel by pixel. */
static int draw_frame(engine *e) {
    psplat_error error = {0};
    if (draw_shadows(e, &error)) return fail(error.text);
    psplat_result result;
    if (e->is_deferred) {
        deferred *d = &e->deferred;
        deferred_begin(d, 1);
        draw_ground(e, &d->paint);
        result = deferred_draw_splats(d, e->renderer, e->items, e->item_count, &error);
        deferred_begin(d, 0);
        mesh_draw(&e->ring, &e->gl, &d->paint, brass);
        deferred_light(d, &e->screen);
    } else {
        forward *f = &e->forward;
        forward_begin(f, &e->screen);
        draw_ground(e, &f->paint);
        result = forward_draw_splats(f, e->renderer, e->items, e->item_count, &error);
        mesh_draw(&e->ring, &e->gl, &f->paint, brass);
    }
    return result ? fail(error.text) : 1;
}

/* Draws frames while models come in, and FRAMES more after the last one has. */
static int run(engine *e, loader *l) {
    for (int frame = 0; frame < FRAMES; frame += e->model_count == 2) {
        if (e->model_count < 2 && !take_models(e, l)) return 0;
        aim(e, frame);
        if (!draw_frame(e)) return 0;
    }
    psplat_memory memory = psplat_renderer_memory(e->renderer);
    printf("%zu items of %d models: %zu kB of splats, %zu kB of targets\n", e->item_count,
           e->model_count, memory.models / 1000, memory.targets / 1000);
    return 1;
}

int main(int argc, char **argv) {
    engine e = {0};
    e.is_deferred = argc == 5 && strcmp(argv[1], "--deferred") == 0;
    if (argc != 4 && !e.is_deferred)
        return fprintf(stderr, "usage: engine [--deferred] A.glb B.glb OUT.ppm\n"), 1;
    const char *const *paths = (const char *const *)argv + argc - 3;
    loader *l = loader_start(paths, 2);
    int is_fine = l ? start(&e) && run(&e, l) : fail("no thread to load on");
    if (is_fine && !screen_save(&e.screen, &e.gl, paths[2])) is_fine = fail("cannot write OUT.ppm");
    stop(&e);
    loader_stop(l);
    return !is_fine;
}
