/* SPDX-License-Identifier: MIT
 *
 * Float targets: RGBA32F because 16 bits saturate where many splats meet in a pixel; RGBA16F only
 * where the context cannot blend 32 bits (psplat_gl.half_targets).
 */
#include "target.h"

#include <string.h>

static GLuint make_texture(const psplat_gl *gl, GLint internal_format, int width, int height,
                           GLenum format, GLenum type) {
    GLuint texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, internal_format, width, height, 0, format, type, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

static void attach(const psplat_gl *gl, GLenum attachment, GLuint texture) {
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
}

/* Depth in 32 bits: its steps near 1 are those of a 24-bit buffer, everywhere else finer. */
static void make_depth(psplat_target *target, const psplat_gl *gl, int width, int height) {
    target->width = width;
    target->height = height;
    gl->GenFramebuffers(1, &target->framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, target->framebuffer);
    target->depth =
        make_texture(gl, GL_DEPTH_COMPONENT32F, width, height, GL_DEPTH_COMPONENT, GL_FLOAT);
    attach(gl, GL_DEPTH_ATTACHMENT, target->depth);
}

static void add_color(psplat_target *target, const psplat_gl *gl) {
    int index = target->color_count++;
    target->colors[index] =
        make_texture(gl, gl->half_targets ? GL_RGBA16F : GL_RGBA32F, target->width, target->height,
                     GL_RGBA, gl->half_targets ? GL_HALF_FLOAT : GL_FLOAT);
    attach(gl, GL_COLOR_ATTACHMENT0 + (GLenum)index, target->colors[index]);
}

psplat_result psplat_target_bind(psplat_target *target, const psplat_gl *gl, int width, int height,
                                 int color_count, psplat_error *error) {
    static const GLenum buffers[PSPLAT_TARGET_COUNT_MATERIALS] = {
        GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT0 + 1, GL_COLOR_ATTACHMENT0 + 2,
        GL_COLOR_ATTACHMENT0 + 3};
    if (target->width != width || target->height != height) psplat_target_destroy(target, gl);

    int is_new = !target->framebuffer || target->color_count < color_count;
    if (!target->framebuffer) make_depth(target, gl, width, height);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, target->framebuffer);
    while (target->color_count < color_count) add_color(target, gl);
    gl->DrawBuffers(color_count, buffers);
    if (!is_new) return PSPLAT_OK;

    GLenum status = gl->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) return PSPLAT_OK;
    psplat_target_destroy(target, gl);
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "float targets of %d x %d pixels are refused (status 0x%x)", width, height,
                       status);
}

void psplat_target_destroy(psplat_target *target, const psplat_gl *gl) {
    gl->DeleteFramebuffers(1, &target->framebuffer);
    gl->DeleteTextures(PSPLAT_TARGET_COUNT_MATERIALS, target->colors);
    gl->DeleteTextures(1, &target->depth);
    memset(target, 0, sizeof *target);
}
