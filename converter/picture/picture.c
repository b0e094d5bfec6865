/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture.c - the reduction of a supersampled picture: from linear float pixels to 8-bit sRGB. The
 * mean is taken in linear light, since light adds up there; the mean of encoded values would darken
 * edges.
 */
#include "picture/picture.h"

#include <math.h>

uint8_t psplat_picture_encode_srgb(double linear) {
    double x = linear < 0 ? 0 : linear > 1 ? 1 : linear;
    double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * encoded + 0.5);
}

static void average(const float *block, int stride, int factor, double mean[4]) {
    for (int c = 0; c < 4; ++c) mean[c] = 0;
    for (int y = 0; y < factor; ++y)
        for (int x = 0; x < factor; ++x)
            for (int c = 0; c < 4; ++c)
                mean[c] += (double)block[((size_t)y * (size_t)stride + (size_t)x) * 4 + (size_t)c];
    for (int c = 0; c < 4; ++c) mean[c] /= (double)factor * factor;
}

void psplat_picture_reduce(const float *rgba, int width, int height, int factor, int channels,
                           uint8_t *pixels) {
    int stride = width * factor;
    for (int y = 0; y < height; ++y) {
        const float *row = rgba + (size_t)(height - 1 - y) * (size_t)factor * (size_t)stride * 4;
        for (int x = 0; x < width; ++x, pixels += channels) {
            double mean[4];
            average(row + (size_t)x * (size_t)factor * 4, stride, factor, mean);
            /* Straight alpha needs the colour of the covered part without the rest. */
            double cover = channels == 4 && mean[3] > 0 ? mean[3] : 1;
            for (int c = 0; c < 3; ++c) pixels[c] = psplat_picture_encode_srgb(mean[c] / cover);
            if (channels == 4) pixels[3] = (uint8_t)(255 * fmin(mean[3], 1) + 0.5);
        }
    }
}
