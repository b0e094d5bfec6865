/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * buffer_layout.h - the primitives of a file and the buffer views that hold their attributes.
 *
 * The layout is made from attribute tables (splat_attributes.h); gltf_document.c describes it in
 * JSON and glb_writer.c writes its bytes.
 */
#ifndef PHONGSPLAT_EXPORT_BUFFER_LAYOUT_H
#define PHONGSPLAT_EXPORT_BUFFER_LAYOUT_H

#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "export/splat_stream.h"

#include <phongsplat/splat.h>

/* The buffer view in which an attribute lies, and the offset of its first element, bytes. */
typedef struct psplat_attribute_place {
    size_t view, offset;
} psplat_attribute_place;

/* The parts of a primitive: one for each number of clip lines, and, after those, one for each
 * number of clip lines of flat splats that share it with curved ones. */
enum { PSPLAT_LINE_CLASSES = PSPLAT_MAX_CLIP_LINES + 1, PSPLAT_PARTS = 2 * PSPLAT_LINE_CLASSES };

/* One primitive: splats of one mesh with equal material and depth tolerance, and of the same kind
 * of surface but for a few flat ones. */
typedef struct psplat_primitive_layout {
    size_t mesh, count;
    uint32_t *order;       /* the splats' indices, count of them */
    int is_streamed;       /* a stream holds what it can (splat_stream.h) */
    size_t stream;         /* its view */
    int streams_texcoords; /* the stream holds texture coordinates but for the coarse TEXCOORD_0 */
    size_t first[PSPLAT_PARTS], counts[PSPLAT_PARTS];
    size_t clip_lines;    /* the most of any splat; splats with fewer are padded (spec 3.6) */
    size_t seam_lines;    /* as in psplat_run */
    size_t section_count; /* of the stream, where is_streamed is 1 */
    uint8_t section_seams[PSPLAT_MOST_SECTIONS]; /* the seam_lines of each of its sections */
    size_t material;
    float depth_tolerance;
    int is_curved, has_shape; /* as in psplat_run */
    int has_texcoord, has_texcoord_bend;
    psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS];
    psplat_attribute_place places[PSPLAT_ATTRIBUTE_KINDS];
} psplat_primitive_layout;

/* The filters of EXT_meshopt_compression that are used. */
typedef enum psplat_view_filter {
    PSPLAT_FILTER_NONE = 0,
    PSPLAT_FILTER_OCTAHEDRAL, /* of normals */
    PSPLAT_FILTER_EXPONENTIAL /* of floats: texture coordinates */
} psplat_view_filter;

/* What the rows of a view are. */
typedef enum psplat_view_kind {
    PSPLAT_VIEW_VERTICES = 0, /* attributes of splats, points or vertices */
    PSPLAT_VIEW_INDICES,      /* of triangles */
    PSPLAT_VIEW_NUMBERS,      /* of animations */
    PSPLAT_VIEW_STREAM        /* bytes of a stream, never compressed */
} psplat_view_kind;

/* One buffer view: rows of equal size. */
typedef struct psplat_buffer_view {
    size_t stride, rows, capacity; /* bytes of a row; rows stored; rows that fit into bytes */
    psplat_view_filter filter;     /* whose input the bytes are */
    psplat_view_kind kind;
    uint8_t *bytes;
    uint8_t *packed; /* compressed bytes, or NULL */
    size_t packed_size;
} psplat_buffer_view;

typedef struct psplat_buffer_layout {
    psplat_attribute_table *tables; /* mesh_count of them, the caller's */
    size_t mesh_count;
    psplat_primitive_layout *primitives; /* by mesh, then by clip lines */
    size_t primitive_count;
    psplat_buffer_view *views;
    size_t view_count;
    const struct psplat_fallback_file *fallbacks; /* the caller's, or NULL (fallback_mesh_file.h) */
    const struct psplat_animation_file *animations; /* the caller's, or NULL (animation_file.h) */
    const struct psplat_mesh_levels *levels; /* of the first finest_count meshes, whose coarser ones
                                                follow; the caller's, or NULL (mesh_levels.h) */
    size_t finest_count;
    uint32_t low_bits; /* of positions, which are in streams and not in POSITION */
} psplat_buffer_layout;

/* The choices that a layout leaves open; glb_writer.c tries several plans and keeps the smallest
 * file. */
typedef struct psplat_buffer_layout_plan {
    int rows_alike;            /* all primitives of a mesh have rows of the same attributes */
    int lines_apart;           /* clip lines have a view of their own, one line in a row */
    int normals_apart;         /* normals have a view of their own, for the octahedral filter; so
                                  have texture coordinates on a grid wherever there is a codec */
    int flat_joins;            /* few flat splats may share a primitive with curved ones */
    int streams;               /* splats on a grid are in streams */
    uint32_t low_bits;         /* of positions, in streams; 0 beside what else lies at POSITION */
    int short_orders;          /* splats in streams are in orders that have fewer bytes, and take
                                  time to find (splat_order.h) */
    double padding;            /* expected bytes in the file for one byte of padding */
    const psplat_codec *codec; /* NULL leaves the views uncompressed */
} psplat_buffer_layout_plan;

/* Stores the least and the greatest POSITION of a primitive as they are written. */
void psplat_buffer_layout_extent(const psplat_buffer_layout *layout,
                                 const psplat_primitive_layout *primitive, float low[3],
                                 float high[3]);

/* Divides the splats of layout's attribute tables into primitives and fills the buffer views. The
 * caller frees them with psplat_buffer_layout_clear, also after an error. Errors: MEMORY. */
psplat_result psplat_buffer_layout_make(const psplat_buffer_layout_plan *plan,
                                        psplat_buffer_layout *layout, psplat_error *error);
/* Frees the primitives and views; the attribute tables and fallback meshes stay. */
void psplat_buffer_layout_clear(psplat_buffer_layout *layout);

#endif
