/* SPDX-License-Identifier: MIT
 *
 * gl_state.c - reads or assumes, sets and restores the host's GL state, mostly by tables of names.
 */
#include "gl/gl_state.h"

#include <stddef.h>
#include <string.h>

static const struct {
    GLenum name;
    int es_version;     /* 10 major + minor of the first GLES that has it; 0: none has */
    GLboolean starting; /* the value that passes and uploads start from */
} capabilities[PSPLAT_GL_CAPABILITY_COUNT] = {
    {GL_BLEND, 30, GL_FALSE},
    {GL_CULL_FACE, 30, GL_FALSE},
    {GL_DEPTH_TEST, 30, GL_FALSE},
    {GL_DITHER, 30, GL_FALSE},
    {GL_POLYGON_OFFSET_FILL, 30, GL_FALSE},
    {GL_RASTERIZER_DISCARD, 30, GL_FALSE},
    {GL_SAMPLE_ALPHA_TO_COVERAGE, 30, GL_FALSE},
    {GL_SAMPLE_COVERAGE, 30, GL_FALSE},
    {GL_SCISSOR_TEST, 30, GL_FALSE},
    {GL_STENCIL_TEST, 30, GL_FALSE},
    {GL_SAMPLE_MASK, 31, GL_FALSE},
    {GL_COLOR_LOGIC_OP, 0, GL_FALSE},
    {GL_DEPTH_CLAMP, 0, GL_FALSE},
    {GL_POLYGON_SMOOTH, 0, GL_FALSE},
    {GL_PRIMITIVE_RESTART, 0, GL_FALSE},        /* some drivers heed it without indices, too */
    {GL_TEXTURE_CUBE_MAP_SEAMLESS, 0, GL_TRUE}, /* GLES is always seamless */
    {GL_CLIP_DISTANCE0, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 1, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 2, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 3, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 4, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 5, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 6, 0, GL_FALSE},
    {GL_CLIP_DISTANCE0 + 7, 0, GL_FALSE},
};

/* The parameters of pixel unpacking; GLES does not have the last one. */
enum { UNPACK_COUNT = 5 };
static const struct {
    GLenum name;
    GLint starting;
} unpack[UNPACK_COUNT] = {{GL_UNPACK_ALIGNMENT, 4},
                          {GL_UNPACK_ROW_LENGTH, 0},
                          {GL_UNPACK_SKIP_ROWS, 0},
                          {GL_UNPACK_SKIP_PIXELS, 0},
                          {GL_UNPACK_SWAP_BYTES, 0}};

/* The state that glGetIntegerv reads, and where in psplat_gl_state it is stored. */
static const struct {
    GLenum name;
    size_t offset;
} integers[] = {
    {GL_DRAW_FRAMEBUFFER_BINDING, offsetof(psplat_gl_state, draw_framebuffer)},
    {GL_CURRENT_PROGRAM, offsetof(psplat_gl_state, program)},
    {GL_VERTEX_ARRAY_BINDING, offsetof(psplat_gl_state, vertex_array)},
    {GL_VIEWPORT, offsetof(psplat_gl_state, viewport)},
    {GL_SCISSOR_BOX, offsetof(psplat_gl_state, scissor_box)},
    {GL_BLEND_SRC_RGB, offsetof(psplat_gl_state, blend_func[0])},
    {GL_BLEND_DST_RGB, offsetof(psplat_gl_state, blend_func[1])},
    {GL_BLEND_SRC_ALPHA, offsetof(psplat_gl_state, blend_func[2])},
    {GL_BLEND_DST_ALPHA, offsetof(psplat_gl_state, blend_func[3])},
    {GL_BLEND_EQUATION_RGB, offsetof(psplat_gl_state, blend_equation[0])},
    {GL_BLEND_EQUATION_ALPHA, offsetof(psplat_gl_state, blend_equation[1])},
    {GL_DEPTH_FUNC, offsetof(psplat_gl_state, depth_func)},
    {GL_CULL_FACE_MODE, offsetof(psplat_gl_state, cull_face)},
    {GL_FRONT_FACE, offsetof(psplat_gl_state, front_face)},
    {GL_ACTIVE_TEXTURE, offsetof(psplat_gl_state, active_texture)},
    {GL_ARRAY_BUFFER_BINDING, offsetof(psplat_gl_state, array_buffer)},
    {GL_PIXEL_UNPACK_BUFFER_BINDING, offsetof(psplat_gl_state, unpack_buffer)},
};

static int has_capability(const psplat_gl *gl, int index) {
    int since = capabilities[index].es_version;
    return !gl->is_es || (since && gl->major * 10 + gl->minor >= since);
}

static int unpack_count(const psplat_gl *gl) {
    return gl->is_es ? UNPACK_COUNT - 1 : UNPACK_COUNT;
}

static void set(const psplat_gl *gl, GLenum capability, GLboolean enabled) {
    if (enabled)
        gl->Enable(capability);
    else
        gl->Disable(capability);
}

static void read_units(psplat_gl_state *state, const psplat_gl *gl) {
    for (GLenum unit = 0; unit < state->unit_count; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->GetIntegerv(GL_TEXTURE_BINDING_2D, &state->textures[unit]);
        gl->GetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &state->cubes[unit]);
        gl->GetIntegerv(GL_SAMPLER_BINDING, &state->samplers[unit]);
    }
}

static void read_state(psplat_gl_state *state, const psplat_gl *gl) {
    for (int i = 0; i < PSPLAT_GL_CAPABILITY_COUNT; ++i)
        if (has_capability(gl, i)) state->capabilities[i] = gl->IsEnabled(capabilities[i].name);
    for (size_t i = 0; i < sizeof integers / sizeof *integers; ++i)
        gl->GetIntegerv(integers[i].name, (GLint *)(void *)((char *)state + integers[i].offset));
    for (int i = 0; i < unpack_count(gl); ++i) gl->GetIntegerv(unpack[i].name, &state->unpack[i]);
    gl->GetBooleanv(GL_COLOR_WRITEMASK, state->color_mask);
    gl->GetBooleanv(GL_DEPTH_WRITEMASK, &state->depth_mask);
    /* Core contexts answer with one value, older ones with two. */
    if (gl->PolygonMode) gl->GetIntegerv(GL_POLYGON_MODE, state->polygon_mode);
    state->knows_scissor_box = 1;
    read_units(state, gl);
}

/* Fails where GL does not answer. Some texture unit is always active, so a context that does not
 * say which one answers nothing at all (KHR_robustness: queries of lost contexts leave their
 * results alone). */
static psplat_result check_answers(const psplat_gl *gl, psplat_error *error) {
    GLint unit = 0;
    if (!gl->is_lost) gl->GetIntegerv(GL_ACTIVE_TEXTURE, &unit);
    if (unit) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the GL context is %s",
                       gl->is_lost ? "lost" : "lost or not current");
}

/* Sets what every pass and upload starts from. */
static void set_starting(const psplat_gl *gl, GLuint unit_count) {
    for (int i = 0; i < PSPLAT_GL_CAPABILITY_COUNT; ++i)
        if (has_capability(gl, i)) set(gl, capabilities[i].name, capabilities[i].starting);
    if (gl->PolygonMode) gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    for (GLuint unit = 0; unit < unit_count; ++unit) gl->BindSampler(unit, 0);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = 0; i < unpack_count(gl); ++i) gl->PixelStorei(unpack[i].name, unpack[i].starting);
}

psplat_result psplat_gl_state_take(psplat_gl_state *state, const psplat_gl *gl, GLuint unit_count,
                                   psplat_error *error) {
    psplat_result result = check_answers(gl, error);
    if (result != PSPLAT_OK) return result;
    memset(state, 0, sizeof *state);
    state->unit_count = unit_count;
    read_state(state, gl);
    set_starting(gl, unit_count);
    return PSPLAT_OK;
}

void psplat_gl_state_assume(psplat_gl_state *state, const psplat_gl *gl, GLuint unit_count,
                            const psplat_host_state *known, const GLint viewport[4]) {
    *state = (psplat_gl_state){
        .color_mask = {GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE},
        .depth_mask = GL_TRUE,
        .draw_framebuffer = (GLint)known->framebuffer,
        .blend_func = {GL_ONE, GL_ZERO, GL_ONE, GL_ZERO},
        .blend_equation = {GL_FUNC_ADD, GL_FUNC_ADD},
        .depth_func = GL_LESS,
        .cull_face = GL_BACK,
        .front_face = GL_CCW,
        .polygon_mode = {GL_FILL, GL_FILL},
        .active_texture = GL_TEXTURE0,
        .unit_count = unit_count,
    };
    memcpy(state->viewport, viewport, sizeof state->viewport);
    memcpy(state->scissor_box, viewport, sizeof state->scissor_box);
    state->knows_scissor_box = !known->scissor_test;
    for (int i = 0; i < UNPACK_COUNT; ++i) state->unpack[i] = unpack[i].starting;
    for (int i = 0; i < PSPLAT_GL_CAPABILITY_COUNT; ++i) {
        if (capabilities[i].name == GL_DITHER) state->capabilities[i] = GL_TRUE;
        if (capabilities[i].name == GL_SCISSOR_TEST) state->capabilities[i] = !!known->scissor_test;
    }
    set_starting(gl, unit_count);
}

static void restore_scissor_box(const psplat_gl_state *state, const psplat_gl *gl) {
    const GLint *box = state->scissor_box;
    if (state->knows_scissor_box) gl->Scissor(box[0], box[1], box[2], box[3]);
}

void psplat_gl_state_bind_host(const psplat_gl_state *state, const psplat_gl *gl) {
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)state->draw_framebuffer);
    restore_scissor_box(state, gl);
    for (int i = 0; i < PSPLAT_GL_CAPABILITY_COUNT; ++i)
        if (capabilities[i].name == GL_SCISSOR_TEST)
            set(gl, GL_SCISSOR_TEST, state->capabilities[i]);
}

static void restore_units(const psplat_gl_state *state, const psplat_gl *gl) {
    for (GLuint unit = 0; unit < state->unit_count; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->BindTexture(GL_TEXTURE_2D, (GLuint)state->textures[unit]);
        gl->BindTexture(GL_TEXTURE_CUBE_MAP, (GLuint)state->cubes[unit]);
        gl->BindSampler(unit, (GLuint)state->samplers[unit]);
    }
    gl->ActiveTexture((GLenum)state->active_texture);
}

void psplat_gl_state_restore(const psplat_gl_state *state, const psplat_gl *gl) {
    for (int i = 0; i < PSPLAT_GL_CAPABILITY_COUNT; ++i)
        if (has_capability(gl, i)) set(gl, capabilities[i].name, state->capabilities[i]);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)state->draw_framebuffer);
    gl->UseProgram((GLuint)state->program);
    gl->BindVertexArray((GLuint)state->vertex_array);
    gl->Viewport(state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
    restore_scissor_box(state, gl);
    gl->BlendFuncSeparate((GLenum)state->blend_func[0], (GLenum)state->blend_func[1],
                          (GLenum)state->blend_func[2], (GLenum)state->blend_func[3]);
    gl->BlendEquationSeparate((GLenum)state->blend_equation[0], (GLenum)state->blend_equation[1]);
    gl->ColorMask(state->color_mask[0], state->color_mask[1], state->color_mask[2],
                  state->color_mask[3]);
    gl->DepthMask(state->depth_mask);
    gl->DepthFunc((GLenum)state->depth_func);
    gl->CullFace((GLenum)state->cull_face);
    gl->FrontFace((GLenum)state->front_face);
    if (gl->PolygonMode) gl->PolygonMode(GL_FRONT_AND_BACK, (GLenum)state->polygon_mode[0]);
    restore_units(state, gl);
    gl->BindBuffer(GL_ARRAY_BUFFER, (GLuint)state->array_buffer);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, (GLuint)state->unpack_buffer);
    for (int i = 0; i < unpack_count(gl); ++i) gl->PixelStorei(unpack[i].name, state->unpack[i]);
}
