/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * layout.h - where the attributes of splats lie in a file: primitives, and the buffer views that
 * hold their rows. For the writer: columns.c, layout.c, document.c, glb.c.
 */
#ifndef PHONGSPLAT_LAYOUT_H
#define PHONGSPLAT_LAYOUT_H

#include "columns.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where a column lies: in which view, and how far from its beginning the first element is. */
typedef struct psplat_place_in_view {
    size_t view, offset;
} psplat_place_in_view;

/* One primitive: splats of a mesh, those of each clip class one after another. */
typedef struct psplat_part {
    size_t mesh, count;
    size_t first[PSPLAT_MAX_CLIP_LINES + 1], counts[PSPLAT_MAX_CLIP_LINES + 1]; /* by class */
    size_t clip_lines; /* of those with the most; others are padded (spec 3.6) */
    size_t material;
    float depth_tolerance;
    psplat_column columns[PSPLAT_COLUMNS];
    psplat_place_in_view places[PSPLAT_COLUMNS];
} psplat_part;

/* Rows of equal size. */
typedef struct psplat_file_view {
    size_t stride, rows, capacity; /* bytes of a row; rows there are and there is room for */
    int is_octahedral;             /* before the filter of EXT_meshopt_compression */
    int is_index;                  /* indices of triangles instead of attributes */
    uint8_t *bytes;
    uint8_t *packed; /* compressed; NULL: not */
    size_t packed_size;
} psplat_file_view;

typedef struct psplat_layout {
    psplat_sheet *sheets; /* mesh_count */
    size_t mesh_count;
    psplat_part *parts; /* by mesh, in the order of its splats */
    size_t part_count;
    psplat_file_view *views;
    size_t view_count;
    const struct psplat_stand_in_file *stand_ins; /* or NULL; made by stand_in_file.c */
} psplat_layout;

/* How a layout is made; glb.c tries several. */
typedef struct psplat_layout_plan {
    int rows_alike;            /* all primitives of a mesh have rows for what any of them has */
    int lines_apart;           /* clip lines have a view of their own, whose rows are lines */
    int normals_apart;         /* normals have, as the octahedral filter takes them */
    double padding;            /* what a byte of a padded line costs in the file, bytes */
    const psplat_codec *codec; /* NULL: not compressed */
} psplat_layout_plan;

/* Lays out the sheets of layout. Errors: MEMORY. psplat_layout_clear also then. */
psplat_result psplat_layout_make(const psplat_layout_plan *plan, psplat_layout *layout,
                                 psplat_error *error);
/* Frees all but the sheets and stand-ins. */
void psplat_layout_clear(psplat_layout *layout);

#ifdef __cplusplus
}
#endif
#endif
