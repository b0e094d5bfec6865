/* SPDX-License-Identifier: MIT
 *
 * test_extremes_depth.c - tests depth where it is hard to distinguish: near and far planes 1e7
 * apart, models far away, splats of one plane at a tolerance of 0, and surfaces close to each
 * other.
 */
#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "extreme_view.h"

/* Looks from a distance along -z, so that a unit is 40 pixels. */
static void see_from(extreme *e, double distance, double near, double far) {
    camera_look(&e->view, (double[]){0, 0, distance}, (double[]){0, 0, 0});
    camera_perspective(&e->view, 40 * distance, near, far);
}

/* ---- surfaces close to each other ----------------------------------------------------------- */

/* Depths between the view's own planes do not matter here: no pixel is left out for a depth tie. */
static const agreement_ties edges = {2e-4, 0, 0};

/* Returns a white disc a hundredth of its size before a red one, at a tolerance of a fifth of
 * that. */
static extreme sheets(void) {
    extreme e = extreme_of(scene_blank(2));
    e.s.has_color = 1;
    e.s.depth_tolerance = 0.002f;
    e.s.splats[1].center[2] = -0.01f;
    e.s.splats[1].color[1] = e.s.splats[1].color[2] = 0;
    return e;
}

/* With the planes of the view, a step of the depth buffer is a third of the discs' distance at
 * 3000, and the red disc would shine through from 10 on. */
static void test_far_over_near(void **state) {
    const double distances[] = {0.5, 3, 30, 300, 3000};
    for (int k = 0; k < 5; ++k) {
        char name[64];
        extreme e = sheets();
        see_from(&e, distances[k], 1e-3, 1e4);
        snprintf(name, sizeof name, "far / near 1e7, two sheets at %g", distances[k]);
        extreme_check(*state, name, &e, (extreme_bounds){.least = 4 * 4000, .ties = edges});
    }
}

static void test_infinite_far(void **state) {
    extreme e = sheets();
    see_from(&e, 1000, 1e-3, 1e4);
    e.view.projection[10] = -1;
    e.view.projection[14] = -2e-3;
    extreme_check(*state, "far plane at infinity, two sheets at 1e6 near", &e,
                  (extreme_bounds){.least = 4 * 4000, .ties = edges});
}

static void test_parallel(void **state) {
    extreme e = sheets();
    camera_look(&e.view, (double[]){0, 0, 3000}, (double[]){0, 0, 0});
    camera_parallel(&e.view, 1.5, 1e-3, 1e4);
    extreme_check(*state, "orthographic, far / near 1e7, two sheets", &e,
                  (extreme_bounds){.least = 4 * 4000, .ties = edges});
}

static double *read_depth(gpu *g, const psplat_asset *asset, const psplat_view *view) {
    size_t count = (size_t)view->width * (size_t)view->height;
    float *depth = malloc(count * sizeof *depth);
    double *result = malloc(count * sizeof *result);
    psplat_item item = {.model = NULL};
    psplat_error error;
    assert_int_equal(psplat_model_create(g->renderer, asset, &item.model, &error), PSPLAT_OK);
    assert_int_equal(
        psplat_host_begin(g->host, view->width, view->height, 1, (float[4]){0}, &error), 0);
    assert_int_equal(psplat_draw(g->renderer, view, &item, 1, &error), 0);
    assert_int_equal(psplat_host_read_depth(g->host, depth, &error), 0);
    for (size_t i = 0; i < count; ++i) result[i] = (double)depth[i];
    psplat_model_destroy(g->renderer, item.model);
    free(depth);
    return result;
}

/* One model lies before the eye and one far behind: what is drawn needs planes of a ratio of
 * 1e4. */
static void test_two_models(void **state) {
    gpu *g = *state;
    enum { SIZE = 64 };
    psplat_error error;
    psplat_model *model = NULL;
    extreme e = sheets();
    psplat_asset *asset = scene_open(&e.s);
    assert_int_equal(psplat_model_create(g->renderer, asset, &model, NULL), PSPLAT_OK);
    e.view.width = e.view.height = SIZE;
    camera_look(&e.view, (double[]){0, 0, 0}, (double[]){0, 0, -1});
    camera_perspective(&e.view, 60, 1e-3, 1e4);
    e.view.shading = PSPLAT_SHADING_UNLIT;
    psplat_item items[2] = {{.model = model}, {.model = model}};
    const double at[2][4] = {{1, -0.9, 0, -3}, {300, 300, 0, -900}}; /* scale, x, y, z */
    for (int k = 0; k < 2; ++k) {
        for (int i = 0; i < 3; ++i) items[k].transform[5 * i] = at[k][0];
        for (int i = 0; i < 3; ++i) items[k].transform[12 + i] = at[k][1 + i];
        items[k].transform[15] = 1;
    }
    float *rgba = malloc(sizeof(float) * 4 * SIZE * SIZE), most = 0;
    int covered = 0;
    assert_int_equal(psplat_host_begin(g->host, SIZE, SIZE, 1, (float[4]){0}, &error), 0);
    assert_int_equal(psplat_draw(g->renderer, &e.view, items, 2, &error), 0);
    assert_int_equal(psplat_host_read_float(g->host, rgba, &error), 0);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (rgba[4 * i + 3] == 0) continue;
        most = fmaxf(most, 1 - rgba[4 * i + 1]);
        ++covered;
    }
    assert_true(covered > 1000);
    extreme_at_most("far / near 1e7, models at 3 and at 900", (double)most, "of red", 1e-6);
    free(rgba);
    psplat_model_destroy(g->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&e.s);
}

/* Window depths in the host's buffer are right in any depth range that the host sets. */
static void test_depth_range(void **state) {
    gpu *g = *state;
    const float ranges[][2] = {{0, 1}, {0.25f, 0.75f}, {0.5f, 0.5f}};
    void *address = psplat_host_get_proc(g->host, "glDepthRangef");
    void (*depth_range)(float near, float far);
    memcpy(&depth_range, &address, sizeof address);
    double most = 0;
    for (int k = 0; k < 3; ++k) {
        extreme e = sheets();
        see_from(&e, 30, 1, 100);
        psplat_asset *asset = scene_open(&e.s);
        picture p = picture_draw(asset, NULL, &e.view);
        depth_range(ranges[k][0], ranges[k][1]);
        double *depth = read_depth(g, asset, &e.view);
        depth_range(0, 1);
        double near = (double)ranges[k][0], far = (double)ranges[k][1];
        for (int i = 0; i < p.width * p.height; ++i)
            if (p.image.count[i] && p.image.tie[i] > 2e-4)
                most = fmax(most, fabs(depth[i] - near - (far - near) * p.image.depth[i]));
        free(depth);
        picture_free(&p);
        psplat_asset_destroy(asset);
        scene_free(&e.s);
    }
    extreme_at_most("depth ranges of the host", most, "of the depth range", 2e-7);
}

/* ---- splats of one plane -------------------------------------------------------------------- */

/* Returns discs in the plane z = 0 that are turned within it, with random centres: each pixel sees
 * some twenty. */
static scene carpet(float tolerance) {
    enum { COUNT = 200 };
    scene s = scene_blank(COUNT);
    uint32_t random = 99;
    for (int i = 0; i < COUNT; ++i) {
        double angle = 6.28 * (double)scene_random(&random);
        scene_set_axes(&s.splats[i], (double[]){cos(angle), sin(angle), 0},
                       (double[]){-sin(angle), cos(angle), 0});
        for (int k = 0; k < 2; ++k) {
            s.splats[i].center[k] = 2 * scene_random(&random) - 1;
            s.splats[i].radius[k] = 0.4f;
        }
    }
    s.depth_tolerance = tolerance;
    return s;
}

/* Counts pixels in which not all splats of the plane blend, which the number of splats shows. */
static agreement count_splats(gpu *g, extreme *e) {
    psplat_asset *asset = scene_open(&e->s);
    e->view.mode = PSPLAT_MODE_PHONG;
    e->view.shading = PSPLAT_SHADING_OVERDRAW;
    agreement a = agreement_measure(g, asset, e->transform, &e->view, 1, &edges);
    psplat_asset_destroy(asset);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.covered - a.skipped > 1000);
    return a;
}

/* Looks straight and at a slant, from half a radius to ten thousand. Beyond 80 degrees an error
 * across the view ray counts more than six times along it, so that some splats are left out
 * there. */
static void check_plane(gpu *g, const char *name, double slant, double near, double far) {
    const double distances[] = {1.5, 5, 100, 1e4};
    double most = 0;
    for (int k = 0; k < 4; ++k) {
        extreme e = extreme_of(carpet(0));
        double distance = distances[k];
        camera_look(&e.view, (double[]){distance * sin(slant), 0.01, distance * cos(slant)},
                    (double[]){0, 0, 0});
        camera_perspective(&e.view, 40 * distance, near * distance, far * distance);
        agreement a = count_splats(g, &e);
        most = a.color <= most ? most : a.color;
        scene_free(&e.s);
    }
    extreme_at_most(name, most, "of some 20 splats missing in a pixel", 0);
}

static void test_one_plane(void **state) {
    const double degrees[] = {0, 45, 80};
    for (int k = 0; k < 6; ++k) {
        char name[64];
        double slant = degrees[k % 3] * CAMERA_PI / 180;
        snprintf(name, sizeof name, "epsilon 0, one plane at %g degrees, far / near %s",
                 degrees[k % 3], k < 3 ? "20" : "1e7");
        check_plane(*state, name, slant, k < 3 ? 0.2 : 1e-4, k < 3 ? 4 : 1e3);
    }
}

int test_extremes_depth_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_far_over_near), cmocka_unit_test(test_infinite_far),
        cmocka_unit_test(test_parallel),      cmocka_unit_test(test_two_models),
        cmocka_unit_test(test_depth_range),   cmocka_unit_test(test_one_plane),
    };
    return cmocka_run_group_tests(tests, gpu_setup_gl, gpu_teardown);
}
