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
#include "finish/open_seams.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/open_charts.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/crease_segments.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "select/selection.h"
#include "splats/quantize.h"

#include <math.h>
#include <string.h>

/* How far a line of a fit may reach over what it stands at, a crease or a tangent edge, in
 * tolerances: close_seams.c moves it by up to 0.8 and 2, close_cracks.c by a little more, and the
 * fit leaves the rest. An edge so near to such a line is not met. Chosen by hand. */
static const double crease_reach_tolerances = 1, tangent_reach_tolerances = 2.5;
/* Where not all beyond a seam keeps the limits, the parts of the way to the rim that are tried, and
 * how far these reach at least, in tolerances: a jump of the shading is softened over that width.
 * Chosen by hand. */
enum { PARTS = 5 };
static const double parts[PARTS] = {0.6, 0.35, 0.2, 0.12, 0.07};
static const double least_reach_tolerances = 0.75;
/* How far off normals may be beyond a seam, as a root mean square weighted by the kernel: this
 * angle (its square, of the chord between unit vectors) of 14 degrees. Chosen by hand. */
static const double greatest_normal_square = 0.06;

/* ---- what goes on beyond a seam -------------------------------------------------------------- */

/* Returns a region of which a line that cuts has become a seam, where the line was fitted. */
static psplat_region with_seam(const psplat_region *region, const psplat_region *fitted,
                               uint32_t line) {
    psplat_region opened = *region;
    uint32_t last = region->line_count + region->seam_count - 1;
    for (uint32_t i = line; i <= last; ++i) {
        const psplat_region *of = i < last ? region : fitted;
        uint32_t from = i < last ? i + 1 : line;
        memcpy(opened.lines[i], of->lines[from], sizeof opened.lines[i]);
        opened.bends[i] = of->bends[from];
    }
    --opened.line_count;
    ++opened.seam_count;
    return opened;
}

/* Returns by how much the value of a line at most changes for each unit of length. */
static double line_rate(const psplat_region *region, uint32_t line) {
    const double *l = region->lines[line];
    return norm2(l[0] / region->radius[0], l[1] / region->radius[1]);
}

/* Gives a region that has room for it another line that cuts, beside its last seam, which keeps so
 * much more (in units of the line's value). */
static void cut_beyond(const psplat_limits *limits, double beyond, psplat_region *region) {
    uint32_t last = region->line_count + region->seam_count - 1;
    const double *seam = region->lines[last];
    double line[3] = {seam[0], seam[1], seam[2] + beyond}, bend = region->bends[last];
    if (limits->precision) {
        const psplat_precision at = psplat_precision_at(limits->precision, region->radius);
        psplat_quantize_line(&at, line, &bend);
    }
    psplat_region_add_line(region, line, bend);
}

/* Returns whether an edge that bounds patches, of creases or of tangent edges, lies in a region,
 * other than beside the first lines, cut_count of them, which stand at such edges. The scratch
 * holds the surroundings. */
static int meets_edge(const psplat_fit_context *context, const psplat_region *region,
                      uint32_t cut_count, int is_tangent) {
    const psplat_neighborhood *near = &context->scratch->near;
    const psplat_segment *segments = context->scratch->segments;
    double tolerance = context->limits->tolerance;
    double reach = (is_tangent ? tangent_reach_tolerances : crease_reach_tolerances) * tolerance;
    psplat_region narrow = *region;
    for (uint32_t i = 0; i < cut_count; ++i) narrow.lines[i][2] -= reach * line_rate(region, i);
    size_t count = psplat_segments_find_near(context->surface, near, &narrow, 2 * tolerance,
                                             context->scratch->segments);
    for (size_t i = 0; i < count; ++i)
        if (segments[i].is_tangent == is_tangent) return 1;
    return 0;
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

/* Returns whether normals beyond the seams of a region are about those of the surface. Samples
 * farther from it than the tolerance count as if its normals were wholly off. */
static int has_normals(const psplat_fit_context *context, const psplat_kernel *kernel,
                       const psplat_candidate *candidate, const psplat_region *region) {
    const psplat_scratch *s = context->scratch;
    double sum = 0, weights = 0, tolerance = context->limits->tolerance;
    for (size_t i = 0; i < s->near_count; ++i) {
        const double *uvh = s->uvh[i], *n = s->near.samples[i].n;
        if (!psplat_region_contains(region, uvh, 1, 0) ||
            !psplat_region_is_beyond_seam(region, uvh) || fabs(uvh[2]) > 2 * tolerance ||
            dot3(n, region->n) <= 0)
            continue;
        double falloff = pow(norm2(uvh[0], uvh[1]), (double)kernel->exponent);
        double weight = exp(-(double)kernel->sharpness * falloff);
        sum += weight * (fabs(uvh[2]) <= tolerance ? normal_square(candidate, uvh, n) : 1);
        weights += weight;
    }
    return sum <= greatest_normal_square * weights;
}

/* Returns the greatest distance of a region from the samples beneath it, which the scratch holds.
 */
static double greatest_deviation(const psplat_fit_context *context, const psplat_region *region) {
    const psplat_scratch *s = context->scratch;
    double greatest = 0;
    for (size_t i = 0; i < s->near_count; ++i) {
        double height = fabs(s->uvh[i][2]);
        if (height <= context->limits->tolerance && psplat_region_contains(region, s->uvh[i], 1, 0))
            greatest = max2(greatest, height);
    }
    return greatest;
}

/* ---- candidates ------------------------------------------------------------------------------ */

/* A candidate whose lines are opened. */
typedef struct opener {
    const psplat_kernel *kernel;
    const psplat_candidate *candidate;
    const psplat_region *fitted; /* the candidate's, before its lines were moved out */
    psplat_site site;
    double deviation; /* greatest of the regions that may take its place, as in psplat_candidate */
} opener;

/* Finds whether a region with seams may take the place of the candidate's. */
static psplat_result try_seams(const psplat_fit_context *context, opener *o,
                               const psplat_region *region, int *is_kept) {
    const psplat_demands demands = {.skip = PSPLAT_SKIP_LINES | PSPLAT_SKIP_COLORS |
                                            PSPLAT_SKIP_NORMALS};
    *is_kept = 0;
    double reach = psplat_region_reach(region) + context->limits->tolerance;
    if (psplat_site_gather(context, &o->site, reach)) return PSPLAT_ERROR_MEMORY;
    /* Those that have not become seams are still the first ones. */
    uint32_t cut_count = o->candidate->region.line_count - region->seam_count;
    if (meets_edge(context, region, cut_count, 0) || meets_edge(context, region, cut_count, 1))
        return PSPLAT_OK;
    psplat_evaluation e = psplat_evaluate(context, &o->site, region, &demands);
    if (e.status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    *is_kept = e.status == PSPLAT_FIT_KEPT && has_normals(context, o->kernel, o->candidate, region);
    if (*is_kept) o->deviation = max2(o->deviation, greatest_deviation(context, region));
    return PSPLAT_OK;
}

/* Makes a seam of a line of a region, with all that lies beyond it, or else as much of that as
 * another line leaves. Stores the region if it may take the place of the candidate's. */
static psplat_result open_line(const psplat_fit_context *context, opener *o, uint32_t line,
                               psplat_region *region) {
    const psplat_region whole = with_seam(region, o->fitted, line);
    /* What is cut off lies beyond where the line was moved to. */
    double all = 1 - region->lines[line][2];
    double moved = region->lines[line][2] - o->fitted->lines[line][2];
    double least = least_reach_tolerances * context->limits->tolerance * line_rate(region, line);
    int is_kept, has_room = whole.line_count + whole.seam_count < PSPLAT_MAX_CLIP_LINES;
    psplat_result result = try_seams(context, o, &whole, &is_kept);
    if (!result && is_kept) *region = whole;
    for (int i = 0; !result && !is_kept && has_room && i < PARTS; ++i) {
        psplat_region part = whole;
        if (parts[i] * all < least) break;
        cut_beyond(context->limits, moved + parts[i] * all, &part);
        result = try_seams(context, o, &part, &is_kept);
        if (!result && is_kept) *region = part;
    }
    return result;
}

/* What the threads need. */
typedef struct opening {
    psplat_selection *selection;
    const psplat_region *fitted; /* as in opener, of each candidate */
    const psplat_kernel *kernel;
} opening;

/* Opens as many lines of a candidate as may be seams. */
static psplat_result open_candidate(const psplat_fit_context *context, size_t index, void *user) {
    const opening *all = user;
    psplat_candidate *candidate = &all->selection->candidates[index];
    psplat_region region = candidate->region;
    const psplat_kept_textures *kept =
        psplat_surface_kept_textures(context->surface, candidate->triangle);
    psplat_result result = PSPLAT_OK;
    region.chart_lines = 0; /* Lines change their places, and nothing beyond them is wanted now. */
    if (!candidate->taken || !region.line_count) return PSPLAT_OK;
    /* Where normals are those of a texture, they end with it. */
    if (!kept || kept->textures[PSPLAT_TEXTURE_NORMAL].image) return PSPLAT_OK;
    opener o = {.kernel = all->kernel,
                .candidate = candidate,
                .fitted = &all->fitted[index],
                .deviation = candidate->deviation,
                .site = psplat_site_of(&region, candidate->triangle)};
    for (uint32_t line = region.line_count; line-- > 0 && !result;)
        result = open_line(context, &o, line, &region);
    if (result || !region.seam_count) return result;
    candidate->region = region;
    candidate->deviation = o.deviation;
    return result;
}

psplat_result psplat_open_seams(const psplat_fit_context *context, const psplat_kernel *kernel,
                                const psplat_region *fitted, psplat_selection *selection) {
    if (!context->surface->chart_border_edges) return PSPLAT_OK;
    psplat_open_charts open;
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (psplat_open_charts_create(context->surface, context->samples, &open)) {
        psplat_fit_context opened = *context;
        opened.surface = &open.surface;
        opened.samples = &open.samples;
        opening all = {selection, fitted, kernel};
        result = psplat_fit_each(&opened, selection->count, open_candidate, &all);
    }
    psplat_open_charts_free(&open);
    return result;
}
