/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_steps.h - the grid on which a file holds texture coordinates.
 */
#ifndef PHONGSPLAT_SPLATS_TEXCOORD_STEPS_H
#define PHONGSPLAT_SPLATS_TEXCOORD_STEPS_H

#include <phongsplat/splat.h>

#include "splats/splats.h"

/* Moves texture coordinates by whole numbers to 0 ... 1, or -1 ... 1 where textures mirror, as far
 * as the textures of their materials repeat, and chooses the steps of splats->precision for what
 * the splats hold. They let textures slide by a small part of a tolerance: a length over the
 * surface and, on top of it, a distance in texture coordinates; where both are 0 it is not bounded.
 * That of T at the centre is a power of two, or 0 where it would take more steps than 24
 * bits count. Leaves splats without texture coordinates as they are, and chooses nothing where the
 * precision is that of floats. */
void psplat_texcoord_settle(psplat_splats *splats, double length, double distance);

#endif
