/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_rewrite.h - a growing buffer that replaces the content of a source file.
 */
#ifndef PHONGSPLAT_SOURCE_SOURCE_REWRITE_H
#define PHONGSPLAT_SOURCE_SOURCE_REWRITE_H

#include <phongsplat/splat.h>

#include "source/source_file.h"

/* Text or bytes that will replace the content of a source. Zero-initialise; after a failure the
 * caller frees data. */
typedef struct psplat_rewrite {
    char *data;
    size_t size, capacity;
} psplat_rewrite;

/* Appends bytes. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_rewrite_bytes(psplat_rewrite *rewrite, const void *bytes, size_t size,
                                   psplat_error *error);

/* Appends text as printf makes it. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_rewrite_text(psplat_rewrite *rewrite, psplat_error *error, const char *format,
                                  ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Replaces the content of the source, which then owns data, and makes the buffer empty. */
void psplat_rewrite_replace(psplat_rewrite *rewrite, psplat_source *source);

#endif
