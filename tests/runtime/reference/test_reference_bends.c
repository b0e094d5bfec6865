/* SPDX-License-Identifier: MIT
 *
 * test_reference_bends.c - tests bent clip lines of the reference rasteriser by eq. (3b)
 * (spec 3.6).
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "curved_fixture.h"

/* Draws a splat with lines of both bends and asserts by eq. (3b) what is left of it. Returns the
 * number of covered pixels. */
static size_t check_bent(const scene *s) {
    const psplat_splat *splat = &s->splats[0];
    scene whole = *s;
    psplat_splat uncut = *splat;
    uncut.clip_count = 0;
    whole.splats = &uncut;
    psplat_view view = front_view();
    picture p = picture_of(s, NULL, &view), q = picture_of(&whole, NULL, &view);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        double u = q.image.uv[2 * i], v = q.image.uv[2 * i + 1];
        int kept = q.image.count[i] > 0;
        for (uint32_t k = 0; k < splat->clip_count; ++k) {
            double a = splat->clip[k][0], b = splat->clip[k][1], c = splat->clip[k][2];
            double along = a * v - b * u, bend = splat->bend[k];
            if (!(a * u + b * v + c + bend * along * along / 2 >= 0)) kept = 0;
        }
        assert_int_equal(p.image.count[i], kept);
        if (!kept) continue;
        assert_near(p.image.uv[2 * i], u, 0);
        assert_near(p.image.depth[i], q.image.depth[i], 0);
    }
    size_t covered = picture_covered(&p);
    picture_free(&p);
    picture_free(&q);
    return covered;
}

static void test_bent_lines(void **state) {
    (void)state;
    for (int is_curved = 0; is_curved < 2; ++is_curved) {
        size_t counts[3];
        for (int i = 0; i < 3; ++i) {
            scene s = shaped(1.5, 1, is_curved * 0.75, is_curved * -0.5, is_curved * 0.25);
            psplat_splat *splat = &s.splats[0];
            splat->clip_count = 1;
            splat->clip[0][0] = 0.6f, splat->clip[0][1] = 0.8f, splat->clip[0][2] = -0.1f;
            splat->bend[0] = (float)(2 * (i - 1));
            counts[i] = check_bent(&s);
            splat->clip_count = 2;
            splat->clip[1][0] = -2, splat->clip[1][1] = 1, splat->clip[1][2] = 1.5f;
            splat->bend[1] = -0.75f;
            assert_true(check_bent(&s) > 100);
            scene_free(&s);
        }
        /* A line that bends towards what it keeps takes more away. */
        assert_true(counts[0] + 100 < counts[1] && counts[1] + 100 < counts[2]);
    }
}

/* The tie of a bent line's pixels is their distance from it: of a circle of curvature 2 about (c +
 * 1/2, 0) the parabola's vertex lies at u = c, and near its axis distances are those along u. */
static void test_bent_ties(void **state) {
    (void)state;
    scene s = scene_disc(1.5f);
    s.splats[0].clip_count = 1;
    s.splats[0].clip[0][0] = 1;
    s.splats[0].bend[0] = 2;
    psplat_view view = front_view();
    view.height = HEIGHT + 1; /* so that a row of pixels is in the middle */
    camera_perspective(&view, FOCAL, NEAR, FAR);
    picture p = picture_of(&s, NULL, &view);
    const double pixels = 1.5 * FOCAL / DISTANCE;
    for (int x = WIDTH / 2 - 8; x < WIDTH / 2 + 8; ++x) {
        double u = (x + 0.5 - WIDTH / 2.0) / pixels;
        assert_near(p.image.tie[HEIGHT / 2 * WIDTH + x], fabs(u), 1e-9);
        double v = 10 / pixels, value = u + v * v, slope = hypot(1, 2 * v);
        double edge = 1 - hypot(u, v);
        assert_near(p.image.tie[(HEIGHT / 2 + 10) * WIDTH + x], fmin(fabs(value) / slope, edge),
                    1e-9);
    }
    picture_free(&p);
    scene_free(&s);
}

int test_reference_bends_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bent_lines),
        cmocka_unit_test(test_bent_ties),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
