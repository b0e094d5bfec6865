/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize.c - rounding of splats to the integers that files hold, and back (spec 3.9).
 *
 * Values are rounded one after another, each in the frame that the rounded ones before it make: the
 * radii, which choose the steps of most others, N, the turn about N, and then tilt, normal field
 * and clip lines in the frame of both. So the error of one value does not add to that of the next.
 */
#include "splats/quantize.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/vector.h"
#include "splats/octahedron.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The greatest bend of a clip line (spec 3.6) less what rounding to floats may add, and the most
 * steps of its distance, as many as two bytes hold. */
static const double greatest_bend = 4 - 1e-5;
/* The same of the left side of spec (3a), with which the normal stays within acos 0.05 of N, too.
 */
static const double greatest_field_slope = 19.9;
enum { MOST_LINE_STEPS = 32767 };

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

static int least_of(int a, int b) {
    return a < b ? a : b;
}

/* Returns the bits of a turn of an ellipse whose radii are so many steps apart (spec 3.12). */
static int turn_bits(const psplat_precision *p, int elongation) {
    int bits = 0;
    for (int parts = 32 * elongation / p->halving; parts; parts >>= 1) ++bits;
    return least_of(bits + elongation / (3 * p->halving), ilogb(1 / p->turn_step));
}

psplat_precision psplat_precision_at(const psplat_precision *p, const double radius[2]) {
    psplat_precision at = *p;
    if (!p->halving) return at;
    int large = round_to(log(radius[0] / p->unit), p->scale_step);
    int small = round_to(log(radius[1] / p->unit), p->scale_step);
    int grade = large < p->reference ? (p->reference - large) / p->halving : 0;
    grade = least_of(grade, PSPLAT_MOST_GRADE);
    at.halving = 0;
    at.normal_shift = least_of(grade, p->normal_grades);
    at.line_shift = least_of(grade, ilogb(1 / p->line_turn_step) - 1);
    double line = 1 << at.line_shift;
    at.turn_step = 1.0 / (1 << turn_bits(p, large > small ? large - small : 0));
    at.shape_step *= 1 << least_of(grade, p->shape_grades);
    at.line_step *= line;
    at.line_turn_step *= line;
    at.bend_step *= line;
    return at;
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
    double length = norm2(line[0], line[1]), x = line[0] / length, y = line[1] / length;
    double c = line[2] / length;
    if (!(fabs(c) < 1)) return c;
    double half = sqrt(1 - c * c), ends[2][2] = {{-c * x - half * y, -c * y + half * x},
                                                 {-c * x + half * y, -c * y - half * x}};
    double least = fmax(-(a * ends[0][0] + b * ends[0][1]), -(a * ends[1][0] + b * ends[1][1]));
    return x * -a + y * -b >= -c ? 1 : least;
}

/* A clip line (x, y, c) of unit direction, and its bend. */
typedef struct bent_line {
    double x, y, c, bend;
} bent_line;

/* Returns the value of a line at a point of the plane: at least 0 where the line keeps the point.
 */
static double line_value(const bent_line *line, const double p[2]) {
    double along = line->x * p[1] - line->y * p[0];
    return line->x * p[0] + line->y * p[1] + line->c + line->bend * along * along / 2;
}

/* Returns the least distance at which the rounded direction and bend keep all points of the unit
 * circle that the line keeps: the circle's points where the rounded line's value has no slope. */
static double distance_for_circle(const bent_line *line, const bent_line *rounded) {
    double least = -HUGE_VAL, x = fabs(rounded->bend) > 1 ? 1 / rounded->bend : 1;
    const double places[4][2] = {{-1, 0}, {1, 0}, {x, sqrt(1 - x * x)}, {x, -sqrt(1 - x * x)}};
    for (int i = 0; i < 4; ++i) {
        const double *q = places[i];
        double p[2] = {rounded->x * q[0] - rounded->y * q[1],
                       rounded->y * q[0] + rounded->x * q[1]};
        if (line_value(line, p) >= 0) least = fmax(least, rounded->c - line_value(rounded, p));
    }
    return least;
}

/* Returns how far along a line the last point lies in which it meets the unit circle; below 0 where
 * it does not. Its square M solves (c + bend M / 2)^2 + M = 1. */
static double last_place(const bent_line *line) {
    double half = line->bend * line->bend / 4, middle = (line->c * line->bend + 1) / 2;
    double rest = line->c * line->c - 1, root = middle * middle - half * rest;
    if (!(root >= 0)) return -1;
    /* The form that does not cancel; half is above 0. */
    double square = middle > 0 ? -rest / (middle + sqrt(root)) : (sqrt(root) - middle) / half;
    return square >= 0 ? fmin(sqrt(square), 1) : -1;
}

/* Returns a distance at which the rounded direction and bend keep all points of the line itself
 * within the circle. It is the greatest of the distances that some of these points need, and what
 * their second derivative along the line allows between two. */
static double distance_for_line(const bent_line *line, const bent_line *rounded) {
    enum { PLACES = 32 };
    double last = last_place(line), least = -HUGE_VAL, gap = 2 * last / PLACES;
    double sine = fabs(line->x * rounded->y - line->y * rounded->x);
    double bends = fabs(line->bend * rounded->bend);
    double change =
        fabs(line->bend - rounded->bend) + 6 * bends * sine +
        (fabs(line->bend) + fabs(rounded->bend) + bends * fabs(line->bend)) * sine * sine;
    if (last < 0) return -HUGE_VAL;
    for (int i = 0; i <= PLACES; ++i) {
        double m = i * gap - last, away = -line->c - line->bend * m * m / 2;
        double p[2] = {away * line->x - m * line->y, away * line->y + m * line->x};
        least = fmax(least, rounded->c - line_value(rounded, p));
    }
    return least + change * gap * gap / 8;
}

/* Returns the most steps of a line's distance, each as long as so many steps of a file. */
static int most_line_steps(const psplat_precision *p) {
    return MOST_LINE_STEPS >> p->line_shift;
}

/* Rounds the bend of a line, and returns the distance at which the rounded line of that direction
 * keeps all that the line keeps. What the rounded line's value is to be at least 0 for grows
 * steadily against its direction, so that the border of what the line keeps decides. */
static double encode_bend(const psplat_precision *p, const double line[3], double bend,
                          double angle, int32_t *code) {
    double length = norm2(line[0], line[1]);
    const bent_line given = {line[0] / length, line[1] / length, line[2] / length, bend * length};
    bent_line rounded = {cos(angle), sin(angle), 0, 0};
    *code = 0;
    if (p->bend_step > 0) {
        double most = floor(greatest_bend / p->bend_step);
        *code = round_to(fmin(fmax(given.bend / p->bend_step, -most), most), 1);
    }
    for (;; *code = 0) {
        rounded.bend = *code * p->bend_step;
        double distance =
            fmax(distance_for_circle(&given, &rounded), distance_for_line(&given, &rounded));
        /* Some lines that cut next to nothing off would need more steps than a file can hold. A
         * straight line never does. */
        if (!*code || distance <= most_line_steps(p) * p->line_step) return distance;
    }
}

static void encode_line(const psplat_precision *p, const double line[3], double bend,
                        int32_t code[3]) {
    int32_t whole = round_to(1, p->line_turn_step);
    int32_t turn = round_to(atan2(line[1], line[0]) / PSPLAT_PI, p->line_turn_step);
    if (turn <= -whole) turn += 2 * whole;
    if (turn > whole) turn -= 2 * whole;
    double angle = PSPLAT_PI * turn * p->line_turn_step, distance, most = 1 / p->line_step;
    code[0] = turn;
    code[2] = 0;
    if (bend != 0)
        distance = encode_bend(p, line, bend, angle, &code[2]);
    else
        distance = conservative_distance(line, cos(angle), sin(angle));
    if (code[2]) most = most_line_steps(p);
    /* The 0.01 steps absorb the rounding to float of a line that is on the grid already. */
    double steps = ceil(fmin(fmax(distance / p->line_step, -most), most) - 0.01);
    code[1] = (int32_t)fmin(fmax(steps, -most), most);
}

void psplat_quantize_line(const psplat_precision *p, double line[3], double *bend) {
    int32_t code[3];
    encode_line(p, line, *bend, code);
    line[0] = cos(PSPLAT_PI * code[0] * p->line_turn_step);
    line[1] = sin(PSPLAT_PI * code[0] * p->line_turn_step);
    line[2] = code[1] * p->line_step;
    *bend = code[2] * p->bend_step;
}

void psplat_quantize_field(const psplat_precision *p, double field[5]) {
    for (int k = 0; k < 5; ++k) {
        double step = k < 2 ? p->tilt_step : p->field_step;
        field[k] = round_to(field[k], step) * step;
    }
}

void psplat_quantize_shape(const psplat_precision *p, const double radius[2], double hessian[3]) {
    const double lengths[3] = {radius[0], radius[0], radius[1]};
    double step = psplat_precision_at(p, radius).shape_step;
    for (int k = 0; k < 3; ++k)
        hessian[k] = step > 0 ? round_to(hessian[k] * lengths[k], step) * step / lengths[k] : 0;
}

/* Rounds the changes of a field's slopes over the radii, in the axes of the code. `change` holds
 * the second derivatives along uu, vv and vu of the splat's own axes for each unit of length
 * (spec 3.5), with the sign of the field. */
static void encode_changes(const psplat_region *region, const double axes[3][3],
                           const double change[3], const double radius[2], double step,
                           int32_t code[3]) {
    static const int pairs[3][2] = {{0, 0}, {1, 1}, {1, 0}};
    double turned[2][2], bent[2][2];
    for (int k = 0; k < 2; ++k) {
        turned[k][0] = dot3(axes[k], region->u);
        turned[k][1] = dot3(axes[k], region->v);
        bent[k][0] = change[0] * turned[k][0] + change[2] * turned[k][1];
        bent[k][1] = change[2] * turned[k][0] + change[1] * turned[k][1];
    }
    for (int i = 0; i < 3; ++i) {
        const double *a = turned[pairs[i][0]], *b = bent[pairs[i][1]];
        code[i] = round_to((a[0] * b[0] + a[1] * b[1]) * radius[i == 1], step);
    }
}

static void encode_tilt(const double normal[3], const double axes[3][3], double step,
                        int32_t code[2]) {
    double height = dot3(normal, axes[2]);
    for (int k = 0; k < 2; ++k) code[k] = round_to(dot3(normal, axes[k]) / height, step);
}

/* Returns the left side of spec (3a) for a field's code: its slope at the centre and the greatest
 * change of that over the ellipse. */
static double field_slope(const psplat_precision *p, const psplat_quantized_splat *code) {
    double ratio = exp((code->scale[1] - code->scale[0]) * p->scale_step);
    double tilt = p->tilt_step * norm2(code->tilt[0], code->tilt[1]);
    double mixed = sqrt(1 + ratio * ratio) * code->field[2];
    return tilt + p->field_step * norm2(norm2(code->field[0], code->field[1]), mixed);
}

/* Takes steps off a field until it keeps the bound of spec (3a), each off its greatest number: a
 * field just within the bound may be rounded to one beyond. */
static void bound_field(const psplat_precision *p, psplat_quantized_splat *code) {
    while (field_slope(p, code) > greatest_field_slope) {
        int32_t *numbers[5] = {&code->tilt[0], &code->tilt[1], &code->field[0], &code->field[1],
                               &code->field[2]};
        int greatest = 0;
        for (int k = 1; k < 5; ++k) {
            double step = k < 2 ? p->tilt_step : p->field_step;
            double best = greatest < 2 ? p->tilt_step : p->field_step;
            if (abs(*numbers[k]) * step > abs(*numbers[greatest]) * best) greatest = k;
        }
        *numbers[greatest] += *numbers[greatest] > 0 ? -1 : 1;
    }
}

/* Encodes the normal field of a splat where it is not that of a curved surface. */
static void encode_field(const psplat_precision *p, const psplat_region *region,
                         const psplat_splat *splat, const double axes[3][3],
                         psplat_quantized_splat *code) {
    const double change[3] = {(double)splat->gradient[0] / region->radius[0],
                              (double)splat->gradient[1] / region->radius[1],
                              (double)splat->gradient[2] / region->radius[0]};
    double normal[3];
    for (int k = 0; k < 3; ++k) normal[k] = (double)splat->normal[k];
    encode_tilt(normal, axes, p->tilt_step, code->tilt);
    encode_changes(region, axes, change, region->radius, p->field_step, code->field);
    bound_field(p, code);
}

/* Returns how many steps of a precision are one of a coarser one. */
static int32_t steps_in(double coarse, double fine) {
    return fine > 0 ? round_to(coarse, fine) : 1;
}

/* Encodes the surface of a curved splat, of these radii, by the steps that these have. The radii
 * that are stored are those of the code, so that the surface keeps its curvature where they were
 * rounded. */
static void encode_shape(const psplat_precision *p, const psplat_precision *at,
                         const psplat_region *region, const double axes[3][3],
                         const double radius[2], psplat_quantized_splat *code) {
    const double change[3] = {-region->hessian[0], -region->hessian[2], -region->hessian[1]};
    double normal[3];
    if (!(p->shape_step > 0)) return;
    memcpy(normal, region->n, sizeof normal);
    mad3(normal, -region->slope[0], region->u);
    mad3(normal, -region->slope[1], region->v);
    encode_changes(region, axes, change, radius, at->shape_step, code->shape);
    for (int k = 0; k < 3; ++k) code->shape[k] *= steps_in(at->shape_step, p->shape_step);
    encode_tilt(normal, axes, p->shape_step, code->shape_tilt);
}

void psplat_quantized_axes(const psplat_precision *p, const int32_t normal[2], const double u[3],
                           double axes[3][3]) {
    int flipped;
    psplat_octahedron_normal(normal, p->normal_bits, axes[2]);
    axes_of(axes[2], encode_turn(axes[2], u, p->turn_step, &flipped) * p->turn_step, axes[0],
            axes[1]);
}

/* Returns whether the field of a run's splats is that of their curved surface. */
static int field_is_shape(const psplat_run *run) {
    return run->is_curved && !run->has_shape;
}

/* Encodes the lines of a splat, by the steps that its radii have. */
static void encode_lines(const psplat_precision *p, const psplat_precision *at,
                         const psplat_region *region, int has_bends, psplat_quantized_splat *code) {
    const int32_t steps[3] = {steps_in(at->line_turn_step, p->line_turn_step),
                              steps_in(at->line_step, p->line_step),
                              steps_in(at->bend_step, p->bend_step)};
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double line[3];
        for (int k = 0; k < 3; ++k)
            line[k] = region->lines[i][k] * (k < 2 && code->flipped ? -1 : 1);
        encode_line(at, line, has_bends ? region->bends[i] : 0, code->lines[i]);
        for (int k = 0; k < 3; ++k) code->lines[i][k] *= steps[k];
    }
}

void psplat_quantize_splat(const psplat_precision *p, const psplat_run *run,
                           const psplat_splat *splat, psplat_quantized_splat *code) {
    psplat_region region;
    double axes[3][3], radius[2];
    psplat_splat_region(splat, 0, &region);
    memset(code, 0, sizeof *code);
    for (int k = 0; k < 3; ++k) code->position[k] = round_to(region.center[k], p->unit);
    for (int k = 0; k < 2; ++k)
        code->scale[k] = round_to(log(region.radius[k] / p->unit), p->scale_step);
    if (code->scale[1] > code->scale[0]) code->scale[0] = code->scale[1];
    for (int k = 0; k < 2; ++k) radius[k] = p->unit * exp(code->scale[k] * p->scale_step);
    const psplat_precision at = psplat_precision_at(p, radius);
    psplat_octahedron_encode_coarsely(region.n, p->normal_bits, at.normal_shift, code->normal);
    psplat_octahedron_normal(code->normal, p->normal_bits, axes[2]);
    code->turn = encode_turn(axes[2], region.u, at.turn_step, &code->flipped);
    code->turn *= steps_in(at.turn_step, p->turn_step);
    axes_of(axes[2], code->turn * p->turn_step, axes[0], axes[1]);
    if (!field_is_shape(run)) encode_field(p, &region, splat, (const double(*)[3])axes, code);
    if (run->is_curved) encode_shape(p, &at, &region, (const double(*)[3])axes, radius, code);
    if (run->has_shape) memset(code->shape_tilt, 0, sizeof code->shape_tilt);
    encode_lines(p, &at, &region, run->has_bends, code);
}

/* Sets the normal, the field and the shape of a splat from its code and axes. */
static void dequantize_field(const psplat_precision *p, const psplat_run *run,
                             const psplat_quantized_splat *code, const double axes[3][3],
                             psplat_splat *splat) {
    const int32_t *tilt = field_is_shape(run) ? code->shape_tilt : code->tilt;
    const int32_t *field = field_is_shape(run) ? code->shape : code->field;
    double tilt_step = field_is_shape(run) ? p->shape_step : p->tilt_step, normal[3];
    double field_step = field_is_shape(run) ? p->shape_step : p->field_step;
    memcpy(normal, axes[2], sizeof normal);
    mad3(normal, tilt[0] * tilt_step, axes[0]);
    mad3(normal, tilt[1] * tilt_step, axes[1]);
    normalize3(normal);
    for (int k = 0; k < 3; ++k) {
        splat->normal[k] = (float)normal[k];
        splat->gradient[k] = (float)(field[k] * field_step);
        splat->shape[2 + k] = (float)(code->shape[k] * p->shape_step);
    }
    for (int k = 0; k < 2; ++k) splat->shape[k] = (float)(code->shape_tilt[k] * p->shape_step);
}

void psplat_dequantize_splat(const psplat_precision *p, const psplat_run *run,
                             const psplat_quantized_splat *code, psplat_splat *splat) {
    double axes[3][3];
    psplat_octahedron_normal(code->normal, p->normal_bits, axes[2]);
    axes_of(axes[2], code->turn * p->turn_step, axes[0], axes[1]);
    psplat_quaternion_of_axes(axes[0], axes[1], axes[2], splat->rotation);
    dequantize_field(p, run, code, (const double(*)[3])axes, splat);
    for (int k = 0; k < 3; ++k) splat->center[k] = (float)(code->position[k] * p->unit);
    for (int k = 0; k < 2; ++k)
        splat->radius[k] = (float)(p->unit * exp(code->scale[k] * p->scale_step));
    for (uint32_t i = 0; i < splat->clip_count; ++i) {
        double angle = PSPLAT_PI * code->lines[i][0] * p->line_turn_step;
        splat->clip[i][0] = (float)cos(angle);
        splat->clip[i][1] = (float)sin(angle);
        splat->clip[i][2] = (float)(code->lines[i][1] * p->line_step);
        splat->bend[i] = (float)(code->lines[i][2] * p->bend_step);
    }
}

/* ---- texture coordinates --------------------------------------------------------------------- */

static void round_pair(const float pair[2], double step, int32_t code[2]) {
    for (int k = 0; k < 2; ++k) code[k] = step > 0 ? round_to((double)pair[k], step) : 0;
}

static void unround_pair(const int32_t code[2], double step, float pair[2]) {
    for (int k = 0; k < 2; ++k) pair[k] = (float)(code[k] * step);
}

void psplat_quantize_texcoord(const psplat_precision *p, const psplat_texcoord *texcoord,
                              int flipped, psplat_quantized_texcoord *code) {
    round_pair(texcoord->at, p->texcoord_step, code->at);
    round_pair(texcoord->along_u, p->texcoord_slope_step, code->along[0]);
    round_pair(texcoord->along_v, p->texcoord_slope_step, code->along[1]);
    for (int k = 0; k < 4; ++k) code->along[k / 2][k % 2] *= flipped ? -1 : 1;
    round_pair(texcoord->along_uu, p->texcoord_bend_step, code->bends[0]);
    round_pair(texcoord->along_uv, p->texcoord_bend_step, code->bends[1]);
    round_pair(texcoord->along_vv, p->texcoord_bend_step, code->bends[2]);
}

void psplat_dequantize_texcoord(const psplat_precision *p, const psplat_quantized_texcoord *code,
                                psplat_texcoord *texcoord) {
    if (p->texcoord_step > 0) unround_pair(code->at, p->texcoord_step, texcoord->at);
    unround_pair(code->along[0], p->texcoord_slope_step, texcoord->along_u);
    unround_pair(code->along[1], p->texcoord_slope_step, texcoord->along_v);
    unround_pair(code->bends[0], p->texcoord_bend_step, texcoord->along_uu);
    unround_pair(code->bends[1], p->texcoord_bend_step, texcoord->along_uv);
    unround_pair(code->bends[2], p->texcoord_bend_step, texcoord->along_vv);
}

static void round_splat(psplat_splats *splats, const psplat_run *run, size_t i) {
    psplat_quantized_splat code;
    psplat_quantize_splat(&splats->precision, run, &splats->splats[i], &code);
    psplat_dequantize_splat(&splats->precision, run, &code, &splats->splats[i]);
    if (run->has_texcoord) {
        psplat_quantize_texcoord(&splats->precision, &splats->texcoords[i], code.flipped,
                                 &code.texcoord);
        psplat_dequantize_texcoord(&splats->precision, &code.texcoord, &splats->texcoords[i]);
    }
    if (!splats->finishes || !code.flipped) return;
    for (int k = 0; k < 3; ++k) {
        splats->finishes[i].color_u[k] *= -1;
        splats->finishes[i].color_v[k] *= -1;
    }
}

void psplat_round_to_precision(psplat_splats *splats) {
    if (!(splats->precision.unit > 0)) return;
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i)
            round_splat(splats, &splats->runs[run], i);
}
