/* SPDX-License-Identifier: MIT
 *
 * test_asset.c - tests what the asset reader makes of good files: every value, in every form that
 * glTF allows. Files come from the writer and from the bundled document with changed attributes,
 * nodes and buffers; expected values are those written, or follow from the glTF specification.
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

static psplat_asset *open_text(const char *text, const psplat_asset_desc *desc) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), desc, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    return asset;
}

static void assert_floats(const float *found, const float *expected, size_t count,
                          float tolerance) {
    for (size_t i = 0; i < count; ++i)
        if (!(fabsf(found[i] - expected[i]) <= tolerance))
            fail_msg("value %zu: %.9g, expected %.9g", i, (double)found[i], (double)expected[i]);
}

/* All values are equal bit by bit except the colour, which is stored with 16 bits: its tolerance is
 * half a step. */
static void assert_splat(const psplat_splat *found, const psplat_splat *expected) {
    assert_memory_equal(found->center, expected->center, sizeof found->center);
    assert_memory_equal(found->rotation, expected->rotation, sizeof found->rotation);
    assert_memory_equal(found->radius, expected->radius, sizeof found->radius);
    assert_memory_equal(found->normal, expected->normal, sizeof found->normal);
    assert_memory_equal(found->gradient, expected->gradient, sizeof found->gradient);
    assert_memory_equal(found->clip, expected->clip, sizeof found->clip);
    assert_int_equal(found->clip_count, expected->clip_count);
    assert_floats(found->color, expected->color, 4, 0.5001f / 65535);
}

static void test_round_trip(void **state) {
    (void)state;
    /* With fewer splats the writer would merge batches by giving some splats more lines. */
    enum { EACH = 200 };
    scene s = scene_ellipses(5 * EACH, 4, 11);
    s.kernel = (psplat_kernel){1.25f, 3.7f};
    s.depth_tolerance = 0.1f;
    s.origin[0] = 1e6 + 0.1;
    s.origin[1] = -1.0 / 3;
    s.material = (psplat_material){.base_color = {0.1f, 0.2f, 0.3f, 0.4f},
                                   .emissive = {0.25f, 0.5f, 4},
                                   .metallic = 0.6f,
                                   .roughness = 0.7f,
                                   .double_sided = 1};
    psplat_asset *asset = scene_open(&s);
    assert_int_equal(psplat_asset_batch_count(asset), 5);
    for (size_t k = 0; k < 5; ++k) {
        const psplat_batch *batch = psplat_asset_batch(asset, k);
        assert_int_equal(batch->clip_count, k);
        assert_int_equal(batch->splat_count, EACH);
        assert_int_equal(batch->has_color, 1);
        assert_memory_equal(&batch->kernel, &s.kernel, sizeof s.kernel);
        assert_true(batch->depth_tolerance == s.depth_tolerance);
        assert_memory_equal(&batch->material, &s.material, sizeof s.material);
        assert_memory_equal(batch->model + 12, s.origin, sizeof s.origin);
        for (size_t i = 0; i < EACH; ++i) assert_splat(&batch->splats[i], &s.splats[i * 5 + k]);
    }
    assert_null(psplat_asset_batch(asset, 5));
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_defaults(void **state) {
    (void)state;
    scene s = scene_disc(2);
    s.material.unlit = 1;
    psplat_asset *asset = scene_open(&s);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    static const float white[4] = {1, 1, 1, 1}, zero[3] = {0, 0, 0};
    assert_int_equal(batch->has_color, 0);
    assert_memory_equal(batch->splats[0].color, white, sizeof white);
    assert_memory_equal(batch->splats[0].gradient, zero, sizeof zero);
    assert_memory_equal(&batch->material, &s.material, sizeof s.material);
    assert_true(batch->kernel.sharpness == 2 && batch->kernel.exponent == 2);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_writes_are_equal(void **state) {
    (void)state;
    scene s = scene_ellipses(40, 4, 5);
    size_t sizes[2];
    uint8_t *first = scene_glb(&s, &sizes[0]), *second = scene_glb(&s, &sizes[1]);
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(first, second, sizes[0]);
    free(first);
    free(second);
    scene_free(&s);
}

/* An ellipse of radii 3 and 1 that is turned by 30 degrees about z reaches hypot(3 cos, sin) along
 * x. */
static void test_bounds(void **state) {
    (void)state;
    scene s = scene_disc(1);
    const double c = cos(0.5235987755982988), sine = 0.5;
    scene_set_axes(&s.splats[0], (double[]){c, sine, 0}, (double[]){-sine, c, 0});
    s.splats[0].radius[0] = 3;
    s.splats[0].center[2] = 5;
    s.origin[0] = 100;
    psplat_asset *asset = scene_open(&s);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    double min[3], max[3], reach[3] = {hypot(3 * c, sine), hypot(3 * sine, c), 0};
    psplat_asset_bounds(asset, min, max);
    for (int i = 0; i < 3; ++i) {
        double center = i == 2 ? 5 : 0, origin = i == 0 ? 100 : 0;
        /* The rotation has float precision: 1e-6 for an extent of 3. Boxes are never too small. */
        assert_true(fabs((double)batch->bounds_max[i] - (center + reach[i])) < 1e-6);
        assert_true(fabs((double)batch->bounds_min[i] - (center - reach[i])) < 1e-6);
        assert_true(fabs(max[i] - (origin + (double)batch->bounds_max[i])) < 1e-12);
        assert_true(fabs(min[i] - (origin + (double)batch->bounds_min[i])) < 1e-12);
    }
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* ---- the bundled document ----------------------------------------------------------------- */

static void check_minimal(const psplat_asset *asset) {
    static const float second_rotation[4] = {0, 0, 0.70710678f, 0.70710678f};
    static const float second_normal[3] = {0, 0.6f, 0.8f}, gradient[3] = {0.25f, 0.125f, 0};
    static const float clip[2][3] = {{1, 0, -0.25f}, {0, 1, -0.25f}};
    assert_int_equal(psplat_asset_batch_count(asset), 3);
    const psplat_batch *whole = psplat_asset_batch(asset, 0), *cut = psplat_asset_batch(asset, 2);
    assert_int_equal(whole->splat_count, 2);
    assert_memory_equal(whole->splats[0].gradient, gradient, sizeof gradient);
    assert_memory_equal(whole->splats[1].rotation, second_rotation, sizeof second_rotation);
    assert_memory_equal(whole->splats[1].normal, second_normal, sizeof second_normal);
    assert_true(whole->splats[1].center[1] == 1.5f);
    assert_int_equal(whole->material.double_sided, 1);
    assert_int_equal(cut->clip_count, 2);
    assert_memory_equal(cut->splats[0].clip, clip, sizeof clip);
    assert_true(cut->splats[0].center[0] == 4);
}

static void test_minimal(void **state) {
    (void)state;
    psplat_asset *asset = NULL;
    psplat_error error;
    psplat_result result =
        psplat_asset_open(PSPLAT_SOURCE_DIR "/schema/minimal.gltf", NULL, &asset, &error);
    if (result) fail_msg("%s (byte %zu)", error.text, error.offset);
    check_minimal(asset);
    psplat_asset_destroy(asset);
}

static void test_names_without_underscore(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    while (strstr(text, "\"_PSPLAT")) document_replace(&text, "\"_PSPLAT", "\"PSPLAT");
    psplat_asset *asset = open_text(text, NULL);
    check_minimal(asset);
    psplat_asset_destroy(asset);
    free(text);
}

/* Data URIs may have any media type, escaped slashes, and no padding. */
static void test_data_uris(void **state) {
    (void)state;
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    document_replace(&text, "data:application/octet-stream;base64,", "data:;base64,");
    document_replace(&text, "==\"", "\"");
    document_replace(&text, "AIA/AAAA", "AIA\\/AAAA");
    psplat_asset *asset = open_text(text, NULL);
    check_minimal(asset);
    psplat_asset_destroy(asset);
    free(text);
}

/* ---- other forms of attributes ------------------------------------------------------------ */

/* Makes a document of one splat; each test gives the buffer's bytes in base64 and the accessors. */
static char *one_splat(const char *attributes, const char *accessors, const char *base64,
                       int stride) {
    static const char format[] =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"PSPLAT_surface_splats\"],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"mode\":0,"
        "\"attributes\":{%s},\"extensions\":{\"PSPLAT_surface_splats\":{\"version\":1,"
        "\"clipLines\":0,\"depthTolerance\":0,\"positionExtent\":[0,0,0],\"future\":{}}}}]}],"
        "\"accessors\":[%s],\"bufferViews\":[{\"buffer\":0,\"byteLength\":52,\"byteStride\":%d}],"
        "\"buffers\":[{\"byteLength\":52,\"uri\":\"data:x;base64,%s\"}]}";
    char *text = malloc(4096);
    assert_non_null(text);
    assert_in_range(snprintf(text, 4096, format, attributes, accessors, stride, base64), 1, 4095);
    return text;
}

static void put_base64(const uint8_t *bytes, size_t size, char *out) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = (uint32_t)bytes[i] << 16;
        if (i + 1 < size) bits |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < size) bits |= bytes[i + 2];
        for (int k = 3; k >= 0; --k) *out++ = digits[bits >> (6 * k) & 63];
    }
    *out = 0;
}

/* Stores position and scale as floats, the rotation as four signed bytes or shorts, and the colour
 * as bytes. */
static void check_quantised(int rotation_type, const int rotation[4], const float expected[4]) {
    uint8_t bytes[54] = {0};
    char base64[80], accessors[1024];
    const float floats[8] = {1, 2, 3, 0, 0, 1, 0.5f, 0.25f};
    memcpy(bytes, floats, sizeof floats); /* the tests run on little-endian machines */
    for (int i = 0; i < 4; ++i) {
        unsigned value = (unsigned)rotation[i];
        if (rotation_type == 5120) {
            bytes[32 + i] = (uint8_t)value;
        } else {
            bytes[32 + 2 * i] = (uint8_t)value;
            bytes[33 + 2 * i] = (uint8_t)(value >> 8);
        }
    }
    const uint8_t color[4] = {255, 0, 51, 102};
    memcpy(bytes + 40, color, 4);
    put_base64(bytes, 54, base64);
    snprintf(accessors, sizeof accessors,
             "{\"bufferView\":0,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"},"
             "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,\"count\":1,"
             "\"type\":\"VEC3\"},"
             "{\"bufferView\":0,\"byteOffset\":24,\"componentType\":5126,\"count\":1,"
             "\"type\":\"VEC2\"},"
             "{\"bufferView\":0,\"byteOffset\":32,\"componentType\":%d,\"normalized\":true,"
             "\"count\":1,\"type\":\"VEC4\"},"
             "{\"bufferView\":0,\"byteOffset\":40,\"componentType\":5121,\"normalized\":true,"
             "\"count\":1,\"type\":\"VEC4\"}",
             rotation_type);
    char *text = one_splat("\"POSITION\":0,\"NORMAL\":1,\"_PSPLAT_surface_splats:SCALE\":2,"
                           "\"_PSPLAT_surface_splats:ROTATION\":3,\"COLOR_0\":4",
                           accessors, base64, 52);
    psplat_asset *asset = open_text(text, NULL);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    static const float color_expected[4] = {1, 0, 0.2f, 0.4f};
    assert_floats(batch->splats[0].rotation, expected, 4, 1e-6f); /* 1e-6: float rounding */
    assert_floats(batch->splats[0].color, color_expected, 4, 1e-7f);
    assert_true(batch->material.metallic == 1 && batch->material.roughness == 1);
    assert_int_equal(batch->has_color, 1);
    psplat_asset_destroy(asset);
    free(text);
}

static void test_quantised(void **state) {
    (void)state;
    /* The rotation is a quarter turn about z; (90, 90)/127 has length 1.0022 and is normalised.
     * -128 reads as -1. */
    check_quantised(5120, (int[]){0, 0, 90, 90}, (float[]){0, 0, 0.70710678f, 0.70710678f});
    check_quantised(5120, (int[]){0, 0, 0, -128}, (float[]){0, 0, 0, -1});
    check_quantised(5122, (int[]){0, 0, 19660, 26214},
                    (float[]){0, 0, 19660 / 32767.2f, 26214 / 32767.2f});
    check_quantised(5122, (int[]){0, 0, 0, -32768}, (float[]){0, 0, 0, -1});
}

/* ---- nodes -------------------------------------------------------------------------------- */

static void assert_matrix(const double *found, const double *expected) {
    for (int i = 0; i < 16; ++i)
        if (!(fabs(found[i] - expected[i]) < 1e-12))
            fail_msg("element %d: %.17g, expected %.17g", i, found[i], expected[i]);
}

static psplat_asset *open_with_nodes(const char *nodes_and_scenes) {
    char *text = document_minimal(PSPLAT_SOURCE_DIR);
    document_replace(&text, "\"scene\": 0,", "");
    document_replace(&text, "\"scenes\": [", "\"unused\": [");
    document_replace(&text, "\"nodes\": [\n", "\"others\": [\n");
    char *brace = strchr(text, '{');
    *brace = ' ';
    char *whole = malloc(strlen(text) + strlen(nodes_and_scenes) + 4);
    assert_non_null(whole);
    sprintf(whole, "{%s,%s", nodes_and_scenes, text);
    psplat_asset *asset = open_text(whole, NULL);
    free(text);
    free(whole);
    return asset;
}

/* A node with a translation, a quarter turn about z and a scale has a child whose matrix mirrors
 * x. */
static void test_node_transforms(void **state) {
    (void)state;
    psplat_asset *asset = open_with_nodes(
        "\"nodes\":[{\"mesh\":0,\"matrix\":[-1,0,0,0,0,1,0,0,0,0,1,0,1,0,0,1]},"
        "{\"children\":[0],\"translation\":[10,20,30],\"scale\":[2,3,4],"
        "\"rotation\":[0,0,0.7071067811865476,0.7071067811865476]}],\"scenes\":[{\"nodes\":[1]}]");
    /* (x, y, z) -> (-x + 1, y, z) -> (-2x + 2, 3y, 4z) -> (-3y, -2x + 2, 4z) -> + (10, 20, 30) */
    static const double expected[16] = {0, -2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 10, 22, 30, 1};
    assert_int_equal(psplat_asset_batch_count(asset), 3);
    assert_matrix(psplat_asset_batch(asset, 0)->model, expected);
    psplat_asset_destroy(asset);
}

/* Instances share splats and primitive numbers. They come unclipped ones first, each in its
 * place. */
static void test_instances(void **state) {
    (void)state;
    psplat_asset *asset = open_with_nodes(
        "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]},{\"mesh\":0}],"
        "\"scenes\":[{\"nodes\":[2]},{\"nodes\":[1,0]}],\"scene\":1");
    assert_int_equal(psplat_asset_batch_count(asset), 6);
    for (size_t i = 0; i < 6; ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i);
        assert_int_equal(batch->clip_count, i / 2);
        assert_int_equal(batch->primitive, i / 2);
        assert_ptr_equal(batch->splats, psplat_asset_batch(asset, i / 2 * 2)->splats);
        assert_true(batch->model[12] == (i % 2 ? 5 : 0));
    }
    psplat_asset_destroy(asset);
}

/* Without scenes all roots are shown; of several scenes without "scene" the first one is. */
static void test_scene_choice(void **state) {
    (void)state;
    psplat_asset *asset = open_with_nodes("\"nodes\":[{\"mesh\":0},{\"mesh\":0}]");
    assert_int_equal(psplat_asset_batch_count(asset), 6);
    psplat_asset_destroy(asset);
    asset = open_with_nodes("\"nodes\":[{\"mesh\":0},{\"mesh\":0}],"
                            "\"scenes\":[{\"nodes\":[1]},{\"nodes\":[0,1]}]");
    assert_int_equal(psplat_asset_batch_count(asset), 3);
    psplat_asset_destroy(asset);
}

/* A chain of nodes is much deeper than any stack; each node moves its child by 1. */
static void test_deep_nodes(void **state) {
    (void)state;
    enum { DEPTH = 50000 };
    char *nodes = malloc(DEPTH * 64), *out = nodes;
    assert_non_null(nodes);
    out += sprintf(out, "\"nodes\":[");
    for (int i = 0; i < DEPTH - 1; ++i)
        out += sprintf(out, "{\"children\":[%d],\"translation\":[1,0,0]},", i + 1);
    sprintf(out, "{\"mesh\":0}]");
    psplat_asset *asset = open_with_nodes(nodes);
    assert_true(psplat_asset_batch(asset, 0)->model[12] == DEPTH - 1);
    psplat_asset_destroy(asset);
    free(nodes);
}

/* ---- files -------------------------------------------------------------------------------- */

typedef struct fake_files {
    const char *path;
    const void *data;
    size_t size;
    int reads;
} fake_files;

static psplat_result read_fake(void *user, const psplat_allocator *allocator, const char *path,
                               size_t max_size, void **data, size_t *size) {
    fake_files *files = user;
    ++files->reads;
    if (strcmp(path, files->path)) return PSPLAT_ERROR_READ;
    if (files->size > max_size) return PSPLAT_ERROR_RANGE;
    *data = allocator->resize(allocator->user, NULL, 0, files->size);
    if (!*data) return PSPLAT_ERROR_MEMORY;
    memcpy(*data, files->data, files->size);
    *size = files->size;
    return PSPLAT_OK;
}

static size_t decode_base64(const char *digits, uint8_t *out) {
    static const char alphabet[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t bits = 0;
    size_t size = 0;
    for (size_t i = 0; strchr(alphabet, digits[i]) && digits[i]; ++i) {
        bits = bits << 6 | (uint32_t)(strchr(alphabet, digits[i]) - alphabet);
        if (i % 4) out[size++] = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    return size;
}

/* Puts the bytes of the bundled document into a file of the given URI. */
static char *externalise(const char *uri, uint8_t bytes[512], size_t *size) {
    char *text = document_minimal(PSPLAT_SOURCE_DIR), quoted[256];
    char *start = text + document_find(text, "data:");
    *size = decode_base64(strchr(start, ',') + 1, bytes);
    assert_int_equal(*size, 244);
    char *end = strchr(start, '"');
    memmove(start, end, strlen(end) + 1);
    snprintf(quoted, sizeof quoted, "\"uri\": \"%s\"", uri);
    document_replace(&text, "\"uri\": \"\"", quoted);
    return text;
}

static void test_external_buffer(void **state) {
    (void)state;
    uint8_t bytes[512];
    fake_files files = {.path = "some/where/a b/\xc3\xa9.bin", .data = bytes};
    char *text = externalise("a%20b/%C3%A9.bin", bytes, &files.size);
    psplat_asset_desc desc = {.files = {read_fake, &files}, .base_path = "some/where"};
    psplat_asset *asset = open_text(text, &desc);
    check_minimal(asset);
    assert_int_equal(files.reads, 1);
    psplat_asset_destroy(asset);
    free(text);
}

/* Opens files through stdio; the buffer lies beside the .gltf. */
static void test_files_on_disk(void **state) {
    (void)state;
    static const char gltf[] = PSPLAT_BINARY_DIR "/test_asset.gltf";
    static const char bin[] = PSPLAT_BINARY_DIR "/test_asset.bin";
    uint8_t bytes[512];
    size_t size = 0;
    char *text = externalise("test_asset.bin", bytes, &size);
    FILE *file = fopen(gltf, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    fclose(file);
    file = fopen(bin, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    psplat_asset *asset = NULL;
    psplat_error error;
    psplat_result result = psplat_asset_open(gltf, NULL, &asset, &error);
    if (result) fail_msg("%s", error.text);
    check_minimal(asset);
    psplat_asset_destroy(asset);

    psplat_asset_desc tight = {.max_file_size = strlen(text) + size - 1};
    assert_int_equal(psplat_asset_open(gltf, &tight, &asset, &error), PSPLAT_ERROR_RANGE);
    tight.max_file_size = strlen(text) + size;
    assert_int_equal(psplat_asset_open(gltf, &tight, &asset, &error), PSPLAT_OK);
    psplat_asset_destroy(asset);
    remove(bin);
    assert_int_equal(psplat_asset_open(gltf, NULL, &asset, &error), PSPLAT_ERROR_READ);
    assert_int_equal(error.offset, document_find(text, "\"test_asset.bin"));
    assert_non_null(strstr(error.text, "test_asset.bin"));
    remove(gltf);
    assert_int_equal(psplat_asset_open(gltf, NULL, &asset, &error), PSPLAT_ERROR_READ);
    assert_null(asset);
    free(text);
}

static void test_arguments(void **state) {
    (void)state;
    psplat_asset *asset = (psplat_asset *)(uintptr_t)1;
    double min[3], max[3];
    assert_int_equal(psplat_asset_open(NULL, NULL, &asset, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_null(asset);
    assert_int_equal(psplat_asset_open("x", NULL, NULL, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_asset_open_memory(NULL, 5, NULL, &asset, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_asset_open_memory("", 0, NULL, &asset, NULL), PSPLAT_ERROR_FORMAT);
    assert_int_equal(psplat_asset_batch_count(NULL), 0);
    assert_null(psplat_asset_batch(NULL, 0));
    psplat_asset_bounds(NULL, min, max);
    assert_true(min[0] > max[0]);
    psplat_asset_destroy(NULL);
}

int test_asset_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),       cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_writes_are_equal), cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_minimal),          cmocka_unit_test(test_names_without_underscore),
        cmocka_unit_test(test_data_uris),        cmocka_unit_test(test_quantised),
        cmocka_unit_test(test_node_transforms),  cmocka_unit_test(test_instances),
        cmocka_unit_test(test_scene_choice),     cmocka_unit_test(test_deep_nodes),
        cmocka_unit_test(test_external_buffer),  cmocka_unit_test(test_files_on_disk),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
