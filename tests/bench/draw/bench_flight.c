/* SPDX-License-Identifier: MIT
 *
 * bench_flight.c - what a low flight over a terrain costs when tiles are chosen by their errors:
 * terrains of more and more splats beside each other, one fixed level, and a simplified mesh.
 *
 *     bench_flight [--levels A,B,...] [--fixed LEVEL] [--mesh ERROR:FILE]... [--pixels N]
 * [--size WxH] [--stops N] [--frames N] [--png DIRECTORY]
 *     bench_flight --write-mesh OUT.obj SIDE
 *
 * The terrain of level L has 576 x 4^L splats at its finest level (flight_terrain.h); --levels (6,
 * 7, 8) names those of the table. At each of --stops (8) places all tiles are loaded that errors of
 * at most --pixels (1) want, then --frames (5) frames are timed, those of all contestants in turn.
 * --fixed adds the finest level of a terrain with all tiles in the view, --mesh a mesh that is
 * drawn where its error, in units of the terrain's side, is at most as great as --pixels at the
 * ground below the eye; of several the coarsest. --write-mesh writes the terrain's surface as a
 * mesh of 2 SIDE^2 triangles, from which to make such meshes. Columns are means over the stops:
 *
 *     finest     splats of the finest level, or triangles of the finest mesh
 *     drawn      tiles, and splats or triangles
 *     error      the greatest of what is drawn, in pixels
 *     select     CPU of psplat_tiles_select, ms
 *     frame      CPU of all threads for select and draw, ms (median at each stop)
 *     ratio      of frame to that of the first row
 */
#include "flight_terrain.h"
#include "measure.h"
#include "source_drawing.h"

#include <phongsplat/host.h>
#include <phongsplat/tiles.h>

#include "picture/png_writer.h"
#include "views/mesh_renderer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_ROWS = 16, MAX_FRAMES = 100 };

static const double opening = 60; /* degrees, vertical */

typedef struct settings {
    int levels[MAX_ROWS], level_count, fixed; /* fixed: a level, or -1 */
    const char *meshes[MAX_ROWS];
    int mesh_count, width, height, stops, frames;
    double pixels;
    const char *png;
} settings;

/* A terrain of which tiles are drawn. */
typedef struct flown {
    terrain terrain;
    psplat_tiles *tiles;
    double pixels;
    const char *name;
} flown;

/* A mesh with its error, or nothing. */
typedef struct level {
    double error;
    size_t triangles;
    psplat_mesh_renderer *renderer;
} level;

/* Sums over stops. */
typedef struct row {
    double drawn, primitives, error, select, frame;
} row;

typedef struct bench {
    settings set;
    psplat_host *host;
    psplat_renderer *renderer;
    flown flown[MAX_ROWS];
    int flown_count;
    level levels[MAX_ROWS]; /* the coarsest last */
    row rows[MAX_ROWS + 1];
} bench;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_flight: %s: %s\n", what, why);
    exit(2);
}

static void check(psplat_result result, const psplat_error *error) {
    if (result != PSPLAT_OK) fail(psplat_result_text(result), error->text);
}

/* ---- tiles --------------------------------------------------------------------------------- */

static psplat_result read_file(void *user, const char *path, uint64_t offset, void *data,
                               size_t size, size_t *got, psplat_error *error) {
    size_t all;
    uint8_t *bytes = terrain_file(user, path, &all);
    (void)error;
    *got = offset > all ? 0 : all - (size_t)offset < size ? all - (size_t)offset : size;
    if (*got) memcpy(data, bytes + offset, *got);
    free(bytes);
    return PSPLAT_OK;
}

static void open_flown(bench *b, int finest, double pixels, const char *name) {
    psplat_error error;
    flown *f = &b->flown[b->flown_count++];
    f->terrain = terrain_make(finest);
    f->pixels = pixels;
    f->name = name;
    const psplat_tiles_desc desc = {.source = {.read = read_file, .user = &f->terrain},
                                    .max_bytes = (size_t)8 << 30,
                                    .max_requests = 256};
    check(psplat_tiles_open(&desc, "tileset.json", &f->tiles, &error), &error);
}

static void select_tiles(const flown *f, const psplat_view *view) {
    psplat_error error;
    const psplat_tiles_view chosen = {.view = view, .pixels = f->pixels};
    check(psplat_tiles_select(f->tiles, &chosen, &error), &error);
}

/* Loads all that a view wants. */
static void settle(bench *b, const flown *f, const psplat_view *view) {
    psplat_error error;
    psplat_tile_request requests[64];
    for (;;) {
        select_tiles(f, view);
        size_t count = psplat_tiles_wanted(f->tiles, requests, 64);
        if (!count) return;
        for (size_t i = 0; i < count; ++i) {
            size_t size;
            uint8_t *bytes = terrain_file(&f->terrain, requests[i].path, &size);
            check(psplat_tiles_supply(f->tiles, requests[i].tile, bytes, size, &error), &error);
            free(bytes);
        }
        check(psplat_tiles_upload(f->tiles, b->renderer, SIZE_MAX, &error), &error);
    }
}

/* ---- frames -------------------------------------------------------------------------------- */

/* Fills the view from a place on the way, 0 ... 1: low above the ground, looking ahead and a little
 * down. Returns the height above the ground. */
static double place_eye(double way, psplat_view *view) {
    const double above = 0.03, down = 0.2;
    double eye[3] = {0.5 + 0.15 * sin(5 * way), 0, 0.95 - 0.6 * way};
    double f = 1 / tan(opening * 3.14159265358979323846 / 360), near = 1e-3, far = 3;
    double c = cos(down), s = sin(down), *m = view->view, *p = view->projection;
    eye[1] = terrain_height(eye[0], eye[2]) + above;
    const double axes[3][3] = {{1, 0, 0}, {0, c, -s}, {0, s, c}};
    memset(m, 0, 16 * sizeof *m);
    memset(p, 0, 16 * sizeof *p);
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) {
            m[4 * k + r] = axes[r][k];
            m[12 + r] -= axes[r][k] * eye[k];
        }
    m[15] = 1;
    p[0] = f * view->height / view->width;
    p[5] = f;
    p[10] = (near + far) / (near - far);
    p[11] = -1;
    p[14] = 2 * near * far / (near - far);
    return above;
}

static psplat_view make_view(const settings *set) {
    psplat_view view = {.width = set->width, .height = set->height, .light_count = 1};
    for (int i = 0; i < 3; ++i) {
        const float sun[3] = {-0.6f, -0.55f, -0.3f}, sky[3] = {0.08f, 0.1f, 0.14f};
        view.lights[0].direction[i] = sun[i];
        view.lights[0].color[i] = 2.6f;
        view.ambient[i] = sky[i];
    }
    return view;
}

static void begin(const bench *b, const psplat_view *view) {
    const float haze[4] = {0.6f, 0.7f, 0.8f, 1};
    psplat_error error;
    check(psplat_host_begin(b->host, view->width, view->height, 0, haze, &error), &error);
}

/* Waits for all that was drawn. */
static void finish(const bench *b, const psplat_view *view, uint8_t *rgba) {
    psplat_error error;
    (void)view;
    check(psplat_host_read_rgba8(b->host, rgba, &error), &error);
}

/* Draws a frame of tiles and returns its CPU ms; *select gets those of the choice alone. */
static double draw_tiles(const bench *b, const flown *f, const psplat_view *view, uint8_t *rgba,
                         double *select) {
    psplat_error error;
    size_t count;
    begin(b, view);
    instant start = measure_now();
    select_tiles(f, view);
    *select = measure_since(start).cpu;
    const psplat_item *items = psplat_tiles_items(f->tiles, &count);
    check(psplat_draw(b->renderer, view, items, count, &error), &error);
    finish(b, view, rgba);
    return measure_since(start).cpu;
}

static double draw_mesh(const bench *b, const level *l, const psplat_view *view, uint8_t *rgba) {
    psplat_error error;
    begin(b, view);
    instant start = measure_now();
    check(psplat_mesh_renderer_draw(l->renderer, view, PSPLAT_MESH_RENDERER_LIGHT, &error), &error);
    finish(b, view, rgba);
    return measure_since(start).cpu;
}

static void write_png(const bench *b, const char *name, int stop, const uint8_t *rgba) {
    char path[1024];
    size_t size, width = (size_t)b->set.width, height = (size_t)b->set.height;
    psplat_error error;
    uint8_t *rgb = malloc(3 * width * height), *png;
    if (!rgb) fail("memory", "none is left");
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x)
            memcpy(rgb + 3 * (y * width + x), rgba + 4 * ((height - 1 - y) * width + x), 3);
    check(psplat_png_encode(rgb, b->set.width, b->set.height, 3, &png, &size, &error), &error);
    snprintf(path, sizeof path, "%s/%s-%d.png", b->set.png, name, stop);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(png, 1, size, file) != size || fclose(file)) fail(path, "is not written");
    free(png);
    free(rgb);
}

/* ---- a stop -------------------------------------------------------------------------------- */

/* Returns the coarsest mesh whose error is small enough on the ground so far below the eye, or the
 * finest one. */
static const level *choose_mesh(const bench *b, double above, double *pixels) {
    double scale = 0.5 * b->set.height / tan(opening * 3.14159265358979323846 / 360) / above;
    const level *best = &b->levels[0];
    for (int i = 1; i < b->set.mesh_count; ++i)
        if (b->levels[i].error * scale <= b->set.pixels && b->levels[i].error > best->error)
            best = &b->levels[i];
    *pixels = best->error * scale;
    return best;
}

static void note_tiles(const flown *f, row *to) {
    psplat_tiles_state state = psplat_tiles_describe(f->tiles);
    to->drawn += (double)state.drawn;
    to->primitives += (double)state.splats;
    to->error = fmax(to->error, state.error_pixels);
}

static void fly_stop(bench *b, int stop, uint8_t *rgba) {
    double times[MAX_ROWS + 1][MAX_FRAMES], choices[MAX_ROWS][MAX_FRAMES], pixels = 0;
    psplat_view view = make_view(&b->set);
    double above = place_eye((stop + 0.5) / b->set.stops, &view);
    const level *mesh = b->set.mesh_count ? choose_mesh(b, above, &pixels) : NULL;
    for (int i = 0; i < b->flown_count; ++i) settle(b, &b->flown[i], &view);
    for (int k = -1; k < b->set.frames; ++k) { /* the first one makes targets and programs */
        int at = k < 0 ? 0 : k;
        for (int i = 0; i < b->flown_count; ++i) {
            times[i][at] = draw_tiles(b, &b->flown[i], &view, rgba, &choices[i][at]);
            if (k < 0 && b->set.png) write_png(b, b->flown[i].name, stop, rgba);
        }
        if (mesh) times[MAX_ROWS][at] = draw_mesh(b, mesh, &view, rgba);
        if (mesh && k < 0 && b->set.png) write_png(b, "mesh", stop, rgba);
    }
    for (int i = 0; i < b->flown_count; ++i) {
        note_tiles(&b->flown[i], &b->rows[i]);
        b->rows[i].select += measure_median(choices[i], (size_t)b->set.frames);
        b->rows[i].frame += measure_median(times[i], (size_t)b->set.frames);
    }
    if (!mesh) return;
    b->rows[MAX_ROWS].primitives += (double)mesh->triangles;
    b->rows[MAX_ROWS].frame += measure_median(times[MAX_ROWS], (size_t)b->set.frames);
    b->rows[MAX_ROWS].error = fmax(b->rows[MAX_ROWS].error, pixels);
}

/* ---- the table ----------------------------------------------------------------------------- */

static void print_row(const bench *b, const char *name, double finest, const row *r) {
    double n = b->set.stops;
    printf("| %-8s | %10.0f | %6.1f | %9.0f | %6.2f | %6.3f | %8.1f | %5.2f |\n", name, finest,
           r->drawn / n, r->primitives / n, r->error, r->select / n, r->frame / n,
           r->frame / b->rows[0].frame);
}

static void print_table(const bench *b) {
    size_t finest = 0;
    printf("| %-8s | %10s | %6s | %9s | %6s | %6s | %8s | %5s |\n", "drawn", "finest", "tiles",
           "drawn", "error", "select", "frame", "ratio");
    printf("|---|--:|--:|--:|--:|--:|--:|--:|\n");
    for (int i = 0; i < b->flown_count; ++i)
        print_row(b, b->flown[i].name, (double)terrain_splats(&b->flown[i].terrain), &b->rows[i]);
    for (int i = 0; i < b->set.mesh_count; ++i)
        finest = b->levels[i].triangles > finest ? b->levels[i].triangles : finest;
    if (b->set.mesh_count) print_row(b, "mesh", (double)finest, &b->rows[MAX_ROWS]);
}

/* ---- beginning and end --------------------------------------------------------------------- */

static void open_mesh(bench *b, const char *argument, level *l) {
    psplat_error error;
    mesh m;
    char *end;
    l->error = strtod(argument, &end);
    if (*end != ':') fail(argument, "is not ERROR:FILE");
    mesh_read(end + 1, &m);
    l->triangles = m.source.triangle_count;
    const psplat_mesh_renderer_desc desc = {psplat_host_get_proc, b->host, m.original};
    check(psplat_mesh_renderer_create(&desc, &l->renderer, &error), &error);
    mesh_free(&m);
}

static int by_error(const void *a, const void *b) {
    double difference = ((const level *)a)->error - ((const level *)b)->error;
    return (difference > 0) - (difference < 0);
}

static void open_all(bench *b) {
    static const char *const names[] = {"level0", "level1", "level2", "level3", "level4",
                                        "level5", "level6", "level7", "level8", "level9"};
    psplat_error error;
    check(psplat_host_create(PSPLAT_API_GL, 1, &b->host, &error), &error);
    const psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = b->host};
    check(psplat_renderer_create(&desc, &b->renderer, &error), &error);
    for (int i = 0; i < b->set.level_count; ++i)
        open_flown(b, b->set.levels[i], b->set.pixels, names[b->set.levels[i]]);
    if (b->set.fixed >= 0) open_flown(b, b->set.fixed, 1e-9, "fixed");
    for (int i = 0; i < b->set.mesh_count; ++i) open_mesh(b, b->set.meshes[i], &b->levels[i]);
    qsort(b->levels, (size_t)b->set.mesh_count, sizeof *b->levels, by_error);
}

static void close_all(bench *b) {
    for (int i = 0; i < b->flown_count; ++i) psplat_tiles_destroy(b->flown[i].tiles, b->renderer);
    for (int i = 0; i < b->set.mesh_count; ++i) psplat_mesh_renderer_destroy(b->levels[i].renderer);
    psplat_renderer_destroy(b->renderer);
    psplat_host_destroy(b->host);
}

static int number(const char *text, int least, int most) {
    char *end;
    long n = strtol(text, &end, 10);
    if (end == text || (*end && *end != ',' && *end != 'x') || n < least || n > most)
        fail(text, "is not a number in its range");
    return (int)n;
}

static void parse_levels(const char *text, settings *set) {
    set->level_count = 0;
    for (; text && set->level_count < MAX_ROWS / 2; text = strchr(text, ',')) {
        text += *text == ',';
        set->levels[set->level_count++] = number(text, 1, TERRAIN_MAX_LEVEL);
    }
}

static void parse_size(const char *text, settings *set) {
    const char *x = strchr(text, 'x');
    if (!x) fail(text, "is not WxH");
    set->width = number(text, 1, 8192);
    set->height = number(x + 1, 1, 8192);
}

static int is_option(const char *argument, const char *name) {
    return !strcmp(argument, name);
}

static void parse_option(const char *option, const char *value, settings *set) {
    if (is_option(option, "--levels"))
        parse_levels(value, set);
    else if (is_option(option, "--fixed"))
        set->fixed = number(value, 1, TERRAIN_MAX_LEVEL);
    else if (is_option(option, "--mesh") && set->mesh_count < MAX_ROWS)
        set->meshes[set->mesh_count++] = value;
    else if (is_option(option, "--pixels"))
        set->pixels = strtod(value, NULL);
    else if (is_option(option, "--size"))
        parse_size(value, set);
    else if (is_option(option, "--stops"))
        set->stops = number(value, 1, 1000);
    else if (is_option(option, "--frames"))
        set->frames = number(value, 1, MAX_FRAMES);
    else if (is_option(option, "--png"))
        set->png = value;
    else
        fail(option, "is not an option");
}

int main(int argc, char **argv) {
    bench *b = calloc(1, sizeof *b);
    if (!b) fail("memory", "none is left");
    if (argc == 4 && is_option(argv[1], "--write-mesh")) {
        terrain_write_mesh(argv[2], number(argv[3], 1, 8192));
        free(b);
        return 0;
    }
    b->set = (settings){.levels = {6, 7, 8},
                        .level_count = 3,
                        .fixed = -1,
                        .width = 960,
                        .height = 540,
                        .stops = 8,
                        .frames = 5,
                        .pixels = 1};
    for (int i = 1; i < argc; i += 2)
        parse_option(argv[i], i + 1 < argc ? argv[i + 1] : "", &b->set);
    uint8_t *rgba = malloc((size_t)b->set.width * (size_t)b->set.height * 4);
    if (!rgba) fail("memory", "none is left");
    open_all(b);
    for (int stop = 0; stop < b->set.stops; ++stop) fly_stop(b, stop, rgba);
    print_table(b);
    close_all(b);
    free(rgba);
    free(b);
    return 0;
}
