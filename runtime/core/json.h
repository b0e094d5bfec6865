/* SPDX-License-Identifier: MIT
 *
 * json.h - strict JSON (RFC 8259). json_grammar.c reads the text once, checks it and makes tokens,
 * json.c walks them. Text and strings stay in place; what json.c is given is well-formed.
 */
#ifndef PHONGSPLAT_CORE_JSON_H
#define PHONGSPLAT_CORE_JSON_H

#include "core/arena.h"

/* Containers inside containers; glTF needs 7, extras of tools some more. */
#define PSPLAT_JSON_MAX_DEPTH 64

/* A value by its token's index. 0 is the document itself and, because the document is nobody's
 * member, also stands for a value that is absent. */
typedef uint32_t psplat_json_value;

typedef enum psplat_json_type {
    PSPLAT_JSON_OBJECT,
    PSPLAT_JSON_ARRAY,
    PSPLAT_JSON_STRING,
    PSPLAT_JSON_NUMBER,
    PSPLAT_JSON_LITERAL /* true, false, null */
} psplat_json_type;

/* Of a value or a key; that of a key encloses its value's. */
typedef struct psplat_json_token {
    uint32_t start,
        end;         /* in the text: its first byte and the one after it, with quotation marks */
    uint32_t length; /* members of an object, elements of an array; else 0 */
    uint32_t beyond; /* the first token after it and what it holds */
} psplat_json_token;

typedef struct psplat_json {
    const char *text; /* must outlive the document */
    size_t size;
    size_t base; /* offset of text in the file, for errors */
    psplat_json_token *tokens;
    psplat_error *error; /* where failing functions describe what is wrong; may be NULL */
} psplat_json;

/* Parses json->text, which is one well-formed object, into tokens that the arena owns. FORMAT,
 * UNSUPPORTED (nested too deep, more than 2 GiB), MEMORY. */
psplat_result psplat_json_parse(psplat_json *json, psplat_arena *arena);

/* Offset of a value's first byte in the file. */
size_t psplat_json_offset(const psplat_json *json, psplat_json_value value);
psplat_json_type psplat_json_type_of(const psplat_json *json, psplat_json_value value);

/* Elements of an array, members of an object. */
size_t psplat_json_length(const psplat_json *json, psplat_json_value value);

/* Elements of an array in order; 0 after the last. Of an object they are the keys, and the value of
 * a key is psplat_json_first of that key. */
psplat_json_value psplat_json_first(const psplat_json *json, psplat_json_value parent);
psplat_json_value psplat_json_next(const psplat_json *json, psplat_json_value parent,
                                   psplat_json_value child);

/* Whether a string, unescaped, equals, or begins with, a word of ASCII. */
int psplat_json_equals(const psplat_json *json, psplat_json_value string, const char *word);
int psplat_json_begins(const psplat_json *json, psplat_json_value string, const char *word);

/* values[i] becomes the member names[i] of an object, or 0; one pass over the object. FORMAT where
 * the value is no object or a name occurs twice. */
psplat_result psplat_json_members(const psplat_json *json, psplat_json_value object,
                                  const char *const *names, size_t count,
                                  psplat_json_value *values);

/* FORMAT unless value is absent or of the type. */
psplat_result psplat_json_expect(const psplat_json *json, psplat_json_value value,
                                 psplat_json_type type, const char *what);

/* Each leaves *out alone where value is absent, and fails with FORMAT on another type, RANGE where
 * the number does not fit. what names the property in the error. */
psplat_result psplat_json_number(const psplat_json *json, psplat_json_value value, const char *what,
                                 double *out);
psplat_result psplat_json_integer(const psplat_json *json, psplat_json_value value,
                                  const char *what, size_t max, size_t *out);
psplat_result psplat_json_boolean(const psplat_json *json, psplat_json_value value,
                                  const char *what, int *out);
psplat_result psplat_json_numbers(const psplat_json *json, psplat_json_value array,
                                  const char *what, size_t count, double *out);

/* The unescaped string, terminated, from the arena; *size is without the terminator. FORMAT on lone
 * surrogates and U+0000. */
psplat_result psplat_json_string(const psplat_json *json, psplat_json_value value,
                                 psplat_arena *arena, char **out, size_t *size);

#endif
