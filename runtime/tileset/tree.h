/* SPDX-License-Identifier: MIT
 *
 * tree.h - the tree of a tileset as far as it is known, what of it is in memory, and the order in
 * which that was used.
 */
#ifndef PHONGSPLAT_TILESET_TREE_H
#define PHONGSPLAT_TILESET_TREE_H

#include "core/arena.h"
#include "tileset/tileset_file.h"

#include <phongsplat/tiles.h>

#include <stdatomic.h>

/* How contents become drawable: the functions of psplat_model, for which tests put others. */
typedef struct psplat_tile_models {
    psplat_result (*create)(psplat_renderer *renderer, const psplat_asset *asset,
                            psplat_model **model, psplat_error *error);
    void (*destroy)(psplat_renderer *renderer, psplat_model *model);
    psplat_model_info (*describe)(const psplat_model *model);
} psplat_tile_models;

/* ---- what changes of contents and tiles --------------------------------------------------- */

typedef enum psplat_tile_progress {
    PSPLAT_TILE_ABSENT = 0,
    PSPLAT_TILE_IN_SLOT, /* requested, being decoded or waiting for the upload */
    PSPLAT_TILE_UPLOADED,
    PSPLAT_TILE_FAILED /* never requested again */
} psplat_tile_progress;

/* What of a content is in memory. */
typedef struct psplat_tile_load {
    psplat_tile_progress progress;
    psplat_model *model;
    size_t bytes;      /* of the model */
    size_t need;       /* bytes that decoding and uploading took, or are known to exceed; 0: not
                          known yet */
    uint32_t failures; /* in a row */
    uint32_t again;    /* the frame from which on it may be requested */
    uint32_t splats;
    double priority;     /* of the last frame in which it was wanted */
    int is_double_sided; /* once it was uploaded: 1 where a material shows backs */
} psplat_tile_load;

typedef enum psplat_tile_sides {
    PSPLAT_SIDES_UNKNOWN = 0,
    PSPLAT_SIDES_SINGLE,
    PSPLAT_SIDES_DOUBLE
} psplat_tile_sides;

/* What select knows of a tile. Frames are numbers of selects, the first being 1. */
typedef struct psplat_tile_use {
    double scale;          /* pixels of a unit of length, in frame `looked` */
    double child_error;    /* greatest error of the children */
    double cone[4];        /* of the tile and all tiles below it */
    uint32_t looked;       /* frame in which is_visible and scale were found */
    uint32_t refined;      /* frame in which it was last replaced by its children */
    uint32_t used;         /* frame in which it was last needed */
    uint32_t shown;        /* frame in which it was last drawn or stood above what was */
    uint32_t uploaded;     /* contents that are uploaded */
    uint32_t newer, older; /* in the list of tiles in memory, PSPLAT_TILE_NONE at its ends */
    psplat_tile_sides sides;
    float mix;                /* 0: it is drawn, 1: its children are; between them it fades out */
    float weight;             /* in the last frame in which it was shown */
    int is_visible, is_aside; /* is_aside: it is not in the view, whichever side it shows */
    int is_listed;
} psplat_tile_use;

/* ---- requests ------------------------------------------------------------------------------ */

/* States of slots, the lowest bits of psplat_tile_slot.state; the rest counts the requests that the
 * slot has had. A slot belongs to the thread of select, but while DECODING to the one that does. */
enum psplat_tile_slot_state {
    PSPLAT_SLOT_FREE = 0,
    PSPLAT_SLOT_UNDER_WAY,
    PSPLAT_SLOT_DECODING,
    PSPLAT_SLOT_ARRIVED, /* with an asset or a tileset */
    PSPLAT_SLOT_RETRY,
    PSPLAT_SLOT_FAILED,
    PSPLAT_SLOT_BITS = 3
};

/* A request under way, and what came of it until it is uploaded. */
typedef struct psplat_tile_slot {
    struct psplat_tiles *tiles;
    _Atomic uint32_t state;
    uint32_t content;
    _Atomic size_t bytes; /* of the asset while it is decoded and waits */
    size_t peak;          /* the most of these */
    size_t refused;       /* bytes that it would have had where max_bytes refused them; 0: never */
    size_t reserved;      /* bytes that it is expected to take */
    psplat_asset *asset;
    psplat_tileset tileset;     /* of a content that is one */
    psplat_tileset_place place; /* for it */
    int is_tileset;
    uint64_t stored; /* bytes of the file in those of an archive */
} psplat_tile_slot;

typedef enum psplat_tile_family_kind {
    PSPLAT_FAMILY_CHILDREN, /* the visible children of a tile that is too coarse */
    PSPLAT_FAMILY_ALONE,    /* a tile */
    PSPLAT_FAMILY_ASIDE /* the children of a replaced tile that are beside the view: where one of
                           them came into view and were not there, the tile would be drawn again */
} psplat_tile_family_kind;

/* Tiles that are wanted together. */
typedef struct psplat_tile_family {
    double priority;
    uint32_t node;
    psplat_tile_family_kind kind;
} psplat_tile_family;

typedef struct psplat_tile_candidate {
    double gain;
    uint32_t node;
} psplat_tile_candidate;

/* The arrays that grow with the tree. */
enum psplat_tile_table {
    PSPLAT_TABLE_NODES,
    PSPLAT_TABLE_USES,
    PSPLAT_TABLE_HEAP,
    PSPLAT_TABLE_FAMILIES,
    PSPLAT_TABLE_SHOWN,
    PSPLAT_TABLE_CONTENTS,
    PSPLAT_TABLE_LOADS,
    PSPLAT_TABLE_REQUESTS,
    PSPLAT_TABLE_TRANSFORMS,
    PSPLAT_TABLE_KEPT,
    PSPLAT_TILE_TABLES
};

struct psplat_tiles {
    psplat_allocator allocator;
    const psplat_tile_models *models;
    psplat_tile_archive archive; /* its name is NULL where there is none */
    size_t max_bytes, max_requests;
    double fade_seconds;
    _Atomic size_t bytes; /* of all slots and models */

    /* The tree. */
    psplat_tile_node *nodes;
    psplat_tile_use *uses;
    psplat_tile_content *contents;
    psplat_tile_load *loads;
    double (*transforms)[16];
    psplat_arena *kept; /* of each file */
    size_t node_count, content_count, transform_count, file_count;
    size_t capacities[PSPLAT_TILE_TABLES]; /* entries that each table has room for */

    /* Tiles in memory, by the time of their last use. A tile is older than the one above it. */
    uint32_t newest, oldest;
    size_t resident, failed;
    double splat_bytes,
        content_bytes; /* what splats and contents took so far, with their numbers */
    double splat_total, content_total;

    psplat_tile_slot *slots; /* max_requests */

    /* The last select. */
    uint32_t frame;
    double seconds;
    psplat_tile_candidate *heap; /* one for each tile, as the next two */
    psplat_tile_family *families;
    uint32_t *shown;    /* tiles that are drawn or stand above these */
    uint32_t *requests; /* one for each content: contents that are wanted */
    size_t heap_count, family_count, shown_count, request_count, next_request;
    size_t cut_splats, pinned; /* of tiles chosen; bytes of tiles used */
    psplat_item *items;
    size_t item_count, item_capacity;
    psplat_tiles_state state;
};

/* ---- tree.c -------------------------------------------------------------------------------- */

/* Makes the tables of a file part of the tree: as the tree itself, or in the place of the tile
 * `node`, which referred to it. It takes over the arenas where it succeeds. Errors: MEMORY,
 * UNSUPPORTED (there are too many tiles). */
psplat_result psplat_tiles_graft(psplat_tiles *tiles, psplat_tileset *tileset, uint32_t node,
                                 psplat_error *error);

/* Returns 1 where all contents of a tile are on the GPU. */
int psplat_tile_is_ready(const psplat_tiles *tiles, uint32_t node);

/* Frees the tables of the tree. */
void psplat_tiles_free_tree(psplat_tiles *tiles);

/* ---- the list of tiles in memory ----------------------------------------------------------- */

/* Makes a tile the newest, if it is in the list. */
void psplat_tile_touch(psplat_tiles *tiles, uint32_t node);

/* Puts a tile into the list, right behind the one above it, if it is not there. */
void psplat_tile_enlist(psplat_tiles *tiles, uint32_t node);
void psplat_tile_unlist(psplat_tiles *tiles, uint32_t node);

#endif
