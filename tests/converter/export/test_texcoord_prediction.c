/* SPDX-License-Identifier: MIT
 *
 * test_texcoord_prediction.c - tests of what the texture coordinates of a splat say about those of
 * the next one in a stream (spec 3.12): on a plane whose image is a quadratic polynomial of the
 * position all is predicted exactly, whatever the axes and radii of both splats; around an edge
 * gradients turn with the plane; predictions that rounding errors could decide are noticed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "base/vector.h"
#include "export/texcoord_prediction.h"
#include "near.h"

/* An image over the plane z = 0: a coordinate is m + g x + x H x / 2 at the point x. */
typedef struct image {
    double middle[2], gradient[2][2], hessian[2][3]; /* the latter along xx, xy and yy */
} image;

static const image some = {
    {0.5, 0.25}, {{0.3, -0.1}, {0.2, 0.4}}, {{0.05, 0.02, -0.03}, {-0.01, 0.04, 0.06}}};

static double value_at(const image *i, int k, double x, double y) {
    const double *g = i->gradient[k], *h = i->hessian[k];
    return i->middle[k] + g[0] * x + g[1] * y + (h[0] * x * x + h[2] * y * y) / 2 + h[1] * x * y;
}

/* Returns the field of a splat at (x, y), turned by an angle, with these radii. */
static psplat_texcoord_field field_at(const image *image, double x, double y, double angle,
                                      double large, double small) {
    double c = cos(angle), s = sin(angle);
    psplat_texcoord_field f = {
        .center = {x, y, 0}, .axes = {{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, .radius = {large, small}};
    for (int k = 0; k < 2; ++k) {
        const double *g = image->gradient[k], *h = image->hessian[k];
        double gx = g[0] + h[0] * x + h[1] * y, gy = g[1] + h[1] * x + h[2] * y;
        f.along[0][k] = large * (c * gx + s * gy);
        f.along[1][k] = small * (c * gy - s * gx);
        f.bends[0][k] = large * large / 2 * (c * c * h[0] + 2 * c * s * h[1] + s * s * h[2]);
        f.bends[1][k] = large * small * (c * s * (h[2] - h[0]) + (c * c - s * s) * h[1]);
        f.bends[2][k] = small * small / 2 * (s * s * h[0] - 2 * c * s * h[1] + c * c * h[2]);
    }
    return f;
}

static void test_plane(void **state) {
    (void)state;
    const double rounding = 1e-13; /* of sums of numbers below 10 */
    for (int i = 0; i < 30; ++i) {
        psplat_texcoord_field from = field_at(&some, 1, -0.5, 0.3 + i, 0.8, 0.5);
        psplat_texcoord_field to = field_at(&some, -0.7, 0.1 * i, 2.1 - i, 1.5, 0.2), blank = to;
        double along[2][2], move[2];
        memset(blank.along, 0, sizeof blank.along);
        psplat_texcoord_predict_slopes(&from, &blank, along);
        psplat_texcoord_predict_move(&from, &to, move);
        for (int k = 0; k < 2; ++k) {
            assert_near(along[0][k], to.along[0][k], rounding);
            assert_near(along[1][k], to.along[1][k], rounding);
            assert_near(move[k],
                        value_at(&some, k, to.center[0], to.center[1]) -
                            value_at(&some, k, from.center[0], from.center[1]),
                        rounding);
        }
    }
}

/* Where curvature changes from splat to splat, coordinates go like a cubic polynomial: here x^3. */
static void test_cubic(void **state) {
    (void)state;
    psplat_texcoord_field from = {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .radius = {1, 1}};
    psplat_texcoord_field to = from;
    double move[2], x = 1.5;
    to.center[0] = x;
    to.along[0][0] = 3 * x * x;
    to.bends[0][0] = 3 * x;
    psplat_texcoord_predict_move(&from, &to, move);
    assert_near(move[0], x * x * x, 1e-15);
    assert_near(move[1], 0, 0);
}

/* A linear image goes around an edge of a right angle, and is not predicted on a back. */
static void test_turned(void **state) {
    (void)state;
    psplat_texcoord_field from = {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                  .radius = {1, 1},
                                  .along = {{0.5, 0.25}, {-0.125, 1}}};
    psplat_texcoord_field wall = {
        .center = {1, 0, -1}, .axes = {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}, .radius = {2, 1}};
    psplat_texcoord_field back = {.axes = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, .radius = {1, 1}};
    double along[2][2];
    psplat_texcoord_predict_slopes(&from, &wall, along);
    assert_near(along[0][0], 1, 1e-15);
    assert_near(along[0][1], 0.5, 1e-15);
    assert_near(along[1][0], -0.125, 1e-15);
    assert_near(along[1][1], 1, 1e-15);
    psplat_texcoord_predict_slopes(&from, &back, along);
    for (int i = 0; i < 4; ++i) assert_near(along[i / 2][i % 2], 0, 0);
}

static void test_rounding(void **state) {
    (void)state;
    static const struct {
        double prediction;
        int32_t rounded;
        int is_safe;
    } cases[] = {{0, 0, 1},           {0.5, 0, 1},    {0.52, 1, 1},         {-0.5, -1, 1},
                 {-0.48, 0, 1},       {0.51, 1, 0},   {0.51 - 1e-9, 0, 0},  {0.51 - 1e-7, 0, 1},
                 {0.51 + 1e-7, 1, 1}, {1e30, 100, 1}, {-INFINITY, -100, 1}, {NAN, 0, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        int is_safe = 1;
        assert_int_equal(psplat_texcoord_round(cases[i].prediction, 100, &is_safe),
                         cases[i].rounded);
        assert_int_equal(is_safe, cases[i].is_safe);
    }
}

int test_texcoord_prediction_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_cubic),
        cmocka_unit_test(test_turned),
        cmocka_unit_test(test_rounding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
