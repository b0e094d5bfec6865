/* SPDX-License-Identifier: MIT
 *
 * test_orbit.c - tests the camera: what fits the window, what stays under the pointer, and where
 * the near and far planes lie. Expected values follow from projecting points with the matrices.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include <math.h>

enum { WIDTH = 400, HEIGHT = 300 };
static const sphere ball = {{1e6, -2, 3}, 5};
/* The tolerance of positions, in heights of the window. Coordinates of 1e6 in double leave an error
 * of 1e-10 of the sphere's radius. */
static const double tolerance = 1e-8;

static psplat_view view_of(const orbit *o, int is_orthographic) {
    psplat_view view = {.width = WIDTH, .height = HEIGHT};
    orbit_view(o, &ball, is_orthographic, &view);
    return view;
}

static void transform(const double m[16], const double p[4], double out[4]) {
    for (int r = 0; r < 4; ++r)
        out[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r] * p[3];
}

/* Computes where a point is seen: in heights of the window from its middle, and in window depth. */
static void project(const psplat_view *view, const double p[3], double out[3]) {
    double eye[4], clip[4];
    transform(view->view, (double[4]){p[0], p[1], p[2], 1}, eye);
    transform(view->projection, eye, clip);
    out[0] = 0.5 * clip[0] / clip[3] * WIDTH / HEIGHT;
    out[1] = 0.5 * clip[1] / clip[3];
    out[2] = 0.5 + 0.5 * clip[2] / clip[3];
}

static orbit fitted(double azimuth, double elevation) {
    orbit o = {.azimuth = azimuth, .elevation = elevation};
    orbit_fit(&o, &ball, (double)WIDTH / HEIGHT);
    return o;
}

static void assert_near(double a, double b, double allowed) {
    if (fabs(a - b) <= allowed) return;
    print_error("%.12g is not %.12g\n", a, b);
    fail();
}

/* Computes points of the sphere's surface along the camera's axes and between them. */
static void surface_point(const orbit *o, int i, double out[3]) {
    static const double ways[][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},     {0, -1, 0},
                                     {0, 0, -1}, {0, 0, 1},  {.6, .64, .48}};
    double axes[3][3];
    orbit_axes(o, axes);
    for (int k = 0; k < 3; ++k) {
        out[k] = ball.center[k];
        for (int a = 0; a < 3; ++a) out[k] += ball.radius * ways[i][a] * axes[a][k];
    }
}

static void test_the_scene_fits_and_touches(void **state) {
    (void)state;
    for (int ortho = 0; ortho < 2; ++ortho)
        for (double elevation = -1.5; elevation < 1.6; elevation += 0.75) {
            orbit o = fitted(2.2, elevation);
            psplat_view view = view_of(&o, ortho);
            double highest = 0;
            for (int i = 0; i < 7; ++i) {
                double p[3], seen[3];
                surface_point(&o, i, p);
                project(&view, p, seen);
                assert_true(fabs(seen[0]) < 0.5 * WIDTH / HEIGHT && fabs(seen[1]) < 0.5);
                assert_true(seen[2] > 0 && seen[2] < 1);
                highest = fmax(highest, seen[1]);
            }
            /* The top is seen at 5 / (2 * 5 / cos 13.5 degrees); the tangent from the eye is
             * higher. */
            assert_near(highest, 0.5 * cos(27 * 3.14159265358979 / 360), tolerance);
        }
}

static void test_a_narrow_window_fits_the_width(void **state) {
    (void)state;
    orbit wide = {.azimuth = 1}, narrow = wide;
    orbit_fit(&wide, &ball, 2);
    orbit_fit(&narrow, &ball, 0.5);
    assert_true(narrow.distance > 1.8 * wide.distance);
}

static void test_turning_back_restores(void **state) {
    (void)state;
    orbit o = fitted(0.3, 0.2);
    double before[3] = {o.azimuth, o.elevation, o.distance};
    orbit_turn(&o, 0.125, -0.25);
    assert_near(o.azimuth, before[0] - 3.14159265358979 / 8, 1e-12);
    assert_near(o.elevation, before[1] + 3.14159265358979 / 4, 1e-12);
    orbit_turn(&o, -0.125, 0.25);
    assert_near(o.azimuth, before[0], 1e-12);
    assert_near(o.elevation, before[1], 1e-12);
    /* A full turn changes nothing; the camera does not turn over the poles. */
    orbit_turn(&o, 2, 0);
    assert_near(o.azimuth, before[0], 1e-12);
    orbit_turn(&o, 0, -7);
    assert_near(o.elevation, 3.14159265358979 / 2, 1e-12);
}

static void test_panning_keeps_the_target_under_the_pointer(void **state) {
    (void)state;
    for (int ortho = 0; ortho < 2; ++ortho) {
        orbit o = fitted(0.7, 0.4);
        double held[3] = {o.target[0], o.target[1], o.target[2]}, seen[3];
        orbit_pan(&o, 0.21, -0.34);
        psplat_view view = view_of(&o, ortho);
        project(&view, held, seen);
        assert_near(seen[0], 0.21, tolerance);
        assert_near(seen[1], -0.34, tolerance);
    }
}

static void test_zooming_keeps_what_is_under_the_pointer(void **state) {
    (void)state;
    for (int ortho = 0; ortho < 2; ++ortho) {
        orbit o = fitted(-2, 0.4), moved = o;
        orbit_pan(&moved, -0.3, 0.2); /* the new target is what o sees at (0.3, -0.2) */
        double distance = o.distance, seen[3];
        orbit_zoom(&o, 4, 0.3, -0.2);
        assert_near(o.distance, distance * pow(0.88, 4), 1e-9);
        psplat_view view = view_of(&o, ortho);
        project(&view, moved.target, seen);
        assert_near(seen[0], 0.3, tolerance);
        assert_near(seen[1], -0.2, tolerance);
    }
}

static void test_zooming_ends(void **state) {
    (void)state;
    orbit o = fitted(0, 0);
    orbit_zoom(&o, 1e4, 0, 0);
    assert_near(o.distance, 5e-3, 1e-12);
    orbit_zoom(&o, -1e4, 0, 0);
    assert_near(o.distance, 5e3, 1e-6);
}

/* From any distance the planes are such as GL and the renderer accept. */
static void test_planes_are_valid_from_anywhere(void **state) {
    (void)state;
    for (int ortho = 0; ortho < 2; ++ortho)
        for (double steps = -100; steps <= 100; steps += 10) {
            orbit o = fitted(1, 1);
            orbit_zoom(&o, steps, 0.4, 0.4);
            orbit_pan(&o, 0.4, 3);
            psplat_view view = view_of(&o, ortho);
            const double *p = view.projection;
            double near = ortho ? (p[14] + 1) / p[10] : p[14] / (p[10] - 1);
            double far = ortho ? (p[14] - 1) / p[10] : p[14] / (p[10] + 1);
            assert_true(isfinite(near) && isfinite(far));
            assert_true(near > 0 && far > near && far <= 1001 * near);
        }
}

static void test_aiming_undoes_projecting(void **state) {
    (void)state;
    for (int ortho = 0; ortho < 2; ++ortho) {
        orbit o = fitted(0.9, -0.3);
        psplat_view view = view_of(&o, ortho);
        double p[3], seen[3];
        surface_point(&o, 6, p);
        project(&view, p, seen);
        double distance = o.distance;
        orbit_aim(&o, &view, seen[0], seen[1], seen[2]);
        for (int i = 0; i < 3; ++i) assert_near(o.target[i], p[i], 1e-6); /* for a radius of 5 */
        assert_near(o.distance, distance, 0);
    }
}

int test_orbit_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_scene_fits_and_touches),
        cmocka_unit_test(test_a_narrow_window_fits_the_width),
        cmocka_unit_test(test_turning_back_restores),
        cmocka_unit_test(test_panning_keeps_the_target_under_the_pointer),
        cmocka_unit_test(test_zooming_keeps_what_is_under_the_pointer),
        cmocka_unit_test(test_zooming_ends),
        cmocka_unit_test(test_planes_are_valid_from_anywhere),
        cmocka_unit_test(test_aiming_undoes_projecting),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
