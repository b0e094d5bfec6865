/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distant.c - what the screen-space filter is for: a distant model's pixel should show the mean of
 * all that it covers, as a larger picture's pixels have it.
 */
#include "distant.h"

#include <math.h>
#include <stdlib.h>

/* IEC 61966-2-1. */
static double decode(uint8_t encoded) {
    double x = encoded / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static uint8_t encode(double linear) {
    double x = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * x + 0.5);
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
    for (int c = 0; c < 3; ++c) pixel[c] = encode(sum[c] / (PSPLAT_DISTANT * PSPLAT_DISTANT));
    pixel[3] = covered ? 255 : 0;
}

void psplat_distant_shrink(const uint8_t *rgba, int size, uint8_t *small) {
    size_t side = (size_t)size, stride = PSPLAT_DISTANT * side;
    double decoded[256];
    for (int i = 0; i < 256; ++i) decoded[i] = decode((uint8_t)i);
    for (size_t y = 0; y < side; ++y)
        for (size_t x = 0; x < side; ++x, small += 4)
            average(rgba + 4 * PSPLAT_DISTANT * (y * stride + x), stride, decoded, small);
}

void psplat_distant_add(const uint8_t *truth, const uint8_t *shown, int size, uint64_t *differences,
                        uint64_t *pixels) {
    size_t count = (size_t)size * (size_t)size;
    for (size_t i = 0; i < count; ++i, truth += 4, shown += 4) {
        if (!truth[3] || !shown[3]) continue;
        ++*pixels;
        for (int c = 0; c < 3; ++c) *differences += (uint64_t)abs(truth[c] - shown[c]);
    }
}
