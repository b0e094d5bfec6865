/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * verify.c - the splats as stored, measured against the surface on samples of its own: two-sided
 * distance, coverage, and the normals that blending gives.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { SAMPLES_PER_SPLAT = 200, LEAST_SAMPLES = 20000, MOST_SAMPLES = 1000000, CORNERS = 68 };

/* Single precision may cut this much of a unit ellipse. */
static const double float_slack = 2e-6;
/* Splats seen more edge-on than this do not show. */
static const double least_cosine = 0.1;
/* How far along a slanted view a splat still stands for the surface, in tolerances. */
static const double sight_reach = 3;

/* Distance in the plane from a point outside a convex polygon, in units of length. */
static double polygon_distance(const psplat_region *region, double (*polygon)[2], size_t count,
                               const double uv[2]) {
    double least = HUGE_VAL, p[2] = {uv[0] * region->radius[0], uv[1] * region->radius[1]};
    for (size_t i = 0; i < count; ++i) {
        const double *from = polygon[i], *to = polygon[i + 1 < count ? i + 1 : 0];
        double a[2] = {from[0] * region->radius[0], from[1] * region->radius[1]};
        double d[2] = {to[0] * region->radius[0] - a[0], to[1] * region->radius[1] - a[1]};
        double length = d[0] * d[0] + d[1] * d[1];
        double t = length > 0 ? ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / length : 0;
        t = min2(max2(t, 0), 1);
        least = min2(least, hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1]));
    }
    return least;
}

/* The lesser of `distance` and that from the point to the splat; uvh: the point's parameters. */
static double nearer_distance(const psplat_region *region, const double uvh[3], double distance) {
    if (fabs(uvh[2]) >= distance) return distance;
    if (psplat_region_contains(region, uvh, 1 + float_slack, float_slack)) return fabs(uvh[2]);
    double polygon[CORNERS][2];
    size_t count = psplat_region_polygon(region, 1, polygon, CORNERS);
    if (!count) return distance;
    return min2(distance, hypot(uvh[2], polygon_distance(region, polygon, count, uvh)));
}

/* ---- splats, ready to be measured --------------------------------------------------------- */

typedef struct measured_splats {
    const psplat_splats *splats;
    psplat_region *regions;
    psplat_locator *locator;
    double tolerance;
} measured_splats;

static void measured_free(measured_splats *measured) {
    psplat_locator_destroy(measured->locator);
    free(measured->regions);
    *measured = (measured_splats){0};
}

/* reach: how far from a point its splats may be. */
static int measured_create(measured_splats *measured, const psplat_splats *splats, double tolerance,
                           double reach) {
    *measured = (measured_splats){.splats = splats, .tolerance = tolerance * (1 + 1e-6)};
    measured->regions = psplat_splat_regions(splats);
    if (measured->regions)
        measured->locator = psplat_locator_create(measured->regions, splats->count, reach);
    if (measured->locator) return 1;
    measured_free(measured);
    return 0;
}

/* ---- one sample ---------------------------------------------------------------------------- */

/* What the splats near one surface point make of it. */
typedef struct probe {
    const measured_splats *measured;
    double point[3], normal[3];
    double distance; /* to the nearest splat */
    int covered;
    double blended[3], constant[3]; /* weighted normals, with and without gradients */
} probe;

static probe probe_at(const psplat_samples *samples, size_t i, const measured_splats *measured) {
    probe p = {.measured = measured, .distance = HUGE_VAL};
    memcpy(p.point, samples->positions + 3 * i, sizeof p.point);
    for (size_t k = 0; k < 3; ++k) p.normal[k] = (double)samples->normals[3 * i + k];
    return p;
}

/* A splat of the other side of a thin part does not cover this one. */
static int covers(const probe *p, const psplat_region *region, const double uvh[3]) {
    return fabs(uvh[2]) <= p->measured->tolerance && dot3(p->normal, region->n) > 0 &&
           psplat_region_contains(region, uvh, 1 + float_slack, float_slack);
}

static int visit_cover(void *user, uint32_t index) {
    probe *p = user;
    double uvh[3];
    const psplat_region *region = &p->measured->regions[index];
    psplat_region_local(region, p->point, uvh);
    return p->covered = covers(p, region, uvh);
}

/* Adds a splat's normal as seen along the surface's own normal, which is what a viewer facing the
 * surface there gets (spec 5.4). */
static void blend_normal(probe *p, const psplat_splat *splat, const psplat_region *region) {
    double cosine = dot3(p->normal, region->n), d[3], q[3], uvh[3];
    if (cosine < least_cosine) return;
    sub3(d, region->center, p->point);
    double t = dot3(d, region->n) / cosine;
    if (fabs(t) > 2 * p->measured->tolerance) return;
    memcpy(q, p->point, sizeof q);
    mad3(q, t, p->normal);
    psplat_region_local(region, q, uvh);
    if (!psplat_region_contains(region, uvh, 1, 0)) return;
    const psplat_kernel *kernel = &p->measured->splats->kernel;
    double r = hypot(uvh[0], uvh[1]);
    double weight = exp(-(double)kernel->sharpness * pow(r, (double)kernel->exponent));
    double center[3] = {(double)splat->normal[0], (double)splat->normal[1],
                        (double)splat->normal[2]};
    mad3(p->constant, weight / dot3(center, region->n), center);
    mad3(p->blended, weight / dot3(center, region->n), center);
    double field[5] = {0, 0, (double)splat->gradient[0], (double)splat->gradient[1],
                       (double)splat->gradient[2]};
    double change[2];
    psplat_fit_normal_at(field, region->radius, uvh, change);
    mad3(p->blended, weight * change[0], region->u);
    mad3(p->blended, weight * change[1], region->v);
}

static int visit_splat(void *user, uint32_t index) {
    probe *p = user;
    const psplat_region *region = &p->measured->regions[index];
    double uvh[3];
    psplat_region_local(region, p->point, uvh);
    p->distance = nearer_distance(region, uvh, p->distance);
    p->covered |= covers(p, region, uvh);
    blend_normal(p, &p->measured->splats->splats[index], region);
    return 0;
}

static void probe_sample(probe *p) {
    const measured_splats *m = p->measured;
    psplat_locator_visit(m->locator, p->point, visit_splat, p);
    if (p->distance <= m->tolerance) return;
    /* Nothing within reach: the sample is a hole, and its distance wants the whole set. */
    for (size_t s = 0; s < m->splats->count; ++s) {
        double uvh[3];
        psplat_region_local(&m->regions[s], p->point, uvh);
        p->distance = nearer_distance(&m->regions[s], uvh, p->distance);
    }
}

/* Marks the samples of which is_open says so. */
static size_t mark_samples(const psplat_samples *samples, const measured_splats *measured,
                           int (*is_open)(probe *p), uint8_t *marks) {
    size_t total = 0;
    long samples_count = (long)samples->count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(static) reduction(+ : total)
#endif
    for (long i = 0; i < samples_count; ++i) {
        probe p = probe_at(samples, (size_t)i, measured);
        marks[i] = (uint8_t)is_open(&p);
        total += marks[i];
    }
    return total;
}

static int is_uncovered(probe *p) {
    psplat_locator_visit(p->measured->locator, p->point, visit_cover, p);
    return !p->covered;
}

psplat_result psplat_verify_coverage(const psplat_samples *samples, const psplat_splats *splats,
                                     double tolerance, uint8_t *uncovered, size_t *count) {
    measured_splats measured;
    if (!measured_create(&measured, splats, tolerance, tolerance)) return PSPLAT_ERROR_MEMORY;
    *count = mark_samples(samples, &measured, is_uncovered, uncovered);
    measured_free(&measured);
    return PSPLAT_OK;
}

/* ---- slanted views -------------------------------------------------------------------------- */

enum { VIEWS = 6 };

/* A view through a surface point. */
typedef struct sight {
    const measured_splats *measured;
    double point[3], to_eye[3];
    int met;
} sight;

static int visit_sight(void *user, uint32_t index) {
    sight *s = user;
    const psplat_region *region = &s->measured->regions[index];
    double cosine = dot3(s->to_eye, region->n), d[3], q[3], uvh[3];
    if (cosine < least_cosine) return 0;
    sub3(d, region->center, s->point);
    double t = dot3(d, region->n) / cosine;
    if (fabs(t) > sight_reach * s->measured->tolerance) return 0;
    memcpy(q, s->point, sizeof q);
    mad3(q, t, s->to_eye);
    psplat_region_local(region, q, uvh);
    return s->met = psplat_region_contains(region, uvh, 1, float_slack);
}

/* Whether some view 60 degrees from the normal meets no splat near the sample. */
static int lets_pass(probe *p) {
    double u[3], v[3];
    perpendicular3(u, p->normal);
    cross3(v, p->normal, u);
    for (int view = 0; view < VIEWS; ++view) {
        double angle = view * (6.283185307179586 / VIEWS), side = sqrt(0.75);
        sight s = {.measured = p->measured};
        memcpy(s.point, p->point, sizeof s.point);
        mad3(s.to_eye, 0.5, p->normal);
        mad3(s.to_eye, side * cos(angle), u);
        mad3(s.to_eye, side * sin(angle), v);
        psplat_locator_visit(p->measured->locator, p->point, visit_sight, &s);
        if (!s.met) return 1;
    }
    return 0;
}

psplat_result psplat_verify_sight(const psplat_samples *samples, const psplat_splats *splats,
                                  double tolerance, uint8_t *open, size_t *count) {
    measured_splats measured;
    if (!measured_create(&measured, splats, tolerance, sight_reach * tolerance))
        return PSPLAT_ERROR_MEMORY;
    *count = mark_samples(samples, &measured, lets_pass, open);
    measured_free(&measured);
    return PSPLAT_OK;
}

/* ---- surface to splats ---------------------------------------------------------------------- */

static double angle_degrees(const double a[3], const double b[3]) {
    double c[3];
    cross3(c, a, b);
    return atan2(length3(c), dot3(a, b)) * (180 / 3.141592653589793);
}

/* Per-sample results, filled in parallel and summed in order, so that sums do not depend on the
 * number of threads. */
typedef struct measurements {
    double *distances, *angles, *constant_angles;
    uint8_t *covered;
    uint8_t *blended; /* whether a splat shows along the normal */
} measurements;

static void measure_sample(const psplat_samples *samples, size_t i, const measured_splats *measured,
                           measurements *m) {
    probe p = probe_at(samples, i, measured);
    probe_sample(&p);
    m->distances[i] = p.distance;
    m->covered[i] = (uint8_t)p.covered;
    m->blended[i] = dot3(p.blended, p.blended) > 0;
    m->angles[i] = angle_degrees(p.blended, p.normal);
    m->constant_angles[i] = angle_degrees(p.constant, p.normal);
}

static int compare_doubles(const void *left, const void *right) {
    const double *a = left, *b = right;
    return *a < *b ? -1 : *a > *b;
}

static void summarise(measurements *m, size_t count, double diagonal, psplat_report *report) {
    double squares = 0, greatest = 0, angles = 0, constant_angles = 0;
    size_t covered = 0, blended = 0;
    for (size_t i = 0; i < count; ++i) {
        squares += m->distances[i] * m->distances[i];
        greatest = max2(greatest, m->distances[i]);
        covered += m->covered[i];
        if (!m->blended[i]) continue;
        angles += m->angles[i] * m->angles[i];
        constant_angles += m->constant_angles[i] * m->constant_angles[i];
        m->angles[blended++] = m->angles[i];
    }
    qsort(m->angles, blended, sizeof(double), compare_doubles);
    double some = blended ? (double)blended : 1;
    report->verification_samples = count;
    report->uncovered_samples = count - covered;
    report->max_distance_surface_percent = 100 * greatest / diagonal;
    report->rms_distance_percent = 100 * sqrt(squares / (double)count) / diagonal;
    report->rms_normal_degrees = sqrt(angles / some);
    report->rms_normal_constant_degrees = sqrt(constant_angles / some);
    report->p95_normal_degrees = blended ? m->angles[(blended - 1) * 95 / 100] : 0;
}

static psplat_result measure_surface(const psplat_samples *samples, const measured_splats *measured,
                                     double diagonal, psplat_report *report) {
    size_t count = samples->count;
    measurements m = {malloc(count * sizeof(double)), malloc(count * sizeof(double)),
                      malloc(count * sizeof(double)), malloc(count), malloc(count)};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (m.distances && m.angles && m.constant_angles && m.covered && m.blended) {
        long end = (long)count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(static)
#endif
        for (long i = 0; i < end; ++i) measure_sample(samples, (size_t)i, measured, &m);
        summarise(&m, count, diagonal, report);
        result = PSPLAT_OK;
    }
    free(m.distances);
    free(m.angles);
    free(m.constant_angles);
    free(m.covered);
    free(m.blended);
    return result;
}

/* ---- splats to surface ---------------------------------------------------------------------- */

/* Points of a splat: the corners of its outline, the same halfway in, and its middle. */
static size_t region_points(const psplat_region *region, double (*points)[3]) {
    double polygon[CORNERS][2], middle[2] = {0, 0};
    size_t count = psplat_region_polygon(region, 1, polygon, CORNERS);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    for (size_t i = 0; i < 2 * count + 1; ++i) {
        double t = i < count ? 1 : i < 2 * count ? 0.5 : 0;
        const double *corner = polygon[i % count];
        memcpy(points[i], region->center, sizeof points[i]);
        mad3(points[i], (middle[0] + t * (corner[0] - middle[0])) * region->radius[0], region->u);
        mad3(points[i], (middle[1] + t * (corner[1] - middle[1])) * region->radius[1], region->v);
    }
    return count ? 2 * count + 1 : 0;
}

static psplat_result measure_splats(const psplat_mesh *mesh, const measured_splats *measured,
                                    double *greatest) {
    psplat_distance *distance = psplat_distance_create(mesh);
    if (!distance) return PSPLAT_ERROR_MEMORY;
    long end = (long)measured->splats->count;
    double most = 0;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 16) reduction(max : most) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) {
        double points[2 * CORNERS + 1][3], distances[2 * CORNERS + 1];
        size_t count = region_points(&measured->regions[i], points);
        failed |= psplat_distance_query(distance, &points[0][0], count, distances) != PSPLAT_OK;
        for (size_t k = 0; k < count && !failed; ++k) most = max2(most, distances[k]);
    }
    psplat_distance_destroy(distance);
    *greatest = most;
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

psplat_result psplat_verify(const psplat_surface *surface, const psplat_splats *splats,
                            double tolerance, uint64_t seed, psplat_report *report,
                            psplat_error *error) {
    size_t wanted = splats->count * SAMPLES_PER_SPLAT;
    if (wanted < LEAST_SAMPLES) wanted = LEAST_SAMPLES;
    if (wanted > MOST_SAMPLES) wanted = MOST_SAMPLES;
    psplat_samples samples;
    psplat_result result = psplat_samples_draw_uniform(surface, wanted, seed, &samples, error);
    if (result) return result;
    double greatest = 0;
    measured_splats measured = {0};
    if (!measured_create(&measured, splats, tolerance, tolerance)) result = PSPLAT_ERROR_MEMORY;
    if (!result) result = measure_surface(&samples, &measured, surface->diagonal, report);
    if (!result) result = measure_splats(surface->mesh, &measured, &greatest);
    measured_free(&measured);
    psplat_samples_free(&samples);
    if (result) return psplat_fail(error, result, 0, "out of memory while verifying");
    report->max_distance_splats_percent = 100 * greatest / surface->diagonal;
    report->max_distance_percent =
        max2(report->max_distance_surface_percent, report->max_distance_splats_percent);
    return PSPLAT_OK;
}
