/* SPDX-License-Identifier: MIT
 *
 * prefilter.h - the integrals of eq. (9) that do not depend on a pixel, on the CPU.
 */
#ifndef PHONGSPLAT_PREFILTER_H
#define PHONGSPLAT_PREFILTER_H

#include <phongsplat/phongsplat.h>

enum { PSPLAT_CUBE_LEVELS = 11 };

/* A cube map and its halves down to one texel a face: level k holds 6 (size >> k)^2 RGB values. */
typedef struct psplat_cube {
    int size, level_count;
    float *levels[PSPLAT_CUBE_LEVELS];
} psplat_cube;

/* Halves radiance (6 size size 3), sized to the next power of two below or equal, as far as it
 * goes. Errors: MEMORY. */
psplat_result psplat_cube_create(psplat_cube *cube, const psplat_allocator *allocator,
                                 const float *radiance, int size, psplat_error *error);
void psplat_cube_free(psplat_cube *cube, const psplat_allocator *allocator);

/* The direction of the point (x, y), 0 ... 1 each, of a face, of length 1. */
void psplat_cube_direction(int face, double x, double y, double direction[3]);

/* Irradiance on a surface with this normal: the first integral of (9). */
void psplat_cube_irradiance(const psplat_cube *cube, const double normal[3], float rgb[3]);

/* Radiance from a direction, at the resolution of a cube of this size. */
void psplat_cube_mirror(const psplat_cube *cube, const double direction[3], int size, float rgb[3]);

/* The mean radiance of (9) around the reflected direction, for alpha > 0. */
void psplat_cube_glossy(const psplat_cube *cube, const double direction[3], double alpha,
                        float rgb[3]);

/* a and b of (9). cosine: n.e > 0. */
void psplat_split_sum(double cosine, double alpha, float ab[2]);

#endif
