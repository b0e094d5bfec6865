/* SPDX-License-Identifier: MIT
 *
 * bench_tile_selection.c - measures psplat_tiles_select: microseconds of a frame for trees of more
 * and more tiles, all of which are in memory. The camera flies over a square that each level of
 * tiles splits into four. Nothing is drawn.
 *
 *     bench_tile_selection [MOST]
 *
 * MOST is the greatest number of tiles (default 100,000).
 */
#include "tileset/tree.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES = 400 };

typedef struct text {
    char *data;
    size_t size, capacity;
} text;

static void put(text *t, const char *words) {
    size_t length = strlen(words);
    if (t->size + length + 1 > t->capacity) {
        t->capacity = 2 * (t->capacity + length) + 4096;
        t->data = realloc(t->data, t->capacity);
        if (!t->data) exit(1);
    }
    memcpy(t->data + t->size, words, length + 1);
    t->size += length;
}

/* Appends a square tile and those below it. */
static void put_tile(text *t, double x, double y, double half, int deep) {
    char words[320];
    snprintf(words, sizeof words,
             "{\"boundingVolume\":{\"box\":[%.9g,%.9g,0,%.9g,0,0,0,%.9g,0,0,0,%.9g]},"
             "\"geometricError\":%.9g,\"refine\":\"REPLACE\",\"content\":{\"uri\":\"a.glb\"}",
             x, y, half, half, 0.1 * half, 0.02 * half);
    put(t, words);
    for (int i = 0; i < 4 && deep; ++i) {
        put(t, i ? "," : ",\"children\":[");
        put_tile(t, x + (i & 1 ? 0.5 : -0.5) * half, y + (i & 2 ? 0.5 : -0.5) * half, 0.5 * half,
                 deep - 1);
    }
    put(t, deep ? "]}" : "}");
}

static psplat_result read_text(void *user, const char *path, uint64_t offset, void *data,
                               size_t size, size_t *got, psplat_error *error) {
    const text *t = user;
    size_t rest = t->size - (size_t)offset;
    (void)path;
    (void)error;
    *got = size < rest ? size : rest;
    memcpy(data, t->data + offset, *got);
    return PSPLAT_OK;
}

/* Says that all tiles are on the GPU, with 700 splats each. */
static void pretend(psplat_tiles *tiles) {
    for (uint32_t i = 0; i < tiles->node_count; ++i) {
        tiles->nodes[i].splats = 700;
        tiles->uses[i].uploaded = 1;
        tiles->uses[i].sides = PSPLAT_SIDES_SINGLE;
        tiles->loads[i].progress = PSPLAT_TILE_UPLOADED;
        tiles->loads[i].bytes = 40000;
        tiles->loads[i].splats = 700;
        psplat_tile_enlist(tiles, i);
    }
}

static void look(psplat_view *view, int frame) {
    double x = -0.9 + 1.8 * frame / FRAMES, angle = 0.4; /* radians below the horizon */
    const double rotation[16] = {0, sin(angle), -cos(angle), 0, 0, cos(angle), sin(angle), 0,
                                 1, 0,          0,           0, 0, 0,          0,          1};
    memset(view, 0, sizeof *view);
    view->width = 1920;
    view->height = 1080;
    for (int i = 0; i < 16; ++i) view->view[i] = rotation[i];
    for (int i = 0; i < 3; ++i) view->view[12 + i] = -(rotation[i] * x + rotation[4 + i] * 0.15);
    view->projection[0] = 1080.0 / 1920 / 0.5;
    view->projection[5] = 1 / 0.5;
    view->projection[10] = view->projection[11] = -1;
    view->projection[14] = -0.002;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(psplat_tiles *tiles, double pixels) {
    static double times[FRAMES];
    size_t drawn = 0, wanted = 0;
    for (int frame = -FRAMES; frame < FRAMES; ++frame) {
        psplat_view view;
        look(&view, frame < 0 ? frame + FRAMES : frame);
        const psplat_tiles_view v = {.view = &view, .pixels = pixels};
        double start = now();
        if (psplat_tiles_select(tiles, &v, NULL)) exit(1);
        if (frame < 0) continue;
        times[frame] = now() - start;
        drawn += psplat_tiles_describe(tiles).drawn;
        wanted += psplat_tiles_describe(tiles).wanted;
    }
    qsort(times, FRAMES, sizeof *times, compare);
    printf("| %zu | %g | %.0f | %.0f | %.0f |%s\n", tiles->node_count, pixels,
           (double)drawn / FRAMES, 1e6 * times[FRAMES / 2], 1e6 * times[FRAMES - 1],
           wanted ? " not all in memory" : "");
}

int main(int argc, char **argv) {
    double most = argc > 1 ? atof(argv[1]) : 100000;
    printf("| tiles | pixels | drawn | median us | greatest us |\n|--:|--:|--:|--:|--:|\n");
    for (int deep = 2; deep < 10; ++deep) {
        psplat_tiles *tiles = NULL;
        psplat_error error;
        text t = {0};
        put(&t, "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":");
        put_tile(&t, 0, 0, 1, deep);
        put(&t, "}");
        const psplat_tiles_desc desc = {.source = {.read = read_text, .user = &t},
                                        .max_bytes = (size_t)1 << 40};
        double start = now();
        if (psplat_tiles_open(&desc, "tileset.json", &tiles, &error)) {
            fprintf(stderr, "bench_tile_selection: %s\n", error.text);
            return 1;
        }
        double opened = now() - start;
        if ((double)tiles->node_count <= most) {
            pretend(tiles);
            measure(tiles, 1);
            measure(tiles, 4);
            fprintf(stderr, "%zu tiles opened in %.1f ms, %.0f bytes of JSON each\n",
                    tiles->node_count, 1e3 * opened, (double)t.size / (double)tiles->node_count);
        }
        double count = (double)tiles->node_count;
        psplat_tiles_destroy(tiles, NULL);
        free(t.data);
        if (4 * count > most * 1.4) break;
    }
    return 0;
}
