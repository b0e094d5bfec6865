/* SPDX-License-Identifier: MIT
 *
 * multisample_target.c - a framebuffer that belongs to no window: for screenshots, and with twice
 * as many pixels each way for smooth drawing.
 */
#include "viewer_gl.h"
#include "viewer.h"

static GLuint attach(const gl *gl, GLenum format, GLenum attachment, int width, int height) {
    GLuint name;
    gl->GenRenderbuffers(1, &name);
    gl->BindRenderbuffer(GL_RENDERBUFFER, name);
    gl->RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, name);
    return name;
}

int target_resize(target *t, const gl *gl, int width, int height) {
    if (t->framebuffer && t->width == width && t->height == height) return t->is_complete;
    target_free(t, gl);
    gl->GenFramebuffers(1, &t->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    t->color = attach(gl, GL_RGBA8, GL_COLOR_ATTACHMENT0, width, height);
    t->depth = attach(gl, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT, width, height);
    t->width = width;
    t->height = height;
    t->is_complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    return t->is_complete;
}

void target_free(target *t, const gl *gl) {
    if (!t->framebuffer) return;
    gl->DeleteFramebuffers(1, &t->framebuffer);
    gl->DeleteRenderbuffers(1, &t->color);
    gl->DeleteRenderbuffers(1, &t->depth);
    *t = (target){0};
}
