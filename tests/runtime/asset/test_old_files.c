/* SPDX-License-Identifier: MIT
 *
 * test_old_files.c - tests that every file of tests/corpus, written by an earlier version of this
 * project (tests/corpus/README.md), opens and holds the splats that it held. What a later version
 * may write is refused, and the error says that this is the reason.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>

enum { CENTER, ROTATION, RADIUS, NORMAL, GRADIENT, COLOR_AND_CLIP, SHAPE_AND_BEND, TEXCOORD, SUMS };

/* What a file holds, as sums over splats i = 1 ... of i times the sum over values k = 1 ... of k
 * times the value. One sum takes the colour's four values and the clip lines' a, b, c, one the
 * shape's five and the lines' bends, and the last the texture coordinates' twelve. */
typedef struct old_file {
    const char *name;
    size_t batches;
    size_t splats_by_clip_lines[PSPLAT_MAX_CLIP_LINES + 1];
    int has_color;
    double sums[SUMS];
} old_file;

static const old_file files[] = {
    {"1-minimal.gltf", 3, {2, 1, 1, 0, 0}, 0, {28, 41.8994949, 19, 31.2, 0.5, 154}},
    {"1-unlit.glb", 1, {0, 0, 0, 0, 6}, 0, {11, 38.1923882, 46.2487271, 22, 0, 1017.94244}},
    {"2-part.glb",
     4,
     {0, 6, 11, 24, 73},
     0,
     {4775.1458, 13578.977, 20683.7027, 2410.02819, -2601.34929, 226671.311}},
    {"2-saddle.glb",
     4,
     {1, 2, 6, 1, 0},
     1,
     {9.20801885, 117.325435, 88.9912862, 154.727503, -8.08886504, 933.34984}},
    {"3-cone.glb",
     5,
     {12, 11, 1, 3, 8},
     0,
     {-1068.48255, 1265.02409, 994.333666, -145.360462, 422.25868, 16414.569}},
    {"4-cone.glb",
     6,
     {20, 39, 3, 3, 8},
     0,
     {-4090.10025, 6508.41165, 4453.68515, 1859.66343, 2123.53898, 52598.1849}},
    {"5-saddle.glb",
     4,
     {1, 2, 3, 1, 0},
     1,
     {4.64215452, 70.4949901, 51.5499385, 77.6474619, -3.94149854, 526.508642}},
    {"5-torus.glb",
     1,
     {11, 0, 0, 0, 0},
     0,
     {48.1026095, 100.421259, 147.139848, -6.38752494, 332.615371, 660}},
    {"6-cube.glb", 1, {0, 0, 0, 0, 6}, 0, {13.8538953, 48.5198863, 95.6235681, 14, 0, 985.461608}},
    {"6-glowing.glb",
     1,
     {0, 0, 0, 0, 6},
     0,
     {6.97628992, 30.3437884, 53.069881, 14, 0, 879.155854}},
    {"6-saddle.glb",
     4,
     {1, 2, 3, 1, 0},
     1,
     {0.112072397, 57.7748885, 49.1876157, 78.5329972, 0.383510955, 321.171981}},
    {"7-cone.glb",
     1,
     {0, 0, 0, 0, 15},
     0,
     {21510, 225.005307, 17167.7984, -45.4617969, 135.646962, 7134.74963}},
    {"compressed/7-cone.glb",
     1,
     {0, 0, 0, 0, 15},
     0,
     {21510, 225.005307, 17167.7984, -45.4617969, 135.646962, 7134.74963}},
    {"compressed/7-cube-mesh.glb",
     1,
     {0, 0, 0, 0, 6},
     0,
     {8584, 76.5230929, 5642.85358, 22, 0, 849.533484}},
    {"compressed/7-painted.glb",
     4,
     {66, 341, 0, 0, 0},
     1,
     {17941938, 179383.392, 1118757.06, 65313.439, 41120.7418, 1364195.67}},
    {"8-curved.glb",
     1,
     {0, 0, 0, 0, 100},
     0,
     {2891989, 7074.32587, 175033.048, -1057.70119, -860.375, 286128.122, 21852.1016}},
    {"compressed/8-shapes.glb",
     1,
     {0, 0, 0, 0, 100},
     0,
     {2891989, 7074.32587, 175033.048, -1065.79933, 1614.98438, 282320.122, 900.101562}},
    {"9-textured.glb",
     1,
     {0, 60, 0, 0, 0},
     0,
     {-3572028, 136.760401, 1114084.12, -351.139509, 794.202756, 25576.6229, 0, 2481.9852}},
    {"10-streamed.glb",
     2,
     {0, 0, 0, 0, 62},
     0,
     {468486, 4008.22291, 224780.736, 56.7291647, 272.677637, 66794.6647, 7547.93322}},
    {"11-texcoords.glb",
     1,
     {0, 0, 0, 0, 19},
     0,
     {108066.5, 688.988716, 34652.1202, 236.547093, 215.366403, 11148.2694, -572.051673,
      165.188399}},
    {"12-seams.glb",
     1,
     {0, 0, 24, 0, 0},
     0,
     {914.101713, 1171.18497, 285.000005, 770.101707, 104.999998, 8805.13765, 314.999995,
      182.305999}},
};

static psplat_asset *open_old(const char *name) {
    char path[1024];
    psplat_asset *asset = NULL;
    psplat_error error;
    snprintf(path, sizeof path, "%s/tests/corpus/%s", PSPLAT_SOURCE_DIR, name);
    if (psplat_asset_open(path, NULL, &asset, &error))
        fail_msg("%s: %s (byte %zu)", name, error.text, error.offset);
    return asset;
}

/* ---- what is in them ------------------------------------------------------------------------- */

/* A sum, and how much rounding may change it. */
typedef struct sum {
    double value, size;
} sum;

static void add(sum *s, double factor, const float *values, size_t first, size_t count) {
    for (size_t k = 0; k < count; ++k) {
        double term = factor * (double)(first + k + 1) * (double)values[k];
        s->value += term;
        s->size += fabs(term);
    }
}

static void add_splat(sum sums[SUMS], size_t index, const psplat_splat *splat) {
    double i = (double)index;
    add(&sums[CENTER], i, splat->center, 0, 3);
    add(&sums[ROTATION], i, splat->rotation, 0, 4);
    add(&sums[RADIUS], i, splat->radius, 0, 2);
    add(&sums[NORMAL], i, splat->normal, 0, 3);
    add(&sums[GRADIENT], i, splat->gradient, 0, 3);
    add(&sums[COLOR_AND_CLIP], i, splat->color, 0, 4);
    for (size_t k = 0; k < splat->clip_count; ++k)
        add(&sums[COLOR_AND_CLIP], i, splat->clip[k], 4 + 3 * k, 3);
    add(&sums[SHAPE_AND_BEND], i, splat->shape, 0, 5);
    add(&sums[SHAPE_AND_BEND], i, splat->bend, 5, splat->clip_count);
}

static void add_texcoord(sum sums[SUMS], size_t index, const psplat_texcoord *t) {
    const float *const terms[] = {t->at,       t->along_u,  t->along_v,
                                  t->along_uu, t->along_uv, t->along_vv};
    for (size_t k = 0; k < 6; ++k) add(&sums[TEXCOORD], (double)index, terms[k], 2 * k, 2);
}

static void check_file(const old_file *file) {
    psplat_asset *asset = open_old(file->name);
    size_t classes[PSPLAT_MAX_CLIP_LINES + 1] = {0}, index = 0;
    sum sums[SUMS] = {{0, 0}};
    assert_int_equal(psplat_asset_batch_count(asset), file->batches);
    for (size_t b = 0; b < file->batches; ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        assert_int_equal(batch->has_color, file->has_color);
        /* Values that vary over a mesh came with version 2. */
        assert_int_equal(batch->finishes != NULL, !strcmp(file->name, "compressed/7-painted.glb"));
        assert_true(batch->depth_tolerance > 0);
        /* Curved splats and bent lines came with version 3. */
        int is_streamed = !strcmp(file->name, "10-streamed.glb");
        int has_seams = !strcmp(file->name, "12-seams.glb");
        assert_int_equal(batch->seam_lines, has_seams);
        assert_int_equal(batch->is_curved, strstr(file->name, "8-") != NULL ||
                                               (is_streamed && b == 0) || has_seams ||
                                               !strcmp(file->name, "11-texcoords.glb"));
        assert_int_equal(batch->has_shape, !strcmp(file->name, "compressed/8-shapes.glb"));
        assert_int_equal(batch->has_bends, is_streamed || !strcmp(file->name, "8-curved.glb") ||
                                               !strcmp(file->name, "11-texcoords.glb"));
        /* So did texture coordinates. */
        int is_textured = has_seams || !strcmp(file->name, "11-texcoords.glb");
        assert_int_equal(batch->has_texcoord, is_textured || strstr(file->name, "9-") != NULL);
        assert_int_equal(batch->has_texcoord_bend, batch->has_texcoord);
        classes[batch->clip_count] += batch->splat_count;
        for (size_t i = 0; i < batch->splat_count; ++i) {
            add_splat(sums, ++index, &batch->splats[i]);
            if (batch->texcoords) add_texcoord(sums, index, &batch->texcoords[i]);
        }
    }
    assert_memory_equal(classes, file->splats_by_clip_lines, sizeof classes);
    /* Nine digits are listed above, and values are rounded to float. The decoder of octahedral
     * filters asks the processor for approximate roots, with which those of some makers round a
     * component of 8 bits to the next of 127 steps: here and there a splat turns by half a degree.
     */
    int is_filtered = strstr(file->name, "compressed/") != NULL;
    for (size_t s = 0; s < SUMS; ++s) {
        double rounding = is_filtered && (s == ROTATION || s == NORMAL) ? 1e-4 : 1e-7;
        if (!(fabs(sums[s].value - file->sums[s]) <=
              2e-8 * fabs(file->sums[s]) + rounding * sums[s].size))
            fail_msg("%s: sum %zu is %.9g, not %.9g", file->name, s, sums[s].value, file->sums[s]);
    }
    psplat_asset_destroy(asset);
}

static void test_splats(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) check_file(&files[i]);
}

static void test_materials(void **state) {
    (void)state;
    /* Values are glTF's defaults, except those that the source file gives. The unlit file shows
     * only its base colour. */
    static const float color[4] = {0.8f, 0.4f, 0.2f, 1}, glow[3] = {0.5f, 0.25f, 0};
    static const double origin[3] = {10.5, 20.5, 30.5};
    psplat_asset *unlit = open_old("1-unlit.glb"), *glowing = open_old("6-glowing.glb");
    const psplat_batch *batch = psplat_asset_batch(unlit, 0);
    assert_memory_equal(batch->material.base_color, color, sizeof color);
    assert_true(batch->material.unlit);
    assert_false(batch->material.double_sided);
    assert_memory_equal(batch->model + 12, origin, sizeof origin);
    batch = psplat_asset_batch(glowing, 0);
    assert_memory_equal(batch->material.base_color, color, sizeof color);
    assert_memory_equal(batch->material.emissive, glow, sizeof glow);
    assert_true(batch->material.metallic == 0.25f && batch->material.roughness == 0.75f);
    assert_true(batch->material.double_sided);
    assert_false(batch->material.unlit);
    psplat_asset_destroy(unlit);
    psplat_asset_destroy(glowing);
}

static void test_textures(void **state) {
    (void)state;
    static const float transform[6] = {2, 0, 0.5f, 0, 2, 0.25f};
    psplat_asset *asset = open_old("9-textured.glb");
    const psplat_material *material = &psplat_asset_batch(asset, 0)->material;
    const psplat_texture *color = &material->textures[PSPLAT_TEXTURE_BASE_COLOR];
    const psplat_texture *normal = &material->textures[PSPLAT_TEXTURE_NORMAL];
    for (size_t i = 0; i < 6; ++i) assert_true(color->transform[i] == transform[i]);
    assert_true(color->wrap[0] == PSPLAT_WRAP_CLAMP && color->wrap[1] == PSPLAT_WRAP_MIRROR);
    assert_true(normal->wrap[0] == PSPLAT_WRAP_REPEAT && normal->strength == 0.5f);
    assert_true(material->alpha_cutoff == 0.25f);
    assert_int_equal(psplat_asset_image_count(asset), 2);
    for (size_t i = 0; i < 2; ++i) {
        const psplat_asset_image *image = psplat_asset_get_image(asset, i);
        assert_string_equal(image->mime_type, "image/png");
        assert_memory_equal((const char *)image->data + image->size - 8, "IEND", 4);
    }
    psplat_asset_destroy(asset);
}

/* In later files flat splats have a primitive, and with it a depth tolerance, of their own. */
static void test_flat_splats(void **state) {
    (void)state;
    psplat_asset *before = open_old("3-cone.glb"), *after = open_old("4-cone.glb");
    for (size_t i = 1; i < psplat_asset_batch_count(before); ++i)
        assert_true(psplat_asset_batch(before, i)->depth_tolerance ==
                    psplat_asset_batch(before, 0)->depth_tolerance);
    const psplat_batch *flat = psplat_asset_batch(after, 0), *other = psplat_asset_batch(after, 1);
    assert_int_equal(flat->clip_count, other->clip_count);
    assert_true(flat->depth_tolerance < 0.1f * other->depth_tolerance);
    psplat_asset_destroy(before);
    psplat_asset_destroy(after);
}

/* Every field of the oldest files satisfies spec 3.5, eq. (3a), once it is read, and one lies on
 * the bound. */
static void test_fields_of_old(void **state) {
    (void)state;
    psplat_asset *asset = open_old("2-part.glb");
    double largest = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        for (size_t i = 0; i < batch->splat_count; ++i) {
            const psplat_splat *s = &batch->splats[i];
            double x = (double)s->rotation[0], y = (double)s->rotation[1];
            double z = (double)s->rotation[2], w = (double)s->rotation[3];
            double cosine = 2 * (x * z + y * w) * (double)s->normal[0] +
                            2 * (y * z - x * w) * (double)s->normal[1] +
                            (1 - 2 * (x * x + y * y)) * (double)s->normal[2];
            double bend = sqrt(fmax(1 / (cosine * cosine) - 1, 0)) +
                          hypot((double)s->gradient[0], (double)s->gradient[1]);
            if (bend > largest) largest = bend;
        }
    }
    /* The rounding of rotation, normal and field as floats. */
    assert_true(fabs(largest - 20) < 1e-4);
    psplat_asset_destroy(asset);
}

/* ---- what comes later ------------------------------------------------------------------------ */

static void test_future(void **state) {
    (void)state;
    static const char *const versions[] = {"5", "4294967295"};
    for (size_t i = 0; i < sizeof versions / sizeof *versions; ++i) {
        char *text = document_minimal(PSPLAT_SOURCE_DIR), stated[40], expected[40];
        snprintf(stated, sizeof stated, "\"version\": %s,", versions[i]);
        snprintf(expected, sizeof expected, "version %s of", versions[i]);
        document_replace(&text, "\"version\": 1,", stated);
        psplat_asset *asset = NULL;
        psplat_error error = {0};
        assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error),
                         PSPLAT_ERROR_UNSUPPORTED);
        assert_null(asset);
        assert_non_null(strstr(error.text, expected));
        assert_non_null(strstr(error.text, "PSPLAT_surface_splats"));
        assert_int_equal(error.offset, document_find(text, stated) + strlen("\"version\": "));
        free(text);
    }
}

int test_old_files_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_splats),      cmocka_unit_test(test_materials),
        cmocka_unit_test(test_flat_splats), cmocka_unit_test(test_fields_of_old),
        cmocka_unit_test(test_textures),    cmocka_unit_test(test_future),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
