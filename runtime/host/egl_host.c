/* SPDX-License-Identifier: MIT
 *
 * egl_host.c - the headless host's creation and destruction: an EGL context (egl_context.c), the GL
 * functions loaded from it, and the framebuffers that framebuffer.c makes in it.
 */
#include "host/egl_context.h"

#include <stdlib.h>
#include <string.h>

/* Loads the runtime's GL functions and glReadPixels, which the runtime itself does not use. */
static psplat_result load_functions(psplat_host *host, psplat_error *error) {
    psplat_result result = psplat_gl_load(&host->gl, psplat_host_get_proc, host, error);
    if (result != PSPLAT_OK) return result;
    void *read_pixels = psplat_host_get_proc(host, "glReadPixels");
    if (!read_pixels)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "EGL has no GL function glReadPixels");
    memcpy(&host->ReadPixels, &read_pixels, sizeof read_pixels);
    host->renderer = (const char *)host->gl.GetString(GL_RENDERER);
    host->version = (const char *)host->gl.GetString(GL_VERSION);
    return PSPLAT_OK;
}

psplat_result psplat_host_create(psplat_api api, int software, psplat_host **host,
                                 psplat_error *error) {
    if (host) *host = NULL;
    if (!host || (api != PSPLAT_API_GL && api != PSPLAT_API_GLES))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "host is NULL or api unknown");
    psplat_host *made = calloc(1, sizeof *made);
    if (!made) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a host");
    made->display = EGL_NO_DISPLAY;
    made->context = EGL_NO_CONTEXT;
    made->surface = EGL_NO_SURFACE;
    psplat_result result = psplat_host_open_context(made, api, !!software, error);
    if (result == PSPLAT_OK) result = load_functions(made, error);
    if (result != PSPLAT_OK) {
        psplat_host_close_context(made);
        free(made);
        return result;
    }
    *host = made;
    return PSPLAT_OK;
}

static void destroy_objects(psplat_host *host) {
    if (psplat_host_make_current(host, NULL) != PSPLAT_OK) return;
    psplat_host_framebuffer_destroy(&host->target, &host->gl);
    psplat_host_framebuffer_destroy(&host->bytes, &host->gl);
    host->gl.DeleteProgram(host->depth_program);
    host->gl.DeleteVertexArrays(1, &host->vertex_array);
}

/* The context that was current before the call is current again afterwards, unless it is the one
 * that is destroyed. */
void psplat_host_destroy(psplat_host *host) {
    if (!host) return;
    EGLContext context = eglGetCurrentContext();
    EGLDisplay display = eglGetCurrentDisplay();
    EGLSurface draw = eglGetCurrentSurface(EGL_DRAW), read = eglGetCurrentSurface(EGL_READ);
    int is_current = context == host->context;
    destroy_objects(host);
    psplat_host_close_context(host);
    if (!is_current && context != EGL_NO_CONTEXT) eglMakeCurrent(display, draw, read, context);
    free(host);
}

const char *psplat_host_renderer(const psplat_host *host) {
    return host ? host->renderer : "";
}

const char *psplat_host_version(const psplat_host *host) {
    return host ? host->version : "";
}
