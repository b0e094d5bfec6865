/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * context.c - a graphics context to draw pictures in.
 */
#define _XOPEN_SOURCE 700

#include "compare.h"

#include <stdlib.h>

/* Mesa prints warnings of its own about each device that it tries; what matters of them is in the
 * error. */
psplat_result psplat_context_create(int software, psplat_host **host, psplat_error *error) {
    setenv("EGL_LOG_LEVEL", "fatal", 0);
    psplat_result result = psplat_host_create(PSPLAT_API_GL, software, host, error);
    if (result != PSPLAT_ERROR_GRAPHICS) return result;
    return psplat_host_create(PSPLAT_API_GLES, software, host, NULL);
}
