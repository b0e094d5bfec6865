/* SPDX-License-Identifier: MIT
 *
 * test_gl_state.c - tests that everything the runtime does leaves the host's GL state as it found
 * it, whatever it was, and changes no object of the host. A spy (spy.h) between runtime and GL
 * keeps what each call is about to change; a snapshot of more state finds changes that calls make
 * on the side. Where the host resets state, a frame must ask GL nothing and leave what
 * phongsplat.h says.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "host_gl.h"
#include "scene_asset.h"
#include "spy.h"

/* These exist only in GL. */
enum {
    POLYGON_MODE = 0x0B40,
    POLYGON_SMOOTH = 0x0B41,
    COLOR_LOGIC_OP = 0x0BF2,
    UNPACK_SWAP_BYTES = 0x0CF0,
    LINE = 0x1B01,
    FILL = 0x1B02,
    CLIP_DISTANCE0 = 0x3000,
    MULTISAMPLE = 0x809D,
    DEPTH_CLAMP = 0x864F,
    PROGRAM_POINT_SIZE = 0x8642,
    FRAMEBUFFER_SRGB = 0x8DB9,
    PRIMITIVE_RESTART = 0x8F9D,
    CUBE_MAP_SEAMLESS = 0x884F,
    SAMPLE_MASK = 0x8E51
};

static const GLenum capabilities[] = {
    GL_BLEND,
    GL_CULL_FACE,
    GL_DEPTH_TEST,
    GL_DITHER,
    GL_STENCIL_TEST,
    GL_POLYGON_OFFSET_FILL,
    GL_SAMPLE_COVERAGE,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SCISSOR_TEST,
    GL_RASTERIZER_DISCARD,
    SAMPLE_MASK,
    /* The rest exists only in GL. */
    COLOR_LOGIC_OP,
    FRAMEBUFFER_SRGB,
    MULTISAMPLE,
    POLYGON_SMOOTH,
    PRIMITIVE_RESTART,
    PROGRAM_POINT_SIZE,
    DEPTH_CLAMP,
    CUBE_MAP_SEAMLESS,
    CLIP_DISTANCE0,
    CLIP_DISTANCE0 + 7,
};
static const GLenum integers[] = {
    GL_DRAW_FRAMEBUFFER_BINDING,
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
    GL_ARRAY_BUFFER_BINDING,
    GL_PIXEL_UNPACK_BUFFER_BINDING,
    GL_PIXEL_PACK_BUFFER_BINDING,
    GL_UNIFORM_BUFFER_BINDING,
    GL_RENDERBUFFER_BINDING,
    GL_UNPACK_ALIGNMENT,
    GL_UNPACK_ROW_LENGTH,
    GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS,
    GL_PACK_ALIGNMENT,
    /* The rest exists only in GL. */
    POLYGON_MODE,
    UNPACK_SWAP_BYTES,
};
enum {
    ES_CAPABILITIES = 11,
    CAPABILITIES = sizeof capabilities / sizeof *capabilities,
    ES_INTEGERS = 28,
    INTEGERS = sizeof integers / sizeof *integers,
    UNITS = 16
};

typedef struct snapshot {
    GLboolean capabilities[CAPABILITIES];
    GLint integers[INTEGERS][4];
    GLint textures[UNITS], cubes[UNITS], samplers[UNITS];
    GLfloat clear_color[4], clear_depth, depth_range[2];
} snapshot;

typedef struct fixture {
    psplat_api api;
    int capability_count, integer_count; /* how many of them the context knows */
    canvas *canvas;                      /* its renderer draws through the spy */
    canvas *calm;                        /* another context with default state and without a spy */
    spy spy;
    host_gl gl;
    scene scene;
    psplat_asset *asset;
    psplat_view view;
    snapshot before;
} fixture;

static void take(const fixture *f, snapshot *s) {
    const host_gl *gl = &f->gl;
    GLint unit = 0;
    memset(s, 0, sizeof *s);
    for (int i = 0; i < f->capability_count; ++i)
        s->capabilities[i] = gl->IsEnabled(capabilities[i]);
    for (int i = 0; i < f->integer_count; ++i) gl->GetIntegerv(integers[i], s->integers[i]);
    gl->GetFloatv(GL_COLOR_CLEAR_VALUE, s->clear_color);
    gl->GetFloatv(GL_DEPTH_CLEAR_VALUE, &s->clear_depth);
    gl->GetFloatv(GL_DEPTH_RANGE, s->depth_range);
    gl->GetIntegerv(GL_ACTIVE_TEXTURE, &unit);
    for (GLuint i = 0; i < UNITS; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + i);
        gl->GetIntegerv(GL_TEXTURE_BINDING_2D, &s->textures[i]);
        gl->GetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &s->cubes[i]);
        gl->GetIntegerv(GL_SAMPLER_BINDING, &s->samplers[i]);
    }
    gl->ActiveTexture((GLenum)unit);
}

static void disturb_units(const host_gl *gl) {
    GLuint names[3 * UNITS];
    gl->GenTextures(2 * UNITS, names);
    gl->GenSamplers(UNITS, names + 2 * UNITS);
    for (GLuint unit = 0; unit < UNITS; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->BindTexture(GL_TEXTURE_2D, names[unit]);
        gl->BindTexture(GL_TEXTURE_CUBE_MAP, names[UNITS + unit]);
        gl->BindSampler(unit, names[2 * UNITS + unit]);
    }
    gl->ActiveTexture(GL_TEXTURE3);
}

static void disturb_unpacking(const fixture *f) {
    const host_gl *gl = &f->gl;
    GLuint name;
    gl->GenBuffers(1, &name);
    gl->BindBuffer(GL_ARRAY_BUFFER, name);
    gl->GenBuffers(1, &name);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, name);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 7);
    gl->PixelStorei(GL_UNPACK_SKIP_ROWS, 2);
    gl->PixelStorei(GL_UNPACK_SKIP_PIXELS, 3);
    if (f->api == PSPLAT_API_GL) gl->PixelStorei(UNPACK_SWAP_BYTES, 1);
}

/* Changes state that GLES does not have. */
static void disturb_desktop(const fixture *f) {
    PFNGLPOLYGONMODEPROC polygon_mode;
    host_gl_load(f->canvas->host, "glPolygonMode", &polygon_mode);
    polygon_mode(GL_FRONT_AND_BACK, LINE);
    f->gl.Disable(CUBE_MAP_SEAMLESS);
}

/* Changes all state to differ from its default and from what the runtime needs. */
static void disturb(const fixture *f) {
    const host_gl *gl = &f->gl;
    GLuint name;
    for (int i = 0; i < f->capability_count; ++i) gl->Enable(capabilities[i]);
    gl->Disable(GL_DITHER);
    if (f->api == PSPLAT_API_GL) disturb_desktop(f);
    gl->BlendFuncSeparate(GL_DST_COLOR, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_DST_ALPHA);
    gl->BlendEquationSeparate(GL_FUNC_SUBTRACT, GL_MIN);
    gl->DepthFunc(GL_GREATER);
    gl->DepthMask(GL_FALSE);
    gl->ColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    gl->CullFace(GL_FRONT);
    gl->FrontFace(GL_CW);
    gl->Viewport(3, 4, 50, 60);
    gl->Scissor(0, 0, CANVAS_SIZE / 2, CANVAS_SIZE);
    gl->ClearColor(0.1f, 0.2f, 0.3f, 0.4f);
    gl->GenVertexArrays(1, &name);
    gl->BindVertexArray(name);
    disturb_units(gl);
    disturb_unpacking(f);
}

/* ---- before and after ----------------------------------------------------------------------- */

static void begin(fixture *f) {
    f->gl.Disable(GL_RASTERIZER_DISCARD); /* otherwise the host could not clear */
    canvas_begin(f->canvas);
    disturb(f);
    take(f, &f->before);
    spy_begin(&f->spy);
}

static void expect_unchanged(fixture *f) {
    snapshot after;
    const char *changed = spy_changed(&f->spy);
    if (changed) fail_msg("%s", changed);
    if (f->spy.trouble[0]) fail_msg("%s", f->spy.trouble);
    take(f, &after);
    for (int i = 0; i < CAPABILITIES; ++i)
        if (f->before.capabilities[i] != after.capabilities[i])
            fail_msg("capability 0x%x changed", capabilities[i]);
    for (int i = 0; i < INTEGERS; ++i)
        if (memcmp(f->before.integers[i], after.integers[i], sizeof after.integers[i]) != 0)
            fail_msg("state 0x%x changed from %d to %d", integers[i], f->before.integers[i][0],
                     after.integers[i][0]);
    assert_memory_equal(&f->before, &after, sizeof after);
    assert_int_equal(f->gl.GetError(), GL_NO_ERROR);
}

/* The picture under the disturbed state equals that under the default state, where the host's
 * scissor box lets it through. */
static void expect_picture(fixture *f, const float *expected) {
    canvas_read(f->canvas);
    for (int y = 0; y < CANVAS_SIZE; ++y) {
        const float *row = canvas_pixel(f->canvas, 0, y), *right = row + 2 * CANVAS_SIZE;
        assert_memory_equal(row, expected + 4 * CANVAS_SIZE * y, 2 * CANVAS_SIZE * sizeof *row);
        for (int i = 0; i < 2 * CANVAS_SIZE; ++i) assert_true(right[i] == 0.0f);
    }
}

/* ---- what the runtime does ------------------------------------------------------------------ */

static void draw(fixture *f, const psplat_item *item, const psplat_item *calm_item) {
    psplat_error error = {0};
    canvas_draw(f->calm, &f->view, calm_item, 1);
    canvas_check(psplat_host_make_current(f->canvas->host, &error), &error);
    begin(f);
    canvas_check(psplat_draw(f->canvas->renderer, &f->view, item, 1, &error), &error);
    expect_unchanged(f);
    expect_picture(f, f->calm->color);
}

static psplat_light make_light(psplat_light_type type, int casts_shadow) {
    psplat_light light = {.type = type, .color = {2, 2, 2}, .direction = {0.2f, -0.3f, -1}};
    light.position[2] = 2.5;
    light.casts_shadow = casts_shadow;
    return light;
}

static psplat_view top_view(void) {
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    view.light_count = 3;
    view.lights[0] = make_light(PSPLAT_LIGHT_DIRECTIONAL, 0);
    view.lights[1] = make_light(PSPLAT_LIGHT_POINT, 0);
    view.lights[2] = make_light(PSPLAT_LIGHT_SPOT, 0);
    return view;
}

static void test_drawing(void **state) {
    fixture *f = *state;
    psplat_item item = {.model = canvas_model(f->canvas, f->asset)};
    canvas_begin(f->calm);
    psplat_item calm = {.model = canvas_model(f->calm, f->asset)};
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        f->view.mode = (psplat_mode)mode;
        draw(f, &item, &calm);
    }
    f->view.mode = PSPLAT_MODE_PHONG;
    for (int shading = 0; shading < PSPLAT_SHADING_COUNT; ++shading) {
        f->view.shading = (psplat_shading)shading;
        draw(f, &item, &calm);
    }
    psplat_model_destroy(f->canvas->renderer, item.model);
    canvas_begin(f->calm);
    psplat_model_destroy(f->calm->renderer, calm.model);
}

/* Textures of materials have units and samplers of their own. */
static void test_textures(void **state) {
    fixture *f = *state;
    psplat_error error = {0};
    psplat_item item = {.model = NULL};
    scene_add_textures(&f->scene);
    psplat_asset *asset = scene_open(&f->scene);
    begin(f);
    canvas_check(psplat_model_create(f->canvas->renderer, asset, &item.model, &error), &error);
    expect_unchanged(f);
    canvas_begin(f->calm);
    psplat_item calm = {.model = canvas_model(f->calm, asset)};
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        f->view.mode = (psplat_mode)mode;
        draw(f, &item, &calm);
    }
    begin(f);
    psplat_model_destroy(f->canvas->renderer, item.model);
    expect_unchanged(f);
    canvas_begin(f->calm);
    psplat_model_destroy(f->calm->renderer, calm.model);
    psplat_asset_destroy(asset);
}

static psplat_environment *make_environment(psplat_renderer *renderer) {
    static const float radiance[6 * 3] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1};
    const psplat_environment_desc desc = {radiance, 1};
    psplat_environment *environment = NULL;
    psplat_error error = {0};
    canvas_check(psplat_environment_create(renderer, &desc, &environment, &error), &error);
    return environment;
}

/* Adds cube maps, comparing samplers and another framebuffer: an environment and two shadow
 * maps. */
static void test_lights(void **state) {
    fixture *f = *state;
    psplat_item item = {.model = canvas_model(f->canvas, f->asset)};
    begin(f);
    psplat_environment *environment = make_environment(f->canvas->renderer);
    expect_unchanged(f);
    canvas_begin(f->calm);
    psplat_item calm = {.model = canvas_model(f->calm, f->asset)};
    psplat_environment *calm_environment = make_environment(f->calm->renderer);
    f->view.lights[0].casts_shadow = f->view.lights[2].casts_shadow = 1;
    f->view.shadow_size = 64;
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        f->view.mode = (psplat_mode)mode;
        f->view.environment = calm_environment;
        psplat_error error = {0};
        canvas_draw(f->calm, &f->view, &calm, 1);
        canvas_check(psplat_host_make_current(f->canvas->host, &error), &error);
        f->view.environment = environment;
        begin(f);
        canvas_check(psplat_draw(f->canvas->renderer, &f->view, &item, 1, &error), &error);
        expect_unchanged(f);
        expect_picture(f, f->calm->color);
    }
    begin(f);
    psplat_environment_destroy(f->canvas->renderer, environment);
    expect_unchanged(f);
    psplat_model_destroy(f->canvas->renderer, item.model);
    canvas_begin(f->calm);
    psplat_environment_destroy(f->calm->renderer, calm_environment);
    psplat_model_destroy(f->calm->renderer, calm.model);
}

/* The first frame makes targets, one of another size makes them anew, later ones reuse them. */
static void test_sizes(void **state) {
    fixture *f = *state;
    psplat_error error = {0};
    psplat_item item = {.model = canvas_model(f->canvas, f->asset)};
    static const int sizes[] = {1, 64, 64, 7, CANVAS_SIZE};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        f->view.width = f->view.height = sizes[i];
        begin(f);
        canvas_check(psplat_draw(f->canvas->renderer, &f->view, &item, 1, &error), &error);
        expect_unchanged(f);
    }
    psplat_model_destroy(f->canvas->renderer, item.model);
}

static void test_lives(void **state) {
    fixture *f = *state;
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_model *model = NULL;
    psplat_renderer_desc desc = {.get_proc = spy_get_proc, .user = &f->spy};
    begin(f);
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    expect_unchanged(f);
    begin(f);
    canvas_check(psplat_model_create(renderer, f->asset, &model, &error), &error);
    expect_unchanged(f);
    psplat_item item = {.model = model};
    canvas_check(psplat_draw(renderer, &f->view, &item, 1, &error), &error);
    begin(f);
    psplat_model_destroy(renderer, model);
    expect_unchanged(f);
    begin(f);
    psplat_renderer_destroy(renderer);
    expect_unchanged(f);
}

/* State is restored also where something fails. */
static void test_failures(void **state) {
    fixture *f = *state;
    static const spy_fault draw_faults[] = {SPY_FAULT_TEXTURE_MEMORY, SPY_FAULT_FRAMEBUFFER,
                                            SPY_FAULT_COMPILE, SPY_FAULT_LINK};
    psplat_item item = {.model = canvas_model(f->canvas, f->asset)};
    for (size_t i = 0; i < sizeof draw_faults / sizeof *draw_faults; ++i) {
        begin(f);
        f->spy.fault = draw_faults[i];
        f->spy.at = f->spy.happened = 0;
        psplat_error error = {0};
        psplat_result result = psplat_draw(f->canvas->renderer, &f->view, &item, 1, &error);
        assert_int_equal(result, i == 0 ? PSPLAT_ERROR_MEMORY : PSPLAT_ERROR_GRAPHICS);
        expect_unchanged(f);
    }
    for (int fault = SPY_FAULT_TEXTURE_MEMORY; fault <= SPY_FAULT_UPLOAD_MEMORY; ++fault) {
        psplat_model *model = NULL;
        begin(f);
        f->spy.fault = (spy_fault)fault;
        f->spy.at = f->spy.happened = 0;
        psplat_result result = psplat_model_create(f->canvas->renderer, f->asset, &model, NULL);
        assert_int_equal(result, PSPLAT_ERROR_MEMORY);
        expect_unchanged(f);
    }
    f->spy.fault = SPY_FAULT_NONE;
    psplat_model_destroy(f->canvas->renderer, item.model);
}

/* ---- a host that resets state ---------------------------------------------------------------- */

/* What phongsplat.h says that a frame leaves behind, of what glGetIntegerv tells. */
static const struct {
    GLenum name;
    GLint value[4];
} initial[] = {
    {GL_CURRENT_PROGRAM, {0}},
    {GL_VERTEX_ARRAY_BINDING, {0}},
    {GL_BLEND_SRC_RGB, {GL_ONE}},
    {GL_BLEND_DST_RGB, {GL_ZERO}},
    {GL_BLEND_SRC_ALPHA, {GL_ONE}},
    {GL_BLEND_DST_ALPHA, {GL_ZERO}},
    {GL_BLEND_EQUATION_RGB, {GL_FUNC_ADD}},
    {GL_BLEND_EQUATION_ALPHA, {GL_FUNC_ADD}},
    {GL_DEPTH_FUNC, {GL_LESS}},
    {GL_DEPTH_WRITEMASK, {GL_TRUE}},
    {GL_COLOR_WRITEMASK, {GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE}},
    {GL_CULL_FACE_MODE, {GL_BACK}},
    {GL_FRONT_FACE, {GL_CCW}},
    {GL_ACTIVE_TEXTURE, {GL_TEXTURE0}},
    {GL_ARRAY_BUFFER_BINDING, {0}},
    {GL_PIXEL_UNPACK_BUFFER_BINDING, {0}},
    {GL_UNPACK_ALIGNMENT, {4}},
    {GL_UNPACK_ROW_LENGTH, {0}},
    {GL_UNPACK_SKIP_ROWS, {0}},
    {GL_UNPACK_SKIP_PIXELS, {0}},
    {POLYGON_MODE, {FILL}},
    {UNPACK_SWAP_BYTES, {0}},
};

/* Capabilities that no frame touches. */
static int is_kept(GLenum capability) {
    return capability == FRAMEBUFFER_SRGB || capability == MULTISAMPLE ||
           capability == PROGRAM_POINT_SIZE;
}

static void expect_integer(const fixture *f, GLenum name, const GLint *now, const GLint *before) {
    const GLint view[4] = {0, 0, f->view.width, f->view.height};
    int is_view = name == GL_VIEWPORT || (name == GL_SCISSOR_BOX && !f->view.host.scissor_test);
    const GLint *wanted = is_view ? view : before;
    for (size_t k = 0; k < sizeof initial / sizeof *initial; ++k)
        if (initial[k].name == name) wanted = initial[k].value;
    /* Contexts tell one polygon mode or two. */
    size_t size = (name == POLYGON_MODE ? 1 : 4) * sizeof *now;
    if (memcmp(now, wanted, size) != 0)
        fail_msg("state 0x%x is %d and not %d", name, now[0], wanted[0]);
}

/* Framebuffer and scissor test are as the host said, and the first `units` texture units empty. */
static void expect_reset(const fixture *f, int units) {
    const snapshot *before = &f->before;
    snapshot now;
    take(f, &now);
    for (int i = 0; i < f->capability_count; ++i) {
        GLenum name = capabilities[i];
        int is_on = name == GL_DITHER || (name == GL_SCISSOR_TEST && f->view.host.scissor_test);
        int wanted = is_kept(name) ? before->capabilities[i] : is_on;
        if (now.capabilities[i] != wanted) fail_msg("capability 0x%x is not %d", name, wanted);
    }
    for (int i = 0; i < f->integer_count; ++i)
        expect_integer(f, integers[i], now.integers[i], before->integers[i]);
    for (int i = 0; i < UNITS; ++i) {
        assert_int_equal(now.textures[i], i < units ? 0 : before->textures[i]);
        assert_int_equal(now.cubes[i], i < units ? 0 : before->cubes[i]);
        assert_int_equal(now.samplers[i], i < units ? 0 : before->samplers[i]);
    }
    assert_memory_equal(now.clear_color, before->clear_color, sizeof now.clear_color);
    assert_memory_equal(now.depth_range, before->depth_range, sizeof now.depth_range);
    assert_int_equal(f->gl.GetError(), GL_NO_ERROR);
    if (f->spy.trouble[0]) fail_msg("%s", f->spy.trouble);
}

/* Draws a frame in disturbed state and returns how often it asks GL. */
static size_t draw_counted(fixture *f, psplat_renderer *renderer, const psplat_item *item) {
    psplat_error error = {0};
    GLint framebuffer = 0;
    begin(f);
    f->gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    f->view.host = (psplat_host_state){.framebuffer = (unsigned)framebuffer, .scissor_test = 1};
    f->spy.queries = 0;
    canvas_check(psplat_draw(renderer, &f->view, item, 1, &error), &error);
    return f->spy.queries;
}

static void try_reset(fixture *f, const psplat_asset *asset, int units) {
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_renderer_desc desc = {.get_proc = spy_get_proc,
                                 .user = &f->spy,
                                 .images = scene_images(),
                                 .state = PSPLAT_STATE_HOST_RESETS};
    canvas_begin(f->calm);
    psplat_item calm = {.model = canvas_model(f->calm, asset)};
    canvas_draw(f->calm, &f->view, &calm, 1);
    psplat_model_destroy(f->calm->renderer, calm.model);
    canvas_check(psplat_host_make_current(f->canvas->host, &error), &error);
    psplat_item restored = {.model = canvas_model(f->canvas, asset)}, item = {.model = NULL};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    canvas_check(psplat_model_create(renderer, asset, &item.model, &error), &error);

    draw_counted(f, f->canvas->renderer, &restored);
    size_t queries = draw_counted(f, f->canvas->renderer, &restored);
    print_message("%zu queries a frame where state is restored\n", queries);
    assert_true(queries > 50);
    assert_true(draw_counted(f, renderer, &item) > 0); /* it makes programs and targets */
    expect_reset(f, units);
    assert_int_equal(draw_counted(f, renderer, &item), 0);
    expect_reset(f, units);
    expect_picture(f, f->calm->color);
    psplat_model_destroy(renderer, item.model);
    psplat_renderer_destroy(renderer);
    psplat_model_destroy(f->canvas->renderer, restored.model);
}

static void test_resets(void **state) {
    fixture *f = *state;
    try_reset(f, f->asset, 9);
    f->view.lights[0].casts_shadow = 1;
    f->view.shadow_size = 64;
    try_reset(f, f->asset, 9);
    scene_add_textures(&f->scene);
    psplat_asset *asset = scene_open(&f->scene);
    try_reset(f, asset, 14);
    psplat_asset_destroy(asset);
}

/* A view outside of which nothing is drawn leaves the same behind, and so does one that fails. */
static void test_resets_always(void **state) {
    fixture *f = *state;
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_item item = {.model = NULL};
    psplat_renderer_desc desc = {
        .get_proc = spy_get_proc, .user = &f->spy, .state = PSPLAT_STATE_HOST_RESETS};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    canvas_check(psplat_model_create(renderer, f->asset, &item.model, &error), &error);
    draw_counted(f, renderer, &item);
    f->view.view[12] += 1000;
    assert_int_equal(draw_counted(f, renderer, &item), 0);
    expect_reset(f, 9);
    f->view.view[12] -= 1000;
    for (int tests = 0; tests < 2; ++tests) {
        GLint framebuffer = 0;
        begin(f);
        f->gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
        f->view.host = (psplat_host_state){(unsigned)framebuffer, tests, {0, 0}};
        canvas_check(psplat_draw(renderer, &f->view, &item, 1, &error), &error);
        expect_reset(f, 9);
    }
    f->view.shading = PSPLAT_SHADING_TOON;
    begin(f);
    f->spy.fault = SPY_FAULT_COMPILE;
    f->spy.at = f->spy.happened = 0;
    assert_int_equal(psplat_draw(renderer, &f->view, &item, 1, &error), PSPLAT_ERROR_GRAPHICS);
    expect_reset(f, 9);
    f->spy.fault = SPY_FAULT_NONE;
    psplat_model_destroy(renderer, item.model);
    psplat_renderer_destroy(renderer);
}

/* A loss is noticed by the call without items, and from then on by each. */
static void test_resets_loss(void **state) {
    fixture *f = *state;
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_item item = {.model = NULL};
    psplat_renderer_desc desc = {
        .get_proc = spy_get_proc, .user = &f->spy, .state = PSPLAT_STATE_HOST_RESETS};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    canvas_check(psplat_model_create(renderer, f->asset, &item.model, &error), &error);
    draw_counted(f, renderer, &item);
    assert_int_equal(psplat_draw(renderer, &f->view, NULL, 0, &error), PSPLAT_OK);
    f->spy.no_reset_status = 1; /* as WebGL has none */
    f->spy.fault = SPY_FAULT_LOST;
    f->spy.at = 0;
    f->spy.calls = 0;
    assert_int_equal(psplat_draw(renderer, &f->view, &item, 1, &error), PSPLAT_OK);
    assert_int_equal(psplat_draw(renderer, &f->view, NULL, 0, &error), PSPLAT_ERROR_GRAPHICS);
    assert_int_equal(psplat_draw(renderer, &f->view, &item, 1, &error), PSPLAT_ERROR_GRAPHICS);
    assert_non_null(strstr(error.text, "lost"));
    psplat_model_destroy(renderer, item.model);
    psplat_renderer_destroy(renderer);
    f->spy.fault = SPY_FAULT_NONE;
}

/* ---- the spy ----------------------------------------------------------------------------------
 */

/* The spy reports state that is left changed, changes of objects of the host, and functions without
 * a row. */
static void test_spy(void **state) {
    fixture *f = *state;
    PFNGLDEPTHFUNCPROC depth_func;
    PFNGLENABLEPROC enable;
    PFNGLTEXPARAMETERIPROC parameter;
    void *address = spy_get_proc(&f->spy, "glDepthFunc");
    memcpy(&depth_func, &address, sizeof address);
    address = spy_get_proc(&f->spy, "glEnable");
    memcpy(&enable, &address, sizeof address);
    address = spy_get_proc(&f->spy, "glTexParameteri");
    memcpy(&parameter, &address, sizeof address);

    begin(f);
    depth_func(GL_ALWAYS);
    assert_non_null(strstr(spy_changed(&f->spy), "glDepthFunc"));
    depth_func(GL_GREATER);
    assert_null(spy_changed(&f->spy));
    enable(GL_DITHER);
    assert_non_null(strstr(spy_changed(&f->spy), "glEnable"));
    f->gl.Disable(GL_DITHER);
    expect_unchanged(f);
    parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    assert_non_null(strstr(f->spy.trouble, "glTexParameteri"));
    assert_null(spy_get_proc(&f->spy, "glHint"));
    assert_non_null(strstr(f->spy.trouble, "glHint"));
}

/* ---- fixtures ------------------------------------------------------------------------------- */

static int setup(void **state, psplat_api api) {
    psplat_error error = {0};
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->api = api;
    f->calm = canvas_create(api);
    f->canvas = canvas_create(api);
    psplat_renderer_destroy(f->canvas->renderer);
    f->spy = (spy){.get_proc = psplat_host_get_proc, .user = f->canvas->host};
    psplat_renderer_desc desc = {
        .get_proc = spy_get_proc, .user = &f->spy, .images = scene_images()};
    canvas_check(psplat_renderer_create(&desc, &f->canvas->renderer, &error), &error);
    f->gl = host_gl_of(f->canvas->host);
    int is_gl = api == PSPLAT_API_GL;
    GLint version[2] = {0};
    f->gl.GetIntegerv(GL_MAJOR_VERSION, &version[0]);
    f->gl.GetIntegerv(GL_MINOR_VERSION, &version[1]);
    int has_mask = is_gl || version[0] * 10 + version[1] >= 31;
    f->capability_count = is_gl ? CAPABILITIES : ES_CAPABILITIES - !has_mask;
    f->integer_count = is_gl ? INTEGERS : ES_INTEGERS;
    f->scene = scene_ellipses(40, 2, 5);
    f->asset = scene_open(&f->scene);
    f->view = top_view();
    *state = f;
    return 0;
}

static int setup_gl(void **state) {
    return setup(state, PSPLAT_API_GL);
}

static int setup_es(void **state) {
    return setup(state, PSPLAT_API_GLES);
}

static int teardown(void **state) {
    fixture *f = *state;
    canvas_begin(f->calm);
    canvas_destroy(f->calm);
    canvas_begin(f->canvas);
    canvas_destroy(f->canvas);
    psplat_asset_destroy(f->asset);
    scene_free(&f->scene);
    free(f);
    return 0;
}

#define BOTH(test)                                                                                 \
    cmocka_unit_test_setup_teardown(test, setup_gl, teardown),                                     \
        cmocka_unit_test_setup_teardown(test, setup_es, teardown)

int test_gl_state_main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(test_drawing),       BOTH(test_lights),      BOTH(test_sizes),    BOTH(test_lives),
        BOTH(test_failures),      BOTH(test_spy),         BOTH(test_textures), BOTH(test_resets),
        BOTH(test_resets_always), BOTH(test_resets_loss),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
