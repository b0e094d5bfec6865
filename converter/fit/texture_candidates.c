/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_candidates.c - the texture coordinates of the candidates that are taken.
 */
#include "fit/texture_candidates.h"

#include "appearance/appearance.h"
#include "base/region.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/texcoord_fit.h"

#include <math.h>

/* Gives a candidate coordinates that change as on a triangle, from those at a point of it on. */
static void take_triangle(const psplat_surface *surface, uint32_t triangle, const double point[3],
                          psplat_candidate *c) {
    psplat_texcoord_sums sums = {.weight = 0};
    double barycentric[3], uvh[3];
    float texcoord[2];
    psplat_region_local(&c->region, point, uvh);
    psplat_surface_barycentric(surface, triangle, point, barycentric);
    psplat_surface_texcoord(surface, triangle, barycentric, texcoord);
    psplat_texcoord_sums_add(&sums, uvh, texcoord, surface->texcoord_slopes + 6 * (size_t)triangle);
    psplat_texcoord_sums_fit(&sums, &c->region, 0, &c->texcoord);
}

/* Moves coordinates by whole tiles, where that changes nothing, to the first tile. */
static void move_tiles(const psplat_kept_textures *kept, psplat_texcoord *texcoord) {
    for (int k = 0; k < 2; ++k) {
        float tile = (float)kept->repeats[k];
        if (tile > 0) texcoord->at[k] -= tile * floorf(texcoord->at[k] / tile);
    }
}

static psplat_result fit_candidate(const psplat_fit_context *context, size_t index, void *user) {
    psplat_candidate *c = (psplat_candidate *)user + index;
    const psplat_samples *samples = context->samples;
    const psplat_demands demands = {.skip = PSPLAT_SKIP_LINES | PSPLAT_SKIP_COLORS |
                                            PSPLAT_SKIP_NEARNESS | PSPLAT_SKIP_NORMALS};
    uint32_t sample = c->covered_count ? c->covered[0] : PSPLAT_NONE;
    uint32_t triangle = sample != PSPLAT_NONE ? samples->triangles[sample] : c->triangle;
    const psplat_kept_textures *kept = psplat_surface_kept_textures(context->surface, triangle);
    c->texcoord = (psplat_texcoord){.at = {0}};
    if (!c->taken || !kept) return PSPLAT_OK;
    /* Beyond a seam the texture is another chart's. */
    const psplat_region inside = psplat_region_inside_seams(&c->region);
    psplat_site site = psplat_site_of(&inside, c->triangle);
    psplat_evaluation evaluation = psplat_evaluate(context, &site, &inside, &demands);
    if (evaluation.status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    if (c->covered_count > 1)
        psplat_evaluate_fit_texcoords(context, &inside, c, &c->texcoord);
    else
        take_triangle(
            context->surface, triangle,
            sample != PSPLAT_NONE ? samples->positions + 3 * (size_t)sample : c->region.center, c);
    move_tiles(kept, &c->texcoord);
    return PSPLAT_OK;
}

psplat_result psplat_fit_texcoords(const psplat_fit_context *context, psplat_candidate *candidates,
                                   size_t count) {
    if (!context->samples->texcoords) return PSPLAT_OK;
    return psplat_fit_each(context, count, fit_candidate, candidates);
}
