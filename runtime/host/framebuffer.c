/* SPDX-License-Identifier: MIT
 *
 * framebuffer.c - the headless host's offscreen framebuffer: its textures, clearing it, and reading
 * colour and depth back. Depth is read through a shader that writes it as bytes (depth.frag),
 * because GLES cannot read a depth buffer.
 */
#include "host/egl_context.h"
#include "gl/gl_state.h"
#include "gl/gl_program.h"
#include "shaders.h"

#include <string.h>

/* Makes a texture and attaches it to the framebuffer that is bound for drawing. */
static GLuint attach_texture(const psplat_gl *gl, GLenum attachment, GLint internal_format,
                             int width, int height, GLenum format, GLenum type) {
    GLuint texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, internal_format, width, height, 0, format, type, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
    return texture;
}

static void make_framebuffer(psplat_host_framebuffer *framebuffer, const psplat_gl *gl,
                             int has_depth) {
    int width = framebuffer->width, height = framebuffer->height;
    gl->GenFramebuffers(1, &framebuffer->framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer->framebuffer);
    framebuffer->color =
        attach_texture(gl, GL_COLOR_ATTACHMENT0, framebuffer->is_float ? GL_RGBA32F : GL_RGBA8,
                       width, height, GL_RGBA, framebuffer->is_float ? GL_FLOAT : GL_UNSIGNED_BYTE);
    if (has_depth)
        framebuffer->depth = attach_texture(gl, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, width,
                                            height, GL_DEPTH_COMPONENT, GL_FLOAT);
}

psplat_result psplat_host_framebuffer_resize(psplat_host_framebuffer *framebuffer,
                                             const psplat_gl *gl, int width, int height,
                                             int is_float, int has_depth, psplat_error *error) {
    if (framebuffer->framebuffer && framebuffer->width == width && framebuffer->height == height &&
        framebuffer->is_float == is_float) {
        gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer->framebuffer);
        return PSPLAT_OK;
    }
    psplat_host_framebuffer_destroy(framebuffer, gl);
    framebuffer->width = width;
    framebuffer->height = height;
    framebuffer->is_float = is_float;
    psplat_gl_state state;
    psplat_result result = psplat_gl_state_take(&state, gl, PSPLAT_UNIT_COUNT, error);
    if (result != PSPLAT_OK) return result;
    make_framebuffer(framebuffer, gl, has_depth);
    GLenum status = gl->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
    psplat_gl_state_restore(&state, gl);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer->framebuffer);
    if (status == GL_FRAMEBUFFER_COMPLETE) return PSPLAT_OK;
    psplat_host_framebuffer_destroy(framebuffer, gl);
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "a framebuffer of %d x %d pixels is refused (status 0x%x)", width, height,
                       status);
}

void psplat_host_framebuffer_destroy(psplat_host_framebuffer *framebuffer, const psplat_gl *gl) {
    gl->DeleteFramebuffers(1, &framebuffer->framebuffer);
    gl->DeleteTextures(1, &framebuffer->color);
    gl->DeleteTextures(1, &framebuffer->depth);
    memset(framebuffer, 0, sizeof *framebuffer);
}

psplat_result psplat_host_begin(psplat_host *host, int width, int height, int is_float,
                                const float rgba[4], psplat_error *error) {
    static const float far_depth = 1.0f;
    psplat_result result = psplat_host_make_current(host, error);
    if (result != PSPLAT_OK) return result;
    const psplat_gl *gl = &host->gl;
    if (!rgba || width < 1 || height < 1 || width > gl->max_texture_size ||
        height > gl->max_texture_size)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a framebuffer of %d x %d pixels is outside 1 ... %d, or rgba is NULL",
                           width, height, gl->max_texture_size);
    result = psplat_host_framebuffer_resize(&host->target, gl, width, height, !!is_float, 1, error);
    if (result != PSPLAT_OK) return result;
    gl->Viewport(0, 0, width, height);
    gl->Disable(GL_SCISSOR_TEST);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->DepthMask(GL_TRUE);
    gl->ClearBufferfv(GL_COLOR, 0, rgba);
    gl->ClearBufferfv(GL_DEPTH, 0, &far_depth);
    return PSPLAT_OK;
}

/* Makes the context current and checks that something was begun. */
static psplat_result check_read(psplat_host *host, const void *out, psplat_error *error) {
    psplat_result result = psplat_host_make_current(host, error);
    if (result != PSPLAT_OK) return result;
    if (!out || !host->target.framebuffer)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "nothing was begun, or there is nowhere to read to");
    return PSPLAT_OK;
}

static void read_framebuffer(psplat_host *host, const psplat_host_framebuffer *framebuffer,
                             GLenum type, void *out) {
    host->gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer->framebuffer);
    host->gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
    host->ReadPixels(0, 0, framebuffer->width, framebuffer->height, GL_RGBA, type, out);
}

static psplat_result read_color(psplat_host *host, int is_float, void *out, psplat_error *error) {
    psplat_result result = check_read(host, out, error);
    if (result != PSPLAT_OK) return result;
    if (host->target.is_float != is_float)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the framebuffer holds %s",
                           is_float ? "bytes, not floats" : "floats, not bytes");
    read_framebuffer(host, &host->target, is_float ? GL_FLOAT : GL_UNSIGNED_BYTE, out);
    return PSPLAT_OK;
}

psplat_result psplat_host_read_rgba8(psplat_host *host, uint8_t *rgba, psplat_error *error) {
    return read_color(host, 0, rgba, error);
}

psplat_result psplat_host_read_float(psplat_host *host, float *rgba, psplat_error *error) {
    return read_color(host, 1, rgba, error);
}

/* Copies the depth texture into host->bytes with depth.frag, four bytes for each float. */
static psplat_result draw_depth(psplat_host *host, psplat_error *error) {
    const psplat_gl *gl = &host->gl;
    const psplat_host_framebuffer *target = &host->target;
    psplat_result result = psplat_host_framebuffer_resize(&host->bytes, gl, target->width,
                                                          target->height, 0, 0, error);
    if (result != PSPLAT_OK) return result;
    if (!host->vertex_array) gl->GenVertexArrays(1, &host->vertex_array);
    if (!host->depth_program)
        host->depth_program = psplat_program_build(
            gl,
            &(psplat_program_source){"", {psplat_shader_screen_vert}, {psplat_shader_depth_frag}},
            error);
    if (!host->depth_program) return PSPLAT_ERROR_GRAPHICS;

    gl->Viewport(0, 0, target->width, target->height);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->UseProgram(host->depth_program); /* its only sampler is on unit 0 */
    gl->BindVertexArray(host->vertex_array);
    gl->BindTexture(GL_TEXTURE_2D, target->depth);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    return PSPLAT_OK;
}

psplat_result psplat_host_read_depth(psplat_host *host, float *depth, psplat_error *error) {
    psplat_result result = check_read(host, depth, error);
    if (result != PSPLAT_OK) return result;
    psplat_gl_state state;
    result = psplat_gl_state_take(&state, &host->gl, PSPLAT_UNIT_COUNT, error);
    if (result != PSPLAT_OK) return result;
    result = draw_depth(host, error);
    psplat_gl_state_restore(&state, &host->gl);
    if (result == PSPLAT_OK) read_framebuffer(host, &host->bytes, GL_UNSIGNED_BYTE, depth);
    return result;
}
