/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * frame_timing.h - how long frames take that are drawn in turn.
 */
#ifndef PHONGSPLAT_BENCHMARK_FRAME_TIMING_H
#define PHONGSPLAT_BENCHMARK_FRAME_TIMING_H

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

/* What is timed: draw draws one frame into the framebuffer that is bound. */
typedef struct psplat_timed_frame {
    psplat_result (*draw)(void *self, const psplat_view *view, psplat_error *error);
    void *self;
} psplat_timed_frame;

typedef struct psplat_quartiles {
    double median, low, high; /* NaN: not to be had */
} psplat_quartiles;

/* Milliseconds a frame, from an empty framebuffer until GL is done with it. */
typedef struct psplat_frame_times {
    int frames;           /* that were timed */
    psplat_quartiles cpu; /* of all threads of the process */
    psplat_quartiles wall;
    psplat_quartiles gpu; /* GL_TIME_ELAPSED; NaN in software */
} psplat_frame_times;

typedef struct psplat_timing_desc {
    psplat_host *host;
    const psplat_view *views; /* that take turns: a round draws the same one of all frames */
    size_t view_count;
    const psplat_timed_frame *timed;
    size_t count;
    int rounds; /* at most, after two that do not count */
    /* The standard error of medians, of the GPU's times or else of the CPU's, in parts of them,
     * that suffices: after a turn of all views in which each median reaches it, no more rounds
     * are drawn. 0: none does. */
    double precision;
    int (*progress)(void *user, double fraction); /* not 0: INTERRUPTED; may be NULL */
    void *user;
} psplat_timing_desc;

/* Fills times with desc->count times. Errors: MEMORY, GRAPHICS, INTERRUPTED, those of drawing. */
psplat_result psplat_timing_run(const psplat_timing_desc *desc, psplat_frame_times *times,
                                psplat_error *error);
/* Returns the quartiles of values, which it reorders; it interpolates between neighbours. */
psplat_quartiles psplat_timing_quartiles(double *values, size_t count);
/* Returns whether the standard error of the median of count values with these quartiles, as it is
 * of normally distributed ones, is at most `precision`, in parts of the median. */
int psplat_timing_is_precise(const psplat_quartiles *quartiles, size_t count, double precision);
double psplat_timing_clock(void); /* seconds of a monotonic clock */

#endif
