/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_input.h - meshes as inputs of commands that also take assets.
 */
#ifndef PHONGSPLAT_CLI_MESH_INPUT_H
#define PHONGSPLAT_CLI_MESH_INPUT_H

#include <phongsplat/splat.h>

#include "compare/source_mesh.h"
#include "mesh/mesh.h"

/* Returns whether a file that psplat_command_open refused with this result is to be read as a mesh:
 * a glTF file without splats, or a file of another format. */
int psplat_mesh_input_expected(const char *path, psplat_result opened);

/* Reads the default scene of a file as one mesh, with its alpha masks cut out, and prepares it to
 * be measured and drawn. crease_angle_degrees is that of psplat_source_mesh_create. The caller
 * frees *source and mesh, also after an error. Errors: those of psplat_mesh_read. */
psplat_result psplat_mesh_input_read(const char *path, double crease_angle_degrees,
                                     psplat_mesh *mesh, psplat_source_mesh **source,
                                     psplat_error *error);

#endif
