/* SPDX-License-Identifier: MIT
 *
 * bench_quality.c - what splats look like beside the mesh that they were made from, and what they
 * cost beside it.
 *
 *     bench_quality [--size N] [--frames N] MESH FILE.glb...
 *
 * The files are the mesh converted at several tolerances, coarse ones first. The mesh is drawn with
 * the normals that the converter gives it, lit per pixel, from six directions, and so are the
 * splats in the modes phong, gaussian and flat (BSK04 figure 9). Errors are mean absolute
 * differences of the sRGB-encoded images in percent of white: of all pixels that either covers
 * (the other is black there), and, in parentheses, of those that both cover. CPU ms are medians of
 * frames in turn with the mesh's.
 *
 * Below: how many splats the other modes need for the error that phong has inside the outline,
 * interpolated between the files on logarithmic axes, and beyond the last one ("~") continued for
 * up to ten times its splats ("> " where even these are too few).
 */
#include "source_drawing.h"
#include "quality.h"
#include "interleaved_timing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_FILES = 64, MODES = 3 };

static const psplat_mode modes[MODES] = {PSPLAT_MODE_PHONG, PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_FLAT};

typedef struct settings {
    int size;
    size_t frames;
} settings;

typedef struct record {
    double splats[MAX_FILES], shading[MODES][MAX_FILES], covered;
    size_t count;
} record;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_quality: %s: %s\n", what, why);
    exit(2);
}

static void print_cost(psplat_host *host, const subject *s, const draw_method *splats,
                       const draw_method *mesh, const settings *set) {
    const double direction[3] = {0.3, 0.4, 1};
    psplat_view view = subject_view(s, direction, set->size, 1);
    draw_method both[2] = {*splats, *mesh};
    timing_result results[2];
    timing_run(host, &view, both, 2, set->frames, 2, results);
    printf(" %.1f | %.1f | %.2f |\n", results[0].frame.cpu, results[1].frame.cpu,
           results[0].frame.cpu / results[1].frame.cpu);
}

static void run_file(psplat_host *host, const char *path, const mesh *source,
                     const draw_method *mesh, const settings *set, record *r) {
    subject s = subject_open(path);
    memcpy(s.center, source->center, sizeof s.center); /* so that all files have the same views */
    s.radius = source->radius;
    draw_method splats = draw_method_splats(host, &s, 0);
    quality_reference reference = quality_draw_mesh(host, &s, mesh, set->size);
    printf("| %s | %zu |", s.name, s.splat_count);
    r->splats[r->count] = (double)s.splat_count;
    for (int i = 0; i < MODES; ++i) {
        quality q = quality_measure(host, &s, &splats, modes[i], &reference);
        printf(" %.2f (%.2f) |", q.image, q.shading);
        r->shading[i][r->count] = q.shading;
        r->covered = q.covered;
    }
    ++r->count;
    print_cost(host, &s, &splats, mesh, set);
    fflush(stdout);
    quality_free(&reference);
    draw_method_destroy(&splats);
    subject_close(&s);
}

/* Prints what quality_splats_for returned. */
static void print_needed(double needed, const record *r, size_t file) {
    double last = r->splats[r->count - 1], shown = needed < 0 ? -needed : needed;
    const char *mark = needed > 0 ? "" : shown > 10 * last ? "> " : "~ ";
    if (shown > 10 * last) shown = 10 * last;
    if (needed != 0)
        printf(" %s%.0f | %s%.1f |", mark, shown, mark, shown / r->splats[file]);
    else
        printf(" | |");
}

static void print_equal(const record *r) {
    printf("\n%.0f %% of the pixels are covered.\n\n| error | phong | gaussian | of phong | flat | "
           "of phong |\n"
           "|--:|--:|--:|--:|--:|--:|\n",
           r->covered);
    for (size_t k = 0; k < r->count; ++k) {
        double error = r->shading[0][k];
        printf("| %.2f | %.0f |", error, r->splats[k]);
        for (int i = 1; i < MODES; ++i)
            print_needed(quality_splats_for(error, r->splats, r->shading[i], r->count), r, k);
        printf("\n");
    }
}

static int parse(int argc, char **argv, settings *set) {
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        long value = strtol(argv[i + 1], NULL, 10);
        if (strcmp(argv[i], "--size") == 0 && value > 0 && value <= 8192)
            set->size = (int)value;
        else if (strcmp(argv[i], "--frames") == 0 && value > 0 && value <= TIMING_MAX_FRAMES)
            set->frames = (size_t)value;
        else
            fail(argv[i], "unknown, or its value out of range");
    }
    if (argc - i < 2 || argc - i - 1 > MAX_FILES)
        fail("usage", "bench_quality [--size N] [--frames N] MESH FILE.glb...");
    return i;
}

int main(int argc, char **argv) {
    static record r;
    settings set = {.size = 512, .frames = 15};
    int first = parse(argc, argv, &set);
    psplat_host *host = NULL;
    psplat_error error;
    if (psplat_host_create(PSPLAT_API_GL, 1, &host, &error)) fail("host", error.text);
    probe_open(host);
    mesh source;
    mesh_read(argv[first], &source);
    draw_method drawn = draw_method_mesh(host, &source);
    printf("%s, %zu triangles; %s\n\n", argv[first], source.source.triangle_count,
           psplat_host_renderer(host));
    printf("| file | splats | phong | gaussian | flat | phong CPU ms | mesh CPU ms | of mesh |\n"
           "|---|--:|--:|--:|--:|--:|--:|--:|\n");
    for (int i = first + 1; i < argc; ++i) run_file(host, argv[i], &source, &drawn, &set, &r);
    print_equal(&r);
    draw_method_destroy(&drawn);
    mesh_free(&source);
    probe_close();
    psplat_host_destroy(host);
    return 0;
}
