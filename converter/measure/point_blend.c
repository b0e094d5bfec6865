/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * point_blend.c - the blend of the splats at a surface point, seen along the surface's normal
 * (spec 5.1 to 5.4).
 */
#include "measure/point_blend.h"

#include "base/region.h"
#include "base/vector.h"
#include "measure/measured_splats.h"

#include <math.h>

/* The least cosine between a splat's normal and the surface's at which the splat counts. Splats
 * that are seen more edge-on do not show. Chosen by hand. */
static const double least_visible_cosine = 0.1;

/* Intersects the line along the surface's normal with the front of a curved splat (spec 5.1). The
 * line's height over the splat is F0 + F1 t + F2 t^2 at t along it, and rises where it leaves the
 * front. Returns 0 where the line does not meet it. */
static int meet_front(const psplat_region *region, const double point[3], const double normal[3],
                      double *height, double *rise) {
    const double *h = region->hessian;
    double d[3];
    sub3(d, point, region->center);
    double s = dot3(d, region->u), t = dot3(d, region->v);
    double x = dot3(normal, region->u), y = dot3(normal, region->v);
    const double uv[2] = {s / region->radius[0], t / region->radius[1]};
    double slope[2];
    psplat_region_slope(region, uv, slope);
    double f0 = dot3(d, region->n) - psplat_region_height(region, uv);
    double f1 = dot3(normal, region->n) - slope[0] * x - slope[1] * y;
    double f2 = -(h[0] * x * x + 2 * h[1] * x * y + h[2] * y * y) / 2;
    double square = f1 * f1 - 4 * f0 * f2;
    if (!(square > 0)) return 0;
    *rise = sqrt(square);
    *height = f1 > 0 ? -2 * f0 / (f1 + *rise) : (*rise - f1) / (2 * f2);
    return 1;
}

/* Intersects the line along the surface's normal with the front of a splat. Returns 0 where it does
 * not meet the splat within reach. */
static int intersect(const psplat_point_blend *blend, uint32_t splat, double uvh[3], double *height,
                     double *cosine) {
    const psplat_region *region = &blend->measured->regions[splat];
    int is_curved = psplat_region_is_curved(region);
    double d[3], q[3];
    if (is_curved) {
        if (!meet_front(region, blend->point, blend->normal, height, cosine)) return 0;
    } else {
        *cosine = dot3(blend->normal, region->n);
        if (*cosine < least_visible_cosine) return 0;
        sub3(d, region->center, blend->point);
        *height = dot3(d, region->n) / *cosine;
    }
    if (!(fabs(*height) <= blend->reach)) return 0;
    along3(q, blend->point, *height, blend->normal);
    psplat_region_local(region, q, uvh);
    if (is_curved) {
        double slope[2];
        psplat_region_slope(region, uvh, slope);
        *cosine /= sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
        if (*cosine < least_visible_cosine) return 0;
    }
    return psplat_region_contains(region, uvh, 1, 0);
}

int psplat_point_blend_meet(const psplat_point_blend *blend, uint32_t splat, double uv[2]) {
    double uvh[3], height, cosine;
    if (!intersect(blend, splat, uvh, &height, &cosine)) return 0;
    uv[0] = uvh[0], uv[1] = uvh[1];
    return 1;
}

int psplat_point_blend_limit(psplat_point_blend *blend, uint32_t splat) {
    double uvh[3], height, cosine;
    if (!intersect(blend, splat, uvh, &height, &cosine)) return 0;
    double epsilon = blend->measured->fields[splat].depth / max2(cosine, 0.5); /* spec eq. 5 */
    blend->limit = max2(blend->limit, height - epsilon);
    return 1;
}

void psplat_point_blend_add(psplat_point_blend *blend, uint32_t splat) {
    double uvh[3], normal[3], height, cosine;
    if (!intersect(blend, splat, uvh, &height, &cosine) || height < blend->limit) return;
    const psplat_blend_field *splat_field = &blend->measured->fields[splat];
    double r = sqrt(uvh[0] * uvh[0] + uvh[1] * uvh[1]);
    double weight =
        exp(-(double)splat_field->kernel.sharpness * pow(r, (double)splat_field->kernel.exponent));
    psplat_blend_field_normal(splat_field, uvh, normal);
    mad3(blend->blended, weight, normal);
    mad3(blend->constant, weight, splat_field->normals[0]);
    if (psplat_region_is_beyond_seam(&blend->measured->regions[splat], uvh))
        weight *= PSPLAT_SEAM_WEIGHT; /* All but normals ends at seams (spec 3.6). */
    mad3(blend->flat_color, weight, splat_field->colors[0]);
    for (int k = 0; k < 3; ++k) { /* Each fragment's colour is clamped (spec eq. 4a). */
        double value = splat_field->colors[0][k] + uvh[0] * splat_field->colors[1][k] +
                       uvh[1] * splat_field->colors[2][k];
        blend->color[k] += weight * min2(max2(value, 0), splat_field->factor[k]);
    }
    for (int k = 0; k < 5; ++k) blend->finish[k] += weight * splat_field->finish[k];
    blend->weight += weight;
}
