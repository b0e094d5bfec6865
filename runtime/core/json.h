/* SPDX-License-Identifier: MIT
 *
 * json.h - strict JSON (RFC 8259). json_grammar.c reads the text once, checks it and makes tokens;
 * json.c walks the tokens. The text and its strings stay in place. The functions of json.c rely on
 * a document that psplat_json_parse has accepted.
 */
#ifndef PHONGSPLAT_CORE_JSON_H
#define PHONGSPLAT_CORE_JSON_H

#include "core/arena.h"

/* The deepest nesting of containers that is read. glTF needs 7; the extras that tools write need
 * some more. */
#define PSPLAT_JSON_MAX_DEPTH 64

/* A value is named by its token's index. Index 0 is the document itself; as the document is
 * nobody's member, 0 also stands for a value that is absent. */
typedef uint32_t psplat_json_value;

typedef enum psplat_json_type {
    PSPLAT_JSON_OBJECT,
    PSPLAT_JSON_ARRAY,
    PSPLAT_JSON_STRING,
    PSPLAT_JSON_NUMBER,
    PSPLAT_JSON_LITERAL /* true, false, null */
} psplat_json_type;

/* The token of a value or of a key. The token of a key encloses that of its value. */
typedef struct psplat_json_token {
    uint32_t start,
        end; /* in the text: the first byte and the one after the last, quotation marks included */
    uint32_t length; /* members of an object, elements of an array, 0 for other values */
    uint32_t beyond; /* index of the first token that is not inside this value */
} psplat_json_token;

typedef struct psplat_json {
    const char *text; /* must outlive the document */
    size_t size;
    size_t base; /* offset of text in the file, added to offsets in errors */
    psplat_json_token *tokens;
    psplat_error *error; /* where failing functions describe what is wrong; may be NULL */
} psplat_json;

/* Parses json->text, which must be one object, into tokens that the arena owns. Fails with FORMAT
 * where the text is no well-formed JSON, UNSUPPORTED where it is nested too deep or larger than 2
 * GiB, and MEMORY. */
psplat_result psplat_json_parse(psplat_json *json, psplat_arena *arena);

/* Returns the offset of a value's first byte in the file. */
size_t psplat_json_offset(const psplat_json *json, psplat_json_value value);
psplat_json_type psplat_json_type_of(const psplat_json *json, psplat_json_value value);

/* Returns the number of elements of an array or of members of an object. */
size_t psplat_json_length(const psplat_json *json, psplat_json_value value);

/* These two walk the elements of an array in order and return 0 after the last. The elements of an
 * object are its keys; the value of a key is psplat_json_first of that key. */
psplat_json_value psplat_json_first(const psplat_json *json, psplat_json_value parent);
psplat_json_value psplat_json_next(const psplat_json *json, psplat_json_value parent,
                                   psplat_json_value child);

/* Returns whether a string, once unescaped, equals (or begins with) an ASCII word. */
int psplat_json_equals(const psplat_json *json, psplat_json_value string, const char *word);
int psplat_json_begins(const psplat_json *json, psplat_json_value string, const char *word);

/* Sets values[i] to the member names[i] of an object, or to 0 where it has none, in one pass over
 * the object. Fails with FORMAT where the value is no object or where a name occurs twice. */
psplat_result psplat_json_members(const psplat_json *json, psplat_json_value object,
                                  const char *const *names, size_t count,
                                  psplat_json_value *values);

/* Fails with FORMAT unless value is absent or of the type. */
psplat_result psplat_json_expect(const psplat_json *json, psplat_json_value value,
                                 psplat_json_type type, const char *what);

/* Each of these leaves *out as it is where value is absent. Each fails with FORMAT where value has
 * another type and with RANGE where the number does not fit. The error's text names the property by
 * what. */
psplat_result psplat_json_number(const psplat_json *json, psplat_json_value value, const char *what,
                                 double *out);
psplat_result psplat_json_integer(const psplat_json *json, psplat_json_value value,
                                  const char *what, size_t max, size_t *out);
psplat_result psplat_json_boolean(const psplat_json *json, psplat_json_value value,
                                  const char *what, int *out);
psplat_result psplat_json_numbers(const psplat_json *json, psplat_json_value array,
                                  const char *what, size_t count, double *out);

/* Stores the unescaped string, terminated by a zero byte that *size does not count, in the arena.
 * Fails with FORMAT on lone surrogates and on U+0000. */
psplat_result psplat_json_string(const psplat_json *json, psplat_json_value value,
                                 psplat_arena *arena, char **out, size_t *size);

#endif
