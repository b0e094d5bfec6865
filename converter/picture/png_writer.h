/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * png_writer.h - pixels as PNG.
 */
#ifndef PHONGSPLAT_PICTURE_PNG_WRITER_H
#define PHONGSPLAT_PICTURE_PNG_WRITER_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

/* Encodes 8-bit sRGB, row 0 on top, 3 channels or 4 (straight alpha), into memory from malloc. */
psplat_result psplat_png_encode(const uint8_t *pixels, int width, int height, int channels,
                                uint8_t **data, size_t *size, psplat_error *error);

#endif
