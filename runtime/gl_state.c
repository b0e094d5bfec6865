/* SPDX-License-Identifier: MIT
 *
 * The host's GL state, taken and put back.
 */
#include "gl_state.h"

#include <stddef.h>

static const GLenum capabilities[PSPLAT_GL_CAPABILITY_COUNT] = {
    GL_BLEND,
    GL_CULL_FACE,
    GL_DEPTH_TEST,
    GL_DITHER,
    GL_POLYGON_OFFSET_FILL,
    GL_RASTERIZER_DISCARD,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,
    GL_SCISSOR_TEST,
    GL_STENCIL_TEST,
    /* From here on unknown to GLES. */
    GL_COLOR_LOGIC_OP,
    GL_DEPTH_CLAMP,
    GL_SAMPLE_MASK,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE0 + 1,
    GL_CLIP_DISTANCE0 + 2,
    GL_CLIP_DISTANCE0 + 3,
    GL_CLIP_DISTANCE0 + 4,
    GL_CLIP_DISTANCE0 + 5,
    GL_CLIP_DISTANCE0 + 6,
    GL_CLIP_DISTANCE0 + 7,
};
enum { ES_CAPABILITY_COUNT = 10 };

static const GLenum unpack_names[4] = {GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH,
                                       GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS};

/* Single integers and where they go. */
static const struct {
    GLenum name;
    size_t offset;
} integers[] = {
    {GL_DRAW_FRAMEBUFFER_BINDING, offsetof(psplat_gl_state, draw_framebuffer)},
    {GL_CURRENT_PROGRAM, offsetof(psplat_gl_state, program)},
    {GL_VERTEX_ARRAY_BINDING, offsetof(psplat_gl_state, vertex_array)},
    {GL_VIEWPORT, offsetof(psplat_gl_state, viewport)},
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
    {GL_PIXEL_UNPACK_BUFFER_BINDING, offsetof(psplat_gl_state, unpack_buffer)},
    {GL_UNPACK_ALIGNMENT, offsetof(psplat_gl_state, unpack[0])},
    {GL_UNPACK_ROW_LENGTH, offsetof(psplat_gl_state, unpack[1])},
    {GL_UNPACK_SKIP_ROWS, offsetof(psplat_gl_state, unpack[2])},
    {GL_UNPACK_SKIP_PIXELS, offsetof(psplat_gl_state, unpack[3])},
};

static int capability_count(const psplat_gl *gl) {
    return gl->is_es ? ES_CAPABILITY_COUNT : PSPLAT_GL_CAPABILITY_COUNT;
}

static void set(const psplat_gl *gl, GLenum capability, GLboolean enabled) {
    if (enabled)
        gl->Enable(capability);
    else
        gl->Disable(capability);
}

static void read_state(psplat_gl_state *state, const psplat_gl *gl) {
    for (int i = 0; i < capability_count(gl); ++i)
        state->capabilities[i] = gl->IsEnabled(capabilities[i]);
    for (size_t i = 0; i < sizeof integers / sizeof *integers; ++i)
        gl->GetIntegerv(integers[i].name, (GLint *)(void *)((char *)state + integers[i].offset));
    gl->GetBooleanv(GL_COLOR_WRITEMASK, state->color_mask);
    gl->GetBooleanv(GL_DEPTH_WRITEMASK, &state->depth_mask);
    /* Core contexts answer with one value, older ones with two. */
    if (gl->PolygonMode) gl->GetIntegerv(GL_POLYGON_MODE, state->polygon_mode);
    for (GLenum unit = 0; unit < PSPLAT_UNIT_COUNT; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->GetIntegerv(GL_TEXTURE_BINDING_2D, &state->textures[unit]);
        gl->GetIntegerv(GL_SAMPLER_BINDING, &state->samplers[unit]);
    }
}

void psplat_gl_state_take(psplat_gl_state *state, const psplat_gl *gl) {
    static const GLint tight[4] = {4, 0, 0, 0};
    read_state(state, gl);
    for (int i = 0; i < capability_count(gl); ++i) gl->Disable(capabilities[i]);
    if (gl->PolygonMode) gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    for (GLuint unit = 0; unit < PSPLAT_UNIT_COUNT; ++unit) gl->BindSampler(unit, 0);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (int i = 0; i < 4; ++i) gl->PixelStorei(unpack_names[i], tight[i]);
}

void psplat_gl_state_bind_host(const psplat_gl_state *state, const psplat_gl *gl) {
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)state->draw_framebuffer);
    for (int i = 0; i < ES_CAPABILITY_COUNT; ++i)
        if (capabilities[i] == GL_SCISSOR_TEST) set(gl, GL_SCISSOR_TEST, state->capabilities[i]);
}

void psplat_gl_state_restore(const psplat_gl_state *state, const psplat_gl *gl) {
    for (int i = 0; i < capability_count(gl); ++i) set(gl, capabilities[i], state->capabilities[i]);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)state->draw_framebuffer);
    gl->UseProgram((GLuint)state->program);
    gl->BindVertexArray((GLuint)state->vertex_array);
    gl->Viewport(state->viewport[0], state->viewport[1], state->viewport[2], state->viewport[3]);
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
    for (GLuint unit = 0; unit < PSPLAT_UNIT_COUNT; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->BindTexture(GL_TEXTURE_2D, (GLuint)state->textures[unit]);
        gl->BindSampler(unit, (GLuint)state->samplers[unit]);
    }
    gl->ActiveTexture((GLenum)state->active_texture);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, (GLuint)state->unpack_buffer);
    for (int i = 0; i < 4; ++i) gl->PixelStorei(unpack_names[i], state->unpack[i]);
}
