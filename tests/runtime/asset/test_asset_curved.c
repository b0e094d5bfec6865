/* SPDX-License-Identifier: MIT
 *
 * test_asset_curved.c - tests what version 3 of the extension added: curved splats, shapes of their
 * own and bent clip lines. Expected values are computed from the specification's formulas, by other
 * means than the reader's.
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

#define HEAD(version, lines)                                                                       \
    "\"version\":" version ",\"clipLines\":" lines                                                 \
    ",\"depthTolerance\":0,\"positionExtent\":[0,0,0]"
#define CURVED HEAD("3", "0") ",\"curved\":true"

static psplat_asset *open_packed(const packed *p) {
    psplat_asset *asset = NULL;
    psplat_error error;
    char *text = packed_text(p);
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    free(text);
    return asset;
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

static void check_shape(const packed *p, const double expected[5], int has_shape) {
    psplat_asset *asset = open_packed(p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_true(batch->is_curved && batch->has_shape == has_shape && !batch->has_bends);
    /* Two roundings of numbers below 1, and those of a rotation and a normal where they count. */
    for (int k = 0; k < 5; ++k)
        assert_near((double)batch->splats->shape[k], expected[k], k < 2 ? 4e-7 : 6e-8);
    psplat_asset_destroy(asset);
}

/* ---- shapes --------------------------------------------------------------------------------- */

static const double field[3] = {0.5, -0.25, 0.125};

/* Beside TURN, the slope at the centre is TILT, which is 0 where it is not stored. */
static void test_beside_turn(void **state) {
    (void)state;
    static const double turn[1] = {0.375}, tilt[2] = {0.25, -0.5}, normal[3] = {0.6, 0, 0.8};
    packed p = packed_default();
    p.attributes[1].values = normal;
    p.attributes[2] = (packed_attribute){"TURN", PACKED_FLOAT, 1, 0, turn};
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, field};
    p.extension = CURVED;
    check_shape(&p, (double[]){0, 0, 0.5, -0.25, 0.125}, 0);
    p.attributes[5] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, tilt};
    check_shape(&p, (double[]){0.25, -0.5, 0.5, -0.25, 0.125}, 0);
}

/* Beside ROTATION, the slope follows from NORMAL (spec eq. 3). The rotation is by atan2(0.6, 0.8) =
 * 36.87 degrees about the y axis: U = (0.8, 0, -0.6), N = (0.6, 0, 0.8). */
static void test_beside_rotation(void **state) {
    (void)state;
    static const double rotation[4] = {0, 0.31622776601683794, 0, 0.94868329805051381};
    static const double normal[3] = {0, 0.6, 0.8};
    packed p = packed_default();
    p.attributes[1].values = normal;
    p.attributes[2].values = rotation;
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, field};
    p.extension = CURVED;
    check_shape(&p, (double[]){-0.48 / 0.64, 0.6 / 0.64, 0.5, -0.25, 0.125}, 0);
}

/* SHAPE takes the place of the field, which may be of any form, or be absent, and of its slope. */
static void test_own_shape(void **state) {
    (void)state;
    static const double normal[3] = {0, 0.6, 0.8}, shape[3] = {-127, 64, -32};
    packed p = packed_default();
    p.attributes[1].values = normal;
    p.attributes[4] = (packed_attribute){"SHAPE", PACKED_BYTE, 3, 0, shape};
    p.extension = CURVED ",\"shapeRange\":0.75";
    const double expected[5] = {0, 0, -0.75, 0.75 * 64 / 127, -0.75 * 32 / 127};
    check_shape(&p, expected, 1);
    p.attributes[5] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 2, 0, field};
    check_shape(&p, expected, 1);
    psplat_asset *asset = open_packed(&p);
    assert_true(psplat_asset_batch(asset, 0)->splats->gradient[0] == 0.5f);
    psplat_asset_destroy(asset);
}

/* Without "curved", or with it false, splats of version 3 are planes. */
static void test_flat(void **state) {
    (void)state;
    static const char *const extensions[] = {HEAD("3", "0"), HEAD("3", "0") ",\"curved\":false",
                                             HEAD("2", "0") ",\"curved\":false"};
    packed p = packed_default();
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, field};
    for (size_t i = 0; i < 3; ++i) {
        p.extension = extensions[i];
        psplat_asset *asset = open_packed(&p);
        const psplat_batch *batch = psplat_asset_batch(asset, 0);
        assert_true(!batch->is_curved && !batch->has_shape);
        for (int k = 0; k < 5; ++k) assert_true(batch->splats->shape[k] == 0);
        psplat_asset_destroy(asset);
    }
}

/* ---- bounds --------------------------------------------------------------------------------- */

/* Returns the point of a splat's surface at (u, v) in the splat's own axes (spec eq. 1a). */
static void point_at(const double radius[2], const double shape[5], double u, double v,
                     double point[3]) {
    double q = radius[1] / radius[0];
    point[0] = radius[0] * u;
    point[1] = radius[1] * v;
    point[2] = -radius[0] * (shape[0] * u + shape[2] * u * u / 2 + shape[4] * q * u * v +
                             q * shape[1] * v + q * shape[3] * v * v / 2);
}

static uint32_t next(uint32_t *random) {
    return *random = *random * 1664525u + 1013904223u;
}

static double part(uint32_t *random) {
    return (double)(next(random) >> 8) / (1 << 24);
}

static void scale_to_unit(double *values, int count) {
    double square = 0;
    for (int k = 0; k < count; ++k) square += values[k] * values[k];
    for (int k = 0; k < count; ++k) values[k] /= sqrt(square);
}

/* Turns a vector by a unit quaternion: v + 2 w (q x v) + 2 q x (q x v). */
static void turn(const double q[4], const double v[3], double out[3]) {
    double a[3] = {q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2], q[0] * v[1] - q[1] * v[0]};
    double b[3] = {q[1] * a[2] - q[2] * a[1], q[2] * a[0] - q[0] * a[2], q[0] * a[1] - q[1] * a[0]};
    for (int k = 0; k < 3; ++k) out[k] = v[k] + 2 * (q[3] * a[k] + b[k]);
}

/* The box holds every point of random curved splats, turned at random, and is no larger than the
 * box of their sphere. */
static void test_bounds(void **state) {
    (void)state;
    uint32_t random = 5;
    for (int i = 0; i < 300; ++i) {
        double rotation[4], radius[2], shape[5], normal[3];
        for (int k = 0; k < 4; ++k) rotation[k] = part(&random) - 0.5;
        scale_to_unit(rotation, 4);
        radius[0] = 0.5 + part(&random);
        radius[1] = radius[0] * (0.05 + 0.9 * part(&random));
        for (int k = 0; k < 5; ++k) shape[k] = 2.4 * part(&random) - 1.2;
        double slope[3] = {shape[0], shape[1], 1};
        scale_to_unit(slope, 3);
        turn(rotation, slope, normal);
        packed p = packed_default();
        p.attributes[1].values = normal;
        p.attributes[2].values = rotation;
        p.attributes[3].values = radius;
        p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, shape + 2};
        p.extension = CURVED;
        psplat_asset *asset = open_packed(&p);
        const psplat_batch *batch = psplat_asset_batch(asset, 0);
        for (int k = 0; k < 1000; ++k) {
            double angle = 6.283185307 * k / 1000, r = k % 4 ? 1 : part(&random), local[3], at[3];
            point_at(radius, shape, r * cos(angle), r * sin(angle), local);
            turn(rotation, local, at);
            for (int c = 0; c < 3; ++c) /* Radii, shapes and rotations are rounded to float. */
                assert_true(at[c] >= (double)batch->bounds_min[c] - 1e-6 &&
                            at[c] <= (double)batch->bounds_max[c] + 1e-6);
        }
        for (int c = 0; c < 3; ++c)
            assert_true((double)(batch->bounds_max[c] - batch->bounds_min[c]) < 10 * radius[0]);
        psplat_asset_destroy(asset);
    }
}

/* The boxes of a bowl and of a slope in the axes' own directions are exact: the first is 0.5 high
 * in the middle of its rim, the second as deep as its slope. */
static void test_tight_bounds(void **state) {
    (void)state;
    static const double bowl[3] = {-1, -1, 0}, none[3] = {0, 0, 0}, turned[1] = {0};
    static const double tilt[2] = {0.75, 0};
    packed p = packed_default();
    p.extension = CURVED;
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, bowl};
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_near((double)batch->bounds_min[2], 0, 1e-7);
    assert_near((double)batch->bounds_max[2], 0.5, 1e-7);
    assert_near((double)batch->bounds_max[0], 1, 1e-7);
    psplat_asset_destroy(asset);
    p.attributes[2] = (packed_attribute){"TURN", PACKED_FLOAT, 1, 0, turned};
    p.attributes[4].values = none;
    p.attributes[5] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, tilt};
    asset = open_packed(&p);
    batch = psplat_asset_batch(asset, 0);
    assert_near((double)batch->bounds_min[2], -0.75, 1e-7);
    assert_near((double)batch->bounds_max[2], 0.75, 1e-7);
    psplat_asset_destroy(asset);
}

/* ---- bent lines ----------------------------------------------------------------------------- */

static void test_bent_floats(void **state) {
    (void)state;
    static const double bent[4] = {0.6, -0.8, 0.25, -3.5}, straight[3] = {0, 1, 0.5};
    packed p = packed_default();
    p.attributes[4] = (packed_attribute){"CLIP_0", PACKED_FLOAT, 3, 0, straight};
    p.attributes[5] = (packed_attribute){"CLIP_1", PACKED_FLOAT, 4, 0, bent};
    p.extension = HEAD("3", "2");
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    const psplat_splat *splat = batch->splats;
    assert_true(batch->has_bends && !batch->is_curved);
    assert_true(splat->clip[0][1] == 1 && splat->clip[0][2] == 0.5f && splat->bend[0] == 0);
    assert_true(splat->clip[1][0] == 0.6f && splat->clip[1][1] == -0.8f);
    assert_true(splat->clip[1][2] == 0.25f && splat->bend[1] == -3.5f);
    psplat_asset_destroy(asset);
}

/* Two splats, so that unpacking three numbers to four is seen. */
static void test_bent_integers(void **state) {
    (void)state;
    static const double twice[12] = {0, 0, 0, 0, 0, 0}, normals[6] = {0, 0, 1, 0, 0, 1};
    static const double rotations[8] = {0, 0, 0, 1, 0, 0, 0, 1}, scales[4] = {1, 1, 1, 1};
    static const double bent[6] = {64, -127, 127, -32, 16, -64};
    packed p = packed_default();
    p.count = 2;
    p.attributes[0].values = twice;
    p.attributes[1].values = normals;
    p.attributes[2].values = rotations;
    p.attributes[3].values = scales;
    p.attributes[4] = (packed_attribute){"CLIP_0", PACKED_BYTE, 3, 0, bent};
    p.extension = HEAD("3", "1") ",\"clipRange\":[1,2],\"bendRange\":0.5";
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_int_equal(batch->has_bends, 1);
    for (int i = 0; i < 2; ++i) {
        const psplat_splat *splat = &batch->splats[i];
        double angle = 3.14159265358979 * bent[3 * i] / 127;
        assert_near((double)splat->clip[0][0], cos(angle), 4e-7); /* the turn is rounded */
        assert_near((double)splat->clip[0][1], sin(angle), 4e-7);
        assert_near((double)splat->clip[0][2], 2 * bent[3 * i + 1] / 127, 2e-7);
        assert_near((double)splat->bend[0], 0.5 * bent[3 * i + 2] / 127, 1e-7);
    }
    psplat_asset_destroy(asset);
}

/* ---- what is refused ------------------------------------------------------------------------ */

static void check_refused(packed_attribute attribute, const char *extension, psplat_result code,
                          const char *word) {
    packed p = packed_default();
    p.attributes[4] = attribute;
    p.extension = extension;
    refuse(&p, code, word);
}

/* Nothing of version 3 is in primitives of older versions. */
static void test_versions(void **state) {
    (void)state;
    static const double values[4] = {1, 0, 0, 0};
    const packed_attribute field3 = {"NORMAL_FIELD", PACKED_FLOAT, 3, 0, field};
    check_refused(field3, HEAD("1", "0") ",\"curved\":true", PSPLAT_ERROR_UNSUPPORTED, "true}}");
    check_refused(field3, HEAD("2", "0") ",\"curved\":true", PSPLAT_ERROR_UNSUPPORTED, "true}}");
    check_refused(field3, HEAD("3", "0") ",\"curved\":1", PSPLAT_ERROR_FORMAT, "1}}");
    const packed_attribute newer[] = {{"SHAPE", PACKED_FLOAT, 3, 0, values},
                                      {"SHAPE", PACKED_SHORT, 3, 0, values},
                                      {"CLIP_0", PACKED_FLOAT, 4, 0, values},
                                      {"CLIP_0", PACKED_SHORT, 3, 0, values}};
    for (size_t i = 0; i < 4; ++i) {
        check_refused(newer[i], i < 2 ? HEAD("2", "0") : HEAD("2", "1"), PSPLAT_ERROR_UNSUPPORTED,
                      "{\"bufferView\":4");
        check_refused(newer[i], i < 2 ? HEAD("1", "0") : HEAD("1", "1"), PSPLAT_ERROR_UNSUPPORTED,
                      "{\"bufferView\":4");
    }
}

/* Rule 18: SHAPE only in curved primitives, which have it or a field of three numbers. */
static void test_presence(void **state) {
    (void)state;
    const packed_attribute shape = {"SHAPE", PACKED_FLOAT, 3, 0, field};
    const packed_attribute field2 = {"NORMAL_FIELD", PACKED_FLOAT, 2, 0, field};
    check_refused(shape, HEAD("3", "0"), PSPLAT_ERROR_FORMAT, "4}");
    check_refused(field2, CURVED, PSPLAT_ERROR_FORMAT, "{\"POSITION\"");
    packed p = packed_default();
    p.extension = CURVED;
    refuse(&p, PSPLAT_ERROR_FORMAT, "{\"POSITION\"");
}

static void test_types_and_ranges(void **state) {
    (void)state;
    static const double values[4] = {1, 0, 0, 0};
    check_refused((packed_attribute){"SHAPE", PACKED_FLOAT, 2, 0, values}, CURVED,
                  PSPLAT_ERROR_UNSUPPORTED, "{\"bufferView\":4");
    check_refused((packed_attribute){"SHAPE", PACKED_UNSIGNED_BYTE, 3, 0, values}, CURVED,
                  PSPLAT_ERROR_UNSUPPORTED, "{\"bufferView\":4");
    check_refused((packed_attribute){"CLIP_0", PACKED_BYTE, 4, 0, values}, HEAD("3", "1"),
                  PSPLAT_ERROR_UNSUPPORTED, "{\"bufferView\":4");
    check_refused((packed_attribute){"CLIP_0", PACKED_FLOAT, 2, 0, values}, HEAD("3", "1"),
                  PSPLAT_ERROR_UNSUPPORTED, "{\"bufferView\":4");
    const packed_attribute shape = {"SHAPE", PACKED_SHORT, 3, 0, values};
    const packed_attribute line = {"CLIP_0", PACKED_SHORT, 3, 0, values};
    check_refused(shape, CURVED, PSPLAT_ERROR_FORMAT, "{\"version\":3");
    check_refused(shape, CURVED ",\"shapeRange\":0", PSPLAT_ERROR_RANGE, "0}}");
    check_refused(line, HEAD("3", "1"), PSPLAT_ERROR_FORMAT, "{\"version\":3");
    check_refused(line, HEAD("3", "1") ",\"bendRange\":-1", PSPLAT_ERROR_RANGE, "-1}}");
}

/* Spec eq. (1b): slopes of at most 4. With q = 1, gamma counts twice. */
static void test_steepness(void **state) {
    (void)state;
    static const double allowed[][3] = {{4, 0, 0}, {0, -4, 0}, {0, 0, 2.828}, {2, 2, 2}};
    static const double steep[][3] = {{4.001, 0, 0}, {0, -4.001, 0}, {0, 0, 2.829}, {2, 2, 2.01}};
    static const double turn_0[1] = {0}, tilt[2] = {1.2, 1.6}, rest[3] = {2.001, 0, 0};
    packed p = packed_default();
    p.extension = CURVED;
    for (size_t i = 0; i < 4; ++i) {
        const packed_attribute shapes[] = {{"SHAPE", PACKED_FLOAT, 3, 0, allowed[i]},
                                           {"NORMAL_FIELD", PACKED_FLOAT, 3, 0, allowed[i]}};
        for (size_t k = 0; k < 2; ++k) {
            p.attributes[4] = shapes[k];
            psplat_asset_destroy(open_packed(&p));
            p.attributes[4].values = steep[i];
            refuse(&p, PSPLAT_ERROR_RANGE, NULL);
        }
    }
    /* A slope of 2 at the centre leaves 2. */
    p.attributes[2] = (packed_attribute){"TURN", PACKED_FLOAT, 1, 0, turn_0};
    p.attributes[4] = (packed_attribute){"NORMAL_FIELD", PACKED_FLOAT, 3, 0, rest};
    psplat_asset_destroy(open_packed(&p));
    p.attributes[5] = (packed_attribute){"TILT", PACKED_FLOAT, 2, 0, tilt};
    refuse(&p, PSPLAT_ERROR_RANGE, NULL);
}

static void test_bend_values(void **state) {
    (void)state;
    static const double allowed[4] = {1, 0, 0, -4},
                        wrong[][4] = {
                            {1, 0, 0, 4.001}, {1, 0, 0, -4.001}, {1, 0, 0, INFINITY}, {0, 0, 1, 1}};
    packed p = packed_default();
    p.attributes[4] = (packed_attribute){"CLIP_0", PACKED_FLOAT, 4, 0, allowed};
    p.extension = HEAD("3", "1");
    psplat_asset_destroy(open_packed(&p));
    for (size_t i = 0; i < 4; ++i) {
        p.attributes[4].values = wrong[i];
        refuse(&p, PSPLAT_ERROR_RANGE, NULL);
    }
}

/* ---- the specification's example ------------------------------------------------------------ */

/* Section 7 says what the file holds. */
static void test_example(void **state) {
    (void)state;
    psplat_asset *asset = NULL;
    psplat_error error;
    const char *path = PSPLAT_SOURCE_DIR "/schema/curved.gltf";
    if (psplat_asset_open(path, NULL, &asset, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_asset_batch_count(asset), 2);
    const psplat_batch *plain = psplat_asset_batch(asset, 0), *own = psplat_asset_batch(asset, 1);
    assert_true(plain->is_curved && !plain->has_shape && plain->has_bends);
    assert_true(own->is_curved && own->has_shape && own->has_bends);
    const psplat_splat *saddle = plain->splats + 1, *trough = own->splats;
    const double radius[2] = {1, 0.5};
    double shape[5], at[3];
    for (int k = 0; k < 5; ++k) shape[k] = (double)saddle->shape[k];
    point_at(radius, shape, 1, 0, at);
    assert_near(at[2], -0.25, 0);
    point_at(radius, shape, 0, 1, at);
    assert_near(at[2], 0.125, 0);
    assert_true(trough->gradient[0] == 0 && trough->shape[0] == 0 && trough->shape[2] == -1);
    assert_near((double)trough->shape[3], 64.0 / 127, 1e-7);
    for (int k = 0; k < 3; ++k) /* the angle is rounded */
        assert_near((double)trough->clip[0][k], (double)saddle->clip[0][k], 2e-7);
    assert_near((double)trough->bend[0], -1, 1e-7);
    /* The saddle's greatest eigenvalue, halved: 0.0625 + sqrt(0.1875^2 + 0.0625^2). */
    assert_near((double)plain->bounds_min[2], -0.2601423, 1e-6);
    psplat_asset_destroy(asset);
}

int test_asset_curved_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_beside_turn),      cmocka_unit_test(test_beside_rotation),
        cmocka_unit_test(test_own_shape),        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_bounds),           cmocka_unit_test(test_tight_bounds),
        cmocka_unit_test(test_bent_floats),      cmocka_unit_test(test_bent_integers),
        cmocka_unit_test(test_versions),         cmocka_unit_test(test_presence),
        cmocka_unit_test(test_types_and_ranges), cmocka_unit_test(test_steepness),
        cmocka_unit_test(test_bend_values),      cmocka_unit_test(test_example),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
