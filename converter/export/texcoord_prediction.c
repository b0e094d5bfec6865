/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_prediction.c - what the texture coordinates of a splat say about those of the next one
 * in a stream (spec 3.12).
 *
 * Between two splats of a chart coordinates are taken for a cubic polynomial: its first and second
 * derivatives at both centres tell how far it goes from one to the other. What is predicted decides
 * what a reader reads, but the arithmetic is that of doubles, whose last bits no two libraries have
 * in common; therefore predictions next to where rounding turns over are refused, and rounding does
 * not turn over at halves, which symmetric models meet all the time.
 */
#include "export/texcoord_prediction.h"

#include "base/angle.h"
#include "base/vector.h"
#include "splats/quantize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where rounding turns over, and how near a prediction may be to that, steps (spec 3.12). */
static const double turnover = 0.49, least_distance = 1e-8;
/* The least of 1 plus the cosine between two normals over which directions are carried. */
static const double least_carried = 0.01;

/* Finds the unit normal of an octahedral code without the rounding of the codec's filter. */
static void code_normal(const int32_t code[2], int bits, double normal[3]) {
    int32_t z = (1 << (bits - 1)) - 1 - abs(code[0]) - abs(code[1]), fold = z < 0 ? z : 0;
    normal[0] = code[0] + (code[0] >= 0 ? fold : -fold);
    normal[1] = code[1] + (code[1] >= 0 ? fold : -fold);
    normal[2] = z;
    double length = sqrt(dot3(normal, normal));
    for (int k = 0; k < 3; ++k) normal[k] /= length;
}

static void make_axes(const psplat_attribute_table *table, size_t index, double axes[3][3]) {
    const psplat_precision *p = &table->splats->precision;
    const psplat_quantized_splat *code = &table->codes[index];
    double b1[3], b2[3], angle = PSPLAT_PI * (code->turn * p->turn_step);
    code_normal(code->normal, p->normal_bits, axes[2]);
    psplat_turn_basis(axes[2], b1, b2);
    for (int k = 0; k < 3; ++k) axes[0][k] = cos(angle) * b1[k] + sin(angle) * b2[k];
    cross3(axes[1], axes[2], axes[0]);
}

void psplat_texcoord_field_make(const psplat_attribute_table *table, size_t index,
                                const psplat_texcoord_steps *steps, psplat_texcoord_field *field) {
    const psplat_quantized_splat *code = &table->codes[index];
    make_axes(table, index, field->axes);
    for (int k = 0; k < 3; ++k)
        field->center[k] =
            (double)(code->position[k] - table->low[k]) / (double)(1u << steps->low_bits);
    for (int k = 0; k < 2; ++k) {
        int32_t radius = code->scale[k] - table->least_scale;
        field->radius[k] = steps->first_radius * exp(radius * steps->radius_step);
    }
    for (int i = 0; i < 4; ++i)
        field->along[i / 2][i % 2] = code->texcoord.along[i / 2][i % 2] * steps->along;
    for (int i = 0; i < 6; ++i)
        field->bends[i / 2][i % 2] = code->texcoord.bends[i / 2][i % 2] * steps->bend;
}

/* Finds the gradient of a coordinate at the centre, over a unit of length. */
static void gradient(const psplat_texcoord_field *f, int k, double out[3]) {
    memset(out, 0, 3 * sizeof *out);
    for (int axis = 0; axis < 2; ++axis)
        mad3(out, f->along[axis][k] / f->radius[axis], f->axes[axis]);
}

/* Finds how much the gradient of a coordinate changes over d. */
static void change(const psplat_texcoord_field *f, int k, const double d[3], double out[3]) {
    double u = dot3(d, f->axes[0]) / f->radius[0], v = dot3(d, f->axes[1]) / f->radius[1];
    memset(out, 0, 3 * sizeof *out);
    mad3(out, (2 * u * f->bends[0][k] + v * f->bends[1][k]) / f->radius[0], f->axes[0]);
    mad3(out, (u * f->bends[1][k] + 2 * v * f->bends[2][k]) / f->radius[1], f->axes[1]);
}

/* Turns a direction of the plane of one normal into that of the other. */
static void carry(const double from[3], const double to[3], double x[3]) {
    double whole = 1 + dot3(from, to), part = -dot3(x, to) / whole;
    if (whole < least_carried) {
        memset(x, 0, 3 * sizeof *x);
        return;
    }
    mad3(x, part, from);
    mad3(x, part, to);
}

void psplat_texcoord_predict_slopes(const psplat_texcoord_field *from,
                                    const psplat_texcoord_field *to, double along[2][2]) {
    double d[3], slope[3], curve[3];
    sub3(d, to->center, from->center);
    for (int k = 0; k < 2; ++k) {
        gradient(from, k, slope);
        change(from, k, d, curve);
        mad3(slope, 0.5, curve);
        carry(from->axes[2], to->axes[2], slope);
        change(to, k, d, curve);
        mad3(slope, 0.5, curve);
        for (int axis = 0; axis < 2; ++axis)
            along[axis][k] = to->radius[axis] * dot3(slope, to->axes[axis]);
    }
}

void psplat_texcoord_predict_move(const psplat_texcoord_field *from,
                                  const psplat_texcoord_field *to, double move[2]) {
    double d[3], first[3], second[3], curves[2][3];
    sub3(d, to->center, from->center);
    for (int k = 0; k < 2; ++k) {
        gradient(from, k, first);
        gradient(to, k, second);
        change(from, k, d, curves[0]);
        change(to, k, d, curves[1]);
        move[k] =
            (dot3(first, d) + dot3(second, d)) / 2 + (dot3(curves[0], d) - dot3(curves[1], d)) / 12;
    }
}

int32_t psplat_texcoord_round(double prediction, int32_t most, int *is_safe) {
    if (isnan(prediction)) return 0;
    double place = fmin(fmax(prediction, -most), most) + turnover, whole = floor(place);
    if (place - whole < least_distance || place - whole > 1 - least_distance) *is_safe = 0;
    return (int32_t)whole;
}
