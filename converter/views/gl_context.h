/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gl_context.h - the GL or GLES context in which pictures are drawn.
 */
#ifndef PHONGSPLAT_VIEWS_GL_CONTEXT_H
#define PHONGSPLAT_VIEWS_GL_CONTEXT_H

#include <phongsplat/splat.h>
#include <phongsplat/host.h>

/* Creates a context of GL, or of GLES where GL is not available. With software it is that of Mesa's
 * software rasteriser. The caller frees *host with psplat_host_destroy. Errors: those of
 * psplat_host_create. */
psplat_result psplat_context_create(int software, psplat_host **host, psplat_error *error);

#endif
