/* SPDX-License-Identifier: MIT
 *
 * measure.c - clocks and medians; see measure.h.
 */
#include "measure.h"

#include <stdlib.h>
#include <time.h>

static double milliseconds(clockid_t id) {
    struct timespec t;
    clock_gettime(id, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

instant measure_now(void) {
    return (instant){milliseconds(CLOCK_PROCESS_CPUTIME_ID), milliseconds(CLOCK_MONOTONIC)};
}

instant measure_since(instant start) {
    instant now = measure_now();
    return (instant){now.cpu - start.cpu, now.wall - start.wall};
}

void measure_add(instant *sum, instant more) {
    sum->cpu += more.cpu;
    sum->wall += more.wall;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

double measure_median(double *values, size_t count) {
    if (!count) return 0;
    qsort(values, count, sizeof *values, compare);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}
