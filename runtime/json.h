/* SPDX-License-Identifier: MIT
 *
 * json.h - strict JSON (RFC 8259) over jsmn. json_grammar.c checks what jsmn lets pass and counts
 * the tokens, jsmn fills exactly that many, json.c walks them. Text, tokens and strings stay in
 * place; nothing is trusted because nothing invalid gets past the grammar.
 */
#ifndef PHONGSPLAT_JSON_H
#define PHONGSPLAT_JSON_H

#include "arena.h"

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

typedef struct psplat_json {
    const char *text; /* must outlive the document */
    size_t size;
    size_t base; /* offset of text in the file, for errors */
    struct psplat_json_token *tokens;
    psplat_error *error; /* where failing functions describe what is wrong; may be NULL */
} psplat_json;

/* json_grammar.c: FORMAT or UNSUPPORTED unless text is one well-formed object. */
psplat_result psplat_json_check(const psplat_json *json, size_t *token_count);

/* Parses json->text; tokens come from the arena. FORMAT, UNSUPPORTED, MEMORY. */
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
