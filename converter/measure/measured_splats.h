/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * measured_splats.h - stored splats prepared for measurements against the surface.
 */
#ifndef PHONGSPLAT_MEASURE_MEASURED_SPLATS_H
#define PHONGSPLAT_MEASURE_MEASURED_SPLATS_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "splats/splats.h"

#include <stdint.h>

/* What a splat adds to a blend. Its normal is n(u, v) = normals[0] + u normals[1] + v normals[2]
 * (spec 3.5), in the coordinates that its region is in. */
typedef struct psplat_blend_field {
    double normals[3][3];
    double colors[3]
                 [3]; /* linear in (u, v) as normals are (spec 3.10); times the material's factor */
    double finish[5]; /* emissive R G B, roughness and metallic; times the material's factors */
    double factor[3]; /* the material's base colour, which no colour of a fragment exceeds */
    psplat_kernel kernel;
    double depth; /* epsilon of spec 5.3, a length along the region's normal */
} psplat_blend_field;

/* Stored splats, with what measurements need of them. */
typedef struct psplat_measured_splats {
    psplat_region *regions;     /* count */
    psplat_blend_field *fields; /* count */
    uint32_t *materials; /* count: indices; NULL: all splats have the first one, and creases of all
                            materials bound them */
    uint32_t *triangles; /* count: those that they grew from; NULL: files do not tell */
    size_t count;
    psplat_region_tree *region_tree;
    double tolerance; /* a length, a little wider than the promised one to allow for rounding */
    double wall; /* how far down the walls under the rims of curved splats are taken to reach (spec
                    5.1), a length */
} psplat_measured_splats;

/* How far from a splat's box a point may lie that is within a tolerance of its surface along the
 * surface's normal, in tolerances: the height over it is that times the root of 1 + slope^2, and
 * the slopes of what a conversion fits are at most 2.75. */
#define PSPLAT_STEEPEST_REACH 3

/* Prepares splats. The tree finds those whose box is within reach, a length, of a point. The depth
 * of all fields is infinite, so that no splat hides another, and there are no walls.
 * psplat_measured_splats_free frees *measured. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_measured_splats_create(const psplat_splats *splats, double tolerance,
                                            double reach, psplat_measured_splats *measured);

/* Prepares the regions of splats alone, for what they cover: the tree finds those that cover a
 * point, and there are no fields, materials or walls. psplat_measured_splats_free frees *measured.
 * Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_measured_splats_create_covering(const psplat_splats *splats, double tolerance,
                                                     psplat_measured_splats *measured);

/* Frees all that measured owns, and zeroes it. */
void psplat_measured_splats_free(psplat_measured_splats *measured);

/* Returns whether a splat covers a surface point: uvh are the point's parameters and height in the
 * splat's region (psplat_region_local), and normal is the surface's. A splat that faces away from
 * that normal at (u, v), as on the other side of a thin wall, does not cover the point. */
int psplat_measured_splats_cover(const psplat_measured_splats *measured, uint32_t splat,
                                 const double normal[3], const double uvh[3]);

/* Returns 0 only where no point of a splat's plane within its ellipse is within reach of the foot
 * of a point: few operations tell for most splats whose boxes are near. */
static inline int psplat_measured_splats_near(const psplat_measured_splats *measured,
                                              uint32_t splat, const double point[3], double reach) {
    const psplat_region *region = &measured->regions[splat];
    double d[3], most = 1 + 1e-5 + reach / min2(region->radius[0], region->radius[1]);
    sub3(d, point, region->center);
    double u = dot3(d, region->u) / region->radius[0], v = dot3(d, region->v) / region->radius[1];
    return u * u + v * v <= most * most;
}

/* Sets the normals of a field to those of a splat with this region. */
void psplat_blend_field_of(const psplat_splat *splat, const psplat_region *region,
                           psplat_blend_field *field);

/* Sets the colours and the finish of a field. finish and material may be NULL: neutral. */
void psplat_blend_field_paint(const float color[4], const psplat_finish *finish,
                              const psplat_material *material, psplat_blend_field *field);

/* Finds the normal of a field at (u, v). It has no particular length. */
void psplat_blend_field_normal(const psplat_blend_field *field, const double uv[2],
                               double normal[3]);

#endif
