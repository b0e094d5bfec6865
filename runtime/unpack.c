/* SPDX-License-Identifier: MIT
 *
 * unpack.c - what integers of attributes stand for: they come as numbers of -1 ... 1 or 0 ... 1 and
 * leave as what the floats of the attribute's other form are (spec 3.3, 3.6, 3.9). All in double
 * precision, so that nothing is lost beyond the last rounding.
 */
#include "gltf.h"

#include <math.h>

/* cos and sin of pi t for |t| <= 1: of what is left of the nearest quarter turn by Taylor's series,
 * whose error is 1e-11, then turned. The C library's would take most of the time of opening a
 * file. */
static void turn_by(double t, double *cosine, double *sine) {
    const double pi = 3.14159265358979323846;
    int quarters = (int)(t * 2 + (t < 0 ? -0.5 : 0.5));
    double a = pi * (t - 0.5 * quarters), b = a * a;
    double s = a * (1 - b / 6 * (1 - b / 20 * (1 - b / 42 * (1 - b / 72 * (1 - b / 110)))));
    double c =
        1 - b / 2 * (1 - b / 12 * (1 - b / 30 * (1 - b / 56 * (1 - b / 90 * (1 - b / 132)))));
    double x = quarters & 1 ? -s : c, y = quarters & 1 ? c : s;
    *cosine = quarters & 2 ? -x : x;
    *sine = quarters & 2 ? -y : y;
}

/* Eq. (0): the axes B1, B2, N are x, y, z turned the short way from z to N, or from -z, after half
 * a turn about x; and U is B1 turned about N. */
void psplat_unpack_turn(const float normal[3], float turn, float quaternion[4]) {
    double x = (double)normal[0], y = (double)normal[1], z = (double)normal[2];
    double q[4] = {-y, x, 0, 1 + z}, c, s;
    turn_by(0.5 * (double)turn, &c, &s);
    if (z < 0) q[0] = 1 - z, q[1] = 0, q[2] = x, q[3] = -y;
    double scale = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    quaternion[0] = (float)((q[0] * c + q[1] * s) * scale);
    quaternion[1] = (float)((q[1] * c - q[0] * s) * scale);
    quaternion[2] = (float)((q[2] * c + q[3] * s) * scale);
    quaternion[3] = (float)((q[3] * c - q[2] * s) * scale);
}

/* Backwards, as what is written takes more room than what is read. */
void psplat_unpack_lines(float *values, size_t count, const float range[2]) {
    for (size_t i = count; i-- > 0;) {
        double cosine, sine;
        float turn = values[2 * i] * range[0], distance = values[2 * i + 1] * range[1];
        turn_by((double)turn, &cosine, &sine);
        values[3 * i] = (float)cosine;
        values[3 * i + 1] = (float)sine;
        values[3 * i + 2] = distance;
    }
}

void psplat_unpack_radii(float *values, size_t count, const double range[2], double step) {
    double rate = log(range[1] / range[0]);
    for (size_t i = 0; i < count; ++i) {
        float *radius = values + 2 * i;
        /* A little more than a step: these are rounded quotients. */
        if (radius[1] > radius[0] && (double)(radius[1] - radius[0]) < 1.01 * step)
            radius[0] = radius[1];
        for (size_t k = 0; k < 2; ++k)
            radius[k] = (float)(range[0] * exp(rate * (double)radius[k]));
    }
}

void psplat_unpack_scaled(float *values, size_t count, float range) {
    for (size_t i = 0; i < count; ++i) values[i] *= range;
}
