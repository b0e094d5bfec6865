/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distant.h - pictures as small as those of a distant model, whose pixels hold the mean of much.
 */
#ifndef PHONGSPLAT_DISTANT_H
#define PHONGSPLAT_DISTANT_H

#include <stdint.h>

enum { PSPLAT_DISTANT = 8 }; /* how many pixels become one, across and down */

/* Averages blocks of sRGB-encoded RGBA in linear light, of (PSPLAT_DISTANT * size)^2 pixels, into
 * size x size. Alpha becomes 255 where all of a block is covered, and 0 elsewhere. */
void psplat_distant_shrink(const uint8_t *rgba, int size, uint8_t *small);

/* Adds up absolute differences of colour channels, and the pixels that both pictures cover. */
void psplat_distant_add(const uint8_t *truth, const uint8_t *shown, int size, uint64_t *differences,
                        uint64_t *pixels);

#endif
