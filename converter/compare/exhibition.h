/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * exhibition.h - an asset, or another mesh, hung in a gallery of its source: everything that takes
 * a graphics context.
 */
#ifndef PHONGSPLAT_EXHIBITION_H
#define PHONGSPLAT_EXHIBITION_H

#include "comparison.h"

typedef struct psplat_exhibition psplat_exhibition;

typedef struct psplat_exhibition_desc {
    psplat_host *host; /* its context is current in every call */
    const psplat_original *source;
    const psplat_asset *asset;   /* not needed any more once created; or */
    const psplat_original *mesh; /* outlives the exhibition */
    psplat_mode mode;
    int no_filter;
    int size; /* 0: as psplat_gallery_desc */
} psplat_exhibition_desc;

/* Errors: ARGUMENT, MEMORY, GRAPHICS. */
psplat_result psplat_exhibition_create(const psplat_exhibition_desc *desc,
                                       psplat_exhibition **exhibition, psplat_error *error);
void psplat_exhibition_destroy(psplat_exhibition *exhibition); /* NULL is accepted */

/* Errors of a view, or of all of them (negative); see psplat_gallery_compare. */
psplat_result psplat_exhibition_compare(psplat_exhibition *exhibition, int view, int perceptual,
                                        psplat_picture_errors *errors, psplat_error *error);
/* Maps of a view as PNG, in memory from malloc; see psplat_gallery_heatmap. */
psplat_result psplat_exhibition_map(psplat_exhibition *exhibition, const psplat_shape_probe *probe,
                                    int view, const psplat_heatmap_limits *limits, uint8_t **png,
                                    size_t *size, psplat_error *error);

#endif
