/* SPDX-License-Identifier: MIT
 *
 * decode_image.h - how a host decodes the images of textures, which the runtime leaves to it. The
 * samples and the viewer share it; engines have decoders of their own.
 */
#ifndef PHONGSPLAT_DECODE_IMAGE_H
#define PHONGSPLAT_DECODE_IMAGE_H

#include <phongsplat/phongsplat.h>

/* Returns functions for psplat_renderer_desc.images that decode PNG and JPEG with stb_image.
 * Loading fails with PSPLAT_ERROR_FORMAT where an image is broken, neither of both, or has more
 * than 16384 pixels along an edge. */
psplat_images decode_images(void);

#endif
