/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep.h - what a setting costs and what it buys, on the user's own model, in flow order:
 *
 *     options -> table of settings -> assets -> measurements -> table, charts, page
 *
 * A sweep converts one mesh by a ladder of tolerances and two kinds of normal fields, measures each
 * conversion (compare/shape_errors.h), draws it in each mode with and without filter, and times
 * them all in turn. What is measured is kept in a directory: tradeoff.csv, assets, charts, a page.
 * Nothing prints but the command line. Numbers are written and read in the C locale, which the
 * command line never leaves.
 */
#ifndef PHONGSPLAT_TRADEOFF_SWEEP_H
#define PHONGSPLAT_TRADEOFF_SWEEP_H

#include "table/sweep_options.h"
#include "table/sweep_table.h"

#include <phongsplat/splat.h>

/* Zeros are the defaults. */
typedef struct psplat_sweep_desc {
    const char *source; /* any file that psplat_mesh_read takes */
    const char *folder; /* see folder.h */
    psplat_sweep_options options;
    int fresh;            /* 1: forget what was measured before */
    int software;         /* 1: draw with Mesa's software rasteriser */
    const char *gltfpack; /* NULL: the one in PATH; "": none */
    int (*progress)(void *user, const char *what, double fraction); /* not 0: INTERRUPTED */
    void (*warn)(void *user, const char *text); /* what is left out, and why; may be NULL */
    void *user;
} psplat_sweep_desc;

/* Counts the settings that this run measured anew. */
typedef struct psplat_sweep_counts {
    size_t measured, timed;
} psplat_sweep_counts;

/* Measures what the folder's table does not have yet, and writes everything. The caller frees
 * *table. Errors name their subject: those of psplat_mesh_read, psplat_convert, folder.h,
 * sweep_table.h, and GRAPHICS, INTERRUPTED. */
psplat_result psplat_sweep_run(const psplat_sweep_desc *desc, psplat_sweep_table *table,
                               psplat_sweep_counts *counts, psplat_error *error);

#endif
