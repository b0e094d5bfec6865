/* SPDX-License-Identifier: MIT
 *
 * test_rim_points.c - tests of points beyond the rims of splats: on a disc that a line halves they
 * lie outside of it at the distances that were asked for, and all along the arc and the line.
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
#include "measure/rim_points.h"

static const double radius = 2, spacing = 0.05, least = 0.001, greatest = 0.02;
/* What a distance beyond an ellipse may err by, a length: rounding, since a disc has no error. */
static const double rounding = 1e-12;

static psplat_region half_disc(double height) {
    psplat_region region = {.center = {1, 2, height},
                            .u = {1, 0, 0},
                            .v = {0, 1, 0},
                            .n = {0, 0, 1},
                            .radius = {radius, radius},
                            .line_count = 1};
    region.lines[0][0] = 1; /* keeps x >= 1 */
    return region;
}

/* Returns how far a point of the plane is outside of the half disc, and stores on which side. */
static double outside(const double p[3], int *on_line) {
    double x = p[0] - 1, y = p[1] - 2;
    *on_line = x < 0;
    return *on_line ? -x : hypot(x, y) - radius;
}

/* Returns the widest part of a range without any of the values. */
static double widest_gap(double *values, size_t count, double from, double to) {
    double widest = 0, last = from;
    for (size_t i = 1; i < count; ++i)
        for (size_t k = i; k && values[k] < values[k - 1]; --k) {
            double swap = values[k];
            values[k] = values[k - 1];
            values[k - 1] = swap;
        }
    for (size_t i = 0; i < count; ++i) {
        widest = fmax(widest, values[i] - last);
        last = values[i];
    }
    return fmax(widest, to - last);
}

static void test_half_disc(void **state) {
    (void)state;
    enum { ROOM = 512 };
    psplat_region regions[2] = {half_disc(0), half_disc(1)};
    const psplat_rim_draw draw = {.regions = regions,
                                  .count = 2,
                                  .spacing = spacing,
                                  .least = least,
                                  .greatest = greatest,
                                  .seed = 5};
    psplat_rim_point *points;
    size_t count, arcs = 0, lines = 0;
    double arc[ROOM], line[ROOM], nearest = HUGE_VAL, farthest = 0;
    assert_int_equal(psplat_rim_points_draw(&draw, &points, &count), PSPLAT_OK);
    for (size_t i = 0; i < count; ++i) {
        int on_line;
        const double *p = points[i].point;
        double away = outside(p, &on_line);
        assert_true(away >= least - rounding && away <= greatest + rounding);
        assert_true(points[i].normal[2] == 1);
        nearest = fmin(nearest, away), farthest = fmax(farthest, away);
        if (p[2] != 0) continue; /* That of the second disc. */
        assert_true(arcs < ROOM && lines < ROOM);
        if (on_line)
            line[lines++] = p[1] - 2;
        else
            arc[arcs++] = radius * atan2(p[1] - 2, p[0] - 1);
    }
    /* Points lie evenly, so that gaps are as wide as the spacing, and twice that at ends. */
    assert_true(widest_gap(line, lines, -radius, radius) <= 2 * spacing);
    assert_true(widest_gap(arc, arcs, -fixture_pi * radius / 2, fixture_pi * radius / 2) <=
                2 * spacing);
    /* Distances are spread over all of the range. */
    assert_true(nearest < 2 * least && farthest > 0.8 * greatest);
    free(points);
}

int test_rim_points_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_half_disc),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
