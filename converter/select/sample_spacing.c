/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sample_spacing.c - the choice of the sample spacing, as fine as the limits make splats small.
 *
 * Flat and straight surfaces make large splats, which need no more samples each than small ones do.
 * How large splats become is not known before, so some are grown on the coarsest samples as a
 * trial. fill_holes.c later finds the holes that samples miss.
 */
#include "select/sample_spacing.h"

#include "features/samples.h"
#include "fit/fit_context.h"
#include "select/conversion.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* All of these were chosen by hand. */
/* The coarsest spacing as a multiple of the finest, which is made for flat splats on round
 * surfaces, and that where all are flat. The number of samples that splats are to cover on average.
 */
static const double coarsest_spacing_factor = 10, planar_spacing_factor = 3;
static const double samples_per_splat = 60;
/* How far splats reach beyond the samples that they cover, in spacings. So only few holes are left
 * between samples, which fill_holes.c closes. */
static const double margin_spacings = 0.2;

static psplat_result draw(psplat_conversion *c, double spacing, psplat_error *error) {
    psplat_samples_free(&c->samples);
    c->limits.margin = margin_spacings * spacing;
    return psplat_samples_draw(&c->surface, spacing, c->desc->seed, &c->samples, error);
}

/* Finds how many samples a splat covers, on average over splats. The seeds are samples, so a splat
 * is met in proportion to what it covers. The harmonic mean over the seeds corrects for that. */
static psplat_result mean_covered(const psplat_conversion *c, double *covered) {
    psplat_selection trials = {0};
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result = psplat_selection_grow_trials(&context, &trials);
    double inverse = 0;
    for (size_t i = 0; i < trials.count; ++i)
        inverse += 1 / ((double)trials.candidates[i].covered_count * (double)trials.count);
    *covered = inverse > 0 ? 1 / inverse : 0;
    psplat_selection_free(&trials);
    return result;
}

psplat_result psplat_draw_samples_for_limits(psplat_conversion *c, psplat_error *error) {
    double covered;
    double coarse =
        (c->limits.planar ? planar_spacing_factor : coarsest_spacing_factor) * c->finest;
    psplat_result result = draw(c, coarse, error);
    if (result) return result;
    if (mean_covered(c, &covered))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while sampling");
    double part = sqrt(covered / samples_per_splat);
    return part < 1 ? draw(c, fmax(part * coarse, c->finest), error) : PSPLAT_OK;
}
