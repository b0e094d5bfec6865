/* SPDX-License-Identifier: MIT
 *
 * stream.h - the coded stream of a primitive of splats (spec 3.12): one buffer view that holds what
 * else would be in the extension object and in accessors.
 */
#ifndef PHONGSPLAT_ASSET_STREAM_H
#define PHONGSPLAT_ASSET_STREAM_H

#include "asset/gltf.h"

enum { PSPLAT_MAX_SECTIONS = 32 };

/* Consecutive splats of one kind. Each section becomes a set of its own. */
typedef struct psplat_stream_section {
    size_t first, count;
    uint32_t clip_count;
    uint32_t seam_lines; /* of these; the stream itself does not say it */
    float depth_tolerance;
    int is_curved;
    int has_own_field; /* a flat splat's NORMAL_FIELD, or a curved one's beside its SHAPE */
    int has_gamma, has_tilt, has_bends;
    int has_texcoord_bend; /* where the stream has texture coordinates */
} psplat_stream_section;

/* A stream, decoded. */
typedef struct psplat_stream {
    psplat_json_value json; /* the index of its view, for errors */
    const uint8_t *bytes;
    size_t size;
    psplat_buffer decoded; /* a row of floats for each splat, where decoded */
    uint32_t low_bits, normal_bits, turn_bits, line_turn_bits, halving, shape_grades, normal_grades;
    int32_t reference;
    psplat_kernel kernel;
    double extent[3], found_extent[3]; /* of centres: as written, and as decoded */
    double first_radius, radius_step, tilt_step, field_step, shape_step, line_step, bend_step;
    int has_texcoord;           /* but for the coarse TEXCOORD_0 */
    uint32_t texcoord_low_bits; /* of T_0, less those of TEXCOORD_0 */
    double texcoord_step, texcoord_slope_step, texcoord_bend_step;
    size_t head_size, count, section_count;
    psplat_stream_section sections[PSPLAT_MAX_SECTIONS];
    /* Bits that attributes take, by section; zeros unless gltf->measures. */
    double spent[PSPLAT_MAX_SECTIONS][PSPLAT_ATTRIBUTES];
} psplat_stream;

/* Reads the head and the sections of the stream in the view of an index in JSON. *stream belongs to
 * gltf, which has one: it and readers of it hold until the next call. Fails with FORMAT, RANGE,
 * UNSUPPORTED or MEMORY. */
psplat_result psplat_stream_open(psplat_gltf *gltf, psplat_json_value view, psplat_stream **stream);

/* Decodes all splats, whose coarse positions are those of POSITION, as coordinates are of
 * TEXCOORD_0, where the stream has some. */
psplat_result psplat_stream_decode(psplat_gltf *gltf, const psplat_readers *beside,
                                   psplat_stream *stream);

/* Sets the readers of all attributes that the stream holds to those of a section. */
void psplat_stream_readers(const psplat_stream *stream, size_t section, psplat_readers *readers);

/* Returns whether the stream holds an attribute, so that accessors of it are not allowed. */
int psplat_stream_holds(const psplat_stream *stream, size_t attribute);

#endif
