/* SPDX-License-Identifier: MIT
 *
 * engine - phongsplat in a host that has a loop, a framebuffer, shaders and meshes of its own. One
 * asset stands in a ring of triangles, instances of another are sunk into the floor around it.
 *
 *     engine A.glb B.glb OUT.ppm
 */
#include "background_loader.h"
#include "decode_image.h"
#include "engine_matrix.h"
#include "engine_mesh.h"
#include "screen.h"

#include <phongsplat/host.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { INSTANCES = 7, ITEMS = 1 + INSTANCES, FRAMES = 8 };

typedef struct engine {
    psplat_host *host; /* takes the place of a window */
    engine_gl gl;
    screen screen;
    paint paint;
    mesh floor, plinth, ring;
    psplat_renderer *renderer;
    psplat_environment *sky;
    psplat_model *models[2];
    int model_count;
    psplat_item items[ITEMS];
    size_t item_count;
    matrix view, projection;
} engine;

static const float sun_direction[3] = {0.9f, -1, -0.45f}, sun[3] = {2.3f, 2.3f, 2.2f},
                   ambient[3] = {0.16f, 0.17f, 0.2f};
/* The sky's faces +x -x +y -y +z -z: bright above, dark below. */
static const float sky_radiance[6 * 3] = {0.18f, 0.18f, 0.20f, 0.18f, 0.18f, 0.20f,
                                          0.40f, 0.45f, 0.55f, 0.08f, 0.08f, 0.07f,
                                          0.18f, 0.18f, 0.20f, 0.18f, 0.18f, 0.20f};

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

static int start(engine *e) {
    psplat_error error = {0};
    if (psplat_host_create(PSPLAT_API_GL, 0, &e->host, &error)) return fail(error.text);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = e->host, .images = decode_images()};
    if (psplat_renderer_create(&desc, &e->renderer, &error)) return fail(error.text);
    const psplat_environment_desc sky = {.radiance = sky_radiance, .size = 1};
    if (psplat_environment_create(e->renderer, &sky, &e->sky, &error)) return fail(error.text);
    if (!engine_gl_load(&e->gl, psplat_host_get_proc, e->host) || !paint_make(&e->paint, &e->gl))
        return fail("GL lacks a function or refuses a shader");
    e->screen = screen_make(&e->gl);
    make_meshes(e);
    return 1;
}

static void stop(engine *e) {
    for (int i = 0; i < e->model_count; ++i) psplat_model_destroy(e->renderer, e->models[i]);
    psplat_environment_destroy(e->renderer, e->sky);
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

static void aim(engine *e, int frame) {
    double angle = 0.5 + 0.02 * frame;
    const double eye[3] = {6.2 * sin(angle), 3.4, 6.2 * cos(angle)}, target[3] = {0, 0.55, 0};
    e->view = matrix_look(eye, target);
    e->projection = matrix_perspective(2.2, (double)SCREEN_WIDTH / SCREEN_HEIGHT, 1, 20);
}

static int draw_splats(const engine *e) {
    psplat_error error = {0};
    psplat_view view = {.width = SCREEN_WIDTH, .height = SCREEN_HEIGHT, .light_count = 1};
    view.linear_output = 1; /* the framebuffer encodes sRGB */
    memcpy(view.view, e->view.m, sizeof view.view);
    memcpy(view.projection, e->projection.m, sizeof view.projection);
    memcpy(view.lights[0].direction, sun_direction, sizeof sun_direction);
    memcpy(view.lights[0].color, sun, sizeof sun);
    view.lights[0].casts_shadow = 1;
    view.shadow_size = 2048;
    view.environment = e->sky;
    if (psplat_draw(e->renderer, &view, e->items, e->item_count, &error)) return fail(error.text);
    return 1;
}

/* Draws meshes before the splats and after them. psplat_draw changes no state of GL: program,
 * uniforms and everything else stay as the engine set them. */
static int draw_frame(const engine *e) {
    static const float stone[3] = {0.42f, 0.40f, 0.37f}, slate[3] = {0.16f, 0.18f, 0.22f},
                       brass[3] = {0.75f, 0.45f, 0.10f};
    const engine_gl *gl = &e->gl;
    matrix clip = matrix_multiply(&e->projection, &e->view);
    screen_begin(&e->screen, gl);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_FRAMEBUFFER_SRGB);
    gl->UseProgram(e->paint.program);
    gl->Uniform3fv(e->paint.light, 1, sun_direction);
    gl->Uniform3fv(e->paint.sun, 1, sun);
    gl->Uniform3fv(e->paint.ambient, 1, ambient);
    mesh_draw(&e->floor, gl, &e->paint, &clip, slate);
    mesh_draw(&e->plinth, gl, &e->paint, &clip, stone);
    if (!draw_splats(e)) return 0;
    mesh_draw(&e->ring, gl, &e->paint, &clip, brass);
    return 1;
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
    if (argc != 4) return fprintf(stderr, "usage: engine A.glb B.glb OUT.ppm\n"), 1;
    loader *l = loader_start((const char *const *)argv + 1, 2);
    int is_fine = l ? start(&e) && run(&e, l) : fail("no thread to load on");
    if (is_fine && !screen_save(&e.screen, &e.gl, argv[3])) is_fine = fail("cannot write OUT.ppm");
    stop(&e);
    loader_stop(l);
    return !is_fine;
}
