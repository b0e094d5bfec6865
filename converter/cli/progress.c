/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * progress.c - the progress line on the terminal, which is rewritten only when its text changes.
 */
#define _XOPEN_SOURCE 700

#include "cli/progress.h"

#include "pipeline/schedule.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The time left is shown after this many seconds and this fraction of the work. Chosen by hand, as
 * the next. */
static const double min_seconds = 2, min_done = 0.05;
/* The time over which estimates are averaged, since stages do not keep to their schedule. */
static const double smoothing_seconds = 3;

double psplat_progress_clock(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

psplat_progress psplat_progress_begin(int quiet) {
    return (psplat_progress){
        .enabled = !quiet && isatty(STDERR_FILENO), .start = psplat_progress_clock(), .left = -1};
}

/* Estimates the time left: the rest goes as fast as what is done. The estimate is averaged with the
 * previous one, minus the time that has passed since. */
static void estimate(psplat_progress *progress, double now) {
    double elapsed = now - progress->start, passed = now - progress->updated;
    if (elapsed < min_seconds || progress->done < min_done) return;
    double left = elapsed * (1 - progress->done) / progress->done;
    double weight = progress->left < 0 ? 1 : 1 - exp(-passed / smoothing_seconds);
    progress->left = fmax((1 - weight) * (progress->left - passed) + weight * left, 0);
}

/* Describes the time left, rounded up, and more coarsely where it is long. */
static void describe_left(const psplat_progress *progress, char text[48]) {
    double left = progress->left;
    text[0] = 0;
    if (left < 0) return;
    if (left > 90)
        snprintf(text, 48, ", about %.0f min left", ceil(left / 60));
    else if (left > 10)
        snprintf(text, 48, ", about %.0f s left", 5 * ceil(left / 5));
    else
        snprintf(text, 48, ", about %.0f s left", fmax(ceil(left), 1));
}

int psplat_progress_advance(psplat_progress *progress, double now, const char *what, double done) {
    char left[48], line[sizeof progress->shown];
    progress->done = fmax(progress->done, done);
    estimate(progress, now);
    progress->updated = now;
    describe_left(progress, left);
    snprintf(line, sizeof line, "%d %%, %.32s%s", (int)(100 * progress->done), what, left);
    int changed = strcmp(line, progress->shown) != 0;
    memcpy(progress->shown, line, sizeof line);
    return changed;
}

int psplat_progress_update(psplat_progress *progress, double now, const char *stage,
                           double fraction) {
    return psplat_progress_advance(progress, now, stage, psplat_schedule_done(stage, fraction));
}

int psplat_progress_show_done(void *user, const char *what, double done) {
    psplat_progress *progress = user;
    if (!progress->enabled) return 0;
    if (!psplat_progress_advance(progress, psplat_progress_clock(), what, done)) return 0;
    fprintf(stderr, "\r\033[K%s", progress->shown);
    fflush(stderr);
    return 0;
}

int psplat_progress_show(void *user, const char *stage, double fraction) {
    return psplat_progress_show_done(user, stage, psplat_schedule_done(stage, fraction));
}

void psplat_progress_end(psplat_progress *progress) {
    if (progress->enabled && *progress->shown) fputs("\r\033[K", stderr);
    *progress->shown = 0;
}
