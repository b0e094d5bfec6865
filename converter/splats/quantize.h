/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize.h - rounding of splats to the integers that files hold, and back (spec 3.9).
 */
#ifndef PHONGSPLAT_SPLATS_QUANTIZE_H
#define PHONGSPLAT_SPLATS_QUANTIZE_H

#include <phongsplat/splat.h>

#include "splats/splats.h"

#include <stdint.h>

/* Rounds all splats to splats->precision, to what a reader of the file gets. Does nothing where the
 * precision is that of floats. */
void psplat_round_to_precision(psplat_splats *splats);

/* Finds B1 and B2 of spec eq. (0), from which the turn about a unit normal is measured. */
void psplat_turn_basis(const double normal[3], double b1[3], double b2[3]);

/* Finds the axes U, V and N of an octahedral code and of the turn on the grid that brings U nearest
 * to the unit vector u or to its opposite. */
void psplat_quantized_axes(const psplat_precision *precision, const int32_t normal[2],
                           const double u[3], double axes[3][3]);

/* Rounds a clip line as psplat_quantize_splat does, for a region whose axes are on the grid. The
 * rounded line cuts nothing off that the line keeps. */
void psplat_quantize_line(const psplat_precision *precision, double line[3]);

/* Rounds a normal field (x, y, alpha, beta, gamma) as psplat_quantize_splat does, for a region
 * whose axes are on the grid. */
void psplat_quantize_field(const psplat_precision *precision, double field[5]);

/* A splat as integers, each a multiple of a step of psplat_precision. */
typedef struct psplat_quantized_splat {
    int32_t position[3];
    int32_t normal[2]; /* the octahedral code of N, not in steps */
    int32_t turn;
    int32_t tilt[2];
    int32_t scale[2]; /* of the logarithm of radius over unit */
    int32_t field[3];
    int32_t lines[PSPLAT_MAX_CLIP_LINES][2]; /* turn and distance */
    int flipped;                             /* 1: U and V point against those of the splat */
} psplat_quantized_splat;

/* Rounds a splat to the nearest integers. Clip lines are rounded outwards: they cut nothing off
 * that the splat keeps. */
void psplat_quantize_splat(const psplat_precision *precision, const psplat_splat *splat,
                           psplat_quantized_splat *code);

/* Makes of the integers what a reader does, up to its own rounding, in the mesh's units. The colour
 * of *splat stays as it is. splat->clip_count tells how many lines there are. */
void psplat_dequantize_splat(const psplat_precision *precision, const psplat_quantized_splat *code,
                             psplat_splat *splat);

#endif
