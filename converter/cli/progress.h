/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * progress.h - the progress line on the terminal.
 */
#ifndef PHONGSPLAT_CLI_PROGRESS_H
#define PHONGSPLAT_CLI_PROGRESS_H

/* A line on standard error that shows how much is done, the stage, and the time left. It is shown
 * only if standard error is a terminal. */
typedef struct psplat_progress {
    int enabled;
    double start, updated; /* seconds of a monotonic clock */
    double done;           /* 0 ... 1, never falling */
    double left;           /* seconds, smoothed; negative until it is known */
    char shown[96];
} psplat_progress;

/* Returns the seconds of a monotonic clock. */
double psplat_progress_clock(void);

/* Begins a line, which is never shown if quiet is set. */
psplat_progress psplat_progress_begin(int quiet);

/* Stores in progress->shown what the line says at time `now` of the clock. Returns 1 where that has
 * changed. */
int psplat_progress_update(psplat_progress *progress, double now, const char *stage,
                           double fraction);

/* Shows the progress of a conversion: it is the callback of psplat_convert_desc, and user is the
 * psplat_progress. It always returns 0 and so never asks to stop, since a signal ends the process
 * (main.c). */
int psplat_progress_show(void *user, const char *stage, double fraction);

/* These do the same for other work; done is the fraction of it that is done. */
int psplat_progress_advance(psplat_progress *progress, double now, const char *what, double done);

int psplat_progress_show_done(void *user, const char *what, double done);

/* Clears the line. */
void psplat_progress_end(psplat_progress *progress);

#endif
