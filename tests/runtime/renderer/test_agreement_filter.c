/* SPDX-License-Identifier: MIT
 *
 * test_agreement_filter.c - tests that with the screen-space filter (spec 5.8) the renderer draws
 * what the reference rasteriser draws: splats from many pixels to far below one, with clip lines,
 * in all kinds of views.
 */
#include "agreement.h"
#include "scene_asset.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#define WIDTH 160
#define HEIGHT 120

/* As in test_agreement.c. */
static const agreement_ties ordinary = {2e-4, 2e-6, 0.015};

/* The bounds of differences of a scene: of window depth and of colour. */
typedef struct tolerances {
    double depth, color;
    double skipped; /* share of covered pixels, as otherwise too little would be compared */
} tolerances;

static const tolerances strict = {1e-6, 1e-4, 0.1};
/* The depth of a slanted splat that is widened to a pixel changes by its whole extent in a pixel.
 * Each 1e-4 of a pixel's position error counts, as where splats show in single pixels in
 * test_agreement.c. */
static const tolerances slanted = {2e-5, 1e-4, 0.25};
/* A pixel has hundreds of splats, and mostly one of them is near an edge. Rasterisers round corners
 * to 1/256 of a pixel and may lose a pixel at the rim, where a splat weighs least. */
static const tolerances crowded = {5e-5, 2e-4, 0.75};

static void assert_agrees(const char *name, const agreement *a, const tolerances *allowed,
                          size_t least) {
    print_message("%-32s covered %6zu skipped %4zu depth %.1e color %.1e\n", name, a->covered,
                  a->skipped, a->depth, a->color);
    assert_true(a->covered >= least);
    assert_true((double)a->skipped <= allowed->skipped * (double)a->covered);
    assert_int_equal(a->mismatches, 0);
    assert_true(a->depth <= allowed->depth);
    assert_true(a->color <= allowed->color);
}

/* Looks from (1, 2, 3) times the distance that makes a sphere of radius 1 this wide. */
static psplat_view view_of(double pixels, int is_parallel) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    const float light[3] = {1, 0.5f, 2}, color[3] = {2.5f, 2, 1.5f};
    view.no_filter = 0;
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, pixels / 2 * sqrt(14), 1, 8);
    if (is_parallel) camera_parallel(&view, HEIGHT / pixels, 1, 8);
    for (int i = 0; i < 3; ++i) {
        view.lights[0].direction[i] = -light[i];
        view.lights[0].color[i] = color[i];
        view.ambient[i] = 0.1f;
    }
    return view;
}

static void check(gpu *g, const char *name, const scene *s, const double transform[16],
                  psplat_view view, const tolerances *allowed, size_t least) {
    psplat_asset *asset = scene_open(s);
    for (int mode = PSPLAT_MODE_PHONG; mode <= PSPLAT_MODE_GAUSSIAN; ++mode) {
        view.mode = (psplat_mode)mode;
        agreement a = agreement_measure(g, asset, transform, &view, 1, &ordinary);
        assert_agrees(mode ? " gaussian" : name, &a, allowed, least);
    }
    psplat_asset_destroy(asset);
}

/* Splats have radii of 9.6, 2.8, 0.9 and a tenth of a pixel. */
static void test_spheres(void **state) {
    const struct {
        size_t count;
        double pixels;
        const char *name;
        const tolerances *allowed;
    } spheres[] = {{400, 110, "sphere, splats of 9 px", &strict},
                   {4000, 110, "sphere, splats of 2.8 px", &strict},
                   {10000, 55, "sphere, splats of 0.9 px", &strict},
                   {20000, 8.5, "sphere, splats of 0.1 px", &crowded}};
    for (int k = 0; k < 4; ++k) {
        scene s = scene_sphere(spheres[k].count, 1);
        s.material.metallic = 0.3f;
        size_t least = (size_t)(spheres[k].pixels * spheres[k].pixels * 0.7);
        for (int parallel = 0; parallel < 2; ++parallel)
            check(*state, parallel ? " parallel" : spheres[k].name, &s, NULL,
                  view_of(spheres[k].pixels, parallel), spheres[k].allowed, least);
        scene_free(&s);
    }
}

/* Ellipses with axes of 1 to 10 and 0 to 4 clip lines go from large to far below a pixel. */
static void test_ellipses(void **state) {
    const double pixels[] = {150, 40, 12, 6};
    const size_t least[] = {5000, 1000, 60, 15};
    for (int k = 0; k < 8; ++k) {
        char name[64];
        scene s = scene_ellipses(200, 4, 7);
        psplat_view view = view_of(pixels[k / 2], k % 2);
        s.material.double_sided = k / 2 % 2;
        snprintf(name, sizeof name, "ellipses over %g px%s", pixels[k / 2],
                 k % 2 ? ", parallel" : "");
        check(*state, name, &s, NULL, view, &slanted, least[k / 2]);
        s.kernel = (psplat_kernel){4, 1.5f};
        s.depth_tolerance = 0.2f;
        check(*state, " sharper, deeper", &s, NULL, view, &slanted, least[k / 2]);
        scene_free(&s);
    }
}

/* Draws a cube of six splats: creases are two soft clip lines that meet. At 20 pixels a face is
 * so slanted that depth changes by 0.14 a pixel: each 1e-5 of a pixel's position error counts
 * 1.4e-6. */
static void test_cube(void **state) {
    const double pixels[] = {100, 20, 5};
    const tolerances steep = {2e-6, 1e-4, 0.1};
    for (int k = 0; k < 3; ++k) {
        scene s = scene_cube(0.8f);
        check(*state, "cube of 6 splats", &s, NULL, view_of(pixels[k], 0),
              k == 1 ? &steep : &strict, (size_t)(pixels[k] * pixels[k] * 0.7));
        scene_free(&s);
    }
}

static void test_transforms(void **state) {
    const double stretched[16] = {1.2, 0, 0, 0, 0.3, 0.7, 0, 0, 0, 0.2, 1, 0, 0.1, 0, 0, 1};
    const double mirrored[16] = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double flat[16] = {1, 0, 0, 0, 0, 0.05, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double *transforms[] = {stretched, mirrored, flat};
    const char *names[] = {"ellipses, sheared", "ellipses, mirrored", "ellipses, flattened"};
    for (int k = 0; k < 3; ++k) {
        scene s = scene_ellipses(300, 2, 3);
        check(*state, names[k], &s, transforms[k], view_of(25, k == 2), &slanted, 250);
        scene_free(&s);
    }
}

/* Before the near plane, and for splats that are large against their distance, the filter stops;
 * the view has splats of both kinds. */
static void test_close(void **state) {
    scene s = scene_ellipses(300, 2, 9);
    psplat_view view = view_of(60, 0);
    s.material.double_sided = 1;
    camera_look(&view, (double[]){-0.4, 0.3, 0.9}, (double[]){0, 0, 0});
    camera_perspective(&view, 20, 0.2, 4);
    agreement_ties ties = ordinary;
    ties.epsilon = 0.1; /* as for near views in test_agreement.c */
    psplat_asset *asset = scene_open(&s);
    agreement a = agreement_measure(*state, asset, NULL, &view, 1, &ties);
    assert_agrees("ellipses, from among them", &a, &slanted, 4000);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Draws discs from 0.01 of a pixel to 40 pixels, turned to within a tenth of a degree of
 * edge-on. */
static void test_edge_on(void **state) {
    const double radii[] = {0.01, 0.3, 0.9, 3, 40}, degrees[] = {80, 89, 89.9, 90.1, 95};
    for (int k = 0; k < 25; ++k) {
        char name[64];
        double angle = degrees[k % 5] * CAMERA_PI / 180, n[3] = {0, -sin(angle), cos(angle)};
        /* Ten pixels a unit, before a disc that fills the view. */
        scene s = scene_blank(2), disc = scene_disc((float)(radii[k / 5] / 10));
        s.splats[0] = disc.splats[0];
        s.splats[1].radius[0] = s.splats[1].radius[1] = 20;
        s.splats[1].center[2] = -2;
        s.depth_tolerance = 3;
        s.material.double_sided = 1;
        scene_free(&disc);
        scene_set_axes(&s.splats[0], (double[]){1, 0, 0}, (double[]){0, cos(angle), sin(angle)});
        for (int i = 0; i < 3; ++i) s.splats[0].normal[i] = (float)n[i];
        s.splats[0].center[0] = 0.013f, s.splats[0].center[1] = 0.027f;
        psplat_view view = view_of(20, 0);
        camera_look(&view, (double[]){0, 0, 30}, (double[]){0, 0, 0});
        camera_perspective(&view, 300, 5, 60);
        snprintf(name, sizeof name, "disc of %g px, %g degrees", radii[k / 5], degrees[k % 5]);
        check(*state, name, &s, NULL, view, &strict, radii[k / 5] > 10 ? 80 : 3);
        scene_free(&s);
    }
}

/* ---- anything ------------------------------------------------------------------------------- */

static double between(uint32_t *random, double low, double high) {
    return low + (high - low) * (double)scene_random(random);
}

/* Returns a view from a distance of 2.5 to 6, with 5 to 300 pixels a radian or a unit, whose near
 * and far planes may cut splats. */
static psplat_view random_view(uint32_t *random) {
    psplat_view view = camera_view(80, 60);
    double eye[3], length = 0, distance = between(random, 2.5, 6);
    for (int i = 0; i < 3; ++i) {
        eye[i] = between(random, -1, 1);
        length += eye[i] * eye[i];
    }
    for (int i = 0; i < 3; ++i) eye[i] *= distance / sqrt(length);
    camera_look(&view, eye, (double[]){between(random, -0.3, 0.3), 0, 0});
    double near = between(random, 0.05, 0.6), far = near + between(random, 2, 12);
    camera_perspective(&view, pow(10, between(random, 0.7, 2.5)), near, far);
    if (scene_random(random) < 0.4f)
        camera_parallel(&view, pow(10, between(random, -0.5, 1.5)), -1, 12);
    view.mode = scene_random(random) < 0.5f ? PSPLAT_MODE_PHONG : PSPLAT_MODE_GAUSSIAN;
    view.culling = (psplat_culling)between(random, 0, 2.99);
    view.no_filter = 0;
    return view;
}

/* Makes a matrix that scales by 0.5 to 1.5, shears and mirrors. */
static void random_transform(uint32_t *random, double m[16]) {
    for (int i = 0; i < 16; ++i) m[i] = i % 4 == 3 || i > 11 ? 0 : between(random, -0.4, 0.4);
    for (int i = 0; i < 3; ++i)
        m[5 * i] = between(random, 0.5, 1.5) * (scene_random(random) < 0.3f ? -1 : 1);
    m[15] = 1;
}

static void test_random_views(void **state) {
    uint32_t random = 2005;
    agreement all = {0};
    agreement_ties ties = ordinary;
    ties.epsilon = 0.15; /* radii are up to a fifth of the distance: (2 / 5)^2 of epsilon */
    for (int k = 0; k < 200; ++k) {
        double transform[16];
        scene s = scene_ellipses((size_t)between(&random, 20, 300), 4, (uint32_t)k + 1);
        s.depth_tolerance = (float)pow(10, between(&random, -4, -0.5));
        s.material.double_sided = scene_random(&random) < 0.5f;
        random_transform(&random, transform);
        psplat_view view = random_view(&random);
        psplat_asset *asset = scene_open(&s);
        agreement a = agreement_measure(*state, asset, transform, &view, 1, &ties);
        agreement_add(&all, &a);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    const tolerances allowed = {1e-4, 1e-3,
                                0.1}; /* some needles are within 0.1 degrees of edge-on */
    assert_agrees("200 random views", &all, &allowed, 50000);
}

/* The shaders of GLES are the same except for their prelude, so that a part of the tests is enough
 * there. */
int test_agreement_filter_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_spheres),      cmocka_unit_test(test_ellipses),
        cmocka_unit_test(test_cube),         cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_close),        cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_random_views),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_transforms),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
