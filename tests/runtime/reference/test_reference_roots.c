/* SPDX-License-Identifier: MIT
 *
 * test_reference_roots.c - tests which of the two points at which a ray meets a curved splat the
 * reference rasteriser shows, from aside, from inside and from behind, and how near to a tie its
 * pixels are (spec 5.1 to 5.3).
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "curved_fixture.h"

/* Returns one whose surface has the slopes x and y at its centre, and the shape of its field. */
static scene sloping(double x, double y) {
    scene s = shaped(1.25, 1, 0, 0, 0);
    const float gradient[3] = {2.7f, 2.7f, 0.25f};
    memcpy(s.splats[0].gradient, gradient, sizeof gradient);
    for (int i = 0; i < 3; ++i)
        s.splats[0].normal[i] = (float)((double[]){x, y, 1}[i] / sqrt(1 + x * x + y * y));
    scene_curve(&s);
    return s;
}

/* The surface z = -k (X^2 + Y^2) / 2 is seen from the side: the ray (y, z) meets it at X = +-root
 * with root^2 = -2 z / k - y^2. Asserts that the picture shows it at X = sign root, and its
 * constant normal z, times turned. The first row of the image's coordinates is z, which camera_look
 * makes the image's -x. Before it meets the back of a hill a ray has been k root^2 / 2 under the
 * surface: up to two depth tolerances the normal is mirrored along the ray, which leaves its z. */
static void check_side(const picture *p, double k, double sign, double turned) {
    size_t covered = 0, peeking = 0;
    double least = k > 0 && turned < 0 ? 4 * (double)0.01f / k : 0;
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            int at = y * SIDE + x;
            double z = -side_of(x), square = -2 * z / k - side_of(y) * side_of(y);
            int inside = square > 0 && -2 * z / k <= 1;
            if (p->image.tie[at] < 1e-9) continue;
            assert_int_equal(p->image.count[at], inside);
            if (!inside) continue;
            assert_near(p->image.uv[2 * at], sign * sqrt(square), 1e-12 / sqrt(square));
            assert_near(p->image.uv[2 * at + 1], side_of(y), ROUNDING);
            assert_near(p->image.depth[at], (DISTANCE - sign * sqrt(square) - 1) / 9,
                        1e-12 / sqrt(square));
            double shown = square > least ? turned : 1;
            assert_near((double)p->image.color[4 * at], 0.5 - 0.5 * shown, FLOAT_STEP);
            peeking += square <= least;
            ++covered;
        }
    assert_true(covered > 500 && (peeking > 50) == (least > 0));
}

/* Both points of a ray are inside the ellipse. A hill shows its near side, which is its front; a
 * bowl shows the inside of its far wall, or where the material is double-sided the outside of its
 * near wall, which is its back. There the normal is negated, however little it turns away. */
static void test_two_roots(void **state) {
    (void)state;
    const double k = 1.5;
    for (int is_bowl = 0; is_bowl < 2; ++is_bowl)
        for (int both = 0; both < 2; ++both) {
            double bend = is_bowl ? -k : k;
            scene s = shaped(1, 1, bend, bend, 0);
            s.material.double_sided = both;
            psplat_view view = side_view();
            picture p = picture_of(&s, NULL, &view);
            check_side(&p, bend, is_bowl && !both ? -1 : 1, is_bowl && both ? -1 : 1);
            picture_free(&p);
            scene_free(&s);
        }
}

/* A clip line takes the nearer point away, and the farther one is seen: of a double-sided hill it
 * is the back. Where the material is single-sided nothing is left. */
static void test_second_root(void **state) {
    (void)state;
    const double k = 1.5;
    for (int both = 0; both < 2; ++both) {
        scene s = shaped(1, 1, k, k, 0);
        s.material.double_sided = both;
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = -1;
        psplat_view view = side_view();
        picture p = picture_of(&s, NULL, &view);
        if (both) check_side(&p, k, -1, -1);
        for (int i = 0; !both && i < SIDE * SIDE; ++i)
            if (p.image.tie[i] >= 1e-9) assert_int_equal(p.image.count[i], 0);
        picture_free(&p);
        scene_free(&s);
    }
}

/* Behind its contour a hill peeks out by up to two depth tolerances. There it has the light of its
 * front, whose normal is that of its back but for the part along the ray: a line takes the front
 * away. Deeper the normal of the back is negated. A field of its own that faces the eye there,
 * since it bends the other way, stays as it is. Normals are of eye space, whose axes are -z, y and
 * x. */
static void test_mirrored(void **state) {
    (void)state;
    const double k = 1.5, least = 4 * (double)0.01f / k;
    size_t peeking = 0, deep = 0;
    for (int is_other = 0; is_other < 2; ++is_other) {
        const double g = is_other ? -k : k;
        scene s = shaped(1, 1, k, k, 0);
        s.material.double_sided = 1;
        s.splats[0].gradient[0] = s.splats[0].gradient[1] = (float)g;
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = -1;
        psplat_view view = side_view();
        picture p = picture_of(&s, NULL, &view);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double z = -side_of(i % SIDE), y = side_of(i / SIDE), square = -2 * z / k - y * y;
            if (p.image.tie[i] < 1e-9 || !p.image.count[i]) continue;
            int peeks = square <= least;
            double x = peeks ? k * sqrt(square) : g * sqrt(square), turned = peeks ? 1 : -1;
            double n[3] = {-turned, turned * g * y, x}, length = sqrt(1 + g * g * y * y + x * x);
            for (int c = 0; c < 3; ++c)
                assert_near((double)p.image.color[4 * i + c], 0.5 + 0.5 * n[c] / length,
                            FLOAT_STEP);
            peeking += (size_t)peeks;
            deep += (size_t)!peeks;
        }
        picture_free(&p);
        scene_free(&s);
    }
    assert_true(peeking > 100 && deep > 500);
}

/* The near plane takes the nearer point away just as well. */
static void test_second_root_by_depth(void **state) {
    (void)state;
    const double k = 1.5;
    scene s = shaped(1, 1, k, k, 0);
    s.material.double_sided = 1;
    psplat_view view = side_view();
    camera_parallel(&view, HALF, DISTANCE, 10);
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < SIDE * SIDE; ++i)
        if (p.image.count[i] && p.image.tie[i] >= 1e-9) assert_true(p.image.uv[2 * i] < 0);
    assert_true(picture_covered(&p) > 500);
    picture_free(&p);
    scene_free(&s);
}

/* The ray of the image's middle touches the hill's top: nothing is undefined, and the tie is 0. To
 * first order the tie of every pixel near the contour g = -2 z / k - y^2 = 0 is its distance
 * |g| / |grad g| in pixels. */
static void test_contour_ties(void **state) {
    (void)state;
    const double k = 1.5, pixel = 2 * HALF / SIDE;
    size_t near = 0, missed = 0;
    for (int both = 0; both < 2; ++both) {
        scene s = shaped(1, 1, k, k, 0);
        s.material.double_sided = both;
        psplat_view view = side_view();
        picture p = picture_of(&s, NULL, &view);
        assert_near(p.image.tie[SIDE / 2 * SIDE + SIDE / 2], 0, 1e-9);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double z = -side_of(i % SIDE), y = side_of(i / SIDE), g = -2 * z / k - y * y;
            double distance = fabs(g) / hypot(2 / k, 2 * y) / pixel;
            double tie = p.image.tie[i];
            assert_true(tie >= 0 && tie <= 1 && isfinite(p.image.depth[i]));
            if (distance < 1 && z < 0.01 && z > -0.7) {
                assert_true(tie <= 1.05 * distance);
                ++near;
                missed += g < 0;
            } else if (distance > 3 && (g < 0 || z > -0.7)) {
                assert_true(tie > 0.03); /* the rim is at z = -0.75, 0.034 of the radius off */
            }
        }
        picture_free(&p);
        scene_free(&s);
    }
    assert_true(near > 200 && missed > 50);
}

/* Returns the tie of the one ray (dx, dy, -1) from the height 1 over a splat, in a view of the
 * given focal length. */
static double tie_of(const scene *s, double dx, double dy, double focal) {
    psplat_view view = camera_view(3, 3);
    camera_look(&view, (double[]){0, 0, 1}, (double[]){0, 0, 0});
    camera_perspective(&view, focal, 0.01, FAR);
    view.projection[8] = dx * view.projection[0]; /* moves it to the middle pixel */
    view.projection[9] = dy * view.projection[5];
    picture p = picture_of(s, NULL, &view);
    assert_int_equal(p.image.count[4], 0);
    double tie = p.image.tie[4];
    picture_free(&p);
    return tie;
}

/* The tie of a ray that misses the surface is D = m^2 - 2 k (from the height 1) over the squares of
 * the ray's length and of the gradient's where the ray is nearest, s = m / k, or D over its own
 * change with a pixel. In a small image the second is the less, and the distance to the contour; in
 * a large one it is the first. A clip line that takes the nearest point away takes the tie along.
 */
static void test_contour_distance(void **state) {
    (void)state;
    const double rays[][2] = {{0.52, 0.05}, {-0.35, 0.4}, {0.1, -0.5}, {-0.48, -0.25}};
    const double focals[] = {0.3, 100};
    size_t in_pixels = 0;
    for (int i = 0; i < 16; ++i) {
        double dx = rays[i / 2 % 4][0], dy = rays[i / 2 % 4][1], focal = focals[i % 2];
        scene s = i < 8 ? shaped(1.25, 1, 2.7, 2.7, 0.25) : sloping(0.05, -0.04);
        surface f = surface_of(&s.splats[0]);
        double k = f.a * dx * dx + 2 * f.b * dx * dy + f.c * dy * dy, m = 1 - f.p * dx - f.q * dy;
        double x = m * dx / k, y = m * dy / k, d = m * m - 2 * k;
        double n[2] = {f.p + f.a * x + f.b * y, f.q + f.b * x + f.c * y};
        double unit = (n[0] * n[0] + n[1] * n[1] + 1) * (dx * dx + dy * dy + 1);
        double change = hypot(2 * m * f.p + 4 * (f.a * dx + f.b * dy),
                              2 * m * f.q + 4 * (f.b * dx + f.c * dy)) /
                        focal;
        assert_true(d < 0 && hypot(x / f.radius_u, y / f.radius_v) < 0.95);
        assert_near(tie_of(&s, dx, dy, focal), -d / fmax(unit, change), FLOAT_STEP);
        in_pixels += change > unit;
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = (float)-dx, s.splats[0].clip[0][1] = (float)-dy;
        assert_true(tie_of(&s, dx, dy, focal) > 0.3); /* the distance to the line */
        scene_free(&s);
    }
    assert_int_equal(in_pixels, 8);
}

/* How far away the eye is changes nothing in a parallel view but what rounding does to the eye's
 * coordinates: 1e-10 of 1e6. */
static void test_far_eye(void **state) {
    (void)state;
    scene s = shaped(1, 0.75, 1.5, 1, 0.5);
    picture p[2];
    for (int i = 0; i < 2; ++i) {
        const double eye = i ? 1e6 : 5;
        psplat_view view = side_view();
        camera_look(&view, (double[]){eye, eye, eye}, (double[]){0, 0, 0});
        camera_parallel(&view, HALF, 1, 3 * eye);
        p[i] = picture_of(&s, NULL, &view);
    }
    assert_true(picture_covered(&p[0]) > 500);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (p[0].image.tie[i] < 1e-4) continue;
        assert_int_equal(p[0].image.count[i], p[1].image.count[i]);
        assert_near(p[0].image.uv[2 * i], p[1].image.uv[2 * i], 1e-7);
    }
    picture_free(&p[0]);
    picture_free(&p[1]);
    scene_free(&s);
}

/* Rays along a cylinder meet it nowhere, and rays along the axis of a paraboloid once: F is linear
 * in both, and a plane seen edge-on is met nowhere. */
static void test_linear(void **state) {
    (void)state;
    psplat_view view = side_view();
    scene along = shaped(1, 1, 0, 1.5, 0);
    along.material.double_sided = 1;
    picture p = picture_of(&along, NULL, &view);
    for (int i = 0; i < SIDE * SIDE; ++i)
        assert_true(isfinite(p.image.depth[i]) && p.image.tie[i] >= 0);
    assert_int_equal(picture_covered(&p), 0);
    picture_free(&p);
    scene_free(&along);
    for (int both = 0; both < 2; ++both) {
        scene s = shaped(0.75, 0.5, 1.5, -1, 0.5);
        s.material.double_sided = both;
        camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
        p = picture_of(&s, NULL, &view);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double u = side_of(i % SIDE) / 0.75, v = side_of(i / SIDE) / 0.5, q = 0.5 / 0.75;
            double h = -0.75 * (0.75 * u * u + 0.5 * q * u * v - 0.5 * q * v * v);
            if (p.image.tie[i] < 1e-9) continue;
            assert_int_equal(p.image.count[i], u * u + v * v <= 1);
            if (!p.image.count[i]) continue;
            assert_near(p.image.uv[2 * i], u, ROUNDING);
            assert_near(p.image.depth[i], (DISTANCE - h - 1) / 9, ROUNDING);
        }
        assert_true(picture_covered(&p) > 1000);
        picture_free(&p);
        scene_free(&s);
    }
}

/* ---- from inside and behind ------------------------------------------------------------------ */

/* The eye is in the bowl z = k (X^2 + Y^2) / 2 at the height 1 and looks along x. A ray (s, s dy, 1
 * + s dz) meets the wall ahead where k (1 + dy^2) s^2 / 2 - dz s - 1 = 0; the other root is behind
 * the eye. camera_look makes the image's x the scene's z. */
static void test_eye_in_bowl(void **state) {
    (void)state;
    const double k = 2.75, near = 0.1, far = 10;
    for (int both = 0; both < 2; ++both) {
        scene s = shaped(1, 1, -k, -k, 0);
        s.material.double_sided = both;
        psplat_view view = camera_view(WIDTH, HEIGHT);
        camera_look(&view, (double[]){0, 0, 1}, (double[]){1, 0, 1});
        camera_perspective(&view, FOCAL, near, far);
        picture p = picture_of(&s, NULL, &view);
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x) {
                int at = y * WIDTH + x;
                double dy = ray_y(y), dz = ray_x(x), square = k * (1 + dy * dy);
                double ahead = (dz + sqrt(dz * dz + 2 * square)) / square;
                int inside = ahead * ahead * (1 + dy * dy) <= 1;
                if (p.image.tie[at] < 1e-9) continue;
                assert_int_equal(p.image.count[at], inside);
                if (!inside) continue;
                assert_near(p.image.uv[2 * at], ahead, ROUNDING);
                assert_near(p.image.uv[2 * at + 1], ahead * dy, ROUNDING);
            }
        assert_true(picture_covered(&p) > 5000);
        picture_free(&p);
        scene_free(&s);
    }
}

/* The eye is in the bowl, and looks down its axis from the height 1.2. The near plane is under the
 * bowl's rim and the far plane over its bottom, so that a ring of its wall is seen. */
static void test_ring(void **state) {
    (void)state;
    const double k = 2.75, eye = 1.2, near = 0.1, far = 0.7;
    scene s = shaped(1, 1, -k, -k, 0);
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, eye}, (double[]){0, 0, 0});
    camera_perspective(&view, 20, near, far);
    picture p = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            int at = y * WIDTH + x;
            double square = (ray_x(x) * ray_x(x) + ray_y(y) * ray_y(y)) * 25 * k;
            double down = (-1 + sqrt(1 + 2 * eye * square)) / square;
            int inside = down >= near && down <= far && down * sqrt(square / k) <= 1;
            if (p.image.tie[at] < 1e-9 || p.image.depth_tie[at] < 1e-9) continue;
            assert_int_equal(p.image.count[at], inside);
            if (inside) assert_near(p.image.uv[2 * at], down * ray_x(x) * 5, ROUNDING);
        }
    assert_true(picture_covered(&p) > 1000);
    picture_free(&p);
    scene_free(&s);
}

/* From below only the back is met: it is culled, or its normals are negated, also where the eye is
 * in the hollow of a hill. */
static void test_back(void **state) {
    (void)state;
    const double eyes[] = {-DISTANCE, -2.0};
    for (int i = 0; i < 4; ++i) {
        int both = i % 2;
        scene s = shaped(1, 1, 1.5, 1.5, 0);
        s.material.double_sided = both;
        psplat_view view = front_view();
        view.shading = PSPLAT_SHADING_NORMAL;
        camera_look(&view, (double[]){0, 0, eyes[i / 2]}, (double[]){0, 0, 0});
        picture p = picture_of(&s, NULL, &view);
        assert_true(both ? picture_covered(&p) > 300 : picture_covered(&p) == 0);
        for (int k = 0; k < WIDTH * HEIGHT; ++k)
            if (p.image.count[k])
                assert_near((double)p.image.color[4 * k + 2], 1, FLOAT_STEP); /* towards the eye */
        picture_free(&p);
        scene_free(&s);
    }
}

int test_reference_roots_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_roots),    cmocka_unit_test(test_second_root),
        cmocka_unit_test(test_mirrored),     cmocka_unit_test(test_second_root_by_depth),
        cmocka_unit_test(test_contour_ties), cmocka_unit_test(test_contour_distance),
        cmocka_unit_test(test_far_eye),      cmocka_unit_test(test_linear),
        cmocka_unit_test(test_eye_in_bowl),  cmocka_unit_test(test_ring),
        cmocka_unit_test(test_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
