/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * write_obj.h - a mesh as a Wavefront OBJ file.
 */
#ifndef PHONGSPLAT_BENCHMARK_WRITE_OBJ_H
#define PHONGSPLAT_BENCHMARK_WRITE_OBJ_H

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "table/text.h"

/* Adds the mesh in the coordinates of the source's file, with the normals that the converter sees,
 * so that a simplifier starts from what the splats started from. */
void psplat_write_obj(const psplat_source_mesh *source_mesh, psplat_text *text);

#endif
