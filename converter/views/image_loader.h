/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_loader.h - the decoder that the converter gives to the renderer, for textures of assets.
 */
#ifndef PHONGSPLAT_VIEWS_IMAGE_LOADER_H
#define PHONGSPLAT_VIEWS_IMAGE_LOADER_H

#include <phongsplat/phongsplat.h>

/* Returns the decoding of PNG and JPEG (material/image.h), for psplat_renderer_desc.images. Errors
 * of its load() are those of psplat_image_decode and name the image. */
psplat_images psplat_image_loader(void);

#endif
