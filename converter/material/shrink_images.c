/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shrink_images.c - smaller images in place of large ones: levels of mipmaps become the images.
 */
#include "material/shrink_images.h"

#include "material/mipmap.h"

#include <math.h>
#include <stdlib.h>

/* Returns whether a material uses an image as colours, which are sRGB. */
static int is_color(const psplat_source_materials *materials, const psplat_image *image) {
    for (size_t i = 0; i < materials->source_material_count; ++i) {
        const psplat_source_material *m = &materials->source_materials[i];
        if (m->base_color.image == image || m->emissive.image == image) return 1;
    }
    return 0;
}

static uint8_t to_byte(float linear, int is_srgb) {
    return (uint8_t)lrintf(255 * (is_srgb ? psplat_srgb_of_linear(linear) : linear));
}

/* Makes an image of a level of a mipmap. */
static psplat_result image_of_level(const psplat_mipmap *mipmap, uint32_t level, psplat_image *out,
                                    psplat_error *error) {
    const psplat_mipmap_level *l = &mipmap->levels[level];
    psplat_result result = psplat_image_allocate(out, l->width, l->height, error);
    for (uint32_t y = 0; y < l->height && !result; ++y)
        for (uint32_t x = 0; x < l->width; ++x) {
            uint8_t *pixel = out->pixels + 4 * ((size_t)y * l->width + x);
            float rgba[4];
            psplat_mipmap_texel(mipmap, level, x, y, rgba);
            for (int k = 0; k < 4; ++k) pixel[k] = to_byte(rgba[k], mipmap->is_srgb && k < 3);
        }
    return result;
}

static psplat_result shrink(psplat_image *image, int is_srgb, uint32_t most, psplat_error *error) {
    psplat_mipmap mipmap;
    psplat_image smaller = {0};
    uint32_t level = 0;
    psplat_result result = psplat_mipmap_build(image, is_srgb, &mipmap);
    if (result) return psplat_fail(error, result, 0, "out of memory while halving an image");
    while (mipmap.levels[level].width > most || mipmap.levels[level].height > most) ++level;
    result = image_of_level(&mipmap, level, &smaller, error);
    smaller.mime_type = image->mime_type;
    if (!result) result = psplat_image_encode(&smaller, error);
    psplat_mipmap_free(&mipmap);
    if (result) {
        psplat_image_free(&smaller);
        return result;
    }
    smaller.name = image->name;
    image->name = NULL;
    psplat_image_free(image);
    *image = smaller;
    return PSPLAT_OK;
}

psplat_result psplat_images_shrink(psplat_source_materials *materials, uint32_t most,
                                   psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < materials->image_count && !result; ++i) {
        psplat_image *image = &materials->images[i];
        if (image->pixels && image->bytes && (image->width > most || image->height > most))
            result = shrink(image, is_color(materials, image), most, error);
    }
    return result;
}
