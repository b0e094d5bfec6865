/* SPDX-License-Identifier: MIT
 *
 * test_close_cracks.c - tests of closing cracks that clip lines leave: two splats over a square
 * that end a known width apart. Afterwards they meet, unless the crack is too wide or a splat would
 * leave the surface.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/nearness.h"
#include "finish/close_cracks.h"
#include "select/conversion.h"

/* The tolerance on a square of side 1, and where the first splat ends. */
static const double tolerance = 0.002, middle = 0.5;

typedef struct cracked {
    fixture f;
    psplat_convert_desc desc;
    psplat_conversion c;
    psplat_candidate candidates[2];
} cracked;

static void place_square(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* A splat over a strip of the square that ends at a line: it keeps sign * (x - from) >= 0. It is
 * raised at that line by height, and rises towards it. */
static psplat_region strip(double sign, double from, double height, double rise) {
    psplat_region region = {.center = {from, 0.5, height}, .radius = {0.2, 0.2}, .line_count = 1};
    double length = hypot(1, rise);
    if (rise > 0) region.radius[0] = 0.01; /* Its far end stays near the square, too. */
    region.u[0] = 1 / length, region.u[2] = -sign * rise / length;
    region.v[1] = 1;
    cross3(region.n, region.u, region.v);
    region.lines[0][0] = sign;
    return region;
}

/* Puts two splats on a square that end `width` apart, the first one raised, rising to its end. */
static void begin(cracked *r, double width, double height, double rise) {
    *r = (cracked){0};
    fixture_grid(&r->f, 3, 3, place_square);
    fixture_build(&r->f);
    fixture_sample(&r->f, 0.05);
    r->c = (psplat_conversion){
        .desc = &r->desc,
        .surface = r->f.surface,
        .samples = r->f.samples,
        .distance = r->f.distance,
        .tolerance = tolerance,
        .limits = {.tolerance = tolerance, .proven = 1, .distance = r->f.distance},
        .selection = {r->candidates, 2, 2}};
    r->candidates[0].region = strip(-1, middle, height, rise);
    r->candidates[1].region = strip(1, middle + width, 0, 0);
    for (int i = 0; i < 2; ++i) r->candidates[i].taken = 1;
}

static void end(cracked *r) {
    fixture_free(&r->f);
}

/* Returns how far the line of a splat has moved out, a length. */
static double moved(const cracked *r, int index) {
    return r->candidates[index].region.lines[0][2] * r->candidates[index].region.radius[0];
}

/* A narrow crack is closed, with a little to spare. */
static void test_narrow(void **state) {
    (void)state;
    cracked r;
    double width = 0.1 * tolerance;
    begin(&r, width, 0, 0);
    assert_int_equal(psplat_close_cracks(&r.c), PSPLAT_OK);
    double sum = moved(&r, 0) + moved(&r, 1);
    print_message("a crack of %g tolerances: lines moved by %g\n", width / tolerance,
                  sum / tolerance);
    /* Points beyond rims lie a fiftieth of the tolerance outside at least, and so far may be left;
     * each line is moved by as much to spare. */
    assert_true(sum >= width - 0.02 * tolerance && sum <= width + 0.04 * tolerance);
    for (int i = 0; i < 2; ++i)
        assert_true(moved(&r, i) <= PSPLAT_GREATEST_CRACK * tolerance * (1 + 1e-9));
    end(&r);
}

/* A crack of half a tolerance is closed by splats of the patch that is seen through it, not by
 * those of another one. */
static void test_own(void **state) {
    (void)state;
    for (uint32_t other = 0; other < 2; ++other) {
        cracked r;
        double width = 0.5 * tolerance;
        begin(&r, width, 0, 0);
        r.c.surface.patches[0] = other; /* of a triangle at a corner, from which both grew */
        assert_int_equal(psplat_close_cracks(&r.c), PSPLAT_OK);
        double sum = moved(&r, 0) + moved(&r, 1);
        assert_true(other ? sum < 0.7 * width : sum >= width - 0.02 * tolerance);
        end(&r);
    }
}

/* Wide cracks may be narrowed from either side, but by no more than is allowed. */
static void test_wide(void **state) {
    (void)state;
    for (uint32_t other = 0; other < 2; ++other) {
        cracked r;
        double most = (other ? PSPLAT_GREATEST_CRACK : PSPLAT_GREATEST_OWN_CRACK) * tolerance;
        begin(&r, 3 * tolerance, 0, 0);
        r.c.surface.patches[0] = other;
        assert_int_equal(psplat_close_cracks(&r.c), PSPLAT_OK);
        for (int i = 0; i < 2; ++i)
            assert_true(moved(&r, i) >= 0 && moved(&r, i) <= most * (1 + 1e-9));
        end(&r);
    }
}

/* Splats that overlap stay as they are. */
static void test_closed(void **state) {
    (void)state;
    cracked r;
    begin(&r, -tolerance, 0, 0);
    assert_int_equal(psplat_close_cracks(&r.c), PSPLAT_OK);
    assert_true(moved(&r, 0) == 0 && moved(&r, 1) == 0);
    end(&r);
}

/* A splat that ends at the tolerance, and rises, does not follow rays that would lead it beyond. */
static void test_bound(void **state) {
    (void)state;
    static const double rise = 0.1;
    cracked r;
    /* Over an eighth of a tolerance it would rise beyond it. */
    begin(&r, 0.14 * tolerance, (1 - rise / 8) * tolerance, rise);
    assert_int_equal(psplat_close_cracks(&r.c), PSPLAT_OK);
    int near;
    assert_int_equal(psplat_limits_region_near(&r.c.limits, &r.candidates[0].region, &near),
                     PSPLAT_OK);
    assert_true(near);
    assert_true(moved(&r, 0) <= tolerance / 8 * (1 + rise));
    end(&r);
}

int test_close_cracks_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_narrow), cmocka_unit_test(test_own),   cmocka_unit_test(test_wide),
        cmocka_unit_test(test_closed), cmocka_unit_test(test_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
