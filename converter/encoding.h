/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * encoding.h - splats as the integers that files hold, and back (spec 3.9).
 *
 * Integers are small: a value is its code times a step, and what the largest code of its type
 * stands for goes into the extension object, so that compression finds the high bits constant.
 */
#ifndef PHONGSPLAT_ENCODING_H
#define PHONGSPLAT_ENCODING_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- octahedron.c -------------------------------------------------------------------------- */

/* Unit vectors as points of an octahedron (Cigolle et al. 2014), as meshoptimizer's filter has
 * them: x, y of so many bits, up to 8 of them decoded to bytes, more to shorts. */
#define PSPLAT_OCTAHEDRON_LEAST 4
#define PSPLAT_OCTAHEDRON_MOST 14

/* The x and y whose decoded vector is nearest to a unit vector. */
void psplat_octahedron_encode(const double normal[3], int bits, int32_t code[2]);
/* Whether these are inside, and every decoder makes the same bytes of them. */
int psplat_octahedron_is_code(const int32_t code[2], int bits);
/* Normalized integers of 8 or 16 bits. */
void psplat_octahedron_decode(const int32_t code[2], int bits, int32_t normal[3]);
/* Their direction, unit. */
void psplat_octahedron_normal(const int32_t code[2], int bits, double normal[3]);

/* ---- encoding.c ---------------------------------------------------------------------------- */

/* B1 and B2 of spec eq. (0). */
void psplat_turn_basis(const double normal[3], double b1[3], double b2[3]);

/* U, V and N of a normal on the grid, U nearest to the direction u or its opposite. */
void psplat_code_axes(const psplat_precision *precision, const int32_t normal[2], const double u[3],
                      double axes[3][3]);

/* A line of a region that has the axes of a code, and the field in them (x, y, alpha, beta, gamma),
 * as psplat_code_of rounds them. */
void psplat_code_line(const psplat_precision *precision, double line[3]);
void psplat_code_field(const psplat_precision *precision, double field[5]);

/* A splat as integers, each a multiple of a step of psplat_precision. */
typedef struct psplat_code {
    int32_t position[3];
    int32_t normal[2]; /* of octahedron.c */
    int32_t turn;
    int32_t tilt[2];
    int32_t scale[2]; /* of the logarithm of radius over unit */
    int32_t field[3];
    int32_t lines[PSPLAT_MAX_CLIP_LINES][2]; /* turn and distance */
    int flipped;                             /* axes are half a turn off those of the splat */
} psplat_code;

/* The nearest integers; of lines those that cut nothing off that the splat keeps. */
void psplat_code_of(const psplat_precision *precision, const psplat_splat *splat,
                    psplat_code *code);
/* What a reader makes of them, in the mesh's units, up to its roundings. The splat's colour stays.
 */
void psplat_code_decode(const psplat_precision *precision, const psplat_code *code,
                        psplat_splat *splat);

#ifdef __cplusplus
}
#endif
#endif
