/* SPDX-License-Identifier: MIT
 *
 * test_stream.c - tests files with a coded stream (spec 3.12) that are not as they should be: each
 * field of the head out of its range, members and attributes that the stream holds, bytes that are
 * missing or changed. tests/converter/export/test_written_splats.c reads streams that are whole.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

/* 84 bytes of zeros in base64. */
#define ZEROS_12 "AAAAAAAAAAAAAAAA"
#define ZEROS_84 ZEROS_12 ZEROS_12 ZEROS_12 ZEROS_12 ZEROS_12 ZEROS_12 ZEROS_12

enum { JSON_AT = 20, HEAD = 60, SECTION = 12 };

/* A file of the corpus: its stream comes first. The first has two sections of 62 splats, the second
 * one of 19 with texture coordinates. */
typedef struct file {
    uint8_t *bytes;
    size_t size, bin, stream_size; /* bin: where the stream begins */
} file;

static file read_named(const char *path) {
    file f = {0};
    f.bytes = (uint8_t *)document_read(path, &f.size);
    f.bin = JSON_AT + 8 + (size_t)(f.bytes[12] | f.bytes[13] << 8);
    const char *at = strstr((const char *)f.bytes + JSON_AT, "\"bufferViews\":[{\"buffer\":0,");
    assert_non_null(at);
    assert_int_equal(
        sscanf(at, "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu", &f.stream_size), 1);
    return f;
}

static file read_file(void) {
    return read_named(PSPLAT_SOURCE_DIR "/tests/corpus/10-streamed.glb");
}

static file read_textured(void) {
    return read_named(PSPLAT_SOURCE_DIR "/tests/corpus/11-texcoords.glb");
}

/* Opens a file and returns the result. */
static psplat_result open_file(const file *f, psplat_error *error) {
    psplat_asset *asset = NULL;
    *error = (psplat_error){0};
    psplat_result result = psplat_asset_open_memory(f->bytes, f->size, NULL, &asset, error);
    assert_int_equal(result == PSPLAT_OK, asset != NULL);
    psplat_asset_destroy(asset);
    return result;
}

static void expect(const file *f, psplat_result expected, const char *what) {
    psplat_error error;
    psplat_result result = open_file(f, &error);
    if (result != expected || (expected && !strstr(error.text, what)))
        fail_msg("%s: result %d, %s", what, (int)result, error.text);
}

/* Each byte of the head and of the first section, with a value that it must not have. */
static void test_head(void **state) {
    (void)state;
    static const struct {
        size_t at;
        uint8_t value;
        psplat_result result;
        const char *what;
    } faults[] = {{0, 2, PSPLAT_ERROR_UNSUPPORTED, "unknown form"},
                  {1, 9, PSPLAT_ERROR_RANGE, "head out of range"},
                  {2, 3, PSPLAT_ERROR_RANGE, "head out of range"},
                  {2, 15, PSPLAT_ERROR_RANGE, "head out of range"},
                  {3, 0, PSPLAT_ERROR_RANGE, "head out of range"},
                  {3, 15, PSPLAT_ERROR_RANGE, "head out of range"},
                  {4, 0, PSPLAT_ERROR_RANGE, "head out of range"},
                  {4, 15, PSPLAT_ERROR_RANGE, "head out of range"},
                  {8, 0, PSPLAT_ERROR_RANGE, "head out of range"},
                  {8, 33, PSPLAT_ERROR_RANGE, "head out of range"},
                  {9, 8, PSPLAT_ERROR_RANGE, "head out of range"},
                  {10, 5, PSPLAT_ERROR_RANGE, "head out of range"},
                  {11, 1, PSPLAT_ERROR_RANGE, "head out of range"}, /* what follows is no step */
                  {15, 0xc0, PSPLAT_ERROR_RANGE, "below 0"},        /* sharpness -4 */
                  {35, 0xff, PSPLAT_ERROR_RANGE, "below 0"},        /* least radius */
                  {HEAD, 0, PSPLAT_ERROR_RANGE, "values for"},      /* 0 splats, or another count */
                  {HEAD + 3, 1, PSPLAT_ERROR_RANGE, "more splats"},
                  {HEAD + 7, 0xff, PSPLAT_ERROR_RANGE, "section out of range"},
                  {HEAD + 8, 5, PSPLAT_ERROR_RANGE, "section out of range"},
                  {HEAD + 9, 5, PSPLAT_ERROR_RANGE, "section out of range"}, /* no gamma */
                  {HEAD + 9, 53, PSPLAT_ERROR_RANGE, "section out of range"},
                  {HEAD + 10, 1, PSPLAT_ERROR_RANGE, "section out of range"},
                  {HEAD + 11, 1, PSPLAT_ERROR_RANGE, "section out of range"}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        file f = read_file();
        expect(&f, PSPLAT_OK, "");
        f.bytes[f.bin + faults[i].at] = faults[i].value;
        if (faults[i].at == HEAD)
            expect(&f, PSPLAT_ERROR_RANGE, "section out of range");
        else
            expect(&f, faults[i].result, faults[i].what);
        free(f.bytes);
    }
}

/* The same of what a stream with texture coordinates has besides. */
static void test_texcoord_head(void **state) {
    (void)state;
    static const struct {
        size_t at;
        uint8_t value;
        psplat_result result;
        const char *what;
    } faults[] = {
        {11, 17, PSPLAT_ERROR_RANGE, "head out of range"},
        {HEAD, 1, PSPLAT_ERROR_RANGE, "head out of range"}, /* no power of two */
        {HEAD + 3, 0xbf, PSPLAT_ERROR_RANGE, "below 0"},    /* a step below 0 */
        {HEAD + 3, 0x20, PSPLAT_ERROR_RANGE, "TEXCOORD_0 out of range"},
        {HEAD + 7, 0xff, PSPLAT_ERROR_RANGE, "below 0"},
        {HEAD + 11, 0xff, PSPLAT_ERROR_RANGE, "below 0"},
        {HEAD + 12 + 9, 127, PSPLAT_ERROR_RANGE, "section out of range"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        file f = read_textured();
        expect(&f, PSPLAT_OK, "");
        f.bytes[f.bin + faults[i].at] = faults[i].value;
        expect(&f, faults[i].result, faults[i].what);
        free(f.bytes);
    }
    file f = read_textured();
    memset(f.bytes + f.bin + HEAD, 0, 4); /* the step of coordinates */
    expect(&f, PSPLAT_ERROR_RANGE, "head out of range");
    free(f.bytes);
    f = read_textured();
    memset(f.bytes + f.bin + HEAD + 4, 0, 4); /* that of the first order */
    expect(&f, PSPLAT_ERROR_RANGE, "head out of range");
    free(f.bytes);
    f = read_textured();
    memset(f.bytes + f.bin + HEAD + 8, 0, 4); /* that of the second, which a flag asks for */
    expect(&f, PSPLAT_ERROR_RANGE, "section out of range");
    free(f.bytes);
}

/* Replaces text in the JSON, which must not become longer than the file's name of its generator. */
static void edit(file *f, const char *from, const char *to) {
    size_t size = f->bin - 8 - JSON_AT;
    char *text = calloc(size + 1, 1);
    assert_non_null(text);
    memcpy(text, f->bytes + JSON_AT, size);
    document_replace(&text, ",\"generator\":\"phongsplat 0.1.0\"", "");
    document_replace(&text, "\"name\":\"tiles\",", "");
    document_replace(&text, from, to);
    assert_true(strlen(text) <= size);
    memset(f->bytes + JSON_AT, ' ', size);
    memcpy(f->bytes + JSON_AT, text, strlen(text));
    free(text);
}

/* TEXCOORD_0 has to be there beside texture coordinates in a stream, the others not. */
static void test_texcoord_attributes(void **state) {
    (void)state;
    static const struct {
        const char *to;
        psplat_result result;
        const char *what;
    } faults[] = {{"\"TEXCOORD_0\":1", PSPLAT_OK, ""},
                  {"\"TEXCOORD_9\":1", PSPLAT_ERROR_FORMAT, "TEXCOORD_0"},
                  {"\"TEXCOORD_0\":1,\"PSPLAT_surface_splats:TEXCOORD_U\":1", PSPLAT_ERROR_FORMAT,
                   "although the primitive has a stream"}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        file f = read_textured();
        edit(&f, "\"TEXCOORD_0\":1", faults[i].to);
        expect(&f, faults[i].result, faults[i].what);
        free(f.bytes);
    }
}

static void put_u32(uint8_t *bytes, uint32_t value) {
    for (int k = 0; k < 4; ++k) bytes[k] = (uint8_t)(value >> (8 * k));
}

/* Counts of sections whose sum, in 32 bits, would be that of the file, are refused where they are
 * added, on machines of any width. */
static void test_counts_wrap(void **state) {
    (void)state;
    file f = read_file();
    put_u32(f.bytes + f.bin + HEAD, UINT32_MAX);
    put_u32(f.bytes + f.bin + HEAD + SECTION, 28 + 34 + 1);
    expect(&f, PSPLAT_ERROR_RANGE, "more splats");
    put_u32(f.bytes + f.bin + HEAD, 28 + 34 + 1);
    put_u32(f.bytes + f.bin + HEAD + SECTION, UINT32_MAX);
    expect(&f, PSPLAT_ERROR_RANGE, "more splats");
    free(f.bytes);
}

/* max_file_size also limits the rows of 33 floats that come out of a stream. */
static void test_budget(void **state) {
    (void)state;
    enum { ROW_BYTES = 132 };
    file f = read_file();
    psplat_asset_desc desc = {.max_file_size = f.size + 62 * ROW_BYTES};
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(f.bytes, f.size, &desc, &asset, &error), PSPLAT_OK);
    psplat_asset_destroy(asset);
    --desc.max_file_size;
    assert_int_equal(psplat_asset_open_memory(f.bytes, f.size, &desc, &asset, &error),
                     PSPLAT_ERROR_RANGE);
    if (!strstr(error.text, "larger than allowed")) fail_msg("%s", error.text);
    free(f.bytes);
}

typedef struct counter {
    size_t bytes, peak;
} counter;

static void *resize_counted(void *user, void *memory, size_t old_size, size_t new_size) {
    counter *c = user;
    c->bytes += new_size - old_size;
    if (c->bytes > c->peak) c->peak = c->bytes;
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

/* Opens a file with so many primitives of one stream and returns the most bytes taken. */
static size_t peak_of(size_t primitives, const char *primitive) {
    size_t size;
    char *text = document_read(PSPLAT_SOURCE_DIR "/schema/streamed.gltf", &size), all[4096] = "";
    counter c = {0};
    const psplat_asset_desc desc = {.allocator = {resize_counted, &c}};
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    for (size_t i = 0; i < primitives; ++i) {
        strcat(all, primitive);
        strcat(all, ",");
    }
    strcat(all, "{ \"mode\": 0,");
    char *brace = strchr(strstr(text, "\"primitives\""), '{'), *mode = strchr(brace, ',');
    char *grown = malloc(size + sizeof all);
    assert_non_null(grown);
    sprintf(grown, "%.*s%s%s", (int)(brace - text), text, all, mode + 1);
    if (psplat_asset_open_memory(grown, strlen(grown), &desc, &asset, &error))
        fail_msg("%s", error.text);
    psplat_asset_destroy(asset);
    assert_int_equal(c.bytes, 0);
    free(grown);
    free(text);
    return c.peak;
}

/* The decoder, the stream's head and its rows are memory that all primitives share: each more takes
 * its JSON, two sets and ten splats, where a decoder and a stream of its own took 15 kB more. */
static void test_shares_memory(void **state) {
    (void)state;
    static const char primitive[] = "{\"mode\":0,\"attributes\":{\"POSITION\":0},\"extensions\":"
                                    "{\"PSPLAT_surface_splats\":{\"version\":4,\"stream\":0}}}";
    size_t few = peak_of(1, primitive), many = peak_of(7, primitive);
    assert_in_range(many - few, 6 * 10 * 164, 6 * 8000);
}

/* Another count, which POSITION has not, and another extent, as a tool that rescales leaves it. */
static void test_positions(void **state) {
    (void)state;
    file f = read_file();
    f.bytes[f.bin + HEAD] = 27;
    expect(&f, PSPLAT_ERROR_RANGE, "POSITION");
    f.bytes[f.bin + HEAD] = 28;
    f.bytes[f.bin + 22] ^= 0x40; /* of the first extent */
    expect(&f, PSPLAT_ERROR_RESCALED, "rescaled");
    free(f.bytes);
}

/* Puts another text of the same length into the JSON. */
static void test_json(void **state) {
    (void)state;
    static const struct {
        const char *from, *to;
        psplat_result result;
        const char *what;
    } faults[] = {{"\"stream\":0", "\"stream\":9", PSPLAT_ERROR_RANGE, "stream"},
                  {"\"version\":4,\"stream\":0", "\"version\":4,\"streak\":0", PSPLAT_ERROR_FORMAT,
                   "clipLines"},
                  {"\"version\":4", "\"version\":3", PSPLAT_ERROR_FORMAT, "clipLines"},
                  {"{\"POSITION\":0}", "{\"POSITIOM\":0}", PSPLAT_ERROR_FORMAT, "POSITION"}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        file f = read_file();
        char *at = strstr((char *)f.bytes + JSON_AT, faults[i].from);
        assert_non_null(at);
        memcpy(at, faults[i].to, strlen(faults[i].to));
        psplat_error error;
        psplat_result result = open_file(&f, &error);
        if (result != faults[i].result || !strstr(error.text, faults[i].what))
            fail_msg("%s: result %d, %s", faults[i].to, (int)result, error.text);
        free(f.bytes);
    }
}

/* What is said twice. The text of a file of its own has room for it. */
static void test_said_twice(void **state) {
    (void)state;
    static const char *const members[] = {
        "\"clipLines\": 4",      "\"depthTolerance\": 1", "\"positionExtent\": [1, 1, 1]",
        "\"kernel\": {}",        "\"curved\": true",      "\"scaleRange\": [1, 2]",
        "\"turnRange\": 1",      "\"tiltRange\": 1",      "\"fieldRange\": 1",
        "\"clipRange\": [1, 1]", "\"shapeRange\": 1",     "\"bendRange\": 1",
    };
    static const char *const names[] = {"NORMAL",
                                        "_PSPLAT_surface_splats:ROTATION",
                                        "_PSPLAT_surface_splats:TURN",
                                        "_PSPLAT_surface_splats:TILT",
                                        "_PSPLAT_surface_splats:SCALE",
                                        "_PSPLAT_surface_splats:NORMAL_FIELD",
                                        "_PSPLAT_surface_splats:SHAPE",
                                        "_PSPLAT_surface_splats:CLIP_0",
                                        "PSPLAT_surface_splats:CLIP_3"};
    enum { MEMBERS = sizeof members / sizeof *members, NAMES = sizeof names / sizeof *names };
    for (size_t i = 0; i <= MEMBERS + NAMES; ++i) {
        char said[128];
        size_t size;
        char *text = document_read(PSPLAT_SOURCE_DIR "/schema/streamed.gltf", &size);
        if (i < MEMBERS) {
            snprintf(said, sizeof said, "\"version\": 4, %s", members[i]);
            document_replace(&text, "\"version\": 4", said);
        } else if (i < MEMBERS + NAMES) {
            snprintf(said, sizeof said, "\"POSITION\": 0, \"%s\": 0", names[i - MEMBERS]);
            document_replace(&text, "\"POSITION\": 0", said);
        }
        file f = {.bytes = (uint8_t *)text, .size = strlen(text)};
        expect(&f, i < MEMBERS + NAMES ? PSPLAT_ERROR_FORMAT : PSPLAT_OK,
               "although the primitive has a stream");
        free(text);
    }
}

/* A stream that ends too early: in its head, in its sections, in its splats. */
static void test_short(void **state) {
    (void)state;
    file f = read_file();
    for (size_t length = 0; length < f.stream_size; length += length < 100 ? 1 : 37) {
        file cut = read_file();
        char number[32], *at = strstr((char *)cut.bytes + JSON_AT, "\"bufferViews\"");
        char *digits = strstr(at, "\"byteLength\":") + strlen("\"byteLength\":");
        snprintf(number, sizeof number, "%0*zu", (int)strspn(digits, "0123456789"), length + 1);
        /* JSON knows no leading zeros, but blanks before a number. */
        for (char *c = number; *c == '0'; ++c) *c = ' ';
        memcpy(digits, number, strlen(number));
        psplat_error error;
        psplat_result result = open_file(&cut, &error);
        if (length + 1 < f.stream_size)
            assert_true(result == PSPLAT_ERROR_FORMAT || result == PSPLAT_ERROR_RANGE);
        free(cut.bytes);
    }
    free(f.bytes);
}

/* Replaces text of the example and opens it. */
static void expect_replaced(const char *const texts[][2], size_t count, psplat_result result,
                            const char *what) {
    size_t size;
    char *text = document_read(PSPLAT_SOURCE_DIR "/schema/streamed.gltf", &size);
    for (size_t i = 0; i < count; ++i) document_replace(&text, texts[i][0], texts[i][1]);
    file f = {.bytes = (uint8_t *)text, .size = strlen(text)};
    expect(&f, result, what);
    free(text);
}

/* Floats and normalized integers, whose distances machines may round differently. */
static void test_coarse_integers(void **state) {
    (void)state;
    static const char unsigned_byte[] = "\"componentType\": 5121,";
    static const char *const normalized[][2] = {
        {unsigned_byte, "\"componentType\": 5121, \"normalized\": true,"}};
    static const char *const floats[][2] = {{unsigned_byte, "\"componentType\": 5126,"},
                                            {"\"byteLength\": 40,", "\"byteLength\": 120,"},
                                            {"\"byteStride\": 4,", "\"byteStride\": 12,"},
                                            {"\"byteLength\": 228", "\"byteLength\": 308"},
                                            {"AAAVFTcA", "AAAVFTcA" ZEROS_84}};
    expect_replaced(normalized, 1, PSPLAT_ERROR_UNSUPPORTED, "must be integers");
    expect_replaced(floats, 5, PSPLAT_ERROR_UNSUPPORTED, "must be integers");
}

/* Zeros may follow the last splat, nothing else, and the view has no stride. */
static void test_end(void **state) {
    (void)state;
    static const char *const zeros[][2] = {{"\"byteLength\": 185", "\"byteLength\": 188"}};
    static const char *const more[][2] = {{"\"byteLength\": 185", "\"byteLength\": 190"}};
    /* Twelve more zeros, before POSITION. */
    static const char *const many[][2] = {{"\"byteLength\": 185", "\"byteLength\": 195"},
                                          {"\"byteOffset\": 188", "\"byteOffset\": 200"},
                                          {"\"byteLength\": 228", "\"byteLength\": 240"},
                                          {"V+YAAAAe", "V+YA" ZEROS_12 "AAAe"}};
    static const char *const stride[][2] = {
        {"\"byteLength\": 185", "\"byteLength\": 185, \"byteStride\": 4"}};
    static const char *const compression[][2] = {
        {"\"byteLength\": 185",
         "\"byteLength\": 185, \"extensions\": {\"EXT_meshopt_compression\": {}}"}};
    expect_replaced(zeros, 1, PSPLAT_OK, "");
    expect_replaced(many, 4, PSPLAT_ERROR_FORMAT, "behind its splats");
    expect_replaced(more, 1, PSPLAT_ERROR_FORMAT, "behind its splats");
    expect_replaced(stride, 1, PSPLAT_ERROR_FORMAT, "byteStride");
    expect_replaced(compression, 1, PSPLAT_ERROR_FORMAT, "compression");
}

/* Whatever the bytes are, the file opens or is refused; every splat that comes out is valid, which
 * the second half of the reader checks. */
static void test_damaged(void **state) {
    (void)state;
    enum { TRIES = 3000 };
    file whole = read_file(), f = read_file();
    uint32_t random = 5;
    size_t refused = 0;
    for (int i = 0; i < TRIES; ++i) {
        psplat_error error;
        for (int k = 0; k <= i % 3; ++k) {
            random = random * 1664525u + 1013904223u;
            size_t at = f.bin + (random >> 8) % f.stream_size;
            f.bytes[at] = (uint8_t)(f.bytes[at] ^ 1u << (random >> 5 & 7));
        }
        refused += open_file(&f, &error) != PSPLAT_OK;
        memcpy(f.bytes, whole.bytes, whole.size);
    }
    assert_in_range(refused, TRIES / 4, TRIES);
    free(whole.bytes);
    free(f.bytes);
}

/* The bytes of attributes in the file add up to those of the stream and of the positions. */
static void test_sizes(void **state) {
    (void)state;
    file f = read_file();
    const psplat_asset_desc desc = {.measures = 1};
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(f.bytes, f.size, &desc, &asset, &error))
        fail_msg("%s", error.text);
    size_t stored = 0, attributes = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        attributes += batch->attribute_count;
        for (size_t i = 0; i < batch->attribute_count; ++i) {
            stored += batch->attributes[i].stored;
            assert_true(batch->attributes[i].is_compressed);
            assert_int_equal(batch->attributes[i].component_type, 0);
        }
    }
    /* Each attribute is rounded to bytes; positions are 3 bytes of 62 splats. */
    size_t coded = f.stream_size - HEAD - 2 * SECTION + 3 * 62;
    assert_in_range(stored, coded - attributes / 2 - 4, coded + attributes / 2);
    psplat_asset_destroy(asset);
    free(f.bytes);
}

int test_stream_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_head),
        cmocka_unit_test(test_texcoord_head),
        cmocka_unit_test(test_texcoord_attributes),
        cmocka_unit_test(test_positions),
        cmocka_unit_test(test_json),
        cmocka_unit_test(test_said_twice),
        cmocka_unit_test(test_short),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_counts_wrap),
        cmocka_unit_test(test_coarse_integers),
        cmocka_unit_test(test_end),
        cmocka_unit_test(test_budget),
        cmocka_unit_test(test_shares_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
