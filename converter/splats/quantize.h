/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize.h - rounding of splats to the integers that files hold, and back (spec 3.9).
 */
#ifndef PHONGSPLAT_SPLATS_QUANTIZE_H
#define PHONGSPLAT_SPLATS_QUANTIZE_H

#include <phongsplat/splat.h>

#include "splats/splats.h"

#include <stdint.h>

/* The most often that steps are halved for splats that are smaller (spec 3.12). */
enum { PSPLAT_MOST_GRADE = 7 };

/* Rounds all splats with their texture coordinates to splats->precision, to what a reader of the
 * file gets. Does nothing where the
 * precision is that of floats. */
void psplat_round_to_precision(psplat_splats *splats);

/* Returns the steps of a splat of these radii, which are on the grid: all of them multiples of
 * those of a precision. normal_shift and line_shift become the low bits of codes of N and of lines
 * that are 0. */
psplat_precision psplat_precision_at(const psplat_precision *precision, const double radius[2]);

/* Finds B1 and B2 of spec eq. (0), from which the turn about a unit normal is measured. */
void psplat_turn_basis(const double normal[3], double b1[3], double b2[3]);

/* Finds the axes U, V and N of an octahedral code and of the turn on the grid that brings U nearest
 * to the unit vector u or to its opposite. */
void psplat_quantized_axes(const psplat_precision *precision, const int32_t normal[2],
                           const double u[3], double axes[3][3]);

/* Rounds a clip line and its bend as psplat_quantize_splat does, for a region whose axes are on the
 * grid, by the steps of its radii: precision is to be that of psplat_precision_at. The rounded line
 * cuts nothing off that the line keeps. It is straight where the step of bends is 0. */
void psplat_quantize_line(const psplat_precision *precision, double line[3], double *bend);

/* Rounds a normal field (x, y, alpha, beta, gamma) as psplat_quantize_splat does where it is not
 * that of a curved surface, for a region whose axes are on the grid. */
void psplat_quantize_field(const psplat_precision *precision, double field[5]);

/* Rounds the second derivatives A, B, C of a region's surface (base/region.h) as
 * psplat_quantize_splat does, for a region whose axes and radii are on the grid: what is rounded is
 * alpha = -A r_u, beta = -C r_v and gamma = -B r_u. They become 0 where the step of shapes is 0. */
void psplat_quantize_shape(const psplat_precision *precision, const double radius[2],
                           double hessian[3]);

/* Texture coordinates as integers, each a multiple of a step of psplat_precision. */
typedef struct psplat_quantized_texcoord {
    int32_t at[2]; /* 0 where the step of texture coordinates is 0: they stay floats */
    int32_t along[2][2];
    int32_t bends[3][2]; /* along uu, uv and vv */
} psplat_quantized_texcoord;

/* Rounds the texture coordinates of a splat to the nearest integers. flipped is that of the splat's
 * own integers: what is linear in u and v changes its sign with these axes. */
void psplat_quantize_texcoord(const psplat_precision *precision, const psplat_texcoord *texcoord,
                              int flipped, psplat_quantized_texcoord *code);

/* Makes of the integers what a reader does, up to its own rounding. Coordinates that stay floats
 * are left as they are. */
void psplat_dequantize_texcoord(const psplat_precision *precision,
                                const psplat_quantized_texcoord *code, psplat_texcoord *texcoord);

/* A splat as integers, each a multiple of a step of psplat_precision. */
typedef struct psplat_quantized_splat {
    int32_t position[3];
    int32_t normal[2]; /* the octahedral code of N, not in steps */
    int32_t turn;
    int32_t tilt[2];
    int32_t scale[2];      /* of the logarithm of radius over unit */
    int32_t field[3];      /* it and tilt are 0 where the field is that of a curved surface */
    int32_t shape_tilt[2]; /* the tilt of such a field */
    int32_t shape[3];      /* of curved surfaces */
    int32_t lines[PSPLAT_MAX_CLIP_LINES][3]; /* turn, distance and bend */
    psplat_quantized_texcoord texcoord;      /* set by psplat_quantize_texcoord, else 0 */
    int flipped;                             /* 1: U and V point against those of the splat */
} psplat_quantized_splat;

/* Rounds a splat of a run to the nearest integers that have the zeros at their end which its radii
 * ask for (spec 3.12): one number with others would cost all splats of the file their grades. Where
 * there are grades, the axes are to be on the grid of the radii already, as psplat_quantized_axes
 * makes them with psplat_precision_at: round splats have few turns, and lines do not turn back. The
 * run says what is stored of the splat's shape and bends. Clip lines are rounded outwards: they cut
 * nothing off that the splat keeps. */
void psplat_quantize_splat(const psplat_precision *precision, const psplat_run *run,
                           const psplat_splat *splat, psplat_quantized_splat *code);

/* Makes of the integers what a reader does, up to its own rounding, in the mesh's units. The colour
 * of *splat stays as it is. splat->clip_count tells how many lines there are. */
void psplat_dequantize_splat(const psplat_precision *precision, const psplat_run *run,
                             const psplat_quantized_splat *code, psplat_splat *splat);

#endif
