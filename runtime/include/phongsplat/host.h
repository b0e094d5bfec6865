/* SPDX-License-Identifier: MIT
 *
 * phongsplat/host.h - a headless GL context through EGL (surfaceless, or else with a pbuffer), and
 * an offscreen framebuffer to draw into. It is a library of its own, which the runtime does not
 * need.
 */
#ifndef PHONGSPLAT_HOST_H
#define PHONGSPLAT_HOST_H

#include "splat.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum psplat_api {
    PSPLAT_API_GL = 0, /* GL 3.3 core */
    PSPLAT_API_GLES    /* GLES 3.0 */
} psplat_api;

/* A headless GL context with an offscreen framebuffer. */
typedef struct psplat_host psplat_host;

/* Creates a context and makes it current on this thread. A GPU is used where EGL offers one;
 * otherwise, or where software is not 0, Mesa's llvmpipe is used. On success *host belongs to the
 * caller, who destroys it; on failure it is NULL. Errors: ARGUMENT, GRAPHICS, MEMORY. */
PSPLAT_EXPORT psplat_result psplat_host_create(psplat_api api, int software, psplat_host **host,
                                               psplat_error *error);

/* Destroys the context and its framebuffer. Another context that is current stays current. NULL is
 * accepted. */
PSPLAT_EXPORT void psplat_host_destroy(psplat_host *host);

/* Makes the host's context current on the calling thread. Errors: ARGUMENT (host is NULL),
 * GRAPHICS. */
PSPLAT_EXPORT psplat_result psplat_host_make_current(psplat_host *host, psplat_error *error);

/* Returns the address of a GL function, or NULL. It is the get_proc of psplat_renderer_desc, with
 * the host as user. */
PSPLAT_EXPORT void *psplat_host_get_proc(void *user, const char *name);

/* Return GL_RENDERER and GL_VERSION of the context, valid until the host is destroyed, or "" where
 * host is NULL. */
PSPLAT_EXPORT const char *psplat_host_renderer(const psplat_host *host);
PSPLAT_EXPORT const char *psplat_host_version(const psplat_host *host);

/* Makes the context current, binds an offscreen framebuffer of width x height pixels (making it
 * anew where its size or format differs), sets the viewport to all of it, and clears colour to rgba
 * and depth to 1. Colour is RGBA32F where is_float is not 0 and RGBA8 otherwise; depth is a 32-bit
 * float. Errors: ARGUMENT (rgba is NULL, or a size is outside 1 ... GL_MAX_TEXTURE_SIZE),
 * GRAPHICS. */
PSPLAT_EXPORT psplat_result psplat_host_begin(psplat_host *host, int width, int height,
                                              int is_float, const float rgba[4],
                                              psplat_error *error);

/* Read back the framebuffer that psplat_host_begin bound, into an array that the caller provides,
 * row 0 at the bottom. read_rgba8 stores 4 bytes a pixel and needs a framebuffer with is_float 0;
 * read_float stores 4 floats a pixel and needs one with is_float 1; read_depth stores 1 float a
 * pixel, window depth 0 ... 1. Errors: ARGUMENT (nothing was begun, the array is NULL, or the
 * format is the other one), GRAPHICS. */
PSPLAT_EXPORT psplat_result psplat_host_read_rgba8(psplat_host *host, uint8_t *rgba,
                                                   psplat_error *error);
PSPLAT_EXPORT psplat_result psplat_host_read_float(psplat_host *host, float *rgba,
                                                   psplat_error *error);
PSPLAT_EXPORT psplat_result psplat_host_read_depth(psplat_host *host, float *depth,
                                                   psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
