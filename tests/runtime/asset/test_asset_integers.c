/* SPDX-License-Identifier: MIT
 *
 * test_asset_integers.c - tests what version 2 of the extension added: integers for every attribute
 * (spec 3.9), turns and tilts instead of rotations, lines of two numbers, and materials that vary
 * (spec 3.10). Expected values are computed from the specification's formulas, by other means than
 * the reader's.
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

static const double pi = 3.14159265358979323846;

#define EXTENSION(members)                                                                         \
    "\"version\":2,\"clipLines\":0,\"depthTolerance\":0,\"positionExtent\":[0,0,0]" members

static psplat_asset *open_packed(const packed *p) {
    psplat_asset *asset = NULL;
    psplat_error error;
    char *text = packed_text(p);
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    free(text);
    return asset;
}

static const psplat_splat *splats_of(const psplat_asset *asset) {
    return psplat_asset_batch(asset, 0)->splats;
}

/* Expects an error with the code at the first occurrence of the word in the text (NULL:
 * anywhere). */
static void refuse(const packed *p, psplat_result code, const char *word) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    char *text = packed_text(p);
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != code || (word && error.offset != document_find(text, word)))
        fail_msg("%s (byte %zu): %s", psplat_result_text(result), error.offset, error.text);
    assert_null(asset);
    free(text);
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance)) fail_msg("%.17g, expected %.17g", found, expected);
}

/* ---- positions and normals ------------------------------------------------------------------ */

/* Positions may be plain or normalized integers of all types of KHR_mesh_quantization. */
static void check_positions(int type, int is_plain, const double stored[6],
                            const double expected[6]) {
    packed p = packed_default();
    char extension[200];
    static const double normals[6] = {0, 0, 1, 0, 0, 1}, scales[4] = {1, 1, 1, 1};
    static const double rotations[8] = {0, 0, 0, 1, 0, 0, 0, 1};
    p.count = 2;
    p.attributes[0] = (packed_attribute){"POSITION", type, 3, is_plain, stored};
    p.attributes[1].values = normals;
    p.attributes[2].values = rotations;
    p.attributes[3].values = scales;
    snprintf(
        extension, sizeof extension,
        "\"version\":2,\"clipLines\":0,\"depthTolerance\":0,\"positionExtent\":[%.9g,%.9g,%.9g]",
        fabs(expected[3] - expected[0]), fabs(expected[4] - expected[1]),
        fabs(expected[5] - expected[2]));
    p.extension = extension;
    psplat_asset *asset = open_packed(&p);
    for (size_t i = 0; i < 6; ++i)
        assert_near((double)splats_of(asset)[i / 3].center[i % 3], (double)(float)expected[i], 0);
    psplat_asset_destroy(asset);
}

static void test_positions(void **state) {
    (void)state;
    const double unsigned_shorts[6] = {0, 1, 65535, 65535, 32768, 7}, shorts[6] = {-32768, 0, 5};
    const double unsigned_bytes[6] = {0, 255, 128, 3, 2, 1}, bytes[6] = {-128, 127, -1, 1, 0, 64};
    check_positions(PACKED_UNSIGNED_SHORT, 1, unsigned_shorts, unsigned_shorts);
    check_positions(PACKED_SHORT, 1, shorts, shorts);
    check_positions(PACKED_UNSIGNED_BYTE, 1, unsigned_bytes, unsigned_bytes);
    check_positions(PACKED_BYTE, 1, bytes, bytes);
    /* Quotients are rounded to float in the same way, so that they must be equal. */
    double parts[6];
    for (int i = 0; i < 6; ++i) parts[i] = (double)((float)unsigned_shorts[i] / 65535.0f);
    check_positions(PACKED_UNSIGNED_SHORT, 0, unsigned_shorts, parts);
    for (int i = 0; i < 6; ++i) parts[i] = fmax((double)((float)bytes[i] / 127.0f), -1);
    check_positions(PACKED_BYTE, 0, bytes, parts);
}

/* Rounding to bytes changes a normal's length; the reader makes it 1 again. The components are off
 * by 0.0068 at most. */
static void test_normals(void **state) {
    (void)state;
    const double normal[3] = {73, -73, 73}; /* 1 / sqrt(3) would be 73.3 */
    packed p = packed_default();
    p.attributes[1] = (packed_attribute){"NORMAL", PACKED_BYTE, 3, 0, normal};
    psplat_asset *asset = open_packed(&p);
    for (int i = 0; i < 3; ++i)
        assert_near((double)splats_of(asset)->normal[i], (i == 1 ? -1 : 1) / sqrt(3), 1e-7);
    psplat_asset_destroy(asset);
    const double short_normal[3] = {0, 16384, 28377}; /* sin and cos of 30 degrees */
    p.attributes[1] = (packed_attribute){"NORMAL", PACKED_SHORT, 3, 0, short_normal};
    asset = open_packed(&p);
    assert_near((double)splats_of(asset)->normal[1], 0.5, 2e-5); /* half a step is 1.5e-5 */
    psplat_asset_destroy(asset);
    const double wrong[3] = {0, 0, 120};
    p.attributes[1] = (packed_attribute){"NORMAL", PACKED_BYTE, 3, 0, wrong};
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
}

/* ---- rotations ------------------------------------------------------------------------------ */

/* Computes spec 3.3, eq. (0), step by step; N is normalised. */
static void axes_of(const double normal[3], double t, double axes[3][3]) {
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int i = 0; i < 3; ++i) axes[2][i] = normal[i] / length;
    const double *N = axes[2];
    double s = N[2] < 0 ? -1 : 1, a = -1 / (s + N[2]), b = N[0] * N[1] * a;
    const double b1[3] = {1 + s * N[0] * N[0] * a, s * b, -s * N[0]};
    const double b2[3] = {b, s + N[1] * N[1] * a, -N[1]};
    for (int i = 0; i < 3; ++i) axes[0][i] = cos(pi * t) * b1[i] + sin(pi * t) * b2[i];
    axes[1][0] = N[1] * axes[0][2] - N[2] * axes[0][1];
    axes[1][1] = N[2] * axes[0][0] - N[0] * axes[0][2];
    axes[1][2] = N[0] * axes[0][1] - N[1] * axes[0][0];
}

static void assert_axes(const float q[4], double expected[3][3]) {
    double x = (double)q[0], y = (double)q[1], z = (double)q[2], w = (double)q[3];
    const double axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                               {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                               {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
    /* The tolerance covers four roundings of a float quaternion, each doubled, and those of N and t
     * as floats. */
    for (int i = 0; i < 9; ++i) assert_near(axes[i / 3][i % 3], expected[i / 3][i % 3], 6e-7);
}

/* turn is of the given type, from 0 to 1 or, as a float, from -1 to 1; x and y tilt the normal. */
static void check_turn(const double normal[3], int type, double turn, double x, double y) {
    packed p = packed_default();
    double largest = type == PACKED_FLOAT ? 1 : type == PACKED_UNSIGNED_BYTE ? 255 : 65535;
    const double tilts[2] = {x, y};
    double expected[3][3], length = sqrt(1 + x * x + y * y);
    axes_of(normal, turn / largest, expected);
    p.attributes[1].values = normal;
    p.attributes[2] = (packed_attribute){"TURN", type, 1, 0, &turn};
    p.attributes[4] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, tilts};
    if (x == 0 && y == 0) p.attributes[4].name = NULL;
    psplat_asset *asset = open_packed(&p);
    assert_axes(splats_of(asset)->rotation, expected);
    for (int i = 0; i < 3; ++i)
        assert_near((double)splats_of(asset)->normal[i],
                    (expected[2][i] + x * expected[0][i] + y * expected[1][i]) / length, 6e-7);
    psplat_asset_destroy(asset);
}

static void test_turns(void **state) {
    (void)state;
    static const double hard[][3] = {
        {0, 0, 1},      {0, 0, -1}, {1, 0, 0},        {0, -1, 0},          {0.6, 0.8, -0.0},
        {0.6, -0.8, 0}, {-1, 0, 0}, {0.6, 0.8, 1e-6}, {-0.6, -0.8, -1e-6}, {1e-7, 0, -1},
    };
    for (size_t i = 0; i < sizeof hard / sizeof *hard; ++i)
        for (int k = -4; k <= 4; ++k) check_turn(hard[i], PACKED_FLOAT, k / 4.0, 0, 0.25 * k);
    uint32_t random = 1;
    for (int i = 0; i < 500; ++i) {
        double n[3], length = 0;
        for (int k = 0; k < 3; ++k) {
            random = random * 1664525u + 1013904223u;
            n[k] = (double)(random >> 8) - (1 << 23);
            length += n[k] * n[k];
        }
        for (int k = 0; k < 3; ++k) n[k] /= sqrt(length);
        random = random * 1664525u + 1013904223u;
        check_turn(n, PACKED_UNSIGNED_BYTE, random >> 24, 0.5, -0.125 * (i % 8));
        check_turn(n, PACKED_UNSIGNED_SHORT, random >> 16, -1, 0);
    }
}

/* N of bytes is normalised first; tilts are parts of their range. */
static void test_turn_of_integers(void **state) {
    (void)state;
    const double normal[3] = {73, -73, -73}, tilts[2] = {127, -32}, turn = 51;
    double expected[3][3], x = 0.5, y = -0.5 * 32 / 127, length = sqrt(1 + x * x + y * y);
    packed p = packed_default();
    p.attributes[1] = (packed_attribute){"NORMAL", PACKED_BYTE, 3, 0, normal};
    p.attributes[2] = (packed_attribute){"TURN", PACKED_UNSIGNED_BYTE, 1, 0, &turn};
    p.attributes[4] = (packed_attribute){"TILT", PACKED_BYTE, 2, 0, tilts};
    p.extension = EXTENSION(",\"tiltRange\":0.5");
    psplat_asset *asset = open_packed(&p);
    axes_of(normal, 0.2, expected);
    assert_axes(splats_of(asset)->rotation, expected);
    for (int i = 0; i < 3; ++i)
        assert_near((double)splats_of(asset)->normal[i],
                    (expected[2][i] + x * expected[0][i] + y * expected[1][i]) / length, 6e-7);
    psplat_asset_destroy(asset);
}

static void test_turns_refused(void **state) {
    (void)state;
    const double values[3] = {0, 0, 1.25}, identity[4] = {0, 0, 0, 1};
    packed p = packed_default();
    p.attributes[2] = (packed_attribute){"TURN", PACKED_FLOAT, 1, 0, values + 2};
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
    p.attributes[2].values = values;
    p.attributes[4] = (packed_attribute){"TILT", PACKED_SHORT, 2, 0, values};
    refuse(&p, PSPLAT_ERROR_FORMAT, "{\"version\":2"); /* tiltRange is missing */
    p.attributes[4] = (packed_attribute){"ROTATION", PACKED_FLOAT, 4, 0, identity};
    refuse(&p, PSPLAT_ERROR_FORMAT, "2,\"_PSPLAT_surface_splats:SCALE");
    p.attributes[2] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, values};
    refuse(&p, PSPLAT_ERROR_FORMAT, "{\"POSITION\""); /* TURN is missing */
    /* Spec 3.5: the least cosine is 0.05, whose tangent is 19.97. */
    const double steep[2] = {0, 19.98};
    p = packed_default();
    p.attributes[2] = (packed_attribute){"TURN", PACKED_FLOAT, 1, 0, values};
    p.attributes[4] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, steep};
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
}

/* ---- radii ---------------------------------------------------------------------------------- */

static void check_radii(int type, double u, double v, double expected_u) {
    packed p = packed_default();
    const double stored[2] = {u, v};
    double largest = type == PACKED_UNSIGNED_BYTE ? 255 : 65535;
    p.attributes[3] = (packed_attribute){"SCALE", type, 2, 0, stored};
    p.extension = EXTENSION(",\"scaleRange\":[0.001,20]");
    psplat_asset *asset = open_packed(&p);
    const float *radius = splats_of(asset)->radius;
    /* The tolerance covers the rounding of the part, times ln 20000, and of the radius. */
    assert_near((double)radius[0] / (0.001 * pow(20000, expected_u / largest)), 1, 8e-7);
    assert_near((double)radius[1] / (0.001 * pow(20000, v / largest)), 1, 8e-7);
    assert_true(radius[0] >= radius[1]);
    psplat_asset_destroy(asset);
}

static void test_radii(void **state) {
    (void)state;
    check_radii(PACKED_UNSIGNED_SHORT, 65535, 0, 65535);
    check_radii(PACKED_UNSIGNED_SHORT, 40000, 30000, 40000);
    check_radii(PACKED_UNSIGNED_BYTE, 255, 255, 255);
    check_radii(PACKED_UNSIGNED_BYTE, 17, 16, 17);
    /* The smaller radius may exceed the other by a step; then it gets the value of the other. */
    check_radii(PACKED_UNSIGNED_SHORT, 65534, 65535, 65535);
    check_radii(PACKED_UNSIGNED_BYTE, 0, 1, 1);
    packed p = packed_default();
    const double inverted[2] = {100, 102};
    p.extension = EXTENSION(",\"scaleRange\":[0.001,20]");
    p.attributes[3] = (packed_attribute){"SCALE", PACKED_UNSIGNED_SHORT, 2, 0, inverted};
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
    /* All radii are equal, and as extreme as floats can be. */
    static const double ends[2] = {65535, 0};
    p.attributes[3].values = ends;
    p.extension = EXTENSION(",\"scaleRange\":[0.75,0.75]");
    psplat_asset *asset = open_packed(&p);
    assert_true(splats_of(asset)->radius[0] == 0.75f && splats_of(asset)->radius[1] == 0.75f);
    psplat_asset_destroy(asset);
    p.extension = EXTENSION(",\"scaleRange\":[1e-38,1e38]");
    asset = open_packed(&p);
    assert_near((double)splats_of(asset)->radius[0] / 1e38, 1, 1e-7);
    assert_near((double)splats_of(asset)->radius[1] / 1e-38, 1, 1e-7);
    psplat_asset_destroy(asset);
}

/* ---- fields and lines ----------------------------------------------------------------------- */

static void test_fields(void **state) {
    (void)state;
    packed p = packed_default();
    const double stored[3] = {127, -64, -128};
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_BYTE, 3, 0, stored};
    p.extension = EXTENSION(",\"fieldRange\":1.5");
    psplat_asset *asset = open_packed(&p);
    const float *gradient = splats_of(asset)->gradient;
    assert_true(gradient[0] == 1.5f && gradient[2] == -1.5f);
    assert_near((double)gradient[1], -1.5 * 64 / 127, 1e-7);
    psplat_asset_destroy(asset);
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_SHORT, 2, 0, stored};
    asset = open_packed(&p);
    assert_near((double)splats_of(asset)->gradient[1], -1.5 * 64 / 32767, 1e-9);
    assert_int_equal(psplat_asset_batch(asset, 0)->has_gamma, 0);
    psplat_asset_destroy(asset);
    /* Spec 3.5, eq. (3a): the bound is 20. */
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_BYTE, 3, 0, stored};
    p.extension = EXTENSION(",\"fieldRange\":15");
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
}

static void test_lines(void **state) {
    (void)state;
    static const double stored[][2] = {{0, 32767}, {16384, -16384}, {-32768, 0},     {-8192, 1},
                                       {32767, 3}, {24576, -32768}, {-24575, 20000}, {-16384, 5}};
    for (size_t i = 0; i + 1 < sizeof stored / sizeof *stored; ++i) {
        packed p = packed_default();
        p.attributes[4] = (packed_attribute){"CLIP_0", PACKED_SHORT, 2, 0, stored[i]};
        p.attributes[5] = (packed_attribute){"CLIP_1", PACKED_SHORT, 2, 0, stored[i + 1]};
        p.extension = "\"version\":2,\"clipLines\":2,\"depthTolerance\":0,"
                      "\"positionExtent\":[0,0,0]";
        psplat_asset *asset = open_packed(&p);
        assert_int_equal(splats_of(asset)->clip_count, 2);
        for (size_t k = 0; k < 2; ++k) {
            const double *line = stored[i + k];
            const float *found = splats_of(asset)->clip[k];
            double t = fmax(line[0] / 32767, -1);
            /* The tolerance covers the rounding of t as a float, times pi, and that of the
             * result. */
            assert_near((double)found[0], cos(pi * t), 2e-7);
            assert_near((double)found[1], sin(pi * t), 2e-7);
            assert_near((double)found[2], fmax(line[1] / 32767, -1), 6e-8);
        }
        psplat_asset_destroy(asset);
    }
}

/* Integers of few bits stand for parts of a turn, by clipRange and turnRange. */
static void test_narrow_turns(void **state) {
    (void)state;
    packed p = packed_default();
    const double line[2] = {-5, 3}, turn[1] = {11}, normal[3] = {0, 0, 1};
    p.attributes[2] = (packed_attribute){"TURN", PACKED_UNSIGNED_BYTE, 1, 0, turn};
    p.attributes[4] = (packed_attribute){"CLIP_0", PACKED_BYTE, 2, 0, line};
    p.extension = "\"version\":2,\"clipLines\":1,\"depthTolerance\":0,\"positionExtent\":[0,0,0],"
                  "\"turnRange\":15.9375,\"clipRange\":[15.875,31.75]";
    psplat_asset *asset = open_packed(&p);
    const float *clip = splats_of(asset)->clip[0];
    double expected[3][3];
    axes_of(normal, 11.0 / 16, expected);
    assert_axes(splats_of(asset)->rotation, expected);
    assert_near((double)clip[0], cos(pi * 5 / 8), 3e-7); /* tolerance as in test_lines */
    assert_near((double)clip[1], -sin(pi * 5 / 8), 3e-7);
    assert_near((double)clip[2], 0.75, 6e-8);
    psplat_asset_destroy(asset);
    p.extension = "\"version\":2,\"clipLines\":1,\"depthTolerance\":0,\"positionExtent\":[0,0,0],"
                  "\"turnRange\":24,\"clipRange\":[1,1]";
    refuse(&p, PSPLAT_ERROR_RANGE, NULL); /* it is more than a half turn */
    p.extension = "\"version\":2,\"clipLines\":1,\"depthTolerance\":0,\"positionExtent\":[0,0,0],"
                  "\"clipRange\":[1,65537]";
    refuse(&p, PSPLAT_ERROR_RANGE, "[1,65537]");
    p.extension = "\"version\":2,\"clipLines\":1,\"depthTolerance\":0,\"positionExtent\":[0,0,0],"
                  "\"clipRange\":[0,1]";
    refuse(&p, PSPLAT_ERROR_RANGE, "[0,1]");
}

/* ---- materials that vary -------------------------------------------------------------------- */

static void test_finishes(void **state) {
    (void)state;
    packed p = packed_default();
    const double u[3] = {127, 0, -127}, v[3] = {32767, -16384, 0}, orm[3] = {0, 51, 255};
    const double emissive[3] = {65535, 0, 13107};
    p.attributes[4] = (packed_attribute){"COLOR_U", PACKED_BYTE, 3, 0, u};
    p.attributes[5] = (packed_attribute){"COLOR_V", PACKED_SHORT, 3, 0, v};
    p.attributes[6] =
        (packed_attribute){"OCCLUSION_ROUGHNESS_METALLIC", PACKED_UNSIGNED_BYTE, 3, 0, orm};
    p.attributes[7] = (packed_attribute){"EMISSIVE", PACKED_UNSIGNED_SHORT, 3, 0, emissive};
    p.extension = EXTENSION(",\"colorRange\":0.5");
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_non_null(batch->finishes);
    const psplat_finish *finish = batch->finishes;
    assert_true(finish->color_u[0] == 0.5f && finish->color_u[2] == -0.5f);
    assert_near((double)finish->color_v[1], -0.5 * 16384 / 32767, 1e-7);
    assert_true(finish->occlusion == 0 && finish->metallic == 1);
    assert_near((double)finish->roughness, 0.2, 1e-7);
    assert_true(finish->emissive[0] == 1 && finish->emissive[1] == 0);
    assert_near((double)finish->emissive[2], 0.2, 1e-7);
    assert_int_equal(batch->has_color, 0);
    assert_int_equal(batch->attribute_count, 8);
    psplat_asset_destroy(asset);
}

/* Values that are not stored are those of a splat without finish. */
static void test_finish_defaults(void **state) {
    (void)state;
    packed p = packed_default();
    const double emissive[3] = {0.25, 0.5, 0.75}, orm[3] = {0.5, 0.25, 0.125};
    p.attributes[4] = (packed_attribute){"EMISSIVE", PACKED_FLOAT, 3, 0, emissive};
    psplat_asset *asset = open_packed(&p);
    const psplat_finish *finish = psplat_asset_batch(asset, 0)->finishes;
    assert_true(finish->occlusion == 1 && finish->roughness == 1 && finish->metallic == 1);
    assert_true(finish->color_u[0] == 0 && finish->color_v[2] == 0 && finish->emissive[2] == 0.75f);
    psplat_asset_destroy(asset);
    p.attributes[4] = (packed_attribute){"OCCLUSION_ROUGHNESS_METALLIC", PACKED_FLOAT, 3, 0, orm};
    asset = open_packed(&p);
    finish = psplat_asset_batch(asset, 0)->finishes;
    assert_true(finish->occlusion == 0.5f && finish->roughness == 0.25f);
    assert_true(finish->metallic == 0.125f && finish->emissive[1] == 1);
    psplat_asset_destroy(asset);
    p.attributes[4].name = NULL;
    asset = open_packed(&p);
    assert_null(psplat_asset_batch(asset, 0)->finishes);
    psplat_asset_destroy(asset);
}

/* ---- what is refused ------------------------------------------------------------------------ */

static void check_refused(packed_attribute attribute, size_t at, const char *extension,
                          psplat_result code, const char *word) {
    packed p = packed_default();
    p.attributes[at] = attribute;
    p.extension = extension;
    refuse(&p, code, word);
}

#define VERSION_1 "\"version\":1,\"clipLines\":0,\"depthTolerance\":0,\"positionExtent\":[0,0,0]"

/* In version 1 all values are floats, except rotations and colours, and there is one material. */
static void test_version_1(void **state) {
    (void)state;
    static const double values[4] = {0, 0, 1, 0};
    static const packed_attribute newer[] = {
        {"POSITION", PACKED_SHORT, 3, 1, values},
        {"NORMAL", PACKED_BYTE, 3, 0, values},
        {"TURN", PACKED_FLOAT, 1, 0, values},
        {"SCALE", PACKED_UNSIGNED_BYTE, 2, 0, values},
        {"NORMAL_FIELD", PACKED_BYTE, 3, 0, values},
        {"EMISSIVE", PACKED_FLOAT, 3, 0, values},
        {"OCCLUSION_ROUGHNESS_METALLIC", PACKED_UNSIGNED_BYTE, 3, 0, values},
    };
    for (size_t i = 0; i < sizeof newer / sizeof *newer; ++i) {
        char word[40];
        snprintf(word, sizeof word, "{\"bufferView\":%zu", i < 4 ? i : (size_t)4);
        check_refused(newer[i], i < 4 ? i : 4, VERSION_1, PSPLAT_ERROR_UNSUPPORTED, word);
    }
}

static void test_types(void **state) {
    (void)state;
    static const double values[4] = {0, 0, 1, 0};
    static const struct {
        size_t at;
        packed_attribute attribute;
    } wrong[] = {
        {1, {"NORMAL", PACKED_BYTE, 3, 1, values}}, /* it is not normalized */
        {1, {"NORMAL", PACKED_UNSIGNED_BYTE, 3, 0, values}},
        {2, {"ROTATION", PACKED_SHORT, 3, 0, values}},
        {2, {"ROTATION", PACKED_UNSIGNED_SHORT, 4, 0, values}},
        {2, {"TURN", PACKED_BYTE, 1, 0, values}},
        {2, {"TURN", PACKED_FLOAT, 2, 0, values}},
        {3, {"SCALE", PACKED_SHORT, 2, 0, values}},
        {4, {"CLIP_0", PACKED_FLOAT, 2, 0, values}},
        {4, {"CLIP_0", PACKED_SHORT, 3, 0, values}},
        {4, {"EMISSIVE", PACKED_UNSIGNED_BYTE, 4, 0, values}},
        {4, {"EMISSIVE", PACKED_SHORT, 3, 0, values}},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        char word[40];
        int is_line = wrong[i].attribute.name[0] == 'C';
        snprintf(word, sizeof word, "{\"bufferView\":%zu", wrong[i].at);
        check_refused(wrong[i].attribute, wrong[i].at,
                      is_line ? "\"version\":2,\"clipLines\":1,\"depthTolerance\":0,"
                                "\"positionExtent\":[0,0,0]"
                              : EXTENSION(",\"scaleRange\":[1,2]"),
                      PSPLAT_ERROR_UNSUPPORTED, word);
    }
}

static void test_ranges(void **state) {
    (void)state;
    static const double values[3] = {1, 1, 1};
    const packed_attribute scale = {"SCALE", PACKED_UNSIGNED_BYTE, 2, 0, values};
    const packed_attribute field = {"NORMAL_FIELD", PACKED_BYTE, 2, 0, values};
    const packed_attribute color = {"COLOR_U", PACKED_BYTE, 3, 0, values};
    check_refused(scale, 3, EXTENSION(""), PSPLAT_ERROR_FORMAT, "{\"version\":2");
    check_refused(scale, 3, EXTENSION(",\"scaleRange\":[0,1]"), PSPLAT_ERROR_RANGE, "[0,1]");
    check_refused(scale, 3, EXTENSION(",\"scaleRange\":[2,1]"), PSPLAT_ERROR_RANGE, "[2,1]");
    check_refused(scale, 3, EXTENSION(",\"scaleRange\":[1,1e39]"), PSPLAT_ERROR_RANGE, "[1,1e39]");
    check_refused(scale, 3, EXTENSION(",\"scaleRange\":[1]"), PSPLAT_ERROR_RANGE, "[1]");
    check_refused(scale, 3, EXTENSION(",\"scaleRange\":1"), PSPLAT_ERROR_FORMAT, "1}}");
    check_refused(field, 4, EXTENSION(""), PSPLAT_ERROR_FORMAT, "{\"version\":2");
    check_refused(field, 4, EXTENSION(",\"fieldRange\":0"), PSPLAT_ERROR_RANGE, "0}}");
    check_refused(field, 4, EXTENSION(",\"fieldRange\":-1"), PSPLAT_ERROR_RANGE, "-1}}");
    check_refused(color, 4, EXTENSION(",\"colorRange\":1"), PSPLAT_ERROR_FORMAT,
                  "{\"POSITION\""); /* COLOR_V is missing */
    packed p = packed_default();
    p.attributes[4] = color;
    p.attributes[5] = (packed_attribute){"COLOR_V", PACKED_FLOAT, 3, 0, values};
    refuse(&p, PSPLAT_ERROR_FORMAT, "{\"version\":2");
}

static void test_values(void **state) {
    (void)state;
    static const double above[3] = {0.5, 1.001, 0}, below[3] = {0.5, -0.001, 0};
    static const char *const names[] = {"EMISSIVE", "OCCLUSION_ROUGHNESS_METALLIC"};
    for (size_t i = 0; i < 2; ++i) {
        const packed_attribute high = {names[i], PACKED_FLOAT, 3, 0, above};
        const packed_attribute low = {names[i], PACKED_FLOAT, 3, 0, below};
        check_refused(high, 4, EXTENSION(""), PSPLAT_ERROR_RANGE, NULL);
        check_refused(low, 4, EXTENSION(""), PSPLAT_ERROR_RANGE, NULL);
    }
}

/* ---- the specification's example ------------------------------------------------------------ */

static void test_example(void **state) {
    (void)state;
    psplat_asset *asset = NULL;
    psplat_error error;
    const char *path = PSPLAT_SOURCE_DIR "/schema/integers.gltf";
    if (psplat_asset_open(path, NULL, &asset, &error)) fail_msg("%s", error.text);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    const psplat_splat *first = batch->splats, *second = first + 1;
    assert_int_equal(batch->splat_count, 2);
    assert_near(batch->model[0], 0.001, 1e-15);
    assert_near((double)first->radius[0], 500, 1e-4); /* float rounding, as everywhere here */
    assert_near((double)first->radius[1], 250, 1e-4);
    assert_near((double)second->radius[1], 500, 1e-4);
    assert_true(second->center[0] == 1000 && second->center[2] == 250);
    const double normal[3] = {0, 1, 1}, x = 0.5 * 64 / 127, y = -0.5;
    double axes[3][3], length = sqrt(1 + x * x + y * y);
    axes_of(normal, 128.0 / 255, axes);
    assert_axes(second->rotation, axes);
    for (int i = 0; i < 3; ++i)
        assert_near((double)second->normal[i],
                    (axes[2][i] + x * axes[0][i] + y * axes[1][i]) / length, 6e-7);
    assert_near((double)batch->finishes[1].occlusion, 0.2, 1e-7);
    assert_near((double)batch->finishes[0].roughness, 128.0 / 255, 1e-7);
    assert_true(batch->finishes[0].metallic == 0 && batch->finishes[1].metallic == 1);
    psplat_asset_destroy(asset);
}

int test_asset_integers_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_positions),       cmocka_unit_test(test_normals),
        cmocka_unit_test(test_turns),           cmocka_unit_test(test_turn_of_integers),
        cmocka_unit_test(test_turns_refused),   cmocka_unit_test(test_radii),
        cmocka_unit_test(test_fields),          cmocka_unit_test(test_lines),
        cmocka_unit_test(test_narrow_turns),    cmocka_unit_test(test_finishes),
        cmocka_unit_test(test_finish_defaults), cmocka_unit_test(test_version_1),
        cmocka_unit_test(test_types),           cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_values),          cmocka_unit_test(test_example),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
