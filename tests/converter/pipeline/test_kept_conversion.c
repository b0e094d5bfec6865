/* SPDX-License-Identifier: MIT
 *
 * test_kept_conversion.c - tests of conversions that keep textures: splats get coordinates that
 * keep their promise, end at borders of charts, and are not split by colours; what is off is
 * reported. The shape is a square, flat or rolled into a quarter of a cylinder.
 */
#include "appearance_fixture.h"

#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "material/source_materials.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

enum { SIZE = 256, CELLS = 24 };

static const double quarter = 1.57079632679489662;

static void checker(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    memset(rgba, (x / 16 + y / 16) % 2 ? 255 : 0, 3);
    rgba[3] = 255;
}

/* Rolls the square around the y axis: x is the length along the arc. */
static void roll(painted *p) {
    for (size_t i = 0; i < p->mesh.vertex_count; ++i) {
        double *at = p->mesh.positions + 3 * i, angle = at[0] * quarter / 2;
        at[0] = 2 / quarter * sin(angle);
        at[2] = 2 / quarter * (cos(angle) - 1);
    }
}

/* Squeezes the image towards one side, so that coordinates are of the third order. */
static void squeeze(painted *p) {
    for (size_t i = 0; i < 3 * p->mesh.triangle_count; ++i) {
        float *u = p->mesh.corner_uvs[0] + 2 * i;
        *u = 0.5f * *u + 0.5f * *u * *u * *u;
    }
}

static void make(painted *p, psplat_source_materials *materials) {
    painted_make(p, CELLS, SIZE, checker);
    p->source_material.base_color =
        (psplat_texture_info){.image = &p->image, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    *materials = (psplat_source_materials){.source_materials = &p->source_material,
                                           .source_material_count = 1,
                                           .images = &p->image,
                                           .image_count = 1};
    psplat_source_materials_describe_textures(materials);
}

static psplat_splats convert(const painted *p, const psplat_convert_desc *desc,
                             psplat_report *report) {
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(&p->mesh, desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

static const psplat_convert_desc usual = {
    .tolerance_percent = 1, .precision = PSPLAT_USUAL_PRECISION, .effort = PSPLAT_EFFORT_NONE};

/* A flat square needs a splat or few, whatever its picture; baked, its checks need hundreds. */
static void test_colors_split_nothing(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report, baked;
    psplat_convert_desc bake = usual;
    make(&p, &materials);
    psplat_splats splats = convert(&p, &usual, &report);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_in_range(splats.count, 1, 8);
    assert_non_null(splats.texcoords);
    assert_false(splats.has_color);
    assert_int_equal(splats.materials[0].textures[PSPLAT_TEXTURE_BASE_COLOR].image, 1);
    for (size_t r = 0; r < splats.run_count; ++r)
        assert_true(splats.runs[r].has_texcoord && !splats.runs[r].has_texcoord_bend);
    /* The coordinates are linear, so that all is the rounding of their numbers: up to 0.12 of the
     * tolerance at the centre, and 0.2 along each axis. */
    assert_true(report.max_texture_slide_percent < 0.52);
    assert_true(report.promises[PSPLAT_PROMISE_TEXTURE].limit == 1);
    psplat_splats_free(&splats);
    bake.bake_textures = 1;
    splats = convert(&p, &bake, &baked);
    assert_true(baked.splats > 20 * report.splats);
    assert_null(splats.texcoords);
    assert_int_equal(splats.materials[0].textures[PSPLAT_TEXTURE_BASE_COLOR].image, 0);
    assert_true(baked.promises[PSPLAT_PROMISE_TEXTURE].limit == 0);
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* Returns the part of the splats that have the second order. */
static double bent_part(const psplat_splats *splats) {
    size_t bent = 0;
    for (size_t r = 0; r < splats->run_count; ++r)
        bent += splats->runs[r].has_texcoord_bend ? splats->runs[r].count : 0;
    return (double)bent / (double)splats->count;
}

static void test_curved(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report, fine;
    psplat_convert_desc texel = usual;
    make(&p, &materials);
    roll(&p);
    squeeze(&p);
    psplat_splats splats = convert(&p, &usual, &report);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_true(bent_part(&splats) > 0.5);
    assert_true(report.max_texture_slide_percent > 0 && report.max_texture_slide_percent <= 1);
    assert_true(report.mirrored_texture_percent == 0 && report.foreign_texture_percent == 0);
    psplat_splats_free(&splats);
    texel.texture_tolerance_texels = 0.5;
    splats = convert(&p, &texel, &fine);
    assert_true(fine.promises[PSPLAT_PROMISE_TEXTURE].limit == 0.5);
    assert_true(fine.p95_texture_slide_texels < 0.5);
    assert_true(fine.p95_texture_slide_texels < 0.5 * report.p95_texture_slide_texels);
    assert_true(fine.splats > report.splats);
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* A seam in the middle keeps splats of either side apart, and its normals together. */
static void test_seam(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report;
    make(&p, &materials);
    roll(&p);
    for (size_t i = 0; i < 3 * p.mesh.triangle_count; ++i)
        if (i / 6 % CELLS >= CELLS / 2) p.mesh.corner_uvs[0][2 * i + 1] += 0.25f;
    psplat_splats splats = convert(&p, &usual, &report);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.chart_border_edges, CELLS);
    assert_int_equal(report.patches, 2);
    assert_true(report.foreign_texture_percent < 2); /* Splats reach over it by 0.3 tolerances. */
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* Half the width of the strip: 1.6 tolerances, and less than the distance of samples, so that all
 * of them lie on its borders. */
static const double strip_half = 0.045;

/* Makes the two middle columns of cells a chart of its own, a strip in whose middle the image is
 * pulled down by 0.03, which is 2.1 tolerances. */
static void make_strip(painted *p) {
    for (size_t i = 0; i < p->mesh.vertex_count; ++i) {
        size_t column = i % (CELLS + 1);
        if (column + 1 == CELLS / 2) p->mesh.positions[3 * i] = -strip_half;
        if (column == CELLS / 2 + 1) p->mesh.positions[3 * i] = strip_half;
    }
    for (size_t i = 0; i < 3 * p->mesh.triangle_count; ++i) {
        size_t vertex = p->mesh.triangles[i], cell = i / 6 % CELLS;
        float *uv = p->mesh.corner_uvs[0] + 2 * i;
        uv[0] = (float)((p->mesh.positions[3 * vertex] + 1) / 2);
        if (cell + 1 != CELLS / 2 && cell != CELLS / 2) continue;
        uv[0] += 0.25f;
        if (vertex % (CELLS + 1) == CELLS / 2) uv[1] += 0.03f;
    }
}

/* Splats that miss what a narrow strip of the surface shows give way to others. Where the image is
 * plain nobody sees it, and they stay. */
static void test_narrow_strip(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report, plain;
    make(&p, &materials);
    make_strip(&p);
    psplat_splats splats = convert(&p, &usual, &report);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    psplat_splats_free(&splats);
    memset(p.image.pixels, 200, (size_t)4 * SIZE * SIZE);
    splats = convert(&p, &usual, &plain);
    assert_int_equal(psplat_report_broken(&plain), PSPLAT_PROMISE_COUNT);
    assert_true(plain.max_texture_slide_percent > 1.5);
    assert_in_range(plain.splats, 1, report.splats - 1);
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* Coordinates that are off by 0.04, which is 4 % of the square's side, break the promise; the
 * report says by how much, and nothing else changes. */
static void test_broken(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report;
    psplat_convert_desc floats = usual;
    floats.precision = 0;
    make(&p, &materials);
    psplat_splats splats = convert(&p, &floats, &report);
    assert_true(report.max_texture_slide_texels < 0.01);
    for (size_t i = 0; i < splats.count; ++i) splats.texcoords[i].at[1] += 0.04f;
    assert_int_equal(psplat_convert_verify(&p.mesh, &floats, &splats, &report, NULL), PSPLAT_OK);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_TEXTURE);
    const psplat_kept *kept = &report.promises[PSPLAT_PROMISE_TEXTURE];
    double texels = 0.04 * SIZE, side = 100 / sqrt(2); /* % of the diagonal */
    assert_near(report.max_texture_slide_texels, texels, 0.3);
    assert_near(kept->worst, side * 0.04 * (texels - 0.25) / texels, 0.1);
    /* The squares of the picture have 16 texels: 10.24 of them show a neighbour instead. */
    assert_near((double)kept->broken / (double)report.verification_samples, texels / 16, 0.03);
    assert_true(report.place_count > 0);
    assert_near(report.places[0].value, kept->worst, 0.01); /* All slide by the same. */
    for (int k = 0; k < 2; ++k) splats.texcoords[0].along_u[k] *= -1;
    assert_int_equal(psplat_convert_verify(&p.mesh, &floats, &splats, &report, NULL), PSPLAT_OK);
    assert_true(report.mirrored_texture_percent > 0);
    psplat_splats_free(&splats);
    painted_free(&p);
}

/* One disc over two charts has the coordinates of the left one. Those of the right one are a square
 * of the picture away, so that what the disc shows there is wrong, and nothing else shows it. */
static void test_lost(void **state) {
    (void)state;
    painted p;
    psplat_source_materials materials;
    psplat_report report;
    psplat_convert_desc floats = usual;
    floats.precision = 0;
    make(&p, &materials);
    for (size_t i = 0; i < 3 * p.mesh.triangle_count; ++i)
        if (i / 6 % CELLS >= CELLS / 2) p.mesh.corner_uvs[0][2 * i + 1] += 16.0f / SIZE;
    psplat_splats splats = convert(&p, &floats, &report), one = splats;
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    psplat_splat disc = {.normal = {0, 0, 1}, .rotation = {0, 0, 0, 1}, .radius = {1.5f, 1.5f}};
    psplat_texcoord left = {.at = {0.5f, 0.5f}, .along_u = {0.75f, 0}, .along_v = {0, -0.75f}};
    psplat_run run = {.count = 1, .has_texcoord = 1};
    one.splats = &disc, one.texcoords = &left, one.runs = &run;
    one.count = one.run_count = 1;
    assert_int_equal(psplat_convert_verify(&p.mesh, &floats, &one, &report, NULL), PSPLAT_OK);
    const psplat_kept *kept = &report.promises[PSPLAT_PROMISE_TEXTURE];
    assert_true(report.max_texture_slide_texels < 0.01); /* of its own chart */
    assert_near(kept->worst, 100, 1e-6);                 /* % of the diagonal */
    /* Between squares both are grey. */
    assert_near((double)kept->broken / (double)report.verification_samples, 0.45, 0.05);
    psplat_splats_free(&splats);
    painted_free(&p);
}

int test_kept_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colors_split_nothing),
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_seam),
        cmocka_unit_test(test_narrow_strip),
        cmocka_unit_test(test_broken),
        cmocka_unit_test(test_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
