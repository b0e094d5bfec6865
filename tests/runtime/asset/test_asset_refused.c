/* SPDX-License-Identifier: MIT
 *
 * test_asset_refused.c - tests what the asset reader refuses: the bundled document or a GLB with
 * one thing changed, each with the expected error code and the offset of the byte at fault.
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

#include <math.h>
#include <stdlib.h>

/* A refused change of the document: the first occurrence of from becomes to. The error must lie at
 * the first occurrence of at in the changed text. */
typedef struct refusal {
    const char *from, *to, *at;
    psplat_result code;
} refusal;

#define FORMAT PSPLAT_ERROR_FORMAT
#define RANGE PSPLAT_ERROR_RANGE
#define UNSUPPORTED PSPLAT_ERROR_UNSUPPORTED

static void check_text(const char *text, const refusal *r) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    size_t offset = r->at ? document_find(text, r->at) : 0;
    if (result != r->code || error.code != r->code || error.offset != offset || asset)
        fail_msg("%s -> %s: %s: %s at %zu, expected %s at %zu", r->from, r->to,
                 psplat_result_text(result), error.text, error.offset, psplat_result_text(r->code),
                 offset);
    assert_true(strlen(error.text) > 5);
}

static void check(const refusal *refusals, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        char *text = document_minimal(PSPLAT_SOURCE_DIR);
        document_replace(&text, refusals[i].from, refusals[i].to);
        check_text(text, &refusals[i]);
        free(text);
    }
}

#define CHECK(refusals) check(refusals, sizeof(refusals) / sizeof *(refusals))

static void test_document(void **state) {
    (void)state;
    static const refusal refusals[] = {
        {"\"version\": \"2.0\"", "\"version\": \"1.0\"", "\"1.0\"", UNSUPPORTED},
        {"\"version\": \"2.0\"", "\"version\": 2", "2 }", FORMAT},
        {"\"version\": \"2.0\"", "\"generator\": \"\"", "{ \"generator", FORMAT},
        {"\"version\": \"2.0\"", "\"version\": \"2.0\", \"minVersion\": \"2.1\"", "\"2.1\"",
         UNSUPPORTED},
        {"\"asset\"", "\"other\"", "{", FORMAT},
        {"\"extensionsUsed\"", "\"extensionsRequired\": [\"KHR_unheard_of\"], \"extensionsUsed\"",
         "\"KHR_unheard_of", UNSUPPORTED},
        /* Without splats it is another's file, which other readers may know. */
        {"\"extensionsUsed\"",
         "\"extensionsRequired\": [\"KHR_unheard_of\"], \"extensionsIgnored\"", NULL,
         PSPLAT_ERROR_NO_SPLATS},
        {"\"extensionsUsed\"", "\"extensionsRequired\": [3], \"extensionsUsed\"", "3]", FORMAT},
        {"\"extensionsUsed\"", "\"extensionsRequired\": 3, \"extensionsUsed\"", "3,", FORMAT},
        {"\"extensionsUsed\"", "\"extensionsIgnored\"", "{\n          \"mode\"", FORMAT},
        {"\"scene\": 0", "\"scene\": 1", "1,\n", RANGE},
        {"\"scene\": 0", "\"scene\": 0, \"scene\": 0", "\"scene\": 0,\n", FORMAT},
        {"\"nodes\": [0] }", "\"nodes\": [1] }", "1] }", RANGE},
        {"\"nodes\": [0] }", "\"nodes\": [0, 0] }", "0] }", RANGE},
        {"\"nodes\": [0] }", "\"nodes\": {} }", "{} }", FORMAT},
        {"\"nodes\": [0] }", "\"nodes\": [] }", NULL, PSPLAT_ERROR_NO_SPLATS},
        {"\"meshes\"", "\"messes\"", NULL, PSPLAT_ERROR_NO_SPLATS},
        {"\"primitives\"", "\"privatives\"", "{\n      \"privatives\"", FORMAT},
        {"\"buffers\"", "\"buffers\": [], \"bluffers\"", "0, \"byteOffset\": 0, \"byteLength\"",
         RANGE},
        {"{", "[]{", NULL, FORMAT},
    };
    CHECK(refusals);
}

static void test_extension_object(void **state) {
    (void)state;
    static const refusal refusals[] = {
        {"\"version\": 1", "\"version\": 5", "5, \"clipLines\"", UNSUPPORTED},
        {"\"version\": 1", "\"version\": 0", "0, \"clipLines\"", RANGE},
        {"\"version\": 1", "\"version\": -1", "-1, \"clipLines\"", RANGE},
        {"\"version\": 1, ", "", "{ \"clipLines\"", FORMAT},
        {"\"clipLines\": 0", "\"clipLines\": 5", "5, \"depth", RANGE},
        {"\"clipLines\": 0", "\"clipLines\": 0.5", "0.5, \"depth", RANGE},
        {"\"clipLines\": 0", "\"clipLines\": \"0\"", "\"0\", \"depth", FORMAT},
        {"\"clipLines\": 0", "\"clipLines\": 1", "{\n            \"POSITION\": 0", FORMAT},
        {"\"clipLines\": 2", "\"clipLines\": 1", "15\n", RANGE},
        {"\"depthTolerance\": 0.01", "\"depthTolerance\": -0.01", "-0.01", RANGE},
        {"\"depthTolerance\": 0.01", "\"depthTolerance\": 1e39", "1e39", RANGE},
        {"\"depthTolerance\": 0.01, ", "", "{ \"version\": 1", FORMAT},
        {"[0, 1.5, 0] }", "[0, 3, 0] }", "[0, 3, 0]", PSPLAT_ERROR_RESCALED},
        {"[0, 1.5, 0] }", "[0, 1.5002, 0] }", "[0, 1.5002, 0]", PSPLAT_ERROR_RESCALED},
        {"[0, 1.5, 0] }", "[0.001, 1.5, 0] }", "[0.001, 1.5, 0]", PSPLAT_ERROR_RESCALED},
        {"[0, 1.5, 0] }", "[0, -1.5, 0] }", "[0, -1.5, 0]", RANGE},
        {"[0, 1.5, 0] }", "[0, 1.5] }", "[0, 1.5] }", RANGE},
        {"[0, 1.5, 0] }", "[0, 1.5, null] }", "null", FORMAT},
        {"[0, 1.5, 0] }", "[0, 1.5, 0], \"kernel\": {\"sharpness\": 0}}", "0}}", RANGE},
        {"[0, 1.5, 0] }", "[0, 1.5, 0], \"kernel\": {\"exponent\": 1e-99}}", "1e-99", RANGE},
        {"[0, 1.5, 0] }", "[0, 1.5, 0], \"kernel\": 1}", "1}", FORMAT},
    };
    CHECK(refusals);
}

static void test_primitive(void **state) {
    (void)state;
    static const refusal refusals[] = {
        {"\"mode\": 0", "\"mode\": 4", "4,", FORMAT},
        {"\"mode\": 0", "\"mode\": 7", "7,", RANGE},
        {"\"mode\": 0,", "", "{\n          \n", FORMAT},
        {"\"mode\": 0", "\"mode\": 0, \"indices\": 0", "0,\n          \"attributes\"", FORMAT},
        {"\"mode\": 0", "\"mode\": 0, \"targets\": []", "[],", FORMAT},
        {"\"material\": 0", "\"material\": 77", "77,\n", RANGE},
        {"\"material\": 0", "\"material\": -1", "-1,\n", RANGE},
        {"\"POSITION\": 0", "\"POSITION\": 99", "99,", RANGE},
        {"\"POSITION\": 0,", "", "{\n            \n", FORMAT},
        {"\"NORMAL\": 1", "\"NORMAL\": 3", "{ \"bufferView\": 0, \"byteOffset\": 40", UNSUPPORTED},
        {"\"NORMAL\": 1", "\"NORMAL\": 6", "{ \"bufferView\": 1, \"byteOffset\": 12", RANGE},
        {"\"NORMAL\": 1", "\"NORMAL\": 1, \"NORMAL\": 1", "\"NORMAL\": 1,\n", FORMAT},
        {"\"NORMAL\": 1", "\"NORMAL\": 1, \"PSPLAT_surface_splats:SCALE\": 77", "3,\n", FORMAT},
        {"\"metallicFactor\": 0.0", "\"metallicFactor\": 1.5", "1.5,\n", RANGE},
        {"\"metallicFactor\": 0.0", "\"metallicFactor\": \"0\"", "\"0\",\n", FORMAT},
        {"[0.8, 0.4, 0.1, 1.0]", "[0.8, 0.4, 0.1]", "[0.8, 0.4, 0.1]", RANGE},
        {"[0.8, 0.4, 0.1, 1.0]", "[0.8, 0.4, -0.1, 1.0]", "[0.8, 0.4, -0.1", RANGE},
        {"\"doubleSided\": true", "\"doubleSided\": 1", "1\n", FORMAT},
    };
    CHECK(refusals);
}

static void test_accessor(void **state) {
    (void)state;
    static const char first[] =
        "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5126, \"count\": 2";
    static const char braced[] = "{ \"bufferView\": 0, \"byteOffset\": 12";
    static const refusal refusals[] = {
        {first, "\"bufferView\": 9, \"byteOffset\": 12, \"componentType\": 5126, \"count\": 2",
         "9, \"byteOffset\"", RANGE},
        {first, "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5126, \"count\": 0",
         "0, \"type\"", RANGE},
        {first, "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5126, \"count\": 3",
         braced, RANGE},
        {first,
         "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5126, \"count\": 4294967296",
         braced, RANGE},
        {first, "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5123, \"count\": 2",
         braced, UNSUPPORTED},
        {first, "\"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5130, \"count\": 2",
         braced, UNSUPPORTED},
        {first, "\"bufferView\": 0, \"byteOffset\": 14, \"componentType\": 5126, \"count\": 2",
         "{ \"bufferView\": 0, \"byteOffset\": 14", RANGE},
        {first, "\"bufferView\": 0, \"byteOffset\": 56, \"componentType\": 5126, \"count\": 2",
         "{ \"bufferView\": 0, \"byteOffset\": 56", RANGE},
        {first,
         "\"bufferView\": 0, \"byteOffset\": 9007199254740992, \"componentType\": 5126, "
         "\"count\": 2",
         "{ \"bufferView\": 0, \"byteOffset\": 9007199254740992", RANGE},
        {first, "\"componentType\": 5126, \"count\": 2",
         "{ \"componentType\": 5126, \"count\": 2, \"type\": \"VEC3\" }", UNSUPPORTED},
        {first,
         "\"sparse\": {}, \"bufferView\": 0, \"byteOffset\": 12, \"componentType\": 5126, "
         "\"count\": 2",
         "{}", UNSUPPORTED},
        {first, "\"bufferView\": 0, \"byteOffset\": 12, \"count\": 2",
         "{ \"bufferView\": 0, \"byteOffset\": 12, \"count\"", FORMAT},
        {"\"type\": \"VEC3\"", "\"type\": \"VEC5\"", "\"VEC5\"", FORMAT},
        {"\"type\": \"VEC4\"", "\"type\": \"MAT2\"", "{ \"bufferView\": 0, \"byteOffset\": 24",
         UNSUPPORTED},
        {"\"_PSPLAT_surface_splats:NORMAL_FIELD\": 4", "\"_PSPLAT_surface_splats:NORMAL_FIELD\": 2",
         "{ \"bufferView\": 0, \"byteOffset\": 24", UNSUPPORTED},
        {"\"byteStride\": 56", "\"byteStride\": 8",
         "{ \"buffer\": 0, \"byteOffset\": 0, \"byteLength\": 112", RANGE},
        {"\"byteStride\": 56", "\"byteStride\": 54", "54,", RANGE},
        {"\"byteStride\": 56", "\"byteStride\": 256", "256,", RANGE},
        {"\"byteStride\": 56", "\"byteStride\": 60", "{ \"bufferView\": 0, \"byteOffset\": 48",
         RANGE},
        {"\"byteLength\": 112", "\"byteLength\": 245",
         "{ \"buffer\": 0, \"byteOffset\": 0, \"byteLength\": 245", RANGE},
        {"\"byteOffset\": 112", "\"byteOffset\": 9007199254740991",
         "{ \"buffer\": 0, \"byteOffset\": 9007199254740991", RANGE},
        {"\"byteLength\": 244", "\"byteLength\": 245", "{\n      \"byteLength\": 245", RANGE},
        {"\"byteLength\": 244", "\"byteLength\": 1e300", "1e300", RANGE},
    };
    CHECK(refusals);
}

static void test_uri(void **state) {
    (void)state;
    static const char data[] = "data:application/octet-stream;base64,";
    static const refusal refusals[] = {
        {data, "data:application/octet-stream,", "\"data:", UNSUPPORTED},
        {data, "https://example.org/", "\"https:", UNSUPPORTED},
        {"base64,AA", "base64,A!", "!", FORMAT},
        {"AACAvg==\"", "AACAvg==A\"", "==A", FORMAT},
        {"AACAvg==\"", "AACAv\"", "v\"", FORMAT},
        {"\"uri\"", "\"url\"", "{\n      \"byteLength\": 244", UNSUPPORTED},
    };
    CHECK(refusals);
}

static void check_path(const char *uri, psplat_result code) {
    char *text = document_minimal(PSPLAT_SOURCE_DIR), quoted[64];
    char *start = text + document_find(text, "data:"), *end = strchr(start, '"');
    memmove(start, end, strlen(end) + 1);
    snprintf(quoted, sizeof quoted, "\"uri\": \"%s\"", uri);
    document_replace(&text, "\"uri\": \"\"", quoted);
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_asset_desc desc = {.base_path = "/nowhere"};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error);
    if (result != code || error.offset != document_find(text, quoted) + strlen("\"uri\": "))
        fail_msg("%s: %s", uri, error.text);
    free(text);
}

/* Files must lie below the document's directory; they are not looked for elsewhere. */
static void test_paths(void **state) {
    (void)state;
    check_path("a.bin", PSPLAT_ERROR_READ);
    check_path("a/..b/..../c.bin", PSPLAT_ERROR_READ);
    check_path("", UNSUPPORTED);
    check_path("/etc/passwd", UNSUPPORTED);
    check_path("%2fetc/passwd", UNSUPPORTED);
    check_path("../a.bin", UNSUPPORTED);
    check_path("a/../../b.bin", UNSUPPORTED);
    check_path("a/%2e%2E/b.bin", UNSUPPORTED);
    check_path("a/..", UNSUPPORTED);
    check_path("a\\\\..\\\\b.bin", UNSUPPORTED);
    check_path("file:///etc/passwd", UNSUPPORTED);
    check_path("C:/a.bin", UNSUPPORTED);
    check_path("C%3A/a.bin", UNSUPPORTED);
    check_path("a%00.bin", UNSUPPORTED);
    check_path("a%4", UNSUPPORTED);
    check_path("a%zz", UNSUPPORTED);
}

static void test_nodes(void **state) {
    (void)state;
    static const char node[] = "{ \"mesh\": 0, \"name\": \"minimal\" }";
    static const refusal refusals[] = {
        {node, "{ \"mesh\": 1 }", "1 }", RANGE},
        {node, "{ \"mesh\": 0, \"children\": [0] }", "0] }", RANGE},
        {node, "{ \"mesh\": 0, \"children\": [2] }", "2] }", RANGE},
        {node, "{ \"mesh\": 0, \"children\": 7 }", "7 }", FORMAT},
        {node, "{ \"mesh\": 0 }, { \"children\": [2] }, { \"children\": [1] }",
         "{ \"children\": [2]", RANGE},
        {node, "{ \"mesh\": 0 }, { \"children\": [2, 2] }, {}", "2] }", RANGE},
        {node, "{ \"mesh\": 0 }, { \"children\": [0] }", "0] }", RANGE},
        {node, "{ \"translation\": [1, 2] }", "[1, 2]", RANGE},
        {node, "{ \"rotation\": [0, 0, 0, 0] }", "[0, 0, 0, 0]", RANGE},
        {node, "{ \"rotation\": [0, 0, 0, 1.02] }", "[0, 0, 0, 1.02]", RANGE},
        {node, "{ \"scale\": [1, 1e999, 1] }", "1e999", RANGE},
        {node, "{ \"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2] }", "[1,0,0,0", RANGE},
        {node, "{ \"matrix\": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] }", "[1,0,0,1", RANGE},
        {node, "{ \"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], \"scale\": [1,1,1] }",
         "[1,0,0,0", FORMAT},
        {node, "{ \"scale\": [1e200,1,1], \"children\": [1] }, { \"scale\": [1e200,1,1] }",
         "{ \"scale\": [1e200,1,1] }", RANGE},
        {node, "{ \"mesh\": 0, \"scale\": [1e308,1e308,1e308] }", "{ \"mesh\": 0, \"scale\"",
         RANGE},
    };
    CHECK(refusals);
}

/* A tool that drops the extension's object leaves points, which the error names. A file without any
 * trace of splats gets the ordinary error. */
static void test_stripped(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    while (strstr(text, "\"PSPLAT_surface_splats\": {"))
        document_replace(&text, "\"PSPLAT_surface_splats\": {", "\"EXT_other\": {");
    check_text(text, &(refusal){"object", "nothing", "\"_PSPLAT_surface_splats:ROTATION",
                                PSPLAT_ERROR_NO_SPLATS});
    while (strstr(text, "\"_PSPLAT")) document_replace(&text, "\"_PSPLAT", "\"_OTHER");
    check_text(text, &(refusal){"names", "others", NULL, PSPLAT_ERROR_NO_SPLATS});
    free(text);
}

/* ---- values ------------------------------------------------------------------------------- */

/* Offsets in the rows that glb_writer.c writes for splats with two lines and without colour and
 * gradients, and the bytes of a row. Without lines, CLIP_0 is the row's end. */
enum { NORMAL = 12, ROTATION = 24, SCALE = 40, CLIP_0 = 48, CLIP_1 = 60, ROW = 72 };

enum { COUNT = 3, INDEX = 1 };

static uint32_t read_u32(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* Writes values into splat INDEX of an otherwise good file and expects RANGE at exactly that
 * place. */
static void check_values(size_t attribute, size_t attribute_size, const float *values) {
    scene s = scene_blank(COUNT);
    for (size_t i = 0; i < COUNT; ++i) {
        s.splats[i].clip_count = 2;
        s.splats[i].clip[0][0] = s.splats[i].clip[1][1] = 1;
    }
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    size_t bin = 20 + read_u32(data + 12) + 8;
    size_t at = bin + INDEX * ROW + attribute;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), PSPLAT_OK);
    psplat_asset_destroy(asset);
    memcpy(data + at, values, attribute_size);
    psplat_result result = psplat_asset_open_memory(data, size, NULL, &asset, &error);
    if (result != RANGE || error.offset != at)
        fail_msg("attribute at %zu, values %g %g %g: %s: %s at %zu, expected %zu", attribute,
                 (double)values[0], (double)values[1], (double)values[2],
                 psplat_result_text(result), error.text, error.offset, at);
    assert_non_null(strstr(error.text, "splat 1"));
    free(data);
    scene_free(&s);
}

static void test_values(void **state) {
    (void)state;
    check_values(0, 12, (float[]){NAN, 0, 0});
    check_values(0, 12, (float[]){0, 0, -INFINITY});
    check_values(NORMAL, 12, (float[]){0, 0, 0});
    check_values(NORMAL, 12, (float[]){0, 0, 1.02f});
    check_values(NORMAL, 12, (float[]){0, NAN, 1});
    check_values(NORMAL, 12, (float[]){1, 0, 0});
    check_values(NORMAL, 12, (float[]){0, 0, -1});
    check_values(NORMAL, 12, (float[]){0.9988f, 0, 0.049f}); /* N.NORMAL is just below 0.05 */
    check_values(ROTATION, 16, (float[]){0, 0, 0, 0});
    check_values(ROTATION, 16, (float[]){0, 0, 0, 0.98f});
    check_values(ROTATION, 16, (float[]){0, 0, INFINITY, 1});
    check_values(SCALE, 8, (float[]){1, 0, 0});
    check_values(SCALE, 8, (float[]){1, -1, 0});
    check_values(SCALE, 8, (float[]){1, 2, 0});
    check_values(SCALE, 8, (float[]){INFINITY, 1, 0});
    check_values(CLIP_0, 12, (float[]){0, 0, 1});
    check_values(CLIP_1, 12, (float[]){0, 0, 0});
    check_values(CLIP_1, 12, (float[]){1, 0, NAN});
}

/* Splats are decoded in blocks; the error names the splat at fault, whether it is the first or the
 * last of its block. */
static void test_blocks(void **state) {
    (void)state;
    enum { MANY = 300 };
    static const size_t places[] = {0, 127, 128, 255, 256, MANY - 1};
    scene s = scene_blank(MANY);
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    size_t bin = 20 + read_u32(data + 12) + 8;
    for (size_t i = 0; i < 2 * sizeof places / sizeof *places; ++i) {
        size_t splat = places[i / 2], attribute = i % 2 ? NORMAL : 0;
        size_t at = bin + splat * CLIP_0 + attribute;
        const float bad[3] = {0, i % 2 ? 0 : NAN, 0};
        uint8_t good[sizeof bad];
        char name[32];
        psplat_asset *asset = NULL;
        psplat_error error = {0};
        snprintf(name, sizeof name, "splat %zu:", splat);
        memcpy(good, data + at, sizeof good);
        memcpy(data + at, bad, sizeof bad);
        assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), RANGE);
        assert_int_equal(error.offset, at);
        assert_non_null(strstr(error.text, name));
        memcpy(data + at, good, sizeof good);
    }
    free(data);
    scene_free(&s);
}

/* Writes a field into a file whose first splat has a gamma. The slope of the normal is 0 or 3 /
 * 4. */
static void check_field(int tilted, const float gradient[3], psplat_result expected) {
    enum { FIELD = 48 };
    scene s = scene_blank(COUNT);
    s.splats[0].gradient[2] = 0.5f;
    for (size_t i = 0; i < COUNT; ++i) s.splats[i].radius[1] = 0.75f;
    if (tilted) s.splats[INDEX].normal[0] = 0.6f, s.splats[INDEX].normal[2] = 0.8f;
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    size_t at = 20 + read_u32(data + 12) + 8 + INDEX * (FIELD + 12) + FIELD;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    memcpy(data + at, gradient, 12);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), expected);
    if (expected) {
        assert_int_equal(error.offset, at);
        assert_non_null(strstr(error.text, "splat 1"));
        assert_non_null(strstr(error.text, "NORMAL_FIELD"));
    }
    psplat_asset_destroy(asset);
    free(data);
    scene_free(&s);
}

/* Tests the bound of spec 3.5, eq. (3a), from both sides; 16 * hypot(1, 0.75) is 20. */
static void test_fields(void **state) {
    (void)state;
    check_field(0, (float[]){20, 0, 0}, PSPLAT_OK);
    check_field(0, (float[]){0, 0, -16}, PSPLAT_OK);
    check_field(0, (float[]){12, -16, 0}, PSPLAT_OK);
    check_field(0, (float[]){20.01f, 0, 0}, RANGE);
    check_field(0, (float[]){0, -20.01f, 0}, RANGE);
    check_field(0, (float[]){0, 0, 16.01f}, RANGE);
    check_field(0, (float[]){12, -16, 1}, RANGE);
    check_field(0, (float[]){0, 0, 3e38f}, RANGE);
    check_field(0, (float[]){0, 0, NAN}, RANGE);
    check_field(0, (float[]){0, INFINITY, 0}, RANGE);
    check_field(1, (float[]){19.24f, 0, 0}, PSPLAT_OK);
    check_field(1, (float[]){19.26f, 0, 0}, RANGE);
}

/* A splat may be large, but the corners of its box must be floats. */
static void test_reach(void **state) {
    (void)state;
    scene s = scene_disc(1);
    s.splats[0].center[0] = s.splats[0].radius[0] = s.splats[0].radius[1] = 3e38f;
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), RANGE);
    assert_int_equal(error.offset, 20 + read_u32(data + 12) + 8 + SCALE);
    free(data);
    scene_free(&s);
}

static void test_color_range(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    /* Positions are read as colours: the second is 0, 1.5, 0. */
    document_replace(&text, "\"NORMAL\": 1", "\"NORMAL\": 1, \"COLOR_0\": 0");
    size_t base64 = document_find(text, "base64,") + 7;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error), RANGE);
    /* Splat 1 begins at byte 56 = 18 groups of three and two more: the error names the digit that
     * holds it. */
    assert_int_equal(error.offset, base64 + 18 * 4 + 2);
    free(text);
}

/* ---- containers --------------------------------------------------------------------------- */

static void check_patched(const uint8_t *data, size_t size, size_t at, uint32_t value,
                          psplat_result code, size_t offset) {
    uint8_t *copy = malloc(size);
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    assert_non_null(copy);
    memcpy(copy, data, size);
    for (int i = 0; i < 4; ++i) copy[at + (size_t)i] = (uint8_t)(value >> (8 * i));
    psplat_result result = psplat_asset_open_memory(copy, size, NULL, &asset, &error);
    if (result != code || error.offset != offset)
        fail_msg("%08x at %zu: %s: %s at %zu, expected %s at %zu", (unsigned)value, at,
                 psplat_result_text(result), error.text, error.offset, psplat_result_text(code),
                 offset);
    free(copy);
}

static void test_container(void **state) {
    (void)state;
    scene s = scene_disc(1);
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    size_t json_size = read_u32(data + 12), bin = 20 + json_size;
    check_patched(data, size, 0, 0x46546c66, FORMAT, 0);
    check_patched(data, size, 4, 1, UNSUPPORTED, 4);
    check_patched(data, size, 8, (uint32_t)size - 1, RANGE, 8);
    check_patched(data, size, 8, UINT32_MAX, RANGE, 8);
    check_patched(data, size, 12, UINT32_MAX, RANGE, 12);
    check_patched(data, size, 12, (uint32_t)json_size - 1, FORMAT, 12);
    check_patched(data, size, 12, (uint32_t)json_size - 2, FORMAT, 12);
    check_patched(data, size, 16, 0x004e4942, FORMAT, 16);
    check_patched(data, size, bin, (uint32_t)(size - bin), RANGE, bin);
    check_patched(data, size, bin, (uint32_t)(size - bin - 12), FORMAT, size - 4);
    check_patched(data, size, bin + 4, 0x4e4f534a, FORMAT, bin + 4);
    /* A chunk of any other type is skipped, so that the buffer has no bytes. */
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    memcpy(data + bin + 4, "ANY ", 4);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), UNSUPPORTED);
    free(data);
    scene_free(&s);
}

static void test_not_gltf(void **state) {
    (void)state;
    static const char *const texts[] = {"", "x", "glT", "solid cube", "\x89PNG", "[]", "ply\n"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        psplat_asset *asset = NULL;
        psplat_error error = {0};
        assert_int_equal(psplat_asset_open_memory(texts[i], strlen(texts[i]), NULL, &asset, &error),
                         FORMAT);
        assert_int_equal(error.offset, 0);
        assert_null(asset);
    }
}

int test_asset_refused_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_document),    cmocka_unit_test(test_extension_object),
        cmocka_unit_test(test_primitive),   cmocka_unit_test(test_accessor),
        cmocka_unit_test(test_uri),         cmocka_unit_test(test_paths),
        cmocka_unit_test(test_nodes),       cmocka_unit_test(test_stripped),
        cmocka_unit_test(test_values),      cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_fields),      cmocka_unit_test(test_reach),
        cmocka_unit_test(test_color_range), cmocka_unit_test(test_container),
        cmocka_unit_test(test_not_gltf),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
