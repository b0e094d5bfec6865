/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * orientation.h - consistent orientation of the triangles of each component.
 */
#ifndef PHONGSPLAT_MESH_ORIENTATION_H
#define PHONGSPLAT_MESH_ORIENTATION_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Orients the triangles of each component consistently and swaps the corners of those that it
 * flips. *consistent becomes 0 if a component, such as a Moebius strip, has no consistent
 * orientation. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_orient(psplat_mesh *mesh, int *consistent, psplat_error *error);

#endif
