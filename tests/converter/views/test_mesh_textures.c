/* SPDX-License-Identifier: MIT
 *
 * test_mesh_textures.c - tests that the source mesh is drawn with its textures as the converter
 * reads them: two programs, one in GLSL and one in C, look up the same texels. The shape is a
 * textured square that fills the picture; expected values are those of the converter
 * (appearance.c).
 */
#include "appearance_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "agreement.h"
#include "appearance/appearance.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "views/mesh_renderer.h"
#include "near.h"

enum { SIZE = 64, TEXELS = 16, BYTES = 4 * SIZE * SIZE };

static void ramps(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    rgba[0] = (uint8_t)(40 + 12 * x), rgba[1] = (uint8_t)(230 - 12 * y);
    rgba[2] = (uint8_t)(90 + 5 * (x + y)), rgba[3] = 255;
}

static void leaning(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    rgba[0] = 204, rgba[1] = 153, rgba[2] = 230, rgba[3] = 255;
}

/* Returns a view from straight ahead in which the square fills the picture. */
static psplat_view view_of(void) {
    static const double eye[3] = {0, 0, 5}, middle[3] = {0, 0, 0};
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, eye, middle);
    camera_parallel(&view, 1, 1, 10);
    view.linear_output = 1;
    return view;
}

static void draw_shaded(gpu *g, const psplat_mesh *mesh, psplat_mesh_renderer_output output,
                        psplat_shading shading, float *pixels) {
    static const float nothing[4] = {0};
    psplat_view view = view_of();
    view.shading = shading;
    psplat_source_mesh *original;
    psplat_mesh_renderer *renderer = NULL;
    psplat_error error = {0};
    if (psplat_source_mesh_create(mesh, 0, &original, &error)) fail_msg("%s", error.text);
    const psplat_mesh_renderer_desc desc = {psplat_host_get_proc, g->host, original};
    psplat_result result = psplat_host_begin(g->host, SIZE, SIZE, 1, nothing, &error);
    if (!result) result = psplat_mesh_renderer_create(&desc, &renderer, &error);
    if (result) fail_msg("%s", error.text);
    result = psplat_mesh_renderer_draw(renderer, &view, output, &error);
    if (!result) result = psplat_host_read_float(g->host, pixels, &error);
    if (result) fail_msg("%s", error.text);
    psplat_mesh_renderer_destroy(renderer);
    psplat_source_mesh_destroy(original);
}

static void draw(gpu *g, const psplat_mesh *mesh, psplat_mesh_renderer_output output,
                 float *pixels) {
    draw_shaded(g, mesh, output, PSPLAT_SHADING_LIT, pixels);
}

/* Returns the appearance by appearance.c at the point that a pixel shows; rows begin at the bottom.
 */
static psplat_baked_point shade_of(const painted *p, int pixel) {
    static const float up[3] = {0, 0, 1};
    double x = (pixel % SIZE + 0.5) / SIZE, y = (double)(pixel / SIZE) + 0.5;
    psplat_appearance appearance;
    psplat_baked_point shade;
    y /= SIZE;
    /* Triangle 0 is the half below the diagonal, and triangle 1 the other half. */
    const double lower[3] = {1 - x, x - y, y}, upper[3] = {1 - y, x, y - x};
    assert_int_equal(psplat_appearance_build(&p->mesh, 2.0 / SIZE, 0, &appearance), PSPLAT_OK);
    psplat_appearance_bake(&appearance, x < y, x < y ? upper : lower, up, &shade);
    psplat_appearance_free(&appearance);
    return shade;
}

static int is_diagonal(int pixel) {
    return pixel % SIZE == pixel / SIZE;
}

static void test_base_color(void **state) {
    static float pixels[BYTES];
    static const psplat_texture_info uses[] = {
        {.wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}},
        {.wrap = {PSPLAT_WRAP_MIRROR, PSPLAT_WRAP_REPEAT},
         .transform = {0.8, -0.6, 0.3, 0.6, 0.8, -0.4}},
        {.nearest = 1},
    };
    for (size_t use = 0; use < sizeof uses / sizeof *uses; ++use) {
        painted p;
        double greatest = 0, sum = 0;
        painted_make(&p, 1, TEXELS, ramps);
        p.source_material.base_color = uses[use];
        p.source_material.base_color.image = &p.image;
        p.source_material.material.unlit = 1;
        p.source_material.material.base_color[1] = 0.5f;
        draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, pixels);
        for (int i = 0; i < SIZE * SIZE; i += 7) {
            psplat_baked_point shade = shade_of(&p, i);
            assert_near(pixels[4 * i + 3], 1, 0);
            for (int k = 0; k < 3; ++k) {
                double expected = (double)shade.color[k] * (k == 1 ? 0.5 : 1);
                double error = fabs((double)pixels[4 * i + k] - expected);
                greatest = fmax(greatest, error);
                sum += error * 7 / (3.0 * SIZE * SIZE);
            }
        }
        print_message("use %zu: mean %.4f, greatest %.3f\n", use, sum, greatest);
        /* GL filters with fractions of 8 bits. Where the image repeats, or texels have hard edges,
         * a pixel may show the other side of an edge; the sum over the picture stays below this. */
        assert_true(sum < 0.002);
        if (use == 0) assert_true(greatest < 0.01);
        painted_free(&p);
    }
}

static void test_normal_map(void **state) {
    static float pixels[BYTES];
    painted p;
    painted_make(&p, 1, TEXELS, leaning);
    p.source_material.normal = (psplat_texture_info){.image = &p.image, .strength = 0.7f};
    const double turned[6] = {0, -1, 1, 1, 0, 0}; /* a quarter turn */
    for (int turn = 0; turn < 2; ++turn) {
        if (turn) memcpy(p.source_material.normal.transform, turned, sizeof turned);
        draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_NORMALS, pixels);
        for (int i = 0; i < SIZE * SIZE; i += 5) {
            psplat_baked_point shade = shade_of(&p, i);
            if (is_diagonal(i)) continue; /* Derivatives there mix both triangles. */
            for (int k = 0; k < 3; ++k)
                assert_near(pixels[4 * i + k], shade.normal[k], 0.005); /* 8-bit texels, filtered */
        }
    }
    painted_free(&p);
}

/* A lit material without light shows what an unlit one does under any. */
static void test_unlit(void **state) {
    static float without_light[BYTES], unlit[BYTES];
    painted p;
    painted_make(&p, 1, TEXELS, ramps);
    p.source_material.base_color.image = &p.image;
    p.source_material.material.emissive[0] = 0.25f;
    draw_shaded(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, PSPLAT_SHADING_UNLIT, without_light);
    p.source_material.material.unlit = 1;
    draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, unlit);
    for (int i = 0; i < BYTES; ++i) assert_near(without_light[i], unlit[i], 1e-6);
    painted_free(&p);
}

/* Textures of one value give the same picture as factors of that value. */
static void test_factors(void **state) {
    static float textured[BYTES], plain[BYTES];
    painted p;
    painted_make(&p, 1, TEXELS, leaning);
    const psplat_texture_info texture = {.image = &p.image, .strength = 1};
    p.source_material.material.emissive[1] = 0.5f;
    p.source_material.metallic_roughness = p.source_material.emissive = texture;
    draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, textured);
    p.source_material.metallic_roughness.image = p.source_material.emissive.image = NULL;
    p.source_material.material.roughness = 153 / 255.0f;
    p.source_material.material.metallic = 230 / 255.0f;
    p.source_material.material.emissive[1] *= psplat_linear_of_srgb(153 / 255.0f);
    draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, plain);
    for (int i = 0; i < BYTES; ++i) /* colours decoded by tables; 1/255 of a factor */
        assert_near(textured[i], plain[i], 0.008);
    painted_free(&p);
}

/* Each group of triangles shows its own material. */
static void test_groups(void **state) {
    static float pixels[BYTES];
    painted p;
    psplat_source_material both[2];
    uint32_t groups[2] = {1, 0};
    painted_make(&p, 1, TEXELS, ramps);
    both[0] = both[1] = p.source_material;
    both[0].material.unlit = both[1].material.unlit = 1;
    both[1].material.base_color[0] = 0.25f;
    p.mesh.source_materials = both;
    p.mesh.source_material_count = 2;
    p.mesh.groups = groups;
    draw(*state, &p.mesh, PSPLAT_MESH_RENDERER_LIGHT, pixels);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (is_diagonal(i)) continue;
        int lower = i % SIZE > i / SIZE; /* the pixel shows triangle 0 */
        assert_near(pixels[4 * i], lower ? 0.25 : 1, 1e-6);
    }
    p.mesh.groups = NULL;
    painted_free(&p);
}

int test_mesh_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_base_color), cmocka_unit_test(test_normal_map),
        cmocka_unit_test(test_unlit),      cmocka_unit_test(test_factors),
        cmocka_unit_test(test_groups),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, gpu_setup_gles, gpu_teardown);
}
