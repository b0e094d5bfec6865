/* SPDX-License-Identifier: MIT
 *
 * unpack.c - turns integers of attributes into what they stand for. They come as numbers from -1
 * to 1 or from 0 to 1 and become what the floats of the attribute's other form are (spec 3.3,
 * 3.6, 3.9). All of it is computed in double precision, so that nothing but the last rounding is
 * lost.
 */
#include "asset/gltf.h"

#include <math.h>

/* Computes cos and sin of pi t: the rest to the nearest quarter turn by Taylor's series, whose
 * error is 1e-11, and then the quarter turns. The C library's functions would take most of the time
 * of opening a file. */
static inline void turn_by(double t, double *cosine, double *sine) {
    const double pi = 3.14159265358979323846;
    int quarters = (int)(t * 2 + (t < 0 ? -0.5 : 0.5));
    double a = pi * (t - 0.5 * quarters), b = a * a, b2 = b * b;
    double s = a * (1 - b * (1.0 / 6) + b2 * (1.0 / 120 - b * (1.0 / 5040)) +
                    b2 * b2 * (1.0 / 362880 - b * (1.0 / 39916800)));
    double c = 1 - b * 0.5 + b2 * (1.0 / 24 - b * (1.0 / 720)) +
               b2 * b2 * (1.0 / 40320 - b * (1.0 / 3628800) + b2 * (1.0 / 479001600));
    double x = quarters & 1 ? -s : c, y = quarters & 1 ? c : s;
    *cosine = quarters & 2 ? -x : x;
    *sine = quarters & 2 ? -y : y;
}

/* Eq. (0) of the spec: the axes B1, B2, N are x, y, z turned the short way from z to N; near -z
 * they are turned from -z, after half a turn about x. U is B1 turned about N. */
static inline void unpack_turn(const float normal[3], float turn, float quaternion[4]) {
    double x = (double)normal[0], y = (double)normal[1], z = (double)normal[2], c, s;
    turn_by(0.5 * (double)turn, &c, &s);
    int is_below = z < 0;
    double w = 1 + fabs(z), scale = 1 / sqrt(x * x + y * y + w * w);
    const double q[4] = {is_below ? w : -y, is_below ? 0 : x, is_below ? x : 0, is_below ? -y : w};
    quaternion[0] = (float)((q[0] * c + q[1] * s) * scale);
    quaternion[1] = (float)((q[1] * c - q[0] * s) * scale);
    quaternion[2] = (float)((q[2] * c + q[3] * s) * scale);
    quaternion[3] = (float)((q[3] * c - q[2] * s) * scale);
}

void psplat_unpack_turns(const float *normals, const float *turns, size_t count,
                         float *quaternions) {
    for (size_t i = 0; i < count; ++i) unpack_turn(normals + 3 * i, turns[i], quaternions + 4 * i);
}

static inline void unpack_line(const float turn_and_distance[2], const float range[2],
                               float line[3]) {
    double cosine, sine;
    float turn = turn_and_distance[0] * range[0], distance = turn_and_distance[1] * range[1];
    turn_by((double)turn, &cosine, &sine);
    line[0] = (float)cosine;
    line[1] = (float)sine;
    line[2] = distance;
}

/* This and the next go backwards, because what is written takes more room than what is read. */
void psplat_unpack_lines(float *values, size_t count, const float range[2]) {
    for (size_t i = count; i-- > 0;) unpack_line(values + 2 * i, range, values + 3 * i);
}

void psplat_unpack_bent_lines(float *values, size_t count, const float range[2], float bend_range) {
    for (size_t i = count; i-- > 0;) {
        float bend = values[3 * i + 2] * bend_range;
        unpack_line(values + 3 * i, range, values + 4 * i);
        values[4 * i + 3] = bend;
    }
}

/* Tabulates by the integers' high and low bytes: an exponential for each integer would take longer
 * than everything else. */
void psplat_radii_set(psplat_radii *radii, const double range[2], float largest) {
    double rate = log(range[1] / range[0]) / (double)largest;
    radii->largest = largest;
    for (int i = 0; i < 256; ++i) {
        radii->high[i] = range[0] * exp(rate * 256 * i);
        radii->low[i] = exp(rate * i);
    }
}

void psplat_unpack_radii(float *values, size_t count, const psplat_radii *radii) {
    for (size_t i = 0; i < count; ++i) {
        float *radius = values + 2 * i;
        unsigned u = (unsigned)(radius[0] * radii->largest + 0.5f);
        unsigned v = (unsigned)(radius[1] * radii->largest + 0.5f);
        if (v == u + 1) u = v;
        radius[0] = (float)(radii->high[u >> 8] * radii->low[u & 255]);
        radius[1] = (float)(radii->high[v >> 8] * radii->low[v & 255]);
    }
}

void psplat_unpack_scaled(float *values, size_t count, float range) {
    for (size_t i = 0; i < count; ++i) values[i] *= range;
}
