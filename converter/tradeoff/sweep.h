/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep.h - what the files of a sweep share: sweep.c runs it, task.c says how far it is, make.c
 * makes assets.
 */
#ifndef PHONGSPLAT_SWEEP_H
#define PHONGSPLAT_SWEEP_H

#include "tradeoff.h"

typedef struct psplat_sweep {
    const psplat_sweep_desc *desc;
    psplat_journal *journal;
    psplat_sweep_counts *counts;
    psplat_folder folder;
    psplat_workbench bench;
    psplat_gltfpack gltfpack;
    psplat_estimate estimate;
    psplat_task task; /* that is running */
    double share, started;
    char what[64];
} psplat_sweep;

/* ---- task.c: how far it is --------------------------------------------------------------------
 */

/* Begins a task and tells of it; row, which may be NULL, is what it works on. INTERRUPTED. */
psplat_result psplat_task_begin(psplat_sweep *sweep, psplat_task task, double share,
                                const char *what, const psplat_row *row, psplat_error *error);
/* Tells how much of it is done; for callbacks, where user is the psplat_sweep. */
int psplat_task_show(void *user, double fraction);
/* For psplat_convert_desc. */
int psplat_task_show_conversion(void *user, const char *stage, double fraction);
void psplat_task_end(psplat_sweep *sweep);

/* ---- make.c: assets ---------------------------------------------------------------------------
 */

/* Converts or simplifies, and fills the values of PSPLAT_GROUP_MADE. Errors other than MEMORY,
 * WRITE, and INTERRUPTED are the setting's own. */
psplat_result psplat_make_asset(psplat_sweep *sweep, psplat_row *row, psplat_error *error);
/* Which task that is, and its share. */
psplat_task psplat_make_task(const psplat_setting *setting);
double psplat_make_share(const psplat_setting *setting);
/* Stamp of what was made: of gltfpack's two files both. 0: not there. *bytes of the first. */
uint64_t psplat_make_stamp(const psplat_sweep *sweep, const psplat_setting *setting, size_t *bytes);
void psplat_make_remove(const psplat_sweep *sweep, const psplat_setting *setting);
/* Writes a text into the folder and frees it. */
psplat_result psplat_make_text(const psplat_sweep *sweep, const char *name, psplat_text *text,
                               psplat_error *error);

#endif
