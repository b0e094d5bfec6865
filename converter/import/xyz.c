/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * xyz.c - the reader of point sets as text (.xyz, .pts, .asc). A point is a line of numbers that
 * are separated by blanks, commas or semicolons:
 *
 *     x y z                      x y z intensity
 *     x y z nx ny nz             x y z r g b             x y z intensity r g b
 *     x y z nx ny nz r g b
 *
 * The files do not name their columns, so the number of columns decides. Of six columns, the last
 * three are a colour if all of their values are whole numbers up to 255 and some are above 1, and
 * otherwise a normal. Comments begin with # or //. A line with one number, before the points, is
 * their count.
 */
#include "import/xyz.h"

#include "points/points.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct xyz_state {
    psplat_lines lines;
    size_t columns;  /* of every point; 0 before the first one */
    size_t promised; /* number of points by the line of the count; 0 without such a line */
    size_t first;    /* number of the first point's line */
    double *values;  /* count x columns */
    size_t count, capacity;
} xyz_state;

/* Cuts off a comment and turns separators into blanks. */
static void blank_comment(char *line) {
    char *slashes = strstr(line, "//");
    if (slashes) *slashes = 0;
    line[strcspn(line, "#")] = 0;
    for (char *c = line; (c = strpbrk(c, ",;")) != NULL;) *c = ' ';
}

static size_t count_columns(psplat_lines *lines) {
    size_t length, count = 0;
    char *before = lines->cursor;
    while (psplat_lines_token(lines, &length)) ++count;
    lines->cursor = before;
    return count;
}

static psplat_result read_count(xyz_state *state, psplat_error *error) {
    if (state->promised || state->count)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "one number instead of a point");
    return psplat_lines_count(&state->lines, "the number of points", &state->promised, error);
}

static int reserve(xyz_state *state) {
    if (state->count < state->capacity) return 1;
    size_t capacity = 2 * state->capacity + 1024;
    double *values = realloc(state->values, capacity * state->columns * sizeof *values);
    if (!values) return 0;
    state->values = values;
    state->capacity = capacity;
    return 1;
}

static psplat_result read_point(xyz_state *state, size_t columns, psplat_error *error) {
    static const char *const names[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
    int known = columns == 3 || columns == 4 || columns == 6 || columns == 7 || columns == 9;
    if (!known)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "%zu columns; 3, 4, 6, 7 or 9 are read", columns);
    if (!state->columns) state->columns = columns, state->first = state->lines.number;
    if (columns != state->columns)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "%zu columns, but %zu in line %zu", columns, state->columns,
                                 state->first);
    if (!reserve(state))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory",
                           state->lines.source->path);
    double *row = state->values + state->count * columns;
    for (size_t k = 0; k < columns; ++k) {
        const char *name = k < 3 ? names[k] : "a component of normal or colour";
        psplat_result result = psplat_lines_number(&state->lines, name, &row[k], error);
        if (result) return result;
    }
    ++state->count;
    return PSPLAT_OK;
}

static psplat_result read_rows(xyz_state *state, psplat_error *error) {
    while (psplat_lines_next(&state->lines)) {
        blank_comment(state->lines.line);
        size_t columns = count_columns(&state->lines);
        if (!columns) continue;
        psplat_result result =
            columns == 1 ? read_count(state, error) : read_point(state, columns, error);
        if (result) return result;
    }
    if (!state->promised || state->promised == state->count) return PSPLAT_OK;
    return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                             "%zu points were promised, the file has %zu", state->promised,
                             state->count);
}

/* ---- meaning of the columns ----------------------------------------------------------------- */

/* Returns whether three columns are a colour of bytes. */
static int are_bytes(const xyz_state *state, size_t column) {
    double greatest = 0;
    for (size_t i = 0; i < state->count; ++i)
        for (size_t k = column; k < column + 3; ++k) {
            double value = state->values[i * state->columns + k];
            if (value != floor(value) || value < 0 || value > 255) return 0;
            greatest = fmax(greatest, value);
        }
    return greatest > 1;
}

/* Converts sRGB (IEC 61966-2-1) in 0 ... 255, or in 0 ... 1, to linear light. */
static float linear_of(double value, int bytes) {
    if (bytes) value /= 255;
    value = fmin(fmax(value, 0), 1);
    return (float)(value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4));
}

static psplat_result store(const xyz_state *state, psplat_points *points, psplat_error *error) {
    size_t columns = state->columns, count = state->count;
    int bytes = columns >= 6 && are_bytes(state, columns - 3);
    int colored = columns == 7 || columns == 9 || (columns == 6 && bytes);
    int oriented = columns == 9 || (columns == 6 && !bytes);
    points->count = count;
    points->positions = malloc((3 * count + 1) * sizeof(double));
    if (oriented) points->normals = malloc((3 * count + 1) * sizeof(float));
    if (colored) points->colors = malloc((4 * count + 1) * sizeof(float));
    if (!points->positions || (oriented && !points->normals) || (colored && !points->colors))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory",
                           state->lines.source->path);
    for (size_t i = 0; i < count; ++i) {
        const double *row = state->values + i * columns;
        memcpy(points->positions + 3 * i, row, 3 * sizeof *row);
        for (size_t k = 0; k < 3 && oriented; ++k) points->normals[3 * i + k] = (float)row[3 + k];
        for (size_t k = 0; k < 4 && colored; ++k)
            points->colors[4 * i + k] = k < 3 ? linear_of(row[columns - 3 + k], bytes) : 1;
    }
    return PSPLAT_OK;
}

psplat_result psplat_points_read_xyz(psplat_source *source, psplat_points *points,
                                     psplat_error *error) {
    if (strlen(source->data) < source->size)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, strlen(source->data),
                           "%s: byte %zu: a zero byte in an XYZ text", source->path,
                           strlen(source->data));
    if (strncmp(source->data, "\xef\xbb\xbf", 3) == 0) memset(source->data, ' ', 3);
    xyz_state state = {.lines = psplat_lines_begin(source)};
    psplat_result result = read_rows(&state, error);
    psplat_lines_end(&state.lines);
    if (!result) result = store(&state, points, error);
    free(state.values);
    return result;
}
