/* SPDX-License-Identifier: MIT
 *
 * bench_equal.c - counts the phong, gaussian and flat splats that give an equally good picture
 * (BSK04 section 5 and figure 9, where 3k, 33k and 170k look alike).
 *
 *     bench_equal [--size N] [--most SPLATS] [--picture FILE.png] [MESH...]
 *
 * Phong splats are converted at 2, 1, 0.5 and 0.2 %. The other modes get splats with constant
 * normals, made for them in two ways, of which the better one counts: by ever smaller tolerances
 * (up to a twentieth of SPLATS), and at 0.5 % by ever smaller angles between a splat and the
 * surface's normals, until their shading is as good or there are more than SPLATS (60000) of them.
 * All are drawn without the screen-space filter, so that only the splats are compared.
 *
 * Pictures are those of `compare`: twelve views, size x size pixels, beside the mesh lit per pixel.
 * Errors are mean absolute differences of sRGB-encoded colours in percent of white: first over the
 * pixels that both cover, where the modes differ, and in parentheses over those that either covers,
 * so that outlines count too. The table of equal errors uses the first and interpolates between
 * measurements on logarithmic axes; "> " means that even the most splats tried are not enough.
 *
 * With --picture, the first mesh is shown beside its 0.5 % phong splats and as many gaussian and
 * flat ones.
 */
#include "views/image_metrics.h"
#include "base/output.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "picture/png_writer.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MODES = 3, MOST_POINTS = 64, FEWER = 20 };

static const psplat_mode modes[MODES] = {PSPLAT_MODE_PHONG, PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_FLAT};

typedef struct settings {
    int size;
    size_t most;
    const char *picture;
} settings;

/* The number of splats and the error of their picture. */
typedef struct point {
    double splats, error;
} point;

/* Points in order of splats, for one mode and one way to make splats for it. */
typedef struct curve {
    point points[MOST_POINTS];
    size_t count;
} curve;

typedef struct bench {
    settings set;
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_mesh mesh;
    psplat_source_mesh *original;
    psplat_picture_views *views;
    const char *name;
    curve curves[MODES][2]; /* [0] by tolerance, [1] by angle */
} bench;

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench_equal: %s\n", error->text);
    exit(1);
}

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- one set of splats ----------------------------------------------------------------------- */

static psplat_model *convert(const bench *b, const psplat_convert_desc *desc, size_t *count) {
    psplat_splats splats = {0};
    psplat_asset *asset = NULL;
    psplat_model *model = NULL;
    psplat_error error;
    uint8_t *glb = NULL;
    size_t size = 0;
    check(psplat_convert(&b->mesh, desc, &splats, NULL, &error), &error);
    check(psplat_glb_write(&splats, NULL, NULL, &glb, &size, &error), &error);
    check(psplat_asset_open_memory(glb, size, NULL, &asset, &error), &error);
    check(psplat_model_create(b->renderer, asset, &model, &error), &error);
    *count = splats.count;
    psplat_asset_destroy(asset);
    psplat_splats_free(&splats);
    free(glb);
    return model;
}

static void measure(bench *b, psplat_model *model, size_t count, int mode, int by_angle) {
    const psplat_pictured pictured = {
        .renderer = b->renderer, .model = model, .mode = modes[mode], .no_filter = 1};
    psplat_picture_errors errors;
    psplat_error error;
    check(psplat_picture_views_compare(b->views, &pictured, -1, &errors, &error), &error);
    curve *c = &b->curves[mode][by_angle];
    if (c->count < MOST_POINTS) c->points[c->count++] = (point){(double)count, errors.inside};
    printf(" %.3f (%.3f) |", errors.inside, errors.difference);
}

/* Converts, measures in the modes first to end - 1, and returns how many splats there are. */
static size_t run(bench *b, const psplat_convert_desc *desc, int first, int end) {
    size_t count = 0;
    double start = seconds_now();
    psplat_model *model = convert(b, desc, &count);
    double taken = seconds_now() - start;
    printf("| %s | %s | %g | ", b->name, desc->constant_normals ? "constant" : "linear",
           desc->tolerance_percent);
    if (desc->normal_tolerance_degrees > 0) printf("%.3g", desc->normal_tolerance_degrees);
    printf(" | %zu |", count);
    for (int mode = 0; mode < MODES; ++mode) {
        if (mode < first || mode >= end)
            printf(" |");
        else
            measure(b, model, count, mode, desc->normal_tolerance_degrees > 0);
    }
    printf(" %.1f |\n", taken);
    fflush(stdout);
    psplat_model_destroy(b->renderer, model);
    return count;
}

/* ---- conversions
 * --------------------------------------------------------------------------------- */

/* Converts ever finer until flat splats, which need the most, are as good as the best phong splats,
 * or until there are too many. */
static void convert_until_equal(bench *b, int by_angle) {
    psplat_convert_desc desc = {.tolerance_percent = by_angle ? 0.5 : 2,
                                .effort = PSPLAT_EFFORT_NONE,
                                .constant_normals = 1,
                                .unverified = 1};
    const curve *flat = &b->curves[2][by_angle], *phong = &b->curves[0][0];
    size_t most = by_angle ? b->set.most : b->set.most / FEWER, count = 0;
    double angle = 24;
    do {
        desc.normal_tolerance_degrees = by_angle ? angle : 0;
        count = run(b, &desc, 1, MODES);
        angle /= sqrt(2);
        if (!by_angle) desc.tolerance_percent /= 2;
    } while (count <= most && flat->count < MOST_POINTS &&
             flat->points[flat->count - 1].error > phong->points[phong->count - 1].error);
}

static void convert_all(bench *b) {
    const double tolerances[] = {2, 1, 0.5, 0.2};
    for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; ++i) {
        const psplat_convert_desc desc = {.tolerance_percent = tolerances[i], .unverified = 1};
        run(b, &desc, 0, 1);
    }
    convert_until_equal(b, 0);
    convert_until_equal(b, 1);
}

/* ---- equal errors ---------------------------------------------------------------------------- */

/* Returns the splats that reach an error on a curve: those of its first point where these are
 * enough already, minus those of its last point where even these are not. */
static double splats_for(const curve *c, double error) {
    const point *p = c->points;
    if (p[0].error <= error) return p[0].splats;
    for (size_t i = 1; i < c->count; ++i) {
        double before = p[i - 1].error, after = p[i].error;
        if (after > error) continue;
        double t = log(before / error) / log(before / after);
        return p[i - 1].splats * pow(p[i].splats / p[i - 1].splats, t);
    }
    return -p[c->count - 1].splats;
}

/* Returns the better of both ways. A bound (negative) is returned only where neither reaches the
 * error. */
static double best_for(const bench *b, int mode, double error) {
    double first = splats_for(&b->curves[mode][0], error);
    double second = splats_for(&b->curves[mode][1], error);
    if (first > 0 && second > 0) return fmin(first, second);
    if (first > 0 || second > 0) return fmax(first, second);
    return fmin(first, second);
}

static void print_equal(const bench *b) {
    const curve *phong = &b->curves[0][0];
    for (size_t i = 0; i < phong->count; ++i) {
        const point *p = &phong->points[i];
        printf("| %s | %.3f | %.0f |", b->name, p->error, p->splats);
        for (int mode = 1; mode < MODES; ++mode) {
            double splats = best_for(b, mode, p->error);
            const char *mark = splats < 0 ? "> " : "";
            printf(" %s%.0f | %s%.1f |", mark, fabs(splats), mark, fabs(splats) / p->splats);
        }
        printf("\n");
    }
}

/* ---- models ---------------------------------------------------------------------------------- */

static void open_model(bench *b, const char *path) {
    psplat_error error;
    const char *slash = strrchr(path, '/');
    b->name = slash ? slash + 1 : path;
    memset(b->curves, 0, sizeof b->curves);
    b->mesh = (psplat_mesh){0};
    check(psplat_mesh_read(path, &b->mesh, &error), &error);
    check(psplat_source_mesh_create(&b->mesh, 0, &b->original, &error), &error);
    const psplat_picture_views_desc desc = {
        .host = b->host, .source = b->original, .size = b->set.size};
    check(psplat_picture_views_create(&desc, &b->views, &error), &error);
}

static void close_model(bench *b) {
    psplat_picture_views_destroy(b->views);
    psplat_source_mesh_destroy(b->original);
    psplat_mesh_free(&b->mesh);
}

static const char *parse(int argc, char **argv, settings *set, int *first) {
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        long value = strtol(argv[i + 1], NULL, 10);
        if (!strcmp(argv[i], "--size") && value >= 16 && value <= 4096)
            set->size = (int)value;
        else if (!strcmp(argv[i], "--most") && value > 0)
            set->most = (size_t)value;
        else if (!strcmp(argv[i], "--picture"))
            set->picture = argv[i + 1];
        else
            return argv[i];
    }
    *first = i;
    return i < argc && argv[i][0] == '-' ? argv[i] : NULL;
}

/* ---- a picture ------------------------------------------------------------------------------- */

/* Copies the framebuffer to panel k of a row of `panels`. */
static void keep_panel(const bench *b, int k, int panels, uint8_t *rgb) {
    size_t size = (size_t)b->set.size;
    uint8_t *shown = malloc(4 * size * size);
    psplat_error error;
    if (!shown) abort();
    check(psplat_host_read_rgba8(b->host, shown, &error), &error);
    for (size_t y = 0; y < size; ++y)
        for (size_t x = 0; x < size; ++x) {
            const uint8_t *from = shown + 4 * (size * (size - 1 - y) + x);
            uint8_t *to = rgb + 3 * (size * ((size_t)panels * y + (size_t)k) + x);
            for (int c = 0; c < 3; ++c) to[c] = from[3] ? from[c] : 255;
        }
    free(shown);
}

static void draw_panels(const bench *b, psplat_model *model, uint8_t *rgb) {
    psplat_view view = psplat_picture_views_at(b->views, 0);
    const psplat_item item = {.model = model};
    const float zeros[4] = {0};
    psplat_error error;
    for (int k = 0; k <= MODES; ++k) {
        check(psplat_host_begin(b->host, view.width, view.height, 0, zeros, &error), &error);
        if (k) view.mode = modes[MODES - k];
        view.no_filter = 1;
        check(k ? psplat_draw(b->renderer, &view, &item, 1, &error)
                : psplat_picture_views_draw_source(b->views, &view, &error),
              &error);
        keep_panel(b, k, MODES + 1, rgb);
    }
}

/* Writes, from left to right, the mesh, flat, gaussian and phong splats. */
static void write_picture(const bench *b) {
    const psplat_convert_desc desc = {.tolerance_percent = 0.5, .unverified = 1};
    size_t count = 0, size = (size_t)b->set.size, bytes = 0;
    psplat_model *model = convert(b, &desc, &count);
    uint8_t *rgb = malloc(3 * size * size * (MODES + 1)), *png = NULL;
    psplat_error error;
    if (!rgb) abort();
    draw_panels(b, model, rgb);
    check(psplat_png_encode(rgb, (MODES + 1) * b->set.size, b->set.size, 3, &png, &bytes, &error),
          &error);
    check(psplat_output_write(b->set.picture, png, bytes, 1, &error), &error);
    printf("\n%s: %s as mesh and as %zu splats, flat, gaussian and phong\n", b->set.picture,
           b->name, count);
    free(rgb);
    free(png);
    psplat_model_destroy(b->renderer, model);
}

/* ---- all of it ------------------------------------------------------------------------------- */

int main(int argc, char **argv) {
    static bench models[8];
    bench shared = {.set = {.size = 512, .most = 60000}};
    char *bundled[] = {PSPLAT_SOURCE_DIR "/samples/models/torus.off",
                       PSPLAT_SOURCE_DIR "/samples/models/part.obj"};
    int first = 0;
    psplat_error error;
    const char *wrong = parse(argc, argv, &shared.set, &first);
    char **paths = first < argc ? argv + first : bundled;
    int count = first < argc ? argc - first : 2;
    if (wrong || count > 8) {
        fprintf(stderr, "bench_equal: %s: unknown, or its value out of range\n",
                wrong ? wrong : "more than 8 meshes");
        return 2;
    }
    check(psplat_host_create(PSPLAT_API_GL, 1, &shared.host, &error), &error);
    const psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = shared.host};
    check(psplat_renderer_create(&desc, &shared.renderer, &error), &error);
    printf("| model | normals | tolerance %% | angle | splats | phong | gaussian | flat | s |\n"
           "|---|---|--:|--:|--:|--:|--:|--:|--:|\n");
    for (int i = 0; i < count; ++i) {
        models[i] = shared;
        open_model(&models[i], paths[i]);
        convert_all(&models[i]);
    }
    printf("\n| model | error %% | phong | gaussian | of phong | flat | of phong |\n"
           "|---|--:|--:|--:|--:|--:|--:|\n");
    for (int i = 0; i < count; ++i) print_equal(&models[i]);
    if (shared.set.picture) write_picture(&models[0]);
    for (int i = 0; i < count; ++i) close_model(&models[i]);
    psplat_renderer_destroy(shared.renderer);
    psplat_host_destroy(shared.host);
    return 0;
}
