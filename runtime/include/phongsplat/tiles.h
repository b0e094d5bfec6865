/* SPDX-License-Identifier: MIT
 *
 * phongsplat/tiles.h - scenes larger than memory: a tree of tiles (3D Tiles 1.0 and 1.1), of which
 * each frame draws what its pixels need.
 *
 * The runtime reads no tile itself. It says which tiles it wants, the host reads their bytes when
 * and how it likes (files, HTTP ranges, threads), and hands them in on any thread. What has not
 * arrived is drawn as the tile above it.
 *
 *     const psplat_tiles_desc desc = {.source = my_source};
 *     psplat_tiles_open(&desc, "scene/tileset.json", &tiles, &error);
 *     // every frame, on the thread of the GL context:
 *     psplat_tiles_select(tiles, &(psplat_tiles_view){.view = &view}, &error);
 *     n = psplat_tiles_wanted(tiles, requests, 16); // most important first; threads read them
 *     psplat_tiles_upload(tiles, renderer, 4 << 20, &error);
 *     items = psplat_tiles_items(tiles, &count);
 *     psplat_draw(renderer, &view, items, count, &error);
 *     // on any thread, when the bytes of a request have arrived:
 *     psplat_tiles_supply(tiles, request.tile, bytes, size, &error); // decodes there
 *
 * What is read of a tileset: boundingVolume (box, sphere, region), geometricError, refine REPLACE,
 * transform, content and contents with .glb files (or .gltf files that need no other file),
 * children, external tilesets, and of the extras of tiles what schema/README.md describes. Refused
 * are refine ADD of a tile that has something to draw (coarse splats would blend over fine ones),
 * implicit tiling, viewerRequestVolume, extensions that are required (but 3DTILES_content_gltf),
 * and everything malformed: errors that grow downwards, singular transforms, tiles with neither
 * content nor children, paths that leave the directory of the tileset, absolute URIs, external
 * tilesets whose root has no content or that refer to themselves, more than 31 tiles nested in one
 * file or 16,777,216 tiles.
 *
 * Coordinates towards the host are glTF's, with y up: a point (x, y, z) of a tileset is (x, z, -y)
 * here. Without transforms of tiles that is the space of the .glb files.
 */
#ifndef PHONGSPLAT_TILES_H
#define PHONGSPLAT_TILES_H

#include "phongsplat.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A tileset with what is in memory of it. It belongs to one thread at a time, that of the GL
 * context once something is uploaded, but for psplat_tiles_supply and psplat_tiles_fail. */
typedef struct psplat_tiles psplat_tiles;

/* Reading of parts of files, for psplat_tiles_open alone. Where it is zero-initialised, stdio is
 * used. read() reads size bytes from offset of a file on, or as many as there are up to its end,
 * into data and stores their number in *got. size() stores the size of a file in *size; it is
 * needed for archives alone and may be NULL. path is that of psplat_tiles_open. Errors of both:
 * READ, MEMORY, INTERRUPTED; they may fill error. */
typedef struct psplat_tiles_source {
    psplat_result (*read)(void *user, const char *path, uint64_t offset, void *data, size_t size,
                          size_t *got, psplat_error *error);
    void *user;
    psplat_result (*size)(void *user, const char *path, uint64_t *size, psplat_error *error);
} psplat_tiles_source;

/* The parameters of psplat_tiles_open. Zeros are the defaults. */
typedef struct psplat_tiles_desc {
    psplat_allocator allocator; /* called by every thread that calls psplat_tiles_supply, by several
                                   at once if they are */
    psplat_tiles_source source;
    size_t max_bytes;    /* of tiles: what decoding takes, what waits for the upload, and textures
                            on the GPU; 0 means 512 MiB. It is never exceeded, but for decoded images
                            of textured splats while they are uploaded: a tile for which they leave
                            no room is then dropped again. The tree of tiles itself,
                            some 600 bytes a tile, is not counted */
    size_t max_requests; /* under way and waiting for the upload at a time, at most 65,536; 0 means
                            16 */
    double fade_seconds; /* how long tiles fade into those that replace them; 0: not at all */
} psplat_tiles_desc;

/* Opens a tileset: path is that of its tileset.json, whose directory holds everything that it
 * names, or of an archive that holds all of them (.3tz, a ZIP archive in which files are stored as
 * they are). Only this file is read here, of an archive its directory and its tileset.json;
 * external tilesets are requested like tiles. On success *tiles belongs to the caller, who destroys
 * it; on failure it is NULL, and error says what is wrong and at which byte of the file. Errors:
 * ARGUMENT, MEMORY, READ, FORMAT, RANGE, UNSUPPORTED, NO_SPLATS (no tile has a content). */
PSPLAT_EXPORT psplat_result psplat_tiles_open(const psplat_tiles_desc *desc, const char *path,
                                              psplat_tiles **tiles, psplat_error *error);

/* Destroys a tileset with everything in memory. No psplat_tiles_supply may be running; requests may
 * be under way, and are then forgotten. renderer is that of the uploads, and may be NULL where
 * nothing was uploaded. NULL is accepted for tiles. */
PSPLAT_EXPORT void psplat_tiles_destroy(psplat_tiles *tiles, psplat_renderer *renderer);

/* Computes an axis-aligned box around the root's bounding volume. */
PSPLAT_EXPORT void psplat_tiles_bounds(const psplat_tiles *tiles, double min[3], double max[3]);

/* The parameters of psplat_tiles_select. Zeros are the defaults of all members but view. */
typedef struct psplat_tiles_view {
    const psplat_view *view; /* of which view, projection, width, height, culling and what lights
                                cast shadows are used */
    double transform[16];    /* of the tileset in the scene, as psplat_item.transform; all zeros
                                mean the identity */
    double pixels; /* tau: the greatest error of what is drawn, pixels; 0 means 1. A tile's error
                      in pixels is that of a length of its geometricError, parallel to the image
                      plane, at the nearest visible point of its bounding volume */
    size_t max_splats; /* that are drawn at most, if the root has no more, or where it has no
                          content the tiles right below it; 0: any number */
    double seconds;    /* time of this frame, for cross-fades; it does not run backwards */
} psplat_tiles_view;

/* Chooses the tiles of a frame, the coarsest whose errors are at most view->pixels: best first by
 * coverage x error removed / splats added, until that holds or a budget is met. A tile is replaced
 * by those of its children that may be visible only where all of these are in memory; else it is
 * drawn and they are wanted. A tile that was replaced in the last frame stays so down to 0.9
 * pixels. Tiles outside the view are left out, and those of which only backs are seen (by the cone
 * of their extras), where materials are single-sided or the view culls always, and no light casts
 * shadows. Tiles outside the view cast none into it.
 *
 * It calls no GL, waits for nothing, and allocates nothing once as many tiles were drawn before.
 * The same calls choose the same tiles. Items of the call before are gone. Errors: ARGUMENT (a
 * pointer is NULL, a matrix has no inverse, a number is out of range), MEMORY; then nothing is
 * drawn. */
PSPLAT_EXPORT psplat_result psplat_tiles_select(psplat_tiles *tiles, const psplat_tiles_view *view,
                                                psplat_error *error);

/* A part of a file that is wanted. */
typedef struct psplat_tile_request {
    uint64_t tile;         /* for psplat_tiles_supply and psplat_tiles_fail */
    const char *path;      /* relative to the directory of the tileset, normalised, percent escapes
                              decoded, with no part that is "..", or the name of the archive. It
                              lives as long as the tileset */
    uint64_t offset, size; /* bytes in that file, which psplat_tiles_supply takes as they are; size
                              0: from offset to its end */
    double priority;       /* greater is more important; negative beside the view */
} psplat_tile_request;

/* Takes up to capacity requests of the last select out, most important first, and returns their
 * number. Each is then under way until it is supplied or failed. What would not fit into max_bytes
 * is held back. A tile is requested only after the one above it has arrived, so that something is
 * there soon. */
PSPLAT_EXPORT size_t psplat_tiles_wanted(psplat_tiles *tiles, psplat_tile_request *requests,
                                         size_t capacity);

/* Hands in the bytes of a request and decodes them; they are not needed afterwards. It may be
 * called on any thread and by several at once, for different requests. On failure the request is
 * done, too: a file that is wrong is never requested again and the tile above it is drawn in its
 * place; one for which there was no memory is requested again later. Errors: ARGUMENT (the request
 * is not under way), MEMORY (of the allocator or of max_bytes), those of psplat_asset_open_memory,
 * and for external tilesets those of psplat_tiles_open. */
PSPLAT_EXPORT psplat_result psplat_tiles_supply(psplat_tiles *tiles, uint64_t tile,
                                                const void *bytes, size_t size,
                                                psplat_error *error);

/* Says that a request could not be read. is_final 0: it is wanted again after some frames, more of
 * them each time; 1: never again. On any thread. A request that is not under way is ignored. */
PSPLAT_EXPORT void psplat_tiles_fail(psplat_tiles *tiles, uint64_t tile, int is_final);

/* Uploads tiles that were supplied, most important first, until max_bytes bytes are reached, but
 * one at least; and destroys tiles that the last select did not use, least recently used first, to
 * make room for these and for what is wanted. What the last select draws, the tiles above it and
 * the root stay. A tile that does not fit into psplat_tiles_desc.max_bytes beside the root alone
 * counts as one that cannot be read. The context is current. Errors: ARGUMENT, and those of
 * psplat_model_create; a tile that failed by ARGUMENT, MEMORY or GRAPHICS is requested again later,
 * others are not, and the call may be repeated. After a loss of the context the tileset is
 * destroyed with the old renderer and opened anew. */
PSPLAT_EXPORT psplat_result psplat_tiles_upload(psplat_tiles *tiles, psplat_renderer *renderer,
                                                size_t max_bytes, psplat_error *error);

/* Returns what the last select draws, *count items for the renderer of the uploads. They are valid
 * until the next select, over any number of uploads. */
PSPLAT_EXPORT const psplat_item *psplat_tiles_items(const psplat_tiles *tiles, size_t *count);

/* Numbers of the last select and of memory. */
typedef struct psplat_tiles_state {
    size_t drawn, splats;   /* tiles and splats that are drawn, those that fade out included */
    size_t missing;         /* tiles drawn above the greatest error because others have not arrived
                               or cannot be read */
    size_t over_budget;     /* the same because of max_splats or max_bytes */
    size_t leaves;          /* the same because they have no children */
    size_t culled;          /* tiles that were looked at and are not visible */
    size_t wanted;          /* requests that psplat_tiles_wanted may give out */
    size_t under_way;       /* requests given out, neither supplied nor failed */
    size_t waiting;         /* supplied, not uploaded */
    size_t failed;          /* never requested again */
    size_t bytes;           /* that count against max_bytes now */
    size_t tiles, resident; /* in the tree as far as it is known, and of them on the GPU */
    double error_pixels;    /* the greatest of what is drawn, without what fades out */
} psplat_tiles_state;

/* Returns these numbers, or zeros where tiles is NULL. */
PSPLAT_EXPORT psplat_tiles_state psplat_tiles_describe(const psplat_tiles *tiles);

#ifdef __cplusplus
}
#endif
#endif
