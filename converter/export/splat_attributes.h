/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_attributes.h - the attribute table: the vertex attributes of a mesh's splats as bytes.
 *
 * The glTF writer works in this order: splat_attributes.c turns splats into attributes,
 * buffer_layout.c places them in buffer views, gltf_document.c writes the JSON, glb_writer.c the
 * GLB.
 */
#ifndef PHONGSPLAT_EXPORT_SPLAT_ATTRIBUTES_H
#define PHONGSPLAT_EXPORT_SPLAT_ATTRIBUTES_H

#include "export/khr_gaussians.h"
#include "splats/quantize.h"
#include "splats/splats.h"

#include <phongsplat/splat.h>

/* The component types of glTF 2.0 section 3.6.2.2. */
enum {
    PSPLAT_TYPE_BYTE = 5120,
    PSPLAT_TYPE_UNSIGNED_BYTE = 5121,
    PSPLAT_TYPE_SHORT = 5122,
    PSPLAT_TYPE_UNSIGNED_SHORT = 5123,
    PSPLAT_TYPE_FLOAT = 5126
};

/* The attributes, in the order in which a file lists them. */
typedef enum psplat_attribute_kind {
    PSPLAT_ATTRIBUTE_POSITION = 0,
    PSPLAT_ATTRIBUTE_NORMAL,
    PSPLAT_ATTRIBUTE_COLOR,
    PSPLAT_ATTRIBUTE_ROTATION,
    PSPLAT_ATTRIBUTE_TURN,
    PSPLAT_ATTRIBUTE_TILT,
    PSPLAT_ATTRIBUTE_SURFACE_TILT, /* TILT of fields that are those of curved surfaces: the steps */
    PSPLAT_ATTRIBUTE_SCALE,
    PSPLAT_ATTRIBUTE_FIELD,
    PSPLAT_ATTRIBUTE_SURFACE_FIELD, /* and NORMAL_FIELD; finer, because they move the surface */
    PSPLAT_ATTRIBUTE_SHAPE,
    PSPLAT_ATTRIBUTE_LINE,
    PSPLAT_ATTRIBUTE_COLOR_U = PSPLAT_ATTRIBUTE_LINE + PSPLAT_MAX_CLIP_LINES,
    PSPLAT_ATTRIBUTE_COLOR_V,
    PSPLAT_ATTRIBUTE_ORM,
    PSPLAT_ATTRIBUTE_EMISSIVE,
    PSPLAT_ATTRIBUTE_TEXCOORD,
    PSPLAT_ATTRIBUTE_TEXCOORD_U,
    PSPLAT_ATTRIBUTE_TEXCOORD_V,
    PSPLAT_ATTRIBUTE_TEXCOORD_UU,
    PSPLAT_ATTRIBUTE_TEXCOORD_UV,
    PSPLAT_ATTRIBUTE_TEXCOORD_VV,
    PSPLAT_ATTRIBUTE_GAUSSIAN_ROTATION, /* this and the next belong to KHR_gaussian_splatting */
    PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE,
    PSPLAT_ATTRIBUTE_OPACITY,
    PSPLAT_ATTRIBUTE_HARMONIC,
    PSPLAT_ATTRIBUTE_KINDS
} psplat_attribute_kind;

/* The component type and number of components in which an attribute is stored. */
typedef struct psplat_attribute_format {
    int type;          /* PSPLAT_TYPE_... */
    size_t components; /* 0 if the attribute is not stored */
} psplat_attribute_format;

/* The names of the attributes in a glTF file. */
extern const char *const psplat_attribute_names[PSPLAT_ATTRIBUTE_KINDS];

/* Appends the low bytes of value in little-endian order and returns the end of them. */
static inline uint8_t *psplat_put_integer(uint8_t *out, uint32_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

/* Returns the bytes of an element, a multiple of four, since glTF aligns elements to four bytes. */
size_t psplat_attribute_bytes(const psplat_attribute_format *format);
/* Returns 1 for CLIP_0 to CLIP_3. */
static inline int psplat_attribute_is_clip_line(size_t kind) {
    return kind >= PSPLAT_ATTRIBUTE_LINE && kind < PSPLAT_ATTRIBUTE_COLOR_U;
}

/* Returns whether the accessor of an attribute has "normalized": integers that stand for fractions
 * of a range. */
int psplat_attribute_is_normalized(const psplat_attribute_format *format, size_t kind);

/* The splats of one mesh with the integers and formats in which they are written. */
typedef struct psplat_attribute_table {
    const psplat_splats *splats;
    psplat_quantized_splat *codes;     /* one for each splat; NULL if floats are written */
    const psplat_gaussian *gaussians;  /* one for each splat, or NULL; the caller owns them */
    int32_t low[3];                    /* least position, steps; positions are relative to it */
    int32_t least_scale, scale_factor; /* (scale - least_scale) * scale_factor is written */
    psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS]; /* wide enough for every splat */
    float color_range; /* largest magnitude of a component of COLOR_U and COLOR_V */
} psplat_attribute_table;

/* Quantizes the splats (unless their precision is 0, which means floats) and chooses the smallest
 * format for each attribute. The splats must outlive the table. The caller frees the table with
 * psplat_attribute_table_free, also after an error. Errors: RANGE if an attribute needs more steps
 * than 16 bits count; MEMORY. */
psplat_result psplat_attribute_table_fill(const psplat_splats *splats,
                                          psplat_attribute_table *table, psplat_error *error);
/* Adds the attributes of KHR_gaussian_splatting. gaussians has one element for each splat and must
 * outlive the table. */
void psplat_attribute_table_add_gaussians(psplat_attribute_table *table,
                                          const psplat_gaussian *gaussians);
void psplat_attribute_table_free(psplat_attribute_table *table);

/* Finds the formats that the splats first to first + count - 1 need in a primitive with the clip
 * lines, the kind of surface and the texture coordinates of a run: attributes that have their
 * default value in all of them get no components, and lines that are all straight none for their
 * bend. */
void psplat_attribute_table_formats(const psplat_attribute_table *table, size_t first, size_t count,
                                    const psplat_run *like,
                                    psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS]);
/* Finds the least and the greatest POSITION of these splats as they are written. */
void psplat_attribute_table_extent(const psplat_attribute_table *table, size_t first, size_t count,
                                   float low[3], float high[3]);
/* Writes the element of one splat; format may have fewer components than that of the table. */
void psplat_attribute_table_put(const psplat_attribute_table *table, size_t kind,
                                const psplat_attribute_format *format, size_t index, uint8_t *out);
/* Writes the NORMAL of one splat as input of the octahedral filter of EXT_meshopt_compression. */
void psplat_attribute_table_put_octahedral(const psplat_attribute_table *table, size_t index,
                                           uint8_t *out);

/* Returns whether the TEXCOORD_0 of the splats is on a grid, as that filter wants it. */
static inline int psplat_attribute_table_has_texcoord_grid(const psplat_attribute_table *table) {
    return table->codes && table->splats->texcoords && table->splats->precision.texcoord_step > 0;
}
/* Writes the TEXCOORD_0 of one splat as input of the exponential filter of EXT_meshopt_compression.
 */
void psplat_attribute_table_put_exponential(const psplat_attribute_table *table, size_t index,
                                            uint8_t *out);

/* The ranges that the integers of attributes stand for, as the extension object has them (spec
 * 3.9). */
typedef struct psplat_quantization_ranges {
    float turn, tilt, surface_tilt, field, shape, scale[2], clip[2], bend, color;
    float texcoord, texcoord_bend;
} psplat_quantization_ranges;
void psplat_attribute_table_ranges(const psplat_attribute_table *table,
                                   psplat_quantization_ranges *ranges);

#endif
