/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * exhibition.c - an asset, or another mesh, hung in a gallery of its source.
 */
#include "exhibition.h"
#include "picture.h"

#include <stdlib.h>

struct psplat_exhibition {
    psplat_gallery *gallery;
    psplat_renderer *renderer;
    psplat_exhibit exhibit;
};

static psplat_result hang(const psplat_exhibition_desc *desc, psplat_exhibition *e,
                          psplat_error *error) {
    const psplat_gallery_desc walls = {desc->host, desc->source, desc->size};
    const psplat_renderer_desc renderer = {.get_proc = psplat_host_get_proc, .user = desc->host};
    psplat_result result = psplat_gallery_create(&walls, &e->gallery, error);
    e->exhibit =
        (psplat_exhibit){.mode = desc->mode, .no_filter = desc->no_filter, .mesh = desc->mesh};
    if (result || desc->mesh) return result;
    result = psplat_renderer_create(&renderer, &e->renderer, error);
    e->exhibit.renderer = e->renderer;
    if (!result) result = psplat_model_create(e->renderer, desc->asset, &e->exhibit.model, error);
    return result;
}

psplat_result psplat_exhibition_create(const psplat_exhibition_desc *desc,
                                       psplat_exhibition **exhibition, psplat_error *error) {
    psplat_exhibition *e = calloc(1, sizeof *e);
    *exhibition = NULL;
    if (!e) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for pictures");
    psplat_result result = hang(desc, e, error);
    if (result)
        psplat_exhibition_destroy(e);
    else
        *exhibition = e;
    return result;
}

void psplat_exhibition_destroy(psplat_exhibition *exhibition) {
    if (!exhibition) return;
    psplat_gallery_destroy(exhibition->gallery);
    if (exhibition->renderer) psplat_model_destroy(exhibition->renderer, exhibition->exhibit.model);
    psplat_renderer_destroy(exhibition->renderer);
    free(exhibition);
}

psplat_result psplat_exhibition_compare(psplat_exhibition *exhibition, int view, int perceptual,
                                        psplat_picture_errors *errors, psplat_error *error) {
    return psplat_gallery_compare(exhibition->gallery, &exhibition->exhibit, view, perceptual,
                                  errors, error);
}

psplat_result psplat_exhibition_map(psplat_exhibition *exhibition, const psplat_shape_probe *probe,
                                    int view, const psplat_heatmap_limits *limits, uint8_t **png,
                                    size_t *size, psplat_error *error) {
    uint8_t *pixels;
    int width, height;
    psplat_result result = psplat_gallery_heatmap(exhibition->gallery, &exhibition->exhibit, probe,
                                                  view, limits, &pixels, &width, &height, error);
    if (result) return result;
    result = psplat_png_encode(pixels, width, height, 3, png, size, error);
    free(pixels);
    return result;
}
