/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * coverage.c - stored splats, ready to be measured, and what they leave open: samples that no splat
 * covers, and samples that a slanted view passes by.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { VIEWS = 6 };

/* Single precision may cut this much of a unit ellipse. */
static const double float_slack = 2e-6;
/* Splats seen more edge-on than this do not show. */
static const double least_cosine = 0.1;
/* How far along a slanted view a splat still stands for the surface, in tolerances. */
static const double sight_reach = 3;

/* ---- splats, ready to be measured --------------------------------------------------------- */

void psplat_measured_free(psplat_measured *measured) {
    psplat_locator_destroy(measured->locator);
    free(measured->regions);
    *measured = (psplat_measured){0};
}

psplat_result psplat_measured_create(const psplat_splats *splats, double tolerance, double reach,
                                     psplat_measured *measured) {
    *measured = (psplat_measured){.splats = splats, .tolerance = tolerance * (1 + 1e-6)};
    measured->regions = psplat_splat_regions(splats);
    if (measured->regions)
        measured->locator = psplat_locator_create(measured->regions, splats->count, reach);
    if (measured->locator) return PSPLAT_OK;
    psplat_measured_free(measured);
    return PSPLAT_ERROR_MEMORY;
}

int psplat_measured_covers(const psplat_measured *measured, uint32_t splat, const double normal[3],
                           const double uvh[3]) {
    const psplat_region *region = &measured->regions[splat];
    return fabs(uvh[2]) <= measured->tolerance && dot3(normal, region->n) > 0 &&
           psplat_region_contains(region, uvh, 1 + float_slack, float_slack);
}

/* ---- samples that are open ------------------------------------------------------------------ */

/* A sample and what looking for splats around it found. */
typedef struct probe {
    const psplat_measured *measured;
    double point[3], normal[3];
    double to_eye[3];
    int met;
} probe;

static probe probe_at(const psplat_samples *samples, size_t i, const psplat_measured *measured) {
    probe p = {.measured = measured};
    memcpy(p.point, samples->positions + 3 * i, sizeof p.point);
    for (size_t k = 0; k < 3; ++k) p.normal[k] = (double)samples->normals[3 * i + k];
    return p;
}

/* Marks the samples of which is_open says so. */
static size_t mark_samples(const psplat_samples *samples, const psplat_measured *measured,
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

static int visit_cover(void *user, uint32_t index) {
    probe *p = user;
    double uvh[3];
    psplat_region_local(&p->measured->regions[index], p->point, uvh);
    return p->met = psplat_measured_covers(p->measured, index, p->normal, uvh);
}

static int is_uncovered(probe *p) {
    psplat_locator_visit(p->measured->locator, p->point, visit_cover, p);
    return !p->met;
}

psplat_result psplat_verify_coverage(const psplat_samples *samples, const psplat_splats *splats,
                                     double tolerance, uint8_t *uncovered, size_t *count) {
    psplat_measured measured;
    psplat_result result = psplat_measured_create(splats, tolerance, tolerance, &measured);
    if (result) return result;
    *count = mark_samples(samples, &measured, is_uncovered, uncovered);
    psplat_measured_free(&measured);
    return PSPLAT_OK;
}

/* ---- slanted views -------------------------------------------------------------------------- */

static int visit_sight(void *user, uint32_t index) {
    probe *p = user;
    const psplat_region *region = &p->measured->regions[index];
    double cosine = dot3(p->to_eye, region->n), d[3], q[3], uvh[3];
    if (cosine < least_cosine) return 0;
    sub3(d, region->center, p->point);
    double t = dot3(d, region->n) / cosine;
    if (fabs(t) > sight_reach * p->measured->tolerance) return 0;
    memcpy(q, p->point, sizeof q);
    mad3(q, t, p->to_eye);
    psplat_region_local(region, q, uvh);
    return p->met = psplat_region_contains(region, uvh, 1, float_slack);
}

/* Whether some view 60 degrees from the normal meets no splat near the sample. */
static int lets_pass(probe *p) {
    double u[3], v[3];
    perpendicular3(u, p->normal);
    cross3(v, p->normal, u);
    for (int view = 0; view < VIEWS; ++view) {
        double angle = view * (6.283185307179586 / VIEWS), side = sqrt(0.75);
        for (int k = 0; k < 3; ++k) p->to_eye[k] = 0.5 * p->normal[k];
        mad3(p->to_eye, side * cos(angle), u);
        mad3(p->to_eye, side * sin(angle), v);
        p->met = 0;
        psplat_locator_visit(p->measured->locator, p->point, visit_sight, p);
        if (!p->met) return 1;
    }
    return 0;
}

psplat_result psplat_verify_sight(const psplat_samples *samples, const psplat_splats *splats,
                                  double tolerance, uint8_t *open, size_t *count) {
    psplat_measured measured;
    psplat_result result =
        psplat_measured_create(splats, tolerance, sight_reach * tolerance, &measured);
    if (result) return result;
    *count = mark_samples(samples, &measured, lets_pass, open);
    psplat_measured_free(&measured);
    return PSPLAT_OK;
}
