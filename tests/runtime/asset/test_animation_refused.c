/* SPDX-License-Identifier: MIT
 *
 * test_animation_refused.c - tests what the reader refuses of animations: a document with one thing
 * changed, each with the expected error code and the offset of the byte at fault, and files made to
 * use up memory.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"
#include "ledger.h"
#include "moving.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>

#define FORMAT PSPLAT_ERROR_FORMAT
#define RANGE PSPLAT_ERROR_RANGE
#define UNSUPPORTED PSPLAT_ERROR_UNSUPPORTED

static const char nodes[] =
    "{\"children\":[1,2]},{\"mesh\":0},{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}";
static const char animation[] =
    "{\"name\":\"a\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}},"
    "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"scale\"}}],\"samplers\":["
    "{\"input\":16,\"output\":17,\"interpolation\":\"LINEAR\"},{\"input\":16,\"output\":18}]}";

/* Returns the document, which opens: a rotation and a scale at three times. */
static char *document_of(const float times[3], const float rotations[12], const float scales[9]) {
    moving m = {0};
    moving_floats(&m, times, 3, 1);
    moving_floats(&m, rotations, 3, 4);
    moving_floats(&m, scales, 3, 3);
    return moving_text(&m, PSPLAT_SOURCE_DIR, nodes, animation);
}

static const float times[3] = {0, 1, 2}, rotations[12] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0},
                   scales[9] = {1, 1, 1, 0, 0, 0, -1, -1, -1};

static void expect(const char *text, psplat_result code, size_t offset, const char *said) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    psplat_asset_destroy(asset);
    if (result != code || (code && (error.offset != offset || !strstr(error.text, said))))
        fail_msg("%s: %s at %zu, expected %s: %s at %zu", psplat_result_text(result), error.text,
                 error.offset, psplat_result_text(code), said, offset);
}

static void test_opens(void **state) {
    (void)state;
    char *text = document_of(times, rotations, scales);
    expect(text, PSPLAT_OK, 0, "");
    free(text);
}

/* What is wrong in the structure of a document, and what is said of it. */
static const struct {
    const char *from, *to, *at;
    psplat_result code;
    const char *said;
} structures[] = {
    {"\"animations\":[{", "\"animations\":3,\"x\":[{", "3,\"x\"", FORMAT, "animations must be"},
    {"\"animations\":[", "\"animations\":[7,", "7,{", FORMAT, ""},
    {"\"name\":\"a\"", "\"name\":1", "1,\"channels\"", FORMAT, "name must be"},
    {"\"channels\":[", "\"channels\":{},\"x\":[", "{},\"x\"", FORMAT, "channels must be"},
    {"\"samplers\":[", "\"samplers\":1,\"x\":[", "1,\"x\"", FORMAT, "samplers must be"},
    {"\"samplers\":[", "\"x\":[", "0,\"target\"", RANGE, "index into nothing"},
    {"\"sampler\":0", "\"sampler\":2", "2,\"target\"", RANGE, "sampler"},
    {"\"sampler\":0", "\"sampler\":-1", "-1,\"target\"", RANGE, "sampler"},
    {"\"sampler\":0,", "", "{\"target\"", FORMAT, "sampler is missing"},
    {"\"target\":{", "\"x\":{", "{\"sampler\":0", FORMAT, "target is missing"},
    {"\"target\":{", "\"target\":[],\"x\":{", "[],\"x\"", FORMAT, ""},
    {"\"node\":0,\"path\"", "\"node\":3,\"path\"", "3,\"path\"", RANGE, "node"},
    {"\"node\":0,\"path\"", "\"node\":\"0\",\"path\"", "\"0\",\"path\"", FORMAT, "node"},
    {"\"path\":\"rotation\"", "\"path\":null", "null", FORMAT, "path"},
    {"\"path\":\"rotation\"", "\"x\":0", "{\"node\":0", FORMAT, "path is missing"},
    {"\"node\":1,\"path\"", "\"node\":2,\"path\"", NULL, PSPLAT_OK, ""}, /* shows nothing */
    {"{\"mesh\":0},{\"matrix\"",
     "{\"mesh\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},{\"matrix\"", "{\"node\":1", FORMAT,
     "node 1 has a matrix, which cannot be animated"},
    {"\"node\":1,\"path\":\"scale\"", "\"node\":0,\"path\":\"rotation\"",
     "{\"node\":0,\"path\":\"rotation\"}}],", FORMAT,
     "two channels of an animation move the same of node 0"},
    {"\"sampler\":1", "\"sampler\":0", "{\"sampler\":0,\"target\":{\"node\":1", FORMAT,
     "a sampler of 4 numbers moves what has 3"},
    {"\"input\":16,\"output\":17", "\"output\":17", "{\"output\":17", FORMAT, "input is missing"},
    {"\"output\":17", "\"x\":17", "{\"input\":16,\"x\"", FORMAT, "output is missing"},
    {"\"output\":17", "\"output\":19", "19,", RANGE, "the rotations of a sampler"},
    {"\"input\":16", "\"input\":1e9", "1e9", RANGE, "the times of a sampler"},
    {"LINEAR", "linear", "\"linear\"", FORMAT, "interpolation is none of"},
    {"\"LINEAR\"", "1", "1},{", FORMAT, "interpolation must be"},
    {"LINEAR", "CUBICSPLINE", "{\"input\":16,\"output\":17", RANGE,
     "a sampler has 3 values for 3 times"},
    {"\"count\":3,\"type\":\"SCALAR\"", "\"count\":2,\"type\":\"SCALAR\"",
     "{\"input\":16,\"output\":17", RANGE, "a sampler has 3 values for 2 times"},
    {"\"count\":3,\"type\":\"SCALAR\"", "\"count\":0,\"type\":\"SCALAR\"", "0,\"type\":\"SCALAR\"",
     RANGE, "count must be at least 1"},
    {"\"count\":3,\"type\":\"SCALAR\"", "\"count\":300,\"type\":\"SCALAR\"",
     "{\"bufferView\":3,\"byteOffset\":0", RANGE, "300 elements leave their bufferView"},
    {"\"count\":3,\"type\":\"SCALAR\"", "\"count\":3,\"type\":\"VEC2\"",
     "{\"bufferView\":3,\"byteOffset\":0", UNSUPPORTED, "the times of a sampler: must be SCALAR"},
    {"\"count\":3,\"type\":\"VEC4\"", "\"count\":3,\"type\":\"VEC3\"",
     "{\"bufferView\":3,\"byteOffset\":12", UNSUPPORTED,
     "the rotations of a sampler: must be VEC4"},
    {"\"count\":3,\"type\":\"VEC4\"", "\"count\":3,\"type\":\"MAT2\"",
     "{\"bufferView\":3,\"byteOffset\":12", UNSUPPORTED,
     "the rotations of a sampler: must be VEC4"},
    {"\"byteOffset\":0,\"componentType\":5126,\"count\":3",
     "\"byteOffset\":0,\"componentType\":5123,\"count\":3", "{\"bufferView\":3,\"byteOffset\":0",
     UNSUPPORTED, "component type 5123"},
    {"\"byteOffset\":12,\"componentType\":5126", "\"byteOffset\":12,\"componentType\":5122",
     "{\"bufferView\":3,\"byteOffset\":12", UNSUPPORTED, "integers must be normalized"},
    {"\"byteOffset\":60,\"componentType\":5126",
     "\"byteOffset\":60,\"componentType\":5122,\"normalized\":true",
     "{\"bufferView\":3,\"byteOffset\":60", UNSUPPORTED,
     "the values of a sampler: component type 5122"},
    {"\"byteOffset\":12,\"componentType\":5126", "\"byteOffset\":13,\"componentType\":5126",
     "{\"bufferView\":3,\"byteOffset\":13", RANGE, "not aligned"},
    {"\"bufferView\":3,\"byteOffset\":12,", "",
     "{\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"", UNSUPPORTED, "without bufferView"},
    {"\"type\":\"VEC4\"}", "\"type\":\"VEC4\",\"sparse\":{}}", "{}}", UNSUPPORTED, "sparse"},
    /* A cycle of nodes is refused before animations walk over it. */
    {"{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}", "{\"children\":[1,2]}", RANGE, "not a root"},
};

static void test_structure(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof structures / sizeof *structures; ++i) {
        char *text = document_of(times, rotations, scales);
        document_replace(&text, structures[i].from, structures[i].to);
        size_t at = structures[i].at ? document_find(text, structures[i].at) : 0;
        if (i + 1 == sizeof structures / sizeof *structures) at = document_find(text, "0] }");
        expect(text, structures[i].code, at, structures[i].said);
        free(text);
    }
}

/* Returns where byte `position` of the second buffer begins in the text. */
static size_t offset_of(const char *text, size_t position) {
    size_t start = document_find(text, "base64,") + 7;
    start += document_find(text + start, "base64,") + 7;
    return start + position / 3 * 4 + position % 3;
}

/* Numbers that are no times, no quaternions or no numbers: the offset is that of the element. */
static void test_numbers(void **state) {
    (void)state;
    static const struct {
        int index; /* 0 ... 2: times, then 12 of rotations and 9 of scales */
        float value;
        size_t position;
        const char *said;
    } cases[] = {
        {0, -0.5f, 0, "times of a sampler: number 0 is negative"},
        {1, 0, 4, "times of a sampler: number 1 is not after the one before it"},
        {2, 0.5f, 8, "times of a sampler: number 2 is not after the one before it"},
        {0, NAN, 0, "times of a sampler: number 0 is not finite"},
        {2, INFINITY, 8, "times of a sampler: number 2 is not finite"},
        {3 + 3, 0, 12, "rotations of a sampler: number 0 is not a unit quaternion"},
        {3 + 6, 1.05f, 28, "rotations of a sampler: number 1 is not a unit quaternion"},
        {3 + 9, NAN, 44, "rotations of a sampler: number 2 is not finite"},
        {15 + 4, -INFINITY, 72, "values of a sampler: number 1 is not finite"},
        {15 + 8, NAN, 84, "values of a sampler: number 2 is not finite"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        float numbers[24];
        memcpy(numbers, times, sizeof times);
        memcpy(numbers + 3, rotations, sizeof rotations);
        memcpy(numbers + 15, scales, sizeof scales);
        numbers[cases[i].index] = cases[i].value;
        char *text = document_of(numbers, numbers + 3, numbers + 15);
        expect(text, RANGE, offset_of(text, cases[i].position), cases[i].said);
        free(text);
    }
}

/* Returns a document in which n samplers have accessors of their own of the same 1600 bytes: 100
 * times and as many scales. */
static char *overlapping(int n) {
    enum { KEYS = 100 };
    static float values[3 * KEYS], keys[KEYS];
    char channels[2048] = "", samplers[2048] = "", list[512] = "{\"mesh\":0,\"children\":[",
         all[4160];
    moving m = {0};
    for (int i = 0; i < KEYS; ++i) keys[i] = (float)i;
    for (int i = 0; i < n; ++i) {
        const char *comma = i ? "," : "";
        size_t said = strlen(samplers), moved = strlen(channels), listed = strlen(list);
        m.size = 0;
        int input = moving_floats(&m, keys, KEYS, 1), output = moving_floats(&m, values, KEYS, 3);
        snprintf(samplers + said, sizeof samplers - said, "%s{\"input\":%d,\"output\":%d}", comma,
                 input, output);
        snprintf(channels + moved, sizeof channels - moved,
                 "%s{\"sampler\":%d,\"target\":{\"node\":%d,\"path\":\"scale\"}}", comma, i, i + 1);
        snprintf(list + listed, sizeof list - listed, "%s%d", comma, i + 1);
    }
    strcat(list, "]}");
    for (int i = 0; i < n; ++i) strcat(list, ",{\"mesh\":0}");
    snprintf(all, sizeof all, "{\"channels\":[%s],\"samplers\":[%s]}", channels, samplers);
    return moving_text(&m, PSPLAT_SOURCE_DIR, list, all);
}

/* Accessors that overlap may read the buffers, of 1600 and 244 bytes, four times over and no more,
 * so that a small file cannot fill the memory. */
static void test_overlap(void **state) {
    (void)state;
    char *text = overlapping(4);
    expect(text, PSPLAT_OK, 0, "");
    free(text);
    text = overlapping(5);
    expect(text, UNSUPPORTED, document_find(text, "25}]"),
           "the accessors of animations overlap too much in 1844 bytes");
    free(text);
}

/* Each allocation fails once, and nothing is left behind. */
static void test_out_of_memory(void **state) {
    (void)state;
    char *text = document_of(times, rotations, scales);
    ledger l = {.fail_at = 0};
    const psplat_asset_desc desc = {.allocator = ledger_allocator(&l)};
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    int failures = 0;
    while (psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error)) {
        assert_int_equal(error.code, PSPLAT_ERROR_MEMORY);
        assert_int_equal(l.bytes, 0);
        l.calls = 0;
        l.fail_at = ++failures;
    }
    psplat_asset_destroy(asset);
    assert_int_equal(l.bytes, 0);
    assert_true(failures > 30); /* some of them for the animations */
    free(text);
}

int test_animation_refused_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_opens),         cmocka_unit_test(test_structure),
        cmocka_unit_test(test_numbers),       cmocka_unit_test(test_overlap),
        cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
