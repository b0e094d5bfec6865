/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * check_off.c - the strict validation of an OFF file before OpenMesh reads it.
 *
 * OpenMesh's reader of this format finds normals and colours only when it opens the file by its
 * name, knows no comments, and takes the colour of a face for the next face. So the text is
 * rewritten in memory as the equivalent PLY.
 */
#include "base/polygon.h"
#include "import/check.h"
#include "source/source_file.h"
#include "source/source_rewrite.h"
#include "source/text_lines.h"

#include <stdlib.h>
#include <string.h>

typedef struct off_state {
    psplat_lines lines;
    int normals, colors, texcoords; /* that the header word promises for each vertex */
    psplat_rewrite out;
} off_state;

static void blank_comments(psplat_source *source) {
    for (char *c = source->data; (c = strchr(c, '#')) != NULL;) memset(c, ' ', strcspn(c, "\n"));
}

/* Moves to the next line that is not blank. */
static psplat_result next_content(off_state *state, const char *what, psplat_error *error) {
    while (psplat_lines_next(&state->lines))
        if (state->lines.line[strspn(state->lines.line, " \t\r")]) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_FORMAT, state->lines.source->size,
                       "%s: line %zu: the file ends before %s", state->lines.source->path,
                       state->lines.number, what);
}

/* Moves on to the next line where nothing is left of this one: vertices and corners may go on
 * there, since the format separates numbers by any white space. */
static psplat_result continue_line(off_state *state, const char *what, psplat_error *error) {
    const char *rest = state->lines.cursor;
    return rest[strspn(rest, " \t\r")] ? PSPLAT_OK : next_content(state, what, error);
}

static psplat_result check_header(off_state *state, psplat_error *error) {
    psplat_lines_next(&state->lines);
    char *word = state->lines.line;
    if (strncmp(word, "ST", 2) == 0) {
        state->texcoords = 1;
        word += 2;
    }
    state->colors = *word == 'C';
    word += state->colors;
    state->normals = *word == 'N';
    word += state->normals;
    if (strncmp(word, "OFF", 3) != 0)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_UNSUPPORTED,
                                 "only vertices of three dimensions are read");
    word += 3;
    if (strstr(word, "BINARY"))
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_UNSUPPORTED,
                                 "binary OFF is not read: its byte order is not defined");
    /* The counts may follow the header word on its line; a line end is put between them. */
    if (word[strspn(word, " \t\r")]) {
        psplat_lines_end(&state->lines);
        *word = '\n';
        state->lines.next = word + 1;
    }
    return PSPLAT_OK;
}

static psplat_result check_counts(psplat_source *source, off_state *state, psplat_error *error) {
    size_t faces = 0;
    psplat_result result = next_content(state, "its counts", error);
    if (!result)
        result =
            psplat_lines_count(&state->lines, "the number of vertices", &source->vertices, error);
    if (!result) result = continue_line(state, "the number of faces", error);
    if (!result) result = psplat_lines_count(&state->lines, "the number of faces", &faces, error);
    if (result) return result;
    source->faces = faces;
    /* The shortest vertex is "0 0 0" and a line end, the shortest face "3 0 1 2". */
    if (source->vertices > source->size / 6 + 1 || faces > source->size / 8 + 1)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_RANGE,
                                 "%zu vertices and %zu faces do not fit into the file of %zu bytes",
                                 source->vertices, faces, source->size);
    source->is_point_set = faces == 0;
    source->positions = malloc((source->vertices + 1) * 3 * sizeof(double));
    if (!source->positions)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    return PSPLAT_OK;
}

static psplat_result write_header(const psplat_source *source, off_state *state,
                                  psplat_error *error) {
    return psplat_rewrite_text(
        &state->out, error,
        "ply\nformat ascii 1.0\nelement vertex %zu\nproperty float x\nproperty float y\n"
        "property float z\n%sproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property uchar alpha\nelement face %zu\nproperty list int int vertex_index\nend_header\n",
        source->vertices,
        state->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        source->faces);
}

/* Reads the colour at the end of a vertex line: three or four integers up to 255, or as many reals
 * up to 1, before the two texture coordinates of STOFF. If there is anything else, the colour is
 * white and has_colors is cleared. */
static psplat_result check_color(psplat_source *source, off_state *state, double color[4],
                                 psplat_error *error) {
    size_t length, count = 0;
    int is_real = 0;
    double value;
    char *before = state->lines.cursor, *token;
    while ((token = psplat_lines_token(&state->lines, &length)) != NULL) {
        is_real |= memchr(token, '.', length) != NULL;
        ++count;
    }
    state->lines.cursor = before;
    if (state->texcoords) count -= count < 2 ? count : 2;
    for (int k = 0; k < 4; ++k) color[k] = 255;
    if (!state->colors || count < 3 || count > 4) {
        source->has_colors = 0;
        return PSPLAT_OK;
    }
    for (size_t k = 0; k < count; ++k) {
        psplat_result result = psplat_lines_number(&state->lines, "a colour", &value, error);
        if (result) return result;
        if (is_real) value *= 255;
        color[k] = value < 0 ? 0 : value > 255 ? 255 : value;
    }
    return PSPLAT_OK;
}

static psplat_result check_vertex(psplat_source *source, off_state *state, size_t index,
                                  psplat_error *error) {
    static const char *const names[] = {"the x coordinate",          "the y coordinate",
                                        "the z coordinate",          "a component of the normal",
                                        "a component of the normal", "a component of the normal"};
    double value[6], color[4];
    psplat_result result = next_content(state, "the last vertex", error);
    for (int k = 0; k < (state->normals ? 6 : 3) && !result; ++k) {
        result = continue_line(state, names[k], error);
        if (!result) result = psplat_lines_number(&state->lines, names[k], &value[k], error);
        if (!result) result = psplat_rewrite_text(&state->out, error, "%.9g ", value[k]);
    }
    if (!result) result = check_color(source, state, color, error);
    if (result) return result;
    memcpy(source->positions + index * 3, value, 3 * sizeof *value);
    return psplat_rewrite_text(&state->out, error, "%.0f %.0f %.0f %.0f\n", color[0], color[1],
                               color[2], color[3]);
}

static psplat_result check_face(const psplat_source *source, off_state *state,
                                psplat_error *error) {
    size_t corners, vertex;
    psplat_result result = next_content(state, "the last face", error);
    if (!result)
        result = psplat_lines_count(&state->lines, "the number of corners", &corners, error);
    if (result) return result;
    if (corners < 3 || corners > PSPLAT_MAX_CORNERS)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_RANGE,
                                 "a face of %zu corners; 3 to %u are read", corners,
                                 PSPLAT_MAX_CORNERS);
    result = psplat_rewrite_text(&state->out, error, "%zu", corners);
    for (size_t i = 0; i < corners && !result; ++i) {
        result = continue_line(state, "the index of a corner", error);
        if (!result)
            result = psplat_lines_count(&state->lines, "the index of a corner", &vertex, error);
        if (result) return result;
        if (vertex >= source->vertices)
            return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_RANGE,
                                     "vertex %zu does not exist (%zu in the file)", vertex,
                                     source->vertices);
        result = psplat_rewrite_text(&state->out, error, " %zu", vertex);
    }
    return result ? result : psplat_rewrite_text(&state->out, error, "\n");
}

psplat_result psplat_check_off(psplat_source *source, psplat_error *error) {
    if (strlen(source->data) < source->size && !strstr(source->data, "BINARY"))
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, strlen(source->data),
                           "%s: byte %zu: a zero byte in an OFF text", source->path,
                           strlen(source->data));
    blank_comments(source);
    off_state state = {.lines = psplat_lines_begin(source)};
    psplat_result result = check_header(&state, error);
    if (!result) result = check_counts(source, &state, error);
    if (!result) result = write_header(source, &state, error);
    source->has_colors = state.colors;
    for (size_t i = 0; i < source->vertices && !result; ++i)
        result = check_vertex(source, &state, i, error);
    for (size_t i = 0; i < source->faces && !result; ++i)
        result = check_face(source, &state, error);
    psplat_lines_end(&state.lines);
    if (result)
        free(state.out.data);
    else
        psplat_rewrite_replace(&state.out, source);
    return result;
}
