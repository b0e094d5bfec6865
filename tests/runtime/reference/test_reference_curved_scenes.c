/* SPDX-License-Identifier: MIT
 *
 * test_reference_curved_scenes.c - tests curved splats of the reference rasteriser among others:
 * what blends, flat splats in their primitive, and shadows (spec 3.4, 4, 5.3).
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "curved_fixture.h"

/* ---- tolerance ------------------------------------------------------------------------------- */

/* Of two equal hills over each other, the lower one contributes where the gap is at most epsilon
 * over the cosine at the fragment, which falls towards the rim. */
static void test_tolerance(void **state) {
    (void)state;
    const double k = 2.5, gap = 0.1, tolerance = 0.06;
    size_t lone = 0, blended = 0;
    scene s = shaped(1, 1, k, k, 0), two = scene_blank(2);
    two.depth_tolerance = (float)tolerance;
    two.splats[0] = two.splats[1] = s.splats[0];
    two.splats[1].center[2] = (float)-gap;
    psplat_view view = side_view();
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    picture p = picture_of(&two, NULL, &view);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        double r = hypot(side_of(i % SIDE), side_of(i / SIDE));
        double cosine = 1 / sqrt(1 + k * k * r * r);
        int both = (double)(float)gap <= (double)(float)tolerance / fmax(cosine, 0.5);
        if (p.image.tie[i] < 1e-9 || p.image.epsilon_tie[i] < 1e-9) continue;
        assert_int_equal(p.image.count[i], r > 1 ? 0 : 1 + both);
        lone += r <= 1 && !both;
        blended += r <= 1 && both;
    }
    assert_true(lone > 500 && blended > 500);
    picture_free(&p);
    scene_free(&s);
    scene_free(&two);
}

/* ---- flat splats among curved ones ----------------------------------------------------------- */

/* A disc of less than a pixel and one of many: the filter widens the small one, but not where it is
 * among curved splats, though its own shape is 0 (spec 3.4). Drawn without the filter both kinds
 * of primitive show the same disc. */
static void test_flat_among_curved(void **state) {
    (void)state;
    const float small = (float)(0.4 * DISTANCE / FOCAL), radii[] = {small, 1};
    for (int i = 0; i < 2; ++i) {
        scene flat = scene_disc(radii[i]), curved = scene_disc(radii[i]);
        flat.splats[0].center[0] = curved.splats[0].center[0] = small;
        flat.splats[0].center[1] = curved.splats[0].center[1] = small;
        flat.splats[0].gradient[0] = curved.splats[0].gradient[0] = 2;
        curved.flat_is_curved = 1;
        psplat_view view = front_view();
        view.no_filter = 0;
        picture filtered = picture_of(&flat, NULL, &view), q = picture_of(&curved, NULL, &view);
        view.no_filter = 1;
        picture p = picture_of(&flat, NULL, &view);
        int differs = 0;
        assert_true(picture_covered(&p) > 0);
        for (int k = 0; k < WIDTH * HEIGHT; ++k) {
            assert_int_equal(q.image.count[k], p.image.count[k]);
            if (!p.image.count[k]) continue;
            /* Roots and planes round differently. */
            assert_near(q.image.depth[k], p.image.depth[k], 1e-9);
            for (int c = 0; c < 3; ++c)
                assert_near(q.image.color[4 * k + c], p.image.color[4 * k + c], 1e-6);
            differs |=
                fabs((double)filtered.image.color[4 * k] - (double)p.image.color[4 * k]) > 1e-3;
        }
        assert_int_equal(differs, i == 0);
        picture_free(&p);
        picture_free(&q);
        picture_free(&filtered);
        scene_free(&flat);
        scene_free(&curved);
    }
}

/* ---- shadows --------------------------------------------------------------------------------- */

/* Returns by how much the height over the surface z = height - k (u^2 + v^2) / 2 rises along l. */
static double rise_of(const double l[3], double k, double u, double v) {
    return l[2] + k * (u * l[0] + v * l[1]);
}

/* Returns the s at which the way (u, v, 0) + s l to the light leaves the cylinder of radius 0.5
 * under the rim, no deeper than the wall and so that the light sees it from above; else 0. */
static double way_to_wall(const double l[3], double u, double v, double height, double k,
                          double wall, double *cosine) {
    double a = l[0] * l[0] + l[1] * l[1], b = u * l[0] + v * l[1], c = u * u + v * v - 0.25;
    double s = (-b + sqrt(b * b - a * c)) / a, rim_height = height - k / 8;
    u += s * l[0], v += s * l[1];
    *cosine = rise_of(l, k, u, v) / sqrt(1 + k * k / 4);
    return s > 0 && s * l[2] < rim_height && s * l[2] > rim_height - wall && *cosine > 0 ? s : 0;
}

/* A hill or bowl z = height - k ((X - 0.25)^2 + Y^2) / 2 of radius 0.5 stands over the floor z = 0.
 * On the way (x, y, 0) + s l to the light, the greater root with which it is inside the ellipse is
 * the point that the light sees, else it may be one of the wall. Returns 1 where it lies farther
 * than epsilon, of walls eight of them, over its cosine. */
static int is_dark(const double l[3], double x, double y, double height, double k, double epsilon) {
    double a = k * (l[0] * l[0] + l[1] * l[1]) / 2;
    double b = l[2] + k * ((x - 0.25) * l[0] + y * l[1]);
    double c = k * ((x - 0.25) * (x - 0.25) + y * y) / 2 - height;
    double root = sqrt(b * b - 4 * a * c), seen = 0, cosine = 1;
    int is_met = 0;
    for (int i = 0; i < 2; ++i) {
        double s = a == 0 ? -c / b : (-b + (i ? root : -root)) / (2 * a);
        double u = x + s * l[0] - 0.25, v = y + s * l[1];
        is_met |= hypot(u, v) <= 0.5;
        if (!(s > seen && hypot(u, v) <= 0.5)) continue;
        seen = s;
        cosine = fabs(rise_of(l, k, u, v)) / sqrt(1 + k * k * (u * u + v * v));
    }
    if (!is_met) {
        seen = way_to_wall(l, x - 0.25, y, height, k, epsilon / 4, &cosine);
        epsilon *= 8;
    }
    return seen > epsilon / fmax(cosine, 0.5);
}

static size_t check_shadow(const double l[3], double k, double epsilon) {
    const double height = 0.875;
    scene s = scene_blank(2);
    s.depth_tolerance = (float)epsilon;
    s.splats[0].radius[0] = s.splats[0].radius[1] = 100;
    psplat_splat *caster = &s.splats[1];
    caster->radius[0] = caster->radius[1] = 0.5f;
    caster->center[0] = 0.25f, caster->center[2] = (float)height;
    caster->shape[2] = caster->shape[3] = (float)(k / 2);
    psplat_view view = camera_view(SIDE, SIDE);
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    camera_parallel(&view, 2, DISTANCE - 0.1, 10); /* the near plane is under the caster */
    for (int i = 0; i < 3; ++i) view.lights[0].direction[i] = (float)-l[i];
    view.lights[0].casts_shadow = 1;
    picture p = picture_of(&s, NULL, &view);
    size_t dark = 0, wrong = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        int expected = is_dark(l, 2 * side_of(i % SIDE), 2 * side_of(i / SIDE), height, k,
                               (double)(float)epsilon);
        assert_int_equal(p.image.splat[i], 0);
        wrong += (p.image.color[4 * i] == 0) != expected;
        dark += (size_t)expected;
    }
    /* The light's direction and epsilon are floats: at most a pixel at an edge may differ. */
    assert_true(wrong <= 1);
    picture_free(&p);
    scene_free(&s);
    return dark;
}

static void test_shadows(void **state) {
    (void)state;
    const double lights[][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0, -0.8, 0.6}};
    for (int i = 0; i < 3; ++i) {
        assert_true(check_shadow(lights[i], 3, 0.01) > 100);
        assert_true(check_shadow(lights[i], -3, 0.01) > 100);
        assert_true(check_shadow(lights[i], 5.5, 0.01) > 100);
        assert_true(check_shadow(lights[i], 3, 0.05) > 100); /* with walls */
        assert_true(check_shadow(lights[i], 1, 0.09) > 100);
        check_shadow(lights[i], 3, 0.9);
        check_shadow(lights[i], 5.5, 0.7);
        check_shadow(lights[i], -5.5, 1.2);
    }
}

int test_reference_curved_scenes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tolerance),
        cmocka_unit_test(test_flat_among_curved),
        cmocka_unit_test(test_shadows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
