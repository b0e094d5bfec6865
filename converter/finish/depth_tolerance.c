/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * depth_tolerance.c - the choice of depth tolerances, and of the splats that are flat.
 *
 * The depth tolerance of what lies before decides how much farther along a ray other layers are
 * blended. A box is nearer than that to the plate on which it stands, at its foot, so that the
 * plate would eat notches into its corners. Where faces meet a fillet or a bore, blending does
 * good: either stands off there, and the mean of both is nearer to the truth than the one that
 * happens to lie before. So a splat of a plane face has a small depth tolerance where it is hardly
 * off its face, where only such splats lie beside it, or where another layer would show through it:
 * boxes hide the plate behind their corners, and labels what they lie on.
 */
#include "finish/depth_tolerance.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "measure/hidden_samples.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* All of these were chosen by hand. */
/* The least tolerance of depth, in tolerances. */
static const double least_tolerances = 0.25;
/* The share of the samples with a layer beneath from which on half the depth is better. */
static const double layered_share = 0.02, layered_part = 0.5;
/* Every how many samples are asked. */
enum { SAMPLE_STEP = 4 };
/* The deviations from the surface, in tolerances, below which a plane splat is flat whatever lies
 * beside it, and below which it may be: what the grid makes of a plane face is mostly half of that.
 */
static const double exact_tolerances = 0.02, level_tolerances = 0.1;
/* The cosines of slanted rays that look for layers behind a point of a face, and how many there are
 * of each; the part of the way to a layer that rounding may make; how far from an outline the
 * points lie, in tolerances; and the least cosine of the splat's normal to that of its face. */
enum { SLANTS = 2, AROUND = 8 };
static const double slants[SLANTS] = {0.75, 0.5}, least_part = 0.01;
static const double inset_tolerances = 0.35, least_face_cosine = 0.99;

/* Returns whether a candidate lies on a plane face, but for a deviation. */
static int is_level(const psplat_candidate *candidate, double most) {
    return !psplat_region_is_curved(&candidate->region) && candidate->deviation < most;
}

/* A splat is uneven; or level, with an uneven one beside it; or flat, as level ones are until such
 * a one is found. */
enum { UNEVEN, LEVEL, FLAT };

/* The search for the splats beside others. */
typedef struct sides {
    const psplat_region *regions;
    uint8_t *levels;  /* of each splat: UNEVEN, LEVEL or FLAT */
    double tolerance; /* how near to a point a splat is beside it, a length */
    size_t index;     /* the splat that the point is of */
    const double *point;
} sides;

/* Of two splats that lie beside each other and of which one is not level, neither is flat. */
static int see_side(void *user, uint32_t other) {
    const sides *s = user;
    uint8_t *level = &s->levels[s->levels[other] == UNEVEN ? s->index : other];
    double uvh[3];
    if (*level != FLAT || (s->levels[s->index] == UNEVEN) == (s->levels[other] == UNEVEN)) return 0;
    const psplat_region *region = &s->regions[other];
    double slack = s->tolerance / min2(region->radius[0], region->radius[1]);
    psplat_region_local(region, s->point, uvh);
    if (fabs(uvh[2]) <= s->tolerance && psplat_region_contains(region, uvh, 1 + slack, slack))
        *level = LEVEL;
    return s->levels[s->index] == LEVEL;
}

/* Looks at what lies beside the rim of a splat. */
static void see_sides(sides *s, const psplat_region_tree *tree) {
    double points[PSPLAT_REGION_POINTS][3];
    size_t count = psplat_region_rim_points(&s->regions[s->index], points);
    for (size_t k = 0; k < count && s->levels[s->index] != LEVEL; ++k) {
        s->point = points[k];
        psplat_region_tree_visit(tree, points[k], see_side, s);
    }
}

/* Marks the candidates that lie on plane faces and have only such beside them as flat. */
static psplat_result find_flat(psplat_selection *selection, double tolerance) {
    size_t count = selection->count, flat = 0;
    psplat_region *regions = malloc((count + 1) * sizeof *regions);
    psplat_region_tree *tree = NULL;
    sides s = {.regions = regions, .levels = malloc(count + 1), .tolerance = tolerance};
    for (size_t i = 0; regions && s.levels && i < count; ++i) {
        int level = is_level(&selection->candidates[i], level_tolerances * tolerance);
        regions[i] = selection->candidates[i].region;
        s.levels[i] = level ? FLAT : UNEVEN;
        flat += (size_t)level;
    }
    if (regions && s.levels) tree = psplat_region_tree_create(regions, count, tolerance);
    for (s.index = 0; tree && flat && flat < count && s.index < count; ++s.index)
        see_sides(&s, tree);
    for (size_t i = 0; tree && i < count; ++i)
        selection->candidates[i].is_flat = s.levels[i] == FLAT;
    free(regions);
    free(s.levels);
    if (!tree) return PSPLAT_ERROR_MEMORY;
    psplat_region_tree_destroy(tree);
    return PSPLAT_OK;
}

/* Stores whether another layer is met within a depth behind a point of a face by one of some rays,
 * of which the first goes straight through: whether it would show through the face from somewhere.
 * Slanted rays may go farther (spec 5.3). */
static psplat_result shows_layer(const psplat_distance *distance, const double point[3],
                                 const double normal[3], double depth, int *shows) {
    double u[3], v[3];
    psplat_result result = PSPLAT_OK;
    perpendicular3(u, normal);
    cross3(v, normal, u);
    *shows = 0;
    for (int i = -1; i < SLANTS * AROUND && !*shows && !result; ++i) {
        double cosine = i < 0 ? 1 : slants[i / AROUND], sine = sqrt(1 - cosine * cosine);
        double angle = 2 * PSPLAT_PI * i / AROUND, from[3], to[3], ray[3];
        for (int k = 0; k < 3; ++k)
            ray[k] = sine * (cos(angle) * u[k] + sin(angle) * v[k]) - cosine * normal[k];
        along3(from, point, least_part * depth, ray);
        along3(to, point, depth / cosine, ray);
        result = psplat_distance_meets(distance, from, to, shows);
    }
    return result;
}

/* Marks a candidate of a plane face as flat if another layer would show through that beside its
 * outline, where the face itself is. */
static psplat_result test_outline(const psplat_conversion *c, double depth,
                                  psplat_candidate *candidate) {
    double points[PSPLAT_REGION_POINTS][3], middle[3] = {0, 0, 0};
    size_t count = psplat_region_rim_points(&candidate->region, points);
    uint32_t guess = PSPLAT_NONE;
    double off = 2 * level_tolerances * c->tolerance;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < count; ++i) mad3(middle, 1 / (double)count, points[i]);
    for (size_t i = 0; i < count && !candidate->is_flat && !result; ++i) {
        double inwards[3], nearest[3];
        uint32_t triangle;
        sub3(inwards, middle, points[i]);
        double way = normalize3(inwards), step = min2(inset_tolerances * c->tolerance, way / 2);
        mad3(points[i], step, inwards);
        result = psplat_distance_nearest(c->distance, points[i], &guess, nearest, &triangle);
        if (result) break;
        const double *normal = c->surface.face_normals + 3 * (size_t)triangle;
        if (distance2_3(points[i], nearest) <= off * off &&
            dot3(normal, candidate->region.n) > least_face_cosine)
            result = shows_layer(c->distance, nearest, normal, depth, &candidate->is_flat);
    }
    return result;
}

/* Marks the candidates of plane faces as flat, too, that are hardly off these or through which
 * layers would show. */
static psplat_result add_flat(psplat_conversion *c, double depth) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < c->selection.count && !result; ++i) {
        psplat_candidate *candidate = &c->selection.candidates[i];
        candidate->is_flat |= is_level(candidate, exact_tolerances * c->tolerance);
        if (!candidate->is_flat && is_level(candidate, level_tolerances * c->tolerance))
            result = test_outline(c, depth, candidate);
    }
    return result;
}

/* Finds the share of the samples beneath which another layer lies within a depth. */
static psplat_result find_layered_share(const psplat_conversion *c, double depth, double *share) {
    size_t layered = 0, count = 0;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < c->samples.count && !result; i += SAMPLE_STEP) {
        int is_over;
        result = psplat_sample_hides(&c->surface, &c->samples, c->distance, depth, i, &is_over);
        layered += !result && is_over;
        ++count;
    }
    *share = (double)layered / fmax((double)count, 1);
    return result;
}

psplat_result psplat_depth_tolerances_choose(psplat_conversion *c, float *depth,
                                             float *flat_depth) {
    double deviation = 0, share;
    for (size_t i = 0; i < c->selection.count; ++i)
        deviation = fmax(deviation, c->selection.candidates[i].deviation);
    psplat_result result = find_layered_share(c, 2 * deviation, &share);
    if (result) return result;
    double part = share >= layered_share ? layered_part : 1;
    *depth = (float)fmax(2 * deviation * part, least_tolerances * c->tolerance);
    *flat_depth = (float)(2 * level_tolerances * c->tolerance);
    result = find_flat(&c->selection, c->tolerance);
    return result ? result : add_flat(c, (double)*depth);
}
