/* SPDX-License-Identifier: MIT
 *
 * test_agreement_finish.c - tests materials that vary over a mesh (spec 3.10): the renderer draws
 * them as the reference rasteriser does, in all modes. What the values mean is tested on single
 * splats by the specification's equations.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "agreement.h"
#include "packed.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>

enum { MOST = 150, WIDTH = 160, HEIGHT = 120 };

/* The parts of a finish that a document stores. */
enum {
    SURFACE = 1,
    EMISSIVE = 2,
    GRADIENT = 4,
    COLOR = 8,
    ALL = 15,
    CURVED = 16,
    SHAPE = 32,
    TEXTURED = 64
};

/* Splats as numbers to be stored, by attribute. */
typedef struct columns {
    double position[3 * MOST], normal[3 * MOST], rotation[4 * MOST], scale[2 * MOST];
    double color[3 * MOST], clip[PSPLAT_MAX_CLIP_LINES][3 * MOST];
    double field[3 * MOST], shape[3 * MOST], bent[PSPLAT_MAX_CLIP_LINES][4 * MOST];
    double surface[3 * MOST], emissive[3 * MOST], color_u[3 * MOST], color_v[3 * MOST];
    double texcoord[3][3 * MOST]; /* of which pairs are used: T0, T_u, T_v */
} columns;

static const char material[] = "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.8,1,1],"
                               "\"metallicFactor\":0.8,\"roughnessFactor\":0.9},"
                               "\"emissiveFactor\":[0.5,0.4,0.3]}";

/* The same with all textures but that of normals, and what they refer to: an image of 2 x 2 pixels
 * in the form of scene_images(). */
static const char textured_material[] =
    "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.8,1,1],\"metallicFactor\":0.8,"
    "\"roughnessFactor\":0.9,\"baseColorTexture\":{\"index\":0},"
    "\"metallicRoughnessTexture\":{\"index\":0}},\"emissiveFactor\":[0.5,0.4,0.3],"
    "\"occlusionTexture\":{\"index\":0},\"emissiveTexture\":{\"index\":0}}";
static const char image_members[] =
    "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":"
    "\"data:image/x-raw;base64,AgAAAAIAAAD/gED/ZJbI/xTIWv+0WvD/\"}]";

static void put(double *out, size_t i, const float *values, size_t count) {
    for (size_t k = 0; k < count; ++k) out[i * count + k] = (double)values[k];
}

static void put_random(double *out, size_t i, double low, double high, uint32_t *random) {
    for (size_t k = 0; k < 3; ++k)
        out[3 * i + k] = low + (high - low) * (double)scene_random(random);
}

static void put_line(double out[4], const float line[3], double bend) {
    for (int k = 0; k < 3; ++k) out[k] = (double)line[k];
    out[3] = bend;
}

/* Fills the columns. Gradients leave the range 0 ... 1 within a splat, so that clamping shows. */
static void fill(columns *c, const scene *s, size_t *count, uint32_t clip_lines) {
    uint32_t random = 99;
    *count = 0;
    for (size_t i = 0; i < s->count && *count < MOST; ++i) {
        const psplat_splat *splat = &s->splats[i];
        if (splat->clip_count != clip_lines) continue;
        size_t at = (*count)++;
        put(c->position, at, splat->center, 3);
        put(c->normal, at, splat->normal, 3);
        put(c->rotation, at, splat->rotation, 4);
        put(c->scale, at, splat->radius, 2);
        put(c->color, at, splat->color, 3);
        for (size_t k = 0; k < clip_lines; ++k) put(c->clip[k], at, splat->clip[k], 3);
        for (size_t k = 0; k < clip_lines; ++k)
            put_line(c->bent[k] + 4 * at, splat->clip[k], (double)scene_random(&random) * 4 - 2);
        put_random(c->field, at, -1.5, 1.5, &random);
        put_random(c->shape, at, -1.5, 1.5, &random);
        put_random(c->surface, at, 0, 1, &random);
        put_random(c->emissive, at, 0, 1, &random);
        put_random(c->color_u, at, -0.8, 0.8, &random);
        put_random(c->color_v, at, -0.8, 0.8, &random);
        for (size_t k = 0; k < 3; ++k) put_random(c->texcoord[k], at, -0.4, 0.4, &random);
    }
}

static void add(packed *p, size_t *at, const char *name, int components, const double *values) {
    p->attributes[(*at)++] = (packed_attribute){name, PACKED_FLOAT, components, 0, values};
}

static psplat_asset *open_columns(const columns *c, size_t count, uint32_t clip_lines,
                                  unsigned stored) {
    static const char *const lines[PSPLAT_MAX_CLIP_LINES] = {"CLIP_0", "CLIP_1", "CLIP_2",
                                                             "CLIP_3"};
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    char extension[220];
    int is_curved = !!(stored & CURVED);
    size_t at = 0;
    for (size_t i = 0; i < 3 * count; ++i) {
        low[i % 3] = fmin(low[i % 3], c->position[i]);
        high[i % 3] = fmax(high[i % 3], c->position[i]);
    }
    snprintf(extension, sizeof extension,
             "\"version\":3,\"clipLines\":%u,\"depthTolerance\":0.01,\"curved\":%s,"
             "\"positionExtent\":[%.9g,%.9g,%.9g]",
             (unsigned)clip_lines, is_curved ? "true" : "false", high[0] - low[0], high[1] - low[1],
             high[2] - low[2]);
    packed p = {.count = count, .extension = extension, .material = material};
    if (stored & TEXTURED) p.material = textured_material;
    if (stored & TEXTURED) p.members = image_members;
    add(&p, &at, "POSITION", 3, c->position);
    add(&p, &at, "NORMAL", 3, c->normal);
    add(&p, &at, "ROTATION", 4, c->rotation);
    add(&p, &at, "SCALE", 2, c->scale);
    for (unsigned k = 0; k < clip_lines; ++k)
        add(&p, &at, lines[k], is_curved ? 4 : 3, is_curved ? c->bent[k] : c->clip[k]);
    if (is_curved) add(&p, &at, "NORMAL_FIELD", 3, c->field);
    if (stored & SHAPE) add(&p, &at, "SHAPE", 3, c->shape);
    if (stored & COLOR) add(&p, &at, "COLOR_0", 3, c->color);
    if (stored & SURFACE) add(&p, &at, "OCCLUSION_ROUGHNESS_METALLIC", 3, c->surface);
    if (stored & EMISSIVE) add(&p, &at, "EMISSIVE", 3, c->emissive);
    if (stored & GRADIENT) add(&p, &at, "COLOR_U", 3, c->color_u);
    if (stored & GRADIENT) add(&p, &at, "COLOR_V", 3, c->color_v);
    if (stored & TEXTURED) add(&p, &at, "TEXCOORD_0", 2, c->texcoord[0]);
    if (stored & TEXTURED) add(&p, &at, "TEXCOORD_U", 2, c->texcoord[1]);
    if (stored & TEXTURED) add(&p, &at, "TEXCOORD_V", 2, c->texcoord[2]);
    char *text = packed_text(&p);
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    free(text);
    return asset;
}

static psplat_view view_of(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 120, 0.3, 10);
    for (int i = 0; i < 3; ++i) view.ambient[i] = 0.5f;
    return view;
}

/* Expects differences of colours below 1e-4, as test_agreement.c does, where bounds and ties are
 * explained; of textured assets below what test_agreement_textures.c explains. */
static void check(gpu *g, const char *name, const psplat_asset *asset, const psplat_view *view) {
    double textured = view->shading == PSPLAT_SHADING_LIT ? 0.06 : 0.02;
    double most = psplat_asset_image_count(asset) > 0 ? textured : 1e-4;
    static const agreement_ties ties = {2e-4, 2e-6, 0.015};
    agreement a = agreement_measure(g, asset, NULL, view, 1, &ties);
    print_message("%-26s covered %6zu skipped %4zu color %.1e\n", name, a.covered, a.skipped,
                  a.color);
    assert_true(a.covered > 500 && a.skipped * 10 < a.covered);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.color <= most);
}

static void check_modes(gpu *g, const psplat_asset *asset) {
    psplat_view view = view_of();
    check(g, " phong", asset, &view);
    view.mode = PSPLAT_MODE_GAUSSIAN;
    check(g, " gaussian", asset, &view);
    view.mode = PSPLAT_MODE_FLAT;
    check(g, " flat", asset, &view);
    view.shading = PSPLAT_SHADING_UNLIT;
    check(g, " flat, unlit", asset, &view);
    view.mode = PSPLAT_MODE_PHONG;
    check(g, " unlit", asset, &view);
    view.shading = PSPLAT_SHADING_LIT;
    view.no_filter = 1;
    check(g, " without the filter", asset, &view);
}

static void test_all(void **state) {
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    for (uint32_t lines = 0; lines <= 2; lines += 2) {
        size_t count = 0;
        scene s = scene_ellipses(3 * MOST, lines, 7);
        fill(c, &s, &count, lines);
        psplat_asset *asset = open_columns(c, count, lines, ALL);
        print_message("%zu ellipses, %u clip lines\n", count, (unsigned)lines);
        check_modes(*state, asset);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    free(c);
}

/* Tests each part alone and each pair, because the place of texels depends on the other parts. */
static void test_parts(void **state) {
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    size_t count = 0;
    scene s = scene_ellipses(MOST, 0, 3);
    fill(c, &s, &count, 0);
    psplat_view view = view_of();
    for (unsigned stored = 0; stored < 16; ++stored) {
        char name[40];
        psplat_asset *asset = open_columns(c, count, 0, stored);
        snprintf(name, sizeof name, "%s%s%s%s", stored & SURFACE ? " surface" : "",
                 stored & EMISSIVE ? " emissive" : "", stored & GRADIENT ? " gradient" : "",
                 stored & COLOR ? " color" : "");
        check(*state, name, asset, &view);
        psplat_asset_destroy(asset);
    }
    scene_free(&s);
    free(c);
}

/* Of curved splats colours have to change with the (u, v) at which the ray meets the surface. The
 * rows of textures are shorter where a splat has both a colour and a shape of its own. Beside four
 * clip lines fragments read a part of the finish themselves. */
static void test_curved(void **state) {
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; lines += 2)
        for (unsigned own = 0; own <= SHAPE; own += SHAPE) {
            size_t count = 0;
            scene s = scene_ellipses((lines + 1) * MOST, lines, 7);
            fill(c, &s, &count, lines);
            /* Highlights of smooth materials would change within a hundredth of a pixel. */
            for (size_t i = 0; i < count; ++i)
                c->surface[3 * i + 1] = 0.4 + 0.6 * c->surface[3 * i + 1];
            print_message("%zu curved ellipses, %u bent clip lines\n", count, (unsigned)lines);
            psplat_asset *asset = open_columns(c, count, lines, ALL | CURVED | own);
            check_modes(*state, asset);
            psplat_asset_destroy(asset);
            asset = open_columns(c, count, lines, CURVED | own);
            check_modes(*state, asset);
            psplat_asset_destroy(asset);
            scene_free(&s);
        }
    free(c);
}

/* Texture coordinates lie beside finishes and do not depend on which of these are there; textures
 * multiply them. */
static void test_textured(void **state) {
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    for (unsigned kind = 0; kind <= (CURVED | SHAPE); kind += CURVED) {
        size_t count = 0;
        if (kind == SHAPE) continue; /* only curved splats have shapes */
        scene s = scene_ellipses(3 * MOST, 2, 7);
        fill(c, &s, &count, 2);
        for (size_t i = 0; i < count; ++i)
            c->surface[3 * i + 1] = 0.6 + 0.4 * c->surface[3 * i + 1];
        for (unsigned stored = SURFACE; stored <= ALL; stored = 2 * stored + 1) {
            psplat_asset *asset = open_columns(c, count, 2, stored | kind | TEXTURED);
            print_message("%u, %u, textured\n", kind, stored);
            check_modes(*state, asset);
            psplat_asset_destroy(asset);
        }
        scene_free(&s);
    }
    free(c);
}

/* The environment is a box of six colours; occlusion darkens it, too. */
static void test_environment(void **state) {
    enum { SIZE = 8 };
    float radiance[6 * SIZE * SIZE * 3];
    for (size_t i = 0; i < 6 * SIZE * SIZE; ++i)
        for (size_t k = 0; k < 3; ++k)
            radiance[3 * i + k] = 0.2f + 0.1f * (float)((i / (SIZE * SIZE) + 2 * k) % 6);
    const psplat_environment_desc environment = {.radiance = radiance, .size = SIZE};
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    size_t count = 0;
    scene s = scene_ellipses(MOST, 0, 3);
    fill(c, &s, &count, 0);
    /* The surface is rough, because environments are approximated for glossy ones
     * (test_agreement_environment.c). */
    for (size_t i = 0; i < count; ++i) {
        c->surface[3 * i + 1] = 1;
        c->surface[3 * i + 2] = 0;
    }
    psplat_view view = camera_view(40, 30);
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 30, 0.3, 10);
    view.light_count = 0;
    psplat_asset *asset = open_columns(c, count, 0, SURFACE | COLOR);
    psplat_reference_scene all = {.asset = asset, .environment = &environment};
    static const agreement_ties ties = {2e-4, 2e-6, 0.015};
    agreement a = agreement_measure_scene(*state, &all, &view, 1, &ties);
    print_message("environment: color %.1e\n", a.color);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.color <= 0.02); /* that test's bound for rough materials */
    psplat_asset_destroy(asset);
    scene_free(&s);
    free(c);
}

/* ---- single splats, by hand ----------------------------------------------------------------- */

/* Returns what the reference draws in the middle of one disc that faces the eye and is lit only by
 * ambient light. */
static void middle_of(const columns *c, unsigned stored, double x, float color[4]) {
    psplat_asset *asset = open_columns(c, 1, 0, stored);
    psplat_view view = camera_view(33, 33);
    camera_look(&view, (double[]){x, 0, 5}, (double[]){x, 0, 0});
    camera_perspective(&view, 100, 1, 10);
    view.light_count = 0;
    for (int i = 0; i < 3; ++i) view.ambient[i] = 1;
    psplat_reference_scene scene = {.asset = asset};
    picture p = picture_of_scene(&scene, &view);
    memcpy(color, p.image.color + 4 * (16 * 33 + 16), 4 * sizeof *color);
    picture_free(&p);
    psplat_asset_destroy(asset);
}

static void assert_near(double found, double expected) {
    if (!(fabs(found - expected) <= 1e-6)) fail_msg("%.9g, expected %.9g", found, expected);
}

/* Expected values come from eq. (4a), (4b) and (7). */
static void test_meaning(void **state) {
    (void)state;
    static const double base[3] = {0.9, 0.8, 1}, glow[3] = {0.5, 0.4, 0.3};
    columns *c = calloc(1, sizeof *c);
    assert_non_null(c);
    scene s = scene_disc(1);
    size_t count = 0;
    fill(c, &s, &count, 0);
    const double color[3] = {0.5, 0.9, 0.2}, u[3] = {0.4, 0.4, -0.6}, orm[3] = {0.25, 0.5, 0.5};
    memcpy(c->color, color, sizeof color);
    memcpy(c->color_u, u, sizeof u);
    memcpy(c->surface, orm, sizeof orm);
    float found[4];
    for (int k = 0; k <= 2; k += 2) { /* at the centre and at u = 1/2 */
        middle_of(c, SURFACE | EMISSIVE | GRADIENT | COLOR, 0.25 * k, found);
        for (int i = 0; i < 3; ++i) {
            double b = base[i] * fmin(fmax(color[i] + 0.25 * k * u[i], 0), 1);
            double metallic = 0.8 * 0.5, f0 = 0.04 + (b - 0.04) * metallic;
            assert_near((double)found[i],
                        0.25 * (b * (1 - metallic) + f0) + glow[i] * c->emissive[i]);
        }
    }
    scene_free(&s);
    free(c);
}

int test_agreement_finish_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all),     cmocka_unit_test(test_parts),
        cmocka_unit_test(test_curved),  cmocka_unit_test(test_environment),
        cmocka_unit_test(test_meaning), cmocka_unit_test(test_textured),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_all),
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_textured),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
