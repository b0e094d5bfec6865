/* SPDX-License-Identifier: MIT
 *
 * test_sample_spacing.c - tests that the spacing of samples follows the size of the expected
 * splats, for any number of threads. The shapes are a cube, which needs the coarsest samples,
 * waves, which need the finest ones, and a sphere between them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "fit/fit_context.h"
#include "fit/candidate.h"
#include "features/samples.h"
#include "mesh/distance.h"
#include "select/conversion.h"
#include "select/sample_spacing.h"

static const psplat_convert_desc desc = {.seed = 3};

/* Runs the stages before sampling; tolerance is in diagonals, and the finest spacing in tolerances.
 */
static void begin(psplat_conversion *c, fixture *f, double tolerance, double finest) {
    f->distance = psplat_distance_create(&f->mesh);
    assert_non_null(f->distance);
    *c = (psplat_conversion){.desc = &desc,
                             .surface = f->surface,
                             .distance = f->distance,
                             .tolerance = tolerance * f->surface.diagonal};
    c->finest = finest * c->tolerance;
    c->limits = (psplat_limits){.tolerance = 0.98 * c->tolerance,
                                .planar = 1, /* The closed forms are those of flat splats. */
                                .crease_tolerance = 0.5 * c->tolerance,
                                .crease_slack = 0.3 * c->tolerance,
                                .distance = f->distance};
}

static void end(psplat_conversion *c, fixture *f) {
    psplat_samples_free(&c->samples);
    fixture_free(f);
}

/* Asserts what holds at any density: the spacing lies between the finest one and ten times that,
 * the margin is a fifth of the spacing, and there are about as many samples as blue noise of that
 * spacing has, more than one for two squares of the spacing. */
static void check(const psplat_conversion *c) {
    double spacing = c->samples.spacing;
    assert_true(spacing >= c->finest * (1 - 1e-12) && spacing <= 3 * c->finest * (1 + 1e-12));
    assert_near(c->limits.margin, 0.2 * spacing, 1e-12 * spacing);
    assert_true((double)c->samples.count > 0.5 * c->surface.area / (spacing * spacing));
}

/* Six splats cover a cube, so that the coarsest samples suffice. */
static void test_flat(void **state) {
    (void)state;
    fixture f;
    psplat_conversion c;
    fixture_model(&f, "cube.off");
    begin(&c, &f, 0.005, 0.7);
    assert_int_equal(psplat_draw_samples_for_limits(&c, NULL), PSPLAT_OK);
    check(&c);
    assert_near(c.samples.spacing, 3 * c.finest, 1e-12 * c.finest);
    end(&c, &f);
}

/* Places waves that are higher than the tolerance and a few finest spacings long. */
static void place_waves(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0.01 * sin(80 * s) * sin(80 * t);
}

static void test_bumpy(void **state) {
    (void)state;
    fixture f;
    psplat_conversion c;
    fixture_grid(&f, 120, 120, place_waves);
    fixture_build(&f);
    begin(&c, &f, 0.001, 8);
    assert_int_equal(psplat_draw_samples_for_limits(&c, NULL), PSPLAT_OK);
    check(&c);
    assert_near(c.samples.spacing, c.finest, 1e-12 * c.finest);
    end(&c, &f);
}

/* On a sphere splats become smaller with the tolerance; with a fixed finest spacing the spacing
 * becomes smaller too, and stays between both ends. */
static void test_between(void **state) {
    (void)state;
    double before = HUGE_VAL;
    int inner = 0;
    for (int i = 0; i < 4; ++i) {
        fixture f;
        psplat_conversion c;
        fixture_model(&f, "sphere.ply");
        double tolerance = 0.02 / (1 << i);
        begin(&c, &f, tolerance, 0.01 / tolerance);
        assert_int_equal(psplat_draw_samples_for_limits(&c, NULL), PSPLAT_OK);
        check(&c);
        assert_true(c.samples.spacing <= before);
        before = c.samples.spacing;
        inner += before > 1.01 * c.finest && before < 2.99 * c.finest;
        end(&c, &f);
    }
    assert_true(inner > 0);
}

/* Any number of threads gives the same samples to the last bit. */
static void test_threads(void **state) {
    (void)state;
    const char *names[] = {"sphere.ply", "part.obj"};
    for (int i = 0; i < 2; ++i) {
        fixture f;
        psplat_conversion one, many;
        fixture_model(&f, names[i]);
        begin(&one, &f, 0.005, 1);
        many = one;
        fixture_threads(1);
        assert_int_equal(psplat_draw_samples_for_limits(&one, NULL), PSPLAT_OK);
        fixture_threads(5);
        assert_int_equal(psplat_draw_samples_for_limits(&many, NULL), PSPLAT_OK);
        fixture_threads(0);
        check(&one);
        assert_int_equal(one.samples.count, many.samples.count);
        assert_memory_equal(one.samples.positions, many.samples.positions,
                            one.samples.count * 3 * sizeof(double));
        assert_memory_equal(&one.limits.margin, &many.limits.margin, sizeof(double));
        psplat_samples_free(&many.samples);
        end(&one, &f);
    }
}

int test_sample_spacing_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_bumpy),
        cmocka_unit_test(test_between),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
