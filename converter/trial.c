/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trial.c - what a region would be as a splat: its lines, what it covers, its normals, and whether
 * all of it lies near the surface.
 */
#include "trial.h"

#include "encoding.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Least cosine between a splat and the normals it represents; beyond, homogeneous normals with
 * third coordinate 1 grow without bound (BSK04 section 3). */
static const double least_cosine = 0.25;
/* Slope of the normal at the centre, which lines may have cut away far from all samples: its cosine
 * stays twice above the least of spec 3.5. */
static const double greatest_slope = 9.9;
/* Change of slope that a field may always make over its region. */
static const double tame_slope = 0.05;
/* Steps in which the surroundings grow. */
static const double ahead = 1.6;

/* Corners of a region's outline, and its rings. */
enum { OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES, RINGS = 2 };
static const double rings[RINGS] = {1, 0.6};

void psplat_growth_free(psplat_growth *growth) {
    psplat_neighborhood_free(&growth->near);
    free(growth->uvh);
    free(growth->chosen);
    free(growth->next);
    free(growth->plane);
    free(growth->local);
    free(growth->segments);
    *growth = (psplat_growth){0};
}

psplat_result psplat_growth_each(size_t count,
                                 psplat_result (*visit)(void *user, size_t index,
                                                        psplat_growth *growth),
                                 void *user) {
    long end = (long)count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        psplat_growth growth = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 4)
#endif
        for (long i = 0; i < end; ++i) failed |= visit(user, (size_t)i, &growth) != PSPLAT_OK;
        psplat_growth_free(&growth);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* ---- gathering ----------------------------------------------------------------------------- */

static int reserve_samples(psplat_growth *g) {
    size_t count = g->near.count + 1;
    if (count <= g->capacity) return 1;
    size_t capacity = 2 * count + 256;
    free(g->uvh);
    free(g->chosen);
    free(g->next);
    free(g->plane);
    free(g->local);
    g->uvh = malloc(capacity * sizeof *g->uvh);
    g->chosen = malloc(capacity * sizeof *g->chosen);
    g->next = malloc(capacity * sizeof *g->next);
    g->plane = malloc(capacity * sizeof *g->plane);
    g->local = malloc(capacity * sizeof *g->local);
    g->capacity = g->uvh && g->chosen && g->next && g->plane && g->local ? capacity : 0;
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

int psplat_trial_gather(psplat_seedling *s, double reach) {
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

void psplat_trial_turn(psplat_seedling *s, const double n[3], const double u[3], double stretch) {
    double v[3];
    cross3(v, n, u);
    memcpy(s->metric.rows[0], u, sizeof s->metric.rows[0]);
    memcpy(s->metric.rows[2], n, sizeof s->metric.rows[2]);
    for (int k = 0; k < 3; ++k) s->metric.rows[1][k] = v[k] / stretch;
    s->gathered = 0;
}

/* Reach of a region from the metric's centre. */
static double region_reach(const psplat_seedling *s, const psplat_region *region) {
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

int psplat_trial_surround(psplat_seedling *s, const psplat_region *region) {
    double reach = region_reach(s, region) + PSPLAT_GREATEST_GAP * s->samples->spacing;
    if (!psplat_trial_gather(s, reach)) return 0;
    s->relevant = psplat_neighborhood_within(&s->growth->near, reach);
    return 1;
}

psplat_seedling psplat_trial_at(const psplat_surface *surface, const psplat_samples *samples,
                                const psplat_limits *limits, psplat_growth *growth,
                                const psplat_region *region, uint32_t triangle) {
    psplat_seedling s = {.surface = surface,
                         .samples = samples,
                         .limits = limits,
                         .growth = growth,
                         .seed = PSPLAT_NONE,
                         .triangle = triangle};
    memcpy(s.metric.center, region->center, sizeof s.metric.center);
    psplat_trial_turn(&s, region->n, region->u, 1);
    return s;
}

/* ---- lines --------------------------------------------------------------------------------- */

size_t psplat_trial_segments(const psplat_seedling *s, const psplat_region *region,
                             double *height) {
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

size_t psplat_trial_cover(psplat_seedling *s, const psplat_region *region) {
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
static void local_normals(const psplat_seedling *s, const psplat_region *region, size_t count) {
    psplat_growth *g = s->growth;
    const float *turned = s->samples->turned;
    for (size_t i = 0; i < count; ++i) {
        const psplat_near_sample *sample = &g->near.samples[g->chosen[i]];
        double n[3];
        for (size_t k = 0; k < 3; ++k)
            n[k] = turned ? (double)turned[3 * (size_t)sample->index + k] : sample->n[k];
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

int psplat_trial_field(const psplat_seedling *s, const psplat_region *region, size_t count,
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
    if (s->limits->precision) psplat_code_field(s->limits->precision, field);
    if (hypot(field[0], field[1]) > greatest_slope) return 0;
    return s->limits->normal_tolerance <= 0 ||
           field_error(g, region, count, field) <= s->limits->normal_tolerance;
}

/* ---- outline ------------------------------------------------------------------------------- */

/* Whether a point (relative to the neighbourhood's origin) lies near the surface: near enough to
 * the tangent plane of a sample, and above or below its surroundings. */
static int near_surface(const psplat_seedling *s, const double q[3]) {
    const psplat_neighborhood *n = &s->growth->near;
    double tolerance2 = s->limits->tolerance * s->limits->tolerance;
    double gap = PSPLAT_GREATEST_GAP * s->samples->spacing, gap2 = gap * gap;
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

int psplat_trial_outline_near(const psplat_seedling *s, const psplat_region *region) {
    double points[RINGS * OUTLINE][3];
    size_t count = outline_points(region, s->growth->near.origin, points);
    for (size_t i = 0; i < count; ++i)
        if (!near_surface(s, points[i])) return 0;
    return 1;
}

/* Puts growth->chosen on record as what the candidate covers. */
static void record(psplat_seedling *s, size_t count, psplat_candidate *candidate) {
    const psplat_growth *g = s->growth;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) {
        s->failed = 1;
        return;
    }
    for (size_t i = 0; i < count; ++i) covered[i] = g->near.samples[g->chosen[i]].index;
    candidate->covered = covered;
    candidate->covered_count = count;
}

void psplat_trial_adopt(psplat_seedling *s, const psplat_region *region, const double field[5],
                        size_t count, psplat_candidate *candidate) {
    const psplat_growth *g = s->growth;
    if (!s->recorded) record(s, count, candidate);
    if (s->failed) return;
    candidate->deviation = 0;
    for (size_t i = 0; i < count; ++i)
        candidate->deviation = max2(candidate->deviation, fabs(g->uvh[g->chosen[i]][2]));
    candidate->region = *region;
    candidate->triangle = s->triangle;
    memcpy(candidate->field, field, sizeof candidate->field);
}

void psplat_trial_order_axes(psplat_region *region) {
    if (region->radius[0] >= region->radius[1]) return;
    double radius = region->radius[0];
    region->radius[0] = region->radius[1], region->radius[1] = radius;
    for (int k = 0; k < 3; ++k) {
        double u = region->u[k];
        region->u[k] = region->v[k], region->v[k] = -u;
    }
}

static double triangle_distance2(const psplat_seedling *s, uint32_t triangle, const double q[3]) {
    const psplat_mesh *mesh = s->surface->mesh;
    const uint32_t *vertices = mesh->triangles + 3 * (size_t)triangle;
    return point_triangle_distance2(q, mesh->positions + 3 * (size_t)vertices[0],
                                    mesh->positions + 3 * (size_t)vertices[1],
                                    mesh->positions + 3 * (size_t)vertices[2]);
}

/* Whether a sample connected with the seed is about as near to a point as it must be where the
 * surface is within the tolerance; what else the point may be near to does not count. */
static int near_sample(const psplat_seedling *s, const double q[3]) {
    double most = s->limits->tolerance + PSPLAT_GREATEST_GAP * s->samples->spacing;
    for (size_t i = 0; i < s->relevant; ++i) {
        double d[3];
        sub3(d, q, s->growth->near.samples[i].p);
        if (dot3(d, d) <= most * most) return 1;
    }
    return 0;
}

/* ---- near the mesh ------------------------------------------------------------------------- */

/* The samples around a region in cells of its parameters, to find one near a point of it. */
enum { CELLS = 16 };
typedef struct cells {
    const psplat_region *region;
    uint32_t heads[CELLS * CELLS];
    const uint32_t *nexts;  /* of each sample, in its cell; PSPLAT_NONE at the end */
    const double (*uvh)[3]; /* of each sample */
} cells;

static int cell_along(double x) {
    return (int)floor((x + 1) * (CELLS / 2.0));
}

static void fill_cells(const psplat_seedling *s, const psplat_region *region, cells *c) {
    psplat_growth *g = s->growth;
    double center[3];
    sub3(center, region->center, g->near.origin);
    *c = (cells){.region = region, .nexts = g->next, .uvh = (const double(*)[3])g->uvh};
    memset(c->heads, 0xff, sizeof c->heads);
    for (uint32_t i = (uint32_t)s->relevant; i-- > 0;) { /* the nearest of the seed come first */
        double d[3], *uvh = g->uvh[i];
        sub3(d, g->near.samples[i].p, center);
        uvh[0] = dot3(d, region->u) / region->radius[0];
        uvh[1] = dot3(d, region->v) / region->radius[1];
        uvh[2] = dot3(d, region->n);
        if (!(fabs(uvh[0]) < 1 && fabs(uvh[1]) < 1)) continue;
        uint32_t *head = &c->heads[cell_along(uvh[1]) * CELLS + cell_along(uvh[0])];
        g->next[i] = *head;
        *head = i;
    }
}

/* Of the samples in the cells around a point, the nearest; PSPLAT_NONE where there is none. */
static uint32_t nearest_sample(const cells *c, const double uv[2], double *distance2) {
    uint32_t nearest = PSPLAT_NONE;
    int column = cell_along(uv[0]), row = cell_along(uv[1]);
    *distance2 = HUGE_VAL;
    for (int y = row > 0 ? row - 1 : 0; y <= row + 1 && y < CELLS; ++y)
        for (int x = column > 0 ? column - 1 : 0; x <= column + 1 && x < CELLS; ++x)
            for (uint32_t i = c->heads[y * CELLS + x]; i != PSPLAT_NONE; i = c->nexts[i]) {
                double du = (c->uvh[i][0] - uv[0]) * c->region->radius[0];
                double dv = (c->uvh[i][1] - uv[1]) * c->region->radius[1], h = c->uvh[i][2];
                double d2 = du * du + dv * dv + h * h;
                if (d2 < *distance2) *distance2 = d2, nearest = i;
            }
    return nearest;
}

/* Whether the triangle of a sample or one next to it is within the tolerance of a point. */
static int near_triangles(const psplat_seedling *s, uint32_t sample, const double q[3]) {
    double tolerance2 = s->limits->tolerance * s->limits->tolerance;
    uint32_t triangle = s->samples->triangles[sample];
    if (triangle_distance2(s, triangle, q) <= tolerance2) return 1;
    for (size_t k = 0; k < 3; ++k) {
        uint32_t neighbor = s->surface->neighbors[3 * (size_t)triangle + k];
        if (neighbor != PSPLAT_NONE && triangle_distance2(s, neighbor, q) <= tolerance2) return 1;
    }
    return 0;
}

int psplat_trial_near_mesh(psplat_seedling *s, const psplat_region *region) {
    double points[PSPLAT_REGION_POINTS][3], tolerance = s->limits->tolerance;
    size_t count = psplat_region_points(region, points);
    cells c;
    fill_cells(s, region, &c);
    for (size_t i = 0; i < count; ++i) {
        double uvh[3], q[3], distance2;
        int near;
        psplat_region_local(region, points[i], uvh);
        uint32_t nearest = nearest_sample(&c, uvh, &distance2);
        if (distance2 <= tolerance * tolerance) continue;
        if (nearest != PSPLAT_NONE &&
            near_triangles(s, s->growth->near.samples[nearest].index, points[i]))
            continue;
        sub3(q, points[i], s->growth->near.origin);
        if (!s->limits->distance || !near_sample(s, q)) return 0;
        if (psplat_distance_within(s->limits->distance, points[i], 1, tolerance, &near))
            s->failed = 1;
        if (!near || s->failed) return 0;
    }
    return 1;
}

/* ---- accepting ----------------------------------------------------------------------------- */

static int still_covers(const psplat_seedling *s, const psplat_region *region,
                        const psplat_candidate *candidate) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double uvh[3];
        psplat_region_local(region, s->samples->positions + 3 * (size_t)candidate->covered[i], uvh);
        if (fabs(uvh[2]) > s->limits->tolerance || !psplat_region_contains(region, uvh, 1, 1e-7))
            return 0;
    }
    return 1;
}

int psplat_trial_accept(psplat_seedling *s, psplat_region *region, double least_area,
                        psplat_candidate *candidate) {
    double height, seed[3], field[5];
    region->line_count = 0;
    if (!psplat_trial_surround(s, region)) return 0;
    size_t segments = psplat_trial_segments(s, region, &height);
    psplat_region_local(region, s->samples->positions + 3 * (size_t)candidate->covered[0], seed);
    if (height > s->limits->crease_tolerance) return 0;
    if (!psplat_clip_choose(region, s->growth->segments, segments, seed, s->limits->crease_slack))
        return 0;
    for (uint32_t i = 0; s->limits->precision && i < region->line_count; ++i)
        psplat_code_line(s->limits->precision, region->lines[i]);
    int large = psplat_region_area(region) >= least_area;
    if (!large && s->recorded) return 0;
    if (!still_covers(s, region, candidate) || !psplat_trial_near_mesh(s, region)) return 0;
    size_t count = psplat_trial_cover(s, region);
    if (!count || (!large && count <= candidate->covered_count)) return 0;
    if (!psplat_trial_field(s, region, count, field) || !psplat_trial_tint(s, count)) return 0;
    psplat_trial_adopt(s, region, field, count, candidate);
    return 1;
}
