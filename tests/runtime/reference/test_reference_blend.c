/* SPDX-License-Identifier: MIT
 *
 * test_reference_blend.c - tests the reference rasteriser against closed forms: visibility,
 * blending and modes (spec 5.3 to 5.7), on one or two discs and on spheres of splats. Unlit
 * materials make colours readable: L = B.
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

#define WIDTH 64
#define HEIGHT 48
#define FOCAL 100.0
#define DISTANCE 5.0
#define FLOAT_STEP 1.2e-7 /* colours are returned as floats, which are at most 1 here */

static psplat_view front_view(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    camera_perspective(&view, FOCAL, 1, 10);
    return view;
}

static double ray_x(int x) {
    return (x + 0.5 - WIDTH / 2.0) / FOCAL;
}

static double ray_y(int y) {
    return (y + 0.5 - HEIGHT / 2.0) / FOCAL;
}

/* ---- two discs of radius 1: red at z = 0, green at x = 0.5 and z = -gap -------------------- */

static scene two_discs(double gap, double epsilon) {
    scene s = scene_blank(2);
    s.material.unlit = 1;
    s.has_color = 1;
    s.depth_tolerance = (float)epsilon;
    s.splats[1].center[0] = 0.5f;
    s.splats[1].center[2] = (float)-gap;
    for (int i = 0; i < 2; ++i)
        for (int c = 0; c < 3; ++c) s.splats[i].color[c] = c == i;
    return s;
}

/* Where the ray of a pixel meets one of the two discs. */
typedef struct hit {
    double r, t, depth;
} hit;

static hit hit_disc(const scene *s, int i, int x, int y) {
    double z = s->splats[i].center[2], distance = DISTANCE - z;
    double dx = ray_x(x), dy = ray_y(y);
    return (hit){.r = hypot(dx * distance - (double)s->splats[i].center[0], dy * distance),
                 .t = distance * sqrt(1 + dx * dx + dy * dy),
                 .depth = 0.5 + 0.5 * (11.0 / 9 - 20.0 / (9 * distance))};
}

static void check_two_discs(const scene *s, const picture *p) {
    size_t blended = 0, hidden = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            double weight[2] = {0, 0}, depth = 0;
            hit hits[2] = {hit_disc(s, 0, x, y), hit_disc(s, 1, x, y)};
            double limit = HUGE_VAL;
            for (int i = 0; i < 2; ++i)
                if (hits[i].r <= 1) limit = fmin(limit, hits[i].t + (double)s->depth_tolerance);
            for (int i = 0; i < 2; ++i)
                if (hits[i].r <= 1 && hits[i].t <= limit)
                    weight[i] = exp(-(double)s->kernel.sharpness *
                                    pow(hits[i].r, (double)s->kernel.exponent));
            double sum = weight[0] + weight[1];
            for (int i = 0; i < 2; ++i) depth += sum > 0 ? weight[i] * hits[i].depth / sum : 0.5;
            int at = y * WIDTH + x;
            assert_int_equal(p->image.count[at], (weight[0] > 0) + (weight[1] > 0));
            assert_near(p->image.depth[at], depth, 1e-12);
            for (int i = 0; i < 2 && sum > 0; ++i)
                assert_near((double)p->image.color[4 * at + i], weight[i] / sum, FLOAT_STEP);
            blended += p->image.count[at] == 2;
            hidden += p->image.count[at] == 1 && hits[0].r <= 1 && hits[1].r <= 1;
        }
    assert_true(blended > 100 || hidden > 100);
}

static void test_two_discs(void **state) {
    (void)state;
    /* The gap of 0.1 is less than, about and more than epsilon. Along slanted rays the gap is
     * longer, so that an epsilon of 0.1005 blends some pixels and hides others. */
    const double epsilons[] = {0.2, 0.1005, 0.05, 0};
    const float kernels[][2] = {{2, 2}, {5, 1}, {0.5f, 4}};
    for (int e = 0; e < 4; ++e)
        for (int k = 0; k < 3; ++k) {
            scene s = two_discs(0.1, epsilons[e]);
            s.kernel = (psplat_kernel){kernels[k][0], kernels[k][1]};
            psplat_view view = front_view();
            picture p = picture_of(&s, NULL, &view);
            check_two_discs(&s, &p);
            picture_free(&p);
            scene_free(&s);
        }
}

/* A transform that scales by 2 doubles epsilon (spec 4): the gap is 0.2, epsilon 2 x 0.15. */
static void test_epsilon_scales(void **state) {
    (void)state;
    const double twice[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
    const double epsilons[] = {0.15, 0.08};
    for (int e = 0; e < 2; ++e) {
        scene s = two_discs(0.1, epsilons[e]);
        psplat_view view = front_view();
        picture p = picture_of(&s, twice, &view);
        int middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
        assert_int_equal(p.image.count[middle], e == 0 ? 2 : 1);
        picture_free(&p);
        scene_free(&s);
    }
}

static void test_epsilon_tie(void **state) {
    (void)state;
    scene s = two_discs(0.1, 0.1);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    int middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
    double slant = sqrt(1 + ray_x(WIDTH / 2) * ray_x(WIDTH / 2) * 2) - 1;
    /* The tie is relative to twice the facing disc's epsilon, the greatest of eq. (5). 0.1 is not a
     * float: 1.5e-8 / 0.1. */
    assert_near(p.image.epsilon_tie[middle], slant / 2, 1e-6);
    assert_int_equal(p.image.count[middle], 1);
    picture_free(&p);
    scene_free(&s);
}

/* Turns a splat about the x axis, so that its normal makes the angle with +z. */
static void tilt(psplat_splat *splat, double degrees) {
    double c = cos(degrees * CAMERA_PI / 180), n = sin(degrees * CAMERA_PI / 180);
    scene_set_axes(splat, (double[]){1, 0, 0}, (double[]){0, c, n});
    splat->normal[0] = 0, splat->normal[1] = (float)-n, splat->normal[2] = (float)c;
}

/* Eq. (5): along the ray epsilon grows with the slant, up to twice its value. */
static void test_slanted_epsilon(void **state) {
    (void)state;
    const struct {
        double degrees, factor;
    } slants[] = {{0, 1}, {45, 1.41421356}, {60, 2}, {80, 2}};
    psplat_view view = front_view();
    camera_parallel(&view, 1, 1, 10);
    for (int i = 0; i < 4; ++i)
        for (int beyond = 0; beyond < 2; ++beyond) {
            double epsilon = 0.1, gap = epsilon * slants[i].factor * (beyond ? 1.02 : 0.98);
            scene s = two_discs(gap, epsilon);
            s.splats[1].center[0] = 0;
            tilt(&s.splats[0], slants[i].degrees);
            tilt(&s.splats[1], slants[i].degrees);
            picture p = picture_of(&s, NULL, &view);
            assert_int_equal(p.image.count[HEIGHT / 2 * WIDTH + WIDTH / 2], beyond ? 1 : 2);
            picture_free(&p);
            scene_free(&s);
        }
}

/* Spec 5.2: normals of a two-sided material are negated where the splat faces away from the eye,
 * but for those whose field bends so much that a ray through the centre has been at most two depth
 * tolerances under the surface: with a curvature of 1/4 along u and 3/4 along v, about which it is
 * tilted, that is where cos^2 <= 4 (3/4) depthTolerance sin^2. These are mirrored, so that along
 * the view's rays they point the other way. Light from where they then point shows which was used,
 * and light from the eye that they point to it. */
static void test_two_sides(void **state) {
    (void)state;
    const double degrees[] = {60, 80, 100, 112, 115, 150, 180};
    const float bends[2] = {0.25f, 0.75f};
    psplat_view view = front_view();
    camera_parallel(&view, 1, 1, 10);
    for (int is_bent = 0; is_bent < 3; ++is_bent)
        for (int i = 0; i < 7; ++i) {
            scene s = scene_disc(1);
            s.material.double_sided = 1;
            s.depth_tolerance = 0.0625f; /* the tilt of tan^2 = 16 / 3 is 113.4 degrees */
            for (int k = 0; k < 2 && is_bent; ++k)
                s.splats[0].gradient[k] = is_bent > 1 ? -bends[k] : bends[k];
            tilt(&s.splats[0], degrees[i]);
            double sign = degrees[i] > (is_bent == 1 ? 113.4 : 90) ? -1 : 1;
            int is_mirrored = sign > 0 && degrees[i] > 90;
            for (int k = 0; k < 3; ++k) /* opposite to the normal that is used */
                view.lights[0].direction[k] =
                    (float)(k == 2 && is_mirrored ? 1 : -sign) * s.splats[0].normal[k];
            for (int from_eye = 0; from_eye < 2; ++from_eye) {
                for (int k = 0; k < 3 && from_eye; ++k)
                    view.lights[0].direction[k] = k == 2 ? -1 : 0;
                picture p = picture_of(&s, NULL, &view);
                int middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
                assert_int_equal(p.image.count[middle], 1);
                /* At the flattest tilts 0.08 of the light counts, or more; from behind none does.
                 */
                assert_true(p.image.color[4 * middle] > (from_eye ? 0.05f : 0.5f));
                picture_free(&p);
            }
            scene_free(&s);
        }
}

/* ---- modes ----------------------------------------------------------------------------------- */

/* Modes that show the nearest splat do so whatever epsilon is: the red disc hides the green one
 * behind it. */
static void test_nearest_modes(void **state) {
    (void)state;
    scene s = two_discs(0.01, 10);
    psplat_view view = front_view();
    view.mode = PSPLAT_MODE_FLAT;
    picture flat = picture_of(&s, NULL, &view);
    view.mode = PSPLAT_MODE_PARAMETERS;
    picture parameters = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            hit hits[2] = {hit_disc(&s, 0, x, y), hit_disc(&s, 1, x, y)};
            int nearest = hits[0].r <= 1 ? 0 : hits[1].r <= 1 ? 1 : -1, at = y * WIDTH + x;
            assert_int_equal(flat.image.splat[at], nearest);
            assert_int_equal(flat.image.count[at], nearest >= 0);
            double tie = 1; /* to the hidden disc, for which epsilon does not matter */
            if (hits[0].r <= 1 && hits[1].r <= 1) tie = hits[1].depth - hits[0].depth;
            assert_near(fmin(flat.image.depth_tie[at], 0.01), fmin(tie, 0.01), 1e-12);
            assert_near(flat.image.epsilon_tie[at], 1, 0);
            if (nearest < 0) continue;
            assert_near((double)flat.image.color[4 * at + nearest], 1, 0);
            assert_near((double)flat.image.color[4 * at + 1 - nearest], 0, 0);
            assert_near(flat.image.depth[at], hits[nearest].depth, 1e-12);
            const float *uv = &parameters.image.color[4 * at];
            assert_near(hypot((double)uv[0], (double)uv[1]), hits[nearest].r, FLOAT_STEP);
            assert_near((double)uv[2], nearest, 0);
            assert_near((double)uv[3], 1, 0);
        }
    picture_free(&flat);
    picture_free(&parameters);
    scene_free(&s);
}

static double brightness(const picture *p, int x, int y) {
    return (double)p->image.color[4 * (y * p->width + x)];
}

/* Returns what a flat splat with this normal that fills the view shows at a pixel. */
static double brightness_of(const double normal[3], const psplat_view *view, int x, int y) {
    scene s = scene_disc(5);
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int i = 0; i < 3; ++i) s.splats[0].normal[i] = (float)(normal[i] / length);
    picture p = picture_of(&s, NULL, view);
    double result = brightness(&p, x, y);
    picture_free(&p);
    scene_free(&s);
    return result;
}

/* One splat is curved more in u than in v, in directions that are not its axes. Only Phong shading
 * varies over it, by eq. (2). */
static void test_curved_splat(void **state) {
    (void)state;
    scene s = scene_disc(1);
    s.splats[0].gradient[0] = 0.6f;
    s.splats[0].gradient[1] = -0.3f;
    s.splats[0].gradient[2] = 0.4f;
    s.splats[0].radius[1] = 0.75f;
    s.splats[0].normal[0] = 0.28f;
    s.splats[0].normal[2] = 0.96f;
    psplat_view view = front_view();
    view.width = view.height = 49;
    camera_parallel(&view, 1.2, 1, 10);
    for (int mode = PSPLAT_MODE_PHONG; mode <= PSPLAT_MODE_FLAT; ++mode) {
        view.mode = (psplat_mode)mode;
        picture p = picture_of(&s, NULL, &view);
        for (int y = 6; y < 49; y += 9)
            for (int x = 6; x < 49; x += 9) {
                int at = y * 49 + x;
                if (!p.image.count[at]) continue;
                double bend = mode == PSPLAT_MODE_PHONG;
                double u = p.image.uv[2 * at], v = p.image.uv[2 * at + 1];
                double normal[3] = {0.28 / 0.96 + bend * (0.6 * u + 0.4 * 0.75 * v),
                                    bend * (0.4 * u - 0.3 * v), 1};
                /* Normals of the flat splat are floats, and the lobe's slope is below 10. */
                assert_near(brightness(&p, x, y), brightness_of(normal, &view, x, y), 2e-6);
            }
        picture_free(&p);
    }
    scene_free(&s);
}

/* The blended normal is the sum of unnormalised ones: two coplanar splats tilted to +x and -x with
 * equal weights face straight up in Phong mode; in Gaussian mode they stay darker. */
static void test_blended_normals(void **state) {
    (void)state;
    scene s = scene_blank(2);
    scene straight = scene_blank(1);
    for (int i = 0; i < 2; ++i) {
        s.splats[i].normal[0] = i ? 0.6f : -0.6f;
        s.splats[i].normal[2] = 0.8f;
    }
    psplat_view view = front_view();
    picture expected = picture_of(&straight, NULL, &view), phong = picture_of(&s, NULL, &view);
    view.mode = PSPLAT_MODE_GAUSSIAN;
    picture gaussian = picture_of(&s, NULL, &view);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        assert_near((double)phong.image.color[4 * i], (double)expected.image.color[4 * i],
                    FLOAT_STEP);
        if (phong.image.count[i])
            assert_true(gaussian.image.color[4 * i] < 0.9f * phong.image.color[4 * i]);
    }
    picture_free(&expected);
    picture_free(&phong);
    picture_free(&gaussian);
    scene_free(&s);
    scene_free(&straight);
}

/* ---- many splats ----------------------------------------------------------------------------- */

/* Returns where the analytic unit sphere is hit; *passes becomes the distance at which the ray
 * passes its centre. */
static double sphere_depth(int x, int y, double *passes) {
    double d[3] = {ray_x(x), ray_y(y), -1}, length = sqrt(d[0] * d[0] + d[1] * d[1] + 1);
    double along = DISTANCE / length, miss2 = DISTANCE * DISTANCE - along * along;
    *passes = sqrt(miss2);
    return miss2 < 1 ? (along - sqrt(1 - miss2)) / length : 0;
}

/* 2000 splats on a unit sphere lie within sagitta = 1 - cos(angular radius) of it. */
static void test_sphere(void **state) {
    (void)state;
    scene s = scene_sphere(2000, 1);
    double radius = s.splats[0].radius[0];
    double sagitta = sqrt(1 + radius * radius) - 1;
    assert_true(radius < 0.12);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    size_t inside = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            double passes = 0, distance = sphere_depth(x, y, &passes);
            uint32_t count = p.image.count[y * WIDTH + x];
            if (passes < 1 - sagitta) assert_true(count > 0);
            if (passes > 1 + sagitta) assert_int_equal(count, 0);
            if (passes > 0.9) continue;
            ++inside;
            /* Both depths are measured along the ray: a plane lies at most sagitta outside, and
             * planes are blended over epsilon. */
            double depth = p.image.depth[y * WIDTH + x];
            double found = 20.0 / (9 * (11.0 / 9 - 2 * (depth - 0.5)));
            double slant = 1 / sqrt(1 - passes * passes);
            assert_near(found, distance, sagitta * slant + (double)s.depth_tolerance);
        }
    assert_true(inside > 400);
    picture_free(&p);
    scene_free(&s);
}

/* The normals of the splats are those of the sphere: a pixel is lit as one splat with the analytic
 * normal. */
static void test_sphere_normals(void **state) {
    (void)state;
    scene s = scene_sphere(2000, 1);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    for (int y = 4; y < HEIGHT; y += 5)
        for (int x = 3; x < WIDTH; x += 7) {
            double passes = 0, distance = sphere_depth(x, y, &passes);
            if (passes > 0.8) continue;
            double n[3] = {ray_x(x) * distance, ray_y(y) * distance, DISTANCE - distance};
            /* The blend errs by the square of the angular radius: 0.1 rad gives 0.01 rad. */
            assert_near(brightness(&p, x, y), brightness_of(n, &view, x, y), 0.01);
        }
    picture_free(&p);
    scene_free(&s);
}

int test_reference_blend_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_discs),    cmocka_unit_test(test_epsilon_scales),
        cmocka_unit_test(test_epsilon_tie),  cmocka_unit_test(test_slanted_epsilon),
        cmocka_unit_test(test_two_sides),    cmocka_unit_test(test_nearest_modes),
        cmocka_unit_test(test_curved_splat), cmocka_unit_test(test_blended_normals),
        cmocka_unit_test(test_sphere),       cmocka_unit_test(test_sphere_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
