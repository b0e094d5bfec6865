/* SPDX-License-Identifier: MIT
 *
 * test_glb.c - tests the glTF writer on sets of one to three splats: what it refuses, what it
 * leaves out, and that nothing outside the splats influences the file.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "export/glb_writer.h"
#include "splats/splats.h"
#include "scene_asset.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>

/* A set of one splat together with its runs and its material. */
typedef struct single {
    psplat_splat splat[3];
    psplat_run runs[2];
    psplat_material material;
} single;

/* Makes one splat with the given number of clip lines and a default material. */
static psplat_splats one(single *s, uint32_t clip_lines) {
    psplat_splat *splat = s->splat;
    *splat = (psplat_splat){.rotation = {0, 0, 0, 1},
                            .radius = {1, 1},
                            .normal = {0, 0, 1},
                            .color = {1, 1, 1, 1},
                            .clip_count = clip_lines};
    for (uint32_t k = 0; k < clip_lines; ++k) splat->clip[k][0] = 1;
    s->runs[0] = (psplat_run){.count = 1, .clip_lines = clip_lines};
    s->material = (psplat_material){.base_color = {1, 1, 1, 1}, .metallic = 1, .roughness = 1};
    return (psplat_splats){.splats = splat,
                           .count = 1,
                           .runs = s->runs,
                           .run_count = 1,
                           .materials = &s->material,
                           .material_count = 1,
                           .kernel = {2, 2}};
}

/* Returns the JSON of a written file, terminated; the caller frees it. */
static char *write_json(const psplat_splats *splats, const char *name) {
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_error error;
    if (psplat_glb_write(splats, name, NULL, &data, &size, &error)) fail_msg("%s", error.text);
    size_t json_size = (size_t)data[12] | (size_t)data[13] << 8 | (size_t)data[14] << 16;
    char *json = malloc(json_size + 1);
    assert_non_null(json);
    memcpy(json, data + 20, json_size);
    json[json_size] = 0;
    psplat_asset *asset = NULL;
    if (psplat_asset_open_memory(data, size, NULL, &asset, &error)) fail_msg("%s", error.text);
    psplat_asset_destroy(asset);
    free(data);
    return json;
}

static void assert_holds(const psplat_splats *splats, const char *name, const char *word,
                         int expected) {
    char *json = write_json(splats, name);
    if ((strstr(json, word) != NULL) != expected)
        fail_msg("%s %s: %s", word, expected ? "is missing" : "is there", json);
    free(json);
}

static void assert_refused(const psplat_splats *splats, psplat_result expected, const char *word) {
    uint8_t *data = (uint8_t *)1;
    size_t size = 1;
    psplat_error error = {0};
    assert_int_equal(psplat_glb_write(splats, NULL, NULL, &data, &size, &error), expected);
    assert_null(data);
    assert_int_equal(size, 0);
    if (word) assert_non_null(strstr(error.text, word));
}

static void test_refuses(void **state) {
    (void)state;
    single s;
    psplat_splats splats = one(&s, 1);
    uint8_t *data;
    size_t size;
    assert_int_equal(psplat_glb_write(NULL, NULL, NULL, &data, &size, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_glb_write(&splats, NULL, NULL, NULL, &size, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    psplat_splats empty = {0};
    assert_refused(&empty, PSPLAT_ERROR_NO_SPLATS, NULL);
    s.splat->clip_count = 0; /* differs from the run that counts it */
    assert_refused(&splats, PSPLAT_ERROR_ARGUMENT, NULL);
    s.splat->clip_count = 1;
    s.runs[0].count = 2; /* one more than there are */
    assert_refused(&splats, PSPLAT_ERROR_ARGUMENT, NULL);
    s.runs[0].count = 0; /* an empty run */
    assert_refused(&splats, PSPLAT_ERROR_ARGUMENT, NULL);
    s.runs[0].count = 1;
    splats.count = 2; /* one less than there are */
    assert_refused(&splats, PSPLAT_ERROR_ARGUMENT, NULL);
    splats.count = 1;
    s.runs[0].material = 1;
    assert_refused(&splats, PSPLAT_ERROR_ARGUMENT, NULL);
    s.runs[0].material = 0;
    s.splat->clip[0][2] = NAN;
    assert_refused(&splats, PSPLAT_ERROR_RANGE, NULL);
    s.splat->clip[0][2] = 0;
    s.splat->center[1] = INFINITY;
    assert_refused(&splats, PSPLAT_ERROR_RANGE, "POSITION");
}

/* Only what the model needs is in the file. */
static void test_leaves_out_defaults(void **state) {
    (void)state;
    static const char *const words[] = {"COLOR_0",   "NORMAL_FIELD", "CLIP_",
                                        "materials", "kernel",       "translation",
                                        "name",      "KHR_",         "\"material\""};
    single s;
    psplat_splats splats = one(&s, 0);
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        assert_holds(&splats, NULL, words[i], 0);
    s.splat->gradient[1] = 1e-30f;
    splats.has_color = 1;
    splats.kernel.sharpness = 3;
    splats.origin[2] = 5;
    s.material.unlit = 1;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (strcmp(words[i], "CLIP_")) assert_holds(&splats, "x", words[i], 1);
}

/* Where one splat has a gamma, all splats with as many lines have one stored, and no others. */
static void test_gradients(void **state) {
    (void)state;
    single s;
    psplat_splats splats = one(&s, 1);
    psplat_splat *splat = s.splat;
    splat[2] = splat[0];
    one(&s, 0);
    splat[1] = splat[0];
    s.runs[0].count = 2;
    /* The runs stay apart, because their depth tolerances differ. */
    s.runs[1] = (psplat_run){.count = 1, .clip_lines = 1, .depth_tolerance = 1};
    splats.count = 3;
    splats.run_count = 2;
    splat[0].gradient[0] = splat[2].gradient[1] = 0.5f;
    assert_holds(&splats, NULL, "\"count\":2,\"type\":\"VEC2\"},", 1);
    splat[1].gradient[2] = -0.25f;
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_asset *asset = NULL;
    assert_int_equal(psplat_glb_write(&splats, NULL, NULL, &data, &size, NULL), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, NULL), PSPLAT_OK);
    const psplat_batch *uncut = psplat_asset_batch(asset, 0), *cut = psplat_asset_batch(asset, 1);
    assert_int_equal(uncut->attributes[4].components, 3);
    assert_true(uncut->has_gamma && !cut->has_gamma);
    assert_int_equal(cut->attributes[4].components, 2);
    for (size_t i = 0; i < 2; ++i)
        assert_memory_equal(uncut->splats[i].gradient, splat[i].gradient, 3 * sizeof(float));
    assert_memory_equal(cut->splats[0].gradient, splat[2].gradient, 3 * sizeof(float));
    psplat_asset_destroy(asset);
    free(data);
}

/* Numbers are written as the shortest decimals that read back exactly. */
static void test_numbers(void **state) {
    (void)state;
    single s;
    psplat_splats splats = one(&s, 0);
    s.runs[0].depth_tolerance = 0.1f;
    splats.origin[0] = 0.1;
    splats.origin[1] = 1.0 / 3;
    splats.origin[2] = -1e21;
    s.splat->center[0] = 16777216;
    s.splat->center[1] = 3.4028235e38f;
    s.splat->center[2] = 1e-45f;
    assert_holds(&splats, NULL, "\"depthTolerance\":0.1,", 1);
    assert_holds(&splats, NULL, "\"translation\":[0.1,0.3333333333333333,-1e+21]", 1);
    assert_holds(&splats, NULL, "\"min\":[16777216,3.4028235e+38,1e-45]", 1);
    assert_holds(&splats, NULL, "\"positionExtent\":[0,0,0]", 1);
}

/* Where printf writes 0,1 the file must still say 0.1. */
static void test_numbers_with_comma(void **state) {
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8")) skip();
    test_numbers(state);
    setlocale(LC_NUMERIC, "C");
}

static void test_names(void **state) {
    (void)state;
    single s;
    psplat_splats splats = one(&s, 0);
    assert_holds(&splats, "a \"b\" \\ \n", "\"a \\u0022b\\u0022 \\u005c \\u000a\"", 1);
    assert_holds(&splats, "\xc3\xa9 \xf0\x9f\x98\x80", "\"\xc3\xa9 \xf0\x9f\x98\x80\"", 1);
    /* These names are not UTF-8: a Latin-1 letter, a cut sequence, a surrogate, an overlong
     * slash. */
    assert_holds(&splats, "\xe9t", "\"\xef\xbf\xbdt\"", 1);
    assert_holds(&splats, "x\xe2\x82", "\"x\xef\xbf\xbd\xef\xbf\xbd\"", 1);
    assert_holds(&splats, "\xed\xa0\x80", "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"", 1);
    assert_holds(&splats, "\xc0\xaf", "\"\xef\xbf\xbd\xef\xbf\xbd\"", 1);
}

/* Emissive factors of glTF end at 1; the excess goes into an extension. An unlit material has none
 * at all. */
static void test_emissive(void **state) {
    (void)state;
    single s;
    psplat_splats splats = one(&s, 0);
    s.material.emissive[1] = 0.5f;
    assert_holds(&splats, NULL, "\"emissiveFactor\":[0,0.5,0]", 1);
    assert_holds(&splats, NULL, "emissive_strength", 0);
    s.material.emissive[1] = 8;
    assert_holds(&splats, NULL, "\"emissiveFactor\":[0,1,0]", 1);
    assert_holds(&splats, NULL, "\"emissiveStrength\":8", 1);
    s.material.unlit = 1;
    assert_holds(&splats, NULL, "emissive", 0);
}

int test_glb_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refuses),
        cmocka_unit_test(test_leaves_out_defaults),
        cmocka_unit_test(test_gradients),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_numbers_with_comma),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_emissive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
