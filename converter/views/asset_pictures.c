/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * asset_pictures.c - the pictures of an asset, or of another mesh, beside those of its source mesh.
 * It owns the picture views of the source and the renderer of the asset.
 */
#include "views/asset_pictures.h"

#include "compare/shape_errors.h"
#include "picture/png_writer.h"
#include "views/heatmap.h"
#include "views/image_loader.h"
#include "views/image_metrics.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <stdlib.h>

struct psplat_asset_pictures {
    psplat_picture_views *views;
    psplat_renderer *renderer;
    psplat_pictured pictured;
};

static psplat_result create(const psplat_asset_pictures_desc *desc, psplat_asset_pictures *e,
                            psplat_error *error) {
    const psplat_picture_views_desc views = {desc->host, desc->source, desc->size, desc->shading};
    const psplat_renderer_desc renderer = {
        .get_proc = psplat_host_get_proc, .user = desc->host, .images = psplat_image_loader()};
    psplat_result result = psplat_picture_views_create(&views, &e->views, error);
    e->pictured = (psplat_pictured){.mode = desc->mode,
                                    .no_filter = desc->no_filter,
                                    .mesh = desc->mesh,
                                    .erosion = desc->erosion};
    if (result || desc->mesh) return result;
    result = psplat_renderer_create(&renderer, &e->renderer, error);
    e->pictured.renderer = e->renderer;
    if (!result) result = psplat_model_create(e->renderer, desc->asset, &e->pictured.model, error);
    return result;
}

psplat_result psplat_asset_pictures_create(const psplat_asset_pictures_desc *desc,
                                           psplat_asset_pictures **pictures, psplat_error *error) {
    psplat_asset_pictures *e = calloc(1, sizeof *e);
    *pictures = NULL;
    if (!e) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for pictures");
    psplat_result result = create(desc, e, error);
    if (result)
        psplat_asset_pictures_destroy(e);
    else
        *pictures = e;
    return result;
}

void psplat_asset_pictures_destroy(psplat_asset_pictures *pictures) {
    if (!pictures) return;
    psplat_picture_views_destroy(pictures->views);
    if (pictures->renderer) psplat_model_destroy(pictures->renderer, pictures->pictured.model);
    psplat_renderer_destroy(pictures->renderer);
    free(pictures);
}

psplat_result psplat_asset_pictures_compare(psplat_asset_pictures *pictures, int view,
                                            psplat_picture_errors *errors, psplat_error *error) {
    return psplat_picture_views_compare(pictures->views, &pictures->pictured, view, errors, error);
}

psplat_result psplat_asset_pictures_map(psplat_asset_pictures *pictures,
                                        const psplat_shape_probe *probe, int view,
                                        const psplat_heatmap_limits *limits, uint8_t **png,
                                        size_t *size, psplat_error *error) {
    uint8_t *pixels;
    int width, height;
    psplat_result result = psplat_picture_views_heatmap(
        pictures->views, &pictures->pictured, probe, view, limits, &pixels, &width, &height, error);
    if (result) return result;
    result = psplat_png_encode(pixels, width, height, 3, png, size, error);
    free(pixels);
    return result;
}
