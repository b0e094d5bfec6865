/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_stream.h - splats as a coded stream (spec 3.12): all that else would be in accessors, but
 * for coarse positions and texture coordinates, and in the extension object.
 */
#ifndef PHONGSPLAT_EXPORT_SPLAT_STREAM_H
#define PHONGSPLAT_EXPORT_SPLAT_STREAM_H

#include "export/splat_attributes.h"

#include <phongsplat/splat.h>

/* The most bits of a position that a stream may hold, and the most sections. */
enum { PSPLAT_MOST_LOW_BITS = 8, PSPLAT_MOST_SECTIONS = 32 };

/* Splats of one kind. */
typedef struct psplat_section {
    uint32_t *order; /* indices of the splats, in an order in which near ones follow each other
                        (splat_order.h) */
    size_t count;
    size_t clip_lines; /* the most of any splat */
    size_t seam_lines; /* of each splat, the last ones */
    float depth_tolerance;
    int is_curved, has_shape; /* as in psplat_run */
    int has_texcoord_bend;    /* the same */
} psplat_section;

/* Returns whether a stream can hold the splats of a table: integers whose turns have steps that are
 * a half turn over a power of two. */
int psplat_stream_can_hold(const psplat_attribute_table *table);

/* Returns component k of the coarse position of a splat, which an accessor holds. The stream has
 * the low bits that it lacks. */
int32_t psplat_stream_coarse_position(const psplat_attribute_table *table, size_t index, int k,
                                      uint32_t low_bits);

/* Returns whether a stream can hold the texture coordinates of a table, where it has some: their
 * numbers are on a grid and fit. */
int psplat_stream_can_hold_texcoords(const psplat_attribute_table *table);

/* Returns how many bits the steps of TEXCOORD_0 beside a stream have less than those in it. */
uint32_t psplat_stream_texcoord_low_bits(const psplat_attribute_table *table);

/* Returns component k of a splat's TEXCOORD_0 beside a stream, in those steps. */
int32_t psplat_stream_coarse_texcoord(const psplat_attribute_table *table, size_t index, int k);

/* How a stream is to be made. */
typedef struct psplat_stream_desc {
    uint32_t low_bits;   /* of positions */
    int holds_texcoords; /* of all splats, where the table's can be held */
} psplat_stream_desc;

/* Encodes sections, 1 to PSPLAT_MOST_SECTIONS of them, of a table that a stream can hold. Returns
 * malloc'ed bytes, which the caller owns, or NULL where memory ran out or, with *is_safe 0, where
 * readers might predict texture coordinates differently. */
uint8_t *psplat_stream_encode(const psplat_attribute_table *table, const psplat_section *sections,
                              size_t section_count, const psplat_stream_desc *desc, size_t *size,
                              int *is_safe);

#endif
