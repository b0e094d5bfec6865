/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shrink_images.h - smaller images in place of large ones.
 */
#ifndef PHONGSPLAT_MATERIAL_SHRINK_IMAGES_H
#define PHONGSPLAT_MATERIAL_SHRINK_IMAGES_H

#include <phongsplat/splat.h>

#include "material/image.h"
#include "material/source_materials.h"

#include <stdint.h>

/* Halves every image with a side of more than `most` texels, 1 or more, until it has none, and
 * encodes it again in its format: PNG by libpng, JPEG by libjpeg. Images that materials use as
 * colours are averaged in linear light. Others, and those whose bytes are not known, stay as they
 * are. Errors: MEMORY; images are whole also then. */
psplat_result psplat_images_shrink(psplat_source_materials *materials, uint32_t most,
                                   psplat_error *error);

/* Encodes the pixels of an image as PNG or JPEG, as its mime_type says, in place of its bytes. A
 * PNG without transparency has no alpha, and a JPEG the quality of 90. Errors: MEMORY. */
psplat_result psplat_image_encode(psplat_image *image, psplat_error *error);

#endif
