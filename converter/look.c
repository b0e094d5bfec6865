/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * look.c - what one who faces a surface at a point of it sees of the splats there: the view along
 * the surface's own normal.
 */
#include "stages.h"
#include "vector.h"

#include <string.h>

/* Splats seen more edge-on than this do not show. */
static const double least_cosine = 0.1;

/* Where the line along the normal meets a splat from its front. 0: nowhere within reach. */
static int meet(const psplat_look *look, uint32_t splat, double uvh[3], double *height,
                double *cosine) {
    const psplat_region *region = &look->measured->regions[splat];
    double d[3], q[3];
    *cosine = dot3(look->normal, region->n);
    if (*cosine < least_cosine) return 0;
    sub3(d, region->center, look->point);
    *height = dot3(d, region->n) / *cosine;
    if (fabs(*height) > look->reach) return 0;
    along3(q, look->point, *height, look->normal);
    psplat_region_local(region, q, uvh);
    return psplat_region_contains(region, uvh, 1, 0);
}

void psplat_look_limit(psplat_look *look, uint32_t splat) {
    double uvh[3], height, cosine;
    if (!meet(look, splat, uvh, &height, &cosine)) return;
    double epsilon = look->measured->fields[splat].depth / max2(cosine, 0.5); /* spec eq. 5 */
    look->limit = max2(look->limit, height - epsilon);
}

void psplat_look_add(psplat_look *look, uint32_t splat) {
    double uvh[3], field[3], height, cosine;
    if (!meet(look, splat, uvh, &height, &cosine) || height < look->limit) return;
    const psplat_field *blend = &look->measured->fields[splat];
    double r = hypot(uvh[0], uvh[1]);
    double weight = exp(-(double)blend->kernel.sharpness * pow(r, (double)blend->kernel.exponent));
    psplat_field_normal(blend, uvh, field);
    mad3(look->blended, weight, field);
    mad3(look->constant, weight, blend->normals[0]);
    mad3(look->flat_color, weight, blend->colors[0]);
    for (int k = 0; k < 3; ++k) { /* clamped as each fragment is (spec eq. 4a) */
        double value =
            blend->colors[0][k] + uvh[0] * blend->colors[1][k] + uvh[1] * blend->colors[2][k];
        look->color[k] += weight * min2(max2(value, 0), blend->factor[k]);
    }
    look->weight += weight;
}
