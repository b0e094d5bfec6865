/* SPDX-License-Identifier: MIT
 *
 * test_own_resolve.c - tests what a host does with psplat_view.resolve and depth_only: a G-buffer
 * of its own, uniforms, lights that it filters, and shadow maps of its own. What it must get
 * follows from what the renderer's shadings and shadows give.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "core/matrix.h"
#include "reference_view.h"
#include "gl_canvas.h"
#include "host_gl.h"
#include "scene_asset.h"
#include "spy.h"

enum { SIZE = CANVAS_SIZE, PIXELS = SIZE * SIZE, OUTPUTS = 3 };

/* A host with a framebuffer of three float outputs and depth. */
typedef struct deferred {
    canvas *canvas; /* its renderer draws through the spy */
    spy spy;
    host_gl gl;
    GLuint framebuffer, textures[OUTPUTS + 1];
    float out[OUTPUTS][PIXELS * 4];
} deferred;

/* ---- the host's framebuffer ----------------------------------------------------------------- */

static GLuint make_texture(const host_gl *gl, GLenum format, int width, int height) {
    int is_depth = format == GL_DEPTH_COMPONENT32F;
    GLuint name;
    gl->GenTextures(1, &name);
    gl->ActiveTexture(GL_TEXTURE0 + PSPLAT_HOST_UNIT);
    gl->BindTexture(GL_TEXTURE_2D, name);
    gl->TexImage2D(GL_TEXTURE_2D, 0, (GLint)format, width, height, 0,
                   is_depth ? GL_DEPTH_COMPONENT : GL_RGBA, GL_FLOAT, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return name;
}

static void make_framebuffer(deferred *d) {
    static const GLenum buffers[OUTPUTS] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                            GL_COLOR_ATTACHMENT2};
    const host_gl *gl = &d->gl;
    gl->GenFramebuffers(1, &d->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    for (int i = 0; i <= OUTPUTS; ++i) {
        d->textures[i] =
            make_texture(gl, i < OUTPUTS ? GL_RGBA32F : GL_DEPTH_COMPONENT32F, SIZE, SIZE);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, i < OUTPUTS ? buffers[i] : GL_DEPTH_ATTACHMENT,
                                 GL_TEXTURE_2D, d->textures[i], 0);
    }
    gl->DrawBuffers(OUTPUTS, buffers);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
}

static deferred *deferred_create(psplat_api api) {
    psplat_error error = {0};
    deferred *d = calloc(1, sizeof *d);
    assert_non_null(d);
    d->canvas = canvas_create(api);
    psplat_renderer_destroy(d->canvas->renderer);
    d->spy = (spy){.get_proc = psplat_host_get_proc, .user = d->canvas->host};
    const psplat_renderer_desc desc = {.get_proc = spy_get_proc, .user = &d->spy};
    canvas_check(psplat_renderer_create(&desc, &d->canvas->renderer, &error), &error);
    d->gl = host_gl_of(d->canvas->host);
    make_framebuffer(d);
    return d;
}

static void deferred_destroy(deferred *d) {
    assert_string_equal(d->spy.trouble, "");
    psplat_renderer_destroy(d->canvas->renderer);
    d->canvas->renderer = NULL;
    assert_int_equal(spy_live(&d->spy), 0);
    canvas_destroy(d->canvas);
    free(d);
}

/* Clears the framebuffer, draws into it and reads it. */
static psplat_result deferred_draw(deferred *d, const psplat_view *view, const psplat_item *items,
                                   size_t count, psplat_error *error) {
    static const float zeros[4] = {0}, one = 1;
    const host_gl *gl = &d->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    for (int i = 0; i < OUTPUTS; ++i) gl->ClearBufferfv(GL_COLOR, i, zeros);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
    psplat_result result = psplat_draw(d->canvas->renderer, view, items, count, error);
    for (int i = 0; i < OUTPUTS; ++i) {
        gl->ReadBuffer(GL_COLOR_ATTACHMENT0 + (GLenum)i);
        gl->ReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT, d->out[i]);
    }
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
    return result;
}

static psplat_view make_view(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0.7, 0.9, 2.6}, (double[]){0, 0, 0});
    camera_perspective(&view, 120, 0.5, 8);
    return view;
}

/* Random splats with colours of their own, and a material of which every part differs from its
 * default. */
static scene make_scene(void) {
    scene s = scene_ellipses(60, 2, 7);
    s.has_color = 1;
    s.material.metallic = 0.3f;
    s.material.roughness = 0.6f;
    for (int i = 0; i < 3; ++i) s.material.emissive[i] = 0.1f * (float)(i + 1);
    return s;
}

static double greatest_difference(const float *a, const float *b, int channels) {
    double most = 0;
    for (int i = 0; i < PIXELS; ++i)
        for (int k = 0; k < channels; ++k)
            most = fmax(most, fabs((double)a[4 * i + k] - (double)b[4 * i + k]));
    return most;
}

/* ---- a G-buffer ------------------------------------------------------------------------------ */

static const char gbuffer[] = "layout(location = 0) out vec4 o_normal;\n"
                              "layout(location = 1) out vec4 o_albedo;\n"
                              "layout(location = 2) out vec4 o_emissive;\n"
                              "void resolve(Pixel pixel) {\n"
                              "    o_normal = vec4(0.5 + 0.5 * normalize(pixel.normal), 1.0);\n"
                              "    o_albedo = vec4(pixel.color, pixel.surface.x);\n"
                              "    o_emissive = vec4(pixel.emissive, pixel.surface.y);\n"
                              "}\n";

/* Outputs hold what the shadings show, in every mode, and depth is that of a shading. */
static void try_gbuffer(psplat_api api) {
    deferred *d = deferred_create(api);
    const psplat_resolve resolve = {.source = gbuffer};
    scene s = make_scene();
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(d->canvas, asset)};
    for (int mode = 0; mode < PSPLAT_MODE_PARAMETERS; ++mode) {
        psplat_error error = {0};
        psplat_view view = make_view();
        view.mode = (psplat_mode)mode;
        view.resolve = &resolve;
        canvas_check(deferred_draw(d, &view, &item, 1, &error), &error);
        view.resolve = NULL;
        view.shading = PSPLAT_SHADING_NORMAL;
        canvas_draw(d->canvas, &view, &item, 1);
        int covered = canvas_covered(d->canvas);
        assert_true(covered > PIXELS / 10);
        /* Roundings of a unit vector, and of an inverse square root that GL allows 2 ulp. */
        assert_true(greatest_difference(d->out[0], d->canvas->color, 4) < 1e-6);
        view.shading = PSPLAT_SHADING_UNLIT;
        canvas_draw(d->canvas, &view, &item, 1);
        assert_true(greatest_difference(d->out[1], d->canvas->color, 3) < 1e-6);
        for (int i = 0; i < PIXELS; ++i) {
            const float *emissive = &d->out[2][4 * i];
            if (!(d->out[0][4 * i + 3] > 0)) continue;
            for (int k = 0; k < 3; ++k)
                assert_true(fabsf(emissive[k] - s.material.emissive[k]) < 1e-6f);
            assert_true(fabsf(emissive[3] - 0.6f) < 1e-6f);
            assert_true(fabsf(d->out[1][4 * i + 3] - 0.3f) < 1e-6f);
        }
    }
    psplat_model_destroy(d->canvas->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

static void test_gbuffer(void **state) {
    (void)state;
    try_gbuffer(PSPLAT_API_GL);
    try_gbuffer(PSPLAT_API_GLES);
}

/* The outputs hold nothing where the host's geometry is nearer: half of the depth buffer is. */
static void test_hidden(void **state) {
    (void)state;
    deferred *d = deferred_create(PSPLAT_API_GL);
    const psplat_resolve resolve = {.source = gbuffer};
    scene s = scene_disc(1);
    psplat_asset *asset = scene_open(&s);
    psplat_item items[2] = {{.model = canvas_model(d->canvas, asset)}};
    items[1] = (psplat_item){.model = items[0].model,
                             .transform = {[0] = 1, [5] = 1, [10] = 1, [14] = 0.5, [15] = 1}};
    psplat_error error = {0};
    psplat_view view = make_view();
    camera_look(&view, (double[]){0, 0, 3}, (double[]){0, 0, 0});
    const host_gl *gl = &d->gl;
    const float zeros[4] = {0}, one = 1, near = 0;
    gl->BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    for (int i = 0; i < OUTPUTS; ++i) gl->ClearBufferfv(GL_COLOR, i, zeros);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Scissor(0, 0, SIZE / 2, SIZE);
    gl->ClearBufferfv(GL_DEPTH, 0, &near);
    gl->Disable(GL_SCISSOR_TEST);
    view.resolve = &resolve;
    canvas_check(psplat_draw(d->canvas->renderer, &view, items, 2, &error), &error);
    for (int i = 0; i < OUTPUTS; ++i) {
        gl->ReadBuffer(GL_COLOR_ATTACHMENT0 + (GLenum)i);
        gl->ReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT, d->out[i]);
        const float *row = &d->out[i][4 * SIZE * (SIZE / 2)];
        assert_true(row[4 * (SIZE / 2 - 3) + 3] == 0.0f);
    }
    assert_true(d->out[0][4 * (SIZE * (SIZE / 2) + SIZE / 2 + 3) + 3] == 1.0f);
    psplat_model_destroy(d->canvas->renderer, items[0].model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

/* Bytes a pixel are those of shadings that read as much (test_needs). */
static void test_reads(void **state) {
    (void)state;
    static const size_t bytes[] = {
        [PSPLAT_READS_MATERIAL] = 16 + 8 + 4 + 16,
        [PSPLAT_READS_COLOR] = 16 + 4 + 4 + 16,
        [PSPLAT_READS_NORMAL] = 16 + 4 + 4,
    };
    scene s = make_scene(), other = make_scene();
    other.material.roughness = 0.9f;
    psplat_asset *assets[2] = {scene_open(&s), scene_open(&other)};
    for (int reads = 0; reads <= PSPLAT_READS_NORMAL; ++reads) {
        psplat_error error = {0};
        deferred *d = deferred_create(PSPLAT_API_GL);
        const psplat_resolve resolve = {.source = gbuffer, .reads = (psplat_reads)reads};
        psplat_view view = make_view();
        psplat_item items[2];
        memset(items, 0, sizeof items);
        for (int i = 0; i < 2; ++i) items[i].model = canvas_model(d->canvas, assets[i]);
        view.resolve = &resolve;
        canvas_check(deferred_draw(d, &view, items, 2, &error), &error);
        assert_int_equal(psplat_renderer_memory(d->canvas->renderer).targets,
                         PIXELS * bytes[reads]);
        for (int i = 0; i < 2; ++i) psplat_model_destroy(d->canvas->renderer, items[i].model);
        deferred_destroy(d);
    }
    for (int i = 0; i < 2; ++i) psplat_asset_destroy(assets[i]);
    scene_free(&s);
    scene_free(&other);
}

static void expect_material(const deferred *d, int x, const psplat_material *material) {
    const float *albedo = &d->out[1][4 * (SIZE * (SIZE / 2) + x)];
    const float *emission = &d->out[2][4 * (SIZE * (SIZE / 2) + x)];
    /* A quotient of sums of one or two splats has a few roundings of 2^-24. */
    assert_true(fabsf(albedo[3] - material->metallic) < 1e-6f);
    assert_true(fabsf(emission[3] - material->roughness) < 1e-6f);
    for (int k = 0; k < 3; ++k) assert_true(fabsf(emission[k] - material->emissive[k]) < 1e-6f);
}

/* Two discs side by side keep their materials, whichever parts of them differ. */
static void test_materials(void **state) {
    (void)state;
    deferred *d = deferred_create(PSPLAT_API_GL);
    const psplat_resolve resolve = {.source = gbuffer};
    psplat_view view = make_view();
    camera_look(&view, (double[]){0, 0, 3}, (double[]){0, 0, 0});
    view.resolve = &resolve;
    for (int differs = 0; differs < 8; ++differs) {
        psplat_error error = {0};
        psplat_item items[2];
        psplat_material materials[2];
        memset(items, 0, sizeof items);
        for (int i = 0; i < 2; ++i) {
            scene s = scene_disc(0.5f);
            s.material.metallic = i && differs & 1 ? 0.7f : 0.3f;
            s.material.roughness = i && differs & 2 ? 0.9f : 0.6f;
            s.material.emissive[1] = i && differs & 4 ? 0.8f : 0.2f;
            s.origin[0] = i ? 0.6 : -0.6;
            materials[i] = s.material;
            psplat_asset *asset = scene_open(&s);
            items[i].model = canvas_model(d->canvas, asset);
            psplat_asset_destroy(asset);
            scene_free(&s);
        }
        canvas_check(deferred_draw(d, &view, items, 2, &error), &error);
        expect_material(d, SIZE / 2 - 24, &materials[0]);
        expect_material(d, SIZE / 2 + 24, &materials[1]);
        for (int i = 0; i < 2; ++i) psplat_model_destroy(d->canvas->renderer, items[i].model);
    }
    deferred_destroy(d);
}

/* ---- programs -------------------------------------------------------------------------------- */

/* What the callback was told. */
typedef struct told {
    const host_gl *gl;
    unsigned programs[8]; /* that were new */
    int calls, new_ones;
    float color[4];
} told;

static void use(void *user, unsigned program, int is_new) {
    told *t = user;
    GLint current = 0;
    t->gl->GetIntegerv(GL_CURRENT_PROGRAM, &current);
    assert_int_equal(current, program);
    ++t->calls;
    if (is_new) t->programs[t->new_ones++] = program;
    t->gl->Uniform4fv(t->gl->GetUniformLocation(program, "tint"), 1, t->color);
}

/* Uniforms arrive, and a program is new once, in each variant. */
static void test_uniforms(void **state) {
    (void)state;
    static const char source[] = "uniform vec4 tint;\n"
                                 "layout(location = 1) out vec4 o_tint;\n"
                                 "void resolve(Pixel pixel) { o_tint = tint; }\n";
    char copy[sizeof source];
    deferred *d = deferred_create(PSPLAT_API_GLES);
    told t = {.gl = &d->gl};
    psplat_resolve resolve = {.source = source, .use = use, .user = &t};
    scene s = scene_disc(1), colored = make_scene();
    psplat_asset *assets[2] = {scene_open(&s), scene_open(&colored)};
    psplat_item items[2] = {{.model = canvas_model(d->canvas, assets[0])},
                            {.model = canvas_model(d->canvas, assets[1])}};
    psplat_error error = {0};
    psplat_view view = make_view();
    view.resolve = &resolve;
    for (int frame = 0; frame < 4; ++frame) {
        /* Another copy of the text is the same function. */
        memcpy(copy, source, sizeof source);
        if (frame == 1) resolve.source = copy;
        t.color[frame] = (float)(frame + 1);
        size_t count = frame < 3 ? 1 : 2; /* colours take another variant */
        canvas_check(deferred_draw(d, &view, items, count, &error), &error);
        assert_memory_equal(&d->out[1][4 * (SIZE * SIZE / 2 + SIZE / 2)], t.color, sizeof t.color);
        assert_int_equal(t.calls, frame + 1);
        assert_int_equal(t.new_ones, frame < 3 ? 1 : 2);
    }
    assert_int_not_equal(t.programs[0], t.programs[1]);
    for (int i = 0; i < 2; ++i) psplat_model_destroy(d->canvas->renderer, items[i].model);
    for (int i = 0; i < 2; ++i) psplat_asset_destroy(assets[i]);
    scene_free(&s);
    scene_free(&colored);
    deferred_destroy(d);
}

/* A function whose output is a number of its own. */
static void write_numbered(int number, char *out, size_t size) {
    snprintf(out, size,
             "layout(location = 0) out vec4 o_number;\n"
             "void resolve(Pixel pixel) { o_number = vec4(%d.0); }\n",
             number);
}

/* However many functions a host makes, the programs of 16 are kept, and each draws what it should.
 */
static void test_many(void **state) {
    (void)state;
    enum { MANY = 50, KEPT = 16 };
    char source[200];
    deferred *d = deferred_create(PSPLAT_API_GL);
    scene s = scene_disc(1);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(d->canvas, asset)};
    psplat_resolve resolve = {.source = source};
    psplat_error error = {0};
    psplat_view view = make_view();
    canvas_draw(d->canvas, &view, &item, 1);
    size_t before = d->spy.live[SPY_PROGRAM];
    view.resolve = &resolve;
    for (int i = 0; i < MANY; ++i) {
        write_numbered(i, source, sizeof source);
        canvas_check(deferred_draw(d, &view, &item, 1, &error), &error);
        assert_true(d->out[0][4 * (SIZE * SIZE / 2 + SIZE / 2)] == (float)i);
        write_numbered(0, source, sizeof source); /* used in between, so it is never dropped */
        size_t made = d->spy.made;
        canvas_check(deferred_draw(d, &view, &item, 1, &error), &error);
        assert_true(d->out[0][4 * (SIZE * SIZE / 2 + SIZE / 2)] == 0.0f);
        assert_int_equal(d->spy.made, made);
        size_t kept = (size_t)(i + 1 < KEPT ? i + 1 : KEPT);
        assert_int_equal(d->spy.live[SPY_PROGRAM], before + kept);
        assert_int_equal(d->spy.live[SPY_SHADER], 0);
    }
    psplat_model_destroy(d->canvas->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

/* What GL says of the host's GLSL arrives with its lines; nothing leaks, and the renderer goes on.
 */
static void try_errors(psplat_api api) {
    static const struct {
        const char *source, *word;
    } cases[] = {
        {"\n\nvoid resolve(Pixel pixel) {\n    misspelt = 1;\n}\n", "misspelt"},
        {"void other(Pixel pixel) {}\n", "refused"},
        {"layout(location = 0) out vec4 o;\nvec3 resolve(Pixel pixel) { return o.rgb; }\n",
         "resolve"},
        {"", "refused"},
    };
    deferred *d = deferred_create(api);
    scene s = scene_disc(1);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(d->canvas, asset)};
    psplat_resolve resolve = {.source = NULL};
    psplat_view view = make_view();
    canvas_draw(d->canvas, &view, &item, 1);
    size_t before = spy_live(&d->spy);
    view.resolve = &resolve;
    for (size_t i = 0; i < 2 * sizeof cases / sizeof *cases; ++i) {
        psplat_error error = {0};
        resolve.source = cases[i / 2].source;
        psplat_result result = deferred_draw(d, &view, &item, 1, &error);
        assert_int_equal(result, PSPLAT_ERROR_GRAPHICS);
        if (!strstr(error.text, cases[i / 2].word)) fail_msg("%s", error.text);
        if (i == 0 && !strstr(error.text, "4")) fail_msg("no line 4: %s", error.text);
        assert_int_equal(spy_live(&d->spy), before);
    }
    psplat_error error = {0};
    resolve.source = NULL;
    assert_int_equal(deferred_draw(d, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
    resolve.source = gbuffer;
    resolve.reads = (psplat_reads)3;
    assert_int_equal(deferred_draw(d, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
    resolve.reads = PSPLAT_READS_MATERIAL;
    canvas_check(deferred_draw(d, &view, &item, 1, &error), &error);
    psplat_model_destroy(d->canvas->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

static void test_errors(void **state) {
    (void)state;
    try_errors(PSPLAT_API_GL);
    try_errors(PSPLAT_API_GLES);
}

/* ---- lights ---------------------------------------------------------------------------------- */

/* Filtered by 1 and 1/4, two lights give what lights of those colours do. */
static void test_filtered_light(void **state) {
    (void)state;
    static const char source[] =
        "layout(location = 0) out vec4 o_color;\n"
        "float light_part(int light, vec3 position, vec3 normal) {\n"
        "    return light == 1 ? 0.25 : abs(length(normal) - 1.0) < 1e-3 ? 1.0 : 0.0;\n"
        "}\n"
        "void resolve(Pixel pixel) {\n"
        "    o_color = vec4(encode(shade(pixel.normal, pixel.window, pixel.color,\n"
        "                                pixel.emissive, pixel.surface)), 1.0);\n"
        "}\n";
    deferred *d = deferred_create(PSPLAT_API_GL);
    const psplat_resolve resolve = {.source = source, .filters_light = 1};
    scene s = scene_sphere(200, 1);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(d->canvas, asset)};
    psplat_error error = {0};
    psplat_view view = make_view();
    view.light_count = 2;
    view.lights[1] = (psplat_light){.color = {2, 4, 8}, .direction = {-1, 0, 0}};
    view.resolve = &resolve;
    canvas_check(deferred_draw(d, &view, &item, 1, &error), &error);
    view.resolve = NULL;
    for (int i = 0; i < 3; ++i) view.lights[1].color[i] *= 0.25f;
    canvas_draw(d->canvas, &view, &item, 1);
    /* Radiances are up to 3, with roundings of 2^-24 of some ten operations. */
    assert_true(greatest_difference(d->out[0], d->canvas->color, 4) < 1e-5);
    psplat_model_destroy(d->canvas->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

/* ---- shadow maps of the host ----------------------------------------------------------------- */

/* The map is a part of a larger texture, as in an atlas. */
enum { MAP = 512, ATLAS = 600, MAP_X = 37, MAP_Y = 11 };

typedef struct shadow {
    const host_gl *gl;
    GLuint framebuffer, map;
    psplat_view light;
    float to_atlas[16]; /* from eye space to coordinates and depth in the atlas */
} shadow;

static void make_shadow(shadow *sh, const host_gl *gl) {
    static const GLenum none = GL_NONE;
    const float one = 1;
    *sh = (shadow){.gl = gl, .map = make_texture(gl, GL_DEPTH_COMPONENT32F, ATLAS, ATLAS)};
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl->GenFramebuffers(1, &sh->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, sh->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, sh->map, 0);
    gl->DrawBuffers(1, &none);
    gl->ReadBuffer(GL_NONE);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
}

/* A light camera around the origin that looks along a direction. */
static void aim_shadow(shadow *sh, const float direction[3], const psplat_view *view) {
    const double scale = (double)MAP / ATLAS;
    const double to_atlas[16] = {[0] = 0.5 * scale,
                                 [5] = 0.5 * scale,
                                 [10] = 0.5,
                                 [12] = 0.5 * scale + (double)MAP_X / ATLAS,
                                 [13] = 0.5 * scale + (double)MAP_Y / ATLAS,
                                 [14] = 0.5,
                                 [15] = 1};
    double eye[3], a[16], b[16];
    for (int i = 0; i < 3; ++i) eye[i] = -4.0 * (double)direction[i];
    sh->light = camera_view(MAP, MAP);
    camera_look(&sh->light, eye, (double[]){0, 0, 0});
    camera_parallel(&sh->light, 2.2, 1, 9);
    sh->light.x = MAP_X;
    sh->light.y = MAP_Y;
    sh->light.depth_only = 1;
    sh->light.culling = PSPLAT_CULL_NEVER;
    psplat_matrix_multiply(sh->light.projection, sh->light.view, a);
    psplat_matrix_multiply(to_atlas, a, b);
    assert_true(psplat_matrix_invert(view->view, a));
    double product[16];
    psplat_matrix_multiply(b, a, product);
    psplat_matrix_to_float(product, 16, sh->to_atlas);
}

static void use_shadow(void *user, unsigned program, int is_new) {
    const shadow *sh = user;
    const host_gl *gl = sh->gl;
    if (is_new) gl->Uniform1i(gl->GetUniformLocation(program, "map"), PSPLAT_HOST_UNIT);
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "to_atlas"), 1, GL_FALSE, sh->to_atlas);
    gl->ActiveTexture(GL_TEXTURE0 + PSPLAT_HOST_UNIT);
    gl->BindTexture(GL_TEXTURE_2D, sh->map);
}

static const char receiving[] =
    "uniform highp sampler2DShadow map;\n"
    "uniform mat4 to_atlas;\n"
    "layout(location = 0) out vec4 o_color;\n"
    "float light_part(int light, vec3 position, vec3 normal) {\n"
    "    vec4 at = to_atlas * vec4(position + 0.03 * normal, 1.0);\n"
    "    return texture(map, at.xyz);\n"
    "}\n"
    "void resolve(Pixel pixel) {\n"
    "    o_color = vec4(shade(pixel.normal, pixel.window, pixel.color, pixel.emissive,\n"
    "                         pixel.surface), 1.0);\n"
    "}\n";

/* A ball above a floor, lit from the side, with the renderer's shadows and with the host's. */
static void try_shadows(psplat_api api, int is_curved) {
    deferred *d = deferred_create(api);
    scene ball = scene_sphere(300, 0.5f), floor = scene_disc(1.6f);
    if (is_curved) scene_curve(&ball);
    ball.depth_tolerance = floor.depth_tolerance = 0.005f;
    psplat_asset *assets[2] = {scene_open(&ball), scene_open(&floor)};
    psplat_item items[2] = {
        {.model = canvas_model(d->canvas, assets[0])},
        {.model = canvas_model(d->canvas, assets[1]),
         .transform = {[0] = 1, [6] = -1, [9] = 1, [13] = -0.7, [15] = 1}},
    };
    psplat_error error = {0};
    psplat_view view = make_view();
    const float direction[3] = {0.6f, -0.8f, 0};
    memcpy(view.lights[0].direction, direction, sizeof direction);
    shadow sh;
    make_shadow(&sh, &d->gl);
    aim_shadow(&sh, direction, &view);
    canvas_check(psplat_draw(d->canvas->renderer, &sh.light, items, 2, &error), &error);
    assert_int_equal(psplat_renderer_memory(d->canvas->renderer).targets, 0);

    static float lit[PIXELS * 4];
    canvas_draw(d->canvas, &view, items, 2);
    memcpy(lit, d->canvas->color, sizeof lit);
    view.lights[0].casts_shadow = 1;
    view.shadow_size = MAP;
    canvas_draw(d->canvas, &view, items, 2);
    const psplat_resolve resolve = {
        .source = receiving, .filters_light = 1, .use = use_shadow, .user = &sh};
    view.lights[0].casts_shadow = 0;
    view.resolve = &resolve;
    canvas_check(deferred_draw(d, &view, items, 2, &error), &error);

    int dark = 0, differ = 0, covered = canvas_covered(d->canvas);
    for (int i = 0; i < PIXELS; ++i) {
        float shaded = d->canvas->color[4 * i];
        dark += lit[4 * i] - shaded > 0.2f;
        differ += fabsf(d->out[0][4 * i] - shaded) > 0.05f;
    }
    print_message("%d pixels, %d in shadow, %d differ\n", covered, dark, differ);
    assert_true(dark > 300);
    /* Texels of the two maps lie elsewhere, so that the shadow's outline, some hundred pixels
     * long, and the terminator differ in places. */
    assert_true(differ < dark / 8);
    for (int i = 0; i < 2; ++i) psplat_model_destroy(d->canvas->renderer, items[i].model);
    for (int i = 0; i < 2; ++i) psplat_asset_destroy(assets[i]);
    scene_free(&ball);
    scene_free(&floor);
    deferred_destroy(d);
}

static void test_shadows(void **state) {
    (void)state;
    try_shadows(PSPLAT_API_GL, 0);
    try_shadows(PSPLAT_API_GL, 1);
    try_shadows(PSPLAT_API_GLES, 1);
}

/* Depth alone: the middle of a disc has the depth of its plane and epsilon (spec 5.3) more, colours
 * stay, and the depth test of what is there holds. */
static void test_depth_only(void **state) {
    (void)state;
    const double near = 1, far = 9, distance = 3, tolerance = 0.01;
    deferred *d = deferred_create(PSPLAT_API_GL);
    scene s = scene_disc(1);
    s.depth_tolerance = (float)tolerance;
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(d->canvas, asset)};
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0, 0, distance}, (double[]){0, 0, 0});
    camera_parallel(&view, 2, near, far);
    view.depth_only = 1;
    canvas_draw(d->canvas, &view, &item, 1);
    assert_int_equal(canvas_covered(d->canvas), 0);
    const float *depth = d->canvas->depth;
    double wanted = (distance + tolerance - near) / (far - near);
    /* Depth buffers of 32-bit floats have steps of 6e-8 here; the shader adds a few roundings. */
    assert_true(fabs((double)depth[SIZE * SIZE / 2 + SIZE / 2] - wanted) < 1e-6);
    assert_true(depth[0] == 1.0f);
    int inside = 0;
    for (int i = 0; i < PIXELS; ++i) inside += depth[i] < 1.0f;
    /* A disc of a quarter of the view's width in radius; its outline is 200 pixels long. */
    assert_true(abs(inside - (int)(3.14159 * SIZE * SIZE / 16)) < 100);
    psplat_model_destroy(d->canvas->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
    deferred_destroy(d);
}

int test_own_resolve_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gbuffer),  cmocka_unit_test(test_hidden),
        cmocka_unit_test(test_reads),    cmocka_unit_test(test_materials),
        cmocka_unit_test(test_uniforms), cmocka_unit_test(test_many),
        cmocka_unit_test(test_errors),   cmocka_unit_test(test_filtered_light),
        cmocka_unit_test(test_shadows),  cmocka_unit_test(test_depth_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
