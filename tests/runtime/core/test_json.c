/* SPDX-License-Identifier: MIT
 *
 * test_json.c - tests the strict JSON reader on short texts: accepted ones with their values, and
 * each rejected one with its code and the offset of the byte at fault (RFC 8259).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "core/json.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>

typedef struct document {
    psplat_arena arena;
    psplat_json json;
    psplat_error error;
} document;

enum { BASE = 1000 }; /* where the text begins in its file */

static psplat_result parse_bytes(document *d, const char *text, size_t size) {
    /* A copy of exactly the text's size makes AddressSanitizer see a read beyond its end. */
    char *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, text, size);
    memset(d, 0, sizeof *d);
    d->arena.allocator = psplat_allocator_default(NULL);
    d->json = (psplat_json){.text = copy, .size = size, .base = BASE, .error = &d->error};
    return psplat_json_parse(&d->json, &d->arena);
}

static void parse(document *d, const char *text) {
    psplat_result result = parse_bytes(d, text, strlen(text));
    if (result) fail_msg("%s: %s (%zu)", text, d->error.text, d->error.offset);
}

static void done(document *d) {
    psplat_arena_release(&d->arena);
    free((void *)(uintptr_t)d->json.text);
}

static psplat_json_value member(const document *d, const char *name) {
    psplat_json_value value = 0;
    assert_int_equal(psplat_json_members(&d->json, 0, &name, 1, &value), PSPLAT_OK);
    return value;
}

/* ---- grammar ------------------------------------------------------------------------------ */

static void test_accepts(void **state) {
    (void)state;
    static const char *const texts[] = {
        "{}",
        " \t\r\n{ } \n",
        "{\"a\":[]}",
        "{\"a\":[1,-0,0.5,-1e5,1E+5,2e-7,10]}",
        "{\"a\":{\"b\":{\"c\":null}},\"d\":[true,false,null]}",
        "{\"\":\"\"}",
        "{\"\\u00e9\\n\\\"\\\\\\/\":\"\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80\"}",
        "{\"a\":[[[]],{},[{}]]}",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        document d;
        parse(&d, texts[i]);
        done(&d);
    }
}

static void test_rejects(void **state) {
    (void)state;
    /* offset is that of the first byte that cannot be right, or of the word that contains it. */
    static const struct {
        const char *text;
        size_t offset;
    } cases[] = {
        {"", 0},
        {"  ", 2},
        {"[]", 0},
        {"1", 0},
        {"\xef\xbb\xbf{}", 0}, /* a byte order mark */
        {"{", 1},
        {"}", 0},
        {"{}}", 2},
        {"{}{}", 2},
        {"{} x", 3},
        {"{,}", 1},
        {"{\"a\"}", 4},
        {"{\"a\" 1}", 5},
        {"{\"a\":}", 5},
        {"{\"a\":1,}", 7},
        {"{\"a\":1 \"b\":2}", 7},
        {"{\"a\":1;\"b\":2}", 6},
        {"{\"a\"::1}", 5},
        {"{a:1}", 1},
        {"{'a':1}", 1},
        {"{1:1}", 1},
        {"{\"a\":[1,]}", 8},
        {"{\"a\":[,1]}", 6},
        {"{\"a\":[1 2]}", 8},
        {"{\"a\":[1}", 7},
        {"{\"a\":{\"b\":1]", 11},
        {"{\"a\":[1:2]}", 7},
        {"{\"a\":01}", 6},
        {"{\"a\":+1}", 5},
        {"{\"a\":-}", 6},
        {"{\"a\":.5}", 5},
        {"{\"a\":1.}", 7},
        {"{\"a\":1.e3}", 7},
        {"{\"a\":1e}", 7},
        {"{\"a\":1e+}", 8},
        {"{\"a\":1x}", 6},
        {"{\"a\":0x10}", 6},
        {"{\"a\":1", 6},
        {"{\"a\":NaN}", 5},
        {"{\"a\":Infinity}", 5},
        {"{\"a\":True}", 5},
        {"{\"a\":tru}", 5},
        {"{\"a\":truex}", 9},
        {"{\"a\":nul", 5},
        {"{\"a\":/*x*/1}", 5},
        {"{\"a\":\"x", 7},
        {"{\"a\":\"\\", 7},
        {"{\"a\":\"\\x\"}", 7},
        {"{\"a\":\"\\u12g4\"}", 10},
        {"{\"a\":\"\\u12", 10},
        {"{\"a\":\"\n\"}", 6},
        {"{\"a\":\"\x01\"}", 6},
        {"{\"a\":\"\x80\"}", 6},             /* a continuation byte alone */
        {"{\"a\":\"\xc0\xaf\"}", 6},         /* overlong, two bytes */
        {"{\"a\":\"\xe0\x80\x80\"}", 6},     /* overlong, three */
        {"{\"a\":\"\xed\xa0\x80\"}", 6},     /* a surrogate */
        {"{\"a\":\"\xf0\x80\x80\x80\"}", 6}, /* overlong, four */
        {"{\"a\":\"\xf4\x90\x80\x80\"}", 6}, /* beyond U+10FFFF */
        {"{\"a\":\"\xf5\x80\x80\x80\"}", 6},
        {"{\"a\":\"\xc3\"}", 6},
        {"{\"a\":\"\xe2\x82", 6},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        document d;
        psplat_result result = parse_bytes(&d, cases[i].text, strlen(cases[i].text));
        if (result != PSPLAT_ERROR_FORMAT || d.error.offset != BASE + cases[i].offset)
            fail_msg("%s: result %d at %zu, expected FORMAT at %zu", cases[i].text, result,
                     d.error.offset - BASE, cases[i].offset);
        done(&d);
    }
}

static void test_zero_bytes(void **state) {
    (void)state;
    static const char in_space[] = "{\0}", in_string[] = "{\"a\0\":1}", at_end[] = "{}\0";
    document d;
    assert_int_equal(parse_bytes(&d, in_space, 3), PSPLAT_ERROR_FORMAT);
    assert_int_equal(d.error.offset, BASE + 1);
    done(&d);
    assert_int_equal(parse_bytes(&d, in_string, 8), PSPLAT_ERROR_FORMAT);
    assert_int_equal(d.error.offset, BASE + 3);
    done(&d);
    assert_int_equal(parse_bytes(&d, at_end, 3), PSPLAT_ERROR_FORMAT);
    assert_int_equal(d.error.offset, BASE + 2);
    done(&d);
}

/* Writes depth nested containers, the outermost of which is the document. */
static void make_nest(char *text, int depth) {
    char *out = text + sprintf(text, "{\"a\":");
    for (int i = 1; i < depth; ++i) *out++ = '[';
    for (int i = 1; i < depth; ++i) *out++ = ']';
    strcpy(out, "}");
}

static void test_depth(void **state) {
    (void)state;
    char text[4 * PSPLAT_JSON_MAX_DEPTH];
    document d;
    make_nest(text, PSPLAT_JSON_MAX_DEPTH);
    parse(&d, text);
    done(&d);
    make_nest(text, PSPLAT_JSON_MAX_DEPTH + 1);
    assert_int_equal(parse_bytes(&d, text, strlen(text)), PSPLAT_ERROR_UNSUPPORTED);
    assert_int_equal(d.error.offset, BASE + 5 + PSPLAT_JSON_MAX_DEPTH - 1);
    done(&d);
}

/* ---- values ------------------------------------------------------------------------------- */

static void test_walk(void **state) {
    (void)state;
    document d;
    parse(&d, "{\"a\":[[1,2],{\"x\":[3]},4,[]],\"b\":5}");
    psplat_json_value a = member(&d, "a"), b = member(&d, "b");
    assert_int_equal(psplat_json_length(&d.json, a), 4);
    static const psplat_json_type types[] = {PSPLAT_JSON_ARRAY, PSPLAT_JSON_OBJECT,
                                             PSPLAT_JSON_NUMBER, PSPLAT_JSON_ARRAY};
    static const size_t offsets[] = {6, 12, 22, 24};
    psplat_json_value value = psplat_json_first(&d.json, a);
    for (size_t i = 0; i < 4; ++i) {
        assert_int_not_equal(value, 0);
        assert_int_equal(psplat_json_type_of(&d.json, value), types[i]);
        assert_int_equal(psplat_json_offset(&d.json, value), BASE + offsets[i]);
        if (i == 3) assert_int_equal(psplat_json_first(&d.json, value), 0);
        value = psplat_json_next(&d.json, a, value);
    }
    assert_int_equal(value, 0);
    assert_int_equal(psplat_json_offset(&d.json, b), BASE + 32);
    done(&d);
}

static void test_members(void **state) {
    (void)state;
    static const char *const names[] = {"b", "a", "c"};
    psplat_json_value values[3];
    document d;
    parse(&d, "{\"\\u0061\":1,\"b\":{\"a\":2},\"A\":3,\"ab\":4,\"\":5}");
    assert_int_equal(psplat_json_members(&d.json, 0, names, 3, values), PSPLAT_OK);
    assert_int_equal(psplat_json_type_of(&d.json, values[0]), PSPLAT_JSON_OBJECT);
    assert_int_equal(psplat_json_offset(&d.json, values[1]), BASE + 10);
    assert_int_equal(values[2], 0);
    psplat_json_value number = values[1];
    assert_int_equal(psplat_json_members(&d.json, number, names, 3, values), PSPLAT_ERROR_FORMAT);
    assert_int_equal(d.error.offset, BASE + 10);
    done(&d);

    parse(&d, "{\"a\":1,\"b\":2,\"\\u0061\":3}");
    assert_int_equal(psplat_json_members(&d.json, 0, names, 3, values), PSPLAT_ERROR_FORMAT);
    assert_int_equal(d.error.offset, BASE + 13);
    assert_non_null(strstr(d.error.text, "'a' occurs twice"));
    done(&d);
}

static void check_number(const char *text, double expected) {
    char json[600];
    double number = -1;
    document d;
    snprintf(json, sizeof json, "{\"n\":%s}", text);
    parse(&d, json);
    assert_int_equal(psplat_json_number(&d.json, member(&d, "n"), "n", &number), PSPLAT_OK);
    if (number != expected) fail_msg("%s reads as %.17g", text, number);
    done(&d);
}

static void check_numbers(void) {
    check_number("0", 0);
    check_number("-0.5", -0.5);
    check_number("1e3", 1000);
    check_number("0.1", 0.1);
    check_number("123456789.015625", 123456789.015625); /* exact in binary */
    check_number("2.2250738585072014e-308", 2.2250738585072014e-308);
    check_number("1.7976931348623157e308", 1.7976931348623157e308);
    check_number("1e-400", 0);
}

static void test_numbers(void **state) {
    (void)state;
    check_numbers();
}

/* Writes a number of up to 18 digits with a point anywhere and an exponent of up to 30, or neither.
 */
static void random_number(uint32_t *random, char text[64]) {
    uint32_t values[4];
    for (int i = 0; i < 4; ++i) values[i] = *random = *random * 1664525u + 1013904223u;
    uint64_t digits = ((uint64_t)values[0] << 32 | values[1]) >> (4 + values[3] / 71582789u);
    char written[32];
    int count = snprintf(written, sizeof written, "%llu", (unsigned long long)digits);
    int point = (int)(values[2] >> 8) % (count + 1);
    snprintf(text, 64, "%s%.*s%s%s", values[2] & 1 ? "-" : "", point, written,
             point == 0      ? "0."
             : point < count ? "."
                             : "",
             written + point);
    if (values[2] & 2)
        snprintf(text + strlen(text), 16, "%c%s%u", values[2] & 4 ? 'e' : 'E',
                 values[2] & 8    ? "-"
                 : values[2] & 16 ? "+"
                                  : "",
                 (values[2] >> 24) % 31);
}

/* Numbers that the reader takes a short way for are those of strtod, to the last bit. */
static void test_random_numbers(void **state) {
    (void)state;
    uint32_t random = 3;
    for (int i = 0; i < 20000; ++i) {
        char text[64], document_text[80];
        document d;
        double number = -1;
        random_number(&random, text);
        double expected = strtod(text, NULL);
        snprintf(document_text, sizeof document_text, "{\"n\":%s}", text);
        parse(&d, document_text);
        assert_int_equal(psplat_json_number(&d.json, member(&d, "n"), "n", &number), PSPLAT_OK);
        if (memcmp(&number, &expected, sizeof number)) fail_msg("%s: %.17g", text, number);
        done(&d);
    }
    check_number("-0", 0);
    check_number("0e500", 0);
    check_number("999999999999999e22", 999999999999999e22);
    check_number("9007199254740993", 9007199254740992.0); /* halfway: to even */
}

/* Under a locale with a decimal comma strtod stops at the point; the reader must not. The test is
 * skipped where the machine lacks that locale, because C.UTF-8 would show nothing. */
static void test_numbers_with_comma(void **state) {
    (void)state;
    static const char *const locales[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    const char *set = NULL;
    for (size_t i = 0; i < 4 && !set; ++i) set = setlocale(LC_NUMERIC, locales[i]);
    if (!set) skip();
    check_numbers();
    setlocale(LC_NUMERIC, "C");
}

static void test_number_limits(void **state) {
    (void)state;
    char text[1000];
    double number = -1;
    document d;
    parse(&d, "{\"n\":-1e999}");
    assert_int_equal(psplat_json_number(&d.json, member(&d, "n"), "n", &number),
                     PSPLAT_ERROR_RANGE);
    assert_int_equal(d.error.offset, BASE + 5);
    done(&d);

    size_t size = (size_t)sprintf(text, "{\"n\":");
    memset(text + size, '1', 500);
    strcpy(text + size + 500, "}");
    parse(&d, text);
    assert_int_equal(psplat_json_number(&d.json, member(&d, "n"), "n", &number),
                     PSPLAT_ERROR_UNSUPPORTED);
    assert_int_equal(d.error.offset, BASE + 5);
    assert_true(number == -1);
    done(&d);
}

static void check_integer(const char *text, size_t max, psplat_result expected, size_t value) {
    char json[64];
    size_t integer = 77;
    document d;
    snprintf(json, sizeof json, "{\"n\":%s}", text);
    parse(&d, json);
    psplat_result result = psplat_json_integer(&d.json, member(&d, "n"), "n", max, &integer);
    if (result != expected) fail_msg("%s up to %zu gives %d", text, max, result);
    assert_int_equal(integer, result ? 77 : value);
    if (result) assert_int_equal(d.error.offset, BASE + 5);
    done(&d);
}

static void test_integers(void **state) {
    (void)state;
    check_integer("0", 0, PSPLAT_OK, 0);
    check_integer("-0", 0, PSPLAT_OK, 0);
    check_integer("7", 7, PSPLAT_OK, 7);
    check_integer("1e2", 100, PSPLAT_OK, 100);
    check_integer("8", 7, PSPLAT_ERROR_RANGE, 0);
    check_integer("-1", 7, PSPLAT_ERROR_RANGE, 0);
    check_integer("0.5", 7, PSPLAT_ERROR_RANGE, 0);
    check_integer("9007199254740992", SIZE_MAX, PSPLAT_OK, (size_t)9007199254740992);
    check_integer("9007199254740994", SIZE_MAX, PSPLAT_ERROR_RANGE, 0);
    check_integer("18446744073709551616", SIZE_MAX, PSPLAT_ERROR_RANGE, 0);
    check_integer("1e308", SIZE_MAX, PSPLAT_ERROR_RANGE, 0);
    check_integer("\"1\"", 7, PSPLAT_ERROR_FORMAT, 0);
    check_integer("null", 7, PSPLAT_ERROR_FORMAT, 0);
}

static void test_other_types(void **state) {
    (void)state;
    int flag = 9;
    double numbers[3] = {0, 0, 0};
    document d;
    parse(&d, "{\"t\":true,\"f\":false,\"n\":null,\"a\":[1,2,3],\"b\":[1,\"2\",3]}");
    assert_int_equal(psplat_json_boolean(&d.json, member(&d, "t"), "t", &flag), PSPLAT_OK);
    assert_int_equal(flag, 1);
    assert_int_equal(psplat_json_boolean(&d.json, member(&d, "f"), "f", &flag), PSPLAT_OK);
    assert_int_equal(flag, 0);
    assert_int_equal(psplat_json_boolean(&d.json, member(&d, "n"), "n", &flag),
                     PSPLAT_ERROR_FORMAT);
    assert_int_equal(psplat_json_numbers(&d.json, member(&d, "a"), "a", 3, numbers), PSPLAT_OK);
    assert_true(numbers[0] == 1 && numbers[1] == 2 && numbers[2] == 3);
    assert_int_equal(psplat_json_numbers(&d.json, member(&d, "a"), "a", 2, numbers),
                     PSPLAT_ERROR_RANGE);
    assert_int_equal(psplat_json_numbers(&d.json, member(&d, "b"), "b", 3, numbers),
                     PSPLAT_ERROR_FORMAT);
    assert_int_equal(psplat_json_numbers(&d.json, 0, "absent", 3, numbers), PSPLAT_OK);
    done(&d);
}

static void check_string(const char *text, const char *expected, size_t wrong_at) {
    char json[128];
    char *string = NULL;
    size_t size = 0;
    document d;
    snprintf(json, sizeof json, "{\"s\":\"%s\"}", text);
    parse(&d, json);
    psplat_result result = psplat_json_string(&d.json, member(&d, "s"), &d.arena, &string, &size);
    assert_int_equal(result, expected ? PSPLAT_OK : PSPLAT_ERROR_FORMAT);
    if (expected) {
        assert_string_equal(string, expected);
        assert_int_equal(size, strlen(expected));
    } else {
        assert_int_equal(d.error.offset, BASE + 6 + wrong_at);
    }
    done(&d);
}

static void test_strings(void **state) {
    (void)state;
    check_string("", "", 0);
    check_string("a\\/b\\\\c\\\"\\b\\f\\n\\r\\t", "a/b\\c\"\b\f\n\r\t", 0);
    check_string("\\u0041\\u00e9\\u20ac", "A\xc3\xa9\xe2\x82\xac", 0);
    check_string("\\ud83d\\ude00!", "\xf0\x9f\x98\x80!", 0);
    check_string("x\\ud83d", NULL, 1);
    check_string("x\\ud83dy", NULL, 1);
    check_string("\\ud83d\\u0041", NULL, 0);
    check_string("\\ude00", NULL, 0);
    check_string("ab\\u0000", NULL, 2);
}

int test_json_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_accepts),
        cmocka_unit_test(test_rejects),
        cmocka_unit_test(test_zero_bytes),
        cmocka_unit_test(test_depth),
        cmocka_unit_test(test_walk),
        cmocka_unit_test(test_members),
        cmocka_unit_test(test_random_numbers),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_numbers_with_comma),
        cmocka_unit_test(test_number_limits),
        cmocka_unit_test(test_integers),
        cmocka_unit_test(test_other_types),
        cmocka_unit_test(test_strings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
