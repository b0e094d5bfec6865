/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * observations.h - what a verification measured at each splat and each sample, for those who write
 * splats in parts and owe each part errors of its own.
 */
#ifndef PHONGSPLAT_VERIFY_OBSERVATIONS_H
#define PHONGSPLAT_VERIFY_OBSERVATIONS_H

#include <stddef.h>

/* Zero-initialise. Positions are in the mesh's centred coordinates, lengths in its units. */
typedef struct psplat_observations {
    double *bounds; /* splat_count: no point of the splat is farther from the surface; proven */
    size_t splat_count;
    double *points;  /* sample_count x 3, on the surface */
    double *degrees; /* sample_count: angles from the blended normals to the surface's; negative
                        where no splat shows */
    size_t sample_count;
    double *open;   /* open_count x 3: points of the surface that no splat covers */
    double *widths; /* open_count: their distances from the nearest splat */
    size_t open_count;
} psplat_observations;

/* Frees what the observations hold, and zeroes them. */
void psplat_observations_free(psplat_observations *observations);

/* Makes room for so many splats, samples and open points. The counts of splats and samples are set,
 * that of open points is 0. Returns 0 when out of memory. */
int psplat_observations_allocate(psplat_observations *observations, size_t splats, size_t samples,
                                 size_t open);

/* Appends an open point, for which there is room. */
void psplat_observations_open(psplat_observations *observations, const double point[3],
                              double width);

#endif
