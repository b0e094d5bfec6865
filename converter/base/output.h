/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output.h - atomic file output: files are written whole or not at all.
 */
#ifndef PHONGSPLAT_BASE_OUTPUT_H
#define PHONGSPLAT_BASE_OUTPUT_H

#include <phongsplat/splat.h>

#include <stddef.h>

/* Writes size bytes to path. The bytes go to a temporary file, which is synced and then renamed, so
 * that path holds either the old content or the new one and never a part, whatever ends the
 * process. An existing file is refused unless overwrite is set. The path "-" is standard output.
 * Errors: PSPLAT_ERROR_WRITE with a text that names path and cause, PSPLAT_ERROR_ARGUMENT,
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_output_write(const char *path, const void *data, size_t size, int overwrite,
                                  psplat_error *error);

/* A file to be written. */
typedef struct psplat_output_file {
    const char *path; /* as above */
    const void *data;
    size_t size;
} psplat_output_file;

enum { PSPLAT_MOST_OUTPUTS = 4 };

/* Writes files that belong together, at most PSPLAT_MOST_OUTPUTS of them, all or none. What cannot
 * be taken back comes first: standard output, devices and pipes; then the temporary files of all
 * others; then each gets its name. If that fails for one, those before it vanish again unless they
 * have replaced another file. Errors: those of psplat_output_write. */
psplat_result psplat_output_write_all(const psplat_output_file *files, size_t count, int overwrite,
                                      psplat_error *error);

#endif
