/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * precision.c - the choice of the grid on which a file holds splats.
 *
 * The steps of values that move splats follow from the tolerance; quantize_candidate.c then checks
 * that the moved splats keep it. The steps of values that turn normals follow from the variation of
 * the normals over splats.
 */
#include "select/precision.h"

#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "select/conversion.h"
#include "splats/octahedron.h"
#include "splats/splat_texcoord.h"
#include "splats/splats.h"
#include "splats/texcoord_steps.h"

#include <math.h>

/* All of these but the first were chosen by hand. */
/* The greatest number of steps of positions: as many as fit into 16 bits. */
static const double most_steps = 65000;

/* How far rounding may move the rim of a splat by tilting it, in tolerances, and the share of the
 * samples whose splats it may tilt more. It is of samples, not of splats: a large splat that has to
 * shrink leaves a large hole. */
static const double greatest_tilt_tolerances = 0.3, greatest_tilted_share = 0.02;
static const int choices_of_bits[] = {8, 11, 14};
enum { CHOICES = sizeof choices_of_bits / sizeof *choices_of_bits };

/* The step of radii as a part of them, which where splats are curved saves more splats than it
 * costs bytes, and the number of steps of a half turn. */
static const double radius_step = 0.04, curved_radius_step = 0.025;
enum { TURNS = 256 };

/* How far rounding may move a line from its crease, in tolerances. */
static const double greatest_line_move_tolerances = 0.05;

/* How far rounding a second derivative may move the rim of a curved splat, in tolerances; of one of
 * the mean size, again over samples. */
static const double greatest_bend_tolerances = 0.05;
/* How much coarser that step may be where the slopes fit into bytes then. */
static const double byte_coarsening = 3;

/* How far rounding a line's bend may move its ends, in tolerances. */
static const double greatest_line_bend_tolerances = 0.1;

/* The step of normal fields, as a part of their mean change over a splat. */
static const double field_step_part = 0.2;

/* Returns the share of the samples whose taken candidates rounding to so many bits tilts too much.
 */
static double tilted_share(const psplat_conversion *c, int bits) {
    double count = 0, broken = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        double normal[3];
        int32_t code[2];
        if (!candidate->taken) continue;
        psplat_octahedron_encode(candidate->region.n, bits, code);
        psplat_octahedron_normal(code, bits, normal);
        double rim = sqrt(distance2_3(normal, candidate->region.n)) * candidate->region.radius[0];
        count += (double)candidate->covered_count;
        if (rim > greatest_tilt_tolerances * c->tolerance)
            broken += (double)candidate->covered_count;
    }
    return count > 0 ? broken / count : 0;
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

/* Returns the step of the slopes of curved surfaces; 0 where no splat is curved. A slope that is
 * off by half a step at the rim of radius r moves that by r step / 4. */
static double shape_step(const psplat_conversion *c) {
    double sum = 0, count = 0, greatest = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        const psplat_region *region = &candidate->region;
        if (!candidate->taken || !psplat_region_is_curved(region)) continue;
        for (int k = 2; k < 5; ++k) greatest = fmax(greatest, fabs(candidate->field[k]));
        sum += (double)candidate->covered_count * region->radius[0] * region->radius[0];
        count += (double)candidate->covered_count;
    }
    if (!(count > 0)) return 0;
    double step = 4 * greatest_bend_tolerances * c->tolerance / sqrt(sum / count);
    return fmax(step, fmin(byte_coarsening * step, greatest / 127));
}

/* Returns the least power of two from 4 to 2^14 that is not below a number; 2^14 where none is. */
static double power_of_two(double least) {
    double n = 4;
    while (n < least && n < 16384) n *= 2;
    return n;
}

static void choose_lines(const psplat_conversion *c, psplat_precision *p) {
    double radius = 0, bent_radius = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_region *region = &c->selection.candidates[i].region;
        if (!c->selection.candidates[i].taken) continue;
        for (uint32_t k = 0; k < region->line_count; ++k) {
            radius = fmax(radius, region->radius[0]);
            if (region->bends[k] != 0) bent_radius = fmax(bent_radius, region->radius[0]);
        }
    }
    if (bent_radius > 0)
        p->bend_step = fmin(4 * greatest_line_bend_tolerances * c->tolerance / bent_radius, 0.5);
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
    p.scale_step = c->limits.planar ? radius_step : curved_radius_step;
    mean_slopes(c, &change, &tilt);
    if (c->limits.normal_tolerance > 0) change = fmin(change, c->limits.normal_tolerance);
    p.field_step = p.tilt_step = fmax(field_step_part * change, 1.0 / 1024);
    choose_lines(c, &p);
    if (!c->limits.planar) p.shape_step = shape_step(c);
    return p;
}

void psplat_precision_settle_texcoords(psplat_conversion *c) {
    double length = c->limits.texture_tolerance, texels = 0;
    double free_texels =
        length > 0 ? PSPLAT_LEAST_SLIDE_TEXELS : c->limits.texture_tolerance_texels;
    const psplat_kept_textures *kept = c->appearance.kept;
    for (size_t i = 0; kept && i < c->surface.mesh->source_material_count; ++i)
        for (int k = 0; k < 2; ++k) texels = fmax(texels, kept[i].texels[k]);
    psplat_texcoord_settle(c->splats, length, texels > 0 ? free_texels / texels : 0);
}
