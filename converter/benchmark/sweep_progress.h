/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_progress.h - the progress of a sweep: its current task, and the part of the work that is
 * done.
 */
#ifndef PHONGSPLAT_BENCHMARK_SWEEP_PROGRESS_H
#define PHONGSPLAT_BENCHMARK_SWEEP_PROGRESS_H

#include "table/setting.h"

#include <phongsplat/splat.h>

typedef enum psplat_task {
    PSPLAT_TASK_MAKE = 0, /* an asset */
    PSPLAT_TASK_SHAPE,
    PSPLAT_TASK_PICTURE,
    PSPLAT_TASK_TIME /* one setting */
} psplat_task;

/* Zero-initialised but for the first two. */
typedef struct psplat_sweep_progress {
    int (*report)(void *user, const char *what, double fraction); /* may be NULL */
    void *user;
    double planned, done, running; /* seconds, guessed */
    char what[64];
} psplat_sweep_progress;

/* Adds a task to what is planned. */
void psplat_sweep_progress_plan(psplat_sweep_progress *progress, psplat_task task,
                                const psplat_setting *setting);
/* Ends the task that is running and begins another; PSPLAT_TASK_TIME begins all timings at once.
 * Fails with INTERRUPTED if the callback of the progress does not return 0. */
psplat_result psplat_sweep_progress_begin(psplat_sweep_progress *progress, psplat_task task,
                                          const psplat_setting *setting, psplat_error *error);
/* Reports how much of the running task is done; for callbacks, where user is the
 * psplat_sweep_progress. Not 0 asks to stop. */
int psplat_sweep_progress_show(void *user, double fraction);
/* The same for psplat_convert_desc. */
int psplat_sweep_progress_show_stage(void *user, const char *stage, double fraction);

#endif
