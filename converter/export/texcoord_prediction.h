/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_prediction.h - what the texture coordinates of a splat say about those of the next one
 * in a stream (spec 3.12).
 */
#ifndef PHONGSPLAT_EXPORT_TEXCOORD_PREDICTION_H
#define PHONGSPLAT_EXPORT_TEXCOORD_PREDICTION_H

#include "export/splat_attributes.h"

/* Texture coordinates over the plane of a splat, as a reader of a stream computes with them. */
typedef struct psplat_texcoord_field {
    double center[3];                /* units of POSITION */
    double axes[3][3];               /* U, V and N */
    double radius[2];                /* units of POSITION */
    double along[2][2], bends[3][2]; /* the change with u and v, and with uu, uv and vv */
} psplat_texcoord_field;

/* The steps that a stream states, as its floats. */
typedef struct psplat_texcoord_steps {
    double at, along, bend, radius_step, first_radius;
    uint32_t low_bits; /* of positions */
} psplat_texcoord_steps;

/* Finds the field of a splat of a table on a grid. */
void psplat_texcoord_field_make(const psplat_attribute_table *table, size_t index,
                                const psplat_texcoord_steps *steps, psplat_texcoord_field *field);

/* Predicts along of a field, of which all else is known, from another one. */
void psplat_texcoord_predict_slopes(const psplat_texcoord_field *from,
                                    const psplat_texcoord_field *to, double along[2][2]);

/* Predicts how far the coordinates at the centre of a field differ from those at another's. */
void psplat_texcoord_predict_move(const psplat_texcoord_field *from,
                                  const psplat_texcoord_field *to, double move[2]);

/* Rounds a prediction in steps, of at most `most`, which it is limited to. *is_safe becomes 0 where
 * the last bits of a reader's arithmetic might decide to which side. */
int32_t psplat_texcoord_round(double prediction, int32_t most, int *is_safe);

#endif
