/* SPDX-License-Identifier: MIT
 *
 * test_agreement_shadow.c - tests shadow maps against shadows by rays of the reference rasteriser
 * (spec 5.6). A map knows its shadows to a texel and blurs their outlines over two texels. So only
 * pixels are compared that lie at least two pixels inside shadow or inside light; the number of
 * those that differ is bounded.
 */
#include "agreement.h"
#include "scene_asset.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define SIZE 96
#define MARGIN 2

typedef struct shadow_figures {
    size_t shadowed, lit, outline; /* pixels of the reference */
    size_t wrong;                  /* compared pixels in another state in the renderer */
} shadow_figures;

/* Returns the red channel of every pixel, as the renderer or the reference draws it. */
static double *draw_red(gpu *g, const psplat_asset *asset, psplat_view view, int by_reference) {
    double *red = calloc(SIZE * SIZE, sizeof *red);
    float *rgba = malloc(SIZE * SIZE * 4 * sizeof *rgba);
    psplat_error error;
    assert_true(red && rgba);
    if (by_reference) {
        picture p = picture_draw(asset, NULL, &view);
        memcpy(rgba, p.image.color, SIZE * SIZE * 4 * sizeof *rgba);
        picture_free(&p);
    } else {
        psplat_item item = {.model = NULL};
        const float clear[4] = {0, 0, 0, 0};
        assert_int_equal(psplat_model_create(g->renderer, asset, &item.model, NULL), 0);
        assert_int_equal(psplat_host_begin(g->host, SIZE, SIZE, 1, clear, &error), 0);
        assert_int_equal(psplat_draw(g->renderer, &view, &item, 1, &error), 0);
        assert_int_equal(psplat_host_read_float(g->host, rgba, &error), 0);
        psplat_model_destroy(g->renderer, item.model);
    }
    for (int i = 0; i < SIZE * SIZE; ++i) red[i] = (double)rgba[4 * i];
    free(rgba);
    return red;
}

/* Returns whether a pixel and those around it lose the same light to shadows, up to a twentieth of
 * what a light sends at a right angle. */
static int is_inside(const double *lost, int x, int y) {
    for (int dy = -MARGIN; dy <= MARGIN; ++dy)
        for (int dx = -MARGIN; dx <= MARGIN; ++dx) {
            int u = x + dx, v = y + dy;
            if (u < 0 || v < 0 || u >= SIZE || v >= SIZE) continue;
            if (fabs(lost[v * SIZE + u] - lost[y * SIZE + x]) > 0.05) return 0;
        }
    return 1;
}

static shadow_figures measure(gpu *g, const scene *s, const psplat_view *view) {
    psplat_view bright = *view;
    shadow_figures f = {0};
    psplat_asset *asset = scene_open(s);
    for (int i = 0; i < bright.light_count; ++i) bright.lights[i].casts_shadow = 0;
    double *with = draw_red(g, asset, *view, 1), *lost = draw_red(g, asset, bright, 1);
    double *ours = draw_red(g, asset, *view, 0);
    for (int i = 0; i < SIZE * SIZE; ++i) lost[i] -= with[i];
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (!is_inside(lost, i % SIZE, i / SIZE)) {
            ++f.outline;
            continue;
        }
        f.shadowed += lost[i] > 0.05;
        f.lit += lost[i] < 0.05 && with[i] > 0.05;
        f.wrong += fabs(ours[i] - with[i]) > 0.05;
    }
    free(with);
    free(lost);
    free(ours);
    psplat_asset_destroy(asset);
    return f;
}

static void check(gpu *g, const char *name, const scene *s, const psplat_view *view) {
    shadow_figures f = measure(g, s, view);
    print_message("%-36s shadowed %5zu lit %5zu outline %4zu wrong %zu\n", name, f.shadowed, f.lit,
                  f.outline, f.wrong);
    assert_true(f.shadowed > 100 && f.lit > 1000);
    assert_int_equal(f.wrong, 0);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

/* Looks from the side at the middle of the scene. */
static psplat_view view_of(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    view.no_filter = 0;
    camera_look(&view, (double[]){3, 2, 6}, (double[]){0, 0, 0.5});
    camera_perspective(&view, 150, 3, 12);
    view.lights[0].direction[0] = 0.6f;
    view.lights[0].direction[1] = 0.3f;
    view.lights[0].direction[2] = -1;
    view.lights[0].casts_shadow = 1;
    return view;
}

/* Adds a floor: a square of two by two splats at z = -0.6, each cut by four lines. */
static scene with_floor(scene s) {
    const float half = 1, radius = 1.5f;
    s.splats = realloc(s.splats, (s.count + 4) * sizeof *s.splats);
    for (int k = 0; k < 4; ++k) {
        psplat_splat splat = {.rotation = {0, 0, 0, 1}, .normal = {0, 0, 1}, .color = {1, 1, 1, 1}};
        splat.center[0] = k % 2 ? half : -half;
        splat.center[1] = k / 2 ? half : -half;
        splat.center[2] = -0.6f;
        splat.radius[0] = splat.radius[1] = radius;
        splat.clip_count = 4;
        for (int i = 0; i < 4; ++i) {
            splat.clip[i][i / 2] = i % 2 ? -1.0f : 1.0f;
            splat.clip[i][2] = half / radius;
        }
        s.splats[s.count++] = splat;
    }
    s.material.double_sided = 1;
    return s;
}

static scene cube_over_floor(void) {
    return with_floor(scene_cube(0.4f));
}

static scene sphere_over_floor(size_t count) {
    scene s = with_floor(scene_sphere(count, 0.5f));
    s.material.double_sided = 0;
    return s;
}

/* Returns the sphere with curved splats, as many as still show their curvature. */
static scene curved_over_floor(int is_two_sided) {
    scene s = scene_sphere(100, 0.5f);
    scene_curve(&s);
    s = with_floor(s);
    s.depth_tolerance = 0.004f;
    s.material.double_sided = is_two_sided;
    return s;
}

/* Shadow maps see both sides of curved splats, too. */
static void test_curved(void **state) {
    for (int sides = 0; sides < 2; ++sides) {
        psplat_view view = view_of();
        scene s = curved_over_floor(sides);
        check(*state, "curved sphere, directional light", &s, &view);
        view.lights[0].type = PSPLAT_LIGHT_SPOT;
        view.lights[0].outer_angle = 0.6f;
        view.lights[0].inner_angle = 0.55f;
        for (int i = 0; i < 3; ++i) {
            view.lights[0].position[i] = (double[]){-1.8, -0.9, 3}[i];
            view.lights[0].color[i] *= 13;
        }
        check(*state, "curved sphere, spot light", &s, &view);
        scene_free(&s);
    }
}

static void test_directional(void **state) {
    psplat_view view = view_of();
    scene s = cube_over_floor();
    check(*state, "cube under a directional light", &s, &view);
    scene_free(&s);
    s = sphere_over_floor(300);
    check(*state, "sphere under a directional light", &s, &view);
    view.shadow_size = 256;
    check(*state, " map of 256 texels", &s, &view);
    scene_free(&s);
}

static void test_spot(void **state) {
    psplat_view view = view_of();
    view.lights[0].type = PSPLAT_LIGHT_SPOT;
    view.lights[0].outer_angle = 0.6f;
    view.lights[0].inner_angle = 0.55f;
    for (int i = 0; i < 3; ++i) {
        view.lights[0].position[i] = (double[]){-1.8, -0.9, 3}[i];
        view.lights[0].color[i] *= 13;
    }
    scene s = cube_over_floor();
    check(*state, "cube under a spot light", &s, &view);
    scene_free(&s);
    s = sphere_over_floor(300);
    check(*state, "sphere under a spot light", &s, &view);
    scene_free(&s);
}

/* Four shadows fall at once, from four sides and lights of two kinds. */
static void test_four(void **state) {
    psplat_view view = view_of();
    view.light_count = PSPLAT_MAX_SHADOWS;
    for (int k = 0; k < PSPLAT_MAX_SHADOWS; ++k) {
        psplat_light *light = &view.lights[k];
        *light = view.lights[0];
        light->direction[0] = k % 2 ? 0.7f : -0.7f;
        light->direction[1] = k / 2 ? 0.7f : -0.7f;
        if (k < 2) continue;
        light->type = PSPLAT_LIGHT_SPOT;
        for (int i = 0; i < 3; ++i) {
            light->position[i] = -3 * (double)light->direction[i];
            light->color[i] *= 9;
        }
    }
    scene s = cube_over_floor();
    check(*state, "cube under four lights", &s, &view);
    scene_free(&s);
}

/* Maps hold depth in the host's range, as the pixels do that they are compared with. */
static void test_depth_range(void **state) {
    gpu *g = *state;
    psplat_view view = view_of();
    void *address = psplat_host_get_proc(g->host, "glDepthRangef");
    void (*depth_range)(float near, float far);
    memcpy(&depth_range, &address, sizeof address);
    scene s = cube_over_floor();
    depth_range(0.25f, 0.75f);
    check(g, "cube, depth from 0.25 to 0.75", &s, &view);
    depth_range(0, 1);
    scene_free(&s);
}

/* A million units away the lights' spaces, too, have to be composed in double. */
static void test_far_from_origin(void **state) {
    const double at[3] = {1e6, -2e6, 3e6};
    psplat_view view = view_of();
    scene s = cube_over_floor();
    camera_look(&view, (double[]){at[0] + 3, at[1] + 2, at[2] + 6},
                (double[]){at[0], at[1], at[2] + 0.5});
    memcpy(s.origin, at, sizeof at);
    check(*state, "cube, 4e6 from the origin", &s, &view);
    view.lights[0].type = PSPLAT_LIGHT_SPOT;
    view.lights[0].outer_angle = 0.6f;
    for (int i = 0; i < 3; ++i) {
        view.lights[0].position[i] = at[i] + (double[]){-1.8, -0.9, 3}[i];
        view.lights[0].color[i] *= 13;
    }
    check(*state, "cube, 4e6 from the origin, spot", &s, &view);
    scene_free(&s);
}

int test_agreement_shadow_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directional), cmocka_unit_test(test_curved),
        cmocka_unit_test(test_spot),        cmocka_unit_test(test_four),
        cmocka_unit_test(test_depth_range), cmocka_unit_test(test_far_from_origin),
    };
    const struct CMUnitTest gles_tests[] = {cmocka_unit_test(test_four)};
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
