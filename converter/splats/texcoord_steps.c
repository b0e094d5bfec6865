/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_steps.c - the grid on which a file holds texture coordinates.
 *
 * What is off at the rim is half a step of each order, so that the steps follow from how far the
 * texture may slide over the surface. At the centre the step is a power of two and values are
 * floats, which EXT_meshopt_compression packs well then: glTF's 16-bit integers stand for 0 ... 1
 * or -1 ... 1, of which most bits would be noise.
 */
#include "splats/texcoord_steps.h"

#include "material/texture_repeats.h"
#include "splats/splats.h"

#include <math.h>

/* How far rounding a number of each order may move the texture at the rim, in tolerances. Chosen by
 * hand. */
static const double greatest_move_tolerances[3] = {0.15, 0.2, 0.3};
/* How much coarser steps may be where numbers fit into bytes then. Chosen by hand. */
static const double byte_coarsening = 2;

/* The finest step at the centre, and the greatest number of steps of each order: glTF's filter of
 * exponents has 24 bits, shorts have 16. */
static const double finest_step = 1.0 / (1 << 20);
static const double most_steps = 8388607, most_short_steps = 32767;

/* What the texture coordinates of many splats have in common. */
typedef struct spread {
    double area, weighed; /* sums of areas, and of these over the fourth powers of the distances in
                             texture coordinates that they may be off by */
    double slope, bend;   /* greatest magnitudes of a number of the first and second order */
    double reach;         /* greatest magnitude of a coordinate at a centre */
} spread;

/* The part of the greatest change of coordinates over a length that counts as their least one
 * (splat_texcoord.h). */
static const double least_change = 0.1;

/* ---- steps ----------------------------------------------------------------------------------- */

static double greatest_of(const float pair[2], double most) {
    return fmax(most, fmax(fabs((double)pair[0]), fabs((double)pair[1])));
}

/* Returns the least change of a splat's coordinates at its centre over a length. */
static double least_density(const psplat_texcoord *t, const float radius[2]) {
    double squares = 0, cross;
    for (int k = 0; k < 2; ++k) {
        double u = (double)t->along_u[k] / (double)radius[0];
        double v = (double)t->along_v[k] / (double)radius[1];
        squares += u * u + v * v;
    }
    cross = ((double)t->along_u[0] * (double)t->along_v[1] -
             (double)t->along_u[1] * (double)t->along_v[0]) /
            ((double)radius[0] * (double)radius[1]);
    double root = sqrt(fmax(squares * squares / 4 - cross * cross, 0));
    double greatest = sqrt(squares / 2 + root), least = sqrt(fmax(squares / 2 - root, 0));
    return fmax(least, least_change * greatest);
}

/* Adds a splat whose texture may slide by a length, and more by a distance in its coordinates. */
static void add_splat(spread *s, const psplat_texcoord *t, const float radius[2], double length,
                      double distance) {
    double area = (double)radius[0] * (double)radius[1];
    double moved = least_density(t, radius) * length + distance;
    s->area += area;
    s->weighed += moved > 0 ? area / pow(moved, 4) : 0;
    s->slope = greatest_of(t->along_v, greatest_of(t->along_u, s->slope));
    s->bend = greatest_of(t->along_vv, greatest_of(t->along_uu, s->bend));
    s->bend = greatest_of(t->along_uv, s->bend);
    s->reach = greatest_of(t->at, s->reach);
}

/* Returns a step with which numbers up to the greatest fit into 16 bits: the one that is wanted, or
 * the somewhat coarser one with which they fit into 8. Any does where all numbers are 0. */
static double fitting_step(double wanted, double greatest) {
    double byte = greatest / 127;
    if (!(greatest > 0)) return finest_step;
    if (!(wanted > 0) || (byte > wanted && byte < byte_coarsening * wanted)) return byte;
    return fmax(wanted, greatest / most_short_steps);
}

/* Returns the step of coordinates at centres: a power of two, or 0 where it would take too many. */
static double center_step(double wanted, double reach) {
    double step =
        wanted > 0 ? fmin(fmax(exp2(floor(log2(wanted))), finest_step), 0.25) : 1.0 / 65536;
    return reach <= most_steps * step ? step : 0;
}

static void choose_steps(const spread *s, double moved, int bends, psplat_precision *p) {
    double wanted[3];
    for (int k = 0; k < 3; ++k) wanted[k] = 2 * greatest_move_tolerances[k] * moved;
    p->texcoord_step = center_step(wanted[0], s->reach);
    p->texcoord_slope_step = fitting_step(wanted[1], s->slope);
    p->texcoord_bend_step = bends ? fitting_step(wanted[2], s->bend) : 0;
}

/* ---- splats ---------------------------------------------------------------------------------- */

/* Moves a run's coordinates to 0 ... 1, or -1 ... 1 where its material's textures mirror, if these
 * repeat. */
static void rebase(const psplat_run *run, const psplat_material *material,
                   psplat_texcoord *texcoords) {
    for (int axis = 0; axis < 2; ++axis) {
        int unit = psplat_textures_repeat(material->textures, axis);
        for (size_t i = 0; i < run->count && unit; ++i) {
            double at = (double)texcoords[i].at[axis];
            double tiles = floor(unit == 2 ? at / 2 + 0.5 : at);
            texcoords[i].at[axis] = (float)(at - unit * tiles);
        }
    }
}

void psplat_texcoord_settle(psplat_splats *splats, double length, double distance) {
    spread s = {0};
    int any = 0, bends = 0;
    for (size_t r = 0, i = 0; r < splats->run_count; i += splats->runs[r++].count) {
        const psplat_run *run = &splats->runs[r];
        if (!run->has_texcoord) continue;
        any = 1;
        bends |= run->has_texcoord_bend;
        rebase(run, &splats->materials[run->material], splats->texcoords + i);
        for (size_t k = i; k < i + run->count; ++k)
            add_splat(&s, &splats->texcoords[k], splats->splats[k].radius, length, distance);
    }
    if (!any || !(splats->precision.unit > 0)) return;
    /* The mean of the inverse fourth powers is next to the least of what most of the area allows.
     */
    double moved = s.weighed > 0 ? pow(s.area / s.weighed, 0.25) : 0;
    choose_steps(&s, moved, bends, &splats->precision);
}
