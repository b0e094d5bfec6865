/* SPDX-License-Identifier: MIT
 *
 * test_viewpoint.c - tests that the default camera sees a whole bounding box from every direction
 * and for every shape of picture. Expected values are normalised device coordinates of the corners
 * of the box, and the tangent cone of its bounding sphere.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "export/glb_writer.h"
#include "picture/viewpoint.h"
#include "scene_asset.h"
#include "splats/splats.h"

static void transform(const double m[16], const double in[4], double out[4]) {
    for (int row = 0; row < 4; ++row) {
        out[row] = 0;
        for (int column = 0; column < 4; ++column) out[row] += m[column * 4 + row] * in[column];
    }
}

/* Stores the normalised device coordinates of a point of the scene. */
static void project(const psplat_view *view, const double point[3], double ndc[3]) {
    double in[4] = {point[0], point[1], point[2], 1}, eye[4], clip[4];
    transform(view->view, in, eye);
    transform(view->projection, eye, clip);
    for (int i = 0; i < 3; ++i) ndc[i] = clip[i] / clip[3];
}

static void assert_box_inside(const psplat_view *view, const double min[3], const double max[3]) {
    for (int corner = 0; corner < 8; ++corner) {
        double point[3], ndc[3];
        for (int i = 0; i < 3; ++i) point[i] = corner >> i & 1 ? max[i] : min[i];
        project(view, point, ndc);
        for (int i = 0; i < 3; ++i) assert_true(fabs(ndc[i]) < 1);
    }
}

static void fit(const psplat_viewpoint *at, const double min[3], const double max[3],
                psplat_view *view) {
    double center[3], square = 0;
    for (int i = 0; i < 3; ++i) {
        center[i] = (min[i] + max[i]) / 2;
        square += (max[i] - min[i]) * (max[i] - min[i]) / 4;
    }
    psplat_viewpoint_fit(at, center, sqrt(square), view);
}

static void test_box_is_seen_from_everywhere(void **state) {
    (void)state;
    const double boxes[][2][3] = {{{-1, -1, -1}, {1, 1, 1}},
                                  {{1e6, 0, 0}, {1e6 + 1, 2, 3}},
                                  {{0, 0, 0}, {1e-6, 1e-6, 0}},
                                  {{-1, -1, 5}, {100, -0.5, 5}}};
    const int sizes[][2] = {{640, 480}, {480, 640}, {1000, 10}, {64, 64}};
    for (size_t b = 0; b < 4; ++b)
        for (size_t s = 0; s < 4; ++s)
            for (int azimuth = -180; azimuth <= 180; azimuth += 45)
                for (int elevation = -90; elevation <= 90; elevation += 30) {
                    psplat_view view = {.width = sizes[s][0], .height = sizes[s][1]};
                    psplat_viewpoint at = {.azimuth_degrees = azimuth,
                                           .elevation_degrees = elevation};
                    fit(&at, boxes[b][0], boxes[b][1], &view);
                    assert_box_inside(&view, boxes[b][0], boxes[b][1]);
                }
}

static void test_sphere_touches_the_shorter_side(void **state) {
    (void)state;
    const double min[3] = {-1, -1, -1}, max[3] = {1, 1, 1};
    const int sizes[][2] = {{640, 480}, {480, 640}};
    for (size_t s = 0; s < 2; ++s) {
        psplat_view view = {.width = sizes[s][0], .height = sizes[s][1]};
        psplat_viewpoint at = {0};
        fit(&at, min, max, &view);
        /* The silhouette of a sphere of radius r at distance d is a cone with half angle asin(r /
         * d), which must be half the angle of view along the shorter side. */
        int shorter = view.width < view.height ? 0 : 5;
        double distance = -view.view[14];
        assert_true(fabs(tan(asin(sqrt(3) / distance)) * view.projection[shorter] - 1) < 1e-12);
    }
}

static void test_directions(void **state) {
    (void)state;
    const double min[3] = {-1, -1, -1}, max[3] = {1, 1, 1}, right[3] = {1, 0, 0}, up[3] = {0, 1, 0},
                 front[3] = {0, 0, 1};
    double ndc[3];
    psplat_view view = {.width = 64, .height = 64};
    fit(&(psplat_viewpoint){0}, min, max, &view);
    project(&view, right, ndc);
    assert_true(ndc[0] > 0.1 && fabs(ndc[1]) < 1e-12); /* seen from +z, +x is on the right */
    project(&view, up, ndc);
    assert_true(ndc[1] > 0.1 && fabs(ndc[0]) < 1e-12); /* +y is up */
    fit(&(psplat_viewpoint){.azimuth_degrees = 90}, min, max, &view);
    project(&view, front, ndc);
    assert_true(ndc[0] < -0.1); /* seen from +x, +z is on the left */
    fit(&(psplat_viewpoint){.elevation_degrees = 90}, min, max, &view);
    project(&view, front, ndc);
    assert_true(ndc[1] < -0.1 && fabs(ndc[0]) < 1e-12); /* seen from above, the front is below */
}

static void test_near_plane_stays_in_front_of_the_eye(void **state) {
    (void)state;
    const double min[3] = {-1, -1, -1}, max[3] = {1, 1, 1};
    const double distances[] = {1e-3, 0.1, 0.25, 1, 1000};
    for (size_t i = 0; i < 5; ++i) {
        psplat_view view = {.width = 64, .height = 64};
        fit(&(psplat_viewpoint){.distance = distances[i]}, min, max, &view);
        /* near and far planes, from m[10] and m[14] of a perspective matrix */
        double near = view.projection[14] / (view.projection[10] - 1);
        double far = view.projection[14] / (view.projection[10] + 1);
        assert_true(near > 0);
        assert_true(far > near && far / near < 1001);
    }
}

/* Lines keep 0 <= x <= 1 of an ellipse and x >= 1 of a disc, so that the sphere must be smaller
 * than that of the box around both without lines. */
static void test_sphere_leaves_out_what_is_clipped(void **state) {
    (void)state;
    psplat_splat splats[2] = {
        {.center = {0, 0, 0}, .rotation = {0, 0, 0, 1}, .radius = {4, 1}, .normal = {0, 0, 1}},
        {.center = {1, 0, 0}, .rotation = {0, 0, 0, 1}, .radius = {1, 1}, .normal = {0, 0, 1}}};
    const float line[3] = {-1, 0, 0.25f}; /* keeps x <= 1 of the first splat */
    memcpy(splats[0].clip[0], line, sizeof line);
    const float other[3] = {1, 0, 0}; /* keeps x >= 0 of the first splat */
    memcpy(splats[0].clip[1], other, sizeof other);
    for (int i = 0; i < 2; ++i) splats[i].clip_count = 2;
    memcpy(splats[1].clip[0], other, sizeof other); /* keeps x >= 1 of the second splat */
    memcpy(splats[1].clip[1], other, sizeof other);
    psplat_run run = {.count = 2, .clip_lines = 2};
    psplat_material material = {.base_color = {1, 1, 1, 1}, .metallic = 1, .roughness = 1};
    psplat_splats set = {.splats = splats,
                         .count = 2,
                         .runs = &run,
                         .run_count = 1,
                         .materials = &material,
                         .material_count = 1};
    set.kernel = (psplat_kernel){2, 2};
    set.origin[1] = 100;
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_asset *asset = NULL;
    assert_int_equal(psplat_glb_write(&set, NULL, NULL, &data, &size, NULL), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, NULL), PSPLAT_OK);
    double center[3], radius = 0;
    psplat_viewpoint_sphere(asset, center, &radius);
    /* The sphere encloses x 0 ... 2 and y 99 ... 101. The outline with 16 sides reaches 2 % beyond
     * a circle; the farthest corners are those of the first splat at (0, +-1). */
    assert_true(fabs(center[0] - 1) < 0.02 && fabs(center[1] - 100) < 1e-6);
    assert_true(radius > sqrt(2) - 0.02 && radius < 1.03 * sqrt(2));
    psplat_asset_destroy(asset);
    free(data);
}

/* Makes a scene of one splat of radii 2 and 1 that is bent to a dome along u and to a bowl along v,
 * and that bent lines keep the middle of where line_count is 2. */
static scene bent_scene(uint32_t line_count) {
    scene s = scene_blank(1);
    psplat_splat *splat = &s.splats[0];
    splat->radius[0] = 2;
    splat->gradient[0] = 1.2f, splat->gradient[1] = -0.8f, splat->gradient[2] = 0.3f;
    splat->clip_count = line_count;
    for (uint32_t i = 0; i < line_count; ++i) {
        splat->clip[i][0] = i ? -1 : 1;
        splat->clip[i][2] = i ? 0.1f : 0.2f;
        splat->bend[i] = i ? 0.6f : -0.5f;
    }
    scene_curve(&s);
    return s;
}

/* Stores the point of the splat of bent_scene at (u, v): its axes are x, y and z. */
static void bent_point(double u, double v, double p[3]) {
    p[0] = 2 * u, p[1] = v, p[2] = -(1.2 * u * u / 2 + 0.3 * u * v / 2 - 0.8 * v * v / 4) * 2;
}

/* The sphere encloses all of a curved surface that bent lines leave, and little more. */
static void test_sphere_holds_curved_splats(void **state) {
    (void)state;
    for (uint32_t lines = 0; lines < 3; lines += 2) {
        scene s = bent_scene(lines);
        psplat_asset *asset = scene_open(&s);
        double center[3], radius = 0, farthest = 0;
        psplat_viewpoint_sphere(asset, center, &radius);
        for (int i = 0; i < 200 * 200; ++i) {
            double u = i % 200 / 99.5 - 1, v = i / 200 / 99.5 - 1, p[3], square = 0;
            if (u * u + v * v > 1) continue;
            if (lines && (u + 0.2 - 0.25 * v * v < 0 || -u + 0.1 + 0.3 * v * v < 0)) continue;
            bent_point(u, v, p);
            for (int k = 0; k < 3; ++k) square += (p[k] - center[k]) * (p[k] - center[k]);
            farthest = fmax(farthest, sqrt(square));
        }
        assert_true(farthest <= radius);
        /* The outline with 16 sides reaches 2 % beyond the circle, where the surface is steep. A
         * straight line stands for each bent one. */
        assert_true(radius < farthest * (lines ? 1.2 : 1.04));
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
}

/* A line that bulges in keeps x <= y^2 of a disc, and others keep -1/4 <= x and |y| <= 2/5 + x / 2:
 * the box ends where x = (2/5 + x / 2)^2, far within the points in which the first one meets the
 * circle, and the middle of the sphere is not 0. */
static void test_sphere_of_a_notch(void **state) {
    (void)state;
    static const float lines[4][3] = {{-1, 0, 0}, {1, 0, 0.25f}, {0.5f, 1, 0.4f}, {0.5f, -1, 0.4f}};
    scene s = scene_disc(1);
    s.splats[0].clip_count = 4;
    memcpy(s.splats[0].clip, lines, sizeof lines);
    s.splats[0].bend[0] = 2;
    psplat_asset *asset = scene_open(&s);
    double center[3], radius = 0;
    psplat_viewpoint_sphere(asset, center, &radius);
    double end = (0.6 - sqrt(0.2)) / 0.5, middle = (end - 0.25) / 2; /* a file has floats */
    for (int k = 0; k < 3; ++k) assert_true(fabs(center[k] - (k ? 0 : middle)) < 1e-6);
    assert_true(fabs(radius - hypot(end - middle, 0.4 + end / 2)) < 1e-6);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_light_comes_from_the_camera_s_side(void **state) {
    (void)state;
    const double min[3] = {-1, -1, -1}, max[3] = {1, 1, 1};
    psplat_view view = {.width = 64, .height = 64};
    psplat_viewpoint at = {.azimuth_degrees = 200, .elevation_degrees = -35};
    fit(&at, min, max, &view);
    double direction[4] = {-view.lights[0].direction[0], -view.lights[0].direction[1],
                           -view.lights[0].direction[2], 0};
    double eye[4];
    transform(view.view, direction, eye);
    assert_true(eye[2] > 0 && eye[1] > 0 && eye[0] < 0);
}

/* A point that falls on a pixel of the whole picture falls on the same pixel of the crop. */
static void test_crop(void **state) {
    (void)state;
    const double center[3] = {3, 4, 5}, point[3] = {3.2, 3.7, 5.1};
    const psplat_viewpoint at = {.azimuth_degrees = 35, .elevation_degrees = 15};
    psplat_view whole = {.width = 640, .height = 480};
    psplat_viewpoint_fit(&at, center, 1, &whole);
    psplat_view part = whole;
    psplat_viewpoint_crop(&part, 300, 100, 200, 150);
    assert_int_equal(part.width, 200);
    assert_int_equal(part.height, 150);
    double a[3], b[3];
    project(&whole, point, a);
    project(&part, point, b);
    /* in pixels, computed in double */
    assert_true(fabs((a[0] + 1) * 320 - 300 - (b[0] + 1) * 100) < 1e-9);
    assert_true(fabs((a[1] + 1) * 240 - 100 - (b[1] + 1) * 75) < 1e-9);
    assert_true(fabs(a[2] - b[2]) < 1e-12);
}

int test_viewpoint_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_box_is_seen_from_everywhere),
        cmocka_unit_test(test_sphere_touches_the_shorter_side),
        cmocka_unit_test(test_directions),
        cmocka_unit_test(test_near_plane_stays_in_front_of_the_eye),
        cmocka_unit_test(test_sphere_leaves_out_what_is_clipped),
        cmocka_unit_test(test_sphere_holds_curved_splats),
        cmocka_unit_test(test_sphere_of_a_notch),
        cmocka_unit_test(test_light_comes_from_the_camera_s_side),
        cmocka_unit_test(test_crop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
