/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_mesh.h - the source mesh, with which splats or another mesh are compared.
 */
#ifndef PHONGSPLAT_COMPARE_SOURCE_MESH_H
#define PHONGSPLAT_COMPARE_SOURCE_MESH_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* A mesh prepared for measurements: with creases, normals as the converter has them, and a tree of
 * its triangles. The type is opaque. */
typedef struct psplat_source_mesh psplat_source_mesh;

/* Prepares a mesh, which must outlive *source. crease_angle_degrees is that of psplat_convert_desc;
 * 0 means 30. The caller frees *source with psplat_source_mesh_destroy. Errors: MEMORY, RANGE. */
psplat_result psplat_source_mesh_create(const psplat_mesh *mesh, double crease_angle_degrees,
                                        psplat_source_mesh **source, psplat_error *error);

void psplat_source_mesh_destroy(psplat_source_mesh *source); /* NULL is accepted */

#endif
