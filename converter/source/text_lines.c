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
#include <stdint.h>
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

/* Reads a power of ten, as after an e. Returns where it ends. */
static const char *read_power(const char *c, const char *end, int *power) {
    int is_negative = c < end && *c == '-', value = 0;
    c += c < end && (*c == '-' || *c == '+');
    for (; c < end && *c >= '0' && *c <= '9' && value < 100; ++c) value = 10 * value + (*c - '0');
    *power += is_negative ? -value : value;
    return c;
}

/* Reads digits with or without a point. Returns where they end, or NULL if there are none. */
static const char *read_digits(const char *c, const char *end, uint64_t *digits, int *power) {
    const char *begin = c, *point = NULL;
    for (; c < end && ((*c >= '0' && *c <= '9') || (*c == '.' && !point)); ++c)
        if (*c == '.')
            point = c;
        else
            *digits = 10 * *digits + (uint64_t)(*c - '0');
    if (point) *power -= (int)(c - point - 1);
    return c - begin > (point != NULL) ? c : NULL;
}

/* Reads a short decimal number: digits that make an integer of less than 2^53, and a power of ten
 * up to 22. Doubles hold both exactly, so that one multiplication or division rounds correctly
 * (Clinger: How to Read Floating Point Numbers Accurately, 1990). Returns 0 for all others. */
static int read_short(const char *text, const char *end, double *value) {
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    enum { GREATEST_POWER = 22, MOST_CHARACTERS = 18 }; /* so few digits cannot overflow */
    int is_negative = *text == '-', power = 0;
    uint64_t digits = 0;
    if (end - text > MOST_CHARACTERS) return 0;
    const char *c = read_digits(text + (*text == '-' || *text == '+'), end, &digits, &power);
    if (!c) return 0;
    if (end - c > 1 && (*c == 'e' || *c == 'E')) {
        if (end[-1] < '0' || end[-1] > '9') return 0;
        c = read_power(c + 1, end, &power);
    }
    if (c != end || digits >> 53 || power < -GREATEST_POWER || power > GREATEST_POWER) return 0;
    *value = power < 0 ? (double)digits / powers[-power] : (double)digits * powers[power];
    if (is_negative) *value = -*value;
    return 1;
}

psplat_result psplat_lines_number(psplat_lines *lines, const char *what, double *value,
                                  psplat_error *error) {
    size_t length;
    char *token = psplat_lines_token(lines, &length);
    if (!token) return psplat_lines_fail(lines, error, PSPLAT_ERROR_FORMAT, "%s is missing", what);
    char *end;
    if (read_short(token, token + length, value)) return PSPLAT_OK; /* < 1e38 */
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
