/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * precision.c - the choice of the grid on which a file holds splats.
 *
 * The steps of values that move splats follow from the tolerance; quantize_candidate.c then checks
 * that the moved splats keep it. The steps of values that turn normals follow from the variation of
 * the normals over splats.
 *
 * Where splats lie on the surface, as on machined parts, rounding is all that one sees of the
 * tolerance, and steps are fine. Where the fit itself uses up most of the tolerance, as on scans,
 * rounding hides behind it, and coarse steps save bytes.
 */
#include "select/precision.h"

#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "select/conversion.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splat_texcoord.h"
#include "splats/splats.h"
#include "splats/texcoord_steps.h"

#include <math.h>

/* All of these but the first were chosen by hand. */
/* The greatest number of steps of positions: as many as fit into 16 bits. */
static const double most_steps = 65000;
/* The same where the splats are written in parts: single precision holds an eighth of a step. */
static const double most_steps_in_parts = 1 << 21;

/* A limit of what rounding may do where splats lie on the surface, and where they leave it by much
 * of the tolerance. */
typedef struct limit {
    double fine, coarse;
} limit;

/* The mean deviation of splats, in tolerances, up to which limits are fine, and from which on they
 * are coarse. That of machined parts is 0.1 to 0.2, that of scans and of smooth shapes 0.6 to 0.9.
 */
static const double little_used = 0.25, much_used = 0.6;

/* The step of positions, in parts of the one that is asked for. */
static const limit position_steps = {1, 3.5};

/* How far rounding may move the rim of a splat by tilting it, in tolerances, and the share of the
 * samples whose splats it may tilt more. It is of samples, not of splats: a large splat that has to
 * shrink leaves a large hole. */
static const limit greatest_tilt_tolerances = {0.15, 0.5};
static const double greatest_tilted_share = 0.02;
static const int choices_of_bits[] = {8, 9, 10, 11, 12, 13, 14};
enum { CHOICES = sizeof choices_of_bits / sizeof *choices_of_bits };

/* The step of radii as a part of them, that of planar splats, and the number of steps of a half
 * turn. */
static const limit radius_step = {0.025, 0.04};
static const double planar_radius_step = 0.04;
enum { TURNS = 256 };

/* How far rounding may move a line from its crease, in tolerances. */
static const limit greatest_line_move_tolerances = {0.05, 0.1};

/* How far rounding a second derivative may move the rim of a curved splat, in tolerances. */
static const limit greatest_bend_tolerances = {0.1, 0.3};

/* The step of lines where no splat has one yet, in tolerances. */
static const double later_line_tolerances = 0.5;
/* How far rounding a line's bend may move its ends, in tolerances. */
static const limit greatest_line_bend_tolerances = {0.1, 0.2};

/* The step of normal fields, as a part of their mean change over a splat. */
static const double field_step_part = 0.2;

/* The fewest bits of the normals of small splats, and the greatest step of the slopes of their
 * surfaces: at the rim it turns normals by half of that, 3 to 6 degrees. */
enum { LEAST_GRADED_BITS = 7 };
static const limit greatest_shape_step = {0.1, 0.2};

double psplat_used_part(const psplat_conversion *c) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        if (!candidate->taken) continue;
        sum += candidate->deviation * (double)candidate->covered_count;
        count += (double)candidate->covered_count;
    }
    return count > 0 ? sum / count / c->tolerance : 0;
}

double psplat_coarseness(const psplat_conversion *c) {
    double part = (psplat_used_part(c) - little_used) / (much_used - little_used);
    return fmin(fmax(part, 0), 1);
}

/* Returns a limit that grows from fine to coarse by equal factors. */
static double limit_at(limit l, double coarseness) {
    return l.fine * pow(l.coarse / l.fine, coarseness);
}

/* Returns the share of the samples whose taken candidates rounding to so many bits, fewer for small
 * ones, tilts so that their rims move by more than a length. */
static double tilted_share(const psplat_conversion *c, const psplat_precision *p, double most,
                           int bits) {
    psplat_precision with_bits = *p;
    with_bits.normal_grades = bits - LEAST_GRADED_BITS;
    double count = 0, broken = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        double normal[3];
        int32_t code[2];
        if (!candidate->taken) continue;
        int shift = psplat_precision_at(&with_bits, candidate->region.radius).normal_shift;
        psplat_octahedron_encode_coarsely(candidate->region.n, bits, shift, code);
        psplat_octahedron_normal(code, bits, normal);
        double rim = sqrt(distance2_3(normal, candidate->region.n)) * candidate->region.radius[0];
        count += (double)candidate->covered_count;
        if (rim > most) broken += (double)candidate->covered_count;
    }
    return count > 0 ? broken / count : 0;
}

static int normal_bits(const psplat_conversion *c, const psplat_precision *p, double coarseness) {
    double most = limit_at(greatest_tilt_tolerances, coarseness) * c->tolerance;
    int i = 0;
    while (i + 1 < CHOICES && tilted_share(c, p, most, choices_of_bits[i]) > greatest_tilted_share)
        ++i;
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

/* Returns the greatest radius of taken candidates. */
static double greatest_radius(const psplat_conversion *c) {
    double greatest = 0;
    for (size_t i = 0; i < c->selection.count; ++i)
        if (c->selection.candidates[i].taken)
            greatest = fmax(greatest, c->selection.candidates[i].region.radius[0]);
    return greatest;
}

static int has_curved(const psplat_conversion *c) {
    for (size_t i = 0; i < c->selection.count; ++i)
        if (c->selection.candidates[i].taken &&
            psplat_region_is_curved(&c->selection.candidates[i].region))
            return 1;
    return 0;
}

/* Sets the step of the slopes of curved surfaces, which is that of the greatest radius. A slope
 * that is off by half a step at the rim of radius r moves that by r step / 4. */
static void choose_shapes(const psplat_conversion *c, double radius, double coarseness,
                          psplat_precision *p) {
    double greatest = limit_at(greatest_shape_step, coarseness);
    double move = limit_at(greatest_bend_tolerances, coarseness) * c->tolerance;
    if (!has_curved(c)) return;
    p->shape_step = fmin(4 * move / radius, greatest);
    p->shape_grades = (int)fmin(floor(log2(greatest / p->shape_step)), PSPLAT_MOST_GRADE);
}

/* Returns the least power of two from 4 to 2^14 that is not below a number; 2^14 where none is. */
static double power_of_two(double least) {
    double n = 4;
    while (n < least && n < 16384) n *= 2;
    return n;
}

/* Sets the steps of lines, which are those of the greatest radius. Where no splat
 * has a line yet, some get one that cuts a rim off (finish/cut_rims.c), and that need not be exact.
 */
static void choose_lines(const psplat_conversion *c, double radius, double coarseness,
                         psplat_precision *p) {
    double move = limit_at(greatest_line_move_tolerances, coarseness) * c->tolerance;
    double bend = limit_at(greatest_line_bend_tolerances, coarseness) * c->tolerance;
    int is_bent = 0, has_lines = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_region *region = &c->selection.candidates[i].region;
        if (!c->selection.candidates[i].taken) continue;
        has_lines |= region->line_count > 0;
        for (uint32_t k = 0; k < region->line_count; ++k) is_bent |= region->bends[k] != 0;
    }
    if (is_bent) p->bend_step = fmin(4 * bend / radius, 0.5);
    double steps = power_of_two(radius / (has_lines ? move : later_line_tolerances * c->tolerance));
    p->line_step = 1 / steps;
    p->line_turn_step = 1 / fmin(2 * steps, 16384);
}

psplat_precision psplat_precision_choose(const psplat_conversion *c) {
    double coarseness = psplat_coarseness(c), change, tilt;
    double part =
        fmin(c->desc->precision * limit_at(position_steps, coarseness), PSPLAT_GREATEST_PRECISION);
    psplat_precision p = {.unit = part * c->tolerance};
    double steps = c->desc->is_written_in_parts ? most_steps_in_parts : most_steps;
    if (!(part > 0) || c->surface.diagonal > steps * p.unit) return (psplat_precision){0};
    double radius = fmax(greatest_radius(c), p.unit);
    p.turn_step = 1.0 / TURNS;
    p.scale_step = c->limits.planar ? planar_radius_step : limit_at(radius_step, coarseness);
    p.halving = (int)lrint(log(2) / p.scale_step);
    p.reference = (int)ceil(log(radius / p.unit) / p.scale_step);
    choose_lines(c, radius, coarseness, &p);
    if (!c->limits.planar) choose_shapes(c, radius, coarseness, &p);
    p.normal_bits = normal_bits(c, &p, coarseness);
    p.normal_grades = p.normal_bits - LEAST_GRADED_BITS;
    mean_slopes(c, &change, &tilt);
    if (c->limits.normal_tolerance > 0) change = fmin(change, c->limits.normal_tolerance);
    p.field_step = p.tilt_step = fmax(field_step_part * change, 1.0 / 1024);
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
