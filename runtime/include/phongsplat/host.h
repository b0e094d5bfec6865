/* SPDX-License-Identifier: MIT
 *
 * phongsplat/host.h - a headless GL context through EGL (surfaceless, then pbuffer), and an
 * offscreen framebuffer to draw into. A separate library: the runtime does not need it.
 */
#ifndef PHONGSPLAT_HOST_H
#define PHONGSPLAT_HOST_H

#include "splat.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum psplat_api {
    PSPLAT_API_GL = 0, /* 3.3 core */
    PSPLAT_API_GLES    /* 3.0 */
} psplat_api;

typedef struct psplat_host psplat_host;

/* Creates a context and makes it current on this thread. A GPU is used where EGL offers one;
 * otherwise, or where software is not 0, Mesa's llvmpipe. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_host_create(psplat_api api, int software, psplat_host **host,
                                 psplat_error *error);
void psplat_host_destroy(psplat_host *host); /* NULL is accepted */

/* Makes the host's context current on the calling thread. */
psplat_result psplat_host_make_current(psplat_host *host, psplat_error *error);

/* Loader to hand to psplat_renderer_desc; user is the host. */
void *psplat_host_get_proc(void *user, const char *name);

/* GL_RENDERER and GL_VERSION, valid until the host is destroyed. */
const char *psplat_host_renderer(const psplat_host *host);
const char *psplat_host_version(const psplat_host *host);

/* Binds (creating or resizing as needed) an offscreen framebuffer with a depth buffer of 24 bits
 * or more, and clears colour to rgba and depth to 1. is_float: RGBA32F instead of RGBA8. */
psplat_result psplat_host_begin(psplat_host *host, int width, int height, int is_float,
                                const float rgba[4], psplat_error *error);

/* Read back what was drawn since begin; row 0 at the bottom. 4 bytes (not float: RGBA8) or 4
 * floats per pixel; depth is 1 float per pixel, window depth 0 ... 1. */
psplat_result psplat_host_read_rgba8(psplat_host *host, uint8_t *rgba, psplat_error *error);
psplat_result psplat_host_read_float(psplat_host *host, float *rgba, psplat_error *error);
psplat_result psplat_host_read_depth(psplat_host *host, float *depth, psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
