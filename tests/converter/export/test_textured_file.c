/* SPDX-License-Identifier: MIT
 *
 * test_textured_file.c - tests of files whose splats have texture coordinates: what the runtime's
 * reader finds of coordinates, textures and images, with and without compression.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "near.h"
#include "writer_fixture.h"
#include "export/meshopt_codec.h"
#include "material/image.h"
#include "splats/texcoord_steps.h"

#include <math.h>
#include <string.h>

enum { COUNT = 300, IMAGES = 3 };

/* The writer copies bytes and does not look at them. */
static uint8_t image_bytes[IMAGES][7] = {"first", "second", "third"};

/* Three images, of which the second is used by no material. */
static psplat_scene textured_scene(psplat_image images[IMAGES]) {
    static char label[] = "label";
    psplat_scene scene = writer_scene(1);
    for (int i = 0; i < IMAGES; ++i)
        images[i] = (psplat_image){
            .bytes = image_bytes[i], .size = 5 + (size_t)i, .mime_type = "image/png"};
    images[2].mime_type = "image/jpeg";
    images[2].name = label;
    scene.materials.images = images;
    scene.materials.image_count = IMAGES;
    return scene;
}

static void free_scene(psplat_scene *scene) {
    scene->materials.images = NULL;
    scene->materials.image_count = 0;
    psplat_scene_free(scene);
}

static float random_between(float low, float high, uint32_t *state) {
    return low + (high - low) * scene_random(state);
}

/* Gives the splats random coordinates, the runs with an even number of lines the second order, and
 * those of the most lines none. */
static void add_texcoords(psplat_splats *s, float low, float high) {
    uint32_t state = 5;
    s->texcoords = writer_memory(s->count, sizeof *s->texcoords);
    for (size_t r = 0, i = 0; r < s->run_count; ++r) {
        psplat_run *run = &s->runs[r];
        run->has_texcoord = run->clip_lines < PSPLAT_MAX_CLIP_LINES;
        run->has_texcoord_bend = run->has_texcoord && run->clip_lines % 2 == 0;
        for (size_t end = i + run->count; i < end; ++i) {
            psplat_texcoord *t = &s->texcoords[i];
            for (int k = 0; k < 2 && run->has_texcoord; ++k) {
                t->at[k] = random_between(low, high, &state);
                t->along_u[k] = random_between(-0.1f, 0.1f, &state);
                t->along_v[k] = random_between(-0.1f, 0.1f, &state);
                if (!run->has_texcoord_bend) continue;
                t->along_uu[k] = random_between(-0.01f, 0.01f, &state);
                t->along_uv[k] = random_between(-0.01f, 0.01f, &state);
                t->along_vv[k] = random_between(-0.01f, 0.01f, &state);
            }
        }
    }
    psplat_texcoord_settle(s, 0, 1e-3);
    psplat_round_to_precision(s);
}

static void add_textures(psplat_material *m) {
    const psplat_texture color = {.image = 3, .strength = 1};
    const psplat_texture normal = {.image = 1,
                                   .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_MIRROR},
                                   .nearest = 1,
                                   .transform = {0, 2, 0.25f, -3, 0, 0.5f},
                                   .strength = 0.5f};
    m->textures[PSPLAT_TEXTURE_BASE_COLOR] = m->textures[PSPLAT_TEXTURE_EMISSIVE] = color;
    m->textures[PSPLAT_TEXTURE_NORMAL] = normal;
    m->textures[PSPLAT_TEXTURE_OCCLUSION] = color;
    m->textures[PSPLAT_TEXTURE_OCCLUSION].strength = 0.75f;
    m->textures[PSPLAT_TEXTURE_OCCLUSION].transform[0] = 1;
    m->textures[PSPLAT_TEXTURE_OCCLUSION].transform[4] = -1;
}

static psplat_asset *write_and_open(const psplat_scene *scene, const psplat_splats *splats,
                                    const psplat_codec *codec, uint8_t **data) {
    const psplat_write_desc desc = {.codec = codec};
    psplat_error error = {0};
    size_t size;
    if (psplat_scene_write(scene, splats, &desc, data, &size, &error)) fail_msg("%s", error.text);
    return writer_open(*data, size);
}

static void compare_pair(const float *found, const float *expected, double tolerance) {
    for (int k = 0; k < 2; ++k) assert_near(found[k], expected[k], tolerance);
}

/* Compares the coordinates of each splat with those of the splat at the same grid point. */
static size_t compare_texcoords(const psplat_splats *splats, const psplat_batch *batch) {
    const double fine = 1e-7; /* of products in single precision, whose factors are below 1 */
    size_t compared = 0;
    for (size_t i = 0; i < batch->splat_count; ++i) {
        size_t from = (size_t)lrint((double)batch->splats[i].center[0] * batch->model[0] * GRID);
        const psplat_texcoord *found = &batch->texcoords[i], *expected = &splats->texcoords[from];
        assert_true(from < splats->count);
        compare_pair(found->at, expected->at, splats->precision.unit > 0 ? 0 : fine);
        compare_pair(found->along_u, expected->along_u, fine);
        compare_pair(found->along_v, expected->along_v, fine);
        compare_pair(found->along_uu, expected->along_uu, fine);
        compare_pair(found->along_uv, expected->along_uv, fine);
        compare_pair(found->along_vv, expected->along_vv, fine);
        ++compared;
    }
    return compared;
}

static void compare_textures(const psplat_material *found, const psplat_material *expected) {
    const uint32_t images[] = {0, 2, 0, 1}; /* in the file, by those of the scene */
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        const psplat_texture *f = &found->textures[slot], *e = &expected->textures[slot];
        assert_int_equal(f->image, images[e->image]);
        if (!e->image) continue;
        assert_memory_equal(f->wrap, e->wrap, sizeof f->wrap);
        assert_int_equal(f->nearest, e->nearest);
        for (int k = 0; k < 6; ++k) assert_near(f->transform[k], e->transform[k], 1e-6);
        if (slot == PSPLAT_TEXTURE_NORMAL || slot == PSPLAT_TEXTURE_OCCLUSION)
            assert_near(f->strength, e->strength, 0);
    }
}

static void check_images(const psplat_asset *asset) {
    assert_int_equal(psplat_asset_image_count(asset), 2);
    const psplat_asset_image *first = psplat_asset_get_image(asset, 0);
    const psplat_asset_image *second = psplat_asset_get_image(asset, 1);
    assert_int_equal(first->size, 7);
    assert_memory_equal(first->data, image_bytes[2], 7);
    assert_string_equal(first->mime_type, "image/jpeg");
    assert_string_equal(first->name, "label");
    assert_int_equal(second->size, 5);
    assert_memory_equal(second->data, image_bytes[0], 5);
    assert_string_equal(second->mime_type, "image/png");
}

static void check_file(const written *w, const psplat_codec *codec, float low, float high) {
    psplat_image images[IMAGES];
    psplat_scene scene = textured_scene(images);
    psplat_splats splats = writer_splats(w, 3);
    size_t compared = 0, bare = 0;
    uint8_t *data;
    add_textures(&splats.materials[0]); /* One does not repeat: coordinates stay where they are. */
    add_texcoords(&splats, low, high);
    psplat_asset *asset = write_and_open(&scene, &splats, codec, &data);
    check_images(asset);
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        if (batch->has_texcoord) {
            compared += compare_texcoords(&splats, batch);
            compare_textures(&batch->material, &splats.materials[0]);
        } else {
            bare += batch->splat_count;
            assert_int_equal(batch->clip_count, PSPLAT_MAX_CLIP_LINES);
        }
    }
    assert_true(bare > 0);
    assert_int_equal(compared + bare, splats.count);
    psplat_asset_destroy(asset);
    free(data);
    psplat_splats_free(&splats);
    free_scene(&scene);
}

static void test_round_trip(void **state) {
    (void)state;
    const psplat_codec *codecs[] = {NULL, &psplat_meshopt_codec};
    written floats = {.count = COUNT, .size = 1, .has_slopes = 1};
    written integers = {.count = COUNT, .size = 1, .precision = usual_steps, .curved = 2};
    for (int i = 0; i < 2; ++i) {
        check_file(&floats, codecs[i], 0, 1);
        check_file(&integers, codecs[i], 0, 1);
        check_file(&integers, codecs[i], -1, 1);
        check_file(&integers, codecs[i], -40, 70);
    }
}

/* A file states version 3 where it has texture coordinates, and not without. */
static void test_version(void **state) {
    (void)state;
    written w = {.count = 20, .size = 1, .precision = usual_steps, .lines = 2};
    for (int textured = 0; textured < 2; ++textured) {
        psplat_image images[IMAGES];
        psplat_scene scene = textured_scene(images);
        psplat_splats splats = writer_splats(&w, 4);
        uint8_t *data = NULL;
        if (textured) add_texcoords(&splats, 0, 1);
        psplat_asset_destroy(write_and_open(&scene, &splats, NULL, &data));
        char *json = writer_json(data);
        assert_non_null(strstr(json, textured ? "\"version\":3" : "\"version\":2"));
        assert_int_equal(strstr(json, "TEXCOORD_0") != NULL, textured);
        assert_null(strstr(json, "TEXCOORD_UU"));
        assert_null(strstr(json, "images"));
        free(json);
        free(data);
        psplat_splats_free(&splats);
        free_scene(&scene);
    }
}

/* Counts how often a text occurs. */
static size_t count_of(const char *text, const char *part) {
    size_t count = 0;
    for (const char *at = strstr(text, part); at; at = strstr(at + 1, part)) ++count;
    return count;
}

/* Streams hold coordinates but for a coarse TEXCOORD_0: bytes where these are from 0 or -1 to 1.
 * Here it has the only bytes that are normalized. */
static void test_streamed(void **state) {
    (void)state;
    static const struct {
        float low, high;
        const char *type; /* NULL: floats */
    } cases[] = {{0, 1, "\"componentType\":5121,\"normalized\":true"},
                 {-1, 1, "\"componentType\":5120,\"normalized\":true"},
                 {-3, 1, NULL}};
    written w = {.count = 40, .size = 1, .precision = usual_steps, .lines = 6};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_image images[IMAGES];
        psplat_scene scene = textured_scene(images);
        psplat_splats splats = writer_splats(&w, 4);
        uint8_t *data = NULL;
        add_textures(&splats.materials[0]);
        add_texcoords(&splats, cases[i].low, cases[i].high);
        psplat_asset_destroy(write_and_open(&scene, &splats, &psplat_meshopt_codec, &data));
        char *json = writer_json(data);
        assert_non_null(strstr(json, "\"version\":4"));
        assert_int_equal(count_of(json, "TEXCOORD"), 1);
        assert_int_equal(count_of(json, "\"normalized\""), cases[i].type != NULL);
        if (cases[i].type) assert_non_null(strstr(json, cases[i].type));
        free(json);
        free(data);
        psplat_splats_free(&splats);
        free_scene(&scene);
    }
}

/* Returns the step of radii, a float as streams have it, with which n times the ratio of two radii
 * a step apart is n + part, as nearly as for any n up to 60. */
static double step_for(double part, int *n) {
    double least = HUGE_VAL, found = 0;
    for (int i = 2; i <= 60; ++i) {
        double step = (double)(float)log((i + part) / i);
        double off = fabs(i * (exp(step) - 1) - part);
        if (off < least) least = off, found = step, *n = i;
    }
    assert_in_range((long)(least * 1e12), 0, 5000); /* Near enough: 5e-9. */
    return found;
}

/* Two discs on a plane whose radii are a step apart. The change along u is n steps on the first, so
 * that on the second n + part are predicted. */
static void put_discs(psplat_splats *s, double part) {
    psplat_precision *p = &s->precision;
    int n = 0;
    p->scale_step = step_for(part, &n);
    for (int i = 0; i < 2; ++i) {
        psplat_splat *disc = &s->splats[i];
        psplat_texcoord texcoord = {.at = {0.25f, 0.25f}};
        *disc = s->splats[0];
        for (int k = 0; k < 3; ++k) disc->center[k] = (float)(4 * i * p->unit);
        for (int k = 0; k < 2; ++k)
            disc->radius[k] = (float)(p->unit * exp((100 + i) * p->scale_step));
        texcoord.along_u[0] = (float)(n * p->texcoord_slope_step);
        s->texcoords[i] = texcoord;
    }
    psplat_round_to_precision(s);
}

/* Where the last bits of a reader's arithmetic would decide what is predicted, coordinates stay in
 * accessors. */
static void test_ambiguous(void **state) {
    (void)state;
    written w = {.count = 2, .size = 1, .precision = usual_steps, .lines = 1};
    for (int ambiguous = 0; ambiguous < 2; ++ambiguous) {
        psplat_image images[IMAGES];
        psplat_scene scene = textured_scene(images);
        psplat_splats splats = writer_splats(&w, 4);
        uint8_t *data = NULL;
        add_texcoords(&splats, 0, 1);
        put_discs(&splats, ambiguous ? 0.51 : 0.35);
        psplat_asset_destroy(write_and_open(&scene, &splats, &psplat_meshopt_codec, &data));
        char *json = writer_json(data);
        assert_non_null(strstr(json, "\"version\":4"));
        assert_int_equal(strstr(json, "TEXCOORD_U") != NULL, ambiguous);
        free(json);
        free(data);
        psplat_splats_free(&splats);
        free_scene(&scene);
    }
}

/* The normal texture stands in the extension's own object, since glTF's own wants tangents. */
static void test_normal_texture(void **state) {
    (void)state;
    written w = {.count = 20, .size = 1, .precision = usual_steps, .lines = 1};
    psplat_image images[IMAGES];
    psplat_scene scene = textured_scene(images);
    psplat_splats splats = writer_splats(&w, 4);
    uint8_t *data = NULL;
    add_texcoords(&splats, 0, 1);
    splats.materials[0].textures[PSPLAT_TEXTURE_NORMAL] =
        (psplat_texture){.image = 1, .strength = 1};
    psplat_asset_destroy(write_and_open(&scene, &splats, NULL, &data));
    char *json = writer_json(data);
    assert_non_null(strstr(json, "\"PSPLAT_surface_splats\":{\"normalTexture\":{\"index\":0}}"));
    assert_null(strstr(json, "samplers"));
    assert_null(strstr(json, "KHR_texture_transform"));
    free(json);
    free(data);
    psplat_splats_free(&splats);
    free_scene(&scene);
}

static void test_refused(void **state) {
    (void)state;
    written w = {.count = 20, .size = 1, .precision = usual_steps, .lines = 1};
    psplat_scene scene = writer_scene(1);
    psplat_splats splats = writer_splats(&w, 4);
    uint8_t *data = NULL;
    size_t size;
    splats.runs[0].has_texcoord = 1;
    assert_int_equal(psplat_scene_write(&scene, &splats, NULL, &data, &size, NULL),
                     PSPLAT_ERROR_ARGUMENT); /* There are no coordinates. */
    splats.runs[0].has_texcoord = 0;
    add_texcoords(&splats, 0, 1);
    add_textures(&splats.materials[0]);
    assert_int_equal(psplat_scene_write(&scene, &splats, NULL, &data, &size, NULL),
                     PSPLAT_ERROR_ARGUMENT); /* The scene has no images. */
    memset(splats.materials[0].textures, 0, sizeof splats.materials[0].textures);
    splats.texcoords[7].along_v[1] = NAN;
    assert_int_equal(psplat_scene_write(&scene, &splats, NULL, &data, &size, NULL),
                     PSPLAT_ERROR_RANGE);
    assert_null(data);
    psplat_splats_free(&splats);
    psplat_scene_free(&scene);
}

int test_textured_file_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),     cmocka_unit_test(test_version),
        cmocka_unit_test(test_streamed),       cmocka_unit_test(test_ambiguous),
        cmocka_unit_test(test_normal_texture), cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
