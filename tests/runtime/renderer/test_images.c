/* SPDX-License-Identifier: MIT
 *
 * test_images.c - tests how images come from the host (psplat_images): each is asked for as often
 * as promised, released as often, and counted; loaders that fail or are missing; textures of the
 * host; and that scenes without textures have no code, texel or sampler for them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "gl_canvas.h"
#include "host_gl.h"
#include "ledger.h"
#include "reference_view.h"
#include "scene_asset.h"
#include "spy.h"

/* Bytes of a splat with a gamma, which textured scenes store, and without; bytes of its
 * coordinates; splats in a row. */
enum { SIZE = 32, WIDE = 64, NARROW = 48, TEXCOORD = 24, ROW = 512 };

/* A loader that counts. */
typedef struct loader {
    psplat_host *host;
    int loads, colors, releases;
    int fail_at;          /* the load, counted from 0, that fails; -1: none */
    psplat_pixels pixels; /* what it returns where rgba or texture is set */
} loader;

/* A renderer that draws through a spy and a ledger. */
typedef struct fixture {
    loader loader;
    spy spy;
    ledger ledger;
    psplat_renderer *renderer;
    psplat_view view;
    float color[SIZE * SIZE * 4];
} fixture;

static psplat_result load(void *user, const psplat_asset_image *image, int is_srgb,
                          psplat_pixels *pixels, psplat_error *error) {
    loader *l = user;
    assert_non_null(error);
    if (l->loads++ == l->fail_at) {
        error->code = PSPLAT_ERROR_FORMAT;
        strcpy(error->text, "not an image");
        return PSPLAT_ERROR_FORMAT;
    }
    l->colors += is_srgb;
    *pixels = l->pixels;
    if (!l->pixels.rgba && !l->pixels.texture && l->pixels.width == 0)
        return scene_images().load(NULL, image, is_srgb, pixels, error);
    return PSPLAT_OK;
}

static void release(void *user, psplat_pixels *pixels) {
    loader *l = user;
    assert_true(pixels->rgba || pixels->texture || pixels->width == 77);
    ++l->releases;
}

/* Names of all functions go through the spy; the sources of shaders are looked into. */
static struct {
    PFNGLSHADERSOURCEPROC real;
    int with_textures;
} sources;

static void APIENTRY watch_source(GLuint shader, GLsizei count, const GLchar *const *strings,
                                  const GLint *lengths) {
    for (GLsizei i = 0; i < count; ++i)
        if (strstr(strings[i], "u_texcoords")) ++sources.with_textures;
    sources.real(shader, count, strings, lengths);
}

static void *get_proc(void *user, const char *name) {
    void *address = spy_get_proc(user, name);
    if (strcmp(name, "glShaderSource") != 0) return address;
    memcpy(&sources.real, &address, sizeof address);
    PFNGLSHADERSOURCEPROC mine = watch_source;
    memcpy(&address, &mine, sizeof address);
    return address;
}

static fixture *open_fixture(int has_loader) {
    psplat_error error = {0};
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->loader.fail_at = f->ledger.fail_at = -1;
    canvas_check(psplat_host_create(PSPLAT_API_GL, 1, &f->loader.host, &error), &error);
    f->spy = (spy){.get_proc = psplat_host_get_proc, .user = f->loader.host};
    psplat_renderer_desc desc = {
        .get_proc = get_proc, .user = &f->spy, .allocator = ledger_allocator(&f->ledger)};
    if (has_loader)
        desc.images = (psplat_images){.load = load, .release = release, .user = &f->loader};
    sources.with_textures = 0;
    canvas_check(psplat_renderer_create(&desc, &f->renderer, &error), &error);
    f->view = camera_view(SIZE, SIZE);
    camera_look(&f->view, (double[]){0, 0, 3}, (double[]){0, 0, 0});
    camera_parallel(&f->view, 1, 1, 5);
    f->view.shading = PSPLAT_SHADING_UNLIT;
    return f;
}

static void close_fixture(fixture *f) {
    psplat_renderer_destroy(f->renderer);
    assert_int_equal(f->ledger.bytes, 0);
    assert_int_equal(spy_live(&f->spy), 0);
    assert_string_equal(f->spy.trouble, "");
    psplat_host_destroy(f->loader.host);
    free(f);
}

static psplat_asset *open_disc(int is_textured, int only_draws) {
    scene s = scene_disc(2);
    size_t size = 0;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    const psplat_asset_desc desc = {.only_draws = only_draws};
    if (is_textured) scene_add_textures(&s);
    uint8_t *data = scene_glb(&s, &size);
    canvas_check(psplat_asset_open_memory(data, size, &desc, &asset, &error), &error);
    free(data);
    scene_free(&s);
    return asset;
}

static psplat_model *make(fixture *f, const psplat_asset *asset) {
    psplat_error error = {0};
    psplat_model *model = NULL;
    canvas_check(psplat_model_create(f->renderer, asset, &model, &error), &error);
    return model;
}

/* Draws a model and destroys it. */
static void show(fixture *f, psplat_model *model) {
    static const float black[4] = {0};
    psplat_error error = {0};
    const psplat_item item = {.model = model};
    canvas_check(psplat_host_begin(f->loader.host, SIZE, SIZE, 1, black, &error), &error);
    canvas_check(psplat_draw(f->renderer, &f->view, &item, 1, &error), &error);
    canvas_check(psplat_host_read_float(f->loader.host, f->color, &error), &error);
    psplat_model_destroy(f->renderer, model);
}

static int is_white(const fixture *f) {
    int is = 1;
    for (size_t i = 0; i < sizeof f->color / sizeof *f->color; ++i) is &= f->color[i] == 1.0f;
    return is;
}

/* ---- what a scene takes --------------------------------------------------------------------- */

/* One image that is used as colours and as other numbers: two textures of 2 x 2 and 1 x 1 texels.
 * The splat has a row of its own and one of coordinates. The loader's pixels are released at once.
 */
static void test_counts(void **state) {
    (void)state;
    for (int only_draws = 0; only_draws < 2; ++only_draws) {
        fixture *f = open_fixture(1);
        psplat_asset *asset = open_disc(1, only_draws);
        psplat_model *model = make(f, asset);
        psplat_asset_destroy(asset);
        assert_int_equal(f->loader.loads, 2);
        assert_int_equal(f->loader.colors, 1);
        assert_int_equal(f->loader.releases, 2);
        size_t bytes = ROW * (WIDE + TEXCOORD) + 2 * (4 + 1) * 4;
        assert_int_equal(psplat_renderer_memory(f->renderer).models, bytes);
        assert_int_equal(psplat_model_describe(model).bytes, bytes);
        show(f, model);
        assert_false(is_white(f));
        assert_true(sources.with_textures > 0);
        assert_int_equal(psplat_renderer_memory(f->renderer).models, 0);
        assert_int_equal(f->loader.releases, 2);
        assert_int_equal(f->spy.live[SPY_SAMPLER], 1);
        close_fixture(f);
    }
}

static void test_without_textures(void **state) {
    (void)state;
    for (int has_loader = 0; has_loader < 2; ++has_loader)
        for (int is_textured = 0; is_textured < 2 - has_loader; ++is_textured) {
            fixture *f = open_fixture(has_loader);
            psplat_asset *asset = open_disc(is_textured, 0);
            psplat_model *model = make(f, asset);
            assert_int_equal(psplat_renderer_memory(f->renderer).models,
                             ROW * (is_textured ? WIDE : NARROW));
            show(f, model);
            assert_true(is_white(f));
            assert_int_equal(sources.with_textures, 0);
            assert_int_equal(f->loader.loads, 0);
            assert_int_equal(f->spy.live[SPY_SAMPLER], 0);
            psplat_asset_destroy(asset);
            close_fixture(f);
        }
}

/* ---- loaders that fail ---------------------------------------------------------------------- */

static void expect_refusal(fixture *f, psplat_result code, const char *says) {
    psplat_error error = {0};
    psplat_asset *asset = open_disc(1, 0);
    psplat_model *model = NULL;
    assert_int_equal(psplat_model_create(f->renderer, asset, &model, &error), code);
    assert_null(model);
    assert_int_equal(error.code, code);
    if (!strstr(error.text, says)) fail_msg("%s", error.text);
    assert_int_equal(psplat_model_create(f->renderer, asset, &model, NULL), code);
    assert_int_equal(psplat_renderer_memory(f->renderer).models, 0);
    psplat_asset_destroy(asset);
}

static void test_failing(void **state) {
    (void)state;
    for (int at = 0; at < 2; ++at) {
        fixture *f = open_fixture(1);
        psplat_error error = {0};
        psplat_model *model = NULL;
        psplat_asset *asset = open_disc(1, 0);
        f->loader.fail_at = at;
        assert_int_equal(psplat_model_create(f->renderer, asset, &model, &error),
                         PSPLAT_ERROR_FORMAT);
        assert_string_equal(error.text, "not an image");
        assert_int_equal(f->loader.releases, at);
        assert_int_equal(psplat_renderer_memory(f->renderer).models, 0);
        psplat_asset_destroy(asset);
        close_fixture(f);
    }
}

static void test_bad_pixels(void **state) {
    (void)state;
    fixture *f = open_fixture(1);
    static const uint8_t some[4] = {0};
    f->loader.pixels = (psplat_pixels){.width = 77, .height = 1};
    expect_refusal(f, PSPLAT_ERROR_ARGUMENT, "no pixels");
    f->loader.pixels = (psplat_pixels){.rgba = some, .width = 1, .height = 1u << 20};
    expect_refusal(f, PSPLAT_ERROR_RANGE, "1 x 1048576 pixels");
    assert_int_equal(f->loader.releases, f->loader.loads);
    close_fixture(f);
}

/* ---- textures of the host ------------------------------------------------------------------- */

/* The host's texture is sampled, kept, and handed back with the model. */
static void test_host_texture(void **state) {
    (void)state;
    static const uint8_t texel[4] = {255, 0, 255, 255};
    fixture *f = open_fixture(1);
    host_gl gl = host_gl_of(f->loader.host);
    GLuint name = 0;
    PFNGLTEXIMAGE2DPROC tex_image;
    host_gl_load(f->loader.host, "glTexImage2D", &tex_image);
    gl.GenTextures(1, &name);
    gl.BindTexture(GL_TEXTURE_2D, name);
    tex_image(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, texel);
    f->loader.pixels = (psplat_pixels){.texture = name};
    psplat_asset *asset = open_disc(1, 0);
    psplat_model *model = make(f, asset);
    assert_int_equal(f->loader.releases, 0);
    assert_int_equal(psplat_model_describe(model).bytes, ROW * (WIDE + TEXCOORD));
    show(f, model);
    assert_int_equal(f->loader.releases, 2);
    assert_true(f->color[0] == 1 && f->color[1] == 0 && f->color[2] == 1);
    psplat_asset_destroy(asset);
    close_fixture(f); /* the spy would complain if the texture were deleted */
}

int test_images_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),       cmocka_unit_test(test_without_textures),
        cmocka_unit_test(test_failing),      cmocka_unit_test(test_bad_pixels),
        cmocka_unit_test(test_host_texture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
