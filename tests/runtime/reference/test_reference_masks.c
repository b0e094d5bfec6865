/* SPDX-License-Identifier: MIT
 *
 * test_reference_masks.c - tests masked materials of the reference rasteriser (spec 3.11) and their
 * shadows.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "textured_fixture.h"

#define MASKED(cutoff)                                                                             \
    "{\"alphaMode\":\"MASK\",\"alphaCutoff\":" cutoff ",\"doubleSided\":true,"                     \
    "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"                               \
    "\"extensions\":{\"KHR_materials_unlit\":{}}}"

/* Alpha grows from 0 to 1 between x = 0.25 and 0.75; what is behind shows where it is below the
 * cutoff. The splat behind has its texture coordinates where alpha is 1. */
static void test_mask(void **state) {
    (void)state;
    static const uint8_t texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    const psplat_pixels image = {.rgba = texels, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.extension = HEAD ",\"positionExtent\":[0,0,1]";
    p.material = MASKED("0.25");
    p.sampler = "\"wrapS\":33071";
    p.has_colors = 1;
    p.colors[3] = 0.5; /* so that the texture's alpha has to be a half, where x is 0.5 */
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = 3, p.radii[2] = p.radii[3] = 3;
    p.u[0] = 3, p.v[1] = 3;
    p.at[2] = 1, p.u[2] = p.v[3] = 0;
    for (int k = 4; k < 7; ++k) p.colors[k] = 0.125;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double alpha = 0.5 * fmin(fmax(2 * middle(i % SIZE) - 0.5, 0), 1);
        int is_there = alpha >= 0.25;
        assert_int_equal(drawn.image.count[i], 1);
        assert_int_equal(drawn.image.splat[i], is_there ? 0 : 1);
        assert_near((double)drawn.image.color[4 * i], is_there ? 1 : 0.125, FLOAT_STEP);
        assert_near(drawn.image.alpha_tie[i], fabs(alpha - 0.25), 1e-6);
    }
    picture_free(&drawn);
    p.material = MASKED("1.5");
    drawn = draw(&p, 2, &image, 1, NULL, &view);
    assert_int_equal(picture_covered(&drawn), 0);
    picture_free(&drawn);
}

/* A masked splat between light and plane casts its shadow where it is there. Light comes from
 * above, and the eye looks up from below at the two-sided plane at z = -1. */
static void test_masked_shadow(void **state) {
    (void)state;
    static const uint8_t texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    const psplat_pixels image = {.rgba = texels, .width = 2, .height = 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_LIT;
    view.culling = PSPLAT_CULL_NEVER;
    camera_look(&view, (double[]){0, 0, 20}, (double[]){0, 0, 0});
    view.lights[0].casts_shadow = 1;
    view.lights[0].direction[0] = 1; /* from the left and above: shadows lie 1 to the right */
    view.lights[0].direction[1] = 0;
    view.lights[0].direction[2] = -1;
    plate p = disc();
    p.extension = "\"version\":3,\"clipLines\":0,\"depthTolerance\":0.01,"
                  "\"positionExtent\":[0,0,1]";
    p.material = "{\"alphaMode\":\"MASK\",\"doubleSided\":true,"
                 "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}";
    p.sampler = "\"wrapS\":33071,\"magFilter\":9728";
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = 0.75, p.radii[2] = p.radii[3] = 4;
    p.u[0] = 0.75, p.at[0] = 0.5; /* there where x >= 0 */
    p.at[2] = 1, p.u[2] = p.v[3] = 0;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    size_t dark = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double x = middle(i % SIZE), y = middle(i / SIZE);
        if (drawn.image.splat[i] != 1) continue;
        double from = x - 1; /* where the light passed the first splat */
        int is_dark = from >= 0 && from * from + y * y <= 0.75 * 0.75;
        assert_true((drawn.image.color[4 * i] == 0) == is_dark);
        if (is_dark) ++dark;
    }
    assert_int_equal(dark, 0); /* x >= 1 is outside the view: the left half casts none */
    picture_free(&drawn);
    p.u[0] = -0.75; /* there where x <= 0 */
    drawn = draw(&p, 2, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double from = middle(i % SIZE) - 1, y = middle(i / SIZE);
        if (drawn.image.splat[i] != 1) continue;
        int is_dark = from <= 0 && from * from + y * y <= 0.75 * 0.75;
        assert_true((drawn.image.color[4 * i] == 0) == is_dark);
        if (is_dark) ++dark;
    }
    assert_true(dark > 20);
    picture_free(&drawn);
}

int test_reference_masks_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_masked_shadow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
