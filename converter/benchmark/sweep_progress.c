/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_progress.c - tasks and the time that they may take.
 */
#include "benchmark/sweep_progress.h"

#include "pipeline/schedule.h"
#include "table/setting.h"
#include "table/text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Guesses how many seconds a task takes on a model of middle size. Conversions take longer the more
 * splats they place. */
static double guess(psplat_task task, const psplat_setting *setting) {
    if (task == PSPLAT_TASK_TIME) return 0.5;
    if (task != PSPLAT_TASK_MAKE) return 2;
    return setting->competitor == PSPLAT_COMPETITOR_SPLATS ? 2 + 1 / setting->tolerance : 0.7;
}

static const char *name_of(psplat_task task, int is_splats) {
    if (task == PSPLAT_TASK_MAKE) return is_splats ? "converting" : "simplifying";
    return task == PSPLAT_TASK_SHAPE ? "comparing shapes" : "comparing pictures";
}

/* Says what is done of which asset: "converting 0.5 %, planar". */
static void name_task(psplat_sweep_progress *progress, psplat_task task,
                      const psplat_setting *setting) {
    psplat_text asset = {0};
    psplat_setting_asset(setting, &asset);
    snprintf(progress->what, sizeof progress->what, "%s %s",
             name_of(task, setting->competitor == PSPLAT_COMPETITOR_SPLATS),
             asset.data ? asset.data : "");
    free(asset.data);
}

void psplat_sweep_progress_plan(psplat_sweep_progress *progress, psplat_task task,
                                const psplat_setting *setting) {
    progress->planned += guess(task, setting);
}

psplat_result psplat_sweep_progress_begin(psplat_sweep_progress *progress, psplat_task task,
                                          const psplat_setting *setting, psplat_error *error) {
    progress->done += progress->running;
    if (task == PSPLAT_TASK_TIME) {
        progress->running = progress->planned - progress->done;
        snprintf(progress->what, sizeof progress->what, "timing");
    } else {
        progress->running = guess(task, setting);
        name_task(progress, task, setting);
    }
    if (!psplat_sweep_progress_show(progress, 0)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
}

int psplat_sweep_progress_show(void *user, double fraction) {
    psplat_sweep_progress *p = user;
    double done = p->done + p->running * fraction;
    if (!p->report) return 0;
    return p->report(p->user, p->what, p->planned > 0 ? fmin(done / p->planned, 1) : 0);
}

int psplat_sweep_progress_show_stage(void *user, const char *stage, double fraction) {
    double done = psplat_schedule_done(stage, fraction);
    return done < 0 ? 0 : psplat_sweep_progress_show(user, done);
}
