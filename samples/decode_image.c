/* SPDX-License-Identifier: MIT
 *
 * decode_image.c - decodes the images of textures with stb_image; see decode_image.h.
 */
#include "decode_image.h"

#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#include <stb/stb_image.h>

#include <limits.h>
#include <stdio.h>

static psplat_result fail(psplat_error *error, psplat_result code, const psplat_asset_image *image,
                          const char *why) {
    error->code = code;
    snprintf(error->text, sizeof error->text, "image %.100s %.20s: %.60s", image->name,
             image->mime_type, why);
    return code;
}

/* Colours are decoded from sRGB by GL, so that both uses of an image are the same bytes. */
static psplat_result load(void *user, const psplat_asset_image *image, int is_srgb,
                          psplat_pixels *pixels, psplat_error *error) {
    int width, height, channels;
    (void)user, (void)is_srgb;
    if (image->size > INT_MAX) return fail(error, PSPLAT_ERROR_RANGE, image, "is too long");
    uint8_t *rgba =
        stbi_load_from_memory(image->data, (int)image->size, &width, &height, &channels, 4);
    if (!rgba) return fail(error, PSPLAT_ERROR_FORMAT, image, stbi_failure_reason());
    *pixels = (psplat_pixels){
        .rgba = rgba, .width = (uint32_t)width, .height = (uint32_t)height, .user = rgba};
    return PSPLAT_OK;
}

static void release(void *user, psplat_pixels *pixels) {
    (void)user;
    stbi_image_free(pixels->user);
}

psplat_images decode_images(void) {
    return (psplat_images){.load = load, .release = release};
}
