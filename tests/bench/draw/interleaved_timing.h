/* SPDX-License-Identifier: MIT
 *
 * interleaved_timing.h - frames of several contestants in turn, so that what else the machine does
 * falls on all alike, and the medians of what they took.
 */
#ifndef PHONGSPLAT_BENCH_RACE_H
#define PHONGSPLAT_BENCH_RACE_H

#include "draw_method.h"
#include "probe.h"

enum { RACE_MAX_FRAMES = 1000, RACE_MAX_CONTESTANTS = 8 };

/* Milliseconds. A frame starts with clearing the host's framebuffer and ends when all is drawn.
 * Passes are of frames of their own, since finishing each takes time. */
typedef struct race_result {
    instant frame;
    instant passes[PROBE_PASS_COUNT];
    double gpu[PROBE_PASS_COUNT];
} race_result;

/* frames 1 ... RACE_MAX_FRAMES of each kind, after warm_up others. */
void race_run(psplat_host *host, const psplat_view *view, const contestant *contestants,
              size_t count, size_t frames, size_t warm_up, race_result *results);

/* Draws one frame; returns what the probe saw. */
probe_report race_frame(psplat_host *host, const psplat_view *view, const contestant *c,
                        unsigned options);

/* Pixels of the last frame that are not as they were cleared. */
double race_covered(psplat_host *host, const psplat_view *view);

#endif
