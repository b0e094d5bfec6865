/* SPDX-License-Identifier: MIT
 *
 * prefilter.h - prefiltering of environment maps on the CPU: the integrals of the split sum, eq.
 * (9), that do not depend on a pixel. The renderer stores them in textures (environment.c).
 */
#ifndef PHONGSPLAT_RENDERER_PREFILTER_H
#define PHONGSPLAT_RENDERER_PREFILTER_H

#include <phongsplat/phongsplat.h>

enum { PSPLAT_CUBE_LEVELS = 11 }; /* mipmap levels of the largest cube map, of 1024 texels */

/* A cube map with its mipmap levels down to one texel a face: level k holds 6 (size >> k)^2 RGB
 * values, laid out as psplat_environment_desc.radiance. */
typedef struct psplat_cube {
    int size, level_count;
    float *levels[PSPLAT_CUBE_LEVELS];
} psplat_cube;

/* Makes the levels of a cube map of 6 x size x size x 3 values; size is 1 ... 1024. Level 0 has the
 * greatest power of two that is at most size. The caller frees the cube. Errors: MEMORY. */
psplat_result psplat_cube_create(psplat_cube *cube, const psplat_allocator *allocator,
                                 const float *radiance, int size, psplat_error *error);

/* Frees the levels and sets the cube to zero. */
void psplat_cube_free(psplat_cube *cube, const psplat_allocator *allocator);

/* Finds the unit direction of the point (x, y), 0 ... 1 each, of a face. */
void psplat_cube_direction(int face, double x, double y, double direction[3]);

/* Computes the irradiance on a surface with this unit normal: the first integral of (9). */
void psplat_cube_irradiance(const psplat_cube *cube, const double normal[3], float rgb[3]);

/* Samples the radiance from a unit direction, at the resolution of a cube map of this size. */
void psplat_cube_mirror(const psplat_cube *cube, const double direction[3], int size, float rgb[3]);

/* Computes the mean radiance of (9) around the reflected unit direction, for alpha > 0. */
void psplat_cube_glossy(const psplat_cube *cube, const double direction[3], double alpha,
                        float rgb[3]);

/* Computes a and b of (9), where cosine is n.e > 0 and alpha > 0. */
void psplat_split_sum(double cosine, double alpha, float ab[2]);

#endif
