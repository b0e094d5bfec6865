/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.c - the largest splat around a sample that keeps the limits (after Wu, Kobbelt 2004).
 *
 * The set of samples grows, not the ellipse: each trial takes the samples within a distance of the
 * seed, fits plane, ellipse and clip lines to them, and lets a walk over the surface decide. The
 * distance is first Euclidean, then that of the curvature found, so that splats stretch along the
 * direction in which the surface is straight.
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
/* Part of a region that the surface may leave open or cover twice, for the polygon's own error. */
static const double area_error = 0.03;

enum { BISECTIONS = 4, STEPS_PAST_FAILURE = 3, STEPS_DOWN = 8 };
/* Corners of an outline: as many as a walk clips by, and those of the lines. */
enum { OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES };

typedef enum trial_result { TRIAL_KEPT, TRIAL_TOO_FAR, TRIAL_TOO_MANY_LINES } trial_result;

/* Where and how a candidate grows. */
typedef struct seedling {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_growth *growth;
    uint32_t seed, triangle;
    double point[3];
    double u[3], v[3], n[3]; /* axes of the metric */
    double stretch[2];       /* lengths of its unit along u and v */
    double gathered;         /* reach up to which growth->near is known in this metric */
    int failed;              /* out of memory */
} seedling;

void psplat_growth_free(psplat_growth *growth) {
    psplat_walk_free(&growth->walk);
    free(growth->chosen);
    free(growth->plane);
    free(growth->local);
    free(growth->near);
    free(growth->distances);
    *growth = (psplat_growth){0};
}

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

static int growth_reserve(psplat_growth *growth, size_t count) {
    if (count <= growth->capacity) return 1;
    size_t capacity = 2 * count + 256;
    void *chosen = realloc(growth->chosen, capacity * sizeof *growth->chosen);
    if (chosen) growth->chosen = chosen;
    void *plane = realloc(growth->plane, capacity * sizeof *growth->plane);
    if (plane) growth->plane = plane;
    void *local = realloc(growth->local, capacity * sizeof *growth->local);
    if (local) growth->local = local;
    void *near = realloc(growth->near, capacity * sizeof *growth->near);
    if (near) growth->near = near;
    void *distances = realloc(growth->distances, capacity * sizeof *growth->distances);
    if (distances) growth->distances = distances;
    if (!chosen || !plane || !local || !near || !distances) return 0;
    growth->capacity = capacity;
    return 1;
}

/* ---- gathering ----------------------------------------------------------------------------- */

static double metric_distance(const seedling *s, const double p[3]) {
    double d[3];
    sub3(d, p, s->point);
    double u = dot3(d, s->u) / s->stretch[0], v = dot3(d, s->v) / s->stretch[1];
    double n = dot3(d, s->n) / min2(s->stretch[0], s->stretch[1]);
    return sqrt(u * u + v * v + n * n);
}

/* Room for all samples of the walked triangles. */
static int reserve_walked(const seedling *s) {
    size_t total = 0;
    for (size_t i = 0; i < s->growth->walk.triangle_count; ++i) {
        uint32_t t = s->growth->walk.triangles[i];
        total += s->samples->first[t + 1] - s->samples->first[t];
    }
    return growth_reserve(s->growth, total);
}

/* Collects the samples connected with the seed and within reach of it, with their distances. */
static void gather(seedling *s, double reach) {
    psplat_growth *g = s->growth;
    psplat_region ball = {.radius = {reach * s->stretch[0], reach * s->stretch[1]}};
    memcpy(ball.center, s->point, sizeof ball.center);
    memcpy(ball.u, s->u, sizeof ball.u);
    memcpy(ball.v, s->v, sizeof ball.v);
    memcpy(ball.n, s->n, sizeof ball.n);
    psplat_walk_surface(&g->walk, s->surface, &ball, s->triangle, HUGE_VAL);
    g->near_count = 0;
    if (g->walk.failed || !reserve_walked(s)) {
        s->failed = 1;
        return;
    }
    for (size_t i = 0; i < g->walk.triangle_count; ++i) {
        uint32_t t = g->walk.triangles[i];
        for (uint32_t k = s->samples->first[t]; k < s->samples->first[t + 1]; ++k) {
            double distance = metric_distance(s, s->samples->positions + 3 * (size_t)k);
            if (distance > reach && k != s->seed) continue;
            g->distances[g->near_count] = distance;
            g->near[g->near_count++] = k;
        }
    }
}

/* Samples within reach, into growth->chosen; gathers anew only beyond the reach gathered last. */
static size_t choose_near(seedling *s, double reach) {
    psplat_growth *g = s->growth;
    if (reach > s->gathered) {
        gather(s, reach);
        s->gathered = reach;
    }
    size_t count = 0;
    if (s->failed || !growth_reserve(g, g->near_count + 1)) return s->failed = 1, 0;
    for (size_t i = 0; i < g->near_count; ++i)
        if (g->distances[i] <= reach) g->chosen[count++] = g->near[i];
    if (!count) g->chosen[count++] = s->seed;
    return count;
}

/* ---- fitting ------------------------------------------------------------------------------- */

/* The plane and the enclosing ellipse of growth->chosen, grown by the margin. */
static void fit_region(const seedling *s, size_t count, double margin, psplat_region *region) {
    psplat_growth *g = s->growth;
    double u[3], v[3];
    psplat_fit_plane(s->samples, g->chosen, count, region->center, region->n);
    perpendicular3(u, region->n);
    cross3(v, region->n, u);
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, s->samples->positions + 3 * (size_t)g->chosen[i], region->center);
        g->plane[i][0] = dot3(d, u), g->plane[i][1] = dot3(d, v);
    }
    psplat_ellipse e;
    psplat_ellipse_enclose(g->plane, count, &e);
    mad3(region->center, e.center[0], u);
    mad3(region->center, e.center[1], v);
    for (int k = 0; k < 3; ++k) region->u[k] = e.axis[0] * u[k] + e.axis[1] * v[k];
    cross3(region->v, region->n, region->u);
    region->line_count = 0;
    for (int k = 0; k < 2; ++k) region->radius[k] = e.radius[k] + margin;
}

/* Moves the plane along its normal to halve the greatest distance, as near to the creases' own
 * middle as that allows. Returns 0 where the limits cannot be kept. */
static int settle_height(const seedling *s, psplat_region *region, double *deviation) {
    const psplat_walk *walk = &s->growth->walk;
    double tolerance = s->limits->tolerance;
    double half = (walk->height[1] - walk->height[0]) / 2;
    if (!walk->triangle_count || half > tolerance) return 0;
    double shift = (walk->height[0] + walk->height[1]) / 2;
    if (walk->crease_height[0] <= walk->crease_height[1]) {
        double low = walk->height[1] - tolerance, high = walk->height[0] + tolerance;
        double wish = (walk->crease_height[0] + walk->crease_height[1]) / 2;
        shift = min2(max2(wish, low), high);
        if (walk->crease_height[1] - shift > s->limits->crease_tolerance ||
            shift - walk->crease_height[0] > s->limits->crease_tolerance)
            return 0;
    }
    mad3(region->center, shift, region->n);
    *deviation = max2(walk->height[1] - shift, shift - walk->height[0]);
    return 1;
}

psplat_result psplat_region_near(const psplat_region *region, const psplat_limits *limits,
                                 int *near) {
    double polygon[OUTLINE][2], points[OUTLINE][3], distances[OUTLINE];
    *near = 1;
    if (!limits->distance) return PSPLAT_OK;
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE);
    for (size_t i = 0; i < count; ++i) {
        memcpy(points[i], region->center, sizeof points[i]);
        mad3(points[i], polygon[i][0] * region->radius[0], region->u);
        mad3(points[i], polygon[i][1] * region->radius[1], region->v);
    }
    psplat_result result = psplat_distance_query(limits->distance, &points[0][0], count, distances);
    for (size_t i = 0; i < count && !result; ++i) *near &= distances[i] <= limits->tolerance;
    return result;
}

/* Whether the outline stays near the mesh. What lines leave over at an acute corner, or all of a
 * sliver between two, is too little area to show. */
static int outline_near(seedling *s, const psplat_region *region) {
    int near = 1;
    if (region->line_count && psplat_region_near(region, s->limits, &near)) s->failed = 1;
    return near && !s->failed;
}

/* Whether the surface covers the region once: a fold or a loose end shows as area. */
static int area_fits(const seedling *s, const psplat_region *region) {
    double polygon[OUTLINE][2], twice = 0;
    size_t count = psplat_region_polygon(region, 0, polygon, OUTLINE);
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[i + 1 < count ? i + 1 : 0];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    double area = twice / 2, error = area_error * area;
    double over = 2 * s->limits->crease_slack / region->radius[1] * region->line_count;
    return s->growth->walk.area >= area - error - over && s->growth->walk.area <= area + error;
}

static trial_result find_lines(const seedling *s, psplat_region *region) {
    psplat_walk *walk = &s->growth->walk;
    double seed[3];
    double range = 2 * s->limits->tolerance;
    psplat_walk_surface(walk, s->surface, region, s->triangle, range);
    if (walk->aborted) return TRIAL_TOO_FAR;
    psplat_region_local(region, s->point, seed);
    int chosen = psplat_clip_choose(region, walk->segments, walk->segment_count, seed,
                                    s->limits->crease_slack);
    if (!chosen) return TRIAL_TOO_MANY_LINES;
    if (region->line_count) psplat_walk_surface(walk, s->surface, region, s->triangle, range);
    return walk->aborted ? TRIAL_TOO_FAR : TRIAL_KEPT;
}

/* ---- coverage ------------------------------------------------------------------------------ */

/* Samples of the walked surface inside the region, less half the margin, into growth->chosen with
 * their parameters. Returns 0 where a normal is out of reach or the seed is not among them. */
static size_t cover(seedling *s, const psplat_region *region) {
    psplat_growth *g = s->growth;
    if (!reserve_walked(s)) return s->failed = 1, 0;
    /* The ellipse less half the margin, as a region of its own: lines stay where they are. */
    double inset = min2(0.5 * s->limits->margin, 0.25 * region->radius[1]), inner[2];
    for (int k = 0; k < 2; ++k) inner[k] = region->radius[k] / (region->radius[k] - inset);
    size_t count = 0;
    int seed_met = s->seed == PSPLAT_NONE;
    for (size_t i = 0; i < g->walk.triangle_count; ++i) {
        uint32_t t = g->walk.triangles[i];
        for (uint32_t k = s->samples->first[t]; k < s->samples->first[t + 1]; ++k) {
            double uvh[3];
            psplat_region_local(region, s->samples->positions + 3 * (size_t)k, uvh);
            if (hypot(uvh[0] * inner[0], uvh[1] * inner[1]) > 1) continue;
            if (!psplat_region_contains(region, uvh, 1, 1e-7)) continue;
            const float *f = s->samples->normals + 3 * (size_t)k;
            double n[3] = {(double)f[0], (double)f[1], (double)f[2]};
            if (dot3(n, region->n) < least_cosine) return 0;
            seed_met |= k == s->seed;
            memcpy(g->local[count], uvh, 2 * sizeof(double));
            g->chosen[count++] = k;
        }
    }
    return seed_met ? count : 0;
}

/* Local normals (x, y) with third coordinate 1 of growth->chosen, into growth->plane. */
static void local_normals(const seedling *s, const psplat_region *region, size_t count) {
    psplat_growth *g = s->growth;
    for (size_t i = 0; i < count; ++i) {
        const float *f = s->samples->normals + 3 * (size_t)g->chosen[i];
        double n[3] = {(double)f[0], (double)f[1], (double)f[2]};
        double height = max2(dot3(n, region->n), least_cosine);
        g->plane[i][0] = dot3(n, region->u) / height;
        g->plane[i][1] = dot3(n, region->v) / height;
    }
}

/* Root mean square of the field's error on growth->chosen, radians. */
static double field_error(const psplat_growth *g, const psplat_region *region, size_t count,
                          const double field[5]) {
    double squares = 0;
    for (size_t i = 0; i < count; ++i) {
        double a[3] = {g->plane[i][0], g->plane[i][1], 1}, b[3] = {0, 0, 1}, c[3];
        psplat_fit_normal_at(field, region->radius, g->local[i], b);
        cross3(c, a, b);
        double angle = atan2(length3(c), dot3(a, b));
        squares += angle * angle;
    }
    return sqrt(squares / (double)count);
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

/* Fits the normal field to growth->chosen, without gradients where those would run wild, and
 * returns the root mean square of its error, radians. */
static double fit_field(const seedling *s, const psplat_region *region, size_t count,
                        double field[5]) {
    psplat_growth *g = s->growth;
    double mean[2] = {0, 0};
    local_normals(s, region, count);
    psplat_fit_normals((const double(*)[2])g->local, (const double(*)[2])g->plane, count,
                       region->radius, field);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += g->plane[i][k] / (double)count;
    if (!field_is_tame(g, region, count, mean, field)) {
        field[0] = mean[0], field[1] = mean[1];
        field[2] = field[3] = field[4] = 0;
    }
    return field_error(g, region, count, field);
}

static void mean_color(const seedling *s, size_t count, float color[4]) {
    double sum[4] = {0};
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 4; ++k)
            sum[k] += (double)s->samples->colors[4 * (size_t)s->growth->chosen[i] + k];
    for (int k = 0; k < 4; ++k) color[k] = (float)(sum[k] / (double)count);
}

/* Makes growth->chosen (count of them, inside region) the candidate's own. */
static void adopt(seedling *s, const psplat_region *region, const double field[5], double deviation,
                  size_t count, psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) {
        s->failed = 1;
        return;
    }
    memcpy(covered, g->chosen, count * sizeof *covered);
    candidate->covered = covered;
    candidate->covered_count = count;
    candidate->region = *region;
    candidate->triangle = s->triangle;
    candidate->deviation = deviation;
    memcpy(candidate->field, field, sizeof candidate->field);
    for (int k = 0; k < 4; ++k) candidate->color[k] = 1;
    if (s->samples->colors) mean_color(s, count, candidate->color);
}

/* ---- trials -------------------------------------------------------------------------------- */

/* One trial with the samples within reach; a success that covers more replaces the candidate. The
 * second round fits again to what the first one's lines left. */
static trial_result try_reach(seedling *s, double reach, psplat_candidate *candidate,
                              size_t *gathered) {
    psplat_region region;
    double deviation, field[5];
    /* Small sets get a small margin, so that a splat between close creases can shrink. */
    double margin = min2(s->limits->margin, 0.5 * reach);
    size_t count = choose_near(s, reach);
    *gathered = count;
    for (int round = 0; round < 2 && !s->failed; ++round) {
        fit_region(s, count, margin, &region);
        trial_result result = find_lines(s, &region);
        if (s->growth->walk.failed) s->failed = 1;
        if (result || s->failed) return result;
        if (!settle_height(s, &region, &deviation) || !area_fits(s, &region)) return TRIAL_TOO_FAR;
        size_t covered = cover(s, &region);
        if (!covered) return TRIAL_TOO_FAR;
        if (fit_field(s, &region, covered, field) > s->limits->normal_error ||
            hypot(field[0], field[1]) > greatest_slope)
            return TRIAL_TOO_FAR;
        if (covered > candidate->covered_count && !outline_near(s, &region)) return TRIAL_TOO_FAR;
        if (covered > candidate->covered_count)
            adopt(s, &region, field, deviation, covered, candidate);
        if (!region.line_count || covered >= count) break;
        count = covered;
    }
    return TRIAL_KEPT;
}

/* Doubles the reach until the limits or the patch end, halves it where even the first is too much,
 * then bisects. */
static double grow_metric(seedling *s, double reach, psplat_candidate *candidate) {
    double kept = 0, broken = 0;
    size_t gathered = 0, before = 0;
    for (int past = 0; past < STEPS_PAST_FAILURE && !s->failed; reach *= 2) {
        trial_result result = try_reach(s, reach, candidate, &gathered);
        if (result == TRIAL_KEPT) {
            kept = reach;
            broken = 0;
            past = 0;
        } else {
            if (broken == 0) broken = reach;
            ++past;
        }
        if (result == TRIAL_TOO_FAR || gathered == before) break;
        before = gathered;
    }
    for (int step = 0; kept == 0 && step < STEPS_DOWN && !s->failed; ++step) {
        double half = broken / 2;
        if (try_reach(s, half, candidate, &gathered) == TRIAL_KEPT)
            kept = half;
        else
            broken = half;
    }
    if (kept == 0 || broken == 0) return kept;
    for (int step = 0; step < BISECTIONS && !s->failed; ++step) {
        double middle = (kept + broken) / 2;
        if (try_reach(s, middle, candidate, &gathered) == TRIAL_KEPT)
            kept = middle;
        else
            broken = middle;
    }
    return kept;
}

/* Turns the metric to the curvature of the candidate. Returns 0 where that changes little. */
static int adapt_metric(seedling *s, const psplat_candidate *candidate) {
    const psplat_region *region = &candidate->region;
    psplat_growth *g = s->growth;
    size_t count = candidate->covered_count;
    if (count < 6 || !growth_reserve(g, count)) return 0;
    memcpy(g->chosen, candidate->covered, count * sizeof *g->chosen);
    for (size_t i = 0; i < count; ++i) {
        double uvh[3];
        psplat_region_local(region, s->samples->positions + 3 * (size_t)g->chosen[i], uvh);
        g->local[i][0] = uvh[0] * region->radius[0];
        g->local[i][1] = uvh[1] * region->radius[1];
    }
    local_normals(s, region, count);
    double direction[2], curvature[2];
    psplat_fit_curvature((const double(*)[2])g->local, (const double(*)[2])g->plane, count,
                         direction, curvature);
    if (!(curvature[0] > 0)) return 0;
    double ratio = sqrt(curvature[0] / max2(curvature[1], 1e-12 * curvature[0]));
    ratio = min2(ratio, greatest_stretch);
    for (int k = 0; k < 3; ++k) s->u[k] = direction[0] * region->u[k] + direction[1] * region->v[k];
    memcpy(s->n, region->n, sizeof s->n);
    cross3(s->v, s->n, s->u);
    s->stretch[0] = 1, s->stretch[1] = ratio;
    s->gathered = 0;
    return ratio > 1.25;
}

/* The last resort: a disc on the seed's own triangle that covers the seed alone. */
static void force(seedling *s, double radius, psplat_candidate *candidate) {
    psplat_region region = {.radius = {radius, radius}};
    memcpy(region.center, s->point, sizeof region.center);
    memcpy(region.n, s->surface->face_normals + 3 * (size_t)s->triangle, sizeof region.n);
    perpendicular3(region.u, region.n);
    cross3(region.v, region.n, region.u);
    find_lines(s, &region);
    if (!growth_reserve(s->growth, 1)) {
        s->failed = 1;
        return;
    }
    s->growth->chosen[0] = s->seed;
    s->growth->local[0][0] = s->growth->local[0][1] = 0;
    double field[5];
    fit_field(s, &region, 1, field);
    adopt(s, &region, field, radius, 1, candidate);
}

psplat_result psplat_candidate_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, uint32_t seed,
                                    psplat_growth *growth, psplat_candidate *candidate) {
    seedling s = {.surface = surface,
                  .samples = samples,
                  .limits = limits,
                  .growth = growth,
                  .seed = seed,
                  .triangle = samples->triangles[seed],
                  .stretch = {1, 1}};
    memcpy(s.point, samples->positions + 3 * (size_t)seed, sizeof s.point);
    memcpy(s.n, surface->face_normals + 3 * (size_t)s.triangle, sizeof s.n);
    perpendicular3(s.u, s.n);
    cross3(s.v, s.n, s.u);
    *candidate = (psplat_candidate){0};
    double reach = grow_metric(&s, 4 * samples->spacing, candidate);
    if (candidate->covered && !s.failed && adapt_metric(&s, candidate))
        grow_metric(&s, reach, candidate);
    if (!candidate->covered && !s.failed) force(&s, samples->spacing / 16, candidate);
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
    psplat_walk_surface(&growth->walk, surface, &candidate->region, candidate->triangle, HUGE_VAL);
    size_t count = growth->walk.failed ? 0 : cover(&s, &candidate->region);
    if (growth->walk.failed || s.failed) return PSPLAT_ERROR_MEMORY;
    candidate->covered_count = 0; /* a forced candidate may cover nothing by this measure */
    if (!count) return PSPLAT_OK;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) return PSPLAT_ERROR_MEMORY;
    memcpy(covered, growth->chosen, count * sizeof *covered);
    candidate->covered = covered;
    candidate->covered_count = count;
    return PSPLAT_OK;
}
