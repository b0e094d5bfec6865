/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate_texcoord.c - the check how far a texture slides over a region whose texture coordinates
 * are fitted to the samples in it.
 *
 * The samples are those that the region covers and those that lie a little beyond its rim, on the
 * same chart: coordinates that are interpolated at the rim do not fly off there. Those of curved
 * splats are of the second order: on a surface that bends coordinates mostly do, too, and of linear
 * ones up to twice as many splats are needed.
 */
#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/texcoord_fit.h"
#include "splats/splat_texcoord.h"

#include <math.h>

/* How far beyond the rim, in spacings, and beyond the tolerance from the surface samples count.
 * Chosen by hand. */
static const double rim_spacings = 0.75, greatest_height_tolerances = 1.5;

/* Returns whether the sample i of the neighbourhood, whose parameters are in the scratch, lies
 * within a length of the region. */
static int counts(const psplat_fit_context *context, const psplat_region *region, double beyond,
                  size_t i) {
    const psplat_scratch *s = context->scratch;
    const double *uvh = s->uvh[i];
    double squares = 0;
    for (int k = 0; k < 2; ++k) {
        double scaled = uvh[k] * region->radius[k] / (region->radius[k] + beyond);
        squares += scaled * scaled;
    }
    if (squares > 1 || fabs(uvh[2]) > greatest_height_tolerances * context->limits->tolerance)
        return 0;
    for (uint32_t line = 0; line < region->line_count; ++line)
        if (psplat_region_line_value(region, line, uvh) < -beyond / region->radius[1]) return 0;
    return dot3(s->near.samples[i].n, region->n) >= PSPLAT_LEAST_COVERED_COSINE;
}

static void add_sample(const psplat_fit_context *context, uint32_t sample, const double uv[2],
                       psplat_texcoord_sums *sums) {
    uint32_t triangle = context->samples->triangles[sample];
    psplat_texcoord_sums_add(sums, uv, context->samples->texcoords + 2 * (size_t)sample,
                             context->surface->texcoord_slopes + 6 * (size_t)triangle);
}

void psplat_evaluate_fit_texcoords(const psplat_fit_context *context, const psplat_region *region,
                                   const psplat_candidate *recorded, psplat_texcoord *fitted) {
    const psplat_scratch *s = context->scratch;
    double beyond = rim_spacings * context->samples->spacing, uvh[3];
    psplat_texcoord_sums sums = {.count = 0};
    for (size_t i = 0; recorded && i < recorded->covered_count; ++i) {
        uint32_t sample = recorded->covered[i];
        psplat_region_local(region, context->samples->positions + 3 * (size_t)sample, uvh);
        add_sample(context, sample, uvh, &sums);
    }
    for (size_t i = 0; i < s->near_count; ++i)
        if (counts(context, region, beyond, i) && !(recorded && counts(context, region, 0, i)))
            add_sample(context, s->near.samples[i].index, s->uvh[i], &sums);
    psplat_texcoord_sums_fit(&sums, region, psplat_region_is_curved(region), fitted);
}

psplat_fit_status psplat_evaluate_texcoords(const psplat_fit_context *context,
                                            const psplat_region *region) {
    const psplat_limits *limits = context->limits;
    const psplat_scratch *s = context->scratch;
    if (!context->samples->texcoords ||
        !(limits->texture_tolerance > 0 || limits->texture_tolerance_texels > 0))
        return PSPLAT_FIT_KEPT;
    uint32_t first = context->samples->triangles[s->near.samples[s->covered[0]].index];
    const psplat_kept_textures *kept = psplat_surface_kept_textures(context->surface, first);
    if (!kept) return PSPLAT_FIT_KEPT;
    psplat_texcoord fitted;
    psplat_evaluate_fit_texcoords(context, region, NULL, &fitted);
    for (size_t i = 0; i < s->near_count; ++i) {
        const float *given = context->samples->texcoords + 2 * (size_t)s->near.samples[i].index;
        double error[2];
        if (!counts(context, region, 0, i)) continue;
        psplat_texcoord_at(&fitted, s->uvh[i], error);
        for (int k = 0; k < 2; ++k) error[k] -= (double)given[k];
        psplat_slide slide = psplat_texcoord_slide(&fitted, region, s->uvh[i], kept->texels, error);
        if (!psplat_slide_is_kept(&slide, limits->texture_tolerance,
                                  limits->texture_tolerance_texels))
            return PSPLAT_FIT_TEXTURE_SLIDES;
    }
    return PSPLAT_FIT_KEPT;
}
