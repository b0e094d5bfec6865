/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * samples.h - oriented sample points of a surface: blue noise or uniform random.
 */
#ifndef PHONGSPLAT_FEATURES_SAMPLES_H
#define PHONGSPLAT_FEATURES_SAMPLES_H

#include <phongsplat/splat.h>

#include "features/clusters.h"
#include "features/surface.h"

#include <stdint.h>

/* Oriented points of a surface with what is baked at them. Those that were drawn as blue noise are
 * sorted by clusters of triangles: those of cluster c are first[c] ... first[c + 1] - 1, in blocks
 * of PSPLAT_BLOCK_SAMPLES, first_block[c] ... first_block[c + 1] - 1, the last of which may be
 * smaller. Those that were appended since are listed for each cluster, the last one first. */
enum { PSPLAT_BLOCK_SAMPLES = 16 };
typedef struct psplat_samples {
    double *positions; /* count x 3 */
    float *normals;    /* count x 3, unit */
    /* The values of psplat_baked_point that vary over the surface; NULL where they do not: */
    float *colors;       /* count x 4 */
    float *turned;       /* count x 3, unit: normals turned by normal maps */
    float *finishes;     /* count x 3 */
    float *emissive;     /* count x 3 */
    float *texcoords;    /* count x 2: in the set that is kept (appearance.h); NULL: none is */
    uint32_t *triangles; /* count */
    size_t count;
    double spacing; /* about the distance of neighbours; 0 of uniform samples */
    /* Of blue noise alone: */
    psplat_clusters clusters;
    uint32_t *first, *first_block; /* clusters.count + 1 */
    psplat_sphere *blocks;         /* first_block[clusters.count]: spheres around blocks */
    uint32_t *last_appended;       /* clusters.count: an index, or PSPLAT_NONE */
    uint32_t *next_appended;       /* count - drawn: of the same cluster, or PSPLAT_NONE */
    size_t drawn;                  /* count before the first was appended */
} psplat_samples;

/* Draws blue-noise samples that are at least spacing apart, and along creases, for each side,
 * samples about half as far apart. Every patch gets at least one sample. Errors: PSPLAT_ERROR_RANGE
 * (more samples than 32 bits count), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_samples_draw(const psplat_surface *surface, double spacing, uint64_t seed,
                                  psplat_samples *samples, psplat_error *error);

/* Draws about count independent uniform samples, for measurements. A point set adds about as many
 * of its own points. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_samples_draw_uniform(const psplat_surface *surface, size_t count,
                                          uint64_t seed, psplat_samples *samples,
                                          psplat_error *error);

/* Drops the uniform samples that lie in the surface's apron. The others keep their order. */
void psplat_samples_drop_apron(psplat_samples *samples, const psplat_surface *surface);

/* Appends samples at points (count x 3) of triangles to blue noise. Samples that were there before
 * keep their indices. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_samples_append(psplat_samples *samples, const psplat_surface *surface,
                                    const double *points, const uint32_t *triangles, size_t count,
                                    psplat_error *error);

/* Removes the samples from index count on, which were appended. */
void psplat_samples_truncate(psplat_samples *samples, size_t count);

/* Returns some sample of the cluster of a triangle; PSPLAT_NONE where there is none. */
uint32_t psplat_samples_near_triangle(const psplat_samples *samples, uint32_t triangle);

void psplat_samples_free(psplat_samples *samples);

#endif
