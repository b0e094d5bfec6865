/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * json_writer.c - JSON writer (RFC 8259): text that grows in memory.
 */
#include "base/json_writer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add(psplat_writer *json, const char *bytes, size_t size) {
    if (json->failed) return;
    if (json->capacity - json->size < size) {
        size_t capacity = 2 * json->capacity + size + 256;
        char *text = realloc(json->text, capacity);
        if (!text) {
            json->failed = 1;
            return;
        }
        json->text = text;
        json->capacity = capacity;
    }
    memcpy(json->text + json->size, bytes, size);
    json->size += size;
}

static void add_text(psplat_writer *json, const char *text) {
    add(json, text, strlen(text));
}

static void add_newline(psplat_writer *json) {
    if (json->compact) return;
    add_text(json, "\n");
    for (int i = 0; i < json->depth; ++i) add_text(json, "  ");
}

/* Returns the length in bytes of the well-formed UTF-8 sequence at s, or 0 if there is none
 * (Unicode 15, table 3-7). */
static size_t utf8_sequence_length(const unsigned char *s) {
    size_t length = *s < 0x80   ? 1
                    : *s < 0xc2 ? 0
                    : *s < 0xe0 ? 2
                    : *s < 0xf0 ? 3
                    : *s < 0xf5 ? 4
                                : 0;
    for (size_t i = 1; i < length; ++i)
        if ((s[i] & 0xc0) != 0x80) return 0;
    int overlong = (*s == 0xe0 && s[1] < 0xa0) || (*s == 0xf0 && s[1] < 0x90);
    int outside = (*s == 0xed && s[1] > 0x9f) || (*s == 0xf4 && s[1] > 0x8f);
    return overlong || outside ? 0 : length;
}

static void add_quoted(psplat_writer *json, const char *string) {
    add_text(json, "\"");
    for (const unsigned char *s = (const unsigned char *)string; *s;) {
        size_t length = utf8_sequence_length(s);
        char escape[8];
        snprintf(escape, sizeof escape, "\\u%04x", *s);
        if (!length)
            add_text(json, "\xef\xbf\xbd");
        else if (*s < 0x20 || *s == '"' || *s == '\\')
            add_text(json, escape);
        else
            add(json, (const char *)s, length);
        s += length ? length : 1;
    }
    add_text(json, "\"");
}

static void begin_member(psplat_writer *json, const char *key) {
    if (json->has_member) add_text(json, ",");
    if (json->depth) add_newline(json);
    json->has_member = 1;
    if (!key) return;
    add_quoted(json, key);
    add_text(json, json->compact ? ":" : ": ");
}

void psplat_writer_open(psplat_writer *json, const char *key, char bracket) {
    begin_member(json, key);
    add(json, &bracket, 1);
    ++json->depth;
    json->has_member = 0;
}

void psplat_writer_close(psplat_writer *json, char bracket) {
    --json->depth;
    if (json->has_member) add_newline(json);
    add(json, &bracket, 1);
    json->has_member = 1;
}

void psplat_writer_count(psplat_writer *json, const char *key, size_t count) {
    char digits[32];
    snprintf(digits, sizeof digits, "%zu", count);
    begin_member(json, key);
    add_text(json, digits);
}

/* Adds a number as printf wrote it. printf uses the decimal separator of the locale, which may be
 * several bytes: whatever is neither digit, sign nor exponent becomes one point. */
static void add_digits(psplat_writer *json, const char *digits) {
    while (*digits) {
        size_t plain = strspn(digits, "0123456789+-e");
        add(json, digits, plain);
        digits += plain;
        size_t separator = strcspn(digits, "0123456789+-e");
        if (separator) add_text(json, ".");
        digits += separator;
    }
}

static void add_number(psplat_writer *json, double number, int is_float) {
    char digits[40];
    if (!isfinite(number)) {
        add_text(json, "null");
        return;
    }
    /* %g would write 60 as 6e+01, since one digit is enough to tell it from other numbers. */
    int is_integer = number == floor(number) && fabs(number) < 1e15;
    if (is_integer) snprintf(digits, sizeof digits, "%.0f", number);
    for (int precision = 1; !is_integer && precision <= 17; ++precision) {
        snprintf(digits, sizeof digits, "%.*g", precision, number);
        double back = is_float ? (double)strtof(digits, NULL) : strtod(digits, NULL);
        if (back == number) break;
    }
    add_digits(json, digits);
}

static void add_separator(psplat_writer *json, size_t index) {
    if (index) add_text(json, json->compact ? "," : ", ");
}

void psplat_writer_number(psplat_writer *json, const char *key, double number) {
    begin_member(json, key);
    add_number(json, number, 0);
}

void psplat_writer_numbers(psplat_writer *json, const char *key, const double *numbers,
                           size_t count) {
    begin_member(json, key);
    add_text(json, "[");
    for (size_t i = 0; i < count; ++i) {
        add_separator(json, i);
        add_number(json, numbers[i], 0);
    }
    add_text(json, "]");
}

void psplat_writer_float(psplat_writer *json, const char *key, float number) {
    begin_member(json, key);
    add_number(json, (double)number, 1);
}

void psplat_writer_floats(psplat_writer *json, const char *key, const float *numbers,
                          size_t count) {
    begin_member(json, key);
    add_text(json, "[");
    for (size_t i = 0; i < count; ++i) {
        add_separator(json, i);
        add_number(json, (double)numbers[i], 1);
    }
    add_text(json, "]");
}

void psplat_writer_boolean(psplat_writer *json, const char *key, int value) {
    begin_member(json, key);
    add_text(json, value ? "true" : "false");
}

void psplat_writer_string(psplat_writer *json, const char *key, const char *string) {
    begin_member(json, key);
    add_quoted(json, string);
}

void psplat_writer_raw(psplat_writer *json, const char *key, const char *value) {
    begin_member(json, key);
    add_text(json, value);
}

int psplat_writer_finish(psplat_writer *json) {
    if (!json->compact) add_text(json, "\n");
    if (!json->failed) return 1;
    free(json->text);
    json->text = NULL;
    json->size = 0;
    return 0;
}
