/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * charts.h - the charts of a sweep, by gnuplot.
 */
#ifndef PHONGSPLAT_TRADEOFF_CHARTS_H
#define PHONGSPLAT_TRADEOFF_CHARTS_H

#include "table/sweep_table.h"
#include "table/text.h"

#include <phongsplat/splat.h>

enum { PSPLAT_CHARTS = 5, PSPLAT_CHARTS_CAUSE = 160 };

extern const char *const psplat_chart_files[PSPLAT_CHARTS]; /* "error-bytes.svg" */

/* Adds the script that draws the charts from tradeoff.csv, to be run in the directory of both. */
void psplat_charts_script(const psplat_sweep_table *table, psplat_text *script);
/* Writes the script as charts.gp into the folder, which holds the table already, and runs gnuplot.
 * Where that cannot be run or fails, left_out says so, and no charts of an earlier sweep are left.
 * Errors: MEMORY, WRITE. */
psplat_result psplat_charts_write(const psplat_sweep_table *table, const char *folder,
                                  char left_out[PSPLAT_CHARTS_CAUSE], psplat_error *error);

#endif
