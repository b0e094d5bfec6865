/* SPDX-License-Identifier: MIT
 *
 * test_reference_curved.c - tests the fronts of curved splats of the reference rasteriser against
 * closed forms (spec 3.4, 5.1), under transforms too.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "curved_fixture.h"

/* ---- surfaces ------------------------------------------------------------------------------- */

/* Returns the s at which the ray (dx, dy, -1) meets the front of the surface; it is not positive or
 * NaN where it does not. */
static double front_of(const surface *f, double dx, double dy) {
    double k = f->a * dx * dx + 2 * f->b * dx * dy + f->c * dy * dy;
    double m = 1 - f->p * dx - f->q * dy;
    return 2 * DISTANCE / (m + sqrt(m * m - 2 * DISTANCE * k));
}

/* Asserts that a picture of front_view shows the front of the surface, and returns the number of
 * pixels that it covers. Pixels whose decision hangs on rounding are left out. */
static size_t check_front(const picture *p, const surface *f, double tolerance) {
    size_t covered = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            int at = y * WIDTH + x;
            double s = front_of(f, ray_x(x), ray_y(y));
            double u = s * ray_x(x) / f->radius_u, v = s * ray_y(y) / f->radius_v;
            int inside = u * u + v * v <= 1 && s >= NEAR && s <= FAR;
            if (p->image.tie[at] < 10 * tolerance) continue;
            assert_int_equal(p->image.count[at], inside);
            if (!inside) continue;
            assert_near(p->image.uv[2 * at], u, tolerance);
            assert_near(p->image.uv[2 * at + 1], v, tolerance);
            assert_near(p->image.depth[at], depth_of(s), tolerance);
            ++covered;
        }
    return covered;
}

static size_t check_scene(const scene *s, const double transform[16], const surface *f,
                          double tolerance) {
    psplat_view view = front_view();
    picture p = picture_of(s, transform, &view);
    size_t covered = check_front(&p, f, tolerance);
    picture_free(&p);
    return covered;
}

/* A cap of a sphere of radius R is a paraboloid of curvature 1 / R up to the fourth order: at a
 * distance r from the axis their heights differ by less than r^4 / (8 R^3) (1 + r^2 / R^2). */
static void test_sphere_cap(void **state) {
    (void)state;
    const double radius = 1, sphere = 2;
    scene s = shaped(radius, radius, radius / sphere, radius / sphere, 0);
    surface f = surface_of(&s.splats[0]);
    assert_true(check_scene(&s, NULL, &f, ROUNDING) > 1000);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            int at = y * WIDTH + x;
            if (!p.image.count[at]) continue;
            double r = hypot(p.image.uv[2 * at], p.image.uv[2 * at + 1]) * radius;
            double cap = sqrt(sphere * sphere - r * r) - sphere;
            /* u = s dx / radius gives s back, without the window depth. */
            double distance = p.image.uv[2 * at] * radius / ray_x(x);
            double apart = pow(r, 4) / (8 * pow(sphere, 3)) * (1 + r * r / (sphere * sphere));
            assert_near(DISTANCE - distance, cap, apart + ROUNDING);
        }
    picture_free(&p);
    scene_free(&s);
}

static void test_cylinder(void **state) {
    (void)state;
    scene s = shaped(1.5, 1, 1.75, 0, 0);
    surface f = surface_of(&s.splats[0]);
    assert_true(check_scene(&s, NULL, &f, ROUNDING) > 1000);
    scene_free(&s);
}

static void test_saddle(void **state) {
    (void)state;
    scene s = shaped(1.5, 0.75, 1.25, -0.75, 0.5);
    surface f = surface_of(&s.splats[0]);
    assert_true(check_scene(&s, NULL, &f, ROUNDING) > 500);
    scene_free(&s);
}

/* The surface of a field has its slopes and curvatures, and the field's normals. */
static void test_field(void **state) {
    (void)state;
    scene s = scene_blank(1);
    psplat_splat *splat = &s.splats[0];
    const double x = 0.5, y = -0.25, length = sqrt(1 + x * x + y * y);
    const float radius[2] = {1.5f, 0.75f}, normal[3] = {0.5f, -0.25f, 1};
    const float gradient[3] = {0.75f, 0.5f, -0.25f};
    memcpy(splat->radius, radius, sizeof radius);
    memcpy(splat->gradient, gradient, sizeof gradient);
    for (int i = 0; i < 3; ++i) splat->normal[i] = (float)((double)normal[i] / length);
    scene_curve(&s);
    surface f = surface_of(splat);
    assert_near(f.p, x, FLOAT_STEP);
    assert_near(f.q, y, FLOAT_STEP);
    assert_true(check_scene(&s, NULL, &f, FLOAT_STEP) > 500);
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        if (!p.image.count[i]) continue;
        double u = p.image.uv[2 * i] * f.radius_u, v = p.image.uv[2 * i + 1] * f.radius_v;
        double n[3] = {f.p + f.a * u + f.b * v, f.q + f.b * u + f.c * v, 1};
        double norm = sqrt(n[0] * n[0] + n[1] * n[1] + 1);
        for (int c = 0; c < 3; ++c)
            assert_near((double)p.image.color[4 * i + c], 0.5 + 0.5 * n[c] / norm, 4 * FLOAT_STEP);
    }
    picture_free(&p);
    scene_free(&s);
}

/* With SHAPE, the normals that are blended are those of the field and not the surface's. */
static void test_shape_beside_field(void **state) {
    (void)state;
    scene s = shaped(1, 1, 1, 1, 0);
    s.splats[0].gradient[0] = -0.5f;
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    picture p = picture_of(&s, NULL, &view);
    assert_true(picture_covered(&p) > 1000);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        if (!p.image.count[i]) continue;
        double x = -0.5 * p.image.uv[2 * i];
        assert_near((double)p.image.color[4 * i], 0.5 + 0.5 * x / sqrt(1 + x * x), FLOAT_STEP);
        assert_near((double)p.image.color[4 * i + 1], 0.5, FLOAT_STEP);
    }
    picture_free(&p);
    scene_free(&s);
}

/* ---- transforms ------------------------------------------------------------------------------ */

/* Under diag(a, b, c) the surface z = h(X, Y) becomes z = c h(X / a, Y / b); a shear that adds k x
 * to z adds a slope. Neither changes (u, v). */
static void test_transforms(void **state) {
    (void)state;
    const double scales[][4] = {{2, 1, 1, 0},    {1, 0.5, 3, 0},  {-1, 1, 1, 0},
                                {1, -2, 0.5, 0}, {1, 1, 1, 0.75}, {-0.5, 2, 2, -0.5}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; ++i) {
        const double *k = scales[i];
        const double m[16] = {k[0], 0, k[3], 0, 0, k[1], 0, 0, 0, 0, k[2], 0, 0, 0, 0, 1};
        scene s = shaped(0.75, 0.5, 0.5, -0.75, 0.25);
        surface f = surface_of(&s.splats[0]);
        f.p = -k[3] / k[0];
        f.a *= k[2] / (k[0] * k[0]);
        f.b *= k[2] / (k[0] * k[1]);
        f.c *= k[2] / (k[1] * k[1]);
        f.radius_u *= k[0];
        f.radius_v *= k[1];
        assert_true(check_scene(&s, m, &f, 10 * ROUNDING) > 100);
        scene_free(&s);
    }
}

/* A mirror along N turns the front away. */
static void test_mirrored_front(void **state) {
    (void)state;
    const double mirror[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
    const double turn[16] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
    scene s = shaped(1, 1, 0.5, 0.5, 0);
    psplat_view view = front_view();
    picture p = picture_of(&s, mirror, &view), q = picture_of(&s, turn, &view);
    assert_int_equal(picture_covered(&p), 0);
    assert_int_equal(picture_covered(&q), 0);
    camera_look(&view, (double[]){0, 0, -DISTANCE}, (double[]){0, 0, 0});
    picture r = picture_of(&s, mirror, &view);
    assert_true(picture_covered(&r) > 1000);
    picture_free(&p);
    picture_free(&q);
    picture_free(&r);
    scene_free(&s);
}

int test_reference_curved_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere_cap),
        cmocka_unit_test(test_cylinder),
        cmocka_unit_test(test_saddle),
        cmocka_unit_test(test_field),
        cmocka_unit_test(test_shape_beside_field),
        cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_mirrored_front),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
