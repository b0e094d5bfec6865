/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_input.c - meshes as inputs of commands that also take assets.
 */
#define _XOPEN_SOURCE 700

#include "cli/mesh_input.h"

#include "appearance/alpha_mask.h"
#include "compare/source_mesh.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#include <string.h>
#include <strings.h>

/* The length of the pieces into which the edges of alpha masks are cut, % of the diagonal: finer
 * than most tolerances. */
static const double mask_step_percent = 0.25;

int psplat_mesh_input_expected(const char *path, psplat_result opened) {
    const char *dot = strrchr(path, '.');
    int is_gltf = dot && (!strcasecmp(dot, ".glb") || !strcasecmp(dot, ".gltf"));
    return opened == PSPLAT_ERROR_NO_SPLATS || (opened == PSPLAT_ERROR_FORMAT && !is_gltf);
}

psplat_result psplat_mesh_input_read(const char *path, double crease_angle_degrees,
                                     psplat_mesh *mesh, psplat_source_mesh **source,
                                     psplat_error *error) {
    psplat_result result = psplat_mesh_read(path, mesh, error);
    if (!result) result = psplat_alpha_mask_apply(mesh, mask_step_percent, error);
    return result ? result : psplat_source_mesh_create(mesh, crease_angle_degrees, source, error);
}
