/* SPDX-License-Identifier: MIT
 *
 * context.h - the inside of the headless host.
 */
#ifndef PHONGSPLAT_HOST_CONTEXT_H
#define PHONGSPLAT_HOST_CONTEXT_H

#include "gl_api.h"

#include <phongsplat/host.h>

#include <EGL/egl.h>

typedef struct psplat_host_framebuffer {
    GLuint framebuffer, color, depth;
    int width, height;
    int is_float;
} psplat_host_framebuffer;

struct psplat_host {
    EGLDisplay display;
    EGLContext context;
    EGLSurface surface; /* EGL_NO_SURFACE where the context needs none */
    psplat_gl gl;
    const char *renderer, *version; /* of the context, which keeps them */
    void(PSPLAT_GL_CALL *ReadPixels)(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format,
                                     GLenum type, void *pixels);
    psplat_host_framebuffer target; /* of begin */
    psplat_host_framebuffer bytes;  /* receives depth as bytes */
    GLuint depth_program, vertex_array;
};

/* display.c: an initialised display for the API, software or not, or EGL_NO_DISPLAY. attempt
 * counts from 0; *done is set when there is nothing left to try. */
EGLDisplay psplat_host_display(int software, int attempt, int *done);

/* framebuffer.c */
psplat_result psplat_host_framebuffer_resize(psplat_host_framebuffer *framebuffer,
                                             const psplat_gl *gl, int width, int height,
                                             int is_float, int has_depth, psplat_error *error);
void psplat_host_framebuffer_destroy(psplat_host_framebuffer *framebuffer, const psplat_gl *gl);

#endif
