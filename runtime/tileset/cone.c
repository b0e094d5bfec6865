/* SPDX-License-Identifier: MIT
 *
 * cone.c - the smallest cone around two.
 */
#include "tileset/cone.h"

#include "core/matrix.h"

#include <math.h>
#include <string.h>

static double angle_of(double cosine) {
    return acos(fmax(fmin(cosine, 1.0), -1.0));
}

static void forget(double cone[4]) {
    cone[3] = -2.0;
}

/* Turns the unit vector from by an angle towards the unit vector to, gamma away, and makes it the
 * axis. */
static void turn(double cone[4], const double to[4], double gamma, double angle) {
    double a = sin(gamma - angle) / sin(gamma), b = sin(angle) / sin(gamma);
    for (int i = 0; i < 3; ++i) cone[i] = a * cone[i] + b * to[i];
    double length = sqrt(psplat_dot3(cone, cone));
    for (int i = 0; i < 3; ++i) cone[i] /= length;
}

void psplat_tile_cone_add(double cone[4], const double other[4]) {
    const double pi = 3.14159265358979323846;
    if (cone[3] < -1.0) return;
    if (other[3] < -1.0) {
        forget(cone);
        return;
    }
    double alpha = angle_of(cone[3]), beta = angle_of(other[3]);
    double gamma = angle_of(psplat_dot3(cone, other)), half = 0.5 * (alpha + beta + gamma);
    if (gamma + beta <= alpha) return;
    if (gamma + alpha <= beta) {
        memcpy(cone, other, 4 * sizeof *cone);
        return;
    }
    if (!(half < pi) || !(gamma < pi - 1e-6)) { /* opposite axes have no plane to turn in */
        forget(cone);
        return;
    }
    if (gamma > 1e-9) turn(cone, other, gamma, half - alpha);
    cone[3] = cos(half + 1e-9); /* rounded outwards */
}
