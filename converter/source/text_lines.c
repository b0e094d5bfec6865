/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * text_lines.c - line reader: a cursor over the lines, tokens and numbers of a text file.
 *
 * Its errors name the line and the offset in bytes.
 */
#include "source/text_lines.h"

#include "base/file_bytes.h"
#include "source/source_file.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

psplat_lines psplat_lines_begin(psplat_source *source) {
    return (psplat_lines){
        .source = source, .line = source->data, .cursor = source->data, .next = source->data};
}

void psplat_lines_end(psplat_lines *lines) {
    if (lines->number && lines->ended_by) lines->next[-1] = lines->ended_by;
    lines->ended_by = 0;
}

int psplat_lines_next(psplat_lines *lines) {
    char *end = lines->source->data + lines->source->size;
    psplat_lines_end(lines);
    if (lines->next >= end) return 0;
    lines->line = lines->cursor = lines->next;
    char *newline = memchr(lines->line, '\n', (size_t)(end - lines->line));
    lines->ended_by = newline ? '\n' : 0;
    lines->next = newline ? newline + 1 : end;
    if (newline) *newline = 0;
    ++lines->number;
    return 1;
}

static int is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

char *psplat_lines_token(psplat_lines *lines, size_t *length) {
    char *token = lines->cursor;
    while (is_blank(*token)) ++token;
    char *end = token;
    while (*end && !is_blank(*end)) ++end;
    lines->cursor = end;
    *length = (size_t)(end - token);
    return *length ? token : NULL;
}

psplat_result psplat_lines_fail(const psplat_lines *lines, psplat_error *error, psplat_result code,
                                const char *format, ...) {
    char text[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return psplat_fail(error, code, (size_t)(lines->line - lines->source->data), "%s: line %zu: %s",
                       lines->source->path, lines->number, text);
}

psplat_result psplat_lines_number(psplat_lines *lines, const char *what, double *value,
                                  psplat_error *error) {
    size_t length;
    char *token = psplat_lines_token(lines, &length);
    if (!token) return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "%s is missing", what);
    char *end;
    *value = strtod(token, &end);
    /* strtod also reads hexadecimal numbers, which the formats do not have. */
    if (end != token + length || memchr(token, 'x', length) || memchr(token, 'X', length))
        return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "%s is not a number: '%.*s'",
                                 what, (int)(length < 40 ? length : 40), token);
    if (!isfinite(*value) || fabs(*value) > (double)FLT_MAX)
        return psplat_lines_fail(lines, error, PSPLAT_ERROR_RANGE, "%s is not finite: '%.*s'", what,
                                 (int)(length < 40 ? length : 40), token);
    return PSPLAT_OK;
}

psplat_result psplat_lines_count(psplat_lines *lines, const char *what, size_t *value,
                                 psplat_error *error) {
    size_t length;
    char *token = psplat_lines_token(lines, &length);
    if (!token) return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "%s is missing", what);
    *value = 0;
    for (size_t i = 0; i < length; ++i) {
        if (token[i] < '0' || token[i] > '9')
            return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "%s is not a count: '%.*s'",
                                     what, (int)(length < 40 ? length : 40), token);
        *value = *value * 10 + (size_t)(token[i] - '0');
        if (*value > PSPLAT_MAX_SOURCE_BYTES)
            return psplat_lines_fail(lines, error, PSPLAT_ERROR_RANGE, "%s is too large", what);
    }
    return PSPLAT_OK;
}
