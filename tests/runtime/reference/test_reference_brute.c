/* SPDX-License-Identifier: MIT
 *
 * test_reference_brute.c - tests the reference rasteriser on thousands of random single splats and
 * views: its bounds lose no pixel, and its ray casting agrees with another way to find (u, v). A
 * pixel (X, Y) and (u, v) are related by the 2 x 2 system that says that the clip space point C + u
 * A + v B projects to (X, Y). The filter of spec 5.8 is computed without singular vectors, by
 * splitting J into a rotation and a reflection.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "random_fixture.h"

/* ---- a random splat in a random view ------------------------------------------------------- */

static void random_splat(psplat_splat *splat, int has_bends, uint32_t *random) {
    double u[3], v[3], length = 0, along = 0;
    for (int i = 0; i < 3; ++i) {
        u[i] = between(random, -1, 1);
        v[i] = between(random, -1, 1);
        splat->center[i] = (float)between(random, -4, 4);
        length += u[i] * u[i];
    }
    for (int i = 0; i < 3; ++i) u[i] /= sqrt(length);
    for (int i = 0; i < 3; ++i) along += u[i] * v[i];
    length = 0;
    for (int i = 0; i < 3; ++i) length += (v[i] - along * u[i]) * (v[i] - along * u[i]);
    for (int i = 0; i < 3; ++i) v[i] = (v[i] - along * u[i]) / sqrt(length);
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i)
        splat->normal[i] =
            (float)(u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    splat->radius[0] = (float)magnitude(random, 1e-2, 1e2);
    splat->radius[1] = splat->radius[0] * (float)magnitude(random, 1e-4, 1);
    random_lines(splat, has_bends, random);
}

/* ---- the other way --------------------------------------------------------------------------- */

/* Computes the clip space images of the two scaled axes and of the centre. */
static void clip_frame(const psplat_splat *splat, const double transform[16],
                       const psplat_view *view, double frame[3][4]) {
    double x = splat->rotation[0], y = splat->rotation[1], z = splat->rotation[2];
    double w = splat->rotation[3], norm = x * x + y * y + z * z + w * w;
    double local[3][4] = {
        {w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y), 0},
        {2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x), 0},
        {splat->center[0], splat->center[1], splat->center[2], 1}};
    for (int k = 0; k < 3; ++k) {
        double scaled[4], scene_point[4], eye_point[4];
        for (int i = 0; i < 4; ++i)
            scaled[i] = k < 2 ? local[k][i] / norm * (double)splat->radius[k] : local[k][i];
        apply(transform, scaled, scene_point);
        apply(view->view, scene_point, eye_point);
        apply(view->projection, eye_point, frame[k]);
    }
}

/* Widens the frame. A matrix is a rotation times q plus a reflection times r, and q + r and |q -
 * r| are its singular values. Stores, row by row, |det J'| J'^-T up to the sign. nearer is the
 * difference of its tested depth, in device coordinates. Returns 0 where the splat is not
 * filtered. */
static int widen(double frame[3][4], double cofactors[2][2], double *area, double *nearer,
                 double *soft) {
    const double half[2] = {WIDTH / 2.0, HEIGHT / 2.0}, *c = frame[2];
    double j[2][2], to[2][2];
    double by_u = frame[0][2] - c[2] / c[3] * frame[0][3];
    double by_v = frame[1][2] - c[2] / c[3] * frame[1][3], slope = hypot(by_u, by_v);
    if (!(c[3] > 0 && c[2] < c[3] && c[2] - 2 * slope > -c[3])) return 0;
    if (!(fabs(frame[0][3]) + fabs(frame[1][3]) < c[3] / 4)) return 0;
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k)
            j[i][k] = half[i] * (frame[k][i] - c[i] / c[3] * frame[k][3]) / c[3];
    double e = (j[0][0] + j[1][1]) / 2, h = (j[1][0] - j[0][1]) / 2;
    double f = (j[0][0] - j[1][1]) / 2, g = (j[1][0] + j[0][1]) / 2;
    double q = hypot(e, h), r = hypot(f, g);
    if (fabs(q - r) >= 1) return 0;
    *soft = fmin(1 / fabs(q - r) - 1, 1);
    double large = fmax(q + r, 1), small = copysign(fmax(fabs(q - r), 1), q - r);
    double turn = (large + small) / 2 / q, flip = (large - small) / 2 / r;
    to[0][0] = turn * e + flip * f;
    to[0][1] = -turn * h + flip * g;
    to[1][0] = turn * h + flip * g;
    to[1][1] = turn * e - flip * f;
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k) frame[k][i] += (to[i][k] - j[i][k]) * c[3] / half[i];
    *area = large * fabs(small);
    *nearer = 1.1 * (1 / fmin(fmax(fabs(q - r), 0.05), 1) - 1) * slope / c[3];
    *nearer = fmin(*nearer, (c[2] - 2 * slope) / c[3] + 1);
    cofactors[0][0] = to[1][1], cofactors[0][1] = -to[1][0];
    cofactors[1][0] = -to[0][1], cofactors[1][1] = to[0][0];
    return 1;
}

/* Returns the value of line k at uv by eq. (3b), and stores its derivatives. */
static double value_of(const psplat_splat *splat, uint32_t k, const double uv[2], double by[2]) {
    double a = splat->clip[k][0], b = splat->clip[k][1], bend = splat->bend[k];
    double m = a * uv[1] - b * uv[0];
    by[0] = a - bend * m * b;
    by[1] = b + bend * m * a;
    return a * uv[0] + b * uv[1] + (double)splat->clip[k][2] + bend * m * m / 2;
}

/* Returns the least value of the lines, in pixels of J', plus half of soft. */
static double softness(const psplat_splat *splat, double cofactors[2][2], double area, double soft,
                       const double uv[2]) {
    double least = HUGE_VAL;
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        double by[2], value = value_of(splat, k, uv, by);
        double across = hypot(cofactors[0][0] * by[0] + cofactors[0][1] * by[1],
                              cofactors[1][0] * by[0] + cofactors[1][1] * by[1]);
        least = fmin(least, value * area / across + 0.5 * soft);
    }
    return least;
}

/* Solves for (u, v) and returns whether there is a fragment, clip lines not considered. */
static int other_fragment(double frame[3][4], double nearer, double x, double y, double uv[2],
                          double *depth) {
    const double at[2] = {x, y};
    double m[2][3];
    for (int row = 0; row < 2; ++row)
        for (int k = 0; k < 3; ++k) m[row][k] = frame[k][row] - at[row] * frame[k][3];
    double determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    uv[0] = (m[0][1] * m[1][2] - m[1][1] * m[0][2]) / determinant;
    uv[1] = (m[1][0] * m[0][2] - m[0][0] * m[1][2]) / determinant;
    double z = frame[2][2] + uv[0] * frame[0][2] + uv[1] * frame[1][2];
    double w = frame[2][3] + uv[0] * frame[0][3] + uv[1] * frame[1][3];
    *depth = 0.5 + 0.5 * z / w;
    return uv[0] * uv[0] + uv[1] * uv[1] <= 1 && w > 0 && fabs(z / w - nearer) <= 1;
}

static int is_kept(const psplat_splat *splat, const double uv[2]) {
    double by[2];
    for (uint32_t k = 0; k < splat->clip_count; ++k)
        if (value_of(splat, k, uv, by) < 0) return 0;
    return 1;
}

typedef struct tally {
    size_t covered, skipped, splats;
} tally;

static void compare(const psplat_splat *splat, const double transform[16], const psplat_view *view,
                    const picture *p, tally *counts) {
    double frame[3][4], own[3][4], cofactors[2][2] = {{0}}, area = 0, nearer = 0, soft = 0;
    size_t before = counts->covered;
    clip_frame(splat, transform, view, frame);
    clip_frame(splat, transform, view, own);
    int is_filtered = !view->no_filter && widen(frame, cofactors, &area, &nearer, &soft);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        double uv[2], depth = 0;
        double x = 2 * (i % WIDTH + 0.5) / WIDTH - 1, y = 2 * (i / WIDTH + 0.5) / HEIGHT - 1;
        int kept = other_fragment(own, 0, x, y, uv, &depth) && is_kept(splat, uv);
        if (is_filtered)
            kept = kept && other_fragment(frame, nearer, x, y, uv, &depth) &&
                   softness(splat, cofactors, area, soft, uv) > 0;
        /* Pixels closer than double rounding to a tie are skipped; aspects of 1e4 and edge-on
         * splats magnify that rounding. */
        if (p->image.tie[i] < 1e-7 || p->image.depth_tie[i] < 1e-9) {
            ++counts->skipped;
            continue;
        }
        assert_int_equal(p->image.count[i], kept);
        counts->covered += (size_t)kept;
        if (!kept) continue;
        for (int k = 0; k < 2 && !is_filtered; ++k)
            assert_near(p->image.uv[2 * i + k], uv[k], 1e-6);
        assert_near(p->image.depth[i], fmin(depth, 1), 1e-9);
    }
    counts->splats += counts->covered > before;
}

static void check_random_splats(int no_filter, int has_bends) {
    uint32_t random = 20040602;
    tally counts = {0};
    const int tries = has_bends ? 1500 : 4000;
    for (int i = 0; i < tries; ++i) {
        scene s = scene_blank(1);
        double transform[16];
        random_splat(&s.splats[0], has_bends, &random);
        random_transform(transform, &random);
        psplat_view view = random_view(&random, 0);
        view.no_filter = no_filter;
        psplat_asset *asset = scene_open(&s);
        picture p = picture_draw(asset, transform, &view);
        compare(&s.splats[0], transform, &view, &p, &counts);
        picture_free(&p);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    print_message("%d splats, %zu seen, %zu pixels covered, %zu skipped\n", tries, counts.splats,
                  counts.covered, counts.skipped);
    assert_true(counts.splats > (size_t)tries / 8 && counts.covered > 5 * (size_t)tries);
    assert_true(counts.skipped * 100 < counts.covered);
}

static void test_random_splats(void **state) {
    (void)state;
    check_random_splats(1, 0);
}

static void test_random_filtered_splats(void **state) {
    (void)state;
    check_random_splats(0, 0);
}

static void test_random_bent_lines(void **state) {
    (void)state;
    check_random_splats(1, 1);
}

static void test_random_filtered_bent_lines(void **state) {
    (void)state;
    check_random_splats(0, 1);
}

int test_reference_brute_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_splats),
                                       cmocka_unit_test(test_random_filtered_splats),
                                       cmocka_unit_test(test_random_bent_lines),
                                       cmocka_unit_test(test_random_filtered_bent_lines)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
