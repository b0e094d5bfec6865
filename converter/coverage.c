/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * coverage.c - stored splats, ready to be measured, and the samples that they leave open.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Single precision may cut this much of a unit ellipse. */
static const double float_slack = 2e-6;
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
    double inset = measured->margin / region->radius[1];
    double scale = inset > 0 ? max2(1 - inset, 0.5) : 1 + float_slack;
    return fabs(uvh[2]) <= measured->tolerance && dot3(normal, region->n) > 0 &&
           psplat_region_contains(region, uvh, scale, float_slack);
}

/* ---- samples that are open ------------------------------------------------------------------ */

/* A sample and what looking for splats around it found. */
typedef struct probe {
    const psplat_measured *measured;
    double point[3], normal[3];
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
                                     double tolerance, double margin, uint8_t *uncovered,
                                     size_t *count) {
    psplat_measured measured;
    psplat_result result = psplat_measured_create(splats, tolerance, tolerance, &measured);
    if (result) return result;
    measured.margin = margin;
    *count = mark_samples(samples, &measured, is_uncovered, uncovered);
    psplat_measured_free(&measured);
    return PSPLAT_OK;
}
