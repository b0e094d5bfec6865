/* SPDX-License-Identifier: MIT
 *
 * A headless GL context through EGL.
 */
#include "context.h"

#include <EGL/eglext.h>
#include <stdlib.h>
#include <string.h>

static const EGLint context_gl[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    3,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    3,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
static const EGLint context_es[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0,
                                    EGL_NONE};

void *psplat_host_get_proc(void *user, const char *name) {
    (void)user;
    void (*function)(void) = eglGetProcAddress(name);
    void *address = NULL;
    memcpy(&address, &function, sizeof address);
    return address;
}

static int create_context(psplat_host *host, psplat_api api) {
    const EGLint attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                 api == PSPLAT_API_GL ? EGL_OPENGL_BIT : EGL_OPENGL_ES3_BIT,
                                 EGL_NONE};
    static const EGLint pbuffer[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    EGLConfig config;
    EGLint count = 0;
    if (!eglBindAPI(api == PSPLAT_API_GL ? EGL_OPENGL_API : EGL_OPENGL_ES_API)) return 0;
    if (!eglChooseConfig(host->display, attributes, &config, 1, &count) || count < 1) return 0;
    host->context = eglCreateContext(host->display, config, EGL_NO_CONTEXT,
                                     api == PSPLAT_API_GL ? context_gl : context_es);
    if (host->context == EGL_NO_CONTEXT) return 0;
    if (eglMakeCurrent(host->display, EGL_NO_SURFACE, EGL_NO_SURFACE, host->context)) return 1;
    host->surface = eglCreatePbufferSurface(host->display, config, pbuffer);
    return eglMakeCurrent(host->display, host->surface, host->surface, host->context) == EGL_TRUE;
}

static void destroy_context(psplat_host *host) {
    if (host->display == EGL_NO_DISPLAY) return;
    if (eglGetCurrentContext() == host->context)
        eglMakeCurrent(host->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (host->surface != EGL_NO_SURFACE) eglDestroySurface(host->display, host->surface);
    if (host->context != EGL_NO_CONTEXT) eglDestroyContext(host->display, host->context);
    host->surface = EGL_NO_SURFACE;
    host->context = EGL_NO_CONTEXT;
}

static psplat_result open_context(psplat_host *host, psplat_api api, int software,
                                  psplat_error *error) {
    for (int attempt = 0, done = 0; !done; ++attempt) {
        host->display = psplat_host_display(software, attempt, &done);
        if (host->display == EGL_NO_DISPLAY) continue;
        if (create_context(host, api)) return PSPLAT_OK;
        destroy_context(host);
    }
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "EGL offers no %s context (last EGL error 0x%x)",
                       api == PSPLAT_API_GL ? "GL 3.3 core" : "GLES 3.0", (unsigned)eglGetError());
}

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
    psplat_result result = open_context(made, api, !!software, error);
    if (result == PSPLAT_OK) result = load_functions(made, error);
    if (result != PSPLAT_OK) {
        destroy_context(made);
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

/* The context that was current stays so, unless it is the one that goes. */
void psplat_host_destroy(psplat_host *host) {
    if (!host) return;
    EGLContext context = eglGetCurrentContext();
    EGLDisplay display = eglGetCurrentDisplay();
    EGLSurface draw = eglGetCurrentSurface(EGL_DRAW), read = eglGetCurrentSurface(EGL_READ);
    int is_current = context == host->context;
    destroy_objects(host);
    destroy_context(host);
    if (!is_current && context != EGL_NO_CONTEXT) eglMakeCurrent(display, draw, read, context);
    free(host);
}

psplat_result psplat_host_make_current(psplat_host *host, psplat_error *error) {
    if (!host) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "host is NULL");
    if (eglGetCurrentContext() == host->context ||
        eglMakeCurrent(host->display, host->surface, host->surface, host->context))
        return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the context cannot be current (EGL 0x%x)",
                       (unsigned)eglGetError());
}

const char *psplat_host_renderer(const psplat_host *host) {
    return host ? host->renderer : "";
}

const char *psplat_host_version(const psplat_host *host) {
    return host ? host->version : "";
}
