/* SPDX-License-Identifier: MIT
 *
 * test_evaluate.c - tests of evaluating a region as a splat: each limit is checked and has a status
 * of its own, and the result depends on nothing but the region, the site and the demands. The shape
 * is a disc of radius 2, flat or with a dome of known height.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "mesh/mesh.h"

static const double tolerance = 0.02;

/* Height of the dome on a disc of radius 2 with an open border. */
static double dome;

static void place_dome(double s, double t, double p[3]) {
    double x = 2 * s - 1, y = 2 * t - 1;
    double most = max2(fabs(x), fabs(y)), length = hypot(x, y);
    double scale = length > 0 ? 2 * most / length : 0;
    p[0] = scale * x, p[1] = scale * y;
    p[2] = dome * (1 - most * most);
}

typedef struct stage {
    fixture f;
    psplat_limits limits;
    psplat_scratch scratch;
    psplat_fit_context context;
    float *colors;
} stage;

static void stage_begin_with(stage *s, double height, uint32_t cells) {
    *s = (stage){0};
    dome = height;
    fixture_grid(&s->f, cells, cells, place_dome);
    fixture_build(&s->f);
    fixture_sample(&s->f, 0.02);
    s->limits = (psplat_limits){.tolerance = tolerance,
                                .crease_tolerance = 0.5 * tolerance,
                                .crease_slack = 0.3 * tolerance,
                                .margin = 0.01,
                                .distance = s->f.distance};
    s->context = fixture_context(&s->f, &s->limits, &s->scratch);
}

static void stage_begin(stage *s, double height) {
    stage_begin_with(s, height, 32);
}

static void stage_end(stage *s) {
    psplat_scratch_free(&s->scratch);
    s->f.samples.colors = NULL;
    free(s->colors);
    fixture_free(&s->f);
}

static psplat_region disc(double x, double height, double radius) {
    return (psplat_region){.center = {x, 0, height},
                           .u = {1, 0, 0},
                           .v = {0, 1, 0},
                           .n = {0, 0, 1},
                           .radius = {radius, radius}};
}

/* Evaluates the region at a site of its own, at the triangle of the sample nearest to its centre.
 */
static psplat_evaluation evaluate(stage *s, const psplat_region *region,
                                  const psplat_demands *wanted) {
    psplat_demands demands = *wanted;
    uint32_t nearest = 0;
    double least = HUGE_VAL;
    for (uint32_t i = 0; i < s->f.samples.count; ++i) {
        double d = distance2_3(s->f.samples.positions + 3 * (size_t)i, region->center);
        if (d < least) least = d, nearest = i;
    }
    demands.inside = region->center;
    psplat_site site = psplat_site_of(region, s->f.samples.triangles[nearest]);
    return psplat_evaluate(&s->context, &site, region, &demands);
}

static psplat_fit_status status_of(stage *s, const psplat_region *region, int skip) {
    return evaluate(s, region, &(psplat_demands){.skip = skip}).status;
}

/* On the plane a disc covers the samples inside it, less the margin, and deviates by nothing. */
static void test_kept(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    const psplat_region region = disc(0.5, 0, 0.8);
    psplat_evaluation e = evaluate(&s, &region, &(psplat_demands){0});
    size_t inside = 0;
    for (size_t i = 0; i < s.f.samples.count; ++i) {
        const double *p = s.f.samples.positions + 3 * i;
        inside += hypot(p[0] - 0.5, p[1]) <= 0.8 - s.limits.margin;
    }
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_true(inside > 50);
    assert_int_equal(e.count, inside);
    assert_int_equal(e.region.line_count, 0);
    assert_near(e.deviation, 0, 1e-12);
    for (int k = 0; k < 5; ++k) assert_near(e.field[k], 0, 1e-6); /* float normals */
    stage_end(&s);
}

/* Each limit that a region breaks is named. */
static void test_broken(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    psplat_region region = disc(0, 0, 3); /* The round border needs more than four lines. */
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_TOO_MANY_LINES);
    region = disc(2, 0.9 * tolerance, 0.1);
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_CREASE_TOO_FAR);
    region = disc(0, 1.1 * tolerance, 0.5);
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_SAMPLES_LOST);
    stage_end(&s);
    stage_begin(&s, 0.5); /* The surface is 0.03 lower at 0.5 from the middle. */
    region = disc(0, 0.5, 0.6);
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_LEAVES_SURFACE);
    assert_int_equal(status_of(&s, &region, PSPLAT_SKIP_EXACTNESS), PSPLAT_FIT_LEAVES_SURFACE);
    assert_int_equal(status_of(&s, &region, PSPLAT_SKIP_NEARNESS), PSPLAT_FIT_KEPT);
    region = disc(0, 0.49, 0.3);
    s.limits.normal_tolerance = 0.02;
    s.limits.constant_normals = 1; /* The dome leans by 0.07 there. */
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_NORMALS_DIFFER);
    assert_int_equal(status_of(&s, &region, PSPLAT_SKIP_NORMALS), PSPLAT_FIT_KEPT);
    s.limits.constant_normals = 0;
    psplat_evaluation e = evaluate(&s, &region, &(psplat_demands){0});
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_true(e.normal_error > 0 && e.normal_error <= 0.02);
    assert_true(e.deviation > 0 && e.deviation <= tolerance);
    stage_end(&s);
}

/* On a plane of a few large triangles, which are near to all samples, a tilted disc may leave the
 * plane at its rim by the tolerance and no more. */
static void test_tilted(void **state) {
    (void)state;
    stage s;
    stage_begin_with(&s, 0, 2);
    for (int beyond = 0; beyond < 2; ++beyond) {
        psplat_region region = disc(0, 0, 1);
        double sine = (beyond ? 1.2 : 0.95) * tolerance, cosine = sqrt(1 - sine * sine);
        region.u[0] = region.n[2] = cosine;
        region.u[2] = -sine, region.n[0] = sine;
        assert_int_equal(status_of(&s, &region, 0),
                         beyond ? PSPLAT_FIT_LEAVES_SURFACE : PSPLAT_FIT_KEPT);
    }
    stage_end(&s);
}

/* One colour that changes linearly suits a ramp, and does not suit a step. */
static void test_colors(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    s.f.samples.colors = s.colors = calloc(4 * s.f.samples.count, sizeof *s.colors);
    assert_non_null(s.colors);
    s.limits.color_tolerance = 0.05;
    const psplat_region region = disc(0.3, 0, 0.8);
    for (int step = 0; step < 2; ++step) {
        for (size_t i = 0; i < s.f.samples.count; ++i) {
            const double *p = s.f.samples.positions + 3 * i;
            for (size_t k = 0; k < 3; ++k)
                s.colors[4 * i + k] = step ? (float)(p[0] > 0.3) : (float)(0.5 - 0.1 * p[0]);
        }
        assert_int_equal(status_of(&s, &region, 0),
                         step ? PSPLAT_FIT_COLORS_DIFFER : PSPLAT_FIT_KEPT);
        assert_int_equal(status_of(&s, &region, PSPLAT_SKIP_COLORS), PSPLAT_FIT_KEPT);
    }
    s.limits.constant_colors = 1;
    for (size_t i = 0; i < s.f.samples.count; ++i)
        for (size_t k = 0; k < 3; ++k)
            s.colors[4 * i + k] = (float)(0.5 - 0.2 * s.f.samples.positions[3 * i]);
    assert_int_equal(status_of(&s, &region, 0), PSPLAT_FIT_COLORS_DIFFER);
    stage_end(&s);
}

/* Besides the limits, demands are tested: to keep the seed, to keep given samples, and to gain
 * enough. */
static void test_demands(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    const psplat_region region = disc(0, 0, 0.8);
    double area = psplat_region_area(&region);
    psplat_evaluation e = evaluate(&s, &region, &(psplat_demands){0});
    uint32_t inside = s.scratch.near.samples[e.covered[0]].index, outside = 0;
    while (length3(s.f.samples.positions + 3 * (size_t)outside) < 0.9) ++outside;
    psplat_site site = psplat_site_of(&region, s.f.samples.triangles[inside]);
    const psplat_demands any = {.inside = region.center};
    site.seed = inside;
    assert_int_equal(psplat_evaluate(&s.context, &site, &region, &any).status, PSPLAT_FIT_KEPT);
    site.seed = outside;
    assert_int_equal(psplat_evaluate(&s.context, &site, &region, &any).status,
                     PSPLAT_FIT_SAMPLES_LOST);
    uint32_t covered[2] = {inside, outside};
    psplat_candidate held = {.covered = covered, .covered_count = 1};
    assert_int_equal(evaluate(&s, &region, &(psplat_demands){.held = &held}).status,
                     PSPLAT_FIT_KEPT);
    held.covered_count = 2;
    assert_int_equal(evaluate(&s, &region, &(psplat_demands){.held = &held}).status,
                     PSPLAT_FIT_SAMPLES_LOST);
    const struct {
        double least_area;
        size_t more_than;
        psplat_fit_status status;
    } cases[] = {
        {0.99 * area, SIZE_MAX, PSPLAT_FIT_KEPT},    {1.01 * area, SIZE_MAX, PSPLAT_FIT_NO_GAIN},
        {1.01 * area, e.count - 1, PSPLAT_FIT_KEPT}, {1.01 * area, e.count, PSPLAT_FIT_NO_GAIN},
        {HUGE_VAL, e.count - 1, PSPLAT_FIT_KEPT},    {HUGE_VAL, SIZE_MAX, PSPLAT_FIT_NO_GAIN}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_int_equal(evaluate(&s, &region,
                                  &(psplat_demands){.least_area = cases[i].least_area,
                                                    .more_than = cases[i].more_than})
                             .status,
                         cases[i].status);
    stage_end(&s);
}

/* Whether a region is kept does not depend on whether any reason will do for refusing it, and a
 * region whose rim leaves the surface is refused for that even where it does not gain. The radii
 * reach over the one beyond which the discs leave the dome, and the heights over the surface. */
static void test_any_reason(void **state) {
    (void)state;
    stage s;
    size_t kept = 0, refused = 0;
    stage_begin(&s, 0.5);
    for (int step = 0; step < 60; ++step) {
        double radius = 0.05 + 0.01 * (step % 30), height = step < 30 ? 0.5 : 0.5 + 0.9 * tolerance;
        const psplat_region region = disc(0, height, radius);
        psplat_fit_status status = evaluate(&s, &region, &(psplat_demands){0}).status;
        psplat_fit_status any = evaluate(&s, &region, &(psplat_demands){.any_reason = 1}).status;
        assert_int_equal(any == PSPLAT_FIT_KEPT, status == PSPLAT_FIT_KEPT);
        kept += !status, refused += status != PSPLAT_FIT_KEPT;
    }
    assert_true(kept > 10 && refused > 10);
    const psplat_region wide = disc(0, 0.5, 0.6);
    psplat_demands gainless = {.least_area = HUGE_VAL, .more_than = SIZE_MAX - 1};
    assert_int_equal(evaluate(&s, &wide, &gainless).status, PSPLAT_FIT_NO_GAIN);
    gainless.any_reason = 1;
    assert_int_equal(evaluate(&s, &wide, &gainless).status, PSPLAT_FIT_LEAVES_SURFACE);
    stage_end(&s);
}

/* Two evaluations agree, whatever was evaluated between them, at that site or elsewhere. */
static void test_repeated(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0.1);
    const psplat_region region = disc(0.2, 0.09, 0.7), larger = disc(0.2, 0.09, 0.9),
                        other = disc(-0.9, 0.08, 0.2);
    const psplat_demands any = {.inside = region.center};
    psplat_site site = psplat_site_of(&region, s.f.samples.triangles[0]), elsewhere;
    for (uint32_t i = 0; i < s.f.samples.count; ++i)
        if (distance2_3(s.f.samples.positions + 3 * (size_t)i, region.center) < 0.01)
            site.triangle = s.f.samples.triangles[i];
    elsewhere = site;
    psplat_evaluation first = psplat_evaluate(&s.context, &site, &region, &any);
    assert_int_equal(first.status, PSPLAT_FIT_KEPT);
    for (int i = 0; i < 3; ++i) {
        if (i == 0) psplat_evaluate(&s.context, &site, &larger, &any);
        if (i == 1) psplat_evaluate(&s.context, &elsewhere, &other, &any);
        if (i == 2) evaluate(&s, &other, &any);
        psplat_evaluation again = psplat_evaluate(&s.context, &site, &region, &any);
        assert_int_equal(again.status, PSPLAT_FIT_KEPT);
        assert_int_equal(again.count, first.count);
        assert_memory_equal(again.field, first.field, sizeof again.field);
        assert_near(again.deviation, first.deviation, 0);
    }
    stage_end(&s);
}

/* The splat of last resort covers its one sample, or none, whatever the limits are. */
static void test_one(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    s.limits.tolerance = s.limits.crease_tolerance = 1e-9;
    const double *point = s.f.samples.positions;
    const psplat_region region = disc(point[0], 0.001, 0.05);
    psplat_region at = region;
    at.center[1] = point[1];
    psplat_site site = psplat_site_of(&at, s.f.samples.triangles[0]);
    psplat_evaluation e = psplat_evaluate_single_sample(&s.context, &site, &at, point, 0, 0);
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_int_equal(e.count, 1);
    assert_int_equal(s.scratch.near.samples[e.covered[0]].index, 0);
    assert_near(e.deviation, 0.001, 1e-12);
    e = psplat_evaluate_single_sample(&s.context, &site, &at, point, PSPLAT_NONE, 0);
    assert_int_equal(e.status, PSPLAT_FIT_KEPT);
    assert_int_equal(e.count, 0);
    stage_end(&s);
}

int test_evaluate_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kept),    cmocka_unit_test(test_broken),
        cmocka_unit_test(test_tilted),  cmocka_unit_test(test_colors),
        cmocka_unit_test(test_demands), cmocka_unit_test(test_repeated),
        cmocka_unit_test(test_one),     cmocka_unit_test(test_any_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
