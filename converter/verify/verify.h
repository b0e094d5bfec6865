/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * verify.h - the verification of stored splats: errors against the surface, and promises kept.
 */
#ifndef PHONGSPLAT_VERIFY_VERIFY_H
#define PHONGSPLAT_VERIFY_VERIFY_H

#include <phongsplat/splat.h>

#include "features/surface.h"
#include "mesh/distance.h"
#include "splats/splats.h"
#include "verify/observations.h"
#include "verify/report.h"

#include <stdint.h>

/* What is verified, and against which tolerances. Owns nothing. */
typedef struct psplat_verification {
    const psplat_surface *surface;
    const psplat_splats *splats;
    const psplat_distance *distance; /* to the mesh */
    double tolerance_percent;
    double diagonal;                   /* the length that percentages are of */
    double normal_tolerance_degrees;   /* 0: none was promised */
    double texture_tolerance_texels;   /* 0: textures may slide by the tolerance of distances */
    double color_tolerance_percent;    /* 0: colours are not promised */
    uint64_t seed;                     /* of the samples; not that of the fitted ones */
    psplat_observations *observations; /* gets what is measured at each place; NULL: not wanted */
} psplat_verification;

/* Draws samples of the surface, measures the splats against them and the mesh, and fills the
 * errors, promises and places of report. The surface's apron is left out, but all of a splat must
 * be near the surface, also of that. The caller frees the observations. Errors: MEMORY, RANGE (too
 * many samples). */
psplat_result psplat_verify(const psplat_verification *verification, psplat_report *report,
                            psplat_error *error);

/* Returns what each point of the surface that is not open is within of a splat that reaches as near
 * to it, given the tolerance. That is more than the tolerance where a part of the surface was too
 * small to be divided further, of which nothing but the middle is known to be covered. */
double psplat_verified_cover(double tolerance);

/* Returns how far an open point is at most from the one that stands for it, given the tolerance. */
double psplat_verified_open_reach(double tolerance);

/* Returns what is proven of the distance between surface and splats, both ways, in the mesh's
 * units: each point of either is within it of the other. */
double psplat_verified_distance(const psplat_report *report);

#endif
