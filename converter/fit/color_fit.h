/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_fit.h - least-squares fits of colours and finishes to the samples that splats cover.
 */
#ifndef PHONGSPLAT_FIT_COLOR_FIT_H
#define PHONGSPLAT_FIT_COLOR_FIT_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "fit/candidate.h"

/* The moments of the parameters (u, v) of samples, from which all linear fits to them start. */
typedef struct psplat_moments {
    double count;
    double mean[2];   /* of u and v */
    double spread[3]; /* mean squares about the mean: uu uv vv */
    int gradients;    /* 0: fits are constant */
} psplat_moments;

/* Finds the moments of uv (count x 2). */
void psplat_moments_of(const double (*uv)[2], size_t count, int gradients, psplat_moments *moments);

/* Fits value(u, v) = fitted[0] + u fitted[1] + v fitted[2] to values of the samples by ridge
 * regression. mean is that of the values; along are the sums of the values times (u, v), which are
 * measured from their mean. */
void psplat_moments_solve(const psplat_moments *moments, double mean, const double along[2],
                          double fitted[3]);

/* Gives each taken one of count candidates the colours and finishes of the samples that it
 * covers. gradients: 1 lets colours change over a splat. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_fit_colors(const psplat_samples *samples, int gradients,
                                psplat_candidate *candidates, size_t count);

#endif
