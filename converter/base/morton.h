/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * morton.h - places along a Morton curve, which visits points that are near each other one after
 * the other.
 */
#ifndef PHONGSPLAT_BASE_MORTON_H
#define PHONGSPLAT_BASE_MORTON_H

#include "base/vector.h"

#include <stdint.h>

/* Returns the place, below 2^30, of a point along a Morton curve through the cube of a middle and
 * half a side >= 0. Points outside count as the nearest ones inside. */
static inline uint32_t psplat_morton_code(const double p[3], const double middle[3],
                                          double half_side) {
    enum { BITS = 10 };
    double scale = half_side > 0 ? ((1 << BITS) - 1) / (2 * half_side) : 0;
    uint32_t code = 0;
    for (int k = 0; k < 3; ++k) {
        double x = (p[k] - middle[k] + half_side) * scale;
        uint32_t cell = (uint32_t)min2(max2(x, 0), (1 << BITS) - 1);
        for (int bit = 0; bit < BITS; ++bit) code |= (cell >> bit & 1) << (3 * bit + k);
    }
    return code;
}

#endif
