/* SPDX-License-Identifier: MIT
 *
 * test_reference_normal_textures.c - tests normal textures of the reference rasteriser (spec 3.11)
 * against closed forms.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "textured_fixture.h"

/* Expects the normal of the middle of the plate to be along n, under a transform of the scene. */
static void check_normal(const plate *from, const double transform[16], const psplat_view *view,
                         const double n[3]) {
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    plate p = *from;
    picture drawn = draw(&p, 1, &image, 1, transform, view);
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const float *found = drawn.image.color + 4 * (SIZE / 2 * SIZE + SIZE / 2);
    for (int i = 0; i < 3; ++i)
        assert_near((double)found[i], 0.5 + 0.5 * n[i] / length, 2 * FLOAT_STEP);
    picture_free(&drawn);
}

/* A normal map leans with the image, however the image lies on the surface, mirrored or not. */
static void test_normals(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    const struct {
        double u[2], v[2], normal[3];
    } charts[] = {
        {{1, 0}, {0, -1}, {x, y, z}},   /* upright: V goes down, and green goes up */
        {{-1, 0}, {0, -1}, {-x, y, z}}, /* mirrored */
        {{1, 0}, {0, 1}, {x, -y, z}},   /* upside down and mirrored */
        {{0, 1}, {1, 0}, {-y, x, z}},   /* turned */
        {{0, -1}, {1, 0}, {y, x, z}},   /* turned and mirrored */
        /* S1 = 3 u + 3 v and S2 = -v / 2: where S2 stays, only u changes, so that t is x, and b is
         * y although S1 changes along it. */
        {{3, 0}, {3, -0.5}, {x, y, z}},
        {{1, 1}, {1, 1}, {0, 0, 1}}, /* no plane */
        {{0, 0}, {0, 0}, {0, 0, 1}},
    };
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    for (size_t i = 0; i < sizeof charts / sizeof *charts; ++i) {
        plate p = disc();
        p.material = "{\"normalTexture\":{\"index\":0}}";
        memcpy(p.u, charts[i].u, sizeof charts[i].u);
        memcpy(p.v, charts[i].v, sizeof charts[i].v);
        check_normal(&p, NULL, &view, charts[i].normal);
    }
    plate p = disc();
    p.material = "{\"normalTexture\":{\"index\":0,\"scale\":0.5}}";
    p.v[1] = -1;
    check_normal(&p, NULL, &view, (double[]){x / 2, y / 2, z});
    /* A quarter turn of the image: what was right is down. */
    p.material = "{\"normalTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
                 "{\"rotation\":1.5707963267948966}}}}";
    check_normal(&p, NULL, &view, (double[]){y, -x, z});
}

/* A mirrored node mirrors what the map shows, another scale of x changes its slope, and from behind
 * all of it is negated. */
static void test_placed_normals(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double wide[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    plate p = disc();
    p.v[1] = -1;
    p.material = "{\"doubleSided\":true,\"normalTexture\":{\"index\":0}}";
    check_normal(&p, mirror, &view, (double[]){-x, y, z});
    check_normal(&p, wide, &view, (double[]){x, y, z}); /* tangents are made unit */
    camera_look(&view, (double[]){0, 0, -20}, (double[]){0, 0, 0});
    /* The eye sees -x to its right and -z before it. */
    check_normal(&p, NULL, &view, (double[]){x, -y, z});
}

/* On a curved surface that rises towards +x, the tangent rises too. */
static void test_curved_normal(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    plate p = disc();
    p.v[1] = -1;
    p.material = "{\"normalTexture\":{\"index\":0}}";
    p.has_field = 1;
    p.fields[0] = -0.8; /* h = 0.4 u^2 */
    p.extension = STILL ",\"curved\":true";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    for (int px = SIZE / 4; px < 3 * SIZE / 4; ++px) {
        double slope = 0.8 * middle(px), c = 1 / sqrt(1 + slope * slope), s = slope * c;
        const double n[3] = {x * c - z * s, y, x * s + z * c};
        double length = sqrt(x * x + y * y + z * z);
        for (int i = 0; i < 3; ++i)
            assert_near((double)drawn.image.color[4 * (SIZE / 2 * SIZE + px) + i],
                        0.5 + 0.5 * n[i] / length, 2 * FLOAT_STEP);
    }
    picture_free(&drawn);
}

int test_reference_normal_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_placed_normals),
        cmocka_unit_test(test_curved_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
