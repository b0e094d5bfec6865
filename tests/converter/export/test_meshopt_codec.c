/* SPDX-License-Identifier: MIT
 *
 * test_meshopt_codec.c - tests of the EXT_meshopt_compression codec: compressed and plain files of
 * the same splats hold the same values, and each declares the extensions that it needs.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <string.h>
#include <cmocka.h>

#include "writer_fixture.h"

#include <meshoptimizer.h>
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "scene/scene.h"
#include "splats/splats.h"

static const psplat_write_desc compressed = {.codec = &psplat_meshopt_codec}, plain;

static const written everything = {.count = 500,
                                   .size = 1,
                                   .has_color = 1,
                                   .has_slopes = 1,
                                   .has_gradients = 1,
                                   .has_surface = 1,
                                   .has_emissive = 1};

/* Counts occurrences of a word in the JSON chunk. */
static size_t mentions(const uint8_t *data, const char *word) {
    char *text = writer_json(data);
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)) != NULL; at += strlen(word)) ++count;
    free(text);
    return count;
}

static void check_extensions(int is_coded, int is_packed, const char *required) {
    written w = everything;
    if (is_coded) w.precision = steps_of(w.size);
    psplat_splats s = writer_splats(&w, 3);
    size_t size;
    uint8_t *data = writer_file(&s, 1, is_packed ? &compressed : &plain, &size);
    assert_int_equal(mentions(data, "\"extensionsRequired\""), required != NULL);
    if (required) assert_int_equal(mentions(data, required), 1);
    assert_int_equal(mentions(data, "EXT_meshopt_compression") > 0, is_packed);
    assert_int_equal(mentions(data, "KHR_mesh_quantization"), is_coded ? 2 : 0);
    assert_int_equal(mentions(data, "\"extensionsUsed\":[\"PSPLAT_surface_splats\""), 1);
    free(data);
    psplat_splats_free(&s);
}

static void test_extensions(void **state) {
    (void)state;
    check_extensions(0, 0, NULL);
    check_extensions(1, 0, "\"extensionsRequired\":[\"KHR_mesh_quantization\"]");
    check_extensions(0, 1, "\"extensionsRequired\":[\"EXT_meshopt_compression\"]");
    check_extensions(
        1, 1, "\"extensionsRequired\":[\"KHR_mesh_quantization\",\"EXT_meshopt_compression\"]");
}

/* The codec restores every byte, for every row size that glTF allows, for one row and for several
 * blocks. */
static void test_bytes(void **state) {
    (void)state;
    static const size_t counts[] = {1, 15, 16, 17, 255, 256, 257, 1000};
    uint32_t random = 11;
    for (size_t stride = 4; stride <= 256; stride += 12)
        for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
            size_t size = counts[c] * stride, bound = psplat_meshopt_codec.bound(counts[c], stride);
            uint8_t *rows = writer_memory(size, 1), *packed = writer_memory(bound, 1);
            uint8_t *again = writer_memory(size, 1);
            for (size_t i = 0; i < size; ++i) rows[i] = (uint8_t)(255 * scene_random(&random));
            size_t packed_size =
                psplat_meshopt_codec.encode(packed, bound, rows, counts[c], stride);
            assert_in_range(packed_size, 1, bound);
            assert_int_equal(packed[0], 0xa0); /* the version that the extension prescribes */
            assert_int_equal(
                meshopt_decodeVertexBuffer(again, counts[c], stride, packed, packed_size), 0);
            assert_memory_equal(again, rows, size);
            free(rows);
            free(packed);
            free(again);
        }
}

static void test_smaller(void **state) {
    (void)state;
    written w = everything;
    w.count = 5000;
    w.precision = steps_of(w.size);
    psplat_splats s = writer_splats(&w, 3);
    size_t plain_size, packed_size;
    uint8_t *data = writer_file(&s, 1, &plain, &plain_size);
    uint8_t *packed = writer_file(&s, 1, &compressed, &packed_size);
    assert_true(packed_size < plain_size);
    free(data);
    free(packed);
    psplat_splats_free(&s);
}

/* Stands for a codec without room: the write fails, and no file is made. */
static size_t no_bytes(uint8_t *out, size_t capacity, const void *rows, size_t count,
                       size_t stride) {
    (void)out, (void)capacity, (void)rows, (void)count, (void)stride;
    return 0;
}

static size_t some(size_t rows, size_t stride) {
    return rows * stride;
}

static void test_failing_codec(void **state) {
    (void)state;
    static const psplat_codec failing = {.bound = some, .encode = no_bytes};
    const psplat_write_desc desc = {.codec = &failing};
    psplat_splats s = writer_splats(&everything, 3);
    psplat_scene scene = writer_scene(1);
    uint8_t *data = NULL;
    size_t size = 1;
    psplat_error error = {0};
    assert_int_equal(psplat_scene_write(&scene, &s, &desc, &data, &size, &error),
                     PSPLAT_ERROR_MEMORY);
    assert_null(data);
    assert_int_equal(size, 0);
    psplat_scene_free(&scene);
    psplat_splats_free(&s);
}

int test_meshopt_codec_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_extensions),
        cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_smaller),
        cmocka_unit_test(test_failing_codec),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
