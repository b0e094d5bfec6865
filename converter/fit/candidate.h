/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.h - a possible splat with the samples that it covers.
 */
#ifndef PHONGSPLAT_FIT_CANDIDATE_H
#define PHONGSPLAT_FIT_CANDIDATE_H

#include <phongsplat/splat.h>

#include "base/region.h"

#include <stdint.h>

/* A possible splat and the samples that it covers. */
typedef struct psplat_candidate {
    psplat_region region;
    double field[5];  /* x, y, alpha, beta, gamma */
    double deviation; /* greatest distance from the plane to a covered sample, a length */
    float color[4];   /* set by psplat_fit_colors, as is the finish */
    psplat_finish finish;
    psplat_texcoord texcoord; /* set by psplat_fit_texcoords; 0 where no texture is kept */
    uint32_t triangle;        /* the triangle from which the candidate grew */
    uint32_t *covered;        /* sample indices, covered_count; the seed among them; owned */
    size_t covered_count;
    uint32_t needed;   /* 1 + the sample that it grew for when splats lay on the grid already, and
                        * that it must cover on the grid too, unless that is left to others
                        * (finish/trim_splats.c); 0: none */
    int taken;         /* 1: belongs to the selection; 0: is only in the pool */
    int ellipse_grown; /* 1 after psplat_grow_ellipse */
    int quantized;     /* 1 after psplat_quantize_candidate */
    int is_flat;       /* 1: has the depth tolerance of flat splats (finish/depth_tolerance.c) */
    int is_within_creases; /* 1: no crease lies too deep in its region, as finish/mend_creases.c has
                            * found; of use to nothing else */
    int failed_extensions; /* rays that it could not be extended to since it was extended last
                            * (finish/close_rays.c) */
} psplat_candidate;

/* Copies a candidate with what it owns. Returns 0 when out of memory; *to then owns nothing. */
int psplat_candidate_copy(const psplat_candidate *from, psplat_candidate *to);

/* Records that a candidate covers one more sample. Returns 0, and leaves it, when out of memory. */
int psplat_candidate_add_covered(psplat_candidate *candidate, uint32_t sample);

/* Frees what the candidate owns, and zeroes it. */
void psplat_candidate_free(psplat_candidate *candidate);

#endif
