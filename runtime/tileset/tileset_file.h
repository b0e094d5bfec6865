/* SPDX-License-Identifier: MIT
 *
 * tileset_file.h - reads one tileset.json (3D Tiles 1.0 and 1.1) into tables of tiles and contents.
 */
#ifndef PHONGSPLAT_TILESET_TILESET_FILE_H
#define PHONGSPLAT_TILESET_TILESET_FILE_H

#include "core/arena.h"
#include "tileset/archive.h"
#include "tileset/volume.h"

#define PSPLAT_TILE_NONE UINT32_MAX

/* The most tiles of a tree, and the most tilesets that refer to one another. */
enum { PSPLAT_TILE_MAX_COUNT = 1 << 24, PSPLAT_TILE_MAX_FILES_DEEP = 64 };

/* A file with tiles, for messages and against circles of files. */
typedef struct psplat_tile_file {
    const char *path;                        /* relative to the directory of the tileset */
    const struct psplat_tile_file *referrer; /* NULL for the first file */
} psplat_tile_file;

/* A tile. Lengths and directions are in the space of the whole tileset, with y up. */
typedef struct psplat_tile_node {
    psplat_tile_volume volume;
    double error;    /* geometricError */
    double cone[4];  /* axis of unit length, cosine of the angle to it that no normal of
                        the tile exceeds; cosine -2: unknown */
    uint32_t parent; /* PSPLAT_TILE_NONE for the root */
    uint32_t first_child, child_count;     /* children lie side by side */
    uint32_t first_content, content_count; /* all of them are drawn together */
    uint32_t transform; /* from the space of contents, an index into transforms */
    uint32_t splats;    /* as extras say or the contents turned out; 0: unknown */
} psplat_tile_node;

/* A file that a tile shows, or an external tileset that stands in its place. */
typedef struct psplat_tile_content {
    const char *path;
    uint64_t offset, size; /* in the file; 0 0: all of it */
    uint64_t stored;       /* bytes of it in these bytes of an archive */
    uint32_t node;
    int is_tileset;
    const psplat_tile_file *file; /* that refers to it */
} psplat_tile_content;

/* What a tileset.json says, in tables. Only the first tile, the root, may be without a content, and
 * only in the first file: tiles without one are left out in favour of their children. */
typedef struct psplat_tileset {
    psplat_arena kept;    /* paths and file */
    psplat_arena scratch; /* the tables */
    psplat_tile_file *file;
    psplat_tile_node *nodes; /* each after its parent */
    psplat_tile_content *contents;
    double (*transforms)[16]; /* affine, y up; number 0 is that of the place where the root is */
    size_t node_count, content_count, transform_count;
} psplat_tileset;

/* Where a tileset stands. */
typedef struct psplat_tileset_place {
    const char *path;                   /* of the file, relative; copied */
    const psplat_tile_file *referrer;   /* NULL for the first file */
    double transform[16];               /* of the tile that refers to it, y up */
    double error;                       /* of that tile, which no tile exceeds; HUGE_VAL: none */
    const psplat_tile_archive *archive; /* that holds all files; NULL: they are in a directory */
    psplat_allocator allocator;         /* with a resize */
} psplat_tileset_place;

/* Reads a file. On success the caller releases both arenas of *tileset, scratch at any time and
 * kept after everything that refers to paths; on failure nothing is left to release. The text of
 * the error begins with the path. Errors: MEMORY, FORMAT, RANGE, UNSUPPORTED, NO_SPLATS. */
psplat_result psplat_tileset_read(const void *text, size_t size, const psplat_tileset_place *place,
                                  psplat_tileset *tileset, psplat_error *error);

#endif
