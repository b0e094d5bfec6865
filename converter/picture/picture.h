/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture.h - the reduction of a supersampled picture to 8-bit sRGB pixels.
 */
#ifndef PHONGSPLAT_PICTURE_PICTURE_H
#define PHONGSPLAT_PICTURE_PICTURE_H

#include <stddef.h>
#include <stdint.h>

/* Encodes linear light, clamped to 0 ... 1, as sRGB (IEC 61966-2-1). */
uint8_t psplat_picture_encode_srgb(double linear);

/* Averages blocks of factor x factor linear, premultiplied RGBA pixels (row 0 at the bottom) into
 * width x height sRGB-encoded pixels (row 0 on top) of 3 channels, or 4 with straight alpha. */
void psplat_picture_reduce(const float *rgba, int width, int height, int factor, int channels,
                           uint8_t *pixels);

#endif
