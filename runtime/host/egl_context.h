/* SPDX-License-Identifier: MIT
 *
 * egl_context.h - the members of psplat_host, and the functions that the host's files share. Calls
 * go from egl_host.c to framebuffer.c, egl_context.c and display.c, never back.
 */
#ifndef PHONGSPLAT_HOST_EGL_CONTEXT_H
#define PHONGSPLAT_HOST_EGL_CONTEXT_H

#include "gl/gl_api.h"

#include <phongsplat/host.h>

#include <EGL/egl.h>

/* A framebuffer with textures as attachments; all members are 0 where it does not exist. */
typedef struct psplat_host_framebuffer {
    GLuint framebuffer, color, depth; /* depth is 0 where it has none */
    int width, height;                /* pixels */
    int is_float;                     /* 1: RGBA32F; 0: RGBA8 */
} psplat_host_framebuffer;

struct psplat_host {
    EGLDisplay display;
    EGLContext context;
    EGLSurface surface; /* EGL_NO_SURFACE where the context needs none */
    psplat_gl gl;
    const char *renderer, *version; /* strings that the context owns */
    void(PSPLAT_GL_CALL *ReadPixels)(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format,
                                     GLenum type, void *pixels);
    psplat_host_framebuffer target; /* the one that psplat_host_begin binds */
    psplat_host_framebuffer bytes;  /* receives depth as bytes (depth.frag) */
    GLuint depth_program, vertex_array;
};

/* ---- display.c ---------------------------------------------------------------------------- */

/* Returns the attempt-th display to try, initialised, or EGL_NO_DISPLAY where that one does not
 * work. attempt counts from 0; software is 1 for Mesa's rasteriser alone. *done becomes 1 when no
 * display is left after this one. */
EGLDisplay psplat_host_display(int software, int attempt, int *done);

/* ---- egl_context.c ------------------------------------------------------------------------ */

/* Finds a display that gives a context of the API, creates the context and makes it current; sets
 * display, context and surface. Fails only with PSPLAT_ERROR_GRAPHICS. */
psplat_result psplat_host_open_context(psplat_host *host, psplat_api api, int software,
                                       psplat_error *error);

/* Destroys context and surface. Displays are never terminated (display.c says why). */
void psplat_host_close_context(psplat_host *host);

/* ---- framebuffer.c ------------------------------------------------------------------------ */

/* Leaves a framebuffer of this size and format bound for drawing, and makes it anew where it has
 * another one. On failure (PSPLAT_ERROR_GRAPHICS) it does not exist. */
psplat_result psplat_host_framebuffer_resize(psplat_host_framebuffer *framebuffer,
                                             const psplat_gl *gl, int width, int height,
                                             int is_float, int has_depth, psplat_error *error);

/* Deletes its objects and sets all members to 0. A framebuffer of zeros is accepted. */
void psplat_host_framebuffer_destroy(psplat_host_framebuffer *framebuffer, const psplat_gl *gl);

#endif
