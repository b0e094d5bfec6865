/* SPDX-License-Identifier: MIT
 *
 * stream_texcoord.c - what the texture coordinates of a splat in a stream say about those of a
 * later one (spec 3.12): between both, coordinates are taken for a cubic polynomial.
 *
 * Predictions decide what is read, and the last bits of doubles are not the same on all machines.
 * Writers make no streams in which these bits would matter.
 */
#include "asset/stream_texcoord.h"

#include "core/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Adds s times a to r. */
static void add3(double r[3], double s, const double a[3]) {
    for (int k = 0; k < 3; ++k) r[k] += s * a[k];
}

/* Finds the unit normal of a code without the rounding of EXT_meshopt_compression's filter. */
static void code_normal(const int32_t code[2], uint32_t bits, double n[3]) {
    int32_t z = (int32_t)(1u << (bits - 1)) - 1 - abs(code[0]) - abs(code[1]), fold = z < 0 ? z : 0;
    n[0] = code[0] + (code[0] >= 0 ? fold : -fold);
    n[1] = code[1] + (code[1] >= 0 ? fold : -fold);
    n[2] = z;
    double length = sqrt(psplat_dot3(n, n));
    for (int k = 0; k < 3; ++k) n[k] /= length;
}

void psplat_stream_texcoord_axes(const int32_t code[2], uint32_t bits, double turn,
                                 double axes[3][3]) {
    double *n = axes[2], *u = axes[0], *v = axes[1];
    double c = cos(3.14159265358979323846 * turn), s = sin(3.14159265358979323846 * turn);
    code_normal(code, bits, n);
    double side = n[2] < 0 ? -1 : 1, a = -1 / (side + n[2]), b = n[0] * n[1] * a;
    const double b1[3] = {1 + side * n[0] * n[0] * a, side * b, -side * n[0]};
    const double b2[3] = {b, side + n[1] * n[1] * a, -n[1]};
    for (int k = 0; k < 3; ++k) u[k] = c * b1[k] + s * b2[k];
    for (int k = 0; k < 3; ++k)
        v[k] = n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3];
}

/* Finds the gradient of a coordinate at the centre, over a unit of length. */
static void gradient(const psplat_stream_texcoord *f, int k, double out[3]) {
    memset(out, 0, 3 * sizeof *out);
    for (int axis = 0; axis < 2; ++axis)
        add3(out, f->along[axis][k] / f->radius[axis], f->axes[axis]);
}

/* Finds how much the gradient of a coordinate changes over d. */
static void change(const psplat_stream_texcoord *f, int k, const double d[3], double out[3]) {
    double u = psplat_dot3(d, f->axes[0]) / f->radius[0];
    double v = psplat_dot3(d, f->axes[1]) / f->radius[1];
    memset(out, 0, 3 * sizeof *out);
    add3(out, (2 * u * f->bends[0][k] + v * f->bends[1][k]) / f->radius[0], f->axes[0]);
    add3(out, (u * f->bends[1][k] + 2 * v * f->bends[2][k]) / f->radius[1], f->axes[1]);
}

/* Turns a direction of the plane of one normal into that of the other; 0 for opposite ones. */
static void carry(const double from[3], const double to[3], double x[3]) {
    double whole = 1 + psplat_dot3(from, to), part = -psplat_dot3(x, to) / whole;
    if (whole < 0.01) {
        memset(x, 0, 3 * sizeof *x);
        return;
    }
    add3(x, part, from);
    add3(x, part, to);
}

static void between(const psplat_stream_texcoord *from, const psplat_stream_texcoord *to,
                    double d[3]) {
    for (int k = 0; k < 3; ++k) d[k] = to->center[k] - from->center[k];
}

void psplat_stream_texcoord_slopes(const psplat_stream_texcoord *from,
                                   const psplat_stream_texcoord *to, double along[2][2]) {
    double d[3], slope[3], curve[3];
    between(from, to, d);
    for (int k = 0; k < 2; ++k) {
        gradient(from, k, slope);
        change(from, k, d, curve);
        add3(slope, 0.5, curve);
        carry(from->axes[2], to->axes[2], slope);
        change(to, k, d, curve);
        add3(slope, 0.5, curve);
        for (int axis = 0; axis < 2; ++axis)
            along[axis][k] = to->radius[axis] * psplat_dot3(slope, to->axes[axis]);
    }
}

void psplat_stream_texcoord_move(const psplat_stream_texcoord *from,
                                 const psplat_stream_texcoord *to, double move[2]) {
    double d[3], slopes[2][3], curves[2][3];
    between(from, to, d);
    for (int k = 0; k < 2; ++k) {
        gradient(from, k, slopes[0]);
        gradient(to, k, slopes[1]);
        change(from, k, d, curves[0]);
        change(to, k, d, curves[1]);
        move[k] = (psplat_dot3(slopes[0], d) + psplat_dot3(slopes[1], d)) / 2 +
                  (psplat_dot3(curves[0], d) - psplat_dot3(curves[1], d)) / 12;
    }
}

int32_t psplat_stream_texcoord_round(double prediction, int32_t most) {
    if (isnan(prediction)) return 0;
    return (int32_t)floor(fmin(fmax(prediction, -most), most) + 0.49);
}
