/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * precision.h - the choice of the grid on which a file holds splats.
 */
#ifndef PHONGSPLAT_SELECT_PRECISION_H
#define PHONGSPLAT_SELECT_PRECISION_H

#include "select/conversion.h"
#include "splats/splats.h"

/* Returns the grid that suits the tolerance, the taken candidates and c->desc->precision. All of it
 * is 0 where floats are wanted, or positions would not fit into 16 bits. */
psplat_precision psplat_precision_choose(const psplat_conversion *c);

/* Returns the mean part of the tolerance that the fits of taken candidates use, from 0 to 1. It is
 * of samples: most of what one sees are large splats. */
double psplat_used_part(const psplat_conversion *c);

/* Returns how coarse the grid is, for the part of the tolerance that fits use: 0 where splats lie
 * on the surface, to 1. */
double psplat_coarseness(const psplat_conversion *c);

/* Moves the texture coordinates of c->splats to where they take fewest bytes, and completes
 * c->splats->precision with their steps (splats/texcoord_steps.h). */
void psplat_precision_settle_texcoords(psplat_conversion *c);

#endif
