/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * spacing.c - samples as dense as the splats to come are small.
 *
 * Flat and straight parts make large splats, which need no more samples than small ones do. How
 * large they become is not known before: some are grown on the coarsest samples. What samples miss,
 * repair.c finds.
 */
#include "stages.h"

#include <math.h>
#include <stdlib.h>

/* Coarsest spacing, in finest ones, and the samples that the mean splat is to cover. */
static const double coarsest = 3, samples_per_splat = 120;
/* Overlap of splats beyond the samples that they cover, in spacings: few holes remain between
 * samples, for repair.c to close. */
static const double margin_spacings = 0.2;
/* Splats grown to see how large they become. */
enum { SCOUTS = 128 };

static psplat_result draw(psplat_conversion *c, double spacing, psplat_error *error) {
    psplat_samples_free(&c->samples);
    c->limits.margin = margin_spacings * spacing;
    return psplat_samples_draw(&c->surface, spacing, c->desc->seed, &c->samples, error);
}

/* Samples that a splat covers, in the mean over splats: seeds that fall on samples meet each in
 * proportion to what it covers, so that the mean of the inverse counts is that of the splats. */
static psplat_result scout(const psplat_conversion *c, double *covered) {
    psplat_selection scouts = {0};
    uint32_t seeds[SCOUTS];
    size_t count = c->samples.count < SCOUTS ? c->samples.count : SCOUTS;
    for (size_t i = 0; i < count; ++i) seeds[i] = (uint32_t)(i * c->samples.count / count);
    psplat_result result =
        psplat_selection_grow(&c->surface, &c->samples, &c->limits, seeds, count, &scouts);
    double inverse = 0;
    for (size_t i = 0; i < scouts.count; ++i)
        inverse += 1 / ((double)scouts.candidates[i].covered_count * (double)count);
    *covered = inverse > 0 ? 1 / inverse : 0;
    psplat_selection_free(&scouts);
    return result;
}

psplat_result psplat_sample(psplat_conversion *c, psplat_error *error) {
    double covered, coarse = coarsest * c->finest;
    psplat_result result = draw(c, coarse, error);
    if (result) return result;
    if (scout(c, &covered))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while sampling");
    double part = sqrt(covered / samples_per_splat);
    return part < 1 ? draw(c, fmax(part * coarse, c->finest), error) : PSPLAT_OK;
}
