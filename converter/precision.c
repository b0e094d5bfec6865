/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * precision.c - how many bits splats need.
 *
 * Steps follow from the tolerance where they move splats, which are judged after it (snap.c), and
 * from the normals' own variation where they bend them.
 */
#include "encoding.h"
#include "stages.h"
#include "vector.h"

/* How many steps of positions shorts count. */
static const double most_steps = 65000;

/* Axes: how far a splat may come to tilt at its rim, in tolerances, and which part may do more. */
static const double tilted_part = 0.3, exceptions = 0.1;
static const int choices_of_bits[] = {8, 11, 14};
enum { CHOICES = sizeof choices_of_bits / sizeof *choices_of_bits };

/* Radii: part of a radius. Half turns: one over so many. */
static const double radius_step = 0.04;
enum { TURNS = 256 };

/* Lines: how far one may come to lie from its crease, in tolerances. */
static const double line_part = 0.05;

/* Part of what fields bend by that rounding them may. */
static const double field_part = 0.2;

/* Part of the taken candidates that tilt too much. */
static double tilted(const psplat_conversion *c, int bits) {
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
        broken += rim > tilted_part * c->tolerance;
    }
    return count ? (double)broken / (double)count : 0;
}

static int normal_bits(const psplat_conversion *c) {
    int i = 0;
    while (i + 1 < CHOICES && tilted(c, choices_of_bits[i]) > exceptions) ++i;
    return choices_of_bits[i];
}

/* Root mean square of what fields change by over a radius, and of what they tilt by. */
static void slopes(const psplat_conversion *c, double *change, double *tilt) {
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

/* The least power of two that is not below a number, at most 2^14. */
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
    double steps = power_of_two(radius / (line_part * c->tolerance));
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
    slopes(c, &change, &tilt);
    if (c->limits.normal_tolerance > 0) change = fmin(change, c->limits.normal_tolerance);
    p.field_step = p.tilt_step = fmax(field_part * change, 1.0 / 1024);
    choose_lines(c, &p);
    return p;
}

void psplat_precision_apply(psplat_splats *splats) {
    if (!(splats->precision.unit > 0)) return;
    for (size_t i = 0; i < splats->count; ++i) {
        psplat_code code;
        psplat_code_of(&splats->precision, &splats->splats[i], &code);
        psplat_code_decode(&splats->precision, &code, &splats->splats[i]);
        if (!splats->finishes || !code.flipped) continue;
        for (int k = 0; k < 3; ++k) {
            splats->finishes[i].color_u[k] *= -1;
            splats->finishes[i].color_v[k] *= -1;
        }
    }
}
