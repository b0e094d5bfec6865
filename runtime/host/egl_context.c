/* SPDX-License-Identifier: MIT
 *
 * egl_context.c - an EGL context for GL or GLES without a window. It needs no surface where the
 * driver allows that (EGL_KHR_surfaceless_context); elsewhere it gets a pbuffer of one pixel. The
 * displays that display.c offers are tried in turn until one gives a context.
 */
#include "host/egl_context.h"

#include <EGL/eglext.h>
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

/* ISO C has no cast from function to object pointers, so the address is copied. */
void *psplat_host_get_proc(void *user, const char *name) {
    (void)user;
    void (*function)(void) = eglGetProcAddress(name);
    void *address = NULL;
    memcpy(&address, &function, sizeof address);
    return address;
}

/* Creates a context on host->display and makes it current; returns 0 on failure. */
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

void psplat_host_close_context(psplat_host *host) {
    if (host->display == EGL_NO_DISPLAY) return;
    if (eglGetCurrentContext() == host->context)
        eglMakeCurrent(host->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (host->surface != EGL_NO_SURFACE) eglDestroySurface(host->display, host->surface);
    if (host->context != EGL_NO_CONTEXT) eglDestroyContext(host->display, host->context);
    host->surface = EGL_NO_SURFACE;
    host->context = EGL_NO_CONTEXT;
}

psplat_result psplat_host_open_context(psplat_host *host, psplat_api api, int software,
                                       psplat_error *error) {
    for (int attempt = 0, done = 0; !done; ++attempt) {
        host->display = psplat_host_display(software, attempt, &done);
        if (host->display == EGL_NO_DISPLAY) continue;
        if (create_context(host, api)) return PSPLAT_OK;
        psplat_host_close_context(host);
    }
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "EGL offers no %s context (last EGL error 0x%x)",
                       api == PSPLAT_API_GL ? "GL 3.3 core" : "GLES 3.0", (unsigned)eglGetError());
}

psplat_result psplat_host_make_current(psplat_host *host, psplat_error *error) {
    if (!host) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "host is NULL");
    if (eglGetCurrentContext() == host->context ||
        eglMakeCurrent(host->display, host->surface, host->surface, host->context))
        return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the context cannot be current (EGL 0x%x)",
                       (unsigned)eglGetError());
}
