/* SPDX-License-Identifier: MIT
 *
 * test_chart_borders.c - tests of the borders of charts: where texture coordinates jump or mirror,
 * splats end, but the surface stays smooth. The shapes are squares of 8 x 8 cells whose coordinates
 * are set by hand, so that the number of border edges is known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "features/samples.h"
#include "features/surface.h"

enum { CELLS = 8 };

/* By how much coordinates of the triangles right of the middle differ. */
static double jump;

static uint32_t column_of(uint32_t triangle) {
    return triangle / 2 % CELLS;
}

static void chart_with_jump(uint32_t triangle, const double p[3], float uv[2]) {
    uv[0] = (float)((p[0] + 1) / 4 + (column_of(triangle) >= CELLS / 2 ? jump : 0));
    uv[1] = (float)((p[1] + 1) / 4);
}

/* Coordinates that go on across the middle, but run back from there. */
static void chart_mirrored(uint32_t triangle, const double p[3], float uv[2]) {
    (void)triangle;
    uv[0] = (float)fabs(p[0]), uv[1] = (float)p[1];
}

/* The same, but for a strip between both halves that is a line in the image. */
static void chart_mirrored_apart(uint32_t triangle, const double p[3], float uv[2]) {
    (void)triangle;
    double x = fabs(p[0] - 0.125) - 0.125;
    uv[0] = (float)(x < 1e-9 ? 0 : x), uv[1] = (float)p[1];
}

static void place_roof(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = -0.1 * fabs(p[0]); /* 11 degrees between the halves: no crease */
}

static size_t count_bounds(const psplat_surface *surface, uint8_t kind) {
    size_t count = 0;
    for (size_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        count += surface->creases[e] == kind;
    return count;
}

static void assert_borders(charted *c, double crease_angle, size_t borders, size_t patches) {
    charted_build(c, crease_angle);
    const psplat_surface *s = &c->f.surface;
    assert_int_equal(s->chart_border_edges, borders);
    assert_int_equal(s->patch_count, patches);
    assert_int_equal(s->crease_edges, 0);
    /* Both triangles of an edge know what it bounds. */
    assert_int_equal(count_bounds(s, PSPLAT_BOUND_CHART), 2 * borders);
    assert_int_equal(count_bounds(s, PSPLAT_BOUND_CREASE), 4 * CELLS);
    psplat_surface_free(&c->f.surface);
}

/* Half a texel is 0.005. A jump by a whole tile is a border, too: a splat has one polynomial. */
static void test_jumps(void **state) {
    (void)state;
    const double jumps[] = {0, 0.0045, 0.0055, 1};
    for (size_t i = 0; i < 4; ++i) {
        charted c;
        jump = jumps[i];
        charted_make(&c, CELLS, place_square, chart_with_jump);
        assert_borders(&c, fixture_crease_angle, i < 2 ? 0 : CELLS, i < 2 ? 1 : 2);
        assert_borders(&c, PSPLAT_NO_CREASES, i < 2 ? 0 : CELLS, i < 2 ? 1 : 2);
        charted_free(&c);
    }
}

static void test_folds(void **state) {
    (void)state;
    charted c;
    charted_make(&c, CELLS, place_square, chart_mirrored);
    assert_borders(&c, fixture_crease_angle, CELLS, 2);
    charted_free(&c);
    charted_make(&c, CELLS, place_square, chart_mirrored_apart);
    assert_borders(&c, fixture_crease_angle, 0, 1);
    charted_free(&c);
}

/* A triangle that is not seen in the image is a border to one that is, and so is another image. */
static void test_materials(void **state) {
    (void)state;
    for (int keeps = 0; keeps < 2; ++keeps) {
        charted c;
        jump = 0;
        charted_make(&c, CELLS, place_square, chart_with_jump);
        c.f.mesh.groups = calloc(c.f.mesh.triangle_count, sizeof(uint32_t));
        assert_non_null(c.f.mesh.groups);
        for (uint32_t t = 0; t < c.f.mesh.triangle_count; ++t)
            c.f.mesh.groups[t] = column_of(t) >= CELLS / 2;
        if (!keeps) c.kept[1] = (psplat_kept_textures){.texels = {0}};
        assert_borders(&c, PSPLAT_NO_CREASES, CELLS, 2);
        charted_free(&c);
    }
}

/* Normals, roughness and creases are those of the surface without charts. */
static void test_smooth_across(void **state) {
    (void)state;
    charted c;
    fixture plain;
    jump = 0.5;
    charted_make(&c, CELLS, place_roof, chart_with_jump);
    charted_build(&c, fixture_crease_angle);
    fixture_grid(&plain, CELLS, CELLS, place_roof);
    fixture_build(&plain);
    assert_int_equal(c.f.surface.patch_count, 2);
    assert_int_equal(plain.surface.patch_count, 1);
    assert_true(c.f.surface.roughness == plain.surface.roughness && plain.surface.roughness > 0);
    for (size_t i = 0; i < 9 * plain.mesh.triangle_count; ++i)
        assert_true(c.f.surface.corner_normals[i] == plain.surface.corner_normals[i]);
    fixture_free(&plain);
    charted_free(&c);
}

/* Samples have the coordinates of their own triangle, also on a border. s and t change by 1/4 for
 * each unit of length along x and y. */
static void test_samples(void **state) {
    (void)state;
    charted c;
    jump = 0.5;
    charted_make(&c, CELLS, place_square, chart_with_jump);
    charted_build(&c, fixture_crease_angle);
    fixture_sample(&c.f, 0.03);
    size_t on_border = 0;
    for (size_t i = 0; i < c.f.samples.count; ++i) {
        const double *p = c.f.samples.positions + 3 * i;
        const float *uv = c.f.samples.texcoords + 2 * i;
        int right = column_of(c.f.samples.triangles[i]) >= CELLS / 2;
        on_border += fabs(p[0]) < 1e-9;
        assert_near(uv[0], (p[0] + 1) / 4 + (right ? 0.5 : 0), 1e-6); /* floats of up to 1 */
        assert_near(uv[1], (p[1] + 1) / 4, 1e-6);
    }
    assert_true(on_border > 2 * CELLS); /* Each side has a row of samples. */
    for (size_t t = 0; t < c.f.mesh.triangle_count; ++t) {
        const float *slopes = c.f.surface.texcoord_slopes + 6 * t;
        const double expected[6] = {0.25, 0, 0, 0, 0.25, 0};
        for (int k = 0; k < 6; ++k) assert_near(slopes[k], expected[k], 1e-6);
    }
    charted_free(&c);
}

int test_chart_borders_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_jumps),     cmocka_unit_test(test_folds),
        cmocka_unit_test(test_materials), cmocka_unit_test(test_smooth_across),
        cmocka_unit_test(test_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
