/* SPDX-License-Identifier: MIT
 *
 * table.h - what was measured, as a table for people (Markdown) or as comma-separated values.
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
    const race_result *result;
    double generated, blended; /* fragments a covered pixel; 0: not counted */
    double ratio;              /* CPU time of ours over its; 0: none */
} table_row;

void table_head(const options *o, psplat_host *host);
void table_print(const options *o, const table_row *row);

#endif
