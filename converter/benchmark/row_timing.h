/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * row_timing.h - all rows of a table timed together.
 */
#ifndef PHONGSPLAT_BENCHMARK_ROW_TIMING_H
#define PHONGSPLAT_BENCHMARK_ROW_TIMING_H

#include "benchmark/sweep_context.h"
#include "table/sweep_table.h"

#include <phongsplat/splat.h>

/* Returns whether all rows were timed already: in as many frames as the options ask for, or in
 * whole turns of the views that leave a standard error of no more than 5 %. */
int psplat_row_timing_is_done(const psplat_sweep_table *table);
/* Draws what each row stands for in turn, opens every asset of the folder in turn, and fills the
 * values from PSPLAT_COLUMN_FRAMES on. progress as in psplat_timing_desc. */
psplat_result psplat_row_timing_run(psplat_sweep_table *table, psplat_sweep_context *context,
                                    const char *folder,
                                    int (*progress)(void *user, double fraction), void *user,
                                    psplat_error *error);

#endif
