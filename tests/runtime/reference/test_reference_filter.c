/* SPDX-License-Identifier: MIT
 *
 * test_reference_filter.c - tests the reference rasteriser's screen-space filter (spec 5.8) against
 * closed forms. Views are parallel and splats unlit, so that everything can be read from the
 * colours: (u, v) is affine in the pixel, and L = B.
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

#define SIZE 32
#define FLOAT_STEP 1.2e-7 /* colours are returned as floats, which are at most 1 here */
#define CENTER 1e-6       /* in pixels: centres are floats of up to 16 */

/* One unit of the scene is a pixel; pixel (0, 0) has its corner at the origin; +z points to the
 * eye. */
static psplat_view pixel_view(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    view.no_filter = 0;
    camera_look(&view, (double[]){SIZE / 2.0, SIZE / 2.0, 20},
                (double[]){SIZE / 2.0, SIZE / 2.0, 0});
    camera_parallel(&view, SIZE / 2.0, 10, 30);
    return view;
}

static void place(psplat_splat *splat, double x, double y, double z, double ru, double rv) {
    splat->center[0] = (float)x;
    splat->center[1] = (float)y;
    splat->center[2] = (float)z;
    splat->radius[0] = (float)ru;
    splat->radius[1] = (float)rv;
}

static void paint(psplat_splat *splat, int channel) {
    for (int c = 0; c < 3; ++c) splat->color[c] = c == channel;
}

/* Turns a splat about the x axis, so that its normal makes the angle with +z. */
static void tilt(psplat_splat *splat, double degrees) {
    double c = cos(degrees * CAMERA_PI / 180), n = sin(degrees * CAMERA_PI / 180);
    scene_set_axes(splat, (double[]){1, 0, 0}, (double[]){0, c, n});
    splat->normal[0] = 0, splat->normal[1] = (float)-n, splat->normal[2] = (float)c;
}

/* Returns count splats, which the test places, and last a blue backdrop over the whole view within
 * epsilon of them, because what the filter adds shows only before splats. */
static scene unlit_scene(size_t count) {
    scene s = scene_blank(count + 1);
    place(&s.splats[count], 16, 16, -4, 1000, 1000);
    paint(&s.splats[count], 2);
    s.material.unlit = 1;
    s.has_color = 1;
    s.depth_tolerance = 5;
    return s;
}

static double distance_to(const psplat_splat *splat, int pixel) {
    return hypot(pixel % SIZE + 0.5 - (double)splat->center[0],
                 pixel / SIZE + 0.5 - (double)splat->center[1]);
}

static double psi(double r) {
    return exp(-2 * r * r);
}

/* Returns the backdrop's weight in a pixel. Its window depth is depth_behind. */
static double behind(int pixel) {
    return psi(hypot(pixel % SIZE + 0.5 - 16, pixel / SIZE + 0.5 - 16) / 1000);
}

static const double depth_behind = 0.7;

/* Counts the pixels that show more than the backdrop. */
static size_t count_before(const picture *p) {
    size_t count = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) count += p->image.count[i] > 1;
    return count;
}

/* ---- far below a pixel ----------------------------------------------------------------------- */

/* An ellipse of any size below a pixel covers the pixels whose centres are within a pixel of its
 * own. Its depths are those of its plane, over a pixel's width. */
static void test_small(void **state) {
    (void)state;
    const double radii[] = {1e-6, 0.1, 0.4, 0.999}, sine = sin(50 * CAMERA_PI / 180);
    const double at[][2] = {{16.5, 16.5}, {16, 16}, {10.9, 7.3}, {0.01, 31.99}};
    for (int r = 0; r < 4; ++r)
        for (int k = 0; k < 4; ++k) {
            scene s = unlit_scene(1);
            psplat_splat splat = s.splats[0];
            place(&splat, at[k][0], at[k][1], 1.5, radii[r], radii[r] / 3);
            tilt(&splat, 50);
            s.splats[0] = splat;
            double area = radii[r] * radii[r] / 3 * cos(50 * CAMERA_PI / 180);
            psplat_view view = pixel_view();
            picture p = picture_of(&s, NULL, &view);
            size_t covered = 0;
            for (int i = 0; i < SIZE * SIZE; ++i) {
                double d = distance_to(&splat, i);
                if (fabs(d - 1) < CENTER) continue;
                double v = i / SIZE + 0.5 - (double)splat.center[1];
                double depth = (8.5 - v * radii[r] / 3 * sine) / 20;
                double w = d <= 1 ? psi(d) * area : 0, w1 = behind(i);
                assert_int_equal(p.image.count[i], 1 + (d <= 1));
                assert_near(p.image.depth[i], (w * depth + w1 * depth_behind) / (w + w1), 1e-7);
                covered += d <= 1;
            }
            assert_true(covered >= 1);
            picture_free(&p);
            scene_free(&s);
        }
}

/* Two of them in a pixel are weighted by psi of their distances in pixels and by their areas. */
static void test_small_weights(void **state) {
    (void)state;
    const double radii[2][2] = {{0.3, 0.3}, {0.5, 0.2}};
    scene s = unlit_scene(2);
    place(&s.splats[0], 16.3, 16.1, 0, radii[0][0], radii[0][1]);
    place(&s.splats[1], 16.7, 15.9, -1, radii[1][0], radii[1][1]);
    for (int i = 0; i < 2; ++i) paint(&s.splats[i], i);
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    size_t shared = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double w[2];
        for (int k = 0; k < 2; ++k) {
            double d = distance_to(&s.splats[k], i);
            w[k] = d <= 1 ? psi(d) * radii[k][0] * radii[k][1] : 0;
        }
        double sum = w[0] + w[1] + behind(i);
        assert_int_equal(p.image.count[i], 1 + (w[0] > 0) + (w[1] > 0));
        for (int c = 0; c < 2; ++c) assert_near((double)p.image.color[4 * i + c], w[c] / sum, 2e-6);
        assert_near(p.image.depth[i], (w[0] * 0.5 + w[1] * 0.55 + behind(i) * depth_behind) / sum,
                    2e-7);
        shared += w[0] > 0 && w[1] > 0;
    }
    assert_true(shared >= 2);
    picture_free(&p);
    scene_free(&s);
}

/* They hide each other beyond epsilon only where the nearer one's own ellipse meets the ray: what
 * the filter adds is not visible to other splats (5.3). */
static void test_small_visibility(void **state) {
    (void)state;
    for (int hit = 0; hit < 2; ++hit) {
        scene s = unlit_scene(2);
        s.depth_tolerance = 0.1f;
        place(&s.splats[0], hit ? 16.5 : 16.7, 16.5, 1, 0.01, 0.01);
        place(&s.splats[1], 16.6, 16.5, -1, 0.01, 0.01);
        psplat_view view = pixel_view();
        picture p = picture_of(&s, NULL, &view);
        assert_int_equal(p.image.count[16 * SIZE + 16], hit ? 1 : 3);
        assert_int_equal(p.image.splat[16 * SIZE + 16], hit ? 0 : 2);
        picture_free(&p);
        scene_free(&s);
    }
}

/* A disc seen along its plane is still two pixels wide, on its one visible side. */
static void test_edge_on(void **state) {
    (void)state;
    const double degrees[] = {89.9, 90, 90.1}, radii[] = {0.7, 4};
    for (int k = 0; k < 12; ++k) {
        scene s = unlit_scene(1);
        double radius = radii[k / 6];
        place(&s.splats[0], 16.4, 16.6, 0, radius, radius);
        tilt(&s.splats[0], degrees[k % 3]);
        psplat_view view = pixel_view();
        int culls = k / 3 % 2;
        view.culling = culls ? PSPLAT_CULL_ALWAYS : PSPLAT_CULL_NEVER;
        picture p = picture_of(&s, NULL, &view);
        size_t expected = 0;
        for (int i = 0; i < SIZE * SIZE; ++i) {
            double u = (i % SIZE + 0.5 - 16.4) / fmax(radius, 1), v = i / SIZE + 0.5 - 16.6;
            expected += hypot(u, v) <= 1;
        }
        assert_true(expected >= 3);
        /* 90 degrees is on neither side exactly: a quaternion of floats errs by 6e-8. */
        if (k % 3 != 1 || !culls)
            assert_int_equal(count_before(&p), culls && k % 3 == 2 ? 0 : expected);
        picture_free(&p);
        scene_free(&s);
    }
}

/* ---- thin ------------------------------------------------------------------------------------ */

/* The splat is 6 pixels along x and less than one along y. The test checks coverage, weight, normal
 * and depth of what the widened splat adds. */
static void check_thin(double rv, double degrees) {
    const double alpha = 0.3, beta = 0.5, slant = cos(degrees * CAMERA_PI / 180);
    const double sine = sin(degrees * CAMERA_PI / 180), s2 = rv * slant;
    scene s = unlit_scene(1);
    place(&s.splats[0], 16.2, 16.4, 0, 6, rv);
    tilt(&s.splats[0], degrees);
    s.splats[0].gradient[0] = (float)alpha;
    s.splats[0].gradient[1] = (float)beta;
    psplat_view view = pixel_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    picture p = picture_of(&s, NULL, &view);
    size_t added = 0, inside = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double u = (i % SIZE + 0.5 - (double)s.splats[0].center[0]) / 6;
        double v = i / SIZE + 0.5 - (double)s.splats[0].center[1], r = hypot(u, v);
        assert_int_equal(p.image.count[i], 1 + (r <= 1));
        if (r > 1) continue;
        ++inside;
        added += hypot(u, v / s2) > 1;
        double w = psi(r) * s2, far = behind(i);
        double n[3] = {w * alpha * u, w * (beta * v * slant - sine),
                       w * (slant + beta * v * sine) + far};
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int c = 0; c < 3; ++c)
            assert_near((double)p.image.color[4 * i + c], 0.5 + 0.5 * n[c] / length, 2e-6);
        double depth = (10 - v * rv * sine) / 20;
        assert_near(p.image.depth[i], (w * depth + far * depth_behind) / (w + far), 1e-6);
    }
    assert_true(inside >= 10 && added >= 3);
    picture_free(&p);
    scene_free(&s);
}

static void test_thin(void **state) {
    (void)state;
    check_thin(0.6, 0);
    check_thin(0.3, 0);
    check_thin(0.01, 0);
    check_thin(1, 60);
    check_thin(1.5, 75);
}

/* ---- clip lines ------------------------------------------------------------------------------ */

/* Compares a red splat that has a clip line, at a distance in pixels, with a green one that is
 * equal but whose line is far away: the ratio of their colours is the line's factor. Over a length
 * of ru a bent line leaves the straight one by bend pixels. What is not tilted is turned in its
 * plane. */
static size_t check_line(double ru, double rv, double degrees, double angle, double offset,
                         double bend) {
    const double center[2] = {16.3, 16.6};
    double slim = rv * cos(degrees * CAMERA_PI / 180), wide = fmax(ru, 1), high = fmax(slim, 1);
    double a = cos(angle) * wide, b = sin(angle) * high;
    double kappa = (double)(float)(2 * bend / (wide * wide)), turn = degrees == 0 ? 0.5 : 0;
    double soft = fmin(fmax(1 / slim - 1, 0), 1);
    scene s = unlit_scene(2);
    for (int k = 0; k < 2; ++k) {
        place(&s.splats[k], center[0], center[1], 0, ru, rv);
        tilt(&s.splats[k], degrees);
        if (turn > 0)
            scene_set_axes(&s.splats[k], (double[]){cos(turn), sin(turn), 0},
                           (double[]){-sin(turn), cos(turn), 0});
        paint(&s.splats[k], k);
        s.splats[k].clip_count = 1;
    }
    memcpy(s.splats[1].clip[0], (float[]){1, 0, 100}, sizeof s.splats[1].clip[0]);
    s.splats[0].clip[0][0] = (float)a;
    s.splats[0].clip[0][1] = (float)b;
    s.splats[0].clip[0][2] = (float)offset;
    s.splats[0].bend[0] = (float)kappa;
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    size_t partly = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double x = i % SIZE + 0.5 - (double)s.splats[0].center[0];
        double y = i / SIZE + 0.5 - (double)s.splats[0].center[1];
        double dx = cos(turn) * x + sin(turn) * y, dy = cos(turn) * y - sin(turn) * x;
        double along = a * dy / high - b * dx / wide;
        double slope[2] = {cos(angle) - kappa * along * b / wide,
                           sin(angle) + kappa * along * a / high};
        double delta = cos(angle) * dx + sin(angle) * dy + offset + kappa * along * along / 2;
        delta /= hypot(slope[0], slope[1]);
        double factor = soft > 0 ? fmin(fmax(0.5 + delta / soft, 0), 1) : delta >= 0;
        double red = (double)p.image.color[4 * i], green = (double)p.image.color[4 * i + 1];
        if (!(green > 0)) continue;
        if (fabs(factor) > 1e-5) assert_int_equal(p.image.count[i], factor > 0 ? 3 : 2);
        /* Lines are floats: 6e-8 of up to 20 pixels. */
        assert_near(red / green, factor, 1e-5);
        partly += factor > 0.1 && factor < 0.9;
    }
    picture_free(&p);
    scene_free(&s);
    return partly;
}

static void test_soft_lines(void **state) {
    (void)state;
    const struct {
        double ru, rv, degrees, offset;
    } splats[] = {{9, 5, 0, 0.2},   /* large: a hard line */
                  {9, 5, 60, -0.3}, /* large, slanted */
                  {8, 0.7, 0, 0.1}, /* thin */
                  {0.5, 0.2, 0, 0}, /* small */
                  {0.05, 0.04, 70, 0.2} /* far below a pixel */};
    for (int i = 0; i < 15; ++i) {
        size_t partly = 0, at = (size_t)i % 5;
        for (int k = 0; k < 8; ++k)
            partly += check_line(splats[at].ru, splats[at].rv, splats[at].degrees, k,
                                 splats[at].offset, (double[]){0, 2, -1.5}[i / 5]);
        assert_true(at < 2 ? partly == 0 : partly >= 4);
    }
}

/* A line through a pixel's centre leaves one half; two lines leave a quarter. */
static void test_half(void **state) {
    (void)state;
    for (uint32_t lines = 0; lines <= 2; ++lines) {
        scene s = unlit_scene(2);
        for (int k = 0; k < 2; ++k) {
            place(&s.splats[k], 16.5, 16.5, 0, 8, 0.5);
            paint(&s.splats[k], k);
        }
        s.splats[0].clip_count = lines;
        s.splats[0].clip[0][0] = s.splats[0].clip[1][1] = 1;
        psplat_view view = pixel_view();
        picture p = picture_of(&s, NULL, &view);
        double factor = pow(0.5, lines);
        int middle = 16 * SIZE + 16;
        assert_near((double)p.image.color[4 * middle],
                    0.5 * factor / (0.5 + 0.5 * factor + behind(middle)), FLOAT_STEP);
        assert_int_equal(p.image.count[middle], 3);
        picture_free(&p);
        scene_free(&s);
    }
}

/* Two halves of a disc that meet at a line weigh as much as the whole disc, without a seam: another
 * disc shows through both alike. */
static void test_no_seam(void **state) {
    (void)state;
    scene whole = unlit_scene(2), halves = unlit_scene(3);
    place(&whole.splats[0], 16.4, 16.2, 0, 11, 0.4);
    place(&whole.splats[1], 15.4, 17.2, 0, 20, 20);
    paint(&whole.splats[1], 1);
    halves.splats[2] = whole.splats[1];
    for (int k = 0; k < 2; ++k) {
        halves.splats[k] = whole.splats[0];
        halves.splats[k].clip_count = 1;
        for (int i = 0; i < 3; ++i)
            halves.splats[k].clip[0][i] = (k ? -1 : 1) * (float[]){0.6f, 0.8f, 0.1f}[i];
    }
    psplat_view view = pixel_view();
    picture p = picture_of(&whole, NULL, &view), q = picture_of(&halves, NULL, &view);
    size_t seam = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        for (int c = 0; c < 3; ++c)
            assert_near((double)q.image.color[4 * i + c], (double)p.image.color[4 * i + c],
                        FLOAT_STEP);
        seam += q.image.count[i] == 4;
    }
    assert_true(seam >= 2);
    picture_free(&p);
    picture_free(&q);
    scene_free(&whole);
    scene_free(&halves);
}

/* ---- what the filter leaves alone ------------------------------------------------------------ */

static void check_equal(const picture *p, const picture *q) {
    size_t n = SIZE * SIZE;
    assert_memory_equal(p->image.color, q->image.color, n * 4 * sizeof(float));
    assert_memory_equal(p->image.depth, q->image.depth, n * sizeof(double));
    assert_memory_equal(p->image.count, q->image.count, n * sizeof(uint32_t));
}

static void check_same(const scene *s, psplat_view view) {
    view.no_filter = 0;
    picture with = picture_of(s, NULL, &view);
    view.no_filter = 1;
    picture without = picture_of(s, NULL, &view);
    assert_true(picture_covered(&with) >= 5);
    check_equal(&with, &without);
    picture_free(&with);
    picture_free(&without);
}

/* The filter leaves out large splats without clip lines, modes that blend nothing, and splats, with
 * clip lines too, whose centre is not between the near and the far plane. */
static void test_unfiltered(void **state) {
    (void)state;
    scene s = unlit_scene(2);
    place(&s.splats[0], 16.4, 16.2, 0, 11, 9);
    place(&s.splats[1], 14.4, 12.2, -1, 3, 1.001);
    check_same(&s, pixel_view());
    for (int k = 0; k < 2; ++k) s.splats[k].clip_count = 1, s.splats[k].clip[0][0] = 1;
    s.splats[1].radius[0] = s.splats[1].radius[1] = 0.6f;
    for (int mode = PSPLAT_MODE_FLAT; mode <= PSPLAT_MODE_PARAMETERS; ++mode) {
        psplat_view view = pixel_view();
        view.mode = (psplat_mode)mode;
        check_same(&s, view);
    }
    scene_free(&s);
    s = unlit_scene(1);
    place(&s.splats[0], 16.5, 16.5, 10.5, 5, 5); /* half a unit before the near plane */
    tilt(&s.splats[0], 45);
    s.splats[0].clip_count = 1;
    s.splats[0].clip[0][0] = 0.8f;
    s.splats[0].clip[0][1] = 0.6f;
    check_same(&s, pixel_view());
    s.splats[0].center[2] = -10.2f; /* beyond the far plane */
    check_same(&s, pixel_view());
    scene_free(&s);
}

/* It leaves out curved splats, however small. */
static void test_unfiltered_curved(void **state) {
    (void)state;
    const double radii[][2] = {{8, 0.7}, {0.8, 0.3}, {0.05, 0.05}};
    for (int i = 0; i < 3; ++i) {
        scene s = unlit_scene(1);
        place(&s.splats[0], 16.4, 16.2, 0, radii[i][0], radii[i][1]);
        s.splats[0].shape[2] = 0.5f;
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = 0.8f;
        s.splats[0].bend[0] = 0.5f;
        check_same(&s, pixel_view());
        scene_free(&s);
    }
}

/* It also leaves out splats over whose axes w changes by more than a quarter, or whose centre is
 * closer to the near plane than twice the change of its depth over them. */
static void test_unfiltered_perspective(void **state) {
    (void)state;
    for (int k = 0; k < 4; ++k) { /* slanted and thin */
        int is_small = k < 2;     /* at the limits or a little within */
        scene s = unlit_scene(1);
        s.depth_tolerance = 30;
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = 0.8f;
        s.splats[0].clip[0][1] = 0.6f;
        psplat_view view = pixel_view();
        if (k % 2) {
            /* w = 20, of which a quarter is 5: |C_u.w| = r sin 45 and |C_v.w| = 0. */
            double r = (is_small ? 4.99 : 5.01) * sqrt(2);
            place(&s.splats[0], 16.5, 16, 0, r, 0.4);
            camera_perspective(&view, 20, 1, 100);
        } else {
            /* |g| is r sin 45 over 20, and the centre's depth is 1/4. */
            double r = (is_small ? 2.49 : 2.51) * sqrt(2);
            place(&s.splats[0], 16.5, 16, 5, r, 0.4);
        }
        tilt(&s.splats[0], 45);
        scene_set_axes(&s.splats[0], (double[]){0, sqrt(0.5), sqrt(0.5)}, (double[]){-1, 0, 0});
        picture with = picture_of(&s, NULL, &view);
        view.no_filter = 1;
        picture without = picture_of(&s, NULL, &view);
        assert_true(count_before(&without) >= 1);
        if (!is_small) check_equal(&with, &without);
        if (is_small) assert_true(count_before(&with) > count_before(&without));
        picture_free(&with);
        picture_free(&without);
        scene_free(&s);
    }
}

/* A slanted splat before the far plane is widened beyond it. There it is compared as if it lay
 * nearer, and the depth written is at most 1. */
static void test_far_plane(void **state) {
    (void)state;
    scene s = unlit_scene(1);
    place(&s.splats[0], 16.2, 16.6, -9.999, 0.9, 0.9);
    s.splats[1].center[2] = -9.9995f;
    const double deepest = 0.999975;
    tilt(&s.splats[0], 50);
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    size_t before = 0, beyond = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double v = i / SIZE + 0.5 - 16.6; /* v grows towards the eye; J' is the unit matrix */
        double depth = 0.99995 - v * 0.9 * sin(50 * CAMERA_PI / 180) / 20;
        double w = psi(distance_to(&s.splats[0], i)) * 0.81 * cos(50 * CAMERA_PI / 180);
        double w1 = behind(i), mean = (w * depth + w1 * deepest) / (w + w1);
        if (p.image.count[i] < 2) continue;
        assert_near(p.image.depth[i], fmin(mean, 1), 1e-6);
        before += depth < 1;
        beyond += depth > 1;
    }
    assert_true(before >= 1 && beyond >= 2);
    picture_free(&p);
    scene_free(&s);
}

/* ---- coverage -------------------------------------------------------------------------------- */

/* What the filter adds shows in pixels that some splat covers, and in no others, so that outlines
 * stay. */
static void check_coverage(uint32_t clip_lines) {
    scene s = scene_ellipses(60, clip_lines, 11);
    s.depth_tolerance = 1;
    psplat_view view = pixel_view();
    camera_parallel(&view, 2.5, 10, 30); /* six pixels a unit: splats of a third to two pixels */
    camera_look(&view, (double[]){0.2, 0.1, 20}, (double[]){0.2, 0.1, 0});
    view.culling = PSPLAT_CULL_NEVER;
    picture with = picture_of(&s, NULL, &view);
    view.no_filter = 1;
    picture without = picture_of(&s, NULL, &view);
    size_t more = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        assert_int_equal(with.image.count[i] > 0, without.image.count[i] > 0);
        assert_true((with.image.depth[i] < 1) == (without.image.depth[i] < 1));
        more += with.image.count[i] > without.image.count[i];
    }
    assert_true(more >= 5);
    picture_free(&with);
    picture_free(&without);
    scene_free(&s);
}

static void test_coverage(void **state) {
    (void)state;
    check_coverage(0);
    check_coverage(1);
}

/* ---- ties ------------------------------------------------------------------------------------ */

static double tie_at(const scene *s, int x, int y) {
    psplat_view view = pixel_view();
    picture p = picture_of(s, NULL, &view);
    double tie = p.image.tie[y * SIZE + x];
    picture_free(&p);
    return tie;
}

static void test_ties(void **state) {
    (void)state;
    scene s = unlit_scene(1);
    place(&s.splats[0], 16.5, 16.5, 0, 0.5, 0.5);
    /* The pixel is at the middle of both ellipses and nearly at that of the backdrop. */
    assert_near(tie_at(&s, 16, 16), 1 - hypot(0.5, 0.5) / 1000, 1e-7);
    place(&s.splats[0], 16.5 - 0.995, 16.5, 0, 0.5, 0.25);
    assert_near(tie_at(&s, 16, 16), 0.005, 1e-6);
    assert_near(tie_at(&s, 14, 16), 0.005, 1e-6);
    place(&s.splats[0], 16.5, 16.5, 0, 0.5, 0.25);
    s.splats[0].clip_count = 1; /* the line is half a pixel away, but for 0.003 */
    s.splats[0].clip[0][0] = 1;
    s.splats[0].clip[0][2] = -0.497f;
    assert_near(tie_at(&s, 16, 16), 0.003, 1e-6);
    place(&s.splats[0], 16.5, 16.5, 0, 8, 8); /* a hard line; (u, v) is less than pixels here */
    s.splats[0].clip[0][2] = -0.003f;
    assert_near(tie_at(&s, 16, 16), 0.003, 1e-6);
    scene_free(&s);
}

int test_reference_filter_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_small),
        cmocka_unit_test(test_small_weights),
        cmocka_unit_test(test_small_visibility),
        cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_thin),
        cmocka_unit_test(test_soft_lines),
        cmocka_unit_test(test_unfiltered_curved),
        cmocka_unit_test(test_half),
        cmocka_unit_test(test_no_seam),
        cmocka_unit_test(test_unfiltered),
        cmocka_unit_test(test_unfiltered_perspective),
        cmocka_unit_test(test_far_plane),
        cmocka_unit_test(test_coverage),
        cmocka_unit_test(test_ties),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
