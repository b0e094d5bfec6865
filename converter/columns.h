/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * columns.h - the attributes of splats as bytes. For the writer of files: columns.c, layout.c,
 * document.c, glb.c, in this order.
 */
#ifndef PHONGSPLAT_COLUMNS_H
#define PHONGSPLAT_COLUMNS_H

#include "encoding.h"
#include "gaussian.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Component types of glTF 2.0 section 3.6.2.2. */
enum {
    PSPLAT_TYPE_BYTE = 5120,
    PSPLAT_TYPE_UNSIGNED_BYTE = 5121,
    PSPLAT_TYPE_SHORT = 5122,
    PSPLAT_TYPE_UNSIGNED_SHORT = 5123,
    PSPLAT_TYPE_FLOAT = 5126
};

/* Attributes in the order in which files have them. */
typedef enum psplat_column_kind {
    PSPLAT_COLUMN_POSITION = 0,
    PSPLAT_COLUMN_NORMAL,
    PSPLAT_COLUMN_COLOR,
    PSPLAT_COLUMN_ROTATION,
    PSPLAT_COLUMN_TURN,
    PSPLAT_COLUMN_TILT,
    PSPLAT_COLUMN_SCALE,
    PSPLAT_COLUMN_FIELD,
    PSPLAT_COLUMN_LINE,
    PSPLAT_COLUMN_COLOR_U = PSPLAT_COLUMN_LINE + PSPLAT_MAX_CLIP_LINES,
    PSPLAT_COLUMN_COLOR_V,
    PSPLAT_COLUMN_ORM,
    PSPLAT_COLUMN_EMISSIVE,
    PSPLAT_COLUMN_GAUSSIAN_ROTATION, /* of KHR_gaussian_splatting, as the rest */
    PSPLAT_COLUMN_GAUSSIAN_SCALE,
    PSPLAT_COLUMN_OPACITY,
    PSPLAT_COLUMN_HARMONIC,
    PSPLAT_COLUMNS
} psplat_column_kind;

/* How one attribute is stored. */
typedef struct psplat_column {
    int type;          /* component type */
    size_t components; /* 0: not at all */
} psplat_column;

extern const char *const psplat_column_names[PSPLAT_COLUMNS];

/* Bytes of an element, a multiple of four as glTF aligns them. */
size_t psplat_column_bytes(const psplat_column *column);
int psplat_column_is_normalized(const psplat_column *column, size_t kind);

/* The splats of a mesh, ready to be written. */
typedef struct psplat_sheet {
    const psplat_splats *splats;
    psplat_code *codes;                    /* of each; NULL: floats */
    const psplat_gaussian *gaussians;      /* of each; NULL: none */
    int32_t low[3];                        /* least position; what is written is relative to it */
    int32_t least_scale, scale_factor;     /* what is written is (scale - least) * factor */
    psplat_column columns[PSPLAT_COLUMNS]; /* of all splats together */
    float color_range;                     /* largest component of COLOR_U and COLOR_V */
} psplat_sheet;

/* Errors: RANGE, where steps are so small that 16 bits do not hold how many there are; MEMORY.
 * psplat_sheet_free also then. */
psplat_result psplat_sheet_fill(const psplat_splats *splats, psplat_sheet *sheet,
                                psplat_error *error);
/* Adds the columns of KHR_gaussian_splatting. gaussians: of each splat; they must outlive the
 * sheet.
 */
void psplat_sheet_add_gaussians(psplat_sheet *sheet, const psplat_gaussian *gaussians);
void psplat_sheet_free(psplat_sheet *sheet);

/* Of columns of the sheet those that count splats from first on need; with lines clip lines. */
void psplat_sheet_columns(const psplat_sheet *sheet, size_t first, size_t count, size_t lines,
                          psplat_column columns[PSPLAT_COLUMNS]);
/* The least and the greatest POSITION of these splats as written. */
void psplat_sheet_extent(const psplat_sheet *sheet, size_t first, size_t count, float low[3],
                         float high[3]);
/* Writes an element of a column, which may have fewer components than that of the sheet. */
void psplat_sheet_put(const psplat_sheet *sheet, size_t kind, const psplat_column *column,
                      size_t index, uint8_t *out);
/* The same of NORMAL as the octahedral filter of EXT_meshopt_compression has it before decoding. */
void psplat_sheet_put_octahedral(const psplat_sheet *sheet, size_t index, uint8_t *out);

/* What integers stand for, as the extension object says (spec 3.9). */
typedef struct psplat_ranges {
    float turn, tilt, field, scale[2], clip[2], color;
} psplat_ranges;
void psplat_sheet_ranges(const psplat_sheet *sheet, psplat_ranges *ranges);

#ifdef __cplusplus
}
#endif
#endif
