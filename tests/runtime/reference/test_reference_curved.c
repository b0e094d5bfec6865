/* SPDX-License-Identifier: MIT
 *
 * test_reference_curved.c - tests curved splats and bent clip lines of the reference rasteriser
 * against closed forms (spec 3.4, 3.6, 4, 5.1 to 5.3).
 *
 * Where the axes are x, y, z, the surface is z = -(p X + q Y + (A X^2 + 2 B X Y + C Y^2) / 2) in
 * lengths, and the ray of pixel (x, y) is (s dx, s dy, 5 - s): it meets the surface where
 *
 *     k s^2 / 2 - m s + 5 = 0,    k = A dx^2 + 2 B dx dy + C dy^2,    m = 1 - p dx - q dy
 *
 * and its height above the surface falls by m - k s, so that s = 10 / (m + sqrt(m^2 - 10 k)) is the
 * front.
 */
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"

#define WIDTH 120
#define HEIGHT 90
#define FOCAL 100.0
#define DISTANCE 5.0
#define NEAR 0.5
#define FAR 20.0

/* The tolerance for some ten sums and products of numbers near 1 in double, 1e-15 each, with a
 * margin. */
#define ROUNDING 1e-12
/* Slopes of surfaces that stem from normals are rounded to floats, where they are at most 2. */
#define FLOAT_STEP 2.5e-7

static psplat_view front_view(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    camera_perspective(&view, FOCAL, NEAR, FAR);
    return view;
}

static double ray_x(int x) {
    return (x + 0.5 - WIDTH / 2.0) / FOCAL;
}

static double ray_y(int y) {
    return (y + 0.5 - HEIGHT / 2.0) / FOCAL;
}

static double depth_of(double s) {
    return 0.5 + 0.5 * ((FAR + NEAR) / (FAR - NEAR) - 2 * FAR * NEAR / ((FAR - NEAR) * s));
}

/* Returns one splat at the origin whose surface has its own alpha, beta and gamma. The normal field
 * stays constant. */
static scene shaped(double radius_u, double radius_v, double alpha, double beta, double gamma) {
    scene s = scene_blank(1);
    psplat_splat *splat = &s.splats[0];
    splat->radius[0] = (float)radius_u, splat->radius[1] = (float)radius_v;
    splat->shape[2] = (float)alpha, splat->shape[3] = (float)beta, splat->shape[4] = (float)gamma;
    return s;
}

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

/* ---- a surface before the camera ------------------------------------------------------------- */

/* The coefficients of the file's comment, and the radii. */
typedef struct surface {
    double p, q, a, b, c, radius_u, radius_v;
} surface;

static surface surface_of(const psplat_splat *splat) {
    double u = splat->radius[0], v = splat->radius[1];
    return (surface){.p = splat->shape[0],
                     .q = splat->shape[1],
                     .a = (double)splat->shape[2] / u,
                     .b = (double)splat->shape[4] / u,
                     .c = (double)splat->shape[3] / v,
                     .radius_u = u,
                     .radius_v = v};
}

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

/* ---- from the side --------------------------------------------------------------------------- */

#define SIDE 81
#define HALF 1.0

/* Looks along -x in a parallel view: the image's x is -z and its y is y, both from -HALF. */
static psplat_view side_view(void) {
    psplat_view view = camera_view(SIDE, SIDE);
    camera_look(&view, (double[]){DISTANCE, 0, 0}, (double[]){0, 0, 0});
    camera_parallel(&view, HALF, 1, 10);
    view.shading = PSPLAT_SHADING_NORMAL;
    return view;
}

static double side_of(int i) {
    return (i + 0.5) * 2 * HALF / SIDE - HALF;
}

/* The surface z = -k (X^2 + Y^2) / 2 is seen from the side: the ray (y, z) meets it at X = +-root
 * with root^2 = -2 z / k - y^2. Asserts that the picture shows it at X = sign root, and its
 * constant normal z, times turned. The first row of the image's coordinates is z, which camera_look
 * makes the image's -x. Before it meets the back of a hill a ray has been k root^2 / 2 under the
 * surface: up to two depth tolerances the normal is not turned. */
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

/* ---- bent clip lines ------------------------------------------------------------------------- */

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

/* A hill or bowl z = height - k ((X - 0.25)^2 + Y^2) / 2 of radius 0.5 stands over the floor z = 0.
 * On the way (x, y, 0) + s l to the light, the greater root with which it is inside the ellipse is
 * the point that the light sees. Returns 1 where it lies farther than epsilon over its cosine. */
static int is_dark(const double l[3], double x, double y, double height, double k, double epsilon) {
    double a = k * (l[0] * l[0] + l[1] * l[1]) / 2;
    double b = l[2] + k * ((x - 0.25) * l[0] + y * l[1]);
    double c = k * ((x - 0.25) * (x - 0.25) + y * y) / 2 - height;
    double root = sqrt(b * b - 4 * a * c), seen = 0, cosine = 1;
    for (int i = 0; i < 2; ++i) {
        double s = a == 0 ? -c / b : (-b + (i ? root : -root)) / (2 * a);
        double u = x + s * l[0] - 0.25, v = y + s * l[1];
        if (!(s > seen && hypot(u, v) <= 0.5)) continue;
        double slope[2] = {k * u, k * v};
        seen = s;
        cosine = fabs(l[2] + slope[0] * l[0] + slope[1] * l[1]) /
                 sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
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
        check_shadow(lights[i], 3, 0.9);
        check_shadow(lights[i], 5.5, 0.7);
        check_shadow(lights[i], -5.5, 1.2);
    }
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
        cmocka_unit_test(test_two_roots),
        cmocka_unit_test(test_second_root),
        cmocka_unit_test(test_second_root_by_depth),
        cmocka_unit_test(test_contour_ties),
        cmocka_unit_test(test_contour_distance),
        cmocka_unit_test(test_far_eye),
        cmocka_unit_test(test_linear),
        cmocka_unit_test(test_eye_in_bowl),
        cmocka_unit_test(test_ring),
        cmocka_unit_test(test_back),
        cmocka_unit_test(test_bent_lines),
        cmocka_unit_test(test_bent_ties),
        cmocka_unit_test(test_tolerance),
        cmocka_unit_test(test_flat_among_curved),
        cmocka_unit_test(test_shadows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
