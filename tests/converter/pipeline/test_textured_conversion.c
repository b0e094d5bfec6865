/* SPDX-License-Identifier: MIT
 *
 * test_textured_conversion.c - tests of converting textures to splat colours, materials and
 * normals: the splats show the square's texture within the colour tolerance. Images are halves,
 * ramps and leaning normals, whose best colours are known.
 */
#include "appearance_fixture.h"

#include "base/random.h"
#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

enum { SIZE = 64 };

/* black on the left, white on the right */
static void halves(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    memset(rgba, x < SIZE / 2 ? 0 : 255, 3);
    rgba[3] = 255;
}

/* light that grows linearly to the right and, in green, downwards */
static void ramp(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    float across = ((float)x + 0.5f) / SIZE, down = ((float)y + 0.5f) / SIZE;
    rgba[0] = (uint8_t)(255 * psplat_srgb_of_linear(0.1f + 0.8f * across) + 0.5f);
    rgba[1] = (uint8_t)(255 * psplat_srgb_of_linear(0.9f - 0.8f * down) + 0.5f);
    rgba[2] = 128, rgba[3] = 255;
}

/* colours that change by a twentieth of the range, 1.5 % in root mean square */
static void faint_ramp(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    memset(rgba, (int)(128 + 13 * x / SIZE), 3);
    rgba[3] = 255;
}

/* greys that are random in squares of three texels, of which a splat covers few */
static void grain(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    uint64_t seed = 1 + x / 3 + SIZE * (y / 3);
    memset(rgba, (int)(psplat_random_next(&seed) % 256), 3);
    rgba[3] = 255;
}

static void red(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    rgba[0] = 255, rgba[1] = rgba[2] = 0, rgba[3] = 255;
}

/* normals that lean by atan(1/2) to the right */
static void lean(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    const double length = sqrt(1.25);
    rgba[0] = (uint8_t)lround(127.5 * (1 + 0.5 / length));
    rgba[1] = 128;
    rgba[2] = (uint8_t)lround(127.5 * (1 + 1 / length));
    rgba[3] = 255;
}

static psplat_splats convert(const painted *p, double color_tolerance, psplat_color_field field,
                             psplat_report *report) {
    const psplat_convert_desc desc = {.tolerance_percent = 1,
                                      .color_tolerance_percent = color_tolerance,
                                      .color_field = field,
                                      .effort = PSPLAT_EFFORT_NONE};
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(&p->mesh, &desc, &splats, report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(report), PSPLAT_PROMISE_COUNT);
    return splats;
}

/* A flat square needs one splat; its two colours need more, each of one colour. */
static void test_edge(void **state) {
    (void)state;
    painted p;
    psplat_report loose, tight;
    painted_make(&p, 2, SIZE, halves);
    p.source_material.base_color =
        (psplat_texture_info){.image = &p.image, .wrap = {PSPLAT_WRAP_CLAMP}};
    psplat_splats splats = convert(&p, 100, PSPLAT_COLOR_FIELD_CONSTANT, &loose);
    assert_in_range(splats.count, 1, 6);
    psplat_splats_free(&splats);
    splats = convert(&p, 10, PSPLAT_COLOR_FIELD_CONSTANT, &tight);
    assert_in_range(splats.count, 2 * loose.splats, 60);
    assert_true(tight.rms_color_percent < 0.5 * loose.rms_color_percent);
    size_t pure = 0;
    for (size_t i = 0; i < splats.count; ++i)
        pure += splats.splats[i].color[0] < 0.01f || splats.splats[i].color[0] > 0.95f;
    assert_true(pure >= 2); /* Each half has at least one splat of its own. */
    psplat_splats_free(&splats);
    painted_free(&p);
}

static void test_ramp(void **state) {
    (void)state;
    painted p;
    psplat_report report, constant;
    painted_make(&p, 2, SIZE, ramp);
    p.source_material.base_color =
        (psplat_texture_info){.image = &p.image, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    psplat_splats splats = convert(&p, 2, PSPLAT_COLOR_FIELD_CHOSEN, &report);
    assert_non_null(splats.finishes); /* Linear colours pay here. */
    assert_true(report.rms_color_percent < 2);
    assert_true(report.rms_color_constant_percent > 4 * report.rms_color_percent);
    for (size_t i = 0; i < splats.count; ++i) /* Blue is 128 everywhere. */
        assert_near(splats.splats[i].color[2], psplat_linear_of_srgb(128 / 255.0f), 1e-4);
    psplat_splats_free(&splats);
    splats = convert(&p, 2, PSPLAT_COLOR_FIELD_CONSTANT, &constant);
    assert_null(splats.finishes);
    assert_true(constant.splats > 4 * report.splats);
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* Converts a square, painted by an image or else by colours of its vertices, which change linearly,
 * with a tolerance for which colours are constant unless they are smooth. */
static psplat_splats paint(psplat_color_field field, void (*image)(uint32_t, uint32_t, uint8_t[4]),
                           psplat_report *report) {
    painted p;
    painted_make(&p, 2, SIZE, image ? image : red);
    size_t corners = 3 * p.mesh.triangle_count;
    if (image) {
        p.source_material.base_color = (psplat_texture_info){
            .image = &p.image, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    } else {
        p.mesh.corner_colors = malloc(4 * corners * sizeof *p.mesh.corner_colors);
        assert_non_null(p.mesh.corner_colors);
    }
    for (size_t i = 0; i < corners && !image; ++i)
        for (size_t k = 0; k < 4; ++k)
            p.mesh.corner_colors[4 * i + k] =
                k == 3 ? 1 : 0.1f + 0.8f * p.mesh.corner_uvs[0][2 * i + k / 2];
    psplat_splats splats = convert(&p, 10, field, report);
    painted_free(&p);
    return splats;
}

static int stays_constant(void (*image)(uint32_t, uint32_t, uint8_t[4]), psplat_report *report) {
    psplat_splats splats = paint(PSPLAT_COLOR_FIELD_CHOSEN, image, report);
    int has_finishes = splats.finishes != NULL;
    psplat_splats_free(&splats);
    return !has_finishes;
}

/* Smooth colours of textures and of vertices become linear, as if that had been asked for, which
 * takes far fewer splats and errs by less. Those of two halves have an edge, those of a faint ramp
 * err by little, and grain has nothing that is linear: all of these stay constant. */
static void test_smooth(void **state) {
    (void)state;
    void (*const images[])(uint32_t, uint32_t, uint8_t[4]) = {ramp, NULL};
    for (size_t i = 0; i < 2; ++i) {
        psplat_report reports[3];
        psplat_splats chosen = paint(PSPLAT_COLOR_FIELD_CHOSEN, images[i], &reports[0]);
        psplat_splats linear = paint(PSPLAT_COLOR_FIELD_LINEAR, images[i], &reports[1]);
        psplat_splats constant = paint(PSPLAT_COLOR_FIELD_CONSTANT, images[i], &reports[2]);
        assert_non_null(chosen.finishes);
        assert_null(constant.finishes);
        assert_int_equal(reports[0].samples, reports[1].samples);
        assert_int_equal(chosen.count, linear.count);
        assert_memory_equal(chosen.splats, linear.splats, chosen.count * sizeof *chosen.splats);
        assert_true(constant.count >= 4 * chosen.count);
        assert_true(reports[0].rms_color_percent < 0.5 * reports[2].rms_color_percent);
        psplat_splats_free(&chosen);
        psplat_splats_free(&linear);
        psplat_splats_free(&constant);
    }
    psplat_report report;
    assert_true(stays_constant(halves, &report));
    assert_true(stays_constant(faint_ramp, &report));
    assert_true(report.rms_color_percent > 0.5 && report.rms_color_percent < 2);
    assert_true(stays_constant(grain, &report));
    assert_true(report.rms_color_percent > 3);
}

static void test_one_color(void **state) {
    (void)state;
    painted p;
    psplat_report report;
    painted_make(&p, 2, 4, red);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    p.source_material.material.base_color[0] = 0.5f;
    psplat_splats splats = convert(&p, 0, PSPLAT_COLOR_FIELD_CHOSEN, &report);
    assert_false(splats.has_color);
    assert_null(splats.finishes);
    assert_near(splats.materials[0].base_color[0], 0.5, 1e-6);
    assert_near(splats.materials[0].base_color[1], 0, 1e-6);
    assert_true(report.rms_color_percent < 0.01);
    psplat_splats_free(&splats);
    painted_free(&p);
}

static void test_finishes(void **state) {
    (void)state;
    painted p;
    psplat_report report;
    painted_make(&p, 2, SIZE, halves);
    p.source_material.base_color =
        (psplat_texture_info){.image = &p.image, .wrap = {PSPLAT_WRAP_CLAMP}};
    p.source_material.metallic_roughness = p.source_material.base_color;
    p.source_material.occlusion = p.source_material.base_color;
    p.source_material.occlusion.strength = 0.5f;
    p.source_material.emissive = p.source_material.base_color;
    psplat_splats splats = convert(&p, 10, PSPLAT_COLOR_FIELD_CONSTANT, &report);
    assert_non_null(splats.finishes);
    for (size_t i = 0; i < splats.count; ++i) {
        /* All values are means over the same samples of one image of 0 and 1. */
        float part = splats.splats[i].color[0];
        assert_near(splats.finishes[i].roughness, part, 1e-5);
        assert_near(splats.finishes[i].metallic, part, 1e-5);
        assert_near(splats.finishes[i].emissive[1], part, 1e-5);
        assert_near(splats.finishes[i].occlusion, 0.5 + 0.5 * (double)part, 1e-5);
    }
    psplat_splats_free(&splats);
    painted_free(&p);
}

static void test_normal_map(void **state) {
    (void)state;
    painted p;
    psplat_report report;
    painted_make(&p, 2, 4, lean);
    p.source_material.normal = (psplat_texture_info){.image = &p.image, .strength = 1};
    psplat_splats splats = convert(&p, 0, PSPLAT_COLOR_FIELD_CHOSEN, &report);
    assert_true(report.rms_normal_degrees < 0.01);
    for (size_t i = 0; i < splats.count; ++i) {
        const psplat_splat *s = &splats.splats[i];
        assert_near(s->center[2], 0, 1e-6);                  /* as flat as before */
        assert_near(s->normal[0] / s->normal[2], 0.5, 0.01); /* normals of eight bits */
        assert_near(s->normal[1], 0, 0.01);
    }
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* Each group has splats of its own with its material. */
static void test_two_materials(void **state) {
    (void)state;
    painted p;
    psplat_report report;
    psplat_source_material both[2];
    painted_make(&p, 2, 4, red);
    both[0] = both[1] = p.source_material;
    both[1].material.base_color[1] = 0.25f;
    both[1].base_color = (psplat_texture_info){.image = &p.image};
    p.mesh.source_materials = both;
    p.mesh.source_material_count = 2;
    p.mesh.groups = calloc(p.mesh.triangle_count, sizeof *p.mesh.groups);
    assert_non_null(p.mesh.groups);
    for (size_t t = 0; t < 4; ++t) p.mesh.groups[t] = 1; /* the lower half */
    psplat_splats splats = convert(&p, 0, PSPLAT_COLOR_FIELD_CHOSEN, &report);
    size_t of_both[2] = {0, 0};
    for (size_t run = 0, i = 0; run < splats.run_count; ++run)
        for (size_t end = i + splats.runs[run].count; i < end; ++i) {
            int lower = splats.splats[i].center[1] < 0;
            assert_int_equal(splats.runs[run].material, lower);
            ++of_both[lower];
        }
    assert_true(of_both[0] > 0 && of_both[1] > 0);
    assert_false(splats.has_color);
    assert_near(splats.materials[0].base_color[1], 1, 1e-6);
    assert_near(splats.materials[1].base_color[1], 0, 1e-6); /* the texture has no green */
    assert_near(splats.materials[1].base_color[0], 1, 1e-6);
    psplat_splats_free(&splats);
    painted_free(&p);
}

int test_textured_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_edge),          cmocka_unit_test(test_ramp),
        cmocka_unit_test(test_smooth),        cmocka_unit_test(test_one_color),
        cmocka_unit_test(test_finishes),      cmocka_unit_test(test_normal_map),
        cmocka_unit_test(test_two_materials),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
