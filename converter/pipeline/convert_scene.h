/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * convert_scene.h - the conversion of all meshes of a scene to splats.
 */
#ifndef PHONGSPLAT_PIPELINE_CONVERT_SCENE_H
#define PHONGSPLAT_PIPELINE_CONVERT_SCENE_H

#include <phongsplat/splat.h>

#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

/* Converts each mesh with the same desc, whose diagonal is ignored; desc and report may be NULL.
 * splats has room for mesh_count, all zeroed, and gets those of each mesh; meshes without triangles
 * leave theirs zeroed. A mesh's tolerance is at most 20 % of its own diagonal. The caller owns the
 * splats and the report. Errors are those of psplat_convert and name the mesh; all splats are freed
 * then. */
psplat_result psplat_scene_convert(const psplat_scene *scene, const psplat_convert_desc *desc,
                                   psplat_splats *splats, psplat_scene_report *report,
                                   psplat_error *error);

/* Measures splats that psplat_scene_convert made of scene and desc, and fills what it left out of
 * report because of desc->unverified. Errors are those of psplat_convert and name the mesh. */
psplat_result psplat_scene_verify(const psplat_scene *scene, const psplat_convert_desc *desc,
                                  const psplat_splats *splats, psplat_scene_report *report,
                                  psplat_error *error);

/* Warns of textures that are baked although textures are kept, since they use other coordinates of
 * their mesh than those that are. */
void psplat_scene_warn_of_textures(psplat_scene *scene);

/* Frees the splats of all meshes, but not the array. */
void psplat_scene_splats_free(const psplat_scene *scene, psplat_splats *splats);

#endif
