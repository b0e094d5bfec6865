/* SPDX-License-Identifier: MIT
 *
 * test_color_errors.c - tests of the errors of looks, on samples set by hand: a black floor (x < 0)
 * next to a white one.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"
#include "features/samples.h"
#include "features/surface.h"
#include "material/mipmap.h"
#include "measure/color_errors.h"
#include "mesh/mesh.h"

enum { COUNT = 41 };
static const double single = 1e-4; /* %: a few roundings of floats */

/* Samples 0.25 apart along x, from -5 to 5. */
typedef struct floor_samples {
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_samples samples;
    double positions[3 * COUNT];
    float normals[3 * COUNT], colors[4 * COUNT], finishes[3 * COUNT], emissive[3 * COUNT];
    uint32_t triangles[COUNT];
    float shown[COUNT * PSPLAT_LOOK_VALUES];
    double errors[COUNT];
} floor_samples;

/* All is shown as it is. */
static void make_floor(floor_samples *f) {
    memset(f, 0, sizeof *f);
    f->mesh.material = (psplat_material){
        .base_color = {1, 1, 1, 1}, .emissive = {1, 1, 1}, .roughness = 1, .metallic = 1};
    f->surface.mesh = &f->mesh;
    for (size_t i = 0; i < COUNT; ++i) {
        float paint = i > COUNT / 2 ? 1 : 0;
        f->positions[3 * i] = 0.25 * (double)i - 5;
        f->normals[3 * i + 2] = 1;
        for (size_t k = 0; k < 3; ++k) f->colors[4 * i + k] = paint;
        f->finishes[3 * i + 1] = 0.5f;
    }
    f->samples = (psplat_samples){.positions = f->positions,
                                  .normals = f->normals,
                                  .colors = f->colors,
                                  .finishes = f->finishes,
                                  .emissive = f->emissive,
                                  .triangles = f->triangles,
                                  .count = COUNT};
    for (size_t i = 0; i < COUNT; ++i)
        psplat_expected_look(&f->surface, &f->samples, i, f->shown + PSPLAT_LOOK_VALUES * i);
}

static void measure(floor_samples *f, double reach) {
    assert_int_equal(
        psplat_color_errors_find(&f->surface, &f->samples, f->shown, reach, 10, f->errors),
        PSPLAT_OK);
}

static float *shown_at(floor_samples *f, size_t i) {
    return f->shown + PSPLAT_LOOK_VALUES * i;
}

static void show_gray(floor_samples *f, size_t i, float linear) {
    for (int k = 0; k < 3; ++k) shown_at(f, i)[k] = linear;
}

/* What is shown as it is has no error. Where nothing is seen there is none to measure. */
static void test_exact(void **state) {
    (void)state;
    floor_samples f;
    make_floor(&f);
    shown_at(&f, 3)[0] = -1;
    measure(&f, 1);
    for (size_t i = 0; i < COUNT; ++i)
        if (i == 3)
            assert_true(f.errors[i] < 0);
        else
            assert_near(f.errors[i], 0, single);
}

/* Far from the edge, a colour errs by its root mean square over the channels in sRGB. */
static void test_far(void **state) {
    (void)state;
    floor_samples f;
    make_floor(&f);
    show_gray(&f, 0, 0.3f);
    shown_at(&f, 1)[1] = 0.3f; /* a third of the squares */
    measure(&f, 1);
    double whole = 100 * (double)psplat_srgb_of_linear(0.3f);
    assert_near(f.errors[0], whole, single);
    assert_near(f.errors[1], whole / sqrt(3), single);
}

/* Within reach of the edge every grey lies between the colours of both sides, but no red does, and
 * neither side counts if it faces away. */
static void test_edge(void **state) {
    (void)state;
    floor_samples f;
    make_floor(&f);
    size_t inside = COUNT / 2 - 2, outside = COUNT / 2 - 4; /* white begins 0.75 and 1.25 away */
    show_gray(&f, inside, 0.3f);
    show_gray(&f, outside, 0.3f);
    measure(&f, 1);
    assert_near(f.errors[inside], 0, single);
    assert_near(f.errors[outside], 100 * (double)psplat_srgb_of_linear(0.3f), single);
    shown_at(&f, inside)[1] = shown_at(&f, inside)[2] = 0;
    measure(&f, 1);
    assert_true(f.errors[inside] > 10);
    show_gray(&f, inside, 0.3f);
    for (size_t i = COUNT / 2 + 1; i < COUNT; ++i) f.normals[3 * i + 2] = -1;
    measure(&f, 1);
    assert_true(f.errors[inside] > 10);
}

/* Emissive light counts as colour does, roughness and metallic by their difference, and the
 * greatest error of all counts. */
static void test_finishes(void **state) {
    (void)state;
    floor_samples f;
    make_floor(&f);
    shown_at(&f, 0)[PSPLAT_LOOK_ROUGHNESS] -= 0.2f;
    shown_at(&f, 1)[PSPLAT_LOOK_METALLIC] += 0.3f;
    for (int k = 0; k < 3; ++k) shown_at(&f, 2)[PSPLAT_LOOK_EMISSIVE + k] = 0.4f;
    shown_at(&f, 2)[PSPLAT_LOOK_ROUGHNESS] -= 0.2f;
    measure(&f, 1);
    assert_near(f.errors[0], 20, single);
    assert_near(f.errors[1], 30, single);
    assert_near(f.errors[2], 100 * (double)psplat_srgb_of_linear(0.4f), single);
}

/* The looks are those of the material with its factors, and unlit ones have a base colour alone. */
static void test_expected(void **state) {
    (void)state;
    floor_samples f;
    float look[PSPLAT_LOOK_VALUES];
    make_floor(&f);
    f.mesh.material.base_color[1] = 0.5f;
    f.mesh.material.roughness = 0.5f;
    psplat_expected_look(&f.surface, &f.samples, COUNT - 1, look);
    assert_near(look[0], 1, single);
    assert_near(look[1], 0.5, single);
    assert_near(look[PSPLAT_LOOK_ROUGHNESS], 0.25, single);
    f.mesh.material.unlit = 1;
    psplat_expected_look(&f.surface, &f.samples, COUNT - 1, look);
    assert_near(look[1], 0.5, single);
    assert_near(look[PSPLAT_LOOK_ROUGHNESS], 0, single);
}

/* Ranges hold all looks within reach, colours as sRGB. */
static void test_ranges(void **state) {
    (void)state;
    floor_samples f;
    float ranges[2][2 * PSPLAT_LOOK_VALUES];
    const uint32_t indices[2] = {COUNT / 2 - 2, COUNT / 2 - 4};
    make_floor(&f);
    f.colors[4 * (COUNT / 2 - 4) + 1] = 0.2f;
    assert_int_equal(psplat_color_ranges_find(&f.samples, 1, indices, 2, ranges[0]), PSPLAT_OK);
    assert_near(ranges[0][1], 0, single);
    assert_near(ranges[0][PSPLAT_LOOK_VALUES + 1], 1, single);
    assert_near(ranges[1][PSPLAT_LOOK_VALUES + 1], psplat_srgb_of_linear(0.2f), single);
    assert_near(ranges[1][PSPLAT_LOOK_ROUGHNESS], 0.5, single);
    assert_near(ranges[1][PSPLAT_LOOK_VALUES + PSPLAT_LOOK_ROUGHNESS], 0.5, single);
}

int test_color_errors_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),    cmocka_unit_test(test_far),
        cmocka_unit_test(test_edge),     cmocka_unit_test(test_finishes),
        cmocka_unit_test(test_expected), cmocka_unit_test(test_ranges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
