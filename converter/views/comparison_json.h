/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * comparison_json.h - the results of comparing an asset or a mesh with its source mesh, and their
 * JSON.
 */
#ifndef PHONGSPLAT_VIEWS_COMPARISON_JSON_H
#define PHONGSPLAT_VIEWS_COMPARISON_JSON_H

#include "compare/rays.h"
#include "compare/shape_errors.h"
#include "views/image_metrics.h"
#include "views/picture_views.h"

#include <phongsplat/phongsplat.h>

typedef struct psplat_comparison {
    const char *source, *target; /* file names */
    size_t source_triangles;
    int is_mesh; /* the target is a mesh instead of an asset */
    psplat_shape_errors shape;
    psplat_ray_errors rays;
    int has_pictures;
    psplat_picture_errors picture, views[PSPLAT_PICTURE_VIEWS];
    int has_base_color;               /* the source has textures or colours */
    psplat_picture_errors base_color; /* of all views, without light */
    psplat_mode mode;                 /* in which an asset was drawn */
    int no_filter, size;
    int erosion;    /* pixels from outlines within which there are no interior holes */
    double seconds; /* of measuring and drawing */
} psplat_comparison;

/* Writes one object of *size bytes to *text, from malloc, owned by the caller and not terminated.
 * Its keys, which programs may rely on: source, target, kind (splats or triangles),
 * source_triangles, elements, source_samples, target_samples, diagonal, reach_percent,
 * crease_width_percent; X_max_percent, X_rms_percent, X_p95_percent for X = outward, inward,
 * distance; X_max_degrees, X_rms_degrees, X_p95_degrees for X = normal, face_normal, crease_normal;
 * uncovered_area_percent, overhang_area_percent, crease_area_percent; rays, an object with count,
 * missed, missed_percent, open, hidden, outline, reach_percent, ranges (an array, by cosine, of
 * least_cosine, count and missed) and places (of missed rays: point, direction and cosine); with
 * pictures image_size, image_erosion, and of splats mode and filter; image_psnr_db,
 * image_inside_psnr_db, image_ssim, image_difference_percent, image_inside_percent,
 * image_missing_percent, image_extra_percent, image_covered, image_interior_holes of all views, and
 * views, an array with the same of each without image_; where the source has textures or colours
 * base_color_psnr_db, base_color_ssim and so on, of pictures without light; seconds. Values that
 * are not finite (the distance to nothing, the PSNR of equal pictures) or not known are null.
 * Errors: MEMORY. */
psplat_result psplat_comparison_json(const psplat_comparison *comparison, char **text, size_t *size,
                                     psplat_error *error);

#endif
