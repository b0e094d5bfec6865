/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * outline.h - by how much the outlines of splats differ from those of their mesh, seen from all
 * sides.
 */
#ifndef PHONGSPLAT_MEASURE_OUTLINE_H
#define PHONGSPLAT_MEASURE_OUTLINE_H

#include "mesh/mesh.h"
#include "splats/splats.h"

#include <phongsplat/splat.h>

/* Stores the outline error of spec 3.13, in the mesh's units: the mean, over 12 directions, of the
 * area that only the mesh or only the splats cover in an orthographic view, over four times the
 * root of the area that the mesh covers there. For a mesh that covers a square that is the mean
 * distance between both outlines. It is measured on a grid of 384 cells over one and a half times
 * the mesh's bounding sphere, and what splats cover beyond does not count. Errors: MEMORY. */
psplat_result psplat_outline_measure(const psplat_mesh *mesh, const psplat_splats *splats,
                                     double *outline, psplat_error *error);

#endif
