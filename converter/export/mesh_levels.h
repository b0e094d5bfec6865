/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_levels.h - the levels of detail of the meshes of a scene (spec 3.13), as they are written.
 */
#ifndef PHONGSPLAT_EXPORT_MESH_LEVELS_H
#define PHONGSPLAT_EXPORT_MESH_LEVELS_H

#include "scene/scene.h"
#include "splats/splats.h"

#include <phongsplat/splat.h>

/* A level and its errors. Lengths are in the mesh's units. */
typedef struct psplat_mesh_level_splats {
    psplat_splats splats; /* empty in the finest, which is what the scene shows */
    double tolerance;     /* in % of the diagonal, with which it was made */
    double distance;      /* proven, both ways */
    double normal;        /* root mean square, degrees */
    double outline;       /* mean distance between outlines from all sides */
} psplat_mesh_level_splats;

/* The levels of one mesh, the finest first. From level to level splats become fewer, and no error
 * falls. A zero-initialised struct has none. */
typedef struct psplat_mesh_levels {
    psplat_mesh_level_splats *list;
    size_t count;
} psplat_mesh_levels;

/* A scene in which coarser levels are further meshes behind its own, which no node shows. */
typedef struct psplat_leveled_scene {
    psplat_scene scene;    /* a shallow copy but for meshes */
    psplat_splats *splats; /* by mesh of it; shallow copies */
    size_t finest_count;   /* meshes of the scene itself */
} psplat_leveled_scene;

/* Makes such a scene, whose arrays psplat_leveled_scene_free frees, also after an error. levels has
 * an element for each mesh, or is NULL. All that is passed must outlive it. Errors: MEMORY. */
psplat_result psplat_leveled_scene_make(const psplat_scene *scene, const psplat_splats *splats,
                                        const psplat_mesh_levels *levels,
                                        psplat_leveled_scene *leveled, psplat_error *error);
void psplat_leveled_scene_free(psplat_leveled_scene *leveled);

/* Returns the mesh of the leveled scene that is a coarser level, 1 or more, of a mesh. */
size_t psplat_leveled_scene_mesh(const psplat_mesh_levels *levels, size_t finest_count, size_t mesh,
                                 size_t level);

#endif
