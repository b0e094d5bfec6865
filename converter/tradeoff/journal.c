/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * journal.c - rows as CSV, exactly, and back, without believing anything.
 *
 *     # phongsplat tradeoff 1
 *     # source part.obj
 *     # graphics llvmpipe, 4.5 (Core Profile) Mesa 22.3.6
 *     # gltfpack gltfpack 1.3
 *     # options tolerances=2,1,0.5 ...
 *     # check 0123456789abcdef
 *     contender,tolerance_percent,ratio,normals,precision,mode,filter,bytes,...,check
 *     splats,0.5,,linear,float,phong,on,28584,...,0123456789abcdef
 */
#include "tradeoff.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char title[] = "phongsplat tradeoff 1";

/* Columns before the values, after them the stamps, the content and the check. */
enum {
    SETTING_CELLS = 7,
    VALUE_CELLS = SETTING_CELLS + PSPLAT_COLUMN_COUNT,
    CONTENT_CELL = VALUE_CELLS + PSPLAT_GROUP_COUNT,
    CELLS = CONTENT_CELL + 2
};

void psplat_journal_free(psplat_journal *journal) {
    free(journal->rows);
    journal->rows = NULL;
    journal->count = 0;
}

/* ---- writing ------------------------------------------------------------------------------ */

static void write_names(psplat_text *text) {
    psplat_text_add(text, "contender,tolerance_percent,ratio,normals,precision,mode,filter");
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i)
        psplat_text_add(text, ",%s", psplat_column_name((psplat_column)i));
    for (int i = 0; i < PSPLAT_GROUP_COUNT; ++i)
        psplat_text_add(text, ",%s", psplat_group_names[i]);
    psplat_text_add(text, ",content,check");
}

static void write_positive(double number, psplat_text *text) {
    if (number > 0) psplat_text_number(text, number);
    psplat_text_add(text, ",");
}

static void write_setting(const psplat_setting *s, psplat_text *text) {
    int is_splats = s->contender == PSPLAT_CONTENDER_SPLATS;
    psplat_text_add(text, "%s,", psplat_contender_names[s->contender]);
    write_positive(s->tolerance, text);
    write_positive(s->ratio, text);
    psplat_text_add(text, "%s,%s,%s,%s", is_splats ? psplat_field_names[s->field] : "",
                    is_splats ? psplat_precision_names[s->precision] : "",
                    is_splats ? psplat_mode_names[s->mode] : "",
                    is_splats ? psplat_filter_names[s->no_filter] : "");
}

static void write_stamp(uint64_t stamp, psplat_text *text) {
    psplat_text_add(text, ",");
    if (stamp) psplat_text_add(text, "%016llx", (unsigned long long)stamp);
}

/* The line so far, from begin on, is what is checked. */
static uint64_t check_of(const psplat_text *text, size_t begin) {
    if (text->failed) return 1;
    return psplat_stamp_bytes(PSPLAT_STAMP, text->data + begin, text->size - begin);
}

static void write_row(const psplat_row *row, psplat_text *text) {
    size_t begin = text->size;
    write_setting(&row->setting, text);
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i) {
        psplat_text_add(text, ",");
        psplat_text_number(text, row->values[i]);
    }
    for (int i = 0; i < PSPLAT_GROUP_COUNT; ++i) write_stamp(row->stamps[i], text);
    write_stamp(row->content, text);
    write_stamp(check_of(text, begin), text);
    psplat_text_add(text, "\n");
}

static void write_comment(const char *name, const char *value, psplat_text *text) {
    psplat_text_add(text, "# %s", name);
    if (*value) psplat_text_add(text, " ");
    for (; *value; ++value)
        psplat_text_add(text, "%c", (unsigned char)*value < 0x20 || *value == 0x7f ? '?' : *value);
    psplat_text_add(text, "\n");
}

void psplat_journal_write(const psplat_journal *journal, psplat_text *text) {
    size_t begin = text->size;
    write_comment(title, "", text);
    write_comment("source", journal->source, text);
    write_comment("graphics", journal->graphics, text);
    write_comment("gltfpack", journal->gltfpack, text);
    psplat_text_add(text, "# ");
    psplat_tradeoff_options_write(&journal->options, text);
    psplat_text_add(text, "\n");
    psplat_text_add(text, "# check %016llx\n", (unsigned long long)check_of(text, begin));
    write_names(text);
    psplat_text_add(text, "\n");
    for (size_t i = 0; i < journal->count; ++i) write_row(&journal->rows[i], text);
}

/* ---- reading ------------------------------------------------------------------------------ */

typedef struct reader {
    const char *at, *end;
    size_t number; /* of the current line, from 1 */
    char *line;    /* a copy of it without its end, from malloc */
    psplat_error *error;
} reader;

static psplat_result refuse(const reader *r, const char *cause) {
    return psplat_fail(r->error, PSPLAT_ERROR_FORMAT, 0, "line %zu: %s", r->number, cause);
}

static psplat_result next_line(reader *r) {
    const char *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
    ++r->number;
    if (!end) return refuse(r, "the line is cut off");
    size_t length = (size_t)(end - r->at);
    if (memchr(r->at, 0, length)) return refuse(r, "a byte is 0");
    free(r->line);
    r->line = malloc(length + 1);
    if (!r->line) return psplat_fail(r->error, PSPLAT_ERROR_MEMORY, 0, "no memory for a line");
    memcpy(r->line, r->at, length);
    r->line[length] = 0;
    r->at = end + 1;
    return PSPLAT_OK;
}

static int read_stamp(const char *cell, uint64_t *stamp) {
    *stamp = 0;
    if (!*cell) return 1;
    if (strlen(cell) != 16 || strspn(cell, "0123456789abcdef") != 16) return 0;
    *stamp = strtoull(cell, NULL, 16);
    return *stamp != 0;
}

/* What follows "# name " goes into value. */
static psplat_result read_comment(reader *r, const char *name, char value[PSPLAT_JOURNAL_TEXT]) {
    psplat_result result = next_line(r);
    size_t length = strlen(name);
    if (result) return result;
    if (strncmp(r->line, "# ", 2) || strncmp(r->line + 2, name, length))
        return refuse(r, "this is no journal of phongsplat tradeoff");
    const char *rest = r->line + 2 + length;
    if (*rest == ' ') ++rest;
    if (strlen(rest) >= PSPLAT_JOURNAL_TEXT) return refuse(r, "the line is too long");
    strcpy(value, rest);
    return PSPLAT_OK;
}

static psplat_result read_head(reader *r, psplat_journal *journal) {
    const char *const begin = r->at;
    char text[PSPLAT_JOURNAL_TEXT], options[PSPLAT_JOURNAL_TEXT];
    psplat_result result = read_comment(r, title, text);
    if (!result && *text) result = refuse(r, "this journal is of another version");
    if (!result) result = read_comment(r, "source", journal->source);
    if (!result) result = read_comment(r, "graphics", journal->graphics);
    if (!result) result = read_comment(r, "gltfpack", journal->gltfpack);
    if (!result) result = read_comment(r, "", options);
    size_t length = (size_t)(r->at - begin);
    if (!result) result = read_comment(r, "check", text);
    if (result) return result;
    uint64_t check = 0;
    if (!read_stamp(text, &check) || check != psplat_stamp_bytes(PSPLAT_STAMP, begin, length))
        return refuse(r, "the lines above were changed by something else");
    return psplat_tradeoff_options_read(options, &journal->options)
               ? PSPLAT_OK
               : refuse(r, "the options above are not known");
}

static psplat_result read_names(reader *r) {
    psplat_text names = {0};
    psplat_result result = next_line(r);
    write_names(&names);
    if (!result) result = psplat_text_check(&names, r->error);
    if (!result && strcmp(r->line, names.data))
        result = refuse(r, "the columns are not those of this version");
    free(names.data);
    return result;
}

/* Splits the line at its commas; 0 where there are not CELLS cells. */
static int split(char *line, char *cells[CELLS]) {
    size_t count = 0;
    for (char *cell = line; cell; ++count) {
        char *comma = strchr(cell, ',');
        if (count == CELLS) return 0;
        if (comma) *comma++ = 0;
        cells[count] = cell;
        cell = comma;
    }
    return count == CELLS;
}

static int read_name(const char *cell, const char *const *names, int *index) {
    for (*index = 0; names[*index]; ++*index)
        if (!strcmp(names[*index], cell)) return 1;
    *index = 0;
    return !*cell;
}

static int read_value(const char *cell, double *value) {
    char *end = NULL;
    *value = NAN;
    if (!*cell) return 1;
    if (strspn(cell, "0123456789+-.einf") != strlen(cell)) return 0;
    *value = strtod(cell, &end);
    return !*end && end != cell && !isnan(*value);
}

static int read_positive(const char *cell, double *value) {
    if (!read_value(cell, value)) return 0;
    if (isnan(*value)) *value = 0;
    return !*cell || (*value > 0 && isfinite(*value));
}

static int read_setting(char *const *cells, psplat_setting *s) {
    int contender = 0, field = 0, precision = 0, mode = 0;
    if (!*cells[0] || !read_name(cells[0], psplat_contender_names, &contender)) return 0;
    if (!read_positive(cells[1], &s->tolerance) || !read_positive(cells[2], &s->ratio)) return 0;
    if (!read_name(cells[3], psplat_field_names, &field)) return 0;
    if (!read_name(cells[4], psplat_precision_names, &precision)) return 0;
    if (!read_name(cells[5], psplat_mode_names, &mode)) return 0;
    if (!read_name(cells[6], psplat_filter_names, &s->no_filter)) return 0;
    s->contender = (psplat_contender)contender;
    s->field = (psplat_normal_field)field;
    s->precision = (psplat_stored_as)precision;
    s->mode = (psplat_mode)mode;
    return 1;
}

static psplat_result read_row(reader *r, psplat_row *row) {
    char *cells[CELLS];
    const char *last = strrchr(r->line, ',');
    uint64_t expected =
        psplat_stamp_bytes(PSPLAT_STAMP, r->line, last ? (size_t)(last - r->line) : 0);
    uint64_t check = 0;
    if (!split(r->line, cells)) return refuse(r, "the number of cells is wrong");
    if (!read_stamp(cells[CELLS - 1], &check) || check != expected)
        return refuse(r, "the row was changed by something else");
    psplat_setting setting = {.tolerance = 0};
    if (!read_setting(cells, &setting)) return refuse(r, "the setting is not known");
    *row = psplat_row_empty(&setting);
    for (int i = 0; i < PSPLAT_COLUMN_COUNT; ++i)
        if (!read_value(cells[SETTING_CELLS + i], &row->values[i]))
            return refuse(r, "a cell is not a number");
    for (int i = 0; i < PSPLAT_GROUP_COUNT; ++i)
        if (!read_stamp(cells[VALUE_CELLS + i], &row->stamps[i]))
            return refuse(r, "a stamp is malformed");
    return read_stamp(cells[CONTENT_CELL], &row->content) ? PSPLAT_OK
                                                          : refuse(r, "a stamp is malformed");
}

static psplat_result read_rows(reader *r, psplat_journal *journal) {
    size_t capacity = 0;
    psplat_result result = PSPLAT_OK;
    while (r->at < r->end && !result) {
        if (journal->count == capacity) {
            capacity = 2 * capacity + 16;
            psplat_row *rows = realloc(journal->rows, capacity * sizeof *rows);
            if (!rows) return psplat_fail(r->error, PSPLAT_ERROR_MEMORY, 0, "no memory for rows");
            journal->rows = rows;
        }
        result = next_line(r);
        if (!result) result = read_row(r, &journal->rows[journal->count]);
        if (!result) ++journal->count;
    }
    return result;
}

psplat_result psplat_journal_read(const char *text, size_t size, psplat_journal *journal,
                                  psplat_error *error) {
    reader r = {.at = text, .end = text + size, .error = error};
    *journal = (psplat_journal){.count = 0};
    psplat_result result = read_head(&r, journal);
    if (!result) result = read_names(&r);
    if (!result) result = read_rows(&r, journal);
    free(r.line);
    if (result) psplat_journal_free(journal);
    return result;
}
