/* SPDX-License-Identifier: MIT
 *
 * Drawing and uploading leave the host's GL state as they found it, whatever it was, and touch no
 * pixel outside the view, behind the host's geometry or outside its scissor box.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "camera.h"
#include "canvas.h"
#include "scene.h"

#include <GLES3/gl3.h>

/* The functions that this test calls itself, as a host would. */
typedef struct host_gl {
    PFNGLENABLEPROC Enable;
    PFNGLDISABLEPROC Disable;
    PFNGLISENABLEDPROC IsEnabled;
    PFNGLGETINTEGERVPROC GetIntegerv;
    PFNGLGETFLOATVPROC GetFloatv;
    PFNGLBLENDFUNCSEPARATEPROC BlendFuncSeparate;
    PFNGLBLENDEQUATIONSEPARATEPROC BlendEquationSeparate;
    PFNGLDEPTHFUNCPROC DepthFunc;
    PFNGLDEPTHMASKPROC DepthMask;
    PFNGLCOLORMASKPROC ColorMask;
    PFNGLCULLFACEPROC CullFace;
    PFNGLFRONTFACEPROC FrontFace;
    PFNGLVIEWPORTPROC Viewport;
    PFNGLSCISSORPROC Scissor;
    PFNGLACTIVETEXTUREPROC ActiveTexture;
    PFNGLGENTEXTURESPROC GenTextures;
    PFNGLBINDTEXTUREPROC BindTexture;
    PFNGLGENSAMPLERSPROC GenSamplers;
    PFNGLBINDSAMPLERPROC BindSampler;
    PFNGLGENBUFFERSPROC GenBuffers;
    PFNGLBINDBUFFERPROC BindBuffer;
    PFNGLGENVERTEXARRAYSPROC GenVertexArrays;
    PFNGLBINDVERTEXARRAYPROC BindVertexArray;
    PFNGLPIXELSTOREIPROC PixelStorei;
    PFNGLCLEARCOLORPROC ClearColor;
    PFNGLCLEARBUFFERFVPROC ClearBufferfv;
    PFNGLGETERRORPROC GetError;
} host_gl;

static void load(psplat_host *host, const char *name, void *function) {
    void *address = psplat_host_get_proc(host, name);
    assert_non_null(address);
    memcpy(function, &address, sizeof address);
}

static host_gl load_all(psplat_host *host) {
    host_gl gl;
#define LOAD(name) load(host, "gl" #name, &gl.name)
    LOAD(Enable), LOAD(Disable), LOAD(IsEnabled), LOAD(GetIntegerv), LOAD(GetFloatv);
    LOAD(BlendFuncSeparate), LOAD(BlendEquationSeparate), LOAD(DepthFunc), LOAD(DepthMask);
    LOAD(ColorMask), LOAD(CullFace), LOAD(FrontFace), LOAD(Viewport), LOAD(Scissor);
    LOAD(ActiveTexture), LOAD(GenTextures), LOAD(BindTexture), LOAD(GenSamplers), LOAD(BindSampler);
    LOAD(GenBuffers), LOAD(BindBuffer), LOAD(GenVertexArrays), LOAD(BindVertexArray);
    LOAD(PixelStorei), LOAD(ClearColor), LOAD(ClearBufferfv), LOAD(GetError);
#undef LOAD
    return gl;
}

static const GLenum capabilities[] = {GL_BLEND,
                                      GL_CULL_FACE,
                                      GL_DEPTH_TEST,
                                      GL_DITHER,
                                      GL_POLYGON_OFFSET_FILL,
                                      GL_RASTERIZER_DISCARD,
                                      GL_SAMPLE_ALPHA_TO_COVERAGE,
                                      GL_SAMPLE_COVERAGE,
                                      GL_SCISSOR_TEST,
                                      GL_STENCIL_TEST};
static const GLenum integers[] = {GL_DRAW_FRAMEBUFFER_BINDING,
                                  GL_READ_FRAMEBUFFER_BINDING,
                                  GL_CURRENT_PROGRAM,
                                  GL_VERTEX_ARRAY_BINDING,
                                  GL_VIEWPORT,
                                  GL_SCISSOR_BOX,
                                  GL_BLEND_SRC_RGB,
                                  GL_BLEND_DST_RGB,
                                  GL_BLEND_SRC_ALPHA,
                                  GL_BLEND_DST_ALPHA,
                                  GL_BLEND_EQUATION_RGB,
                                  GL_BLEND_EQUATION_ALPHA,
                                  GL_DEPTH_FUNC,
                                  GL_DEPTH_WRITEMASK,
                                  GL_COLOR_WRITEMASK,
                                  GL_CULL_FACE_MODE,
                                  GL_FRONT_FACE,
                                  GL_ACTIVE_TEXTURE,
                                  GL_PIXEL_UNPACK_BUFFER_BINDING,
                                  GL_ARRAY_BUFFER_BINDING,
                                  GL_RENDERBUFFER_BINDING,
                                  GL_UNPACK_ALIGNMENT,
                                  GL_UNPACK_ROW_LENGTH,
                                  GL_UNPACK_SKIP_ROWS,
                                  GL_UNPACK_SKIP_PIXELS,
                                  GL_PACK_ALIGNMENT};
enum {
    CAPABILITIES = sizeof capabilities / sizeof *capabilities,
    INTEGERS = sizeof integers / sizeof *integers,
    UNITS = 8
};

typedef struct snapshot {
    GLboolean capabilities[CAPABILITIES];
    GLint integers[INTEGERS][4];
    GLint textures[UNITS], samplers[UNITS];
    GLfloat clear_color[4], clear_depth, depth_range[2];
} snapshot;

static void take(const host_gl *gl, snapshot *s) {
    memset(s, 0, sizeof *s);
    for (int i = 0; i < CAPABILITIES; ++i) s->capabilities[i] = gl->IsEnabled(capabilities[i]);
    for (int i = 0; i < INTEGERS; ++i) gl->GetIntegerv(integers[i], s->integers[i]);
    gl->GetFloatv(GL_COLOR_CLEAR_VALUE, s->clear_color);
    gl->GetFloatv(GL_DEPTH_CLEAR_VALUE, &s->clear_depth);
    gl->GetFloatv(GL_DEPTH_RANGE, s->depth_range);
    for (GLuint unit = 0; unit < UNITS; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->GetIntegerv(GL_TEXTURE_BINDING_2D, &s->textures[unit]);
        gl->GetIntegerv(GL_SAMPLER_BINDING, &s->samplers[unit]);
    }
    gl->ActiveTexture((GLenum)s->integers[17][0]);
}

static void expect_same(const snapshot *a, const snapshot *b) {
    for (int i = 0; i < CAPABILITIES; ++i)
        if (a->capabilities[i] != b->capabilities[i])
            fail_msg("capability 0x%x changed", capabilities[i]);
    for (int i = 0; i < INTEGERS; ++i)
        if (memcmp(a->integers[i], b->integers[i], sizeof a->integers[i]))
            fail_msg("state 0x%x changed from %d to %d", integers[i], a->integers[i][0],
                     b->integers[i][0]);
    assert_memory_equal(a, b, sizeof *a);
}

/* Everything away from its default. */
static void disturb(const host_gl *gl, int width) {
    GLuint names[2 * UNITS + 2];
    for (int i = 0; i < CAPABILITIES; ++i) gl->Enable(capabilities[i]);
    gl->Disable(GL_DITHER);
    gl->BlendFuncSeparate(GL_DST_COLOR, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_DST_ALPHA);
    gl->BlendEquationSeparate(GL_FUNC_SUBTRACT, GL_MIN);
    gl->DepthFunc(GL_GREATER);
    gl->DepthMask(GL_FALSE);
    gl->ColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    gl->CullFace(GL_FRONT);
    gl->FrontFace(GL_CW);
    gl->Viewport(3, 4, 50, 60);
    gl->Scissor(0, 0, width, CANVAS_SIZE);
    gl->ClearColor(0.1f, 0.2f, 0.3f, 0.4f);
    gl->GenTextures(UNITS, names);
    gl->GenSamplers(UNITS, names + UNITS);
    for (GLuint unit = 0; unit < UNITS; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->BindTexture(GL_TEXTURE_2D, names[unit]);
        gl->BindSampler(unit, names[UNITS + unit]);
    }
    gl->ActiveTexture(GL_TEXTURE3);
    gl->GenBuffers(1, names + 2 * UNITS);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, names[2 * UNITS]);
    gl->GenVertexArrays(1, names + 2 * UNITS + 1);
    gl->BindVertexArray(names[2 * UNITS + 1]);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 7);
    gl->PixelStorei(GL_UNPACK_SKIP_ROWS, 2);
    gl->PixelStorei(GL_UNPACK_SKIP_PIXELS, 3);
}

static psplat_view top_view(void) {
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    return view;
}

/* Uploads and draws under the disturbed state; the picture must be that of the default state,
 * where the scissor box lets it through. */
static void test_state(void **state) {
    canvas *c = *state;
    host_gl gl = load_all(c->host);
    scene s = scene_disc(0.8f);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = top_view();
    canvas_draw(c, &view, &item, 1);
    float *expected = malloc(sizeof c->color);
    assert_non_null(expected);
    memcpy(expected, c->color, sizeof c->color);

    psplat_error error = {0};
    snapshot before, after;
    canvas_begin(c);
    disturb(&gl, 64);
    take(&gl, &before);
    psplat_model *model = canvas_model(c, asset);
    take(&gl, &after);
    expect_same(&before, &after);
    psplat_model_destroy(c->renderer, item.model);
    item.model = model;
    for (int mode = PSPLAT_MODE_COUNT - 1; mode >= 0; --mode) {
        canvas_begin(c);
        disturb(&gl, 64);
        take(&gl, &before);
        view.mode = (psplat_mode)mode;
        canvas_check(psplat_draw(c->renderer, &view, &item, 1, &error), &error);
        take(&gl, &after);
        expect_same(&before, &after);
    }
    canvas_read(c);
    for (int y = 0; y < CANVAS_SIZE; ++y)
        for (int x = 0; x < CANVAS_SIZE; ++x) {
            float alpha = x < 64 ? expected[4 * (y * CANVAS_SIZE + x) + 3] : 0.0f;
            assert_true(canvas_pixel(c, x, y)[3] == alpha);
        }
    assert_int_equal(gl.GetError(), GL_NO_ERROR);
    free(expected);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Geometry of the host at window depth 0.3 in the left half and 0.7 in the right: the disc at 0.5
 * appears in the right half alone, and pixels outside the view keep their colour and depth. */
static void test_host_pixels(void **state) {
    canvas *c = *state;
    host_gl gl = load_all(c->host);
    scene s = scene_disc(0.8f);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = top_view();
    psplat_error error = {0};
    const float near_depth = 0.3f, far_depth = 0.7f, gray[4] = {0.5f, 0.5f, 0.5f, 0.25f};
    canvas_begin(c);
    gl.ClearBufferfv(GL_COLOR, 0, gray);
    gl.ClearBufferfv(GL_DEPTH, 0, &far_depth);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(0, 0, 64, CANVAS_SIZE);
    gl.ClearBufferfv(GL_DEPTH, 0, &near_depth);
    gl.Disable(GL_SCISSOR_TEST);
    canvas_check(psplat_draw(c->renderer, &view, &item, 1, &error), &error);
    canvas_read(c);
    int drawn = 0;
    for (int y = 0; y < CANVAS_SIZE; ++y)
        for (int x = 0; x < CANVAS_SIZE; ++x) {
            const float *p = canvas_pixel(c, x, y);
            float depth = c->depth[y * CANVAS_SIZE + x];
            int is_splat = p[3] == 1.0f;
            drawn += is_splat;
            if (x < 64) assert_false(is_splat);
            if (is_splat) assert_true(fabsf(depth - 0.5f) < 1e-6f);
            if (!is_splat) assert_memory_equal(p, gray, sizeof gray);
            if (!is_splat) assert_true(depth == (x < 64 ? near_depth : far_depth));
        }
    /* Half of pi 0.8^2 square units at 64^2 pixels each, give or take the rim. */
    assert_true(abs(drawn - 4118) < 60);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static int setup_gl(void **state) {
    *state = canvas_create(PSPLAT_API_GL);
    return 0;
}

static int setup_es(void **state) {
    *state = canvas_create(PSPLAT_API_GLES);
    return 0;
}

static int teardown(void **state) {
    canvas_destroy(*state);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_state, setup_gl, teardown),
        cmocka_unit_test_setup_teardown(test_state, setup_es, teardown),
        cmocka_unit_test_setup_teardown(test_host_pixels, setup_gl, teardown),
        cmocka_unit_test_setup_teardown(test_host_pixels, setup_es, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
