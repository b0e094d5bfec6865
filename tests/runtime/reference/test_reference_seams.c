/* SPDX-License-Identifier: MIT
 *
 * test_reference_seams.c - tests seam lines of the reference rasteriser (spec 3.6) against closed
 * forms: beyond a seam a splat covers, hides and bends normals as inside, and its material has a
 * 256th of its weight. Views are parallel, so that (u, v) is affine in the pixel.
 */
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"

#define SIZE 32
#define FLOAT_STEP 1.2e-7 /* colours are returned as floats, which are at most 1 here */
#define BEYOND (1.0 / 256)

/* One unit of the scene is a pixel; pixel (0, 0) has its corner at the origin; +z points to the
 * eye. */
static psplat_view pixel_view(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){SIZE / 2.0, SIZE / 2.0, 20},
                (double[]){SIZE / 2.0, SIZE / 2.0, 0});
    camera_parallel(&view, SIZE / 2.0, 10, 30);
    view.shading = PSPLAT_SHADING_UNLIT;
    return view;
}

/* Returns a red and a green disc of radius 10 at one place, within epsilon of each other, with a
 * seam at u = 0.05 from its side each: red goes on to +x, green to -x. The seam is between two
 * columns of pixels. */
static scene two_sides(void) {
    scene s = scene_blank(2);
    for (int k = 0; k < 2; ++k) {
        psplat_splat *splat = &s.splats[k];
        const float center[3] = {16, 16, (float)-k};
        memcpy(splat->center, center, sizeof center);
        splat->radius[0] = splat->radius[1] = 10;
        for (int c = 0; c < 3; ++c) splat->color[c] = c == k;
        splat->clip_count = 1;
        splat->clip[0][0] = k ? -1.0f : 1.0f;
        splat->clip[0][2] = k ? 0.1f : -0.1f;
    }
    s.has_color = 1;
    s.depth_tolerance = 3;
    s.seam_lines = 1;
    return s;
}

static double x_of(int pixel) {
    return pixel % SIZE + 0.5 - 16;
}

static double y_of(int pixel) {
    return pixel / SIZE + 0.5 - 16;
}

/* Returns s of splat k of two_sides in a pixel. */
static double seam_of(int k, int pixel) {
    return (x_of(pixel) > 1) == (k == 0) ? 1 : BEYOND;
}

/* Colour and depth have the weights s, which psi, equal for both, drops out of; both discs cover
 * all of their ellipse. */
static void test_weights(void **state) {
    (void)state;
    static const psplat_mode modes[] = {PSPLAT_MODE_PHONG, PSPLAT_MODE_GAUSSIAN};
    for (int m = 0; m < 2; ++m) {
        scene s = two_sides();
        s.material.unlit = 1;
        psplat_view view = pixel_view();
        view.mode = modes[m];
        if (m) view.shading = PSPLAT_SHADING_LIT; /* splats are lit one by one: L = B */
        picture p = picture_of(&s, NULL, &view);
        for (int i = 0; i < SIZE * SIZE; ++i) {
            int is_covered = hypot(x_of(i), y_of(i)) <= 10;
            assert_int_equal(p.image.count[i], is_covered ? 2 : 0);
            if (!is_covered) continue;
            double red = seam_of(0, i), green = seam_of(1, i), sum = red + green;
            assert_near((double)p.image.color[4 * i], red / sum, FLOAT_STEP);
            assert_near((double)p.image.color[4 * i + 1], green / sum, FLOAT_STEP);
            assert_near(p.image.depth[i], (red * 0.5 + green * 0.55) / sum, 1e-12);
            /* A pixel is a tenth of a unit of (u, v), and the line is 1 + half a pixel away. */
            assert_true(p.image.tie[i] <= fabs(x_of(i) - 1) + 1e-6);
        }
        picture_free(&p);
        scene_free(&s);
    }
}

/* Alone, what lies beyond a seam looks as inside it: the least weight fills the gap. */
static void test_gap(void **state) {
    (void)state;
    scene s = two_sides();
    s.count = 1;
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i)
        if (p.image.count[i]) assert_near((double)p.image.color[4 * i], 1, FLOAT_STEP);
    assert_int_equal(p.image.count[16 * SIZE + 10], 1);
    picture_free(&p);
    scene_free(&s);
}

static void lean(psplat_splat *splat, double x) {
    double length = hypot(x, 1);
    splat->normal[0] = (float)(x / length);
    splat->normal[2] = (float)(1 / length);
}

/* Expects that the normals of two_sides, (0.5, 0, 1) and (-0.25, 0, 1) and their gradients, are
 * blended with these weights on either side. */
static void check_normals(const scene *from, double (*weight)(int k, int pixel)) {
    scene s = *from;
    lean(&s.splats[0], 0.5);
    lean(&s.splats[1], -0.25);
    s.splats[0].gradient[0] = 0.25f;
    psplat_view view = pixel_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (!p.image.count[i]) continue;
        double first = weight(0, i), second = weight(1, i);
        double x = first * (0.5 + 0.025 * x_of(i)) - second * 0.25, z = first + second;
        /* Normals are stored as floats. */
        assert_near((double)p.image.color[4 * i], 0.5 + 0.5 * x / hypot(x, z), 3 * FLOAT_STEP);
    }
    picture_free(&p);
}

static double whole(int k, int pixel) {
    (void)k, (void)pixel;
    return 1;
}

/* Normals are blended across seams as if there were none, but not those that a texture turns: here
 * by one that leaves them as they are. */
static void test_normals(void **state) {
    (void)state;
    const uint8_t texel[4] = {255, 255, 255, 255};
    const psplat_pixels image = {.rgba = texel, .width = 1, .height = 1};
    scene s = two_sides();
    check_normals(&s, whole);
    s.texcoords = calloc(2, sizeof *s.texcoords);
    assert_non_null(s.texcoords);
    for (int k = 0; k < 2; ++k)
        s.texcoords[k] = (psplat_texcoord){.along_u = {1, 0}, .along_v = {0, -1}};
    s.images = &image;
    s.image_count = 1;
    s.material.textures[PSPLAT_TEXTURE_BASE_COLOR] = (psplat_texture){.image = 1};
    check_normals(&s, whole);
    s.material.textures[PSPLAT_TEXTURE_NORMAL] = (psplat_texture){.image = 1, .strength = 0};
    check_normals(&s, seam_of);
    scene_free(&s);
}

/* Beyond its seam a splat hides what lies farther than epsilon, and is the nearest. */
static void test_visibility(void **state) {
    (void)state;
    scene s = two_sides();
    s.depth_tolerance = 0.1f;
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    assert_int_equal(p.image.count[16 * SIZE + 10], 1);
    assert_int_equal(p.image.splat[16 * SIZE + 10], 0);
    view.mode = PSPLAT_MODE_FLAT;
    picture flat = picture_of(&s, NULL, &view);
    assert_near((double)flat.image.color[4 * (16 * SIZE + 10)], 1, FLOAT_STEP);
    picture_free(&flat);
    picture_free(&p);
    scene_free(&s);
}

/* Beyond its seam a disc casts a shadow on the floor, and beyond its other line it does not. */
static void test_shadow(void **state) {
    (void)state;
    scene s = two_sides();
    const float at[3] = {8, 16, 4}, cut[3] = {0, 1, 0}, seam[3] = {1, 0, 0},
                whole_disc[3] = {1, 0, 9};
    memcpy(s.splats[0].center, at, sizeof at);
    s.splats[0].radius[0] = s.splats[0].radius[1] = 3;
    s.splats[0].clip_count = 2;
    memcpy(s.splats[0].clip[0], cut, sizeof cut);
    memcpy(s.splats[0].clip[1], seam, sizeof seam);
    memcpy(s.splats[1].clip[0], whole_disc, sizeof whole_disc);
    s.splats[1].center[2] = 0;
    s.splats[1].radius[0] = s.splats[1].radius[1] = 40;
    s.depth_tolerance = 0.1f;
    psplat_view view = pixel_view();
    view.shading = PSPLAT_SHADING_LIT;
    view.lights[0].direction[0] = 2; /* the shadow lies 8 to the right of the disc */
    view.lights[0].direction[2] = -1;
    view.lights[0].casts_shadow = 1;
    picture p = picture_of(&s, NULL, &view);
    const float *inside = p.image.color + 4 * (17 * SIZE + 17);
    const float *beyond = p.image.color + 4 * (17 * SIZE + 14);
    const float *cut_off = p.image.color + 4 * (14 * SIZE + 14);
    assert_true(inside[1] == 0 && beyond[1] == 0 && cut_off[1] > 0.1f);
    picture_free(&p);
    scene_free(&s);
}

/* One line cuts the disc, the last one is a seam; which is which does not hang on their order in
 * files, but on their number. */
static void test_last_lines(void **state) {
    (void)state;
    for (uint32_t seams = 0; seams <= 2; ++seams) {
        scene s = two_sides();
        s.seam_lines = seams;
        const float up[3] = {0, 1, 0};
        for (int k = 0; k < 2; ++k) {
            s.splats[k].clip_count = 2;
            memcpy(s.splats[k].clip[1], s.splats[k].clip[0], sizeof up);
            memcpy(s.splats[k].clip[0], up, sizeof up);
        }
        psplat_view view = pixel_view();
        picture p = picture_of(&s, NULL, &view);
        const uint32_t above[] = {1, 2, 2}, below[] = {0, 0, 2};
        assert_int_equal(p.image.count[20 * SIZE + 12], above[seams]);
        assert_int_equal(p.image.count[12 * SIZE + 12], below[seams]);
        /* Beyond both seams a splat has a 256th, too, and not a 256th of that: below, red is beyond
         * one or two of them, and green beyond one. */
        if (seams == 2) assert_near((double)p.image.color[4 * (12 * SIZE + 12)], 0.5, FLOAT_STEP);
        picture_free(&p);
        scene_free(&s);
    }
}

/* A bent seam is where its parabola is. */
static void test_bend(void **state) {
    (void)state;
    scene s = two_sides();
    const double kappa = 1.5;
    s.splats[0].bend[0] = (float)kappa;
    s.splats[1].bend[0] = (float)kappa;
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    size_t bent = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (!p.image.count[i]) continue;
        double u = x_of(i) / 10, v = y_of(i) / 10, rise = kappa * v * v / 2;
        double red = u - 0.1 + rise >= 0 ? 1 : BEYOND, green = 0.1 - u + rise >= 0 ? 1 : BEYOND;
        if (p.image.tie[i] < 1e-6) continue;
        assert_near((double)p.image.color[4 * i], red / (red + green), FLOAT_STEP);
        bent += red == green;
    }
    assert_true(bent > 50);
    picture_free(&p);
    scene_free(&s);
}

/* Below a pixel the line is softened over up to a pixel, as those are that cut, and what is left
 * of s is never below a 256th. A backdrop lies behind both, because what the filter adds shows only
 * before splats. */
static void test_soft(void **state) {
    (void)state;
    const double radii[2] = {8, 0.6}, soft = 1 / radii[1] - 1;
    scene s = scene_blank(3), two = two_sides();
    for (int k = 0; k < 2; ++k) {
        s.splats[k] = two.splats[k];
        const float line[3] = {0, k ? -1.0f : 1.0f, k ? 0.25f : -0.25f};
        memcpy(s.splats[k].clip[0], line, sizeof line);
        for (int i = 0; i < 2; ++i) s.splats[k].radius[i] = (float)radii[i];
        s.splats[k].center[1] = 16.3f;
    }
    s.splats[2].center[0] = s.splats[2].center[1] = 16;
    s.splats[2].center[2] = -2;
    s.splats[2].radius[0] = s.splats[2].radius[1] = 1000;
    for (int c = 0; c < 3; ++c) s.splats[2].color[c] = c == 2;
    s.has_color = 1;
    s.depth_tolerance = 4;
    s.seam_lines = 1;
    psplat_view view = pixel_view();
    view.no_filter = 0;
    picture p = picture_of(&s, NULL, &view);
    size_t partly = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double u = x_of(i) / radii[0], v = i / SIZE + 0.5 - (double)s.splats[0].center[1];
        int is_covered = hypot(u, v) <= 1;
        assert_int_equal(p.image.count[i], is_covered ? 3 : 1);
        if (!is_covered) continue;
        double factor[2];
        for (int k = 0; k < 2; ++k) {
            double delta = (k ? -1 : 1) * (v - 0.25);
            factor[k] = fmax(fmin(fmax(0.5 + delta / soft, 0), 1), BEYOND);
        }
        double red = (double)p.image.color[4 * i], green = (double)p.image.color[4 * i + 1];
        /* Centres are floats of 16 pixels, and slopes a unit in soft pixels. */
        assert_near(red / (red + green), factor[0] / (factor[0] + factor[1]), 1e-5);
        partly += factor[0] > 0.1 && factor[0] < 0.9;
    }
    assert_true(partly >= 5);
    picture_free(&p);
    scene_free(&two);
    scene_free(&s);
}

/* On curved splats a seam is where (u, v) is, which the view from above shows as it is. */
static void test_curved(void **state) {
    (void)state;
    scene s = two_sides();
    for (int k = 0; k < 2; ++k) s.splats[k].gradient[0] = s.splats[k].gradient[1] = 0.5f;
    scene_curve(&s);
    psplat_view view = pixel_view();
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        int is_covered = hypot(x_of(i), y_of(i)) <= 10;
        assert_int_equal(p.image.count[i], is_covered ? 2 : 0);
        if (!is_covered) continue;
        double red = seam_of(0, i), green = seam_of(1, i);
        assert_near((double)p.image.color[4 * i], red / (red + green), 1e-6);
    }
    picture_free(&p);
    scene_free(&s);
}

int test_reference_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_weights), cmocka_unit_test(test_gap),
        cmocka_unit_test(test_normals), cmocka_unit_test(test_visibility),
        cmocka_unit_test(test_shadow),  cmocka_unit_test(test_last_lines),
        cmocka_unit_test(test_bend),    cmocka_unit_test(test_soft),
        cmocka_unit_test(test_curved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
