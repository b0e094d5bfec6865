/* SPDX-License-Identifier: MIT
 *
 * test_reference_environment.c - tests environments and debug views of the reference rasteriser
 * (spec 5.6, eq. (9); psplat_shading) against closed forms, and eq. (9)'s a and b against a
 * quadrature over directions of light.
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

#define SIZE 16
/* The relative error of the quadratures, and of R, which is linear between texels. */
#define QUADRATURE 2e-3

typedef struct cube {
    float texels[6 * SIZE * SIZE * 3];
    psplat_environment_desc desc;
} cube;

/* Fills the cube with R = 1 + slope l, channel by channel: x, y and z of the direction are red,
 * green and blue. The directions of the texels are those of GL 4.6, section 8.13, solved for the
 * direction. */
static void cube_fill(cube *c, double slope) {
    for (int i = 0; i < 6 * SIZE * SIZE; ++i) {
        double s = (i % SIZE + 0.5) / SIZE * 2 - 1, t = (i / SIZE % SIZE + 0.5) / SIZE * 2 - 1;
        const double directions[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                         {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
        const double *l = directions[i / SIZE / SIZE];
        double length = sqrt(1 + s * s + t * t);
        for (int k = 0; k < 3; ++k) c->texels[3 * i + k] = (float)(1 + slope * l[k] / length);
    }
    c->desc = (psplat_environment_desc){c->texels, SIZE};
}

/* One pixel that sees a splat with this centre normal in the given direction. */
typedef struct study {
    psplat_asset *asset;
    psplat_view view;
    cube cube;
} study;

static void study_open(study *st, const psplat_material *material, const double normal[3],
                       double slope) {
    scene s = scene_disc(10);
    s.material = *material;
    for (int i = 0; i < 3; ++i) s.splats[0].normal[i] = (float)normal[i];
    st->asset = scene_open(&s);
    st->view = camera_view(1, 1);
    st->view.light_count = 0;
    camera_look(&st->view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_parallel(&st->view, 0.001, 1, 10);
    cube_fill(&st->cube, slope);
    scene_free(&s);
}

static void study_color(const study *st, double color[3]) {
    psplat_reference_scene scene = {.asset = st->asset, .environment = &st->cube.desc};
    picture p = picture_of_scene(&scene, &st->view);
    assert_int_equal(p.image.count[0], 1);
    for (int i = 0; i < 3; ++i) color[i] = (double)p.image.color[i];
    picture_free(&p);
}

static psplat_material material_of(float base, float metallic, float roughness) {
    return (psplat_material){
        .base_color = {base, base, base, 1}, .metallic = metallic, .roughness = roughness};
}

static void normalise(double a[3]) {
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* ---- eq. (9) --------------------------------------------------------------------------------- */

/* Computes a and b by a quadrature over l; e and n span the plane y = 0. */
static void split_sums(double normal_eye, double alpha, double sums[2]) {
    enum { rings = 1500, sectors = 720 };
    double e[3] = {sqrt(1 - normal_eye * normal_eye), 0, normal_eye}, a2 = alpha * alpha;
    sums[0] = sums[1] = 0;
    for (int k = 0; k < rings * sectors; ++k) {
        double nl = (k / sectors + 0.5) / rings,
               angle = (k % sectors + 0.5) / sectors * 2 * CAMERA_PI;
        double l[3] = {sqrt(1 - nl * nl) * cos(angle), sqrt(1 - nl * nl) * sin(angle), nl}, h[3];
        for (int i = 0; i < 3; ++i) h[i] = l[i] + e[i];
        normalise(h);
        double eh = e[0] * h[0] + e[2] * h[2], d = h[2] * h[2] * (a2 - 1) + 1;
        double smith = nl * sqrt(normal_eye * normal_eye * (1 - a2) + a2) +
                       normal_eye * sqrt(nl * nl * (1 - a2) + a2);
        double value =
            a2 / (CAMERA_PI * d * d) * 0.5 / smith * nl * 2 * CAMERA_PI / (rings * sectors);
        sums[0] += value * (1 - pow(1 - eh, 5));
        sums[1] += value * pow(1 - eh, 5);
    }
}

/* Under a constant R a metal of f0 reflects (f0 a + b) R, and a dielectric c_diff R more. */
static void test_constant(void **state) {
    (void)state;
    const float roughnesses[] = {0.4f, 0.7f, 1};
    const double normals[][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0, -0.954, 0.3}};
    for (int k = 0; k < 9; ++k) {
        double n[3], sums[2], color[3];
        for (int i = 0; i < 3; ++i) n[i] = normals[k / 3][i];
        normalise(n);
        double rough = (double)roughnesses[k % 3];
        split_sums(n[2], rough * rough, sums);
        for (int metallic = 0; metallic < 2; ++metallic) {
            psplat_material material = material_of(0.6f, (float)metallic, roughnesses[k % 3]);
            study st;
            study_open(&st, &material, n, 0);
            study_color(&st, color);
            double expected = metallic ? 0.6 * sums[0] + sums[1] : 0.6 + 0.04 * sums[0] + sums[1];
            for (int i = 0; i < 3; ++i) assert_near(color[i], expected, QUADRATURE);
            psplat_asset_destroy(st.asset);
        }
    }
}

/* The irradiance of R = 1 + l / 2 is pi + pi n / 3. This tests six faces, their order and their
 * orientation. */
static void test_diffuse(void **state) {
    (void)state;
    const double normals[][3] = {{0.3, 0.5, 0.8}, {-0.7, 0.2, 0.6}, {0.1, -0.9, 0.4}};
    psplat_material material = material_of(1, 0, 1), black = material_of(0, 0, 1);
    for (int k = 0; k < 3; ++k) {
        double n[3], color[3], without[3];
        for (int i = 0; i < 3; ++i) n[i] = normals[k][i];
        normalise(n);
        study st, dark; /* the dielectric's reflection does not depend on its colour */
        study_open(&st, &material, n, 0.5);
        study_open(&dark, &black, n, 0.5);
        study_color(&st, color);
        study_color(&dark, without);
        for (int i = 0; i < 3; ++i) assert_near(color[i] - without[i], 1 + n[i] / 3, QUADRATURE);
        psplat_asset_destroy(st.asset);
        psplat_asset_destroy(dark.asset);
    }
}

/* A polished white metal is a mirror: it shows R in the direction r, in scene space however the
 * view is turned. */
static void test_mirror(void **state) {
    (void)state;
    const double eyes[][3] = {{0, 0, 5}, {1, 2, 3}, {-2, 1, 3}, {2, -4, 3}, {0.1, 0.2, 6}};
    psplat_material material = material_of(1, 1, 0);
    for (int k = 0; k < 5; ++k) {
        double n[3] = {0.3, -0.2, 0.93}, e[3], color[3];
        normalise(n);
        study st;
        study_open(&st, &material, n, 0.5);
        camera_look(&st.view, eyes[k], (double[]){0, 0, 0});
        for (int i = 0; i < 3; ++i) e[i] = eyes[k][i];
        normalise(e);
        study_color(&st, color);
        double along = n[0] * e[0] + n[1] * e[1] + n[2] * e[2];
        for (int i = 0; i < 3; ++i)
            assert_near(color[i], 1 + 0.5 * (2 * along * n[i] - e[i]), QUADRATURE);
        psplat_asset_destroy(st.asset);
    }
}

/* A linear R keeps its form under any symmetric mean: it becomes 1 + k r, where k is the mean of
 * r.l. That is found by integrating D (r.h) (r.l) over half vectors at angles x to r. */
static void test_glossy(void **state) {
    (void)state;
    const double r[3] = {0, 0, 1};
    for (int k = 1; k <= 4; ++k) {
        double rough = k * 0.25, a2 = pow(rough, 4), sum = 0, mean = 0, color[3], dark[3];
        for (int i = 0; i < 100000; ++i) {
            double x = (i + 0.5) / 100000 * CAMERA_PI / 4, c = cos(x), d = c * c * (a2 - 1) + 1;
            double weight = sin(x) / (d * d) * c * cos(2 * x);
            sum += weight;
            mean += weight * cos(2 * x);
        }
        psplat_material material = material_of(1, 1, (float)rough);
        study st, even;
        study_open(&st, &material, r, 0.5);
        study_open(&even, &material, r, 0);
        study_color(&st, color);
        study_color(&even, dark);
        assert_near(color[0] / dark[0], 1, QUADRATURE);
        assert_near(color[2] / dark[2], 1 + 0.5 * mean / sum, QUADRATURE);
        psplat_asset_destroy(st.asset);
        psplat_asset_destroy(even.asset);
    }
}

/* ---- debug views ----------------------------------------------------------------------------- */

/* Shows two discs of different colours and normals, at distances 5 and 6, with equal weights. */
static void show(psplat_shading shading, psplat_mode mode, int linear, double color[3]) {
    scene s = scene_blank(2);
    s.depth_tolerance = 10;
    s.has_color = 1;
    s.material.base_color[2] = 0.5f;
    s.splats[1].center[2] = -1;
    for (int i = 0; i < 2; ++i) {
        s.splats[i].radius[0] = s.splats[i].radius[1] = 100;
        s.splats[i].color[i] = 0.25f;
        s.splats[i].normal[i] = 0.6f;
        s.splats[i].normal[2] = 0.8f;
    }
    psplat_view view = camera_view(1, 1);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_perspective(&view, 1, 1, 11);
    view.shading = shading;
    view.mode = mode;
    view.linear_output = linear;
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < 3; ++i) color[i] = (double)p.image.color[i];
    picture_free(&p);
    scene_free(&s);
}

static void check_shown(psplat_shading shading, psplat_mode mode, int linear, double red,
                        double green, double blue) {
    const double expected[3] = {red, green, blue};
    double color[3];
    show(shading, mode, linear, color);
    for (int i = 0; i < 3; ++i) assert_near(color[i], expected[i], 1e-5); /* colours have 16 bits */
}

static double encoded(double linear) {
    return 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static void test_debug_views(void **state) {
    (void)state;
    /* The eye is on the axis: weights are psi(0). Normals of eq. (2) have z = 1 and x, y = 3/4. */
    double length = sqrt(2 * 0.375 * 0.375 + 1), side = 0.5 + 0.5 * 0.375 / length;
    double tilted = 0.5 + 0.5 * 0.6, mean = 0.625, depth = 11 - 60.0 / 11;
    for (int linear = 0; linear < 2; ++linear)
        for (int mode = PSPLAT_MODE_PHONG; mode <= PSPLAT_MODE_GAUSSIAN; ++mode) {
            psplat_mode m = (psplat_mode)mode;
            check_shown(PSPLAT_SHADING_NORMAL, m, linear, side, side, 0.5 + 0.5 / length);
            check_shown(PSPLAT_SHADING_DEPTH, m, linear, depth / 10, depth / 10, depth / 10);
            check_shown(PSPLAT_SHADING_UNLIT, m, linear, linear ? mean : encoded(mean),
                        linear ? mean : encoded(mean), linear ? 0.5 : encoded(0.5));
            if (linear) check_shown(PSPLAT_SHADING_OVERDRAW, m, linear, 2, 2, 2);
        }
    check_shown(PSPLAT_SHADING_NORMAL, PSPLAT_MODE_FLAT, 0, tilted, 0.5, 0.9);
    check_shown(PSPLAT_SHADING_DEPTH, PSPLAT_MODE_FLAT, 0, 0.6, 0.6, 0.6);
    check_shown(PSPLAT_SHADING_UNLIT, PSPLAT_MODE_FLAT, 1, 0.25, 1, 0.5);
    check_shown(PSPLAT_SHADING_OVERDRAW, PSPLAT_MODE_FLAT, 1, 1, 1, 1);
}

int test_reference_environment_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant),    cmocka_unit_test(test_diffuse),
        cmocka_unit_test(test_mirror),      cmocka_unit_test(test_glossy),
        cmocka_unit_test(test_debug_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
