/* SPDX-License-Identifier: MIT
 * Frames in turn; see interleaved_timing.h. */
#include "interleaved_timing.h"

#include <stdio.h>
#include <stdlib.h>

/* What all frames of a contestant took. */
typedef struct laps {
    double cpu[RACE_MAX_FRAMES], wall[RACE_MAX_FRAMES];
    struct {
        double cpu[RACE_MAX_FRAMES], wall[RACE_MAX_FRAMES], gpu[RACE_MAX_FRAMES];
    } passes[PROBE_PASS_COUNT];
} laps;

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench: %s\n", error->text);
    exit(1);
}

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory) return memory;
    fprintf(stderr, "bench: out of memory\n");
    exit(1);
}

probe_report race_frame(psplat_host *host, const psplat_view *view, const contestant *c,
                        unsigned options) {
    const float zeros[4] = {0};
    psplat_error error;
    check(psplat_host_begin(host, view->width, view->height, 0, zeros, &error), &error);
    probe_begin(c->options | options);
    c->draw(c->self, view);
    return probe_end();
}

static void run_lap(psplat_host *host, const psplat_view *view, const contestant *c, laps *l,
                    size_t lap) {
    instant start = measure_now();
    race_frame(host, view, c, 0);
    instant taken = measure_since(start);
    l->cpu[lap] = taken.cpu;
    l->wall[lap] = taken.wall;
    probe_report report = race_frame(host, view, c, PROBE_PASSES);
    for (int pass = 0; pass < PROBE_PASS_COUNT; ++pass) {
        l->passes[pass].cpu[lap] = report.passes[pass].cpu;
        l->passes[pass].wall[lap] = report.passes[pass].wall;
        l->passes[pass].gpu[lap] = report.gpu[pass];
    }
}

static race_result summarise(laps *l, size_t frames) {
    race_result result = {
        .frame = {measure_median(l->cpu, frames), measure_median(l->wall, frames)}};
    for (int pass = 0; pass < PROBE_PASS_COUNT; ++pass) {
        result.passes[pass].cpu = measure_median(l->passes[pass].cpu, frames);
        result.passes[pass].wall = measure_median(l->passes[pass].wall, frames);
        result.gpu[pass] = measure_median(l->passes[pass].gpu, frames);
    }
    return result;
}

void race_run(psplat_host *host, const psplat_view *view, const contestant *contestants,
              size_t count, size_t frames, size_t warm_up, race_result *results) {
    laps *all = allocate(count, sizeof *all);
    for (size_t lap = 0; lap < warm_up + frames; ++lap)
        for (size_t i = 0; i < count; ++i)
            run_lap(host, view, &contestants[i], &all[i], lap < warm_up ? 0 : lap - warm_up);
    for (size_t i = 0; i < count; ++i) results[i] = summarise(&all[i], frames);
    free(all);
}

double race_covered(psplat_host *host, const psplat_view *view) {
    size_t pixels = (size_t)view->width * (size_t)view->height, covered = 0;
    uint8_t *rgba = allocate(pixels, 4);
    psplat_error error;
    check(psplat_host_read_rgba8(host, rgba, &error), &error);
    for (size_t i = 0; i < pixels; ++i) covered += rgba[4 * i + 3] > 0;
    free(rgba);
    return (double)covered;
}
