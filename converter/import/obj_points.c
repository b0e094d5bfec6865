/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_points.c - the reader of point sets in OBJ files: `v` lines without faces, with or without
 * `p` elements that name them.
 *
 * Faces tell which normal belongs to which vertex. Without faces, the n-th `vn` belongs to the n-th
 * `v`, as programs that scan write them; where there are more or fewer normals than vertices, none
 * is used. A colour follows its position, as x y z r g b. Colours are sRGB, of 0 to 1 or, where one
 * of the file is above 1, of 0 to 255.
 */
#include "import/obj_points.h"

#include "material/mipmap.h"
#include "points/points.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct obj_points {
    psplat_lines lines;
    psplat_points *points;
    size_t colored, oriented; /* vertices with a colour and normals so far */
} obj_points;

static int is_word(const char *token, size_t length, const char *word) {
    return token && strlen(word) == length && memcmp(token, word, length) == 0;
}

static psplat_result read_three(obj_points *state, const char *what, float values[3],
                                psplat_error *error) {
    double value;
    for (int k = 0; k < 3; ++k) {
        psplat_result result = psplat_lines_number(&state->lines, what, &value, error);
        if (result) return result;
        values[k] = (float)value;
    }
    return PSPLAT_OK;
}

/* Reads the colour of a vertex; its position is known since the file was checked. */
static psplat_result read_color(obj_points *state, psplat_error *error) {
    size_t length;
    for (int axis = 0; axis < 3; ++axis) psplat_lines_token(&state->lines, &length);
    float *color = state->points->colors + 4 * state->colored++;
    color[3] = 1;
    return read_three(state, "a component of the colour", color, error);
}

static psplat_result read_line(obj_points *state, psplat_error *error) {
    psplat_points *points = state->points;
    size_t length;
    char *word = psplat_lines_token(&state->lines, &length);
    if (points->colors && is_word(word, length, "v")) return read_color(state, error);
    if (points->normals && is_word(word, length, "vn"))
        return read_three(state, "a component of the normal",
                          points->normals + 3 * state->oriented++, error);
    return PSPLAT_OK;
}

/* Turns sRGB into linear light. */
static void make_linear(psplat_points *points) {
    float greatest = 0;
    for (size_t i = 0; i < 4 * points->count; ++i) greatest = fmaxf(greatest, points->colors[i]);
    float scale = greatest > 1 ? 1.0f / 255 : 1;
    for (size_t i = 0; i < 4 * points->count; ++i)
        if (i % 4 < 3)
            points->colors[i] =
                psplat_linear_of_srgb(fminf(fmaxf(scale * points->colors[i], 0), 1));
}

static int allocate(const psplat_source *source, psplat_points *points) {
    size_t count = points->count = source->vertices;
    points->positions = malloc((3 * count + 1) * sizeof(double));
    if (source->normals == count) points->normals = malloc((3 * count + 1) * sizeof(float));
    if (source->has_colors) points->colors = malloc((4 * count + 1) * sizeof(float));
    return points->positions && (points->normals || source->normals != count) &&
           (points->colors || !source->has_colors);
}

psplat_result psplat_points_read_obj(psplat_source *source, psplat_points *points,
                                     psplat_error *error) {
    if (!allocate(source, points))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    memcpy(points->positions, source->positions, 3 * points->count * sizeof(double));
    obj_points state = {.lines = psplat_lines_begin(source), .points = points};
    psplat_result result = PSPLAT_OK;
    while (!result && psplat_lines_next(&state.lines)) result = read_line(&state, error);
    psplat_lines_end(&state.lines);
    if (!result && points->colors) make_linear(points);
    return result;
}
