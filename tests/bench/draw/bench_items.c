/* SPDX-License-Identifier: MIT
 *
 * bench_items.c - what items cost: N items of one model are drawn in turn with one item of a model
 * that has all of their splats, so that both show the same picture.
 *
 *     bench_items [--splats N] [--items N] [--size N] [--mode M] [--frames N] [--curved]
 * [--clipped] [--shadow]
 *
 * Spheres stand in a square grid that fills a view of --size (512) pixels. All of them together
 * have about --splats (64000) splats; --items takes one number of them in place of 1, 64 and 1,000.
 * --curved makes their splats curved, --clipped gives them 0 to 4 clip lines, so that a model has
 * five batches, --shadow lets the light cast shadows, --mode is phong, gaussian or flat. "apart"
 * are the items with a call of psplat_draw for each, at most 64 of them. Medians of --frames (31)
 * frames are printed:
 *
 *     CPU        of all threads, in ms a frame
 *     wall       of the wall clock, in ms a frame
 *     thread     of the thread that called psplat_draw while it was in there, in ms. Software GL
 *                computes vertices in that thread and pixels in others
 *     no draws   the same where the loader's draw calls do nothing: the runtime and GL's state
 *     an item    by how much a column is greater than that of the one item, in us an item
 *     differ     pixels that differ from the one item's by more than 1 of 255
 */
#include "measure.h"
#include "scene_asset.h"
#include "subject.h"

#include <phongsplat/host.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_ITEMS = 100000, MAX_FRAMES = 1000 };

typedef struct settings {
    size_t splats, items, frames;
    int size, is_curved, is_clipped, has_shadow;
    psplat_mode mode;
} settings;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_items: %s: %s\n", what, why);
    exit(2);
}

static void check(psplat_result result, const psplat_error *error) {
    if (result != PSPLAT_OK) fail(psplat_result_text(result), error->text);
}

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (!memory) fail("memory", "none is left");
    return memory;
}

/* ---- a loader whose draw calls can be turned off ----------------------------------------------
 */

typedef void (*finish)(void);
typedef void (*draw_arrays)(unsigned mode, int first, int count);
typedef void (*draw_instances)(unsigned mode, int first, int count, int instances);

static struct {
    psplat_host *host;
    finish finish;
    draw_arrays arrays;
    draw_instances instances;
    int is_off;
} loader;

static void draw_or_not(unsigned mode, int first, int count) {
    if (!loader.is_off) loader.arrays(mode, first, count);
}

static void draw_instances_or_not(unsigned mode, int first, int count, int instances) {
    if (!loader.is_off) loader.instances(mode, first, count, instances);
}

/* ISO C has no cast from function to object pointers. */
static void *get_proc(void *user, const char *name) {
    void *address = psplat_host_get_proc(user, name);
    if (strcmp(name, "glDrawArrays") == 0) {
        draw_arrays mine = draw_or_not;
        memcpy(&loader.arrays, &address, sizeof address);
        memcpy(&address, &mine, sizeof address);
    } else if (strcmp(name, "glDrawArraysInstanced") == 0) {
        draw_instances mine = draw_instances_or_not;
        memcpy(&loader.instances, &address, sizeof address);
        memcpy(&address, &mine, sizeof address);
    }
    return address;
}

/* ---- what is drawn ----------------------------------------------------------------------------
 */

/* A grid of spheres, as many items and as one. */
typedef struct grid {
    size_t item_count, sphere_splats;
    psplat_model *sphere, *all;
    psplat_item *items, one;
    subject bounds; /* without an asset */
} grid;

static double spacing(void) {
    return 2.5; /* radii, so that spheres stand apart */
}

static void place(size_t index, size_t side, double position[3]) {
    double middle = 0.5 * (double)(side - 1);
    position[0] = spacing() * ((double)(index % side) - middle);
    position[1] = spacing() * ((double)(index / side) - middle);
    position[2] = 0;
}

/* Gives a splat count clip lines, which keep all of it. */
static void clip(psplat_splat *splat, uint32_t count) {
    const float lines[4][3] = {{1, 0, 1}, {0, 1, 1}, {-1, 0, 1}, {0, -1, 1}};
    splat->clip_count = count;
    for (uint32_t i = 0; i < count; ++i) memcpy(splat->clip[i], lines[i], sizeof lines[i]);
}

/* Returns the splats of spheres on a grid as one scene. */
static scene make_scene(const psplat_batch *sphere, const settings *set, size_t count,
                        size_t side) {
    scene s = scene_blank(count * sphere->splat_count);
    s.depth_tolerance = sphere->depth_tolerance;
    for (size_t i = 0; i < s.count; ++i) {
        size_t splat = i % sphere->splat_count;
        double position[3];
        place(i / sphere->splat_count, side, position);
        s.splats[i] = sphere->splats[splat];
        for (int k = 0; k < 3; ++k) s.splats[i].center[k] += (float)position[k];
        if (set->is_clipped) clip(&s.splats[i], (uint32_t)(5 * splat / sphere->splat_count));
    }
    return s;
}

static psplat_model *make_model(psplat_renderer *renderer, scene s) {
    psplat_error error;
    psplat_model *model = NULL;
    psplat_asset *asset = scene_open(&s);
    check(psplat_model_create(renderer, asset, &model, &error), &error);
    psplat_asset_destroy(asset);
    scene_free(&s);
    return model;
}

static grid make_grid(psplat_renderer *renderer, const settings *set, size_t count) {
    size_t side = (size_t)ceil(sqrt((double)count)), splats = set->splats / count;
    if (splats < 4) splats = 4;
    subject sphere = set->is_curved ? subject_curved_sphere(splats) : subject_sphere(splats);
    const psplat_batch *batch = psplat_asset_batch(sphere.asset, 0);
    grid g = {.item_count = count, .sphere_splats = splats};
    g.sphere = make_model(renderer, make_scene(batch, set, 1, 1));
    g.all = make_model(renderer, make_scene(batch, set, count, side));
    g.items = allocate(count, sizeof *g.items);
    for (size_t i = 0; i < count; ++i) {
        double *m = g.items[i].transform;
        g.items[i].model = g.sphere;
        m[0] = m[5] = m[10] = m[15] = 1;
        place(i, side, m + 12);
    }
    g.one.model = g.all;
    g.bounds.radius = 0.5 * sqrt(2) * spacing() * (double)(side - 1) + 1;
    subject_close(&sphere);
    return g;
}

static void free_grid(psplat_renderer *renderer, grid *g) {
    psplat_model_destroy(renderer, g->sphere);
    psplat_model_destroy(renderer, g->all);
    free(g->items);
}

/* ---- times ------------------------------------------------------------------------------------
 */

typedef struct cost {
    double cpu, wall, thread, no_draws; /* milliseconds */
} cost;

static double thread_time(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* Draws a frame, with a call for each so many items, and returns what it cost. */
static cost draw(psplat_renderer *renderer, const psplat_view *view, const psplat_item *items,
                 size_t count, size_t at_once, int is_off) {
    const float zeros[4] = {0};
    psplat_error error;
    cost c = {0};
    check(psplat_host_begin(loader.host, view->width, view->height, 0, zeros, &error), &error);
    instant start = measure_now();
    loader.is_off = is_off;
    double before = thread_time();
    for (size_t i = 0; i < count; i += at_once) {
        size_t here = count - i < at_once ? count - i : at_once;
        check(psplat_draw(renderer, view, items + i, here, &error), &error);
    }
    c.thread = thread_time() - before;
    loader.is_off = 0;
    loader.finish();
    instant taken = measure_since(start);
    c.cpu = taken.cpu;
    c.wall = taken.wall;
    return c;
}

/* The costs of all frames, column by column. */
typedef struct costs {
    double cpu[MAX_FRAMES], wall[MAX_FRAMES], thread[MAX_FRAMES], no_draws[MAX_FRAMES];
} costs;

static void draw_twice(psplat_renderer *renderer, const psplat_view *view, const psplat_item *items,
                       size_t count, size_t at_once, costs *all, size_t frame) {
    cost c = draw(renderer, view, items, count, at_once, 0);
    all->cpu[frame] = c.cpu;
    all->wall[frame] = c.wall;
    all->thread[frame] = c.thread;
    all->no_draws[frame] = draw(renderer, view, items, count, at_once, 1).thread;
}

static cost median(costs *all, size_t frames) {
    return (cost){measure_median(all->cpu, frames), measure_median(all->wall, frames),
                  measure_median(all->thread, frames), measure_median(all->no_draws, frames)};
}

/* ---- pictures ---------------------------------------------------------------------------------
 */

static uint8_t *picture(psplat_renderer *renderer, const psplat_view *view,
                        const psplat_item *items, size_t count) {
    psplat_error error;
    uint8_t *rgba = allocate((size_t)view->width * (size_t)view->height, 4);
    draw(renderer, view, items, count, count, 0);
    check(psplat_host_read_rgba8(loader.host, rgba, &error), &error);
    return rgba;
}

static size_t differing_pixels(psplat_renderer *renderer, const psplat_view *view, const grid *g) {
    uint8_t *a = picture(renderer, view, g->items, g->item_count);
    uint8_t *b = picture(renderer, view, &g->one, 1);
    size_t pixels = (size_t)view->width * (size_t)view->height, count = 0;
    for (size_t i = 0; i < pixels; ++i) {
        int most = 0;
        for (size_t k = 4 * i; k < 4 * i + 4; ++k)
            most = abs((int)a[k] - (int)b[k]) > most ? abs((int)a[k] - (int)b[k]) : most;
        count += most > 1;
    }
    free(a);
    free(b);
    return count;
}

/* ---- table ------------------------------------------------------------------------------------
 */

static void print_row(const grid *g, const char *name, cost c, cost than, size_t differ) {
    double items = (double)g->item_count, us = 1e3 / items;
    printf("| %zu x %zu | %s | %.2f | %.2f | %.3f | %.3f | %.2f | %.2f | %.2f | %zu |\n",
           g->item_count, g->sphere_splats, name, c.cpu, c.wall, c.thread, c.no_draws,
           c.cpu / than.cpu, us * (c.thread - than.thread), us * (c.no_draws - than.no_draws),
           differ);
    fflush(stdout);
}

static void run(psplat_renderer *renderer, const settings *set, size_t count) {
    enum { WARM_UP = 2 };
    const double direction[3] = {0.1, 0.2, 1};
    grid g = make_grid(renderer, set, count);
    psplat_view view = subject_view(&g.bounds, direction, set->size, 1);
    view.mode = set->mode;
    view.lights[0].casts_shadow = set->has_shadow;
    const psplat_item *items[] = {g.items, &g.one, g.items};
    const size_t counts[] = {count, 1, count <= 64 ? count : 0}, at_once[] = {count, 1, 1};
    costs *of = allocate(3, sizeof *of);
    for (size_t round = 0; round < WARM_UP + set->frames; ++round)
        for (size_t i = 0; i < 3; ++i)
            draw_twice(renderer, &view, items[i], counts[i], at_once[i], &of[i],
                       round < WARM_UP ? 0 : round - WARM_UP);
    cost one = median(&of[1], set->frames);
    print_row(&g, "items", median(&of[0], set->frames), one, differing_pixels(renderer, &view, &g));
    print_row(&g, "one", one, one, 0);
    if (counts[2]) print_row(&g, "apart", median(&of[2], set->frames), one, 0);
    free(of);
    free_grid(renderer, &g);
}

/* ---- command line -----------------------------------------------------------------------------
 */

static psplat_mode mode_of(const char *name) {
    static const char *const names[] = {"phong", "gaussian", "flat"};
    for (int i = 0; i < 3; ++i)
        if (strcmp(name, names[i]) == 0) return (psplat_mode)i;
    fail(name, "no such mode");
    return PSPLAT_MODE_PHONG;
}

static int parse_flag(settings *set, const char *name) {
    if (strcmp(name, "--curved") == 0) return set->is_curved = 1;
    if (strcmp(name, "--clipped") == 0) return set->is_clipped = 1;
    if (strcmp(name, "--shadow") == 0) return set->has_shadow = 1;
    return 0;
}

static void parse_number(settings *set, const char *name, const char *text) {
    const long value = strtol(text, NULL, 10);
    if (strcmp(name, "--splats") == 0 && value >= 4 && value <= 10000000)
        set->splats = (size_t)value;
    else if (strcmp(name, "--items") == 0 && value >= 1 && value <= MAX_ITEMS)
        set->items = (size_t)value;
    else if (strcmp(name, "--size") == 0 && value >= 1 && value <= 8192)
        set->size = (int)value;
    else if (strcmp(name, "--frames") == 0 && value >= 1 && value <= MAX_FRAMES)
        set->frames = (size_t)value;
    else
        fail(name, "unknown, or its value out of range");
}

static settings parse(int argc, char **argv) {
    settings set = {.splats = 64000, .size = 512, .frames = 31};
    for (int i = 1; i < argc; ++i) {
        if (parse_flag(&set, argv[i])) continue;
        if (i + 1 == argc) fail(argv[i], "unknown, or without a value");
        if (strcmp(argv[i], "--mode") == 0)
            set.mode = mode_of(argv[i + 1]);
        else
            parse_number(&set, argv[i], argv[i + 1]);
        ++i;
    }
    return set;
}

int main(int argc, char **argv) {
    const size_t counts[] = {1, 64, 1000};
    settings set = parse(argc, argv);
    psplat_renderer *renderer = NULL;
    psplat_error error;
    check(psplat_host_create(PSPLAT_API_GL, 1, &loader.host, &error), &error);
    psplat_renderer_desc desc = {.get_proc = get_proc, .user = loader.host};
    check(psplat_renderer_create(&desc, &renderer, &error), &error);
    void *address = psplat_host_get_proc(loader.host, "glFinish");
    memcpy(&loader.finish, &address, sizeof address);
    printf("%s, %d pixels\n\n", psplat_host_renderer(loader.host), set.size);
    printf(
        "| items x splats | drawn as | CPU | wall | thread | no draws | CPU / one | thread an item "
        "| no draws an item | differ |\n|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    if (set.items) run(renderer, &set, set.items);
    for (size_t i = 0; i < sizeof counts / sizeof *counts && !set.items; ++i)
        run(renderer, &set, counts[i]);
    psplat_renderer_destroy(renderer);
    psplat_host_destroy(loader.host);
    return 0;
}
