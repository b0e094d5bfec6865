/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * comparison.h - all that was found when something was compared with a mesh, and its JSON.
 */
#ifndef PHONGSPLAT_COMPARISON_H
#define PHONGSPLAT_COMPARISON_H

#include "compare.h"

typedef struct psplat_comparison {
    const char *source, *target; /* names of files */
    size_t source_triangles;
    int is_mesh; /* the target is a mesh instead of an asset */
    psplat_shape_errors shape;
    int has_pictures;
    psplat_picture_errors picture, views[PSPLAT_GALLERY_VIEWS];
    psplat_mode mode; /* of pictures of an asset */
    int no_filter, size;
    double seconds; /* of measuring and drawing */
} psplat_comparison;

/* One object in *text, allocated with malloc and owned by the caller; *size bytes, not terminated.
 * Its keys, which programs may rely on: source, target, kind (splats or triangles),
 * source_triangles, elements, source_samples, target_samples, diagonal, reach_percent,
 * crease_width_percent; X_max_percent, X_rms_percent, X_p95_percent for X = outward, inward,
 * distance; X_max_degrees, X_rms_degrees, X_p95_degrees for X = normal, face_normal, crease_normal;
 * uncovered_area_percent, overhang_area_percent, crease_area_percent; with pictures image_size,
 * and of splats mode and filter; image_psnr_db, image_ssim, image_difference_percent,
 * image_inside_percent, image_missing_percent, image_extra_percent, image_covered,
 * image_perceptual of all views, and views, an array with the same of each without image_ and
 * perceptual; seconds. Values that are not finite (the distance to nothing, the PSNR of equal
 * pictures) or not known are null. */
psplat_result psplat_comparison_json(const psplat_comparison *comparison, char **text, size_t *size,
                                     psplat_error *error);

#endif
