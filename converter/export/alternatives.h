/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * alternatives.h - what a file shows in viewers that do not know splats: fallback meshes and
 * Gaussians of all meshes of a scene.
 */
#ifndef PHONGSPLAT_EXPORT_ALTERNATIVES_H
#define PHONGSPLAT_EXPORT_ALTERNATIVES_H

#include <phongsplat/splat.h>

#include "export/fallback_mesh.h"
#include "export/khr_gaussians.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"

/* Simplifies every mesh that has triangles to a fallback mesh (fallback_mesh.h), which stays as
 * near to its source as the splats do. *fallbacks is an array from malloc with one element for each
 * mesh of the scene; the caller frees it with psplat_scene_fallback_meshes_free. desc is that of
 * the conversion, with the tolerance that was used; its diagonal and progress are ignored. Errors:
 * those of psplat_fallback_mesh_make. */
psplat_result psplat_scene_fallback_meshes(const psplat_scene *scene,
                                           const psplat_convert_desc *desc,
                                           psplat_fallback_mesh **fallbacks, psplat_error *error);

/* The same with all triangles of the meshes. */
psplat_result psplat_scene_whole_meshes(const psplat_scene *scene, const psplat_convert_desc *desc,
                                        psplat_fallback_mesh **whole, psplat_error *error);

/* Accepts NULL. */
void psplat_scene_fallback_meshes_free(const psplat_scene *scene, psplat_fallback_mesh *fallbacks);

/* Makes a Gaussian (khr_gaussians.h) of every splat. splats has one element for each mesh of the
 * scene. *gaussians is from malloc and holds one array for each mesh, with one Gaussian for each of
 * its splats; the caller frees it with psplat_scene_gaussians_free. Errors: MEMORY. */
psplat_result psplat_scene_gaussians(const psplat_scene *scene, const psplat_splats *splats,
                                     psplat_gaussian ***gaussians, psplat_error *error);

/* Accepts NULL. */
void psplat_scene_gaussians_free(const psplat_scene *scene, psplat_gaussian **gaussians);

#endif
