/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * asset_pictures.h - the pictures of an asset, or of another mesh, beside those of its source mesh:
 * all of a comparison that needs a graphics context.
 */
#ifndef PHONGSPLAT_VIEWS_ASSET_PICTURES_H
#define PHONGSPLAT_VIEWS_ASSET_PICTURES_H

#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "views/heatmap.h"
#include "views/image_metrics.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

typedef struct psplat_asset_pictures psplat_asset_pictures;

typedef struct psplat_asset_pictures_desc {
    psplat_host *host; /* its context is current in every call */
    const psplat_source_mesh *source;
    const psplat_asset *asset;      /* what is pictured; need not outlive creation */
    const psplat_source_mesh *mesh; /* or, if not NULL, this mesh; must outlive the pictures */
    psplat_mode mode;
    int no_filter;
    int size;               /* as in psplat_picture_views_desc, */
    psplat_shading shading; /* as is this */
    int erosion;            /* as in psplat_pictured */
} psplat_asset_pictures_desc;

/* Draws the pictures of the source. The caller frees *pictures with psplat_asset_pictures_destroy.
 * Errors: ARGUMENT, MEMORY, GRAPHICS. */
psplat_result psplat_asset_pictures_create(const psplat_asset_pictures_desc *desc,
                                           psplat_asset_pictures **pictures, psplat_error *error);
/* Accepts NULL. */
void psplat_asset_pictures_destroy(psplat_asset_pictures *pictures);

/* Measures the differences in one view, or in all views if view is negative; see
 * psplat_picture_views_compare. */
psplat_result psplat_asset_pictures_compare(psplat_asset_pictures *pictures, int view,
                                            psplat_picture_errors *errors, psplat_error *error);
/* Makes the heat maps of a view as a PNG in memory from malloc, which the caller frees; see
 * psplat_picture_views_heatmap. */
psplat_result psplat_asset_pictures_map(psplat_asset_pictures *pictures,
                                        const psplat_shape_probe *probe, int view,
                                        const psplat_heatmap_limits *limits, uint8_t **png,
                                        size_t *size, psplat_error *error);

#endif
