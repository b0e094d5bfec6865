/* SPDX-License-Identifier: MIT
 *
 * archive.h - tilesets in one file: the directory of a .3tz archive, which is a ZIP archive
 * (APPNOTE 6.3) of files that are stored as they are.
 */
#ifndef PHONGSPLAT_TILESET_ARCHIVE_H
#define PHONGSPLAT_TILESET_ARCHIVE_H

#include "core/arena.h"

#include <phongsplat/tiles.h>

/* A file in an archive. */
typedef struct psplat_tile_entry {
    const char *name; /* name_size bytes, not terminated */
    size_t name_size;
    uint64_t offset; /* of its header in the archive */
    uint64_t span;   /* bytes from there on that hold the header and the file */
    uint64_t size;   /* of the file */
    int is_stored;   /* 0: it is compressed or encrypted */
} psplat_tile_entry;

typedef struct psplat_tile_archive {
    psplat_arena arena;
    const char *name; /* of the archive, without its directory */
    psplat_tile_entry *entries;
    size_t entry_count;
} psplat_tile_archive;

/* Reads the directory of an archive. On success the caller releases the arena; on failure nothing
 * is left to release. Errors: MEMORY, READ, FORMAT, UNSUPPORTED. */
psplat_result psplat_tile_archive_open(const psplat_tiles_source *source, const char *path,
                                       const psplat_allocator *allocator,
                                       psplat_tile_archive *archive, psplat_error *error);

/* Returns the file with this name, or NULL. */
const psplat_tile_entry *psplat_tile_archive_find(const psplat_tile_archive *archive,
                                                  const char *name);

/* Finds a file of file_size bytes in the bytes of its span. Errors: FORMAT. */
psplat_result psplat_tile_archive_unpack(const void *span, size_t span_size, uint64_t file_size,
                                         const void **data, psplat_error *error);

#endif
