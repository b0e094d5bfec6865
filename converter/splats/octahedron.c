/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * octahedron.c - octahedral encoding of unit vectors in two integers (Cigolle et al. 2014).
 *
 * It decodes as the octahedral filter of EXT_meshopt_compression does, and encodes by trying all
 * codes next to the rounded one, of which it takes the one that decodes nearest to the vector.
 */
#include "splats/octahedron.h"

#include "base/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns the largest coordinate of a code with so many bits. */
static int32_t largest_coordinate(int bits) {
    return (1 << (bits - 1)) - 1;
}

/* Does the arithmetic of the decoder of EXT_meshopt_compression's octahedral filter in its single
 * precision, but leaves out the last rounding. */
static void decode(const int32_t code[2], int bits, float normal[3]) {
    float x = (float)code[0], y = (float)code[1];
    float z = (float)(largest_coordinate(bits) - abs(code[0]) - abs(code[1]));
    float fold = z >= 0 ? 0 : z;
    x += x >= 0 ? fold : -fold;
    y += y >= 0 ? fold : -fold;
    float scale = (bits <= 8 ? 127.0f : 32767.0f) / sqrtf(x * x + y * y + z * z);
    const float v[3] = {x, y, z};
    for (int k = 0; k < 3; ++k) normal[k] = v[k] * scale;
}

void psplat_octahedron_decode(const int32_t code[2], int bits, int32_t normal[3]) {
    float v[3];
    decode(code, bits, v);
    for (int k = 0; k < 3; ++k) normal[k] = (int32_t)(v[k] + (v[k] >= 0 ? 0.5f : -0.5f));
}

void psplat_octahedron_normal(const int32_t code[2], int bits, double normal[3]) {
    int32_t decoded[3];
    psplat_octahedron_decode(code, bits, decoded);
    for (int k = 0; k < 3; ++k) normal[k] = decoded[k];
    normalize3(normal);
}

/* Returns whether all decoders round a code to the same integers. For bytes, libmeshoptimizer uses
 * an approximate root whose relative error is at most 1.5 * 2^-12. A coordinate that is as near as
 * that to halfway between two integers may be rounded either way, half a degree apart. */
static int decodes_uniquely(const int32_t code[2], int bits) {
    static const float greatest_relative_error = 4e-4f;
    float v[3];
    if (bits > 8) return 1; /* For shorts the root is exact, and one step is next to nothing. */
    decode(code, bits, v);
    for (int k = 0; k < 3; ++k) {
        float magnitude = fabsf(v[k]), from_half = magnitude - floorf(magnitude) - 0.5f;
        if (fabsf(from_half) <= greatest_relative_error * magnitude) return 0;
    }
    return 1;
}

int psplat_octahedron_is_code(const int32_t code[2], int bits) {
    return abs(code[0]) <= largest_coordinate(bits) && abs(code[1]) <= largest_coordinate(bits) &&
           decodes_uniquely(code, bits);
}

void psplat_octahedron_encode(const double normal[3], int bits, int32_t code[2]) {
    psplat_octahedron_encode_coarsely(normal, bits, 0, code);
}

void psplat_octahedron_encode_coarsely(const double normal[3], int bits, int shift,
                                       int32_t code[2]) {
    double sum = fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]), nearest = HUGE_VAL;
    double x = normal[0] / sum, y = normal[1] / sum;
    if (normal[2] < 0) {
        double folded = (1 - fabs(y)) * (x >= 0 ? 1 : -1);
        y = (1 - fabs(x)) * (y >= 0 ? 1 : -1);
        x = folded;
    }
    int32_t unit = 1 << shift;
    double largest = (double)largest_coordinate(bits) / unit;
    int32_t middle[2] = {(int32_t)lrint(x * largest), (int32_t)lrint(y * largest)};
    for (int32_t i = -1; i <= 1; ++i)
        for (int32_t k = -1; k <= 1; ++k) {
            const int32_t tried[2] = {(middle[0] + i) * unit, (middle[1] + k) * unit};
            double found[3];
            if (!psplat_octahedron_is_code(tried, bits)) continue;
            psplat_octahedron_normal(tried, bits, found);
            double distance2 = distance2_3(found, normal);
            if (!(distance2 < nearest)) continue;
            nearest = distance2;
            memcpy(code, tried, sizeof tried);
        }
}
