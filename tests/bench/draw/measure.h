/* SPDX-License-Identifier: MIT
 *
 * measure.h - clocks and medians.
 */
#ifndef PHONGSPLAT_BENCH_MEASURE_H
#define PHONGSPLAT_BENCH_MEASURE_H

#include <stddef.h>

/* Milliseconds since an arbitrary moment: cpu is the processor time of all threads of this process,
 * wall the time of the wall clock. Software GL draws with as many threads as there are cores, so
 * that the first says what a frame costs and the second how long it takes on an idle machine. */
typedef struct instant {
    double cpu, wall;
} instant;

instant measure_now(void);
instant measure_since(instant start);
void measure_add(instant *sum, instant more);

/* Returns the median and reorders the values. Returns 0 where there are none. */
double measure_median(double *values, size_t count);

#endif
