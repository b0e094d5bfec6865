/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * check_stl.c - the strict validation of an STL file, text or binary, before OpenMesh reads it.
 */
#include "import/check.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

/* The bytes of a binary file's header, with the count, and of each triangle. */
enum { HEADER_BYTES = 84, TRIANGLE_BYTES = 50 };

static float read_float(const char *data) {
    const unsigned char *b = (const unsigned char *)data;
    uint32_t bits =
        (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static psplat_result check_binary(psplat_source *source, psplat_error *error) {
    if (source->size < HEADER_BYTES)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, source->size,
                           "%s: byte %zu: the file ends before the %d bytes of an STL header",
                           source->path, source->size, HEADER_BYTES);
    const unsigned char *count = (const unsigned char *)source->data + HEADER_BYTES - 4;
    size_t triangles =
        (size_t)count[0] | (size_t)count[1] << 8 | (size_t)count[2] << 16 | (size_t)count[3] << 24;
    if (source->size != HEADER_BYTES + TRIANGLE_BYTES * triangles)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, source->size,
                           "%s: byte 80: %zu triangles need %zu bytes, the file has %zu",
                           source->path, triangles, HEADER_BYTES + TRIANGLE_BYTES * triangles,
                           source->size);
    for (size_t t = 0; t < triangles; ++t) {
        size_t offset = HEADER_BYTES + t * TRIANGLE_BYTES + 12;
        for (size_t i = 0; i < 9; ++i)
            if (!isfinite(read_float(source->data + offset + i * 4)))
                return psplat_fail(error, PSPLAT_ERROR_RANGE, offset + i * 4,
                                   "%s: byte %zu: a coordinate of triangle %zu is not finite",
                                   source->path, offset + i * 4, t);
    }
    source->faces = triangles;
    return PSPLAT_OK;
}

/* Moves to the next line with content; returns 0 at the end of the file. */
static int next_content(psplat_lines *lines) {
    while (psplat_lines_next(lines))
        if (lines->line[strspn(lines->line, " \t\r")]) return 1;
    return 0;
}

static psplat_result expect(psplat_lines *lines, const char *word, psplat_error *error) {
    size_t length;
    char *token = psplat_lines_token(lines, &length);
    if (!token || length != strlen(word) || strncmp(token, word, length) != 0)
        return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "'%s' expected", word);
    return PSPLAT_OK;
}

static psplat_result expect_line(psplat_lines *lines, const char *first, const char *second,
                                 psplat_error *error) {
    if (!psplat_lines_next(lines))
        return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT,
                                 "the file ends inside a facet, before '%s'", first);
    psplat_result result = expect(lines, first, error);
    return result || !second ? result : expect(lines, second, error);
}

/* Reads a facet after its first word. OpenMesh wants the three vertices on the three lines after
 * "outer loop". */
static psplat_result check_facet(psplat_source *source, psplat_lines *lines, psplat_error *error) {
    static const char *const names[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
    double value;
    psplat_result result = expect(lines, "normal", error);
    if (!result) result = expect_line(lines, "outer", "loop", error);
    for (int i = 0; i < 9 && !result; ++i) {
        if (i % 3 == 0) result = expect_line(lines, "vertex", NULL, error);
        if (!result) result = psplat_lines_number(lines, names[i % 3], &value, error);
    }
    if (!result) result = expect_line(lines, "endloop", NULL, error);
    if (!result) result = expect_line(lines, "endfacet", NULL, error);
    ++source->faces;
    return result;
}

static psplat_result check_text(psplat_source *source, psplat_error *error) {
    if (strlen(source->data) < source->size)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, strlen(source->data),
                           "%s: byte %zu: neither a text nor a binary STL of this length",
                           source->path, strlen(source->data));
    for (char *c = source->data; *c; ++c) *c = (char)tolower((unsigned char)*c);
    psplat_lines lines = psplat_lines_begin(source);
    psplat_result result = PSPLAT_OK;
    int ended = 0;
    while (!result && next_content(&lines)) {
        size_t length;
        char *word = psplat_lines_token(&lines, &length);
        if (length == 5 && strncmp(word, "facet", 5) == 0) {
            result = check_facet(source, &lines, error);
        } else if (length == 8 && strncmp(word, "endsolid", 8) == 0) {
            ended = 1;
        } else if (length == 5 && strncmp(word, "solid", 5) == 0) {
            ended = 0;
        } else {
            result = psplat_lines_fail(&lines, error, PSPLAT_ERROR_FORMAT, "'facet' expected");
        }
    }
    if (!result && !ended)
        result = psplat_lines_fail(&lines, error, PSPLAT_ERROR_FORMAT,
                                   "the file ends before 'endsolid'");
    psplat_lines_end(&lines);
    return result;
}

psplat_result psplat_check_stl(psplat_source *source, psplat_error *error) {
    psplat_result result = source->format == PSPLAT_SOURCE_STL_BINARY ? check_binary(source, error)
                                                                      : check_text(source, error);
    if (!result && source->faces == 0)
        result = psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: end of file: no triangle",
                             source->path);
    return result;
}
