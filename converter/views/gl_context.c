/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gl_context.c - the GL or GLES context in which pictures are drawn.
 */
#define _XOPEN_SOURCE 700

#include "views/gl_context.h"

#include <phongsplat/host.h>

#include <stdlib.h>

/* EGL_LOG_LEVEL silences Mesa, which prints warnings about each device that it tries; the error
 * says what matters. */
psplat_result psplat_context_create(int software, psplat_host **host, psplat_error *error) {
    setenv("EGL_LOG_LEVEL", "fatal", 0);
    psplat_result result = psplat_host_create(PSPLAT_API_GL, software, host, error);
    if (result != PSPLAT_ERROR_GRAPHICS) return result;
    return psplat_host_create(PSPLAT_API_GLES, software, host, NULL);
}
