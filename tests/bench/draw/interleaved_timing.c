/* SPDX-License-Identifier: MIT
 *
 * interleaved_timing.c - times frames of several draw methods in turn; see interleaved_timing.h.
 */
#include "interleaved_timing.h"

#include <stdio.h>
#include <stdlib.h>

/* The times of all frames of a draw method, in milliseconds. */
typedef struct frame_times {
    double cpu[TIMING_MAX_FRAMES], wall[TIMING_MAX_FRAMES];
    struct {
        double cpu[TIMING_MAX_FRAMES], wall[TIMING_MAX_FRAMES], gpu[TIMING_MAX_FRAMES];
    } passes[PROBE_PASS_COUNT];
} frame_times;

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

probe_report timing_frame(psplat_host *host, const psplat_view *view, const draw_method *method,
                          unsigned options) {
    const float zeros[4] = {0};
    psplat_error error;
    check(psplat_host_begin(host, view->width, view->height, 0, zeros, &error), &error);
    probe_begin(method->options | options);
    method->draw(method->self, view);
    return probe_end();
}

static void time_round(psplat_host *host, const psplat_view *view, const draw_method *method,
                       frame_times *l, size_t round) {
    instant start = measure_now();
    timing_frame(host, view, method, 0);
    instant taken = measure_since(start);
    l->cpu[round] = taken.cpu;
    l->wall[round] = taken.wall;
    probe_report report = timing_frame(host, view, method, PROBE_PASSES);
    for (int pass = 0; pass < PROBE_PASS_COUNT; ++pass) {
        l->passes[pass].cpu[round] = report.passes[pass].cpu;
        l->passes[pass].wall[round] = report.passes[pass].wall;
        l->passes[pass].gpu[round] = report.gpu[pass];
    }
}

static timing_result summarise(frame_times *l, size_t frames) {
    timing_result result = {
        .frame = {measure_median(l->cpu, frames), measure_median(l->wall, frames)}};
    for (int pass = 0; pass < PROBE_PASS_COUNT; ++pass) {
        result.passes[pass].cpu = measure_median(l->passes[pass].cpu, frames);
        result.passes[pass].wall = measure_median(l->passes[pass].wall, frames);
        result.gpu[pass] = measure_median(l->passes[pass].gpu, frames);
    }
    return result;
}

void timing_run(psplat_host *host, const psplat_view *view, const draw_method *methods,
                size_t count, size_t frames, size_t warm_up, timing_result *results) {
    frame_times *all = allocate(count, sizeof *all);
    for (size_t round = 0; round < warm_up + frames; ++round)
        for (size_t i = 0; i < count; ++i)
            time_round(host, view, &methods[i], &all[i], round < warm_up ? 0 : round - warm_up);
    for (size_t i = 0; i < count; ++i) results[i] = summarise(&all[i], frames);
    free(all);
}

double timing_covered(psplat_host *host, const psplat_view *view) {
    size_t pixels = (size_t)view->width * (size_t)view->height, covered = 0;
    uint8_t *rgba = allocate(pixels, 4);
    psplat_error error;
    check(psplat_host_read_rgba8(host, rgba, &error), &error);
    for (size_t i = 0; i < pixels; ++i) covered += rgba[4 * i + 3] > 0;
    free(rgba);
    return (double)covered;
}
