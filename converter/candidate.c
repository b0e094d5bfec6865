/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.c - the largest splat around a sample that keeps the limits (after Wu, Kobbelt 2004).
 *
 * The set of samples grows, not the ellipse: each trial takes the nearest samples, whose covariance
 * gives plane and axes at once, and asks what the ellipse around them covers. Near is first
 * Euclidean, then by the metric of the curvature found, so that splats stretch along the direction
 * in which the surface is straight. What a splat covers and where it leaves the surface are two
 * questions: it may reach beyond what it covers, as long as all of it stays near the surface.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Aspect ratio up to which the curvature's metric stretches. */
static const double greatest_stretch = 8;
/* Least cosine between a splat and the normals it represents; beyond, homogeneous normals with
 * third coordinate 1 grow without bound (BSK04 section 3). */
static const double least_cosine = 0.25;
/* Slope of the normal at the centre, which lines may have cut away far from all samples: its cosine
 * stays twice above the least of spec 3.5. */
static const double greatest_slope = 9.9;
/* Change of slope that a field may always make over its region. */
static const double tame_slope = 0.05;
/* Seed's surroundings known beyond the samples of a trial, in reaches. */
static const double gathered_part = 1.3;
/* Steps in which the surroundings grow. */
static const double ahead = 1.6;
/* Part of the samples of a trial that must come to be covered. */
static const double least_covered = 0.7;
/* The first reach, in spacings, and the steps in which it grows. */
static const double first_reach = 5;
static const double growing = 1.5;
/* Spacings up to which a sample stands for the surface around it: blue noise leaves no larger gaps.
 */
static const double greatest_gap = 1.5;
/* Steps in which an ellipse widens after its samples were found, and narrows where its outline
 * turns out to leave the surface. */
static const double widening = 1.1;
static const double narrowing = 0.92;

enum { BINS = 32 }; /* of heights */
enum { BISECTIONS = 4, STEPS_DOWN = 8, WIDENINGS = 6, NARROWINGS = 12, LEAST_PREFIX = 3 };
/* Corners of a trial's outline, and its rings. */
enum { OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES, RINGS = 2 };
static const double rings[RINGS] = {1, 0.6};

typedef enum trial_result { TRIAL_KEPT, TRIAL_TOO_FAR, TRIAL_TOO_MANY_LINES } trial_result;

/* Where and how a candidate grows. */
typedef struct seedling {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_growth *growth;
    uint32_t seed, triangle;
    psplat_metric metric;
    double gathered; /* reach up to which the neighbourhood is known in this metric */
    size_t relevant; /* samples of the neighbourhood that the region judged may hold */
    int failed;      /* out of memory */
} seedling;

void psplat_growth_free(psplat_growth *growth) {
    psplat_neighborhood_free(&growth->near);
    free(growth->uvh);
    free(growth->chosen);
    free(growth->plane);
    free(growth->local);
    free(growth->segments);
    *growth = (psplat_growth){0};
}

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

/* ---- gathering ----------------------------------------------------------------------------- */

static int reserve_samples(psplat_growth *g) {
    size_t count = g->near.count + 1;
    if (count <= g->capacity) return 1;
    size_t capacity = 2 * count + 256;
    free(g->uvh);
    free(g->chosen);
    free(g->plane);
    free(g->local);
    g->uvh = malloc(capacity * sizeof *g->uvh);
    g->chosen = malloc(capacity * sizeof *g->chosen);
    g->plane = malloc(capacity * sizeof *g->plane);
    g->local = malloc(capacity * sizeof *g->local);
    g->capacity = g->uvh && g->chosen && g->plane && g->local ? capacity : 0;
    return g->capacity > 0;
}

static int reserve_segments(psplat_growth *g) {
    if (g->near.crease_count <= g->segment_capacity) return 1;
    size_t capacity = 2 * g->near.crease_count;
    free(g->segments);
    g->segments = malloc(capacity * sizeof *g->segments);
    g->segment_capacity = g->segments ? capacity : 0;
    return g->segment_capacity > 0;
}

/* Knows the surroundings up to reach, unless they end before. */
static int gather(seedling *s, double reach) {
    psplat_growth *g = s->growth;
    if (reach <= s->gathered || (s->gathered > 0 && g->near.whole)) return 1;
    if (s->gathered > 0) reach = max2(reach, ahead * s->gathered);
    int ok = psplat_neighborhood_gather(&g->near, s->surface, s->samples, &s->metric, s->triangle,
                                        reach) &&
             reserve_samples(g) && reserve_segments(g);
    s->gathered = reach;
    if (!ok) s->failed = 1;
    return ok;
}

static void set_metric(seedling *s, const double n[3], const double u[3], double stretch) {
    double v[3];
    cross3(v, n, u);
    memcpy(s->metric.rows[0], u, sizeof s->metric.rows[0]);
    memcpy(s->metric.rows[2], n, sizeof s->metric.rows[2]);
    for (int k = 0; k < 3; ++k) s->metric.rows[1][k] = v[k] / stretch;
    s->gathered = 0;
}

/* ---- fitting ------------------------------------------------------------------------------- */

/* The height about which most of count heights lie within the tolerance; where all of them do, the
 * middle of their range. */
static double best_height(const double *heights, size_t count, double tolerance) {
    size_t bins[BINS + 1] = {0}, within = 0, most = 0;
    double low = HUGE_VAL, high = -HUGE_VAL, best;
    for (size_t i = 0; i < count; ++i) {
        low = min2(low, heights[i]);
        high = max2(high, heights[i]);
    }
    best = (low + high) / 2;
    if (!(high - low > 2 * tolerance)) return best;
    double scale = BINS / (high - low);
    size_t window = (size_t)(2 * tolerance * scale);
    for (size_t i = 0; i < count; ++i) bins[(size_t)((heights[i] - low) * scale)]++;
    for (size_t i = 0; i <= BINS; ++i) {
        within += bins[i];
        if (i >= window) within -= bins[i - window];
        if (within <= most) continue;
        most = within;
        best = low + ((double)i + 1 - (double)window / 2) / scale;
    }
    return best;
}

/* The ellipse of a plane's axes around chosen samples (indices into near; NULL: the first count),
 * at the height where most of them are. */
static void fit_ellipse(const seedling *s, const psplat_plane *plane, const uint32_t *chosen,
                        size_t count, psplat_region *region) {
    const psplat_near_sample *near = s->growth->near.samples;
    double scale = 0, *heights = &s->growth->plane[0][0];
    /* A row of samples still gets some width. */
    double least = 0.01 * s->samples->spacing * s->samples->spacing;
    double variance[2] = {plane->variance[0] + least, plane->variance[1] + least};
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, near[chosen ? chosen[i] : i].p, plane->mean);
        double x = dot3(d, plane->u), y = dot3(d, plane->v);
        scale = max2(scale, x * x / variance[0] + y * y / variance[1]);
        heights[i] = dot3(d, plane->n);
    }
    memcpy(region->u, plane->u, sizeof region->u);
    memcpy(region->v, plane->v, sizeof region->v);
    memcpy(region->n, plane->n, sizeof region->n);
    for (int k = 0; k < 3; ++k) region->center[k] = s->growth->near.origin[k] + plane->mean[k];
    mad3(region->center, best_height(heights, count, s->limits->tolerance), plane->n);
    for (int k = 0; k < 2; ++k) region->radius[k] = sqrt(variance[k] * scale) + s->limits->margin;
    region->line_count = 0;
}

/* ---- lines --------------------------------------------------------------------------------- */

/* Creases inside the ellipse, on the side of the surface that the splat lies on. Returns their
 * number, in growth->segments, and how far they leave the plane. */
static size_t find_segments(const seedling *s, const psplat_region *region, double *height) {
    psplat_growth *g = s->growth;
    /* What lies farther off is another part of a bent surface. */
    size_t count = psplat_segments_find(s->surface, g->near.creases, g->near.crease_count, region,
                                        2 * s->limits->tolerance, g->segments);
    *height = 0;
    for (size_t i = 0; i < count; ++i)
        *height = max2(*height, max2(fabs(g->segments[i].a[2]), fabs(g->segments[i].b[2])));
    return count;
}

/* ---- coverage ------------------------------------------------------------------------------ */

/* Samples that the region covers, into growth->chosen with their parameters: inside its ellipse
 * less the margin, within the tolerance, facing its way. Returns 0 where the seed is not among
 * them. */
static size_t cover(seedling *s, const psplat_region *region) {
    psplat_growth *g = s->growth;
    double inner[2], tolerance = s->limits->tolerance;
    for (int k = 0; k < 2; ++k)
        inner[k] = region->radius[k] /
                   (region->radius[k] - min2(s->limits->margin, 0.5 * region->radius[k]));
    double center[3];
    sub3(center, region->center, g->near.origin);
    size_t count = 0;
    int seed_met = s->seed == PSPLAT_NONE;
    for (uint32_t i = 0; i < s->relevant; ++i) {
        const psplat_near_sample *sample = &g->near.samples[i];
        double d[3], *uvh = g->uvh[i];
        sub3(d, sample->p, center);
        uvh[0] = dot3(d, region->u) / region->radius[0];
        uvh[1] = dot3(d, region->v) / region->radius[1];
        uvh[2] = dot3(d, region->n);
        double x = uvh[0] * inner[0], y = uvh[1] * inner[1];
        if (fabs(uvh[2]) > tolerance || x * x + y * y > 1) continue;
        if (!psplat_region_contains(region, uvh, 1, 1e-7)) continue;
        if (dot3(sample->n, region->n) < least_cosine) continue;
        seed_met |= sample->index == s->seed;
        memcpy(g->local[count], uvh, 2 * sizeof(double));
        g->chosen[count++] = i;
    }
    return seed_met ? count : 0;
}

/* Local normals (x, y) with third coordinate 1 of growth->chosen, into growth->plane. */
static void local_normals(const seedling *s, const psplat_region *region, size_t count) {
    psplat_growth *g = s->growth;
    for (size_t i = 0; i < count; ++i) {
        const double *n = g->near.samples[g->chosen[i]].n;
        double height = max2(dot3(n, region->n), least_cosine);
        g->plane[i][0] = dot3(n, region->u) / height;
        g->plane[i][1] = dot3(n, region->v) / height;
    }
}

/* Greatest angle between the field and the normals of growth->chosen, radians. */
static double field_error(const psplat_growth *g, const psplat_region *region, size_t count,
                          const double field[5]) {
    double greatest = 0;
    for (size_t i = 0; i < count; ++i) {
        double a[3] = {g->plane[i][0], g->plane[i][1], 1}, b[3] = {0, 0, 1}, c[3];
        psplat_fit_normal_at(field, region->radius, g->local[i], b);
        cross3(c, a, b);
        greatest = max2(greatest, atan2(length3(c), dot3(a, b)));
    }
    return greatest;
}

/* Whether the field keeps, all over the region, to twice the samples' own spread about their mean.
 * A gradient from a few samples in a row may be anything beside the row. */
static int field_is_tame(const psplat_growth *g, const psplat_region *region, size_t count,
                         const double mean[2], const double field[5]) {
    double spread = 0, outline[OUTLINE][2];
    for (size_t i = 0; i < count; ++i)
        spread = max2(spread, hypot(g->plane[i][0] - mean[0], g->plane[i][1] - mean[1]));
    size_t corners = psplat_region_polygon(region, 1, outline, OUTLINE);
    for (size_t i = 0; i < corners; ++i) {
        double xy[2];
        psplat_fit_normal_at(field, region->radius, outline[i], xy);
        if (hypot(xy[0] - mean[0], xy[1] - mean[1]) > 2 * spread + tame_slope) return 0;
    }
    return 1;
}

/* Fits the normal field to growth->chosen, without gradients where those would run wild or are not
 * wanted. Returns 0 where it errs by more than the limit. */
static int fit_field(const seedling *s, const psplat_region *region, size_t count,
                     double field[5]) {
    psplat_growth *g = s->growth;
    double mean[2] = {0, 0};
    local_normals(s, region, count);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += g->plane[i][k] / (double)count;
    if (!s->limits->constant_normals)
        psplat_fit_normals((const double(*)[2])g->local, (const double(*)[2])g->plane, count,
                           region->radius, field);
    if (s->limits->constant_normals || !field_is_tame(g, region, count, mean, field)) {
        field[0] = mean[0], field[1] = mean[1];
        field[2] = field[3] = field[4] = 0;
    }
    if (hypot(field[0], field[1]) > greatest_slope) return 0;
    return s->limits->normal_tolerance <= 0 ||
           field_error(g, region, count, field) <= s->limits->normal_tolerance;
}

static void mean_color(const seedling *s, size_t count, float color[4]) {
    const psplat_growth *g = s->growth;
    double sum[4] = {0};
    for (size_t i = 0; i < count; ++i) {
        size_t sample = g->near.samples[g->chosen[i]].index;
        for (size_t k = 0; k < 4; ++k) sum[k] += (double)s->samples->colors[4 * sample + k];
    }
    for (int k = 0; k < 4; ++k) color[k] = (float)(sum[k] / (double)count);
}

/* ---- outline ------------------------------------------------------------------------------- */

/* Whether a point (relative to the neighbourhood's origin) lies near the surface: near enough to
 * the tangent plane of a sample, and above or below its surroundings. */
static int near_surface(const seedling *s, const double q[3]) {
    const psplat_neighborhood *n = &s->growth->near;
    double tolerance2 = s->limits->tolerance * s->limits->tolerance;
    double gap = greatest_gap * s->samples->spacing, gap2 = gap * gap;
    for (size_t i = 0; i < s->relevant; ++i) {
        double d[3];
        sub3(d, q, n->samples[i].p);
        double distance2 = dot3(d, d);
        if (distance2 > tolerance2 + gap2) continue;
        double height = dot3(d, n->samples[i].n), height2 = height * height;
        if (height2 <= tolerance2 && distance2 - height2 <= gap2) return 1;
    }
    return 0;
}

/* Points of a region on two rings, relative to origin. Returns their number. */
static size_t outline_points(const psplat_region *region, const double origin[3],
                             double points[][3]) {
    double polygon[OUTLINE][2], middle[2] = {0, 0}, center[3];
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE), total = 0;
    sub3(center, region->center, origin);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    for (int ring = 0; ring < RINGS; ++ring)
        for (size_t i = 0; i < count; ++i, ++total) {
            double uv[2];
            for (int k = 0; k < 2; ++k)
                uv[k] = middle[k] + rings[ring] * (polygon[i][k] - middle[k]);
            memcpy(points[total], center, sizeof center);
            mad3(points[total], uv[0] * region->radius[0], region->u);
            mad3(points[total], uv[1] * region->radius[1], region->v);
        }
    return total;
}

static int outline_near_samples(const seedling *s, const psplat_region *region) {
    double points[RINGS * OUTLINE][3];
    size_t count = outline_points(region, s->growth->near.origin, points);
    for (size_t i = 0; i < count; ++i)
        if (!near_surface(s, points[i])) return 0;
    return 1;
}

/* ---- trials -------------------------------------------------------------------------------- */

/* Makes growth->chosen (count of them, inside region) the candidate's own. */
static void adopt(seedling *s, const psplat_region *region, const double field[5], size_t count,
                  psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) {
        s->failed = 1;
        return;
    }
    candidate->deviation = 0;
    for (size_t i = 0; i < count; ++i) {
        covered[i] = g->near.samples[g->chosen[i]].index;
        candidate->deviation = max2(candidate->deviation, fabs(g->uvh[g->chosen[i]][2]));
    }
    candidate->covered = covered;
    candidate->covered_count = count;
    candidate->region = *region;
    candidate->triangle = s->triangle;
    memcpy(candidate->field, field, sizeof candidate->field);
    for (int k = 0; k < 4; ++k) candidate->color[k] = 1;
    if (s->samples->colors) mean_color(s, count, candidate->color);
}

/* Reach of a region from the seed in the metric. */
static double region_reach(const seedling *s, const psplat_region *region) {
    double corners[OUTLINE][2], farthest = 0;
    size_t count = psplat_region_polygon(region, 0, corners, OUTLINE);
    for (size_t i = 0; i < count; ++i) {
        double d[3], w[3];
        sub3(d, region->center, s->metric.center);
        mad3(d, corners[i][0] * region->radius[0], region->u);
        mad3(d, corners[i][1] * region->radius[1], region->v);
        for (int k = 0; k < 3; ++k) w[k] = dot3(s->metric.rows[k], d);
        farthest = max2(farthest, length3(w));
    }
    return farthest;
}

/* Turns the frame so that the larger radius comes first. */
static void order_axes(psplat_region *region) {
    if (region->radius[0] >= region->radius[1]) return;
    double radius = region->radius[0];
    region->radius[0] = region->radius[1], region->radius[1] = radius;
    for (int k = 0; k < 3; ++k) {
        double u = region->u[k];
        region->u[k] = region->v[k], region->v[k] = -u;
    }
}

/* Gives a region its lines and asks what it covers; where it keeps the limits and covers more than
 * the candidate does, it becomes the candidate's. Stores how many samples it covers. */
static trial_result judge(seedling *s, psplat_region *region, psplat_candidate *candidate,
                          size_t *covered) {
    psplat_growth *g = s->growth;
    double seed[3], height, field[5];
    *covered = 0;
    double reach = region_reach(s, region) + greatest_gap * s->samples->spacing;
    if (!gather(s, reach)) return TRIAL_TOO_FAR;
    s->relevant = psplat_neighborhood_within(&g->near, reach);
    size_t segments = find_segments(s, region, &height);
    psplat_region_local(region, s->metric.center, seed);
    if (height > s->limits->crease_tolerance) return TRIAL_TOO_FAR;
    if (!psplat_clip_choose(region, g->segments, segments, seed, s->limits->crease_slack))
        return TRIAL_TOO_MANY_LINES;
    *covered = cover(s, region);
    if (!*covered) return TRIAL_TOO_FAR;
    int better = *covered > candidate->covered_count;
    if (better && !outline_near_samples(s, region)) return TRIAL_TOO_FAR;
    if (!better && !(s->limits->normal_tolerance > 0)) return TRIAL_KEPT;
    if (!fit_field(s, region, *covered, field)) return TRIAL_TOO_FAR;
    if (!better) return TRIAL_KEPT;
    adopt(s, region, field, *covered, candidate);
    return TRIAL_KEPT;
}

/* One trial with the nearest count samples. What lines leave of them is fitted once more. */
static trial_result try_prefix(seedling *s, size_t count, psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    psplat_covariance covariance;
    psplat_plane plane;
    psplat_region region;
    size_t covered;
    psplat_neighborhood_covariance(&g->near, count, &covariance);
    psplat_covariance_fit(&covariance, &plane);
    double tolerance = s->limits->tolerance;
    if (plane.variance[2] > tolerance * tolerance) return TRIAL_TOO_FAR;
    fit_ellipse(s, &plane, NULL, count, &region);
    trial_result result = judge(s, &region, candidate, &covered);
    if (!result && !region.line_count && (double)covered < least_covered * (double)count)
        return TRIAL_TOO_FAR;
    if (result || !region.line_count || covered >= count || covered < LEAST_PREFIX) return result;
    covariance = (psplat_covariance){0};
    for (size_t i = 0; i < covered; ++i)
        psplat_covariance_add(&covariance, g->near.samples[g->chosen[i]].p,
                              g->near.samples[g->chosen[i]].n);
    psplat_covariance_fit(&covariance, &plane);
    fit_ellipse(s, &plane, g->chosen, covered, &region);
    judge(s, &region, candidate, &covered);
    return TRIAL_KEPT;
}

/* The nearest samples within reach; at least a few. */
static trial_result try_reach(seedling *s, double reach, psplat_candidate *candidate,
                              size_t *count) {
    *count = 0;
    if (!gather(s, gathered_part * reach)) return TRIAL_TOO_FAR;
    *count = psplat_neighborhood_within(&s->growth->near, reach);
    if (*count < LEAST_PREFIX)
        *count = s->growth->near.count < LEAST_PREFIX ? s->growth->near.count : LEAST_PREFIX;
    return *count ? try_prefix(s, *count, candidate) : TRIAL_TOO_FAR;
}

/* Raises the reach until the limits or the patch end, halves it where even the first is too much,
 * then bisects. */
static double grow_metric(seedling *s, double reach, psplat_candidate *candidate) {
    double kept = 0, broken = 0;
    size_t count = 0, before = 0;
    for (; !s->failed; reach *= growing) {
        trial_result result = try_reach(s, reach, candidate, &count);
        if (result == TRIAL_KEPT) kept = reach, broken = 0;
        if (result != TRIAL_KEPT && broken == 0) broken = reach;
        /* Lines that do not suffice may yet: a larger region may leave the crease's end behind. */
        if (result == TRIAL_TOO_FAR || count == before || reach > 8 * broken + 8 * kept) break;
        before = count;
    }
    for (int step = 0; kept == 0 && step < STEPS_DOWN && !s->failed; ++step) {
        double half = broken / 2;
        if (try_reach(s, half, candidate, &count) == TRIAL_KEPT)
            kept = half;
        else
            broken = half;
    }
    for (int step = 0; kept > 0 && broken > kept && step < BISECTIONS && !s->failed; ++step) {
        double middle = (kept + broken) / 2;
        if (try_reach(s, middle, candidate, &count) == TRIAL_KEPT)
            kept = middle;
        else
            broken = middle;
    }
    return kept;
}

/* Widens the ellipse along both axes, then each, while it comes to cover more. */
static void widen(seedling *s, psplat_candidate *candidate) {
    for (int axes = 3; axes > 0 && !s->failed; --axes)
        for (int step = 0; step < WIDENINGS && !s->failed; ++step) {
            psplat_region region = candidate->region;
            size_t covered, before = candidate->covered_count;
            for (int k = 0; k < 2; ++k)
                if (axes & (1 << k)) region.radius[k] *= widening;
            region.line_count = 0;
            order_axes(&region);
            judge(s, &region, candidate, &covered);
            if (candidate->covered_count <= before) break;
        }
}

/* Turns the metric to the curvature of the samples that the candidate covers. Returns 0 where that
 * changes little. */
static int adapt_metric(seedling *s, const psplat_candidate *candidate) {
    psplat_covariance covariance = {0};
    psplat_plane plane;
    double direction[2], curvature[2], u[3];
    if (candidate->covered_count < 6) return 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        const size_t sample = candidate->covered[i];
        double p[3], n[3];
        sub3(p, s->samples->positions + 3 * sample, s->metric.center);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)s->samples->normals[3 * sample + k];
        psplat_covariance_add(&covariance, p, n);
    }
    psplat_covariance_fit(&covariance, &plane);
    if (!psplat_covariance_curvature(&covariance, &plane, direction, curvature)) return 0;
    double stretch = sqrt(curvature[0] / max2(curvature[1], 1e-12 * curvature[0]));
    if (stretch <= 1.25) return 0;
    for (int k = 0; k < 3; ++k) u[k] = direction[0] * plane.u[k] + direction[1] * plane.v[k];
    set_metric(s, plane.n, u, min2(stretch, greatest_stretch));
    return 1;
}

/* Squared distance of a point to the triangle of a sample. */
static double triangle_distance2(const seedling *s, uint32_t sample, const double q[3]) {
    const psplat_mesh *mesh = s->surface->mesh;
    const uint32_t *vertices = mesh->triangles + 3 * (size_t)s->samples->triangles[sample];
    return point_triangle_distance2(q, mesh->positions + 3 * (size_t)vertices[0],
                                    mesh->positions + 3 * (size_t)vertices[1],
                                    mesh->positions + 3 * (size_t)vertices[2]);
}

/* Whether all of a region is near the mesh. The triangle of the nearest sample mostly says so; only
 * points that it is too far from ask the mesh. */
static int region_near_mesh(seedling *s, const psplat_region *region) {
    const psplat_neighborhood *n = &s->growth->near;
    double points[PSPLAT_REGION_POINTS][3], distance, tolerance = s->limits->tolerance;
    size_t count = psplat_region_points(region, points);
    for (size_t i = 0; i < count; ++i) {
        double q[3], d[3], least = HUGE_VAL;
        uint32_t nearest = s->seed;
        sub3(q, points[i], n->origin);
        for (size_t k = 0; k < s->relevant; ++k) {
            sub3(d, q, n->samples[k].p);
            double distance2 = dot3(d, d);
            if (distance2 < least) least = distance2, nearest = n->samples[k].index;
        }
        if (triangle_distance2(s, nearest, points[i]) <= tolerance * tolerance) continue;
        if (!s->limits->distance) return 0;
        if (psplat_distance_query(s->limits->distance, points[i], 1, &distance)) s->failed = 1;
        if (distance > tolerance || s->failed) return 0;
    }
    return 1;
}

/* Narrows a candidate whose outline leaves the mesh between samples. Returns 0 where that does not
 * help. */
static int keep_near(seedling *s, psplat_candidate *candidate) {
    for (int step = 0; step < NARROWINGS && !s->failed; ++step) {
        size_t covered;
        if (region_near_mesh(s, &candidate->region)) return 1;
        psplat_region region = candidate->region;
        for (int k = 0; k < 2; ++k) region.radius[k] *= narrowing;
        region.line_count = 0;
        candidate->covered_count = 0;
        judge(s, &region, candidate, &covered);
        if (!candidate->covered_count) return 0;
    }
    return 0;
}

/* The last resort: a disc on the seed's own triangle that covers the seed alone. */
static void force(seedling *s, double radius, psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    psplat_region region = {.radius = {radius, radius}};
    double field[5], height, seed[3] = {0, 0, 0};
    memcpy(region.center, s->metric.center, sizeof region.center);
    memcpy(region.n, s->surface->face_normals + 3 * (size_t)s->triangle, sizeof region.n);
    perpendicular3(region.u, region.n);
    cross3(region.v, region.n, region.u);
    if (!gather(s, 2 * radius)) return;
    size_t segments = find_segments(s, &region, &height);
    psplat_clip_choose(&region, g->segments, segments, seed, s->limits->crease_slack);
    g->chosen[0] = 0;
    while (g->near.samples[g->chosen[0]].index != s->seed) ++g->chosen[0];
    g->local[0][0] = g->local[0][1] = 0;
    fit_field(s, &region, 1, field);
    g->uvh[g->chosen[0]][2] = radius;
    adopt(s, &region, field, 1, candidate);
}

psplat_result psplat_candidate_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, uint32_t seed,
                                    psplat_growth *growth, psplat_candidate *candidate) {
    seedling s = {.surface = surface,
                  .samples = samples,
                  .limits = limits,
                  .growth = growth,
                  .seed = seed,
                  .triangle = samples->triangles[seed]};
    const double *n = surface->face_normals + 3 * (size_t)s.triangle;
    double u[3];
    memcpy(s.metric.center, samples->positions + 3 * (size_t)seed, sizeof s.metric.center);
    perpendicular3(u, n);
    set_metric(&s, n, u, 1);
    *candidate = (psplat_candidate){0};
    double reach = grow_metric(&s, first_reach * samples->spacing, candidate);
    if (candidate->covered_count && !s.failed && adapt_metric(&s, candidate))
        grow_metric(&s, reach, candidate);
    if (candidate->covered_count && !s.failed) {
        widen(&s, candidate);
        if (!keep_near(&s, candidate)) candidate->covered_count = 0;
    }
    if (!candidate->covered_count && !s.failed) force(&s, samples->spacing / 16, candidate);
    if (!s.failed) return PSPLAT_OK;
    psplat_candidate_free(candidate);
    return PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_candidate_cover(const psplat_surface *surface, const psplat_samples *samples,
                                     const psplat_limits *limits, psplat_growth *growth,
                                     psplat_candidate *candidate) {
    seedling s = {.surface = surface,
                  .samples = samples,
                  .limits = limits,
                  .growth = growth,
                  .seed = PSPLAT_NONE,
                  .triangle = candidate->triangle};
    const psplat_region *region = &candidate->region;
    memcpy(s.metric.center, region->center, sizeof s.metric.center);
    set_metric(&s, region->n, region->u, 1);
    if (!gather(&s, 1.01 * (region->radius[0] + limits->tolerance))) return PSPLAT_ERROR_MEMORY;
    s.relevant = growth->near.count;
    size_t count = cover(&s, region);
    candidate->covered_count = 0; /* a forced candidate may cover nothing by this measure */
    if (!count) return PSPLAT_OK;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) covered[i] = growth->near.samples[growth->chosen[i]].index;
    candidate->covered = covered;
    candidate->covered_count = count;
    return PSPLAT_OK;
}
