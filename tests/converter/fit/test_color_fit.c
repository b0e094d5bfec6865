/* SPDX-License-Identifier: MIT
 *
 * test_color_fit.c - tests that fitted colours, gradients and material values are the least-squares
 * best for the samples that a splat covers. The shape is one ellipse over a lattice of samples with
 * colours that are known functions of (u, v).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>

#include <cmocka.h>

#include "near.h"
#include "base/region.h"
#include "fit/candidate.h"
#include "fit/color_fit.h"
#include "features/samples.h"
#include "select/selection.h"

enum { SIDE = 21, SAMPLES = SIDE * SIDE };

/* A splat of radii 2 and 1 in the plane z = 0, turned a little, over a lattice of samples. */
typedef struct fixture {
    psplat_samples samples;
    psplat_selection selection;
    psplat_candidate candidate;
    uint32_t covered[SAMPLES];
    double positions[3 * SAMPLES];
    float colors[4 * SAMPLES], finishes[3 * SAMPLES], emissive[3 * SAMPLES];
} fixture;

static void make(fixture *f) {
    *f = (fixture){0};
    f->candidate = (psplat_candidate){.region = {.center = {5, 6, 7},
                                                 .u = {0.6, 0.8, 0},
                                                 .v = {-0.8, 0.6, 0},
                                                 .n = {0, 0, 1},
                                                 .radius = {2, 1}},
                                      .taken = 1,
                                      .covered = f->covered};
    const psplat_region *region = &f->candidate.region;
    for (int i = 0; i < SAMPLES; ++i) {
        const double uv[2] = {i % SIDE / 10.0 - 1, i / SIDE / 10.0 - 1};
        for (int k = 0; k < 3; ++k)
            f->positions[3 * i + k] =
                region->center[k] + 2 * uv[0] * region->u[k] + uv[1] * region->v[k];
        if (hypot(uv[0], uv[1]) <= 1) f->covered[f->candidate.covered_count++] = (uint32_t)i;
    }
    f->samples = (psplat_samples){.positions = f->positions, .count = SAMPLES};
    f->selection = (psplat_selection){.candidates = &f->candidate, .count = 1, .capacity = 1};
}

static double u_of(int sample) {
    return sample % SIDE / 10.0 - 1;
}

static double v_of(int sample) {
    int row = sample / SIDE;
    return row / 10.0 - 1;
}

/* A colour that is linear over the splat comes back, up to the regularisation that keeps gradients
 * of few samples small: 0.001 against a variance of 0.25. */
static void test_gradient(void **state) {
    (void)state;
    fixture f;
    make(&f);
    for (int i = 0; i < SAMPLES; ++i) {
        const double color[4] = {0.5 + 0.2 * u_of(i), 0.4 - 0.3 * v_of(i), 0.3, 0.75};
        for (int k = 0; k < 4; ++k) f.colors[4 * i + k] = (float)color[k];
    }
    f.samples.colors = f.colors;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    const psplat_finish *finish = &f.candidate.finish;
    assert_near(f.candidate.color[0], 0.5, 1e-6);
    assert_near(f.candidate.color[1], 0.4, 1e-6);
    assert_near(f.candidate.color[2], 0.3, 1e-6);
    assert_near(f.candidate.color[3], 0.75, 1e-6);
    assert_near(finish->color_u[0], 0.2, 0.005 * 0.2);
    assert_near(finish->color_v[1], -0.3, 0.005 * 0.3);
    assert_near(finish->color_v[0], 0, 1e-6);
    assert_near(finish->color_u[2], 0, 1e-6);
    assert_int_equal(psplat_fit_colors(&f.samples, 0, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    /* The colour is the mean, because samples lie symmetrically. */
    assert_near(f.candidate.color[0], 0.5, 1e-6);
    assert_near(finish->color_u[0], 0, 0);
}

/* A linear colour comes back also where the samples lie to one side, and where u and v are
 * correlated. */
static void test_lopsided(void **state) {
    (void)state;
    fixture f;
    make(&f);
    size_t count = 0;
    for (size_t i = 0; i < f.candidate.covered_count; ++i) {
        int at = (int)f.covered[i];
        if (fabs(v_of(at) - u_of(at)) < 0.8 && u_of(at) > -0.5) f.covered[count++] = f.covered[i];
    }
    f.candidate.covered_count = count;
    for (int i = 0; i < SAMPLES; ++i) {
        const double color[4] = {0.5 + 0.1 * u_of(i) - 0.05 * v_of(i), 0.4 - 0.2 * v_of(i),
                                 0.3 + 0.1 * (u_of(i) + v_of(i)), 1};
        for (int k = 0; k < 4; ++k) f.colors[4 * i + k] = (float)color[k];
    }
    f.samples.colors = f.colors;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    const psplat_finish *finish = &f.candidate.finish;
    const double middle[3] = {0.5, 0.4, 0.3}, u[3] = {0.1, 0, 0.1}, v[3] = {-0.05, -0.2, 0.1};
    for (int k = 0; k < 3; ++k) {
        assert_near(f.candidate.color[k], middle[k], 0.003);
        assert_near(finish->color_u[k], u[k], 0.008);
        assert_near(finish->color_v[k], v[k], 0.008);
    }
}

/* Three samples in a corner do not determine the colour at the far side, although a plane goes
 * through them. */
static void test_few_samples(void **state) {
    (void)state;
    fixture f;
    make(&f);
    static const uint32_t corner[3] = {SIDE * 10 + 19, SIDE * 10 + 20, SIDE * 11 + 19};
    for (int i = 0; i < 3; ++i) {
        f.covered[i] = corner[i];
        for (int k = 0; k < 4; ++k) f.colors[4 * corner[i] + (uint32_t)k] = i == 1 ? 1 : 0;
    }
    f.candidate.covered_count = 3;
    f.samples.colors = f.colors;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    for (double angle = 0; angle < 6.28; angle += 0.1)
        for (int k = 0; k < 3; ++k) {
            double value = (double)f.candidate.color[k] +
                           cos(angle) * (double)f.candidate.finish.color_u[k] +
                           sin(angle) * (double)f.candidate.finish.color_v[k];
            assert_true(value >= -0.51 && value <= 1.51); /* half of the samples' range beyond it */
        }
}

static void test_finish(void **state) {
    (void)state;
    fixture f;
    make(&f);
    for (int i = 0; i < SAMPLES; ++i)
        for (int k = 0; k < 3; ++k) {
            f.finishes[3 * i + k] = (float)(0.2 * k + 0.1 * u_of(i));
            f.emissive[3 * i + k] = (float)(0.9 - 0.2 * k - 0.1 * v_of(i));
        }
    f.finishes[0] = 1000; /* This sample is not covered. */
    f.samples.finishes = f.finishes;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    assert_near(f.candidate.finish.occlusion, 0, 1e-6);
    assert_near(f.candidate.finish.roughness, 0.2, 1e-6);
    assert_near(f.candidate.finish.metallic, 0.4, 1e-6);
    assert_near(f.candidate.finish.emissive[1], 1, 0);
    assert_near(f.candidate.color[2], 1, 0);
    f.samples.emissive = f.emissive;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    for (int k = 0; k < 3; ++k) assert_near(f.candidate.finish.emissive[k], 0.9 - 0.2 * k, 1e-6);
}

/* A candidate that covers nothing gets plain values, and one that is not taken stays as it is. */
static void test_nothing(void **state) {
    (void)state;
    fixture f;
    make(&f);
    f.samples.colors = f.colors;
    f.candidate.covered_count = 0;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    assert_near(f.candidate.color[0], 1, 0);
    f.candidate.color[0] = 0.25f;
    f.candidate.taken = 0;
    assert_int_equal(psplat_fit_colors(&f.samples, 1, f.selection.candidates, f.selection.count),
                     PSPLAT_OK);
    assert_near(f.candidate.color[0], 0.25, 0);
}

int test_color_fit_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradient),    cmocka_unit_test(test_lopsided),
        cmocka_unit_test(test_few_samples), cmocka_unit_test(test_finish),
        cmocka_unit_test(test_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
