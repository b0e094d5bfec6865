/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize.c - rounding of splats to the integers that files hold, and back (spec 3.9).
 *
 * Values are rounded one after another, each in the frame that the rounded ones before it make: N
 * comes first, then the turn about N, and then tilt, normal field and clip lines in the frame of
 * both. So the error of one value does not add to that of the next.
 */
#include "splats/quantize.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/vector.h"
#include "splats/octahedron.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"

#include <math.h>
#include <string.h>

void psplat_turn_basis(const double n[3], double b1[3], double b2[3]) {
    double s = n[2] < 0 ? -1 : 1, a = -1 / (s + n[2]), b = n[0] * n[1] * a;
    const double first[3] = {1 + s * n[0] * n[0] * a, s * b, -s * n[0]};
    const double second[3] = {b, s + n[1] * n[1] * a, -n[1]};
    memcpy(b1, first, sizeof first);
    memcpy(b2, second, sizeof second);
}

/* Finds U and V of a normal and a turn, in half turns. */
static void axes_of(const double n[3], double turn, double u[3], double v[3]) {
    double b1[3], b2[3], c = cos(PSPLAT_PI * turn), s = sin(PSPLAT_PI * turn);
    psplat_turn_basis(n, b1, b2);
    for (int k = 0; k < 3; ++k) u[k] = c * b1[k] + s * b2[k];
    cross3(v, n, u);
}

static int32_t round_to(double value, double step) {
    return (int32_t)lrint(fmin(fmax(value / step, -1e9), 1e9));
}

/* Returns the turn of u about n in steps, between 0 and a half turn. *flipped tells whether that
 * turn leads to -u instead of u. */
static int32_t encode_turn(const double n[3], const double u[3], double step, int *flipped) {
    double b1[3], b2[3];
    psplat_turn_basis(n, b1, b2);
    int32_t whole = round_to(1, step);
    int32_t turn = round_to(atan2(dot3(u, b2), dot3(u, b1)) / PSPLAT_PI, step);
    *flipped = 0;
    for (; turn < 0; turn += whole) *flipped ^= 1;
    for (; turn >= whole; turn -= whole) *flipped ^= 1;
    return turn;
}

/* Returns the least distance at which a line of direction (a, b) keeps all of the unit disc that
 * the given line keeps. It must keep both ends of the given line's chord, and the point of the arc
 * that is farthest out where that belongs to the kept part. */
static double conservative_distance(const double line[3], double a, double b) {
    double length = hypot(line[0], line[1]), x = line[0] / length, y = line[1] / length;
    double c = line[2] / length;
    if (!(fabs(c) < 1)) return c;
    double half = sqrt(1 - c * c), ends[2][2] = {{-c * x - half * y, -c * y + half * x},
                                                 {-c * x + half * y, -c * y - half * x}};
    double least = fmax(-(a * ends[0][0] + b * ends[0][1]), -(a * ends[1][0] + b * ends[1][1]));
    return x * -a + y * -b >= -c ? 1 : least;
}

static void encode_line(const psplat_precision *p, const double line[3], int32_t code[2]) {
    int32_t whole = round_to(1, p->line_turn_step);
    int32_t turn = round_to(atan2(line[1], line[0]) / PSPLAT_PI, p->line_turn_step);
    if (turn <= -whole) turn += 2 * whole;
    if (turn > whole) turn -= 2 * whole;
    double angle = PSPLAT_PI * turn * p->line_turn_step;
    double distance = fmin(fmax(conservative_distance(line, cos(angle), sin(angle)), -1), 1);
    /* The 0.01 steps absorb the rounding to float of a line that is on the grid already. */
    double steps = ceil(distance / p->line_step - 0.01);
    code[0] = turn;
    code[1] = (int32_t)fmin(fmax(steps, -1 / p->line_step), 1 / p->line_step);
}

void psplat_quantize_line(const psplat_precision *p, double line[3]) {
    int32_t code[2];
    encode_line(p, line, code);
    line[0] = cos(PSPLAT_PI * code[0] * p->line_turn_step);
    line[1] = sin(PSPLAT_PI * code[0] * p->line_turn_step);
    line[2] = code[1] * p->line_step;
}

void psplat_quantize_field(const psplat_precision *p, double field[5]) {
    for (int k = 0; k < 5; ++k) {
        double step = k < 2 ? p->tilt_step : p->field_step;
        field[k] = round_to(field[k], step) * step;
    }
}

/* Encodes the normal field in the axes of the code: the slopes at the centre as tilt, and their
 * change over the radii as field. */
static void encode_field(const psplat_precision *p, const psplat_region *region,
                         const psplat_splat *splat, const double axes[3][3],
                         psplat_quantized_splat *code) {
    double normal[3], turned[2][2], bent[2][2];
    for (int k = 0; k < 3; ++k) normal[k] = (double)splat->normal[k];
    double height = dot3(normal, axes[2]);
    /* The Hessian for each unit of length (spec 3.5), and its products with the code's axes. */
    double xx = (double)splat->gradient[0] / region->radius[0];
    double yy = (double)splat->gradient[1] / region->radius[1];
    double xy = (double)splat->gradient[2] / region->radius[0];
    for (int k = 0; k < 2; ++k) {
        code->tilt[k] = round_to(dot3(normal, axes[k]) / height, p->tilt_step);
        turned[k][0] = dot3(axes[k], region->u);
        turned[k][1] = dot3(axes[k], region->v);
        bent[k][0] = xx * turned[k][0] + xy * turned[k][1];
        bent[k][1] = xy * turned[k][0] + yy * turned[k][1];
    }
    static const int pairs[3][2] = {{0, 0}, {1, 1}, {1, 0}};
    for (int i = 0; i < 3; ++i) {
        const double *a = turned[pairs[i][0]], *b = bent[pairs[i][1]];
        code->field[i] =
            round_to((a[0] * b[0] + a[1] * b[1]) * region->radius[i == 1], p->field_step);
    }
}

void psplat_quantized_axes(const psplat_precision *p, const int32_t normal[2], const double u[3],
                           double axes[3][3]) {
    int flipped;
    psplat_octahedron_normal(normal, p->normal_bits, axes[2]);
    axes_of(axes[2], encode_turn(axes[2], u, p->turn_step, &flipped) * p->turn_step, axes[0],
            axes[1]);
}

void psplat_quantize_splat(const psplat_precision *p, const psplat_splat *splat,
                           psplat_quantized_splat *code) {
    psplat_region region;
    double axes[3][3];
    psplat_splat_region(splat, &region);
    memset(code, 0, sizeof *code);
    psplat_octahedron_encode(region.n, p->normal_bits, code->normal);
    psplat_octahedron_normal(code->normal, p->normal_bits, axes[2]);
    code->turn = encode_turn(axes[2], region.u, p->turn_step, &code->flipped);
    axes_of(axes[2], code->turn * p->turn_step, axes[0], axes[1]);
    for (int k = 0; k < 3; ++k) code->position[k] = round_to(region.center[k], p->unit);
    for (int k = 0; k < 2; ++k)
        code->scale[k] = round_to(log(region.radius[k] / p->unit), p->scale_step);
    if (code->scale[1] > code->scale[0]) code->scale[0] = code->scale[1];
    encode_field(p, &region, splat, (const double(*)[3])axes, code);
    for (uint32_t i = 0; i < splat->clip_count; ++i) {
        double line[3];
        for (int k = 0; k < 3; ++k)
            line[k] = region.lines[i][k] * (k < 2 && code->flipped ? -1 : 1);
        encode_line(p, line, code->lines[i]);
    }
}

void psplat_dequantize_splat(const psplat_precision *p, const psplat_quantized_splat *code,
                             psplat_splat *splat) {
    double n[3], u[3], v[3], normal[3];
    psplat_octahedron_normal(code->normal, p->normal_bits, n);
    axes_of(n, code->turn * p->turn_step, u, v);
    psplat_quaternion_of_axes(u, v, n, splat->rotation);
    memcpy(normal, n, sizeof normal);
    mad3(normal, code->tilt[0] * p->tilt_step, u);
    mad3(normal, code->tilt[1] * p->tilt_step, v);
    normalize3(normal);
    for (int k = 0; k < 3; ++k) {
        splat->center[k] = (float)(code->position[k] * p->unit);
        splat->normal[k] = (float)normal[k];
        splat->gradient[k] = (float)(code->field[k] * p->field_step);
    }
    for (int k = 0; k < 2; ++k)
        splat->radius[k] = (float)(p->unit * exp(code->scale[k] * p->scale_step));
    for (uint32_t i = 0; i < splat->clip_count; ++i) {
        double angle = PSPLAT_PI * code->lines[i][0] * p->line_turn_step;
        splat->clip[i][0] = (float)cos(angle);
        splat->clip[i][1] = (float)sin(angle);
        splat->clip[i][2] = (float)(code->lines[i][1] * p->line_step);
    }
}

void psplat_round_to_precision(psplat_splats *splats) {
    if (!(splats->precision.unit > 0)) return;
    for (size_t i = 0; i < splats->count; ++i) {
        psplat_quantized_splat code;
        psplat_quantize_splat(&splats->precision, &splats->splats[i], &code);
        psplat_dequantize_splat(&splats->precision, &code, &splats->splats[i]);
        if (!splats->finishes || !code.flipped) continue;
        for (int k = 0; k < 3; ++k) {
            splats->finishes[i].color_u[k] *= -1;
            splats->finishes[i].color_v[k] *= -1;
        }
    }
}
