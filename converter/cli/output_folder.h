/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output_folder.h - a folder of files that appears whole or not at all.
 */
#ifndef PHONGSPLAT_CLI_OUTPUT_FOLDER_H
#define PHONGSPLAT_CLI_OUTPUT_FOLDER_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

/* Files in memory, by names like "tiles/a.glb" with one folder at most. Zero-initialise it. */
typedef struct psplat_output_folder {
    struct psplat_folder_file *files;
    size_t count, capacity;
} psplat_output_folder;

/* Adds a file with a copy of its bytes. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_output_folder_add(psplat_output_folder *folder, const char *name,
                                       const void *data, size_t size, psplat_error *error);

/* Checks, before any work is done, where a tileset shall go: nothing or an empty folder, or with
 * overwrite one that holds a tileset and nothing else; never the working directory or one above it
 * or a mount point, which cannot be renamed. input is the source. Errors: WRITE, MEMORY. */
psplat_result psplat_output_folder_check(const char *input, const char *path, int overwrite,
                                         psplat_error *error);

/* Writes the files to a new folder beside path and gives that the name in the end, in place of the
 * tileset that is there; where path is a symbolic link, in place of what it points to. Signals that
 * would end the process are held back meanwhile. Errors: WRITE, MEMORY; path is as it was then. */
psplat_result psplat_output_folder_write(const psplat_output_folder *folder, const char *path,
                                         int overwrite, psplat_error *error);

void psplat_output_folder_free(psplat_output_folder *folder);

#endif
