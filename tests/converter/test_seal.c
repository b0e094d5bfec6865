/* SPDX-License-Identifier: MIT
 * Cracks that open to slanted views: found where there is one, and closed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "stage_fixture.h"

/* A flat square of 1 x 1 in z = 0. */
static void place_flat(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* Half of the square as a splat at a height: 0 the half with x <= 0.5, 1 the other. */
static psplat_candidate half_square(int half, double height, double overlap) {
    psplat_candidate c = {.region = {.center = {0.5, 0.5, height},
                                     .u = {1, 0, 0},
                                     .v = {0, 1, 0},
                                     .n = {0, 0, 1},
                                     .radius = {2, 2},
                                     .lines = {{half ? 1 : -1, 0, overlap / 2}},
                                     .line_count = 1},
                          .color = {1, 1, 1, 1}};
    return c;
}

/* Of 20,000 views of samples at least 0.1 from the border, how many pass by. */
static size_t count_open(const fixture *f, const psplat_splats *splats, double tolerance) {
    psplat_samples probes;
    size_t total = 0, inner = 0;
    assert_int_equal(psplat_samples_draw_uniform(&f->surface, 20000, 3, &probes, NULL), PSPLAT_OK);
    uint8_t *open = malloc(probes.count);
    assert_non_null(open);
    assert_int_equal(psplat_verify_sight(&probes, splats, tolerance, open, &total), PSPLAT_OK);
    for (size_t i = 0; i < probes.count; ++i) {
        const double *p = probes.positions + 3 * i;
        inner += open[i] && fabs(p[0] - 0.5) < 0.4 && fabs(p[1] - 0.5) < 0.4;
    }
    free(open);
    psplat_samples_free(&probes);
    return inner;
}

/* Two halves at heights 0.02 apart: under 60 degrees a strip of up to 0.02 tan 60 = 0.035 beside
 * the step shows the gap between them; an overlap of that size closes it. */
static void test_step(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 4, 4, place_flat);
    fixture_build(&f);
    for (int closed = 0; closed < 2; ++closed) {
        double overlap = closed ? 0.035 : 0;
        psplat_candidate halves[2] = {half_square(0, 0.01, overlap),
                                      half_square(1, -0.01, overlap)};
        psplat_selection selection = {halves, 2, 2};
        psplat_splats splats = {.kernel = {2, 2}};
        assert_int_equal(psplat_store_splats(&selection, 0, &splats), PSPLAT_OK);
        size_t open = count_open(&f, &splats, 0.02);
        print_message("overlap %.3f: %zu of 20000 samples open\n", overlap, open);
        /* 0.035 x 0.8 of the square are 554 samples; the six views pass half of that or more. */
        if (closed)
            assert_int_equal(open, 0);
        else
            assert_in_range(open, 270, 620);
        psplat_splats_free(&splats);
    }
    fixture_free(&f);
}

/* The same step, sealed by splats that keep near the surface. */
static void test_sealed(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 4, 4, place_flat);
    fixture_build(&f);
    fixture_sample(&f, 0.02);
    psplat_selection selection = {0};
    for (int half = 0; half < 2; ++half) {
        psplat_candidate c = half_square(half, half ? -0.01 : 0.01, 0);
        assert_int_equal(psplat_selection_push(&selection, &c), 1);
    }
    psplat_splats splats = {.kernel = {2, 2}};
    assert_int_equal(psplat_store_splats(&selection, 0, &splats), PSPLAT_OK);
    psplat_limits limits = {.tolerance = 0.02,
                            .crease_tolerance = 0.01,
                            .crease_slack = 0.002,
                            .margin = 2 * f.samples.spacing,
                            .normal_error = 0.1};
    psplat_seal seal = {&f.surface, &f.samples, &limits, &splats, &selection, 0.02, 1};
    assert_true(count_open(&f, &splats, 0.02) > 100);
    assert_int_equal(psplat_seal_cracks(&seal, &splats), PSPLAT_OK);
    assert_true(splats.count > 2);
    assert_int_equal(count_open(&f, &splats, 0.02), 0);
    for (size_t i = 2; i < selection.count; ++i)
        assert_true(selection.candidates[i].deviation <= 0.02 / 2); /* the tight tolerance */
    psplat_splats_free(&splats);
    psplat_selection_free(&selection);
    fixture_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_step),
        cmocka_unit_test(test_sealed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
