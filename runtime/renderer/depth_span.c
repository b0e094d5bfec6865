/* SPDX-License-Identifier: MIT
 *
 * depth_span.c - fits the depth range of a projection to the boxes it shows. z / w is monotonic
 * along view rays, so its extremes over a box are those of its corners. Replacing the projection's
 * z by (z - middle w) / half keeps w, and with it pixels and perspective. Depths become an affine
 * function of the host's, so that even blended depths (spec 5.4) can be converted back.
 */
#include "renderer/depth_span.h"

#include <math.h>
#include <string.h>

/* The corners of a box in clip space, and by how much z / w changes there where the distance from
 * the eye grows. */
typedef struct corners {
    double clip[8][4];
    double by_scale[8];  /* for a distance that grows by a factor: derivative by the factor */
    double by_length[8]; /* derivative by the distance, an upper bound */
} corners;

static corners corners_of(const double modelview[16], const double p[16], const float min[3],
                          const float max[3]) {
    corners c;
    double length = sqrt(p[3] * p[3] + p[7] * p[7] + p[11] * p[11]);
    for (int k = 0; k < 8; ++k) {
        double eye[3], *clip = c.clip[k];
        for (int row = 0; row < 3; ++row) {
            eye[row] = modelview[12 + row];
            for (int axis = 0; axis < 3; ++axis)
                eye[row] +=
                    modelview[4 * axis + row] * (double)(k >> axis & 1 ? max[axis] : min[axis]);
        }
        for (int row = 0; row < 4; ++row)
            clip[row] = p[row] * eye[0] + p[4 + row] * eye[1] + p[8 + row] * eye[2] + p[12 + row];
        double z = clip[2] - p[14], w = clip[3] - p[15];
        c.by_scale[k] = fabs(z - clip[2] / clip[3] * w) / clip[3];
        /* No point with this w is nearer to the eye than w / length. */
        c.by_length[k] = length > 0.0 ? c.by_scale[k] * length / clip[3] : fabs(p[10] / clip[3]);
    }
    return c;
}

/* Returns 1 where all of the box lies behind the eye or beyond one side of the view. */
static int is_outside(const corners *c) {
    unsigned outside = ~0u;
    for (int k = 0; k < 8; ++k) {
        const double *clip = c->clip[k], w = clip[3];
        unsigned here = w <= 0.0;
        for (int axis = 0; axis < 3; ++axis)
            here |= (clip[axis] < -w ? 2u : 0u) << 2 * axis | (clip[axis] > w ? 4u : 0u)
                                                                  << 2 * axis;
        outside &= here;
    }
    return outside != 0;
}

/* The span gets this room around the box:
 *
 * In front of it, as far as the near plane allows, twice the depth of the box. The filter compares
 * splats as if they were nearer than they are, which must not move them out of the depth range; it
 * leaves 2 |g| to the near plane where there is no more room (spec 5.8).
 *
 * On both sides a 4096th of the distance, which is far above rounding and makes room where the box
 * is flat, and the greatest shift of the visibility pass. Without that room the farthest splats
 * would be shifted out of the depth range and would leave no trace in the depth buffer. */
void psplat_depth_span_add(psplat_depth_span *span, const double modelview[16],
                           const double projection[16], const float min[3], const float max[3],
                           double shift) {
    corners c = corners_of(modelview, projection, min, max);
    if (is_outside(&c)) return;
    double low = HUGE_VAL, high = -HUGE_VAL, room = 0.0;
    for (int k = 0; k < 8; ++k) {
        double ndc = c.clip[k][2] / c.clip[k][3];
        if (!(c.clip[k][3] > 0.0) || !isfinite(ndc)) {
            *span = PSPLAT_SPAN_WHOLE;
            return;
        }
        low = fmin(low, ndc);
        high = fmax(high, ndc);
        room = fmax(room, c.by_scale[k] / 4096.0 + c.by_length[k] * shift);
    }
    span->low = fmin(span->low, fmax(low - 2.0 * (high - low) - room, -1.0));
    span->high = fmax(span->high, fmin(high + room, 1.0));
}

double psplat_depth_span_middle(const psplat_depth_span *span) {
    return 0.5 * (span->low + span->high);
}

/* The lower bound keeps the ends of a span apart in double precision. */
double psplat_depth_span_half(const psplat_depth_span *span) {
    return fmax(0.5 * (span->high - span->low), 0x1p-44);
}

void psplat_depth_span_project(const psplat_depth_span *span, const double projection[16],
                               double fitted[16]) {
    double middle = psplat_depth_span_middle(span), half = psplat_depth_span_half(span);
    memcpy(fitted, projection, 16 * sizeof *fitted);
    for (int i = 0; i < 4; ++i)
        fitted[4 * i + 2] = (projection[4 * i + 2] - middle * projection[4 * i + 3]) / half;
}
