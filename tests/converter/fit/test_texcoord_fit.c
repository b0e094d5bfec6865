/* SPDX-License-Identifier: MIT
 *
 * test_texcoord_fit.c - tests of fitting texture coordinates to samples: what samples determine is
 * met, what they leave open follows the triangles, and what cannot be met is refused. Coordinates
 * are polynomials over a square, which are known everywhere.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "base/region.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/texcoord_fit.h"
#include "fit/texture_candidates.h"
#include "splats/splat_texcoord.h"

/* ---- sums ------------------------------------------------------------------------------------ */

static const psplat_region ellipse = {
    .u = {0.6, 0.8, 0}, .v = {-0.8, 0.6, 0}, .n = {0, 0, 1}, .radius = {2, 1}};
static const psplat_texcoord wanted = {.at = {0.5f, 3.25f},
                                       .along_u = {0.5f, 0.125f},
                                       .along_v = {-0.25f, 0.5f},
                                       .along_uu = {0.0625f, 0.03125f},
                                       .along_uv = {0.125f, 0},
                                       .along_vv = {-0.03125f, 0.0625f}};
static const float flat[6];

static void add(psplat_texcoord_sums *sums, double u, double v, const float slopes[6]) {
    const double uv[2] = {u, v};
    double at[2];
    psplat_texcoord_at(&wanted, uv, at);
    psplat_texcoord_sums_add(sums, uv, (const float[2]){(float)at[0], (float)at[1]}, slopes);
}

static void add_disc(psplat_texcoord_sums *sums) {
    for (int i = -10; i <= 10; ++i)
        for (int j = -10; j <= 10; ++j)
            if (hypot(i, j) <= 10) add(sums, i / 10.0, j / 10.0, flat);
}

/* The ridges are 1/170 of the slopes' mean squares, and up to 1/120 of those of the second order.
 */
static void test_second_order(void **state) {
    (void)state;
    psplat_texcoord_sums sums = {.weight = 0};
    psplat_texcoord fitted;
    add_disc(&sums);
    psplat_texcoord_sums_fit(&sums, &ellipse, 1, &fitted);
    for (int k = 0; k < 2; ++k) {
        assert_near(fitted.at[k], wanted.at[k], 1e-3);
        assert_near(fitted.along_u[k], wanted.along_u[k], 0.5 / 150);
        assert_near(fitted.along_v[k], wanted.along_v[k], 0.5 / 150);
        assert_near(fitted.along_uu[k], wanted.along_uu[k], 0.1 / 80);
        assert_near(fitted.along_uv[k], wanted.along_uv[k], 0.1 / 80);
        assert_near(fitted.along_vv[k], wanted.along_vv[k], 0.1 / 80);
    }
}

/* What the second order adds on average is left to the constant. Samples weigh exp(-2 r^2): over a
 * disc the weighted mean of r^2, which is 1/2 without weights, is (1 - 3 / e^2) / (2 - 2 / e^2),
 * and u^2 and v^2 are half of that. So errors are less in the middle than at the rim. */
static void test_linear(void **state) {
    (void)state;
    psplat_texcoord_sums sums = {.weight = 0};
    psplat_texcoord fitted;
    add_disc(&sums);
    psplat_texcoord_sums_fit(&sums, &ellipse, 0, &fitted);
    const double square = (1 - 3 * exp(-2)) / (2 - 2 * exp(-2));
    for (int k = 0; k < 2; ++k) {
        double mean = (double)(wanted.along_uu[k] + wanted.along_vv[k]) * square / 2;
        assert_near(fitted.at[k], (double)wanted.at[k] + mean, 5e-4); /* of a grid of samples */
        assert_near(fitted.along_u[k], wanted.along_u[k], 0.5 / 150);
        assert_true(fitted.along_uu[k] == 0 && fitted.along_uv[k] == 0 && fitted.along_vv[k] == 0);
    }
}

/* Of samples in a row the change across comes from the triangles, which say (1, 2) for each unit of
 * length along V; V is one such unit. */
static void test_row(void **state) {
    (void)state;
    const float across[6] = {-0.8f, 0.6f, 0, -1.6f, 1.2f, 0};
    psplat_texcoord_sums sums = {.weight = 0};
    psplat_texcoord fitted;
    for (int i = -5; i <= 5; ++i) add(&sums, i / 5.0, 0, across);
    psplat_texcoord_sums_fit(&sums, &ellipse, 1, &fitted);
    assert_near(fitted.along_v[0], 1, 1e-5);
    assert_near(fitted.along_v[1], 2, 1e-5);
    for (int k = 0; k < 2; ++k) {
        assert_near(fitted.along_u[k], wanted.along_u[k], 0.5 / 200);
        assert_true(fabsf(fitted.along_uv[k]) < 1e-6f && fabsf(fitted.along_vv[k]) < 1e-6f);
    }
}

/* One sample keeps its own coordinates, and those of its triangle around it. */
static void test_one_sample(void **state) {
    (void)state;
    const float slopes[6] = {0.6f, 0.8f, 0, -0.8f, 0.6f, 0}; /* s grows along U, t along V */
    psplat_texcoord_sums sums = {.weight = 0};
    psplat_texcoord fitted;
    double expected[2], at[2];
    const double uv[2] = {0.5, -0.5};
    add(&sums, uv[0], uv[1], slopes);
    psplat_texcoord_sums_fit(&sums, &ellipse, 0, &fitted);
    psplat_texcoord_at(&wanted, uv, expected);
    psplat_texcoord_at(&fitted, uv, at);
    for (int k = 0; k < 2; ++k) assert_near(at[k], expected[k], 1e-6);
    assert_near(fitted.along_u[0], 2, 1e-6); /* the radius along U */
    assert_near(fitted.along_v[1], 1, 1e-6);
    assert_near(fitted.along_u[1], 0, 1e-6);
}

/* Samples around a splat of next to no size, which all lie far beyond its rim, still count. */
static void test_far_samples(void **state) {
    (void)state;
    psplat_texcoord_sums sums = {.weight = 0};
    psplat_texcoord fitted;
    for (int i = 0; i < 8; ++i)
        add(&sums, 40 * cos(i * fixture_pi / 4), 40 * sin(i * fixture_pi / 4), flat);
    psplat_texcoord_sums_fit(&sums, &ellipse, 0, &fitted);
    for (int k = 0; k < 2; ++k) {
        assert_near(fitted.along_u[k], wanted.along_u[k], 1e-3);
        assert_near(fitted.along_v[k], wanted.along_v[k], 1e-3);
    }
}

/* ---- regions --------------------------------------------------------------------------------- */

/* The factor of the third order of coordinates that else are x / 4 and y / 4. */
static double third;

static void chart_third(uint32_t triangle, const double p[3], float uv[2]) {
    (void)triangle;
    uv[0] = (float)(p[0] / 4 + third * p[0] * p[0] * p[0] + 2.5);
    uv[1] = (float)(p[1] / 4 - 1.75);
}

static void place_dome(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = -0.1 * (p[0] * p[0] + p[1] * p[1]);
}

typedef struct stage {
    charted c;
    psplat_limits limits;
    psplat_scratch scratch;
    psplat_fit_context context;
} stage;

static void stage_begin(stage *s, double factor) {
    *s = (stage){.limits = {.tolerance = 0.02, .crease_tolerance = 0.01}};
    third = factor;
    charted_make(&s->c, 40, place_dome, chart_third);
    charted_build(&s->c, fixture_crease_angle);
    fixture_sample(&s->c.f, 0.02);
    s->limits.distance = s->c.f.distance;
    s->context = fixture_context(&s->c.f, &s->limits, &s->scratch);
}

static void stage_end(stage *s) {
    psplat_scratch_free(&s->scratch);
    charted_free(&s->c);
}

/* The dome itself, up to what its triangles sag. */
static psplat_region dome(void) {
    return (psplat_region){.u = {1, 0, 0},
                           .v = {0, 1, 0},
                           .n = {0, 0, 1},
                           .radius = {0.8, 0.8},
                           .hessian = {-0.2, 0, -0.2}};
}

static uint32_t triangle_at_origin(const stage *s) {
    uint32_t nearest = 0;
    double least = HUGE_VAL;
    const double origin[3] = {0, 0, 0};
    for (uint32_t i = 0; i < s->c.f.samples.count; ++i) {
        double d = distance2_3(s->c.f.samples.positions + 3 * (size_t)i, origin);
        if (d < least) least = d, nearest = i;
    }
    return s->c.f.samples.triangles[nearest];
}

static psplat_fit_status status_of(stage *s, int skip) {
    const psplat_region region = dome();
    const psplat_demands demands = {.inside = region.center, .skip = skip};
    psplat_site site = psplat_site_of(&region, triangle_at_origin(s));
    return psplat_evaluate(&s->context, &site, &region, &demands).status;
}

/* x^3 over -r ... r leaves its best line, and with it its best parabola, by r^3 / 4 or more, and by
 * 0.6 r^3 at the rim of a disc of samples that weigh exp(-2 (x^2 + y^2) / r^2): the mean of x^4
 * over that of x^2 is 0.41 r^2. With 0.1 x^3 and r = 0.8 that is 0.013 to 0.031, and s changes by
 * 0.25 to 0.44 for each unit of length. */
static void test_limits(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0.1);
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_KEPT);
    s.limits.texture_tolerance = 0.01;
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_TEXTURE_SLIDES);
    assert_int_equal(status_of(&s, PSPLAT_SKIP_COLORS), PSPLAT_FIT_KEPT);
    s.limits.texture_tolerance = 0.1;
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_KEPT);
    /* In texels: 100 for each unit of s. */
    s.limits.texture_tolerance_texels = 1;
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_TEXTURE_SLIDES);
    s.limits.texture_tolerance_texels = 3.2;
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_KEPT);
    s.c.appearance.kept = NULL; /* Nothing is kept: nothing slides. */
    s.limits.texture_tolerance_texels = 1;
    assert_int_equal(status_of(&s, 0), PSPLAT_FIT_KEPT);
    stage_end(&s);
}

/* What is taken gets the coordinates of its samples, moved to 0 ... 1 along s, which repeats. */
static void test_candidates(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    for (int k = 0; k < 2; ++k) s.c.kept[k].repeats[0] = 1;
    uint32_t triangle = triangle_at_origin(&s), one = 0;
    psplat_candidate candidates[4] = {{.region = dome(), .triangle = triangle, .taken = 1},
                                      {.region = dome(), .triangle = triangle},
                                      {.region = dome(), .taken = 1},
                                      {.region = dome(), .taken = 1, .covered_count = 1}};
    uint32_t *covered = malloc(s.c.f.samples.count * sizeof *covered);
    assert_non_null(covered);
    for (uint32_t i = 0; i < s.c.f.samples.count; ++i) {
        const double *p = s.c.f.samples.positions + 3 * (size_t)i;
        if (hypot(p[0], p[1]) < 0.8) covered[candidates[0].covered_count++] = i;
    }
    candidates[0].covered = candidates[1].covered = covered;
    candidates[1].covered_count = candidates[0].covered_count;
    candidates[3].covered = &one;
    /* The last two are discs beside the triangle whose coordinates they get. */
    candidates[2].region.radius[0] = candidates[2].region.radius[1] = 0.01;
    candidates[3].region.radius[0] = candidates[3].region.radius[1] = 0.01;
    memcpy(candidates[3].region.center, s.c.f.samples.positions + 3 * (size_t)one,
           sizeof candidates[3].region.center);
    memcpy(candidates[2].region.center, candidates[3].region.center,
           sizeof candidates[2].region.center);
    candidates[2].triangle = candidates[3].triangle = s.c.f.samples.triangles[one];
    psplat_fit_context context = s.context;
    context.scratch = NULL;
    assert_int_equal(psplat_fit_texcoords(&context, candidates, 4), PSPLAT_OK);
    const psplat_texcoord *t = &candidates[0].texcoord;
    assert_near(t->at[0], 0.5, 1e-4);
    assert_near(t->at[1], -1.75, 1e-4); /* t does not repeat. */
    assert_near(t->along_u[0], 0.25 * 0.8, 0.2 / 200);
    assert_near(t->along_v[1], 0.25 * 0.8, 0.2 / 200);
    assert_true(candidates[1].texcoord.at[1] == 0); /* It is not taken. */
    for (int i = 2; i < 4; ++i) {
        const double *p = candidates[i].region.center;
        double s_there = p[0] / 4 + 2.5;
        assert_near(candidates[i].texcoord.at[0], s_there - floor(s_there), 1e-3);
        assert_near(candidates[i].texcoord.at[1], p[1] / 4 - 1.75, 1e-3);
        assert_near(candidates[i].texcoord.along_u[0], 0.25 * 0.01, 1e-4);
    }
    free(covered);
    stage_end(&s);
}

/* A splat on a tube beside its seam, which it is long enough to meet from both sides. Its line
 * stands so far beyond the seam. */
static psplat_region region_beside_seam(double beyond) {
    psplat_region region = {.center = {0.2, 0, 0},
                            .u = {0, 0, 1},
                            .v = {0, -1, 0},
                            .n = {1, 0, 0},
                            .radius = {0.45, 0.12},
                            .hessian = {0, 0, -5}};
    double seam[3], p[3];
    place_tube(0, 0.5, p);
    psplat_region_local(&region, p, seam);
    region.lines[0][1] = 1, region.lines[0][2] = -seam[1] + beyond / region.radius[1];
    region.line_count = 1;
    return region;
}

/* Makes a candidate of all samples inside a region, but for a margin at its rim, of which the first
 * is nearest to its centre. The caller frees what it covers. */
static psplat_candidate candidate_of(const stage *s, const psplat_region *region) {
    const psplat_samples *samples = &s->c.f.samples;
    psplat_candidate c = {.region = *region, .taken = 1};
    c.covered = malloc(samples->count * sizeof *c.covered);
    assert_non_null(c.covered);
    for (uint32_t i = 0; i < samples->count; ++i) {
        double uvh[3];
        psplat_region_local(region, samples->positions + 3 * (size_t)i, uvh);
        if (fabs(uvh[2]) < 0.01 && psplat_region_contains(region, uvh, 0.95, 0))
            c.covered[c.covered_count++] = i;
    }
    assert_true(c.covered_count > 50);
    psplat_candidate_put_nearest_first(samples, region->center, &c);
    c.triangle = samples->triangles[c.covered[0]];
    return c;
}

/* Fits the coordinates of a candidate, and tests them at the samples that it covers on its own side
 * of the seam. Samples across have coordinates that are off by a whole image. What the splat gets
 * errs by what sines leave of angles, 0.007 at the rim. */
static void assert_own_side_fits(stage *s, psplat_candidate *c, size_t least_across) {
    const psplat_samples *samples = &s->c.f.samples;
    psplat_fit_context context = fixture_context(&s->c.f, &s->limits, NULL);
    size_t across = 0;
    assert_int_equal(psplat_fit_texcoords(&context, c, 1), PSPLAT_OK);
    for (size_t i = 0; i < c->covered_count; ++i) {
        double uvh[3], at[2];
        const float *given = samples->texcoords + 2 * (size_t)c->covered[i];
        psplat_region_local(&c->region, samples->positions + 3 * (size_t)c->covered[i], uvh);
        psplat_texcoord_at(&c->texcoord, uvh, at);
        across += given[0] < 0.5f;
        if (given[0] < 0.5f) continue;
        for (int k = 0; k < 2; ++k) assert_near(at[k], (double)given[k], 0.01);
    }
    assert_true(across >= least_across);
}

/* Samples across the seam lie beyond a line that stands before it. */
static void test_around_a_neck(void **state) {
    (void)state;
    stage s = {.limits = {.tolerance = 0.02, .crease_tolerance = 0.01}};
    charted_make_tube(&s.c);
    fixture_sample(&s.c.f, 0.02);
    s.limits.distance = s.c.f.distance;
    const psplat_region region = region_beside_seam(-0.0024);
    psplat_candidate c = candidate_of(&s, &region);
    assert_own_side_fits(&s, &c, 0);
    free(c.covered);
    stage_end(&s);
}

/* Where lines have been moved out over the seam, by 0.7 of the tolerance, samples across lie inside
 * the splat, and do not count. */
static void test_over_a_seam(void **state) {
    (void)state;
    stage s = {.limits = {.tolerance = 0.02, .crease_tolerance = 0.01}};
    charted_make_tube(&s.c);
    fixture_sample(&s.c.f, 0.005);
    s.limits.distance = s.c.f.distance;
    const psplat_region region = region_beside_seam(0.014);
    psplat_candidate c = candidate_of(&s, &region);
    assert_own_side_fits(&s, &c, 20);
    free(c.covered);
    stage_end(&s);
}

/* On trial, a line may stand a little beyond the seam, as on the grid of a file; a region that
 * reaches far over the seam shows the wrong part of the image there. */
static void test_seam_on_trial(void **state) {
    (void)state;
    static const struct {
        double beyond;
        psplat_fit_status status;
    } cases[] = {
        {-0.0024, PSPLAT_FIT_KEPT}, {0.004, PSPLAT_FIT_KEPT}, {0.014, PSPLAT_FIT_TEXTURE_SLIDES}};
    stage s = {.limits = {.tolerance = 0.02,
                          .crease_tolerance = 0.01,
                          .crease_slack = 0.006,
                          .texture_tolerance = 0.02}};
    charted_make_tube(&s.c);
    fixture_sample(&s.c.f, 0.005);
    s.limits.distance = s.c.f.distance;
    psplat_fit_context context = fixture_context(&s.c.f, &s.limits, NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const psplat_region region = region_beside_seam(cases[i].beyond);
        psplat_candidate c = candidate_of(&s, &region);
        psplat_site site = psplat_site_of(&region, c.triangle);
        const psplat_demands demands = {.skip = PSPLAT_SKIP_LINES | PSPLAT_SKIP_NEARNESS |
                                                PSPLAT_SKIP_NORMALS};
        psplat_scratch scratch = {0};
        context.scratch = &scratch;
        psplat_evaluation e = psplat_evaluate(&context, &site, &region, &demands);
        assert_int_equal(e.status, cases[i].status);
        psplat_scratch_free(&scratch);
        free(c.covered);
    }
    stage_end(&s);
}

/* Coordinates that change 160 times as fast from x = 1/2 on. */
static void chart_kink(uint32_t triangle, const double p[3], float uv[2]) {
    (void)triangle;
    uv[0] = (float)(p[0] < 0.5 ? p[0] / 4 : 0.125 + 40 * (p[0] - 0.5));
    uv[1] = (float)(p[1] / 4);
}

/* Where a kink lies beyond the rim, what is there does not spoil coordinates inside, which its
 * samples give exactly, but for floats. */
static void test_kink_beyond_rim(void **state) {
    (void)state;
    stage s = {.limits = {.tolerance = 0.02, .texture_tolerance = 0.002}};
    charted_make(&s.c, 8, place_square, chart_kink);
    charted_build(&s.c, fixture_crease_angle);
    fixture_sample(&s.c.f, 0.02);
    s.limits.distance = s.c.f.distance;
    const psplat_region region = {
        .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {0.49, 0.49}};
    psplat_candidate c = candidate_of(&s, &region);
    psplat_fit_context context = fixture_context(&s.c.f, &s.limits, NULL);
    assert_int_equal(psplat_fit_texcoords(&context, &c, 1), PSPLAT_OK);
    for (int k = 0; k < 2; ++k) {
        assert_near(c.texcoord.at[k], 0, 1e-6);
        assert_near(c.texcoord.along_u[k], k ? 0 : 0.49 / 4, 1e-6);
        assert_near(c.texcoord.along_v[k], k ? 0.49 / 4 : 0, 1e-6);
    }
    free(c.covered);
    stage_end(&s);
}

int test_texcoord_fit_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_second_order),    cmocka_unit_test(test_linear),
        cmocka_unit_test(test_far_samples),     cmocka_unit_test(test_row),
        cmocka_unit_test(test_one_sample),      cmocka_unit_test(test_limits),
        cmocka_unit_test(test_candidates),      cmocka_unit_test(test_around_a_neck),
        cmocka_unit_test(test_over_a_seam),     cmocka_unit_test(test_seam_on_trial),
        cmocka_unit_test(test_kink_beyond_rim),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
