/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_loader.c - the decoder that the converter gives to the renderer, for textures of assets.
 */
#include "views/image_loader.h"

#include "base/path.h"
#include "material/image.h"

#include <stdlib.h>
#include <string.h>

/* Puts the image's name before the text of an error. */
static psplat_result name_error(const psplat_asset_image *image, const psplat_error *cause,
                                psplat_result result, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(image->name, shown);
    return psplat_fail(error, result, cause->offset, "image%s%s: %s", *shown ? " " : "", shown,
                       cause->text);
}

static psplat_result load(void *user, const psplat_asset_image *image, int is_srgb,
                          psplat_pixels *pixels, psplat_error *error) {
    psplat_image decoded = {0};
    psplat_error cause = {0};
    (void)user, (void)is_srgb; /* the renderer converts colours */
    psplat_result result = psplat_image_decode(image->data, image->size, &decoded, &cause);
    if (result) {
        psplat_image_free(&decoded);
        return name_error(image, &cause, result, error);
    }
    *pixels = (psplat_pixels){.rgba = decoded.pixels,
                              .width = decoded.width,
                              .height = decoded.height,
                              .user = decoded.pixels};
    decoded.pixels = NULL;
    psplat_image_free(&decoded);
    return PSPLAT_OK;
}

static void release(void *user, psplat_pixels *pixels) {
    (void)user;
    free(pixels->user);
}

psplat_images psplat_image_loader(void) {
    return (psplat_images){.load = load, .release = release};
}
