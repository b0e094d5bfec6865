/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * frame_timing.c - frames in turn, round by round, so that what else the machine does falls on all
 * alike.
 */
#define _XOPEN_SOURCE 700

#include "benchmark/frame_timing.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* These rounds do not count: programs are compiled and textures uploaded in the first, and targets
 * are made anew where the second still differs from it. */
enum { WARM_UP = 2 };

/* GL 3.3 has GL_TIME_ELAPSED and what it takes. GLES has it as an extension under other names, and
 * is left out. */
enum { TIME_ELAPSED = 0x88BF, QUERY_RESULT = 0x8866 };
typedef struct gl {
    void (*Finish)(void);
    void (*GenQueries)(int count, unsigned *ids);
    void (*DeleteQueries)(int count, const unsigned *ids);
    void (*BeginQuery)(unsigned target, unsigned id);
    void (*EndQuery)(unsigned target);
    void (*GetQueryObjectui64v)(unsigned id, unsigned name, uint64_t *value);
    unsigned query; /* 0: no times of a GPU */
} gl;

static double seconds_of(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double psplat_timing_clock(void) {
    return seconds_of(CLOCK_MONOTONIC);
}

/* ---- quartiles ---------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double at_fraction(const double *sorted, size_t count, double fraction) {
    double position = fraction * (double)(count - 1);
    size_t below = (size_t)position;
    double beyond = position - (double)below;
    if (below + 1 >= count) return sorted[count - 1];
    return sorted[below] + beyond * (sorted[below + 1] - sorted[below]);
}

psplat_quartiles psplat_timing_quartiles(double *values, size_t count) {
    if (!count || isnan(values[0])) return (psplat_quartiles){NAN, NAN, NAN};
    qsort(values, count, sizeof *values, ascending);
    return (psplat_quartiles){at_fraction(values, count, 0.5), at_fraction(values, count, 0.25),
                              at_fraction(values, count, 0.75)};
}

int psplat_timing_is_precise(const psplat_quartiles *q, size_t count, double precision) {
    /* The standard error of the median of normally distributed values, in interquartile ranges of
     * them over the root of their number: sqrt(pi / 2) / 1.349. */
    static const double error_of_median = 0.929;
    return error_of_median * (q->high - q->low) / sqrt((double)count) <= precision * q->median;
}

/* ---- rounds ------------------------------------------------------------------------------- */

static int load(psplat_host *host, const char *name, void *function) {
    void *address = psplat_host_get_proc(host, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

static int is_software(psplat_host *host) {
    const char *name = psplat_host_renderer(host);
    return strstr(name, "llvmpipe") || strstr(name, "softpipe") || strstr(name, "Software");
}

static psplat_result load_gl(psplat_host *host, gl *functions, psplat_error *error) {
    *functions = (gl){.query = 0};
    if (!load(host, "glFinish", &functions->Finish))
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "there is no glFinish");
    int has_queries = load(host, "glGenQueries", &functions->GenQueries) &&
                      load(host, "glDeleteQueries", &functions->DeleteQueries) &&
                      load(host, "glBeginQuery", &functions->BeginQuery) &&
                      load(host, "glEndQuery", &functions->EndQuery) &&
                      load(host, "glGetQueryObjectui64v", &functions->GetQueryObjectui64v);
    int is_gles = strstr(psplat_host_version(host), "OpenGL ES") != NULL;
    if (has_queries && !is_gles && !is_software(host)) functions->GenQueries(1, &functions->query);
    return PSPLAT_OK;
}

typedef struct sample {
    double cpu, wall, gpu; /* milliseconds */
} sample;

static psplat_result draw_timed(const psplat_timing_desc *desc, const gl *functions,
                                const psplat_timed_frame *timed, const psplat_view *view,
                                sample *taken, psplat_error *error) {
    const float black[4] = {0, 0, 0, 0};
    psplat_result result =
        psplat_host_begin(desc->host, view->width, view->height, 0, black, error);
    if (result) return result;
    functions->Finish();
    double cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID), wall = seconds_of(CLOCK_MONOTONIC);
    uint64_t nanoseconds = 0;
    if (functions->query) functions->BeginQuery(TIME_ELAPSED, functions->query);
    result = timed->draw(timed->self, view, error);
    if (functions->query) functions->EndQuery(TIME_ELAPSED);
    functions->Finish();
    taken->cpu = 1e3 * (seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    taken->wall = 1e3 * (seconds_of(CLOCK_MONOTONIC) - wall);
    if (functions->query)
        functions->GetQueryObjectui64v(functions->query, QUERY_RESULT, &nanoseconds);
    taken->gpu = functions->query ? 1e-6 * (double)nanoseconds : NAN;
    return result;
}

/* Rounds that are drawn. The samples of what is timed as number i begin at i * desc->rounds, and
 * scratch has room for as many. */
typedef struct timing {
    const psplat_timing_desc *desc;
    gl functions;
    sample *samples;
    double *scratch;
    size_t drawn; /* rounds that count */
} timing;

/* Draws a round. Those that do not count write into the first samples, which are written again. */
static psplat_result draw_round(timing *t, size_t round, psplat_error *error) {
    const psplat_timing_desc *desc = t->desc;
    const psplat_view *view = &desc->views[round % desc->view_count];
    size_t frame = round < WARM_UP ? 0 : round - WARM_UP;
    for (size_t i = 0; i < desc->count; ++i) {
        psplat_result result = draw_timed(desc, &t->functions, &desc->timed[i], view,
                                          &t->samples[i * (size_t)desc->rounds + frame], error);
        if (result) return result;
    }
    t->drawn = round < WARM_UP ? 0 : frame + 1;
    return PSPLAT_OK;
}

static psplat_frame_times summarise(const timing *t, size_t index) {
    const sample *samples = t->samples + index * (size_t)t->desc->rounds;
    psplat_frame_times times = {.frames = (int)t->drawn};
    for (size_t i = 0; i < t->drawn; ++i) t->scratch[i] = samples[i].cpu;
    times.cpu = psplat_timing_quartiles(t->scratch, t->drawn);
    for (size_t i = 0; i < t->drawn; ++i) t->scratch[i] = samples[i].wall;
    times.wall = psplat_timing_quartiles(t->scratch, t->drawn);
    for (size_t i = 0; i < t->drawn; ++i) t->scratch[i] = samples[i].gpu;
    times.gpu = psplat_timing_quartiles(t->scratch, t->drawn);
    return times;
}

/* Returns whether all frames are known well enough. Only whole turns of the views are looked at, so
 * that all views count alike. */
static int is_enough(const timing *t) {
    const psplat_timing_desc *desc = t->desc;
    if (!(desc->precision > 0) || !t->drawn || t->drawn % desc->view_count) return 0;
    for (size_t i = 0; i < desc->count; ++i) {
        const psplat_frame_times times = summarise(t, i);
        const psplat_quartiles *cost = t->functions.query ? &times.gpu : &times.cpu;
        if (!psplat_timing_is_precise(cost, t->drawn, desc->precision)) return 0;
    }
    return 1;
}

static psplat_result run_rounds(timing *t, psplat_error *error) {
    const psplat_timing_desc *desc = t->desc;
    size_t rounds = WARM_UP + (size_t)desc->rounds;
    for (size_t round = 0; round < rounds && !is_enough(t); ++round) {
        psplat_result result = draw_round(t, round, error);
        if (result) return result;
        double done = (double)(round + 1) / (double)rounds;
        if (desc->progress && desc->progress(desc->user, done))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    }
    return PSPLAT_OK;
}

psplat_result psplat_timing_run(const psplat_timing_desc *desc, psplat_frame_times *times,
                                psplat_error *error) {
    size_t frames = (size_t)desc->rounds;
    timing t = {.desc = desc};
    psplat_result result = load_gl(desc->host, &t.functions, error);
    if (result) return result;
    t.samples = calloc(desc->count * frames + 1, sizeof *t.samples);
    t.scratch = malloc(frames * sizeof *t.scratch);
    if (!t.samples || !t.scratch)
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu frames",
                             desc->count * frames);
    if (!result) result = run_rounds(&t, error);
    for (size_t i = 0; i < desc->count && !result; ++i) times[i] = summarise(&t, i);
    if (t.functions.query) t.functions.DeleteQueries(1, &t.functions.query);
    free(t.samples);
    free(t.scratch);
    return result;
}
