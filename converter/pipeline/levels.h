/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * levels.h - levels of detail: the conversions of a scene to coarser splats, with their errors.
 */
#ifndef PHONGSPLAT_PIPELINE_LEVELS_H
#define PHONGSPLAT_PIPELINE_LEVELS_H

#include "export/mesh_levels.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <phongsplat/splat.h>

/* Each of these levels has twice the tolerance of the one before, until no mesh has more splats
 * than this. */
enum { PSPLAT_LEAST_LEVEL_SPLATS = 32 };

/* The most levels of a scene, the finest included. */
enum { PSPLAT_MOST_LEVELS = 16 };

/* Which levels to make. Levels of a mesh that would have more than four fifths of the splats of the
 * one before are left out. */
typedef struct psplat_levels_desc {
    size_t most;                           /* levels, the finest included: 2 or more */
    double tolerances[PSPLAT_MOST_LEVELS]; /* of the coarser ones, in % as in psplat_convert_desc,
                                              ascending; 0 from the first that is not given on:
                                              each is twice the one before */
} psplat_levels_desc;

/* Converts the scene to coarser levels. splats and report are those of the finest (by mesh of the
 * scene), converted with desc and the tolerance of the report. *levels is an array from malloc with
 * one element for each mesh; the caller frees it with psplat_mesh_levels_free. Errors are those of
 * psplat_scene_convert; *levels is NULL then. */
psplat_result psplat_scene_levels(const psplat_scene *scene, const psplat_convert_desc *desc,
                                  const psplat_levels_desc *wanted, const psplat_splats *splats,
                                  const psplat_scene_report *report, psplat_mesh_levels **levels,
                                  psplat_error *error);

/* Frees the levels of all meshes of a scene, and levels, which may be NULL. */
void psplat_mesh_levels_free(const psplat_scene *scene, psplat_mesh_levels *levels);

#endif
