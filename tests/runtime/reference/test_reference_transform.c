/* SPDX-License-Identifier: MIT
 *
 * test_reference_transform.c - tests sides and transforms of the reference rasteriser against
 * closed forms (spec 4 and 5.2), on discs and clipped splats.
 */
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
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

static void assert_pictures_near(const picture *a, const picture *b, double tolerance) {
    assert_true(picture_covered(a) > 100);
    for (int i = 0; i < a->width * a->height; ++i) {
        assert_int_equal(a->image.count[i], b->image.count[i]);
        assert_near(a->image.depth[i], b->image.depth[i], tolerance);
        for (int c = 0; c < 4; ++c)
            assert_near((double)a->image.color[4 * i + c], (double)b->image.color[4 * i + c],
                        tolerance);
    }
}

/* ---- sides ----------------------------------------------------------------------------------- */

static void test_culling(void **state) {
    (void)state;
    static const struct {
        int from_behind, double_sided;
        psplat_culling culling;
        int seen;
    } cases[] = {
        {0, 0, PSPLAT_CULL_BY_MATERIAL, 1}, {1, 0, PSPLAT_CULL_BY_MATERIAL, 0},
        {1, 1, PSPLAT_CULL_BY_MATERIAL, 1}, {1, 0, PSPLAT_CULL_NEVER, 1},
        {1, 1, PSPLAT_CULL_ALWAYS, 0},      {0, 1, PSPLAT_CULL_ALWAYS, 1},
    };
    scene s = scene_disc(1);
    psplat_view view = front_view();
    picture front = picture_of(&s, NULL, &view);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const double normal = cases[i].from_behind ? -1 : 1;
        s.material.double_sided = cases[i].double_sided;
        scene_set_axes(&s.splats[0], (double[]){normal, 0, 0}, (double[]){0, 1, 0});
        s.splats[0].normal[2] = (float)normal;
        view.culling = cases[i].culling;
        picture p = picture_of(&s, NULL, &view);
        /* Seen from behind the normal is negated, so that the disc is lit as from the front. */
        if (cases[i].seen)
            assert_pictures_near(&p, &front, FLOAT_STEP);
        else
            assert_int_equal(picture_covered(&p), 0);
        picture_free(&p);
    }
    picture_free(&front);
    scene_free(&s);
}

/* ---- transforms ------------------------------------------------------------------------------ */

/* A disc under diag(2, 1, 1) is an ellipse of radii 2 and 1. */
static void test_scaled_disc(void **state) {
    (void)state;
    const double stretch[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    scene disc = scene_disc(0.5f), ellipse = scene_disc(1);
    ellipse.splats[0].radius[1] = 0.5f;
    psplat_view view = front_view();
    picture a = picture_of(&disc, stretch, &view), b = picture_of(&ellipse, NULL, &view);
    assert_pictures_near(&a, &b, FLOAT_STEP);
    picture_free(&a);
    picture_free(&b);
    scene_free(&disc);
    scene_free(&ellipse);
}

/* The transform diag(1, 3, 1) is applied to a tilted splat. Its plane's normal (0, -sin, cos) is
 * divided by (1, 3, 1), and its second axis grows to length L while it stays in the plane. */
static void test_scaled_tilted_disc(void **state) {
    (void)state;
    const double stretch[16] = {1, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double c = cos(0.5), t = sin(0.5), length = hypot(3 * c, t);
    scene before = scene_disc(0.5f), after = scene_disc(0.5f);
    scene_set_axes(&before.splats[0], (double[]){1, 0, 0}, (double[]){0, c, t});
    before.splats[0].normal[1] = (float)-t;
    before.splats[0].normal[2] = (float)c;
    /* radius[0] is the larger one, so that U becomes the stretched axis. */
    scene_set_axes(&after.splats[0], (double[]){0, 3 * c / length, t / length},
                   (double[]){-1, 0, 0});
    double normal[3] = {0, -t / 3, c}, norm = hypot(normal[1], normal[2]);
    for (int i = 0; i < 3; ++i) after.splats[0].normal[i] = (float)(normal[i] / norm);
    after.splats[0].radius[0] = (float)(0.5 * length);
    psplat_view view = front_view();
    picture a = picture_of(&before, stretch, &view), b = picture_of(&after, NULL, &view);
    /* Stored normals and axes are floats: 1e-7 each, and the lobe's slope is below 10. */
    assert_pictures_near(&a, &b, 1e-6);
    picture_free(&a);
    picture_free(&b);
    scene_free(&before);
    scene_free(&after);
}

/* A mirror shows the mirrored image, from the same side, also of a shape with clip lines. */
static void test_mirror(void **state) {
    (void)state;
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    scene s = scene_ellipses(150, 4, 3);
    psplat_view view = front_view();
    camera_look(&view, (double[]){0, 0.5, 3}, (double[]){0, 0.5, 0});
    view.lights[0].direction[0] = 0;
    picture plain = picture_of(&s, NULL, &view), mirrored = picture_of(&s, mirror, &view);
    assert_true(picture_covered(&plain) > 300);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            int a = y * WIDTH + x, b = y * WIDTH + WIDTH - 1 - x;
            assert_int_equal(plain.image.count[a], mirrored.image.count[b]);
            assert_near(plain.image.depth[a], mirrored.image.depth[b], 1e-12);
            for (int c = 0; c < 3; ++c)
                assert_near((double)plain.image.color[4 * a + c],
                            (double)mirrored.image.color[4 * b + c], FLOAT_STEP);
        }
    picture_free(&plain);
    picture_free(&mirrored);
    scene_free(&s);
}

static void test_singular_transform(void **state) {
    (void)state;
    const double flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    scene s = scene_disc(1);
    psplat_view view = front_view();
    picture p = picture_of(&s, flat, &view);
    assert_int_equal(picture_covered(&p), 0);
    picture_free(&p);
    scene_free(&s);
}

int test_reference_transform_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_scaled_disc),
        cmocka_unit_test(test_scaled_tilted_disc),
        cmocka_unit_test(test_mirror),
        cmocka_unit_test(test_singular_transform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
