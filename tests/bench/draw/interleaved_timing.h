/* SPDX-License-Identifier: MIT
 *
 * interleaved_timing.h - interleaved timing of draw methods: their frames are drawn in turn, so
 * that whatever else the machine does slows all of them alike. The results are medians.
 */
#ifndef PHONGSPLAT_BENCH_INTERLEAVED_TIMING_H
#define PHONGSPLAT_BENCH_INTERLEAVED_TIMING_H

#include "draw_method.h"
#include "probe.h"

enum { TIMING_MAX_FRAMES = 1000, TIMING_MAX_METHODS = 8 };

/* Times in milliseconds. A frame starts with clearing the host's framebuffer and ends when all is
 * drawn. Passes are timed in frames of their own, since finishing each of them takes time. */
typedef struct timing_result {
    instant frame;
    instant passes[PROBE_PASS_COUNT];
    double gpu[PROBE_PASS_COUNT];
} timing_result;

/* Times 1 to TIMING_MAX_FRAMES frames of each kind, after warm_up others. */
void timing_run(psplat_host *host, const psplat_view *view, const draw_method *methods,
                size_t count, size_t frames, size_t warm_up, timing_result *results);

/* Draws one frame and returns what the probe measured. */
probe_report timing_frame(psplat_host *host, const psplat_view *view, const draw_method *method,
                          unsigned options);

/* Returns the number of pixels of the last frame that differ from the cleared ones. */
double timing_covered(psplat_host *host, const psplat_view *view);

#endif
