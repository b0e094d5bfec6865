/* SPDX-License-Identifier: MIT
 *
 * table.h - measurements printed as a table for people (Markdown) or as comma-separated values.
 */
#ifndef PHONGSPLAT_BENCH_TABLE_H
#define PHONGSPLAT_BENCH_TABLE_H

#include "draw_options.h"
#include "interleaved_timing.h"

typedef struct table_row {
    const char *subject;
    size_t splats;
    int size;
    psplat_mode mode;
    const char *who;
    const timing_result *result;
    double generated, blended; /* fragments per covered pixel; 0: not counted */
    double ratio;              /* CPU time of ours divided by that of this method; 0: not known */
} table_row;

void table_head(const options *o, psplat_host *host);
void table_print(const options *o, const table_row *row);

#endif
