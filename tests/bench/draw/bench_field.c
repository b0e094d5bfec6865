/* SPDX-License-Identifier: MIT
 *
 * bench_field.c - what a field of instances costs when each is drawn at the level of detail that
 * its distance wants, beside all of them at the finest level.
 *
 *     bench_field [--items N] [--size N] [--pixels N] [--reach N] [--frames N] [--png FILE]
 *                 ERROR:FILE [ERROR:FILE ...]
 *
 * The files are conversions of one model, from fine to coarse, with their greatest distances in
 * percent of its diagonal. --items (1000) instances, their diagonals of length 1, stand at random
 * in a wedge before the eye that reaches from 2 to --reach (100); a view has --size (512) pixels
 * squared and an opening angle of 60 degrees. A level is drawn where its error is at most --pixels
 * (1). Medians of --frames (9) frames, of the two in turn, are printed:
 *
 *     splats     of all instances
 *     CPU        of all threads, ms a frame
 *     thread     of the thread that calls psplat_draw while it is in there, ms a frame
 *     ratio      of CPU to that of the finest level
 *
 * and how many instances have each level. --png writes both pictures beside each other.
 */
#include "measure.h"
#include "subject.h"

#include <phongsplat/host.h>

#include "picture/png_writer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_LEVELS = 16, MAX_FRAMES = 200 };

typedef struct level {
    double error; /* parts of the diagonal */
    psplat_model *model;
    size_t splats, items;
} level;

typedef struct bench {
    int items, size, frames;
    double pixels, reach;
    const char *png;
    level levels[MAX_LEVELS];
    int level_count;
    double low[3], high[3]; /* of the model */
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_item *fixed, *chosen;
} bench;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_field: %s: %s\n", what, why);
    exit(2);
}

static void check(psplat_result result, const psplat_error *error) {
    if (result != PSPLAT_OK) fail(psplat_result_text(result), error->text);
}

static double focal_length(void) {
    return 1 / tan(3.14159265358979323846 / 6);
}

/* ---- the field ----------------------------------------------------------------------------- */

static double random_number(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / 16777216;
}

/* Places an instance and returns its distance along the view, at its nearest point. */
static double place(const bench *b, uint32_t *random, double transform[16]) {
    double size = 0, scale;
    for (int i = 0; i < 3; ++i) size += (b->high[i] - b->low[i]) * (b->high[i] - b->low[i]);
    scale = 1 / sqrt(size);
    double from = 2, far = b->reach, angle = 0.9 * (random_number(random) - 0.5);
    double distance = sqrt(from * from + (far * far - from * from) * random_number(random));
    const double at[3] = {distance * sin(angle), -0.9 - 0.02 * distance, -distance * cos(angle)};
    memset(transform, 0, 16 * sizeof *transform);
    transform[0] = transform[5] = transform[10] = scale;
    for (int i = 0; i < 3; ++i)
        transform[12 + i] = at[i] - scale * (i == 1 ? b->low[i] : 0.5 * (b->low[i] + b->high[i]));
    transform[15] = 1;
    return distance * cos(angle) - 0.5;
}

static void make_field(bench *b) {
    uint32_t random = 1;
    b->fixed = calloc((size_t)b->items, sizeof *b->fixed);
    b->chosen = calloc((size_t)b->items, sizeof *b->chosen);
    if (!b->fixed || !b->chosen) fail("memory", "none is left");
    for (int i = 0; i < b->items; ++i) {
        double distance = place(b, &random, b->fixed[i].transform);
        int best = 0;
        for (int k = 1; k < b->level_count; ++k)
            if (b->levels[k].error * 0.5 * b->size * focal_length() / distance <= b->pixels)
                best = k;
        b->chosen[i] = b->fixed[i];
        b->fixed[i].model = b->levels[0].model;
        b->chosen[i].model = b->levels[best].model;
        ++b->levels[best].items;
    }
}

static psplat_view make_view(const bench *b) {
    double near = 0.5, far = b->reach + 2, *p;
    psplat_view view = {.width = b->size, .height = b->size, .light_count = 1};
    for (int i = 0; i < 4; ++i) view.view[5 * i] = 1;
    p = view.projection;
    p[0] = p[5] = focal_length();
    p[10] = (near + far) / (near - far);
    p[11] = -1;
    p[14] = 2 * near * far / (near - far);
    for (int i = 0; i < 3; ++i) {
        const float along[3] = {-0.3f, -0.6f, -0.7f};
        view.lights[0].direction[i] = along[i];
        view.lights[0].color[i] = 2.8f;
        view.ambient[i] = 0.1f;
    }
    return view;
}

/* ---- frames -------------------------------------------------------------------------------- */

static double thread_time(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void draw(const bench *b, const psplat_view *view, const psplat_item *items, uint8_t *rgba,
                 double *cpu, double *thread) {
    const float white[4] = {1, 1, 1, 1};
    psplat_error error;
    check(psplat_host_begin(b->host, view->width, view->height, 0, white, &error), &error);
    instant start = measure_now();
    double before = thread_time();
    check(psplat_draw(b->renderer, view, items, (size_t)b->items, &error), &error);
    *thread = thread_time() - before;
    check(psplat_host_read_rgba8(b->host, rgba, &error), &error);
    *cpu = measure_since(start).cpu;
}

static void write_png(const bench *b, const uint8_t *left, const uint8_t *right) {
    size_t side = (size_t)b->size, size;
    psplat_error error;
    uint8_t *rgb = malloc(6 * side * side), *png;
    if (!rgb) fail("memory", "none is left");
    for (size_t y = 0; y < side; ++y)
        for (size_t x = 0; x < 2 * side; ++x)
            memcpy(rgb + 3 * (2 * y * side + x),
                   (x < side ? left : right) + 4 * ((side - 1 - y) * side + x % side), 3);
    check(psplat_png_encode(rgb, 2 * b->size, b->size, 3, &png, &size, &error), &error);
    FILE *file = fopen(b->png, "wb");
    if (!file || fwrite(png, 1, size, file) != size || fclose(file)) fail(b->png, "is not written");
    free(png);
    free(rgb);
}

static void print_row(const char *name, double splats, double cpu, double thread, double ratio) {
    printf("| %-8s | %10.0f | %8.1f | %7.2f | 1/%-5.1f |\n", name, splats, cpu, thread, 1 / ratio);
}

static void run(bench *b) {
    double cpu[2][MAX_FRAMES], thread[2][MAX_FRAMES], splats = 0;
    size_t bytes = 4 * (size_t)b->size * (size_t)b->size;
    uint8_t *fixed = malloc(bytes), *chosen = malloc(bytes);
    psplat_view view = make_view(b);
    if (!fixed || !chosen) fail("memory", "none is left");
    for (int k = -1; k < b->frames; ++k) { /* the first one makes targets and programs */
        int at = k < 0 ? 0 : k;
        draw(b, &view, b->fixed, fixed, &cpu[0][at], &thread[0][at]);
        draw(b, &view, b->chosen, chosen, &cpu[1][at], &thread[1][at]);
    }
    size_t n = (size_t)b->frames;
    double all = measure_median(cpu[0], n), few = measure_median(cpu[1], n);
    for (int i = 0; i < b->level_count; ++i)
        splats += (double)(b->levels[i].splats * b->levels[i].items);
    printf("| drawn    |     splats |      CPU |  thread | ratio   |\n|---|--:|--:|--:|--:|\n");
    print_row("finest", (double)b->levels[0].splats * b->items, all, measure_median(thread[0], n),
              1);
    print_row("levels", splats, few, measure_median(thread[1], n), few / all);
    printf("\ninstances of each level, from the finest on:");
    for (int i = 0; i < b->level_count; ++i) printf(" %zu", b->levels[i].items);
    printf("\n");
    if (b->png) write_png(b, fixed, chosen);
    free(fixed);
    free(chosen);
}

/* ---- beginning and end --------------------------------------------------------------------- */

static void open_level(bench *b, const char *argument) {
    psplat_error error;
    char *end;
    level *l = &b->levels[b->level_count++];
    l->error = strtod(argument, &end) / 100;
    if (*end != ':' || l->error <= 0) fail(argument, "is not ERROR:FILE");
    subject s = subject_open(end + 1);
    check(psplat_model_create(b->renderer, s.asset, &l->model, &error), &error);
    l->splats = s.splat_count;
    if (b->level_count == 1) psplat_asset_bounds(s.asset, b->low, b->high);
    subject_close(&s);
}

static void set_option(bench *b, const char *option, const char *value) {
    double n = strtod(value, NULL);
    if (!strcmp(option, "--png"))
        b->png = value;
    else if (!(n > 0))
        fail(option, "needs a number");
    else if (!strcmp(option, "--items") && n <= 100000)
        b->items = (int)n;
    else if (!strcmp(option, "--size") && n <= 4096)
        b->size = (int)n;
    else if (!strcmp(option, "--frames") && n <= MAX_FRAMES)
        b->frames = (int)n;
    else if (!strcmp(option, "--pixels"))
        b->pixels = n;
    else if (!strcmp(option, "--reach") && n > 2)
        b->reach = n;
    else
        fail(option, "is not an option, or out of range");
}

int main(int argc, char **argv) {
    bench b = {.items = 1000, .size = 512, .frames = 9, .pixels = 1, .reach = 100};
    psplat_error error;
    int first = 1;
    for (; first + 1 < argc && !strncmp(argv[first], "--", 2); first += 2)
        set_option(&b, argv[first], argv[first + 1]);
    if (first >= argc || argc - first > MAX_LEVELS) fail("files", "from 1 to 16 are needed");
    check(psplat_host_create(PSPLAT_API_GL, 1, &b.host, &error), &error);
    const psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = b.host};
    check(psplat_renderer_create(&desc, &b.renderer, &error), &error);
    for (int i = first; i < argc; ++i) open_level(&b, argv[i]);
    make_field(&b);
    run(&b);
    for (int i = 0; i < b.level_count; ++i) psplat_model_destroy(b.renderer, b.levels[i].model);
    psplat_renderer_destroy(b.renderer);
    psplat_host_destroy(b.host);
    free(b.fixed);
    free(b.chosen);
    return 0;
}
