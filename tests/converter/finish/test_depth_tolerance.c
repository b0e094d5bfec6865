/* SPDX-License-Identifier: MIT
 *
 * test_depth_tolerance.c - tests of the depth tolerance: twice the greatest deviation, half of that
 * where it reaches another layer beneath, and never less than a quarter of the tolerance.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "layers_fixture.h"
#include "fit/candidate.h"
#include "select/conversion.h"
#include "finish/depth_tolerance.h"

/* Returns the depth tolerance where splats of a sheet in two layers deviate so far. */
static double depth_of(const fixture *f, double tolerance, double deviation) {
    psplat_candidate candidates[2] = {{.taken = 1, .deviation = deviation / 2},
                                      {.taken = 1, .deviation = deviation}};
    const psplat_conversion c = {.surface = f->surface,
                                 .samples = f->samples,
                                 .distance = f->distance,
                                 .tolerance = tolerance,
                                 .selection = {.candidates = candidates, .count = 2}};
    float depth;
    assert_int_equal(psplat_depth_tolerance_choose(&c, &depth), PSPLAT_OK);
    return (double)depth;
}

static void test_layers(void **state) {
    (void)state;
    fixture f;
    fixture_layers(&f);
    const double rounding = 1e-6 * layer_height;
    /* 0.9 of the distance of the layers does not reach the lower one, and 1.1 does. */
    assert_near(depth_of(&f, layer_height, 0.45 * layer_height), 0.9 * layer_height, rounding);
    assert_near(depth_of(&f, layer_height, 0.55 * layer_height), 0.55 * layer_height, rounding);
    assert_near(depth_of(&f, layer_height, 0.1 * layer_height), 0.25 * layer_height, rounding);
    fixture_free(&f);
}

int test_depth_tolerance_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_layers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
