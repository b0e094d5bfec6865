/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * wire_width.h - how wide the wires are of which a mesh consists.
 */
#ifndef PHONGSPLAT_MESH_WIRE_WIDTH_H
#define PHONGSPLAT_MESH_WIRE_WIDTH_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Stores the width, a length > 0, that the narrowest wires of a mesh have at most that make up half
 * of its area together; HUGE_VAL where less than half is wires. A wire is a component (triangles
 * connected by edges) that is rather convex, has a surface all around and is much longer than wide,
 * as cables, spokes and strings are. Its width is its area divided by the integral of its mean
 * curvature, which of a round wire is the diameter. Balls and plates are no wires, unless plates
 * are four times as long as wide, and tubes of a thin wall whose inside and outside are connected
 * are none either: the curvatures of both cancel. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_wire_width(const psplat_mesh *mesh, double *width);

#endif
