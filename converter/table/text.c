/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * text.c - text that grows, and what is written into it: numbers, names, cells.
 */
#include "table/text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes room for length more bytes and the end. */
static int reserve(psplat_text *text, size_t length) {
    if (text->failed) return 0;
    if (text->size + length < text->capacity) return 1;
    size_t capacity = 2 * text->capacity + length + 256;
    char *data = realloc(text->data, capacity);
    text->failed = !data;
    if (!data) return 0;
    text->data = data;
    text->capacity = capacity;
    return 1;
}

void psplat_text_add(psplat_text *text, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    if (length < 0) text->failed = 1;
    if (length >= 0 && reserve(text, (size_t)length)) {
        vsnprintf(text->data + text->size, (size_t)length + 1, format, again);
        text->size += (size_t)length;
    }
    va_end(again);
    va_end(arguments);
}

void psplat_text_number(psplat_text *text, double number) {
    char digits[40];
    if (isnan(number)) return;
    /* %g writes 60 as 6e+01 where one digit is enough to tell it. */
    int is_integer = number == floor(number) && fabs(number) < 1e15;
    if (is_integer) snprintf(digits, sizeof digits, "%.0f", number);
    for (int precision = 1; !is_integer && precision <= 17; ++precision) {
        snprintf(digits, sizeof digits, "%.*g", precision, number);
        if (strtod(digits, NULL) == number) break;
    }
    psplat_text_add(text, "%s", digits);
}

/* Adds an integer in groups of three digits. */
static void add_grouped(psplat_text *text, double number) {
    char digits[400];
    int length = snprintf(digits, sizeof digits, "%.0f", fabs(number));
    if (number < 0) psplat_text_add(text, "-");
    for (int i = 0; i < length; ++i)
        psplat_text_add(text, i && (length - i) % 3 == 0 ? ",%c" : "%c", digits[i]);
}

void psplat_text_figure(psplat_text *text, double number) {
    if (isnan(number))
        psplat_text_add(text, "\xe2\x80\x93");
    else if (isinf(number))
        psplat_text_add(text, number < 0 ? "-\xe2\x88\x9e" : "\xe2\x88\x9e");
    else if (fabs(number) >= 100 || number == floor(number))
        add_grouped(text, number);
    else if (fabs(number) >= 1e-3)
        psplat_text_add(text, "%.*f",
                        fabs(number) >= 9.995    ? 1
                        : fabs(number) >= 0.9995 ? 2
                        : fabs(number) >= 0.0995 ? 3
                                                 : 4,
                        number);
    else
        psplat_text_add(text, "%.1e", number);
}

static char without_control(char c) {
    return (unsigned char)c < 0x20 || c == 0x7f ? '?' : c;
}

void psplat_text_escaped(psplat_text *text, const char *raw) {
    for (; *raw; ++raw) switch (*raw) {
        case '&':
            psplat_text_add(text, "&amp;");
            break;
        case '<':
            psplat_text_add(text, "&lt;");
            break;
        case '>':
            psplat_text_add(text, "&gt;");
            break;
        case '"':
            psplat_text_add(text, "&quot;");
            break;
        default:
            psplat_text_add(text, "%c", without_control(*raw));
        }
}

void psplat_text_quoted(psplat_text *text, const char *raw) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "+-_./,:=@%";
    if (*raw && !raw[strspn(raw, plain)]) {
        psplat_text_add(text, "%s", raw);
        return;
    }
    psplat_text_add(text, "'");
    for (; *raw; ++raw) psplat_text_add(text, *raw == '\'' ? "'\\''" : "%c", *raw);
    psplat_text_add(text, "'");
}

void psplat_text_enclosed(psplat_text *text, const char *raw, char mark) {
    psplat_text_add(text, "%c", mark);
    for (; *raw; ++raw) {
        if (*raw == mark) psplat_text_add(text, "%c", mark);
        psplat_text_add(text, "%c", without_control(*raw));
    }
    psplat_text_add(text, "%c", mark);
}

void psplat_text_stem(psplat_text *text, const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    psplat_text_add(text, "%.*s", dot && dot > name ? (int)(dot - name) : (int)strlen(name), name);
}

psplat_result psplat_text_check(const psplat_text *text, psplat_error *error) {
    if (!text->failed) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a text");
}
