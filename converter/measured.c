/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * measured.c - stored splats, ready to be measured.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Single precision may cut this much of a unit ellipse. */
static const double float_slack = 2e-6;

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
