/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * precision.c - the choice of the grid on which a file holds splats.
 *
 * The steps of values that move splats follow from the tolerance; quantize_candidate.c then checks
 * that the moved splats keep it. The steps of values that turn normals follow from the variation of
 * the normals over splats.
 */
#include "select/precision.h"

#include "base/vector.h"
#include "fit/candidate.h"
#include "select/conversion.h"
#include "splats/octahedron.h"
#include "splats/splats.h"

#include <math.h>

/* All of these but the first were chosen by hand. */
/* The greatest number of steps of positions: as many as fit into 16 bits. */
static const double most_steps = 65000;

/* How far rounding may move the rim of a splat by tilting it, in tolerances, and the share of
 * splats that it may tilt more. */
static const double greatest_tilt_tolerances = 0.3, greatest_tilted_share = 0.1;
static const int choices_of_bits[] = {8, 11, 14};
enum { CHOICES = sizeof choices_of_bits / sizeof *choices_of_bits };

/* The step of radii as a part of them, and the number of steps of a half turn. */
static const double radius_step = 0.04;
enum { TURNS = 256 };

/* How far rounding may move a line from its crease, in tolerances. */
static const double greatest_line_move_tolerances = 0.05;

/* The step of normal fields, as a part of their mean change over a splat. */
static const double field_step_part = 0.2;

/* Returns the share of the taken candidates that rounding to so many bits tilts too much. */
static double tilted_share(const psplat_conversion *c, int bits) {
    size_t count = 0, broken = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        double normal[3];
        int32_t code[2];
        if (!candidate->taken) continue;
        psplat_octahedron_encode(candidate->region.n, bits, code);
        psplat_octahedron_normal(code, bits, normal);
        double rim = sqrt(distance2_3(normal, candidate->region.n)) * candidate->region.radius[0];
        ++count;
        broken += rim > greatest_tilt_tolerances * c->tolerance;
    }
    return count ? (double)broken / (double)count : 0;
}

static int normal_bits(const psplat_conversion *c) {
    int i = 0;
    while (i + 1 < CHOICES && tilted_share(c, choices_of_bits[i]) > greatest_tilted_share) ++i;
    return choices_of_bits[i];
}

/* Finds the root mean squares, over the taken candidates, of the change of normal fields over a
 * radius and of their tilt at the centre. */
static void mean_slopes(const psplat_conversion *c, double *change, double *tilt) {
    double sums[2] = {0, 0}, count = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        const double *f = candidate->field;
        if (!candidate->taken) continue;
        sums[0] += f[2] * f[2] + f[3] * f[3] + 2 * f[4] * f[4];
        sums[1] += f[0] * f[0] + f[1] * f[1];
        ++count;
    }
    *change = sqrt(sums[0] / fmax(count, 1));
    *tilt = sqrt(sums[1] / fmax(count, 1));
}

/* Returns the least power of two from 4 to 2^14 that is not below a number; 2^14 where none is. */
static double power_of_two(double least) {
    double n = 4;
    while (n < least && n < 16384) n *= 2;
    return n;
}

static void choose_lines(const psplat_conversion *c, psplat_precision *p) {
    double radius = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        if (candidate->taken && candidate->region.line_count)
            radius = fmax(radius, candidate->region.radius[0]);
    }
    double steps = power_of_two(radius / (greatest_line_move_tolerances * c->tolerance));
    p->line_step = 1 / steps;
    p->line_turn_step = 1 / fmin(2 * steps, 16384);
}

psplat_precision psplat_precision_choose(const psplat_conversion *c) {
    double part = fmin(c->desc->precision, PSPLAT_GREATEST_PRECISION), change, tilt;
    psplat_precision p = {.unit = part * c->tolerance};
    if (!(part > 0) || c->surface.diagonal > most_steps * p.unit) return (psplat_precision){0};
    p.normal_bits = normal_bits(c);
    p.turn_step = 1.0 / TURNS;
    p.scale_step = radius_step;
    mean_slopes(c, &change, &tilt);
    if (c->limits.normal_tolerance > 0) change = fmin(change, c->limits.normal_tolerance);
    p.field_step = p.tilt_step = fmax(field_step_part * change, 1.0 / 1024);
    choose_lines(c, &p);
    return p;
}
