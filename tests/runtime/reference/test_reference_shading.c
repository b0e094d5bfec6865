/* SPDX-License-Identifier: MIT
 *
 * test_reference_shading.c - tests eq. (7) of the specification as the reference rasteriser
 * computes it, through one-pixel images of a splat that fills them. Expected values come from the
 * same material written down independently: distribution and masking by tangents as in Walter et
 * al. 2007 and Heitz 2014, radiance by Schlick 1994.
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

/* The image stores floats. */
#define FLOAT_STEP 1.2e-7

typedef struct study {
    psplat_asset *asset;
    psplat_view view; /* one pixel, parallel, along -z */
} study;

static study study_open(const psplat_material *material, const double normal[3]) {
    scene s = scene_disc(10);
    s.material = *material;
    for (int i = 0; i < 3; ++i) s.splats[0].normal[i] = (float)normal[i];
    study result = {scene_open(&s), camera_view(1, 1)};
    camera_look(&result.view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_parallel(&result.view, 1, 1, 10);
    scene_free(&s);
    return result;
}

static void study_light(study *st, const double direction[3], double irradiance) {
    for (int i = 0; i < 3; ++i) {
        st->view.lights[0].direction[i] = (float)-direction[i];
        st->view.lights[0].color[i] = (float)irradiance;
    }
}

static void study_color(const study *st, double color[3]) {
    picture p = picture_draw(st->asset, NULL, &st->view);
    for (int i = 0; i < 3; ++i) color[i] = (double)p.image.color[i];
    picture_free(&p);
}

static void study_close(study *st) {
    psplat_asset_destroy(st->asset);
}

static psplat_material material_of(const float base[3], float metallic, float roughness) {
    return (psplat_material){
        .base_color = {base[0], base[1], base[2], 1}, .metallic = metallic, .roughness = roughness};
}

/* ---- the material by tangents --------------------------------------------------------------- */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void direction_of(double azimuth, double elevation, double out[3]) {
    out[0] = cos(elevation) * cos(azimuth);
    out[1] = cos(elevation) * sin(azimuth);
    out[2] = sin(elevation);
}

/* Heitz 2014, eq. 72: Lambda of the GGX distribution. */
static double lambda(double cosine, double alpha) {
    double tangent = tan(acos(cosine));
    return (sqrt(1 + alpha * alpha * tangent * tangent) - 1) / 2;
}

/* Walter et al. 2007, eq. 33. */
static double ggx(double cosine, double alpha) {
    double tangent = tan(acos(fmin(cosine, 1)));
    double k = alpha * alpha + tangent * tangent;
    return alpha * alpha / (CAMERA_PI * pow(cosine, 4) * k * k);
}

/* Computes the specular reflection without its Fresnel factor; *cosine becomes e.h. */
static double lobe(const double n[3], const double l[3], const double e[3], double alpha,
                   double *cosine) {
    double h[3], length = 0;
    for (int i = 0; i < 3; ++i) h[i] = l[i] + e[i];
    length = sqrt(dot(h, h));
    for (int i = 0; i < 3; ++i) h[i] /= length;
    *cosine = dot(e, h);
    double nl = dot(n, l), ne = dot(n, e);
    double shadowing = 1 / (1 + lambda(nl, alpha) + lambda(ne, alpha));
    return ggx(dot(n, h), alpha) * shadowing / (4 * nl * ne);
}

/* These return the radiance for irradiance pi: of a dielectric of index 1.5 (F0 = 0.04) and of a
 * metal. */
static double dielectric(double base, double nl, double specular, double cosine) {
    double fresnel = 0.04 + 0.96 * pow(1 - cosine, 5);
    return CAMERA_PI * nl * ((1 - fresnel) * base / CAMERA_PI + fresnel * specular);
}

static double metal(double base, double nl, double specular, double cosine) {
    return CAMERA_PI * nl * (base + (1 - base) * pow(1 - cosine, 5)) * specular;
}

static void test_metallic_roughness(void **state) {
    (void)state;
    const float base[3] = {1, 0.5f, 0.1f}, roughnesses[] = {0.1f, 0.5f, 1};
    const double n[3] = {0.28, 0, 0.96}, e[3] = {0, 0, 1};
    for (int r = 0; r < 3; ++r)
        for (int m = 0; m < 2; ++m) {
            psplat_material material = material_of(base, (float)m, roughnesses[r]);
            study st = study_open(&material, n);
            for (int k = 0; k < 12; ++k) {
                double l[3], color[3], cosine = 0;
                direction_of(k * 0.6, 0.5 + 0.08 * k, l);
                double rough = (double)roughnesses[r];
                double specular = lobe(n, l, e, fmax(rough * rough, 0.002), &cosine);
                study_light(&st, l, CAMERA_PI);
                study_color(&st, color);
                for (int i = 0; i < 3; ++i) {
                    double expected =
                        (m ? metal : dielectric)((double)base[i], dot(n, l), specular, cosine);
                    /* Directions are floats (6e-8); at alpha = 0.01 the lobe falls by its own
                     * height within 0.01 rad. */
                    assert_near(color[i], expected, 1e-6 + 5e-5 * fabs(expected) / rough * 0.1);
                }
            }
            study_close(&st);
        }
}

/* Between metal and dielectric, c_diff and f0 are mixed, not the results. */
static void test_half_metal(void **state) {
    (void)state;
    const float base[3] = {0.8f, 0.4f, 0.2f};
    const double n[3] = {0, 0, 1};
    psplat_material material = material_of(base, 0.5f, 1);
    study st = study_open(&material, n);
    double color[3];
    study_light(&st, n, CAMERA_PI);
    study_color(&st, color);
    for (int i = 0; i < 3; ++i) {
        /* All vectors are equal: D = 1 / pi, V = 1/4, F = f0. */
        double f0 = (0.04 + (double)base[i]) / 2, diffuse = (double)base[i] / 2;
        assert_near(color[i], (1 - f0) * diffuse + f0 / 4, FLOAT_STEP);
    }
    study_close(&st);
}

static void test_ambient_and_emissive(void **state) {
    (void)state;
    psplat_material material = material_of((const float[]){0.8f, 0.4f, 0.2f}, 0.25f, 0.5f);
    material.emissive[1] = 0.125f;
    const double n[3] = {0, 0, 1};
    study st = study_open(&material, n);
    double color[3];
    study_light(&st, (double[]){0.1, 0, -1}, 100); /* a light from behind adds nothing */
    for (int i = 0; i < 3; ++i) st.view.ambient[i] = 0.5f;
    study_color(&st, color);
    for (int i = 0; i < 3; ++i) {
        double b = (double)material.base_color[i];
        double expected = 0.5 * (b * 0.75 + 0.04 * 0.75 + b * 0.25);
        assert_near(color[i], expected + (i == 1 ? 0.125 : 0), FLOAT_STEP);
    }
    study_close(&st);
}

static void test_unlit(void **state) {
    (void)state;
    psplat_material material = material_of((const float[]){0.8f, 0.4f, 0.2f}, 1, 0.5f);
    material.unlit = 1;
    material.emissive[0] = 3;
    study st = study_open(&material, (double[]){0, 0, 1});
    double color[3];
    study_color(&st, color);
    for (int i = 0; i < 3; ++i) assert_near(color[i], (double)material.base_color[i], FLOAT_STEP);
    study_close(&st);
}

/* IEC 61966-2-1 is tested by its published pairs, and the clamp. */
static void test_encoding(void **state) {
    (void)state;
    static const double pairs[][2] = {{0, 0},
                                      {0.001, 0.01292},
                                      {0.0031308, 0.0404499},
                                      {0.004, 0.0507087},
                                      {0.2140411, 0.5},
                                      {0.5, 0.7353570},
                                      {1, 1}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        float x = (float)pairs[i][0];
        psplat_material material = material_of((const float[]){x, x, x}, 0, 1);
        material.unlit = 1;
        study st = study_open(&material, (double[]){0, 0, 1});
        st.view.linear_output = 0;
        double color[3];
        study_color(&st, color);
        assert_near(color[0], pairs[i][1], 2e-7); /* the pairs have seven digits */
        study_close(&st);
    }
    psplat_material white = material_of((const float[]){1, 1, 1}, 0, 1);
    study st = study_open(&white, (double[]){0, 0, 1});
    study_light(&st, (double[]){0, 0, 1}, 100);
    st.view.linear_output = 0;
    double color[3];
    study_color(&st, color);
    assert_near(color[0], 1, 0);
    study_close(&st);
}

/* A directional light from the side keeps its direction in the scene, not in eye space, and the
 * length of its direction does not matter. */
static void test_light_is_in_the_scene(void **state) {
    (void)state;
    psplat_material material = material_of((const float[]){1, 1, 1}, 0, 1);
    scene s = scene_disc(10);
    s.material = material;
    psplat_asset *asset = scene_open(&s);
    psplat_view view = camera_view(1, 1);
    camera_parallel(&view, 1, 1, 30);
    const double l[3] = {0.6, 0, 0.8};
    for (int i = 0; i < 3; ++i) view.lights[0].direction[i] = (float)(-7 * l[i]);
    double e[3], cosine = 0;
    for (int k = 0; k < 5; ++k) {
        direction_of(k, 0.8, e);
        camera_look(&view, (double[]){20 * e[0], 20 * e[1], 20 * e[2]}, (double[]){0, 0, 0});
        picture p = picture_draw(asset, NULL, &view);
        double specular = lobe((double[]){0, 0, 1}, l, e, 1, &cosine);
        assert_near((double)p.image.color[0], dielectric(1, 0.8, specular, cosine), 1e-6);
        picture_free(&p);
    }
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Returns what a surface sends to the eye under equal light from everywhere, as a sum over
 * directions. */
static double furnace(float metallic, float roughness) {
    psplat_material material = material_of((const float[]){1, 1, 1}, metallic, roughness);
    study st = study_open(&material, (double[]){0.6, 0, 0.8});
    const int rows = 48, columns = 96;
    double sum = 0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            /* Equal steps of height make equal solid angles. */
            double l[3], color[3];
            direction_of((column + 0.5) * 2 * CAMERA_PI / columns, asin((row + 0.5) * 2 / rows - 1),
                         l);
            study_light(&st, l, 4 * CAMERA_PI / (rows * columns));
            study_color(&st, color);
            sum += color[0];
        }
    study_close(&st);
    return sum;
}

/* No surface returns more light than it gets. The lobe models a single scattering, so that rough
 * surfaces lose some. */
static void test_energy(void **state) {
    (void)state;
    /* The sum errs by up to 0.005: directions are 0.03 rad apart, the lobe 0.16 rad wide or more.
     */
    double last = 1.005;
    const float roughnesses[] = {0.4f, 0.7f, 1};
    for (int r = 0; r < 3; ++r) {
        double sum = furnace(1, roughnesses[r]);
        assert_true(sum < last && furnace(0, roughnesses[r]) < 1.005);
        last = sum;
    }
    /* At roughness 1, D = 1 / pi and V = 1 / (2 (n.l + n.e)): for n.e = c the integral is 1 - c
     * ln(1 + 1 / c). The midpoint sum over 4608 directions is exact to 1e-3. */
    assert_near(last, 1 - 0.8 * log(1 + 1 / 0.8), 1e-3);
}

int test_reference_shading_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metallic_roughness),
        cmocka_unit_test(test_half_metal),
        cmocka_unit_test(test_ambient_and_emissive),
        cmocka_unit_test(test_unlit),
        cmocka_unit_test(test_encoding),
        cmocka_unit_test(test_light_is_in_the_scene),
        cmocka_unit_test(test_energy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
