/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distant_view.c - the reference for pictures of a distant model. A pixel should show the mean of
 * all that it covers, which is what the screen-space filter of splats is for; a larger picture of
 * the source, averaged, shows that mean.
 */
#include "views/distant_view.h"

#include "picture/picture.h"

#include <math.h>
#include <stdlib.h>

/* Decodes sRGB (IEC 61966-2-1) to linear light. */
static double decode(uint8_t encoded) {
    double x = encoded / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static void average(const uint8_t *block, size_t stride, const double decoded[256],
                    uint8_t pixel[4]) {
    double sum[3] = {0};
    int covered = 1;
    for (size_t y = 0; y < PSPLAT_DISTANT; ++y)
        for (size_t x = 0; x < PSPLAT_DISTANT; ++x) {
            const uint8_t *from = block + 4 * (y * stride + x);
            for (int c = 0; c < 3; ++c) sum[c] += decoded[from[c]];
            covered &= from[3] != 0;
        }
    for (int c = 0; c < 3; ++c)
        pixel[c] = psplat_picture_encode_srgb(sum[c] / (PSPLAT_DISTANT * PSPLAT_DISTANT));
    pixel[3] = covered ? 255 : 0;
}

void psplat_distant_view_shrink(const uint8_t *rgba, int size, uint8_t *small) {
    size_t side = (size_t)size, stride = PSPLAT_DISTANT * side;
    double decoded[256];
    for (int i = 0; i < 256; ++i) decoded[i] = decode((uint8_t)i);
    for (size_t y = 0; y < side; ++y)
        for (size_t x = 0; x < side; ++x, small += 4)
            average(rgba + 4 * PSPLAT_DISTANT * (y * stride + x), stride, decoded, small);
}

void psplat_distant_view_add(const uint8_t *truth, const uint8_t *shown, int size,
                             uint64_t *differences, uint64_t *pixels) {
    size_t count = (size_t)size * (size_t)size;
    for (size_t i = 0; i < count; ++i, truth += 4, shown += 4) {
        if (!truth[3] || !shown[3]) continue;
        ++*pixels;
        for (int c = 0; c < 3; ++c) *differences += (uint64_t)abs(truth[c] - shown[c]);
    }
}
