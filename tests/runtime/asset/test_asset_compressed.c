/* SPDX-License-Identifier: MIT
 *
 * test_asset_compressed.c - tests files with EXT_meshopt_compression: the values that come out are
 * those that went in, damaged files are refused, and files that announce too much are refused
 * before memory is requested.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"
#include "packed.h"

#include <math.h>
#include <phongsplat/phongsplat.h>
#include <stdlib.h>

enum { COUNT = 40 };

/* Splats that differ in every value. All values are integers except the radii. */
typedef struct sample {
    double positions[3 * COUNT], normals[3 * COUNT], rotations[4 * COUNT], radii[2 * COUNT];
    char extension[200];
    packed document;
} sample;

static sample *make_sample(void) {
    sample *s = calloc(1, sizeof *s);
    assert_non_null(s);
    uint32_t random = 7;
    for (size_t i = 0; i < COUNT; ++i) {
        double angle = (double)i * 0.03;
        for (size_t k = 0; k < 3; ++k) {
            random = random * 1664525u + 1013904223u;
            s->positions[3 * i + k] = random >> 16;
        }
        s->normals[3 * i + 2] = 1;
        s->rotations[4 * i + 2] = sin(angle);
        s->rotations[4 * i + 3] = cos(angle);
        s->radii[2 * i] = 4 + (double)i;
        s->radii[2 * i + 1] = 4 + 0.5 * (double)i;
    }
    double extent[3];
    for (size_t k = 0; k < 3; ++k) {
        double low = 65535, high = 0;
        for (size_t i = 0; i < COUNT; ++i) {
            low = fmin(low, s->positions[3 * i + k]);
            high = fmax(high, s->positions[3 * i + k]);
        }
        extent[k] = high - low;
    }
    snprintf(s->extension, sizeof s->extension,
             "\"version\":2,\"clipLines\":0,\"depthTolerance\":1,\"positionExtent\":[%g,%g,%g]",
             extent[0], extent[1], extent[2]);
    s->document = (packed){
        .count = COUNT,
        .attributes = {{"POSITION", PACKED_UNSIGNED_SHORT, 3, 1, s->positions},
                       {"NORMAL", PACKED_BYTE, 3, 0, s->normals},
                       {"ROTATION", PACKED_SHORT, 4, 0, s->rotations},
                       {"SCALE", PACKED_FLOAT, 2, 0, s->radii}},
        .extension = s->extension,
        .is_compressed = 1,
        .filters = {PACKED_NONE, PACKED_OCTAHEDRAL, PACKED_QUATERNION, PACKED_EXPONENTIAL}};
    return s;
}

static psplat_asset *open_text(const char *text) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    return asset;
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance)) fail_msg("%.17g, expected %.17g", found, expected);
}

static void check_splats(const psplat_asset *asset, const sample *s) {
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_int_equal(batch->splat_count, COUNT);
    for (size_t i = 0; i < COUNT; ++i) {
        const psplat_splat *splat = &batch->splats[i];
        double sign = (double)splat->rotation[3] * s->rotations[4 * i + 3] < 0 ? -1 : 1;
        for (size_t k = 0; k < 3; ++k) {
            assert_true((double)splat->center[k] == s->positions[3 * i + k]);
            assert_near((double)splat->normal[k], s->normals[3 * i + k], 1e-6);
        }
        /* The filter keeps 15 bits of the three smaller components. */
        for (size_t k = 0; k < 4; ++k)
            assert_near(sign * (double)splat->rotation[k], s->rotations[4 * i + k], 1e-4);
        for (size_t k = 0; k < 2; ++k) /* and 14 bits of radii up to 44 */
            assert_near((double)splat->radius[k], s->radii[2 * i + k], 64.0 / 16384);
    }
}

static void test_filters(void **state) {
    (void)state;
    sample *s = make_sample();
    char *text = packed_text(&s->document);
    psplat_asset *asset = open_text(text);
    check_splats(asset, s);
    psplat_asset_destroy(asset);
    free(text);
    free(s);
}

/* The sizes of the attributes add up to the size of the file's streams, except for a byte at the
 * beginning of each stream and its tail of 32 bytes. Zeros take a 64th of their size, noise all of
 * it and a 32nd more. */
static void test_sizes(void **state) {
    (void)state;
    enum { REPEATED = 20 * COUNT }; /* several blocks of the format */
    sample *s = make_sample();
    s->document.repeat = REPEATED / COUNT;
    char *text = packed_text(&s->document);
    psplat_asset *asset = open_text(text);
    assert_true(psplat_asset_batch(asset, 0)->attributes[0].stored == 0);
    psplat_asset_destroy(asset);
    psplat_asset_desc desc = {.measures = 1};
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error))
        fail_msg("%s", error.text);
    const psplat_attribute *attributes = psplat_asset_batch(asset, 0)->attributes;
    const char *at = text;
    for (size_t i = 0; i < 4; ++i) {
        size_t length = 0, buffer = 0, offset = 0;
        at = strstr(at, "{\"buffer\":0,\"byteOffset\":");
        assert_non_null(at);
        assert_int_equal(sscanf(at, "{\"buffer\":%zu,\"byteOffset\":%zu,\"byteLength\":%zu",
                                &buffer, &offset, &length),
                         3);
        ++at;
        /* Bytes of padding are in the stream but not in the attribute: they take two planes of
         * zeros at most. */
        assert_in_range(attributes[i].stored + 33, length - 2 * (REPEATED / 64 + 1), length);
        assert_true(attributes[i].is_compressed);
    }
    assert_int_equal(attributes[0].bytes, 6 * REPEATED);
    /* N is the same for all splats. */
    assert_in_range(attributes[1].stored, 3 * REPEATED / 64, 3 * REPEATED / 64 + 20);
    psplat_asset_destroy(asset);
    free(text);
    free(s);
}

/* Some attributes are compressed and the others are not; the keys of one object are changed for
 * that. */
static void test_some_plain(void **state) {
    (void)state;
    sample *s = make_sample();
    for (int i = 0; i < 4; ++i) s->document.filters[i] = PACKED_NONE;
    double normals[3 * COUNT], rotations[4 * COUNT];
    for (size_t i = 0; i < 3 * COUNT; ++i) normals[i] = s->normals[i] * 127;
    for (size_t i = 0; i < 4 * COUNT; ++i) rotations[i] = round(s->rotations[i] * 32767);
    s->document.attributes[1].values = normals;
    s->document.attributes[2].values = rotations;
    for (int is_compressed = 0; is_compressed < 2; ++is_compressed) {
        s->document.is_compressed = is_compressed;
        char *text = packed_text(&s->document);
        psplat_asset *asset = open_text(text);
        check_splats(asset, s);
        psplat_asset_destroy(asset);
        free(text);
    }
    free(s);
}

/* ---- what is refused ------------------------------------------------------------------------ */

typedef struct refusal {
    const char *from, *to, *at; /* at NULL: any place */
    psplat_result code;
} refusal;

static void check_refused(const sample *s, const refusal *r) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    char *text = packed_text(&s->document);
    document_replace(&text, r->from, r->to);
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != r->code || (r->at && error.offset != document_find(text, r->at)) || asset)
        fail_msg("%s -> %s: %s: %s at %zu", r->from, r->to, psplat_result_text(result), error.text,
                 error.offset);
    free(text);
}

#define STREAM "{\"buffer\":0,\"byteOffset\":0"
#define UNSUPPORTED PSPLAT_ERROR_UNSUPPORTED
#define FORMAT PSPLAT_ERROR_FORMAT
#define RANGE PSPLAT_ERROR_RANGE

static void test_objects_refused(void **state) {
    (void)state;
    static const refusal refusals[] = {
        {"\"mode\":\"ATTRIBUTES\"", "\"mode\":\"TRIANGLES\"", STREAM, UNSUPPORTED},
        {"\"mode\":\"ATTRIBUTES\"", "\"mode\":1", "1,\"filter\"", FORMAT},
        {"\"mode\":\"ATTRIBUTES\",", "", STREAM, FORMAT},
        {"\"filter\":\"NONE\"", "\"filter\":\"COLOR\"", STREAM, UNSUPPORTED},
        {"\"filter\":\"NONE\"", "\"filter\":null", "null", FORMAT},
        {"\"filter\":\"QUATERNION\"", "\"filter\":\"OCTAHEDRAL\"", NULL, RANGE},
        {"\"filter\":\"OCTAHEDRAL\"", "\"filter\":\"QUATERNION\"", NULL, RANGE},
        {"\"count\":40,\"mode\"", "\"count\":41,\"mode\"", STREAM, RANGE},
        {"\"count\":40,\"mode\"", "\"count\":0,\"mode\"", STREAM, RANGE},
        {"\"count\":40,\"mode\"", "\"count\":9007199254740992,\"mode\"", STREAM, RANGE},
        {"\"byteStride\":8,\"count\"", "\"byteStride\":0,\"count\"", STREAM, RANGE},
        {"\"byteStride\":8,\"count\"", "\"byteStride\":16,\"count\"", STREAM, RANGE},
        {"\"byteStride\":8,\"count\"", "\"byteStride\":260,\"count\"", "260", RANGE},
        {STREAM, "{\"buffer\":7,\"byteOffset\":0", "7,\"byteOffset\"", RANGE},
        {STREAM, "{\"buffer\":0,\"byteOffset\":65536", "{\"buffer\":0,\"byteOffset\":65536", RANGE},
        /* The empty fallback buffer. */
        {STREAM, "{\"buffer\":1,\"byteOffset\":0", NULL, UNSUPPORTED},
        {STREAM, "{\"buffer\":0,\"byteOffset\":9007199254740991",
         "{\"buffer\":0,\"byteOffset\":9007199254740991", RANGE},
        {"base64,o", "base64,4", NULL, FORMAT}, /* a stream of indices */
        {"\"fallback\":true", "\"fallback\":1", "1}}}", FORMAT},
    };
    sample *s = make_sample();
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i) check_refused(s, &refusals[i]);
    free(s);
}

/* Later versions of the library write 0xa1, which the extension does not allow. */
static void test_other_version(void **state) {
    (void)state;
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    sample *s = make_sample();
    char *text = packed_text(&s->document);
    char *second = text + document_find(text, "base64,o") + strlen("base64,o");
    *second = digits[strchr(digits, *second) - digits + 16];
    psplat_asset *asset = NULL;
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, NULL), FORMAT);
    free(text);
    free(s);
}

/* Streams of other modes that no splat uses are not looked at, whatever they hold. */
static void test_other_modes(void **state) {
    (void)state;
    sample *s = make_sample();
    char *text = packed_text(&s->document);
    document_replace(&text, "],\"buffers\"",
                     ",{\"buffer\":1,\"byteLength\":6,\"extensions\":{\"EXT_meshopt_compression\":"
                     "{\"buffer\":0,\"byteLength\":3,\"byteStride\":2,\"count\":3,"
                     "\"mode\":\"TRIANGLES\"}}}],\"buffers\"");
    psplat_asset *asset = open_text(text);
    check_splats(asset, s);
    psplat_asset_destroy(asset);
    free(text);
    free(s);
}

/* ---- memory --------------------------------------------------------------------------------- */

typedef struct counter {
    size_t bytes, peak, largest;
} counter;

static void *resize_counted(void *user, void *memory, size_t old_size, size_t new_size) {
    counter *c = user;
    c->bytes += new_size;
    c->bytes -= old_size;
    if (c->bytes > c->peak) c->peak = c->bytes;
    if (new_size > c->largest) c->largest = new_size;
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

static psplat_result open_counted(const char *text, size_t most, counter *c, psplat_error *error) {
    psplat_asset *asset = NULL;
    psplat_asset_desc desc = {.allocator = {resize_counted, c}, .max_file_size = most};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), &desc, &asset, error);
    psplat_asset_destroy(asset);
    assert_int_equal(c->bytes, 0);
    return result;
}

/* Zeros take a 64th of their size, which is as dense as the format gets. A stream that announces
 * more is refused before memory is requested. */
static void test_announces_too_much(void **state) {
    (void)state;
    static const double zeros[4] = {0};
    packed p = packed_default();
    p.is_compressed = 1;
    p.repeat = 2000;
    p.attributes[4] = (packed_attribute){"EMISSIVE", PACKED_UNSIGNED_BYTE, 3, 0, zeros};
    char *text = packed_text(&p);
    counter c = {0};
    psplat_error error;
    assert_int_equal(open_counted(text, 0, &c, &error), PSPLAT_OK);
    /* A splat and its finish take 184 bytes and 52 decoded ones; the rest is tokens and text. */
    assert_in_range(c.peak, 2000 * 184, 2000 * 236 + 64 * strlen(text));

    static const char stored[] = "\"byteLength\":24000,\"byteStride\":12,\"extensions\"";
    document_replace(&text, stored, "\"byteLength\":240000000,\"byteStride\":12,\"extensions\"");
    document_replace(&text, "\"count\":2000,\"mode\"", "\"count\":20000000,\"mode\"");
    document_replace(&text, "{\"byteLength\":104000,", "{\"byteLength\":1040000000,");
    c = (counter){0};
    assert_int_equal(open_counted(text, 0, &c, &error), PSPLAT_ERROR_RANGE);
    if (!strstr(error.text, "more than its bytes can hold")) fail_msg("%s", error.text);
    assert_true(c.largest < 100 * strlen(text));
    free(text);
}

/* max_file_size also limits the bytes that come out of compression. */
static void test_budget(void **state) {
    (void)state;
    packed p = packed_default();
    p.is_compressed = 1;
    p.repeat = 1000;
    char *text = packed_text(&p);
    counter c = {0};
    psplat_error error;
    size_t decoded = 1000 * (12 + 12 + 16 + 8);
    assert_int_equal(open_counted(text, strlen(text) + decoded, &c, &error), PSPLAT_OK);
    assert_int_equal(open_counted(text, strlen(text) + decoded - 1, &c, &error), RANGE);
    assert_non_null(strstr(error.text, "larger than allowed"));
    free(text);
}

/* Flips every bit of the compressed bytes, as far as base64 shows them, and tries every length. */
static void test_damage(void **state) {
    (void)state;
    sample *s = make_sample();
    char *text = packed_text(&s->document);
    size_t start = document_find(text, "base64,") + 7,
           end = document_find(text, "\"},{\"byteLength");
    for (size_t i = start; i < end; ++i) {
        char digit = text[i];
        counter c = {0};
        psplat_error error = {0};
        text[i] = digit == 'A' ? '/' : 'A';
        (void)open_counted(text, 0, &c, &error);
        assert_true(c.peak < 64 * strlen(text));
        text[i] = digit;
    }
    free(text);
    free(s);
}

int test_asset_compressed_main(void) {
    if (!packed_can_compress()) return 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_filters),     cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_some_plain),  cmocka_unit_test(test_objects_refused),
        cmocka_unit_test(test_other_modes), cmocka_unit_test(test_other_version),
        cmocka_unit_test(test_budget),      cmocka_unit_test(test_announces_too_much),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
