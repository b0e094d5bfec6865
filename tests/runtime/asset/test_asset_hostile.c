/* SPDX-License-Identifier: MIT
 *
 * test_asset_hostile.c - tests what the asset reader must survive: files that are cut off anywhere
 * or have any bit wrong, files made to use up memory or time, and a machine without memory.
 * AddressSanitizer finds the errors that the tests themselves cannot see.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"
#include "scene_asset.h"

#include <stdlib.h>

/* ---- an allocator that counts, and fails when told to ------------------------------------- */

typedef struct counter {
    size_t calls, fail_at; /* fail_at 0: no call fails */
    size_t bytes, peak;
} counter;

static void *resize_counted(void *user, void *memory, size_t old_size, size_t new_size) {
    counter *c = user;
    if (new_size > old_size && ++c->calls == c->fail_at) return NULL;
    c->bytes += new_size;
    c->bytes -= old_size; /* a wrong old_size leaves a rest at the end */
    if (c->bytes > c->peak) c->peak = c->bytes;
    if (!new_size) {
        free(memory);
        return NULL;
    }
    return realloc(memory, new_size);
}

static psplat_result open_counted(const void *data, size_t size, counter *c, psplat_error *error) {
    psplat_asset_desc desc = {.allocator = {resize_counted, c}};
    psplat_asset *asset = NULL;
    psplat_result result = psplat_asset_open_memory(data, size, &desc, &asset, error);
    assert_int_equal(asset == NULL, result != PSPLAT_OK);
    psplat_asset_destroy(asset);
    assert_int_equal(c->bytes, 0);
    return result;
}

/* Returns a file with two primitives of one splat each, as small as a file with every feature
 * gets. */
static uint8_t *small_glb(size_t *size) {
    scene s = scene_ellipses(2, 1, 1);
    uint8_t *data = scene_glb(&s, size);
    scene_free(&s);
    return data;
}

/* Fails the first allocation, then the second, and so on until none is left to fail. */
static void fail_each_allocation(const void *data, size_t size) {
    size_t failures = 0;
    for (;; ++failures) {
        counter c = {.fail_at = failures + 1};
        psplat_error error = {0};
        psplat_result result = open_counted(data, size, &c, &error);
        if (c.calls < c.fail_at) {
            assert_int_equal(result, PSPLAT_OK);
            break;
        }
        assert_int_equal(result, PSPLAT_ERROR_MEMORY);
        assert_int_equal(error.code, PSPLAT_ERROR_MEMORY);
        assert_true(strlen(error.text) > 0);
    }
    /* There are the asset, tokens, six tables, the queue of nodes, a block for each set, and the
     * batches. */
    assert_true(failures >= 12);
}

static void test_out_of_memory(void **state) {
    (void)state;
    size_t size = 0;
    uint8_t *data = small_glb(&size);
    fail_each_allocation(data, size);
    free(data);
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    fail_each_allocation(text, strlen(text));
    free(text);
}

static void test_out_of_memory_with_files(void **state) {
    (void)state;
    static const char path[] = PSPLAT_SOURCE_DIR "/schema/minimal.gltf";
    size_t failures = 0;
    for (;; ++failures) {
        counter c = {.fail_at = failures + 1};
        psplat_asset_desc desc = {.allocator = {resize_counted, &c}};
        psplat_asset *asset = NULL;
        psplat_result result = psplat_asset_open(path, &desc, &asset, NULL);
        psplat_asset_destroy(asset);
        assert_int_equal(c.bytes, 0);
        assert_int_equal(result, c.calls < c.fail_at ? PSPLAT_OK : PSPLAT_ERROR_MEMORY);
        if (!result) break;
    }
    /* Also the directory's name, the file, and its block in the list. */
    assert_true(failures >= 14);
}

/* ---- damage ------------------------------------------------------------------------------- */

/* Tries every beginning of a file, in a block of exactly that size. */
static void test_truncation(void **state) {
    (void)state;
    size_t size = 0;
    uint8_t *data = small_glb(&size);
    for (size_t cut = 0; cut < size; ++cut) {
        uint8_t *part = malloc(cut ? cut : 1);
        counter c = {0};
        psplat_error error = {0};
        assert_non_null(part);
        memcpy(part, data, cut);
        assert_int_not_equal(open_counted(part, cut, &c, &error), PSPLAT_OK);
        assert_true(error.offset <= cut);
        free(part);
    }
    free(data);
}

static void test_truncated_text(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    size_t size = strlen(text);
    for (size_t cut = 0; cut + 1 < size; ++cut) {
        char *part = malloc(cut ? cut : 1);
        counter c = {0};
        psplat_error error = {0};
        assert_non_null(part);
        memcpy(part, text, cut);
        assert_int_equal(open_counted(part, cut, &c, &error), PSPLAT_ERROR_FORMAT);
        free(part);
    }
    free(text);
}

/* The length in the header follows the file here, so that the damage behind it is reached. */
static void test_truncated_chunks(void **state) {
    (void)state;
    size_t size = 0;
    uint8_t *data = small_glb(&size);
    for (size_t cut = 12; cut < size; ++cut) {
        uint8_t *part = malloc(cut);
        counter c = {0};
        psplat_error error = {0};
        assert_non_null(part);
        memcpy(part, data, cut);
        for (int i = 0; i < 4; ++i) part[8 + i] = (uint8_t)(cut >> (8 * i));
        assert_int_not_equal(open_counted(part, cut, &c, &error), PSPLAT_OK);
        free(part);
    }
    free(data);
}

/* Any result is accepted, as long as memory stays bounded and all of it is freed. */
static void flip_bits(uint8_t *data, size_t size, size_t step) {
    for (size_t bit = 0; bit < 8 * size; bit += step) {
        counter c = {0};
        psplat_error error = {0};
        data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        psplat_result result = open_counted(data, size, &c, &error);
        if (result) assert_true(error.code == result && error.offset <= size && error.text[0]);
        assert_true(c.peak < 64 * size + 4096);
        data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

static void test_bit_flips(void **state) {
    (void)state;
    scene s = scene_disc(1); /* the smallest file, because each bit needs an opening */
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    flip_bits(data, size, 1);
    free(data);
    scene_free(&s);
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    /* A sample that has all eight positions in a byte. */
    flip_bits((uint8_t *)text, strlen(text), 31);
    free(text);
}

/* ---- small files that ask for much -------------------------------------------------------- */

typedef struct builder {
    char *text;
    size_t size, capacity;
} builder;

static void add(builder *b, const char *piece) {
    size_t length = strlen(piece);
    if (b->capacity - b->size <= length) {
        b->capacity = 2 * b->capacity + length + 4096;
        b->text = realloc(b->text, b->capacity);
        assert_non_null(b->text);
    }
    memcpy(b->text + b->size, piece, length + 1);
    b->size += length;
}

static void repeat(builder *b, size_t count, const char *piece) {
    for (size_t i = 0; i < count; ++i) {
        if (i) add(b, ",");
        add(b, piece);
    }
}

/* Makes a document of count primitives of one splat each, and of instances of its mesh. All
 * primitives use the same 32 bytes: the floats 0 0 1 0 1 1 0 0, the first of which position, normal
 * and rotation share. */
static builder many(size_t count, size_t instances) {
    builder b = {0};
    add(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"PSPLAT_surface_splats\"],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"componentType\":5126,\"count\":1,\"type\":\"VEC4\"},"
        "{\"bufferView\":0,\"byteOffset\":16,\"componentType\":5126,\"count\":1,"
        "\"type\":\"VEC2\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":32}],"
        "\"buffers\":[{\"byteLength\":32,\"uri\":\"data:;base64,AAAAAAAAAAAAAIA/AAAAAAAAgD8AAIA/"
        "AAAAAAAAAAA=\"}],"
        "\"nodes\":[");
    repeat(&b, instances, "{\"mesh\":0}");
    add(&b, "],\"meshes\":[{\"primitives\":[");
    repeat(&b, count,
           "{\"mode\":0,\"attributes\":{\"POSITION\":0,\"NORMAL\":0,"
           "\"_PSPLAT_surface_splats:ROTATION\":1,\"_PSPLAT_surface_splats:SCALE\":2},"
           "\"extensions\":{\"PSPLAT_surface_splats\":{\"version\":1,\"clipLines\":0,"
           "\"depthTolerance\":0,\"positionExtent\":[0,0,0]}}}");
    add(&b, "]}]}");
    return b;
}

/* Opens the document and expects the given result, with at most times the file's size of memory. */
static psplat_error expect(builder b, psplat_result code, size_t times) {
    counter c = {0};
    psplat_error error = {0};
    psplat_result result = open_counted(b.text, b.size, &c, &error);
    if (result != code) fail_msg("%s: %s", psplat_result_text(result), error.text);
    if (c.peak > times * b.size) fail_msg("%zu bytes for a file of %zu", c.peak, b.size);
    free(b.text);
    return error;
}

/* Brackets, numbers and empty objects make the densest possible tokens, nodes and primitives. */
static void test_dense_json(void **state) {
    (void)state;
    static const char *const dense[][2] = {
        {"{\"extras\":[", "1"},   {"{\"nodes\":[", "{}"},       {"{\"materials\":[", "{}"},
        {"{\"buffers\":[", "{}"}, {"{\"meshes\":[", "{}"},      {"{\"accessors\":[", "{}"},
        {"{\"scenes\":[", "[]"},  {"{\"bufferViews\":[", "{}"}, {"{\"textures\":[", "{}"},
    };
    for (size_t i = 0; i < sizeof dense / sizeof *dense; ++i) {
        builder b = {0};
        add(&b, dense[i][0]);
        repeat(&b, 50000, dense[i][1]);
        add(&b, "],\"asset\":{\"version\":\"2.0\"}}");
        psplat_error error = {0};
        counter c = {0};
        assert_int_not_equal(open_counted(b.text, b.size, &c, &error), PSPLAT_OK);
        /* Each number with its comma takes a token of 20 bytes; each byte of an empty object takes
         * 7 to 17 bytes of table. */
        if (c.peak > 100 * b.size) fail_msg("%s: %zu of %zu", dense[i][0], c.peak, b.size);
        free(b.text);
    }
}

/* Primitives may share bytes, but a small file must not fill the memory that way. One splat is
 * allowed for each 8 bytes; here there is one for 4. */
static void test_shared_bytes(void **state) {
    (void)state;
    expect(many(4, 1), PSPLAT_OK, 20);
    assert_non_null(strstr(expect(many(5, 1), PSPLAT_ERROR_RANGE, 20).text, "too many times"));
    expect(many(5000, 1), PSPLAT_ERROR_RANGE, 20);
}

/* Batches are nodes times primitives: here there are four for each node, which takes 11 bytes. A
 * batch takes 560 bytes, of which 270 are its material with five textures. */
static void test_many_instances(void **state) {
    (void)state;
    expect(many(4, 1 << 16), PSPLAT_OK, 230);
    assert_non_null(
        strstr(expect(many(4, (1 << 16) + 1), PSPLAT_ERROR_UNSUPPORTED, 60).text, "262144"));
}

int test_asset_hostile_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_out_of_memory),    cmocka_unit_test(test_out_of_memory_with_files),
        cmocka_unit_test(test_truncation),       cmocka_unit_test(test_truncated_text),
        cmocka_unit_test(test_truncated_chunks), cmocka_unit_test(test_bit_flips),
        cmocka_unit_test(test_dense_json),       cmocka_unit_test(test_shared_bytes),
        cmocka_unit_test(test_many_instances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
