/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_frame.c - conversion between the rotation quaternion of a splat and its axes U, V, N.
 */
#include "splats/splat_frame.h"

#include "base/region.h"

#include <math.h>

/* This is Shepperd's (1978) method: it divides by the largest of the four components. */
void psplat_quaternion_of_axes(const double u[3], const double v[3], const double n[3],
                               float rotation[4]) {
    const double m[3][3] = {{u[0], v[0], n[0]}, {u[1], v[1], n[1]}, {u[2], v[2], n[2]}};
    double trace = m[0][0] + m[1][1] + m[2][2], q[4];
    int i = m[0][0] >= m[1][1] ? (m[0][0] >= m[2][2] ? 0 : 2) : (m[1][1] >= m[2][2] ? 1 : 2);
    if (trace > m[i][i]) {
        q[3] = 1 + trace;
        q[0] = m[2][1] - m[1][2], q[1] = m[0][2] - m[2][0], q[2] = m[1][0] - m[0][1];
    } else {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        q[i] = 1 + m[i][i] - m[j][j] - m[k][k];
        q[j] = m[j][i] + m[i][j], q[k] = m[k][i] + m[i][k], q[3] = m[k][j] - m[j][k];
    }
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (q[3] < 0) length = -length;
    for (int c = 0; c < 4; ++c) rotation[c] = (float)(q[c] / length);
}

static void take_lines(const psplat_splat *splat, uint32_t seam_lines, psplat_region *region) {
    for (uint32_t i = 0; i < splat->clip_count; ++i) {
        for (int k = 0; k < 3; ++k) region->lines[i][k] = (double)splat->clip[i][k];
        region->bends[i] = (double)splat->bend[i];
    }
    region->seam_count = seam_lines < splat->clip_count ? seam_lines : splat->clip_count;
    region->line_count = splat->clip_count - region->seam_count;
}

void psplat_splat_region(const psplat_splat *splat, uint32_t seam_lines, psplat_region *region) {
    double q[4], length = 0;
    for (int k = 0; k < 4; ++k) length += (double)splat->rotation[k] * (double)splat->rotation[k];
    for (int k = 0; k < 4; ++k) q[k] = (double)splat->rotation[k] / sqrt(length);
    double x = q[0], y = q[1], z = q[2], w = q[3];
    *region = (psplat_region){
        .center = {(double)splat->center[0], (double)splat->center[1], (double)splat->center[2]},
        .u = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
        .v = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
        .n = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)},
        .radius = {(double)splat->radius[0], (double)splat->radius[1]}};
    take_lines(splat, seam_lines, region);
    region->slope[0] = -(double)splat->shape[0];
    region->slope[1] = -(double)splat->shape[1];
    region->hessian[0] = -(double)splat->shape[2] / region->radius[0];
    region->hessian[1] = -(double)splat->shape[4] / region->radius[0];
    region->hessian[2] = -(double)splat->shape[3] / region->radius[1];
}
