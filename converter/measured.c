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
    free(measured->fields);
    *measured = (psplat_measured){0};
}

void psplat_field_of(const psplat_splat *splat, const psplat_region *region, psplat_field *field) {
    double center[3], gradient[3], ratio = region->radius[1] / region->radius[0];
    for (int k = 0; k < 3; ++k) center[k] = (double)splat->normal[k];
    for (int k = 0; k < 3; ++k) gradient[k] = (double)splat->gradient[k];
    memset(field->normals, 0, sizeof field->normals);
    mad3(field->normals[0], 1 / dot3(center, region->n), center);
    mad3(field->normals[1], gradient[0], region->u);
    mad3(field->normals[1], gradient[2], region->v);
    mad3(field->normals[2], gradient[2] * ratio, region->u);
    mad3(field->normals[2], gradient[1], region->v);
}

/* What the splat's fragments have as colour; finish may be NULL. */
static void color_field(const psplat_splat *splat, const psplat_finish *finish,
                        const psplat_material *material, psplat_field *field) {
    for (int k = 0; k < 3; ++k) {
        double factor = material ? (double)material->base_color[k] : 1;
        field->factor[k] = factor;
        field->colors[0][k] = factor * (double)splat->color[k];
        field->colors[1][k] = finish ? factor * (double)finish->color_u[k] : 0;
        field->colors[2][k] = finish ? factor * (double)finish->color_v[k] : 0;
    }
}

void psplat_field_normal(const psplat_field *field, const double uv[2], double normal[3]) {
    memcpy(normal, field->normals[0], 3 * sizeof(double));
    mad3(normal, uv[0], field->normals[1]);
    mad3(normal, uv[1], field->normals[2]);
}

psplat_result psplat_measured_create(const psplat_splats *splats, double tolerance, double reach,
                                     psplat_measured *measured) {
    *measured = (psplat_measured){.count = splats->count, .tolerance = tolerance * (1 + 1e-6)};
    measured->regions = psplat_splat_regions(splats);
    measured->fields = malloc((splats->count + 1) * sizeof *measured->fields);
    if (measured->regions && measured->fields)
        measured->locator = psplat_locator_create(measured->regions, splats->count, reach);
    if (!measured->locator) {
        psplat_measured_free(measured);
        return PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < splats->count; ++i) {
        psplat_field_of(&splats->splats[i], &measured->regions[i], &measured->fields[i]);
        measured->fields[i].kernel = splats->kernel;
        measured->fields[i].depth = HUGE_VAL;
    }
    for (size_t run = 0, i = 0; run < splats->run_count; ++run) {
        uint32_t material = splats->runs[run].material;
        for (size_t end = i + splats->runs[run].count; i < end && i < splats->count; ++i)
            color_field(&splats->splats[i], splats->finishes ? &splats->finishes[i] : NULL,
                        material < splats->material_count ? &splats->materials[material] : NULL,
                        &measured->fields[i]);
    }
    return PSPLAT_OK;
}

int psplat_measured_covers(const psplat_measured *measured, uint32_t splat, const double normal[3],
                           const double uvh[3]) {
    const psplat_region *region = &measured->regions[splat];
    return fabs(uvh[2]) <= measured->tolerance && dot3(normal, region->n) > 0 &&
           psplat_region_contains(region, uvh, 1 + float_slack, float_slack);
}
