/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * row.c - the columns by name, and which of them is the cost of a frame.
 */
#include "table/row.h"

#include "table/setting.h"

#include <math.h>

const char *const psplat_row_value_names[] = {
#define NAME(constant, name) #name,
    PSPLAT_COLUMNS(NAME)
#undef NAME
};

psplat_row psplat_row_empty(const psplat_setting *setting) {
    psplat_row row = {.setting = *setting};
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i) row.values[i] = NAN;
    return row;
}

psplat_column psplat_rows_cost(const psplat_row *rows, size_t count) {
    size_t timed = 0;
    for (size_t i = 0; i < count; ++i) {
        if (isnan(rows[i].values[PSPLAT_COLUMN_CPU_MS])) continue;
        if (isnan(rows[i].values[PSPLAT_COLUMN_GPU_MS])) return PSPLAT_COLUMN_CPU_MS;
        ++timed;
    }
    return timed ? PSPLAT_COLUMN_GPU_MS : PSPLAT_COLUMN_CPU_MS;
}
