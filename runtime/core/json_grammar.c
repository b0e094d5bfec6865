/* SPDX-License-Identifier: MIT
 *
 * json_grammar.c - the grammar of RFC 8259, UTF-8 included. It goes over the bytes once, without
 * recursion, and makes a token for each value and key.
 */
#include "core/json.h"

#include "core/memory.h"

#include <limits.h>
#include <string.h>

typedef struct reader {
    const unsigned char *text;
    size_t size, at;
    const psplat_allocator *allocator;
    psplat_json_token *tokens;
    size_t count, capacity;
    uint32_t open[PSPLAT_JSON_MAX_DEPTH]; /* tokens of the containers around the reader, outermost
                                             first */
    size_t depth;
    psplat_result code; /* the error code that belongs to the message returned */
} reader;

/* Past the end it returns a byte that no rule accepts. */
static unsigned peek(const reader *r) {
    return r->at < r->size ? r->text[r->at] : 0;
}

/* Returns the first byte after white space. */
static unsigned skip_space(reader *r) {
    while (peek(r) == ' ' || peek(r) == '\n' || peek(r) == '\r' || peek(r) == '\t') ++r->at;
    return peek(r);
}

static int is_digit(unsigned c) {
    return c >= '0' && c <= '9';
}

static int is_hex(unsigned c) {
    return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

/* The functions below return NULL, or a message that says what is wrong at r->at. */

static const char *read_digits(reader *r) {
    if (!is_digit(peek(r))) return "a number lacks a digit";
    while (is_digit(peek(r))) ++r->at;
    return NULL;
}

static const char *read_number(reader *r) {
    const char *wrong = NULL;
    if (peek(r) == '-') ++r->at;
    if (peek(r) == '0') {
        ++r->at;
        if (is_digit(peek(r))) return "a number begins with 0";
    } else {
        wrong = read_digits(r);
    }
    if (!wrong && peek(r) == '.') {
        ++r->at;
        wrong = read_digits(r);
    }
    if (!wrong && (peek(r) == 'e' || peek(r) == 'E')) {
        ++r->at;
        if (peek(r) == '+' || peek(r) == '-') ++r->at;
        wrong = read_digits(r);
    }
    return wrong;
}

static const char *read_literal(reader *r) {
    static const char *const literals[] = {"true", "false", "null"};
    for (size_t i = 0; i < 3; ++i) {
        size_t length = strlen(literals[i]);
        if (r->size - r->at < length || memcmp(r->text + r->at, literals[i], length)) continue;
        r->at += length;
        return NULL;
    }
    return "a value is expected";
}

/* Accepts well-formed UTF-8 of two to four bytes (Unicode 15, table 3-7). */
static const char *read_utf8(reader *r) {
    static const char wrong[] = "a string is not UTF-8";
    const unsigned char *s = r->text + r->at;
    size_t length = s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
    if (!length || r->size - r->at < length) return wrong;
    for (size_t i = 1; i < length; ++i)
        if ((s[i] & 0xc0) != 0x80) return wrong;
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f)) return wrong;
    if ((s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f)) return wrong;
    r->at += length;
    return NULL;
}

static const char *read_escape(reader *r) {
    ++r->at;
    unsigned c = peek(r);
    if (!c || !strchr("\"\\/bfnrtu", (int)c)) return "an escape is unknown";
    ++r->at;
    if (c != 'u') return NULL;
    for (int i = 0; i < 4; ++i, ++r->at)
        if (!is_hex(peek(r))) return "\\u is not followed by four hexadecimal digits";
    return NULL;
}

static const char *read_string(reader *r) {
    const char *wrong = NULL;
    ++r->at;
    while (!wrong && peek(r) != '"') {
        if (peek(r) < 0x20) return "a string holds a control character";
        if (peek(r) == '\\')
            wrong = read_escape(r);
        else if (peek(r) >= 0x80)
            wrong = read_utf8(r);
        else
            ++r->at;
    }
    if (!wrong) ++r->at;
    return wrong;
}

/* ---- tokens ------------------------------------------------------------------------------- */

static const char *begin_token(reader *r) {
    enum { EACH = sizeof *r->tokens };
    if (r->count == r->capacity) {
        size_t capacity = 2 * r->capacity + 64;
        psplat_json_token *tokens = NULL;
        if (capacity <= SIZE_MAX / EACH)
            tokens = psplat_resize(r->allocator, r->tokens, r->capacity * EACH, capacity * EACH);
        if (!tokens) {
            r->code = PSPLAT_ERROR_MEMORY;
            return "no memory for its values";
        }
        r->tokens = tokens;
        r->capacity = capacity;
    }
    r->tokens[r->count++] = (psplat_json_token){.start = (uint32_t)r->at};
    return NULL;
}

static psplat_json_token *container(const reader *r) {
    return r->depth ? &r->tokens[r->open[r->depth - 1]] : NULL;
}

static int in_object(const reader *r) {
    return r->depth && r->text[container(r)->start] == '{';
}

/* Ends a value here, and with it the key before it, which encloses it. */
static void end_value(reader *r, size_t token) {
    r->tokens[token].end = (uint32_t)r->at;
    r->tokens[token].beyond = (uint32_t)r->count;
    if (in_object(r)) r->tokens[token - 1].beyond = (uint32_t)r->count;
}

static const char *read_key(reader *r) {
    if (skip_space(r) != '"') return "a key is expected";
    const char *wrong = begin_token(r);
    if (!wrong) wrong = read_string(r);
    if (wrong) return wrong;
    r->tokens[r->count - 1].end = (uint32_t)r->at;
    if (skip_space(r) != ':') return "a colon is expected";
    ++r->at;
    return NULL;
}

/* Reads a string, number or literal, or the opening bracket of a container. */
static const char *read_value(reader *r) {
    unsigned c = skip_space(r);
    int is_container = c == '{' || c == '[';
    if (is_container && r->depth == PSPLAT_JSON_MAX_DEPTH) {
        r->code = PSPLAT_ERROR_UNSUPPORTED;
        return "containers are nested more than 64 deep";
    }
    size_t token = r->count;
    const char *wrong = begin_token(r);
    if (wrong) return wrong;
    if (is_container) {
        r->open[r->depth++] = (uint32_t)token;
        ++r->at;
        return NULL;
    }
    wrong = c == '"' ? read_string(r) : c == '-' || is_digit(c) ? read_number(r) : read_literal(r);
    end_value(r, token);
    return wrong;
}

/* Reads the next member or element of the innermost container, or that container's end. */
static const char *read_next(reader *r) {
    int is_object = in_object(r);
    unsigned c = skip_space(r);
    if (c == (is_object ? '}' : ']')) {
        ++r->at;
        --r->depth;
        end_value(r, r->open[r->depth]);
        return NULL;
    }
    if (container(r)->length++) {
        if (c != ',') return is_object ? "a comma or } is expected" : "a comma or ] is expected";
        ++r->at;
    }
    const char *wrong = is_object ? read_key(r) : NULL;
    return wrong ? wrong : read_value(r);
}

static const char *read_document(reader *r) {
    if (skip_space(r) != '{') return "the document is not an object";
    const char *wrong = read_value(r);
    while (!wrong && r->depth) wrong = read_next(r);
    if (wrong) return wrong;
    skip_space(r);
    return r->at < r->size ? "something follows the end of the document" : NULL;
}

psplat_result psplat_json_parse(psplat_json *json, psplat_arena *arena) {
    reader r = {.text = (const unsigned char *)json->text,
                .size = json->size,
                .allocator = &arena->allocator,
                .code = PSPLAT_ERROR_FORMAT};
    if (json->size > INT_MAX)
        return psplat_fail(json->error, PSPLAT_ERROR_UNSUPPORTED, json->base,
                           "JSON: %zu bytes are more than 2 GiB", json->size);
    const char *wrong = read_document(&r);
    json->tokens = r.tokens;
    if (psplat_arena_adopt(arena, r.tokens, r.capacity * sizeof *r.tokens))
        return psplat_fail(json->error, PSPLAT_ERROR_MEMORY, json->base, "no memory for JSON");
    if (wrong && r.at == r.size) wrong = "the document ends early";
    return wrong ? psplat_fail(json->error, r.code, json->base + r.at, "JSON: %s", wrong)
                 : PSPLAT_OK;
}
