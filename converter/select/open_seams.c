/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * open_seams.c - clip lines along borders of charts become seams.
 *
 * A splat has one polynomial of texture coordinates, so that it is grown within a chart and ends at
 * its border. But the surface goes on there. As normals of splats that end at a line do not blend
 * with those beyond, shading jumps along every border, and where two splats do not quite meet there
 * is a crack. A seam bounds the texture alone: the splat goes on, and its normals blend with those
 * beyond. What goes on has to keep the limits as all of a splat does: it is near the surface, it
 * meets no crease, and its normals are about those of the surface.
 */
#include "select/open_seams.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/open_charts.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/crease_segments.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "select/selection.h"

#include <math.h>
#include <string.h>

/* How far a line that cuts may reach over its crease, in tolerances: close_seams.c moves it by up
 * to 0.8, and the fit leaves the rest. A crease so near to such a line is not met. Chosen by hand.
 */
static const double line_reach_tolerances = 1;
/* How far off normals may be beyond a seam, as a root mean square weighted by the kernel: this
 * angle (its square, of the chord between unit vectors) of 14 degrees. Chosen by hand. */
static const double greatest_normal_square = 0.06;

/* ---- what goes on beyond a seam -------------------------------------------------------------- */

/* Returns a region whose lines in a set of bits are seams and whose other lines cut. */
static psplat_region with_seams(const psplat_region *region, unsigned seams) {
    psplat_region split = *region;
    split.line_count = split.seam_count = 0;
    for (unsigned is_seam = 0; is_seam < 2; ++is_seam)
        for (uint32_t i = 0; i < region->line_count; ++i) {
            if ((seams >> i & 1) != is_seam) continue;
            uint32_t to = split.line_count + split.seam_count;
            memcpy(split.lines[to], region->lines[i], sizeof split.lines[to]);
            split.bends[to] = region->bends[i];
            split.line_count += !is_seam;
            split.seam_count += is_seam;
        }
    return split;
}

/* Returns whether a crease lies in a region, other than beside a line that cuts. The scratch holds
 * the surroundings. */
static int meets_crease(const psplat_fit_context *context, const psplat_region *region) {
    const psplat_neighborhood *near = &context->scratch->near;
    double tolerance = context->limits->tolerance;
    psplat_region narrow = *region;
    for (uint32_t i = 0; i < narrow.line_count; ++i)
        narrow.lines[i][2] -= line_reach_tolerances * tolerance *
                              norm2(region->lines[i][0] / region->radius[0],
                                    region->lines[i][1] / region->radius[1]);
    return psplat_segments_find(context->surface, near->creases, near->crease_count, &narrow,
                                2 * tolerance, context->scratch->segments) > 0;
}

/* Returns the squared difference of the unit normals of a candidate at (u, v) and of a sample. */
static double normal_square(const psplat_candidate *candidate, const double uv[2],
                            const double n[3]) {
    const double *f = candidate->field;
    double own[3], ratio = candidate->region.radius[1] / candidate->region.radius[0];
    memcpy(own, candidate->region.n, sizeof own);
    mad3(own, f[0] + f[2] * uv[0] + f[4] * ratio * uv[1], candidate->region.u);
    mad3(own, f[1] + f[4] * uv[0] + f[3] * uv[1], candidate->region.v);
    normalize3(own);
    return distance2_3(own, n);
}

/* Returns whether normals beyond the seams of a region are about those of the surface. Samples that
 * it does not cover, although they are beneath it, count as if they were wholly off. */
static int has_normals(const psplat_fit_context *context, const psplat_candidate *candidate,
                       const psplat_region *region, size_t covered) {
    const psplat_scratch *s = context->scratch;
    double sum = 0, weights = 0;
    for (size_t i = 0, next = 0; i < s->near_count; ++i) {
        int is_covered = next < covered && s->covered[next] == i;
        const double *uvh = s->uvh[i];
        next += (size_t)is_covered;
        if (!psplat_region_contains(region, uvh, 1, 0) ||
            !psplat_region_is_beyond_seam(region, uvh) ||
            fabs(uvh[2]) > 2 * context->limits->tolerance)
            continue;
        if (!is_covered && dot3(s->near.samples[i].n, region->n) <= 0) continue;
        double weight = exp(-4 * (uvh[0] * uvh[0] + uvh[1] * uvh[1]));
        sum += weight * (is_covered ? normal_square(candidate, uvh, s->near.samples[i].n) : 1);
        weights += weight;
    }
    return sum <= greatest_normal_square * weights;
}

/* ---- candidates ------------------------------------------------------------------------------ */

/* Returns whether a region with seams may take the place of a candidate's. */
static psplat_result try_seams(const psplat_fit_context *context, psplat_site *site,
                               const psplat_candidate *candidate, const psplat_region *region,
                               int *is_kept) {
    const psplat_demands demands = {.skip = PSPLAT_SKIP_LINES | PSPLAT_SKIP_COLORS |
                                            PSPLAT_SKIP_NORMALS};
    *is_kept = 0;
    double reach = psplat_region_reach(region) + context->limits->tolerance;
    if (psplat_site_gather(context, site, reach)) return PSPLAT_ERROR_MEMORY;
    if (meets_crease(context, region)) return PSPLAT_OK;
    psplat_evaluation e = psplat_evaluate(context, site, region, &demands);
    if (e.status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    *is_kept = e.status == PSPLAT_FIT_KEPT && has_normals(context, candidate, region, e.count);
    return PSPLAT_OK;
}

static int bit_count(unsigned bits) {
    int count = 0;
    for (; bits; bits &= bits - 1) ++count;
    return count;
}

/* Opens as many lines of a candidate as may be seams. */
static psplat_result open_candidate(const psplat_fit_context *context, size_t index, void *user) {
    psplat_candidate *candidate = (psplat_candidate *)user + index;
    uint32_t lines = candidate->region.line_count;
    const psplat_kept_textures *kept =
        psplat_surface_kept_textures(context->surface, candidate->triangle);
    if (!candidate->taken || !lines) return PSPLAT_OK;
    /* Where normals are those of a texture, they end with it. */
    if (!kept || kept->textures[PSPLAT_TEXTURE_NORMAL].image) return PSPLAT_OK;
    psplat_site site = psplat_site_of(&candidate->region, candidate->triangle);
    for (int count = (int)lines; count > 0; --count)
        for (unsigned seams = 1; seams < 1u << lines; ++seams) {
            if (bit_count(seams) != count) continue;
            psplat_region region = with_seams(&candidate->region, seams);
            int is_kept;
            psplat_result result = try_seams(context, &site, candidate, &region, &is_kept);
            if (result) return result;
            if (!is_kept) continue;
            candidate->region = region;
            return PSPLAT_OK;
        }
    return PSPLAT_OK;
}

psplat_result psplat_open_seams(const psplat_fit_context *context, psplat_selection *selection) {
    if (!context->surface->chart_border_edges) return PSPLAT_OK;
    psplat_open_charts open;
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (psplat_open_charts_create(context->surface, context->samples, &open)) {
        psplat_fit_context opened = *context;
        opened.surface = &open.surface;
        opened.samples = &open.samples;
        result = psplat_fit_each(&opened, selection->count, open_candidate, selection->candidates);
    }
    psplat_open_charts_free(&open);
    return result;
}
