/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * measured_splats.c - stored splats prepared for measurements: regions, blend fields and a tree.
 */
#include "measure/measured_splats.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The width, in a region's parameters (u, v), that rounding to single precision may cut off. */
static const double rounding_slack = 2e-6;

void psplat_measured_splats_free(psplat_measured_splats *measured) {
    psplat_region_tree_destroy(measured->region_tree);
    free(measured->regions);
    free(measured->fields);
    free(measured->materials);
    free(measured->triangles);
    *measured = (psplat_measured_splats){0};
}

void psplat_blend_field_of(const psplat_splat *splat, const psplat_region *region,
                           psplat_blend_field *field) {
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

/* Sets what a splat's fragments have besides colours. finish and material may be NULL. */
static void set_finish(const psplat_finish *finish, const psplat_material *material,
                       psplat_blend_field *field) {
    static const psplat_finish neutral = {.roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    const psplat_finish *f = finish ? finish : &neutral;
    memset(field->finish, 0, sizeof field->finish);
    if (!material || material->unlit) return;
    for (int k = 0; k < 3; ++k)
        field->finish[k] = (double)material->emissive[k] * (double)f->emissive[k];
    field->finish[3] = (double)material->roughness * (double)f->roughness;
    field->finish[4] = (double)material->metallic * (double)f->metallic;
}

/* Sets the colours of a splat's fragments. finish and material may be NULL. */
static void set_colors(const float color[4], const psplat_finish *finish,
                       const psplat_material *material, psplat_blend_field *field) {
    for (int k = 0; k < 3; ++k) {
        double factor = material ? (double)material->base_color[k] : 1;
        field->factor[k] = factor;
        field->colors[0][k] = factor * (double)color[k];
        field->colors[1][k] = finish ? factor * (double)finish->color_u[k] : 0;
        field->colors[2][k] = finish ? factor * (double)finish->color_v[k] : 0;
    }
}

void psplat_blend_field_paint(const float color[4], const psplat_finish *finish,
                              const psplat_material *material, psplat_blend_field *field) {
    set_colors(color, finish, material, field);
    set_finish(finish, material, field);
}

void psplat_blend_field_normal(const psplat_blend_field *field, const double uv[2],
                               double normal[3]) {
    memcpy(normal, field->normals[0], 3 * sizeof(double));
    mad3(normal, uv[0], field->normals[1]);
    mad3(normal, uv[1], field->normals[2]);
}

/* How much wider the tolerance is, in parts of it. */
static const double tolerance_slack = 1e-6;

psplat_result psplat_measured_splats_create_covering(const psplat_splats *splats, double tolerance,
                                                     psplat_measured_splats *measured) {
    *measured = (psplat_measured_splats){.count = splats->count,
                                         .tolerance = tolerance * (1 + tolerance_slack)};
    measured->regions = psplat_splat_regions(splats);
    if (measured->regions)
        measured->region_tree = psplat_region_tree_create_covering(measured->regions, splats->count,
                                                                   measured->tolerance);
    if (measured->region_tree) return PSPLAT_OK;
    psplat_measured_splats_free(measured);
    return PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_measured_splats_create(const psplat_splats *splats, double tolerance,
                                            double reach, psplat_measured_splats *measured) {
    *measured = (psplat_measured_splats){.count = splats->count,
                                         .tolerance = tolerance * (1 + tolerance_slack)};
    measured->regions = psplat_splat_regions(splats);
    measured->fields = malloc((splats->count + 1) * sizeof *measured->fields);
    measured->materials = calloc(splats->count + 1, sizeof *measured->materials);
    if (measured->regions && measured->fields && measured->materials)
        measured->region_tree = psplat_region_tree_create(measured->regions, splats->count, reach);
    if (!measured->region_tree) {
        psplat_measured_splats_free(measured);
        return PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < splats->count; ++i) {
        psplat_blend_field_of(&splats->splats[i], &measured->regions[i], &measured->fields[i]);
        measured->fields[i].kernel = splats->kernel;
        measured->fields[i].depth = HUGE_VAL;
    }
    for (size_t run = 0, i = 0; run < splats->run_count; ++run) {
        uint32_t material = splats->runs[run].material;
        for (size_t end = i + splats->runs[run].count; i < end && i < splats->count; ++i) {
            const psplat_finish *finish = splats->finishes ? &splats->finishes[i] : NULL;
            const psplat_material *factors =
                material < splats->material_count ? &splats->materials[material] : NULL;
            measured->materials[i] = material;
            psplat_blend_field_paint(splats->splats[i].color, finish, factors,
                                     &measured->fields[i]);
        }
    }
    return PSPLAT_OK;
}

int psplat_measured_splats_cover(const psplat_measured_splats *measured, uint32_t splat,
                                 const double normal[3], const double uvh[3]) {
    const psplat_region *region = &measured->regions[splat];
    double own[3];
    if (!(fabs(uvh[2]) <= measured->tolerance) ||
        !psplat_region_contains(region, uvh, 1 + rounding_slack, rounding_slack))
        return 0;
    if (!psplat_region_is_curved(region)) return dot3(normal, region->n) > 0;
    psplat_region_normal(region, uvh, own);
    return dot3(normal, own) > 0;
}
