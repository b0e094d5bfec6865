/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * progress.c - one line on the terminal, rewritten only when what it says changes.
 */
#define _XOPEN_SOURCE 700

#include "command.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Before this many seconds and this much of the work nothing is said about what is left. */
static const double least_seconds = 2, least_done = 0.05;
/* Seconds over which estimates are averaged: stages are not as even as their schedule. */
static const double smoothing = 3;

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

psplat_progress psplat_progress_begin(int quiet) {
    return (psplat_progress){
        .enabled = !quiet && isatty(STDERR_FILENO), .start = seconds_now(), .left = -1};
}

/* If the rest goes as what is done went; averaged with what was said before, less the time since.
 */
static void estimate(psplat_progress *progress, double now) {
    double elapsed = now - progress->start, passed = now - progress->updated;
    if (elapsed < least_seconds || progress->done < least_done) return;
    double left = elapsed * (1 - progress->done) / progress->done;
    double weight = progress->left < 0 ? 1 : 1 - exp(-passed / smoothing);
    progress->left = fmax((1 - weight) * (progress->left - passed) + weight * left, 0);
}

/* Rounded up, coarser where there is more of it. */
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
    if (!psplat_progress_advance(progress, seconds_now(), what, done)) return 0;
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
