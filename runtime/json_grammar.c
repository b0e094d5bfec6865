/* SPDX-License-Identifier: MIT
 *
 * json_grammar.c - the grammar of RFC 8259, UTF-8 included, without recursion: one pass over the
 * bytes with a bit per open container. jsmn, which tokenises afterwards, accepts missing and
 * spare commas and colons, any word as a number, and bytes after the end.
 */
#include "json.h"

#include <string.h>

typedef enum expected {
    EXPECT_VALUE,
    EXPECT_VALUE_OR_END, /* just after [ */
    EXPECT_KEY,
    EXPECT_KEY_OR_END, /* just after { */
    EXPECT_COLON,
    EXPECT_COMMA_OR_END,
    EXPECT_NOTHING /* the document is complete */
} expected;

typedef struct grammar {
    const unsigned char *text;
    size_t size, at;
    size_t tokens;
    unsigned depth;
    uint64_t objects; /* bit d: the container at depth d is an object */
    expected state;
    psplat_result code;
} grammar;

_Static_assert(PSPLAT_JSON_MAX_DEPTH <= 64, "one bit of objects for each depth");

/* Past the end there is a byte that no rule accepts. */
static unsigned peek(const grammar *g) {
    return g->at < g->size ? g->text[g->at] : 0;
}

static int is_digit(unsigned c) {
    return c >= '0' && c <= '9';
}

static int is_hex(unsigned c) {
    return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

/* Each check returns NULL, or what is wrong at g->at. */

static const char *check_digits(grammar *g) {
    if (!is_digit(peek(g))) return "a number lacks a digit";
    while (is_digit(peek(g))) ++g->at;
    return NULL;
}

static const char *check_number(grammar *g) {
    const char *wrong = NULL;
    if (peek(g) == '-') ++g->at;
    if (peek(g) == '0') {
        ++g->at;
        if (is_digit(peek(g))) return "a number begins with 0";
    } else {
        wrong = check_digits(g);
    }
    if (!wrong && peek(g) == '.') {
        ++g->at;
        wrong = check_digits(g);
    }
    if (!wrong && (peek(g) == 'e' || peek(g) == 'E')) {
        ++g->at;
        if (peek(g) == '+' || peek(g) == '-') ++g->at;
        wrong = check_digits(g);
    }
    return wrong;
}

static const char *check_literal(grammar *g) {
    static const char *const literals[] = {"true", "false", "null"};
    for (size_t i = 0; i < 3; ++i) {
        size_t length = strlen(literals[i]);
        if (g->size - g->at < length || memcmp(g->text + g->at, literals[i], length)) continue;
        g->at += length;
        return NULL;
    }
    return "a value is expected";
}

/* Well-formed UTF-8 of two to four bytes (Unicode 15, table 3-7). */
static const char *check_utf8(grammar *g) {
    static const char wrong[] = "a string is not UTF-8";
    const unsigned char *s = g->text + g->at;
    size_t length = s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
    if (!length || g->size - g->at < length) return wrong;
    for (size_t i = 1; i < length; ++i)
        if ((s[i] & 0xc0) != 0x80) return wrong;
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f)) return wrong;
    if ((s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f)) return wrong;
    g->at += length;
    return NULL;
}

static const char *check_escape(grammar *g) {
    ++g->at;
    unsigned c = peek(g);
    if (!c || !strchr("\"\\/bfnrtu", (int)c)) return "an escape is unknown";
    ++g->at;
    if (c != 'u') return NULL;
    for (int i = 0; i < 4; ++i, ++g->at)
        if (!is_hex(peek(g))) return "\\u is not followed by four hexadecimal digits";
    return NULL;
}

static const char *check_string(grammar *g) {
    const char *wrong = NULL;
    ++g->at;
    while (!wrong) {
        unsigned c = peek(g);
        if (g->at == g->size) return "a string has no end";
        if (c < 0x20) return "a string holds a control character";
        if (c == '"') break;
        if (c == '\\')
            wrong = check_escape(g);
        else if (c >= 0x80)
            wrong = check_utf8(g);
        else
            ++g->at;
    }
    if (!wrong) ++g->at;
    return wrong;
}

static const char *open_container(grammar *g, int is_object) {
    if (g->depth == PSPLAT_JSON_MAX_DEPTH) {
        g->code = PSPLAT_ERROR_UNSUPPORTED;
        return "containers are nested more than 64 deep";
    }
    uint64_t bit = (uint64_t)1 << g->depth++;
    g->objects = is_object ? g->objects | bit : g->objects & ~bit;
    g->state = is_object ? EXPECT_KEY_OR_END : EXPECT_VALUE_OR_END;
    ++g->tokens;
    ++g->at;
    return NULL;
}

static int in_object(const grammar *g) {
    return g->depth && (g->objects >> (g->depth - 1) & 1);
}

static void close_container(grammar *g) {
    --g->depth;
    ++g->at;
    g->state = g->depth ? EXPECT_COMMA_OR_END : EXPECT_NOTHING;
}

static const char *check_value(grammar *g) {
    unsigned c = peek(g);
    if (c == '{') return open_container(g, 1);
    if (!g->depth) return "the document is not an object";
    if (c == '[') return open_container(g, 0);
    if (c == ']' && g->state == EXPECT_VALUE_OR_END) {
        close_container(g);
        return NULL;
    }
    ++g->tokens;
    g->state = EXPECT_COMMA_OR_END;
    if (c == '"') return check_string(g);
    return c == '-' || is_digit(c) ? check_number(g) : check_literal(g);
}

static const char *check_key(grammar *g) {
    if (peek(g) == '}' && g->state == EXPECT_KEY_OR_END) {
        close_container(g);
        return NULL;
    }
    if (peek(g) != '"') return "a key is expected";
    ++g->tokens;
    g->state = EXPECT_COLON;
    return check_string(g);
}

static const char *check_comma_or_end(grammar *g) {
    if (peek(g) == ',') {
        ++g->at;
        g->state = in_object(g) ? EXPECT_KEY : EXPECT_VALUE;
        return NULL;
    }
    if (peek(g) != (in_object(g) ? '}' : ']'))
        return in_object(g) ? "a comma or } is expected" : "a comma or ] is expected";
    close_container(g);
    return NULL;
}

static const char *check_next(grammar *g) {
    switch (g->state) {
    case EXPECT_VALUE:
    case EXPECT_VALUE_OR_END:
        return check_value(g);
    case EXPECT_KEY:
    case EXPECT_KEY_OR_END:
        return check_key(g);
    case EXPECT_COLON:
        if (peek(g) != ':') return "a colon is expected";
        ++g->at;
        g->state = EXPECT_VALUE;
        return NULL;
    case EXPECT_COMMA_OR_END:
        return check_comma_or_end(g);
    case EXPECT_NOTHING:
        break;
    }
    return "something follows the end of the document";
}

psplat_result psplat_json_check(const psplat_json *json, size_t *token_count) {
    grammar g = {
        .text = (const unsigned char *)json->text, .size = json->size, .code = PSPLAT_ERROR_FORMAT};
    const char *wrong = NULL;
    while (!wrong) {
        while (g.at < g.size && strchr(" \t\r\n", g.text[g.at]) && g.text[g.at]) ++g.at;
        if (g.at == g.size) {
            if (g.state == EXPECT_NOTHING) break;
            wrong = "the document ends early";
        } else {
            wrong = check_next(&g);
        }
    }
    *token_count = g.tokens;
    return wrong ? psplat_fail(json->error, g.code, json->base + g.at, "JSON: %s", wrong)
                 : PSPLAT_OK;
}
