/* SPDX-License-Identifier: MIT
 *
 * json.c - access to the values of a JSON document that psplat_json_parse has found well-formed;
 * see json.h.
 */
#include "core/json.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t psplat_json_offset(const psplat_json *json, psplat_json_value value) {
    return json->base + json->tokens[value].start;
}

psplat_json_type psplat_json_type_of(const psplat_json *json, psplat_json_value value) {
    switch (json->text[json->tokens[value].start]) {
    case '{':
        return PSPLAT_JSON_OBJECT;
    case '[':
        return PSPLAT_JSON_ARRAY;
    case '"':
        return PSPLAT_JSON_STRING;
    case 't':
    case 'f':
    case 'n':
        return PSPLAT_JSON_LITERAL;
    default:
        return PSPLAT_JSON_NUMBER;
    }
}

size_t psplat_json_length(const psplat_json *json, psplat_json_value value) {
    return json->tokens[value].length;
}

psplat_json_value psplat_json_first(const psplat_json *json, psplat_json_value parent) {
    return json->tokens[parent].beyond > parent + 1 ? parent + 1 : 0;
}

psplat_json_value psplat_json_next(const psplat_json *json, psplat_json_value parent,
                                   psplat_json_value child) {
    psplat_json_value next = json->tokens[child].beyond;
    return next < json->tokens[parent].beyond ? next : 0;
}

/* ---- strings ------------------------------------------------------------------------------ */

static uint32_t hex4(const char *s) {
    uint32_t code = 0;
    for (int i = 0; i < 4; ++i) {
        uint32_t c = (uint32_t)(unsigned char)s[i];
        code = code * 16 + (c <= '9' ? c - '0' : (c | 0x20) - 'a' + 10);
    }
    return code;
}

static size_t put_utf8(uint32_t code, char out[4]) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    size_t length = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (size_t i = length; i-- > 1; code >>= 6) out[i] = (char)(0x80 | (code & 0x3f));
    out[0] = (char)(code | (length == 2 ? 0xc0 : length == 3 ? 0xe0 : 0xf0));
    return length;
}

/* Reads one \u escape, or two that form a surrogate pair. Returns 0 for a lone surrogate. */
static uint32_t read_unicode(const char **at, const char *end) {
    uint32_t code = hex4(*at + 2);
    *at += 6;
    if (code < 0xd800 || code > 0xdfff) return code;
    if (code > 0xdbff || end - *at < 6 || (*at)[0] != '\\' || (*at)[1] != 'u') return 0;
    uint32_t low = hex4(*at + 2);
    if (low < 0xdc00 || low > 0xdfff) return 0;
    *at += 6;
    return 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
}

/* Unescapes one character of a string into out and returns its length in bytes of UTF-8, or 0 where
 * the escape stands for no character. */
static size_t read_character(const char **at, const char *end, char out[4]) {
    if (**at != '\\') {
        out[0] = *(*at)++;
        return 1;
    }
    if ((*at)[1] == 'u') {
        uint32_t code = read_unicode(at, end);
        return code ? put_utf8(code, out) : 0;
    }
    static const char escapes[] = "\"\\/bfnrt", meanings[] = "\"\\/\b\f\n\r\t";
    out[0] = meanings[strchr(escapes, (*at)[1]) - escapes];
    *at += 2;
    return 1;
}

/* Returns the string's first character, after the quotation mark. */
static const char *string_begin(const psplat_json *json, psplat_json_value string) {
    return json->text + json->tokens[string].start + 1;
}

static const char *string_end(const psplat_json *json, psplat_json_value string) {
    return json->text + json->tokens[string].end - 1;
}

/* Returns where the string goes on after the word, or NULL if it does not begin with the word. */
static const char *skip_word(const psplat_json *json, psplat_json_value string, const char *word) {
    const char *at = string_begin(json, string);
    const char *end = string_end(json, string);
    char character[4];
    while (*word && at < end)
        if (read_character(&at, end, character) != 1 || character[0] != *word++) return NULL;
    return *word ? NULL : at;
}

int psplat_json_begins(const psplat_json *json, psplat_json_value string, const char *word) {
    return skip_word(json, string, word) != NULL;
}

int psplat_json_equals(const psplat_json *json, psplat_json_value string, const char *word) {
    return skip_word(json, string, word) == string_end(json, string);
}

psplat_result psplat_json_string(const psplat_json *json, psplat_json_value value,
                                 psplat_arena *arena, char **out, size_t *size) {
    psplat_result result = psplat_json_expect(json, value, PSPLAT_JSON_STRING, "a string");
    if (result) return result;
    const char *at = string_begin(json, value);
    const char *end = string_end(json, value);
    /* Unescaping never lengthens a string: the shortest escape of 3 bytes of UTF-8 takes 6
     * bytes. */
    char *string = psplat_arena_take(arena, (size_t)(end - at) + 1, 1);
    if (!string)
        return psplat_fail(json->error, PSPLAT_ERROR_MEMORY, psplat_json_offset(json, value),
                           "no memory for a string");
    *out = string;
    while (at < end) {
        const char *start = at;
        char character[4];
        size_t length = read_character(&at, end, character);
        if (!length)
            return psplat_fail(json->error, PSPLAT_ERROR_FORMAT,
                               json->base + (size_t)(start - json->text),
                               "JSON: an escape is not a character");
        memcpy(string, character, length);
        string += length;
    }
    *size = (size_t)(string - *out);
    return PSPLAT_OK;
}

/* ---- objects ------------------------------------------------------------------------------ */

psplat_result psplat_json_members(const psplat_json *json, psplat_json_value object,
                                  const char *const *names, size_t count,
                                  psplat_json_value *values) {
    memset(values, 0, count * sizeof *values);
    if (psplat_json_type_of(json, object) != PSPLAT_JSON_OBJECT)
        return psplat_fail(json->error, PSPLAT_ERROR_FORMAT, psplat_json_offset(json, object),
                           "an object is expected");
    psplat_json_value key = psplat_json_first(json, object);
    for (; key; key = psplat_json_next(json, object, key))
        for (size_t i = 0; i < count; ++i) {
            if (!psplat_json_equals(json, key, names[i])) continue;
            if (values[i])
                return psplat_fail(json->error, PSPLAT_ERROR_FORMAT, psplat_json_offset(json, key),
                                   "'%s' occurs twice", names[i]);
            values[i] = psplat_json_first(json, key);
        }
    return PSPLAT_OK;
}

psplat_result psplat_json_expect(const psplat_json *json, psplat_json_value value,
                                 psplat_json_type type, const char *what) {
    static const char *const names[] = {"an object", "an array", "a string", "a number",
                                        "true, false or null"};
    if (!value || psplat_json_type_of(json, value) == type) return PSPLAT_OK;
    return psplat_fail(json->error, PSPLAT_ERROR_FORMAT, psplat_json_offset(json, value),
                       "%s must be %s", what, names[type]);
}

/* ---- numbers ------------------------------------------------------------------------------ */

/* The powers of ten that doubles hold exactly. */
static const double powers_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                       1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                       1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* Reads the digits of a number without its sign and its point. Returns where its exponent would
 * begin, or NULL where there are more than 15 of them behind zeros. *places: behind the point. */
static const char *read_digits(const char *at, const char *end, uint64_t *digits, int *places) {
    int has_point = 0;
    for (; at < end && (*at | 0x20) != 'e'; ++at) {
        if (*at == '.') {
            has_point = 1;
            continue;
        }
        *digits = 10 * *digits + (uint64_t)(*at - '0');
        *places += has_point;
        if (*digits >= 1000000000000000u || *places > 22) return NULL;
    }
    return at;
}

/* Reads a number of at most 15 digits times a power of ten of at most 22. Doubles hold both, so
 * that their product or quotient is rounded once, to what strtod finds (Clinger: How to read
 * floating point numbers accurately, 1990), in a fraction of the time. Returns 0 for any other
 * number, and where doubles are computed with more digits. */
static int read_short(const char *at, const char *end, double *number) {
    int is_negative = *at == '-', places = 0, exponent = 0;
    uint64_t digits = 0;
    at = read_digits(at + is_negative, end, &digits, &places);
    if (!at || FLT_EVAL_METHOD != 0) return 0;
    if (at < end) {
        int is_small = at[1] == '-';
        for (at += 1 + (at[1] == '-' || at[1] == '+'); at < end && exponent < 100; ++at)
            exponent = 10 * exponent + (*at - '0');
        if (is_small) exponent = -exponent;
    }
    exponent -= places;
    if (exponent < -22 || exponent > 22) return 0;
    *number = exponent < 0 ? (double)digits / powers_of_ten[-exponent]
                           : (double)digits * powers_of_ten[exponent];
    if (is_negative) *number = -*number;
    return 1;
}

/* Calls strtod, which expects the locale's decimal separator instead of the point; snprintf shows
 * which one that is. */
static double parse_number(const char *digits, size_t size, char *copy) {
    char sample[32], *out = copy;
    int sample_size = snprintf(sample, sizeof sample, "%.1f", 0.5);
    for (size_t i = 0; i < size; ++i) {
        if (digits[i] != '.') {
            *out++ = digits[i];
            continue;
        }
        for (int k = 1; k < sample_size - 1; ++k) *out++ = sample[k];
    }
    *out = 0;
    return strtod(copy, NULL);
}

psplat_result psplat_json_number(const psplat_json *json, psplat_json_value value, const char *what,
                                 double *out) {
    enum { MAX_DIGITS = 400 }; /* DBL_MAX written without an exponent has 309 */
    char copy[MAX_DIGITS + 32];
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_expect(json, value, PSPLAT_JSON_NUMBER, what);
    if (result) return result;
    const psplat_json_token *token = &json->tokens[value];
    size_t size = token->end - token->start;
    if (size > MAX_DIGITS)
        return psplat_fail(json->error, PSPLAT_ERROR_UNSUPPORTED, psplat_json_offset(json, value),
                           "%s is written with %zu characters, more than %d", what, size,
                           MAX_DIGITS);
    const char *text = json->text + token->start;
    double number;
    if (!read_short(text, text + size, &number)) number = parse_number(text, size, copy);
    if (!isfinite(number))
        return psplat_fail(json->error, PSPLAT_ERROR_RANGE, psplat_json_offset(json, value),
                           "%s is too large for a number", what);
    *out = number;
    return PSPLAT_OK;
}

psplat_result psplat_json_integer(const psplat_json *json, psplat_json_value value,
                                  const char *what, size_t max, size_t *out) {
    const double exact = 9007199254740992.0; /* 2^53: above it, doubles skip integers */
    double number = 0;
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_number(json, value, what, &number);
    if (result) return result;
    double limit = (double)max < exact ? (double)max : exact;
    if (!(number >= 0 && number <= limit) || number != floor(number))
        return psplat_fail(json->error, PSPLAT_ERROR_RANGE, psplat_json_offset(json, value),
                           "%s must be an integer from 0 to %.0f", what, limit);
    *out = (size_t)number;
    return PSPLAT_OK;
}

psplat_result psplat_json_boolean(const psplat_json *json, psplat_json_value value,
                                  const char *what, int *out) {
    if (!value) return PSPLAT_OK;
    char c = json->text[json->tokens[value].start];
    if (psplat_json_type_of(json, value) != PSPLAT_JSON_LITERAL || c == 'n')
        return psplat_fail(json->error, PSPLAT_ERROR_FORMAT, psplat_json_offset(json, value),
                           "%s must be true or false", what);
    *out = c == 't';
    return PSPLAT_OK;
}

psplat_result psplat_json_numbers(const psplat_json *json, psplat_json_value array,
                                  const char *what, size_t count, double *out) {
    if (!array) return PSPLAT_OK;
    psplat_result result = psplat_json_expect(json, array, PSPLAT_JSON_ARRAY, what);
    if (result) return result;
    if (psplat_json_length(json, array) != count)
        return psplat_fail(json->error, PSPLAT_ERROR_RANGE, psplat_json_offset(json, array),
                           "%s must have %zu numbers", what, count);
    psplat_json_value element = psplat_json_first(json, array);
    for (; element; element = psplat_json_next(json, array, element)) {
        result = psplat_json_number(json, element, what, out++);
        if (result) return result;
    }
    return PSPLAT_OK;
}
