/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_table.c - rows as lines of CSV, and lines as rows.
 *
 *     kind,tolerance_percent,ratio,form,mode,source,source_hash,program,...
 *     splats,0.5,,usual,phong,"part.obj",0123456789abcdef,"phongsplat 0.1.0",...
 *
 * Only keys have cells with quotes. So the values of a line are read from its end, and its key is
 * compared as it stands.
 */
#include "table/sweep_table.h"

#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/text.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char key_names[] = "kind,tolerance_percent,ratio,form,mode,source,source_hash,program,"
                                "command,measured_with,graphics";

/* ---- keys --------------------------------------------------------------------------------- */

static void add_cell(psplat_text *key, const char *raw) {
    psplat_text_add(key, ",");
    psplat_text_enclosed(key, raw, '"');
}

static void add_positive(psplat_text *key, double number) {
    psplat_text_add(key, ",");
    if (number > 0) psplat_text_number(key, number);
}

static void add_program(psplat_text *key, const psplat_sweep_table *table,
                        const psplat_setting *s) {
    psplat_text program = {0}, command = {0};
    if (s->competitor == PSPLAT_COMPETITOR_SPLATS)
        psplat_text_add(&program, "phongsplat %d.%d.%d", PSPLAT_VERSION_MAJOR, PSPLAT_VERSION_MINOR,
                        PSPLAT_VERSION_PATCH);
    else if (s->competitor == PSPLAT_COMPETITOR_GLTFPACK)
        psplat_text_add(&program, "%s", table->gltfpack);
    if (s->competitor != PSPLAT_COMPETITOR_MESH)
        psplat_setting_command(s, &table->options, table->source, &command);
    add_cell(key, program.data ? program.data : "");
    add_cell(key, command.data ? command.data : "");
    key->failed |= program.failed | command.failed;
    free(program.data);
    free(command.data);
}

/* Creases are part of how a mesh is compared and drawn, too. */
static void add_measurement(psplat_text *key, const psplat_sweep_options *o) {
    psplat_text_add(key, ",samples %d size %d", o->samples, o->size);
    if (o->no_creases) psplat_text_add(key, " no creases");
    if (o->crease_angle > 0) {
        psplat_text_add(key, " crease angle ");
        psplat_text_number(key, o->crease_angle);
    }
}

static char *make_key(const psplat_sweep_table *table, const psplat_setting *s) {
    psplat_text key = {0};
    int is_splats = s->competitor == PSPLAT_COMPETITOR_SPLATS;
    psplat_text_add(&key, "%s", psplat_competitor_names[s->competitor]);
    add_positive(&key, s->tolerance);
    add_positive(&key, s->ratio);
    psplat_text_add(&key, ",%s,%s", is_splats ? psplat_form_names[s->form] : "",
                    is_splats ? psplat_mode_names[s->mode] : "");
    add_cell(&key, table->source);
    psplat_text_add(&key, ",%016llx", (unsigned long long)table->source_hash);
    add_program(&key, table, s);
    add_measurement(&key, &table->options);
    add_cell(&key, table->graphics);
    if (key.failed) free(key.data);
    return key.failed ? NULL : key.data;
}

/* ---- rows --------------------------------------------------------------------------------- */

static void add_row(psplat_sweep_table *table, const psplat_setting *setting) {
    psplat_row *row = &table->rows[table->count++];
    *row = psplat_row_empty(setting);
    row->key = make_key(table, setting);
}

/* What convert writes is drawn in each mode, and what users rarely take only as they would. */
static int modes_of(psplat_form form) {
    return form == PSPLAT_FORM_USUAL ? PSPLAT_DRAWN_MODES : 1;
}

static void add_asset(psplat_sweep_table *table, double tolerance, psplat_form form) {
    for (int mode = 0; mode < modes_of(form); ++mode)
        add_row(table, &(psplat_setting){.competitor = PSPLAT_COMPETITOR_SPLATS,
                                         .tolerance = tolerance,
                                         .form = form,
                                         .mode = (psplat_mode)mode});
}

psplat_result psplat_sweep_table_plan(psplat_sweep_table *table, psplat_error *error) {
    const psplat_ladder *tolerances = &table->options.tolerances, *ratios = &table->options.ratios;
    const size_t drawn = PSPLAT_DRAWN_MODES * PSPLAT_FORM_COUNT;
    int has_all = 1;
    table->count = 0;
    table->rows = malloc((1 + drawn * tolerances->count + ratios->count) * sizeof *table->rows);
    if (!table->rows) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for rows");
    add_row(table, &(psplat_setting){.competitor = PSPLAT_COMPETITOR_MESH});
    for (size_t i = 0; i < tolerances->count; ++i)
        for (int form = 0; form < PSPLAT_FORM_COUNT; ++form)
            add_asset(table, tolerances->steps[i], (psplat_form)form);
    for (size_t i = ratios->count; i-- && *table->gltfpack;)
        add_row(table, &(psplat_setting){.competitor = PSPLAT_COMPETITOR_GLTFPACK,
                                         .ratio = ratios->steps[i]});
    for (size_t i = 0; i < table->count; ++i) has_all &= table->rows[i].key != NULL;
    if (has_all) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for rows");
}

void psplat_sweep_table_free(psplat_sweep_table *table) {
    for (size_t i = 0; i < table->count; ++i) free(table->rows[i].key);
    free(table->rows);
    table->rows = NULL;
    table->count = 0;
}

void psplat_sweep_table_remove(psplat_sweep_table *table, size_t first, size_t count) {
    psplat_row *rows = table->rows + first;
    for (size_t i = 0; i < count; ++i) free(rows[i].key);
    memmove(rows, rows + count, (table->count - first - count) * sizeof *rows);
    table->count -= count;
}

/* ---- writing ------------------------------------------------------------------------------ */

static void write_names(psplat_text *text) {
    psplat_text_add(text, "%s", key_names);
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i)
        psplat_text_add(text, ",%s", psplat_row_value_names[i]);
    psplat_text_add(text, "\n");
}

void psplat_sweep_table_write(const psplat_sweep_table *table, psplat_text *text) {
    write_names(text);
    for (size_t i = 0; i < table->count; ++i) {
        const psplat_row *row = &table->rows[i];
        if (!row->is_measured) continue;
        psplat_text_add(text, "%s", row->key);
        for (int k = 0; k < PSPLAT_COLUMN_COUNT; ++k) {
            psplat_text_add(text, ",");
            psplat_text_number(text, row->values[k]);
        }
        psplat_text_add(text, "\n");
    }
}

/* ---- reading ------------------------------------------------------------------------------ */

/* Returns where the values of a line begin, or NULL where it has too few cells. */
static const char *find_values(const char *line, const char *end) {
    size_t commas = 0;
    for (const char *at = end; at > line; --at)
        if (at[-1] == ',' && ++commas == PSPLAT_COLUMN_COUNT) return at;
    return NULL;
}

static int read_value(const char *cell, size_t length, double *value) {
    char digits[40], *end = NULL;
    *value = NAN;
    if (!length) return 1;
    if (length >= sizeof digits) return 0;
    memcpy(digits, cell, length);
    digits[length] = 0;
    if (strspn(digits, "0123456789+-.einf") != length) return 0;
    *value = strtod(digits, &end);
    return end == digits + length && !isnan(*value);
}

static int read_values(const char *at, const char *end, double values[PSPLAT_COLUMN_COUNT]) {
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i) {
        const char *comma = memchr(at, ',', (size_t)(end - at));
        if (!comma) comma = end;
        if (!read_value(at, (size_t)(comma - at), &values[i])) return 0;
        at = comma + 1;
    }
    return 1;
}

static psplat_row *find_row(const psplat_sweep_table *table, const char *key, size_t length) {
    for (size_t i = 0; i < table->count; ++i) {
        psplat_row *row = &table->rows[i];
        if (strlen(row->key) == length && !memcmp(row->key, key, length)) return row;
    }
    return NULL;
}

/* Returns what is wrong with the line, or NULL. */
static const char *recall_line(psplat_sweep_table *table, const char *line, const char *end) {
    double values[PSPLAT_COLUMN_COUNT];
    const char *begin = find_values(line, end);
    if (!begin) return "there are too few cells";
    if (!read_values(begin, end, values)) return "a cell is not a number";
    psplat_row *row = find_row(table, line, (size_t)(begin - 1 - line));
    if (!row) return NULL;
    memcpy(row->values, values, sizeof values);
    row->is_measured = 1;
    return NULL;
}

static const char *check_names(const psplat_text *names, const char *line, const char *end) {
    size_t length = (size_t)(end - line);
    return length + 1 == names->size && !memcmp(names->data, line, length)
               ? NULL
               : "these are not the columns of a sweep";
}

psplat_result psplat_sweep_table_recall(psplat_sweep_table *table, const char *text, size_t size,
                                        psplat_error *error) {
    const char *const end = text + size, *cause = NULL;
    psplat_text names = {0};
    size_t number = 0;
    write_names(&names);
    psplat_result result = psplat_text_check(&names, error);
    for (const char *line = text; line < end && !cause && !result; ++number) {
        const char *line_end = memchr(line, '\n', (size_t)(end - line));
        if (!line_end)
            cause = "the line is cut off";
        else
            cause =
                number ? recall_line(table, line, line_end) : check_names(&names, line, line_end);
        if (line_end) line = line_end + 1;
    }
    free(names.data);
    if (cause) result = psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "line %zu: %s", number, cause);
    return result;
}
