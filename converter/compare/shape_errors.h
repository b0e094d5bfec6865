/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shape_errors.h - the errors of shape between a source mesh and splats or another mesh: one- and
 * two-sided Hausdorff distance, normals after blending, and coverage, all measured on samples.
 */
#ifndef PHONGSPLAT_COMPARE_SHAPE_ERRORS_H
#define PHONGSPLAT_COMPARE_SHAPE_ERRORS_H

#include <phongsplat/splat.h>
#include <phongsplat/phongsplat.h>

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/statistics.h"

#include <stdint.h>

typedef struct psplat_shape_errors {
    double diagonal;            /* of the source's bounding box, its units; distances are % of it */
    size_t elements;            /* splats, or triangles of another mesh */
    size_t source_samples;      /* points on the source */
    size_t target_samples;      /* points on the splats or the other mesh */
    psplat_statistics outward;  /* from source points to the nearest point of the target, %; max is
                               a lower bound of the one-sided Hausdorff distance, since it is
                               sampled */
    psplat_statistics inward;   /* from target points to the nearest point of the source; the max of
                               splats is that of all their points, and at most 1 % too small, as
                               long as psplat_splat_distance_find meets no limit */
    psplat_statistics distance; /* two-sided: max is the greater of both; rms and p95 are those of
                               the samples of both sides, each side with half the weight */
    psplat_statistics normal;   /* angle of blended and source normal, degrees, where covered */
    psplat_statistics face_normal;   /* the same, farther than crease_width from creases */
    psplat_statistics crease_normal; /* the same, within crease_width of a crease */
    double crease_width;             /* %, that was used */
    double crease_area;              /* % of the source's area within crease_width of a crease */
    double uncovered_area; /* % of the source's area where a ray along its normal, from reach
                              outside to reach inside, meets no front side of the target */
    double overhang_area;  /* % of the target's area that is farther than reach / 2 from the
                              source */
    double reach;          /* %, that was used */
} psplat_shape_errors;

/* A zero in a member means its default. */
typedef struct psplat_shape_desc {
    size_t samples; /* points on either side; default 200,000 */
    uint64_t seed;
    double reach;        /* %; default twice the greatest depth tolerance of the asset (spec 5.3),
                            1 % for a mesh */
    double crease_width; /* %; default reach */
} psplat_shape_desc;

/* Measures an asset in the coordinates of the source file. desc may be NULL. Errors: MEMORY,
 * RANGE. */
psplat_result psplat_shape_compare(const psplat_source_mesh *source, const psplat_asset *asset,
                                   const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                   psplat_error *error);

/* Measures another mesh, such as a simplified one, in the same way. */
psplat_result psplat_shape_compare_mesh(const psplat_source_mesh *source,
                                        const psplat_source_mesh *target,
                                        const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                        psplat_error *error);

/* A probe measures the errors at single points of the source, for heat maps. */
typedef struct psplat_shape_probe psplat_shape_probe;

/* The source must outlive the probe, the asset need not. The caller frees *probe with
 * psplat_shape_probe_destroy. desc may be NULL. Errors: MEMORY, RANGE. */
psplat_result psplat_shape_probe_create(const psplat_source_mesh *source, const psplat_asset *asset,
                                        const psplat_shape_desc *desc, psplat_shape_probe **probe,
                                        psplat_error *error);

/* Creates a probe for another mesh, which must outlive the probe as well. Errors: MEMORY. */
psplat_result psplat_shape_probe_create_mesh(const psplat_source_mesh *source,
                                             const psplat_source_mesh *target,
                                             const psplat_shape_desc *desc,
                                             psplat_shape_probe **probe, psplat_error *error);

/* Measures at a point of the source's surface, in the coordinates of its file, with the normal
 * there. *distance is that to the nearest point of the target, %; *angle is that between the
 * normals, degrees, or negative where the point is not covered. */
void psplat_shape_probe_at(const psplat_shape_probe *probe, const double point[3],
                           const double normal[3], double *distance, double *angle);

void psplat_shape_probe_destroy(psplat_shape_probe *probe); /* NULL is accepted */

#endif
