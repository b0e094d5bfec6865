/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distant_view.h - the reference for pictures of a distant model, each pixel of which covers many
 * triangles: a larger picture, averaged.
 */
#ifndef PHONGSPLAT_VIEWS_DISTANT_VIEW_H
#define PHONGSPLAT_VIEWS_DISTANT_VIEW_H

#include <stdint.h>

enum { PSPLAT_DISTANT = 8 }; /* pixels, across and down, that become one */

/* Averages blocks of an sRGB-encoded RGBA picture, PSPLAT_DISTANT * size pixels wide and high, in
 * linear light into size x size pixels. Alpha becomes 255 where the whole block is covered, else 0.
 */
void psplat_distant_view_shrink(const uint8_t *rgba, int size, uint8_t *small);

/* Adds the absolute differences of colour channels, 0 ... 255, over the pixels that both pictures
 * cover, and the number of these pixels. */
void psplat_distant_view_add(const uint8_t *truth, const uint8_t *shown, int size,
                             uint64_t *differences, uint64_t *pixels);

#endif
