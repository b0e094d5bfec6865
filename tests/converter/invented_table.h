/* SPDX-License-Identifier: MIT
 *
 * invented_table.h - rows of a sweep that was never run, whose values are formulas, so that tests
 * know every answer.
 */
#ifndef PHONGSPLAT_TESTS_INVENTED_TABLE_H
#define PHONGSPLAT_TESTS_INVENTED_TABLE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"

static inline psplat_row splats_row(double tolerance, psplat_form form, psplat_mode mode) {
    const psplat_setting setting = {
        .competitor = PSPLAT_COMPETITOR_SPLATS, .tolerance = tolerance, .form = form, .mode = mode};
    return psplat_row_empty(&setting);
}

/* Returns a row with a size in bytes, a picture difference in % and a frame time in ms; NaN stands
 * for a value that was not measured. */
static inline psplat_row plain_row(double bytes, double difference, double ms) {
    psplat_row row = splats_row(1, PSPLAT_FORM_USUAL, PSPLAT_MODE_PHONG);
    row.values[PSPLAT_COLUMN_BYTES] = bytes;
    row.values[PSPLAT_COLUMN_DIFFERENCE] = difference;
    row.values[PSPLAT_COLUMN_CPU_MS] = ms;
    return row;
}

/* Fills in values such as those of a medium-sized model: a finer tolerance raises every value but
 * the errors. */
static inline void fill_row(psplat_row *row) {
    const psplat_setting *s = &row->setting;
    int is_splats = s->competitor == PSPLAT_COMPETITOR_SPLATS;
    double fineness = is_splats ? 1 / s->tolerance : 30 * s->ratio;
    double elements = is_splats ? 120 * pow(fineness, 0.8) : 3000 * fineness;
    if (s->form == PSPLAT_FORM_PLANAR) elements *= 2; /* as flat splats need, where curved do */
    /* Floats are a little more accurate. */
    double worse = s->form == PSPLAT_FORM_FLOAT ? 0.9 : 1;
    double *v = row->values;
    v[PSPLAT_COLUMN_ELEMENTS] = floor(elements);
    v[PSPLAT_COLUMN_BYTES] = floor(2000 + elements * (!is_splats                     ? 5
                                                      : s->form == PSPLAT_FORM_FLOAT ? 64
                                                                                     : 12));
    v[PSPLAT_COLUMN_CONVERT_S] = 0.1 + fineness / 7;
    v[PSPLAT_COLUMN_BROKEN] = 0;
    for (int i = PSPLAT_COLUMN_DISTANCE_MAX; i <= PSPLAT_COLUMN_TARGET_SAMPLES; ++i)
        v[i] = 0.37 / fineness / (1 + i);
    v[PSPLAT_COLUMN_DISTANCE_MAX] = 0.97 / fineness;
    v[PSPLAT_COLUMN_NORMAL_RMS] = 4 * worse * pow(fineness, -0.4);
    for (int i = PSPLAT_COLUMN_PSNR; i <= PSPLAT_COLUMN_COVERED; ++i) v[i] = 20 + i / 3.0;
    v[PSPLAT_COLUMN_OUTLINE] = 0.16 / fineness;
    v[PSPLAT_COLUMN_DIFFERENCE] = 1.2 * worse * (1 + 0.6 * (double)s->mode) * pow(fineness, -0.5);
    for (int i = PSPLAT_COLUMN_LOAD_MS; i <= PSPLAT_COLUMN_WALL_MS_Q3; ++i)
        v[i] = (6 - 1.5 * (double)s->mode) * pow(elements, 0.2);
    v[PSPLAT_COLUMN_CPU_MS_Q1] *= 0.9;
    v[PSPLAT_COLUMN_CPU_MS_Q3] *= 1.2;
}

/* Returns the table of a whole sweep in which every row is measured. */
static inline psplat_sweep_table make_table(int with_gltfpack) {
    psplat_sweep_table table = {.source = "models/<p&q>.obj", .graphics = "Somebody's GPU, 4.5"};
    psplat_sweep_options_complete(&table.options);
    if (with_gltfpack) strcpy(table.gltfpack, "gltfpack 1.3");
    if (psplat_sweep_table_plan(&table, NULL)) abort();
    for (size_t i = 0; i < table.count; ++i) {
        psplat_row *row = &table.rows[i];
        row->is_measured = 1;
        if (row->setting.competitor != PSPLAT_COMPETITOR_MESH)
            fill_row(row);
        else
            row->values[PSPLAT_COLUMN_CPU_MS] = 13.25;
    }
    return table;
}

#endif
