/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * folder.h - the directory of a sweep. A directory that holds a tradeoff.csv counts as one; files
 * of the user beside it are left alone. Two sweeps at once must not share a directory.
 */
#ifndef PHONGSPLAT_TABLE_FOLDER_H
#define PHONGSPLAT_TABLE_FOLDER_H

#include <phongsplat/splat.h>

extern const char psplat_folder_table[]; /* "tradeoff.csv" */

/* Makes the directory where there is none, and within it directories "assets" and "pictures" and an
 * empty table.
 * Refuses one that holds something, but no table: WRITE. */
psplat_result psplat_folder_open(const char *path, psplat_error *error);
/* Returns the path of a file in it, from malloc, or NULL where memory ran out. */
char *psplat_folder_path(const char *folder, const char *name);
/* Writes a file as psplat_output_write does, over what is there. */
psplat_result psplat_folder_write(const char *folder, const char *name, const void *data,
                                  size_t size, psplat_error *error);
/* Reads a whole file; *data is from malloc and terminated. */
psplat_result psplat_folder_read(const char *folder, const char *name, char **data, size_t *size,
                                 psplat_error *error);

#endif
