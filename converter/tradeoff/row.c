/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * row.c - a setting and what was measured of it: the columns of the table.
 */
#include "tradeoff.h"

#include <math.h>

const char *const psplat_group_names[] = {"made", "shaped", "pictured", "timed", NULL};

static const struct {
    const char *name;
    psplat_group group;
} columns[] = {
#define COLUMN(name, column, group) {#column, PSPLAT_GROUP_##group},
    PSPLAT_COLUMNS(COLUMN)
#undef COLUMN
};

const char *psplat_column_name(psplat_column column) {
    return columns[column].name;
}

psplat_group psplat_column_group(psplat_column column) {
    return columns[column].group;
}

psplat_row psplat_row_empty(const psplat_setting *setting) {
    psplat_row row = {.setting = *setting};
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i) row.values[i] = NAN;
    return row;
}

void psplat_row_copy(psplat_row *to, const psplat_row *from, psplat_group group) {
    to->stamps[group] = from->stamps[group];
    if (group == PSPLAT_GROUP_MADE) to->content = from->content;
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i)
        if (columns[i].group == group) to->values[i] = from->values[i];
}

void psplat_row_forget(psplat_row *row, psplat_group group) {
    const psplat_row empty = psplat_row_empty(&row->setting);
    psplat_row_copy(row, &empty, group);
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
