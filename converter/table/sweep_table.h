/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_table.h - the rows of a sweep, which are kept as tradeoff.csv.
 *
 * A line of the CSV is a key and the values of row.h. The key is all that decides what a row is:
 * the setting, the source and a hash of its content, the program and the command that make the
 * asset, what it is measured with, and the graphics that draw it. A sweep that is started again
 * takes over the rows whose keys it would write itself.
 */
#ifndef PHONGSPLAT_TABLE_SWEEP_TABLE_H
#define PHONGSPLAT_TABLE_SWEEP_TABLE_H

#include "table/row.h"
#include "table/sweep_options.h"
#include "table/text.h"

#include <phongsplat/splat.h>

typedef struct psplat_sweep_table {
    psplat_sweep_options options; /* complete */
    const char *source;           /* its path, of the caller */
    uint64_t source_hash;
    char graphics[512]; /* GL_RENDERER, GL_VERSION */
    char gltfpack[128]; /* its version; "": none */
    psplat_row *rows;
    size_t count;
} psplat_sweep_table;

/* Makes the rows of all settings from the fields before them, coarse to fine, the source first:
 * rows of one asset follow each other. Errors: MEMORY. */
psplat_result psplat_sweep_table_plan(psplat_sweep_table *table, psplat_error *error);
void psplat_sweep_table_free(psplat_sweep_table *table);
/* Removes count rows from first on. */
void psplat_sweep_table_remove(psplat_sweep_table *table, size_t first, size_t count);
/* Adds a line of names and a line for each row that is measured. Numbers are exact. */
void psplat_sweep_table_write(const psplat_sweep_table *table, psplat_text *text);
/* Fills the rows that the text has a line for; other lines are left out. The text need not be
 * terminated, and may be empty. Errors: FORMAT, its text naming line and cause. */
psplat_result psplat_sweep_table_recall(psplat_sweep_table *table, const char *text, size_t size,
                                        psplat_error *error);

#endif
