/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * task.c - what a sweep is at, and how far.
 */
#include "sweep.h"

#include <stdio.h>

int psplat_task_show(void *user, double fraction) {
    psplat_sweep *s = user;
    if (!s->desc->progress) return 0;
    double done = psplat_estimate_done(&s->estimate, s->task, s->share * fraction);
    return s->desc->progress(s->desc->user, s->what, done);
}

int psplat_task_show_conversion(void *user, const char *stage, double fraction) {
    double done = psplat_schedule_done(stage, fraction);
    return done < 0 ? 0 : psplat_task_show(user, done);
}

psplat_result psplat_task_begin(psplat_sweep *s, psplat_task task, double share, const char *what,
                                const psplat_row *row, psplat_error *error) {
    s->task = task;
    s->share = share;
    s->started = psplat_timing_clock();
    snprintf(s->what, sizeof s->what, "%s", what);
    if (row) {
        int is_splats = row->setting.contender == PSPLAT_CONTENDER_SPLATS;
        snprintf(s->what, sizeof s->what, is_splats ? "%s, %g %%" : "%s, %g", what,
                 is_splats ? row->setting.tolerance : row->setting.ratio);
    }
    if (!psplat_task_show(s, 0)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
}

void psplat_task_end(psplat_sweep *s) {
    s->estimate.done[s->task] += s->share;
    s->estimate.seconds[s->task] += psplat_timing_clock() - s->started;
}
