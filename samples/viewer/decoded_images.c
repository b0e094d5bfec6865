/* SPDX-License-Identifier: MIT
 *
 * decoded_images.c - the images of files, decoded on the loader's worker, so that the window does
 * not wait for them; the main thread only uploads the pixels.
 */
#include "viewer.h"

#include "decode_image.h"

#include <stdlib.h>

psplat_result decoded_images_make(loaded_file *file) {
    const psplat_images decoder = decode_images();
    size_t count = psplat_asset_image_count(file->asset);
    file->images = calloc(count ? count : 1, sizeof *file->images);
    if (!file->images)
        return psplat_fail(&file->error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu images", count);
    for (size_t i = 0; i < count; ++i) {
        psplat_result result = decoder.load(NULL, psplat_asset_get_image(file->asset, i), 0,
                                            &file->images[i], &file->error);
        if (result) return result;
    }
    return PSPLAT_OK;
}

void decoded_images_free(loaded_file *file) {
    const psplat_images decoder = decode_images();
    for (size_t i = 0; file->images && i < psplat_asset_image_count(file->asset); ++i)
        if (file->images[i].rgba) decoder.release(NULL, &file->images[i]);
    free(file->images);
    file->images = NULL;
}

/* Both uses of an image, as colours and as other numbers, have the same pixels. */
static psplat_result find(void *user, const psplat_asset_image *image, int is_srgb,
                          psplat_pixels *pixels, psplat_error *error) {
    const shown_assets *shown = user;
    const loaded_file *file = shown->uploading;
    (void)is_srgb;
    for (size_t i = 0; file && i < psplat_asset_image_count(file->asset); ++i)
        if (psplat_asset_get_image(file->asset, i) == image) {
            *pixels = file->images[i];
            return PSPLAT_OK;
        }
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "an image was not decoded");
}

psplat_images decoded_images(shown_assets *shown) {
    return (psplat_images){.load = find, .user = shown};
}
