/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * instances.h - mesh instances: the global transforms with which nodes place meshes.
 */
#ifndef PHONGSPLAT_SCENE_INSTANCES_H
#define PHONGSPLAT_SCENE_INSTANCES_H

#include <phongsplat/splat.h>

#include "scene/scene.h"

#include <stdint.h>

/* One mesh that a node of a scene shows. */
typedef struct psplat_instance {
    uint32_t mesh, node;
    double matrix[16]; /* global, at rest, column-major */
    double stretch;    /* greatest singular value of its upper left 3 x 3, with the greatest scales
                          that animations have at their keys */
} psplat_instance;

/* Lists the instances of the scene of this index in the order of a walk from its roots, or those of
 * all nodes if index is PSPLAT_NO_INDEX. Left out are meshes without triangles, and instances that
 * are flattened by their nodes at rest and at all keys of animations, since flattened splats are
 * not drawn (spec 4). *instances is malloc'ed and belongs to the caller. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_scene_instances(const psplat_scene *scene, uint32_t index,
                                     psplat_instance **instances, size_t *count,
                                     psplat_error *error);

/* Returns the index of the scene that a viewer shows at first, or PSPLAT_NO_INDEX if the file has
 * no scenes. */
uint32_t psplat_scene_shown(const psplat_scene *scene);

/* Stores for each mesh the length of which its errors are percentages, in units of the mesh: the
 * diagonal of the shown scene's bounding box, divided by the greatest stretch of the mesh's
 * instances there. A mesh that only other scenes show has the length of the first of these. Length
 * 0 stands for the diagonal of the mesh's own box: for meshes that no scene shows, and for the only
 * mesh of a file without a graph. lengths has room for mesh_count. *diagonal is that of the shown
 * scene, or 0. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_scene_lengths(const psplat_scene *scene, double *lengths, double *diagonal,
                                   psplat_error *error);

/* Returns the diagonal of the bounding box of the vertices of instances, or 0 without instances. */
double psplat_scene_diagonal(const psplat_scene *scene, const psplat_instance *instances,
                             size_t count);

/* Refuses nodes whose transforms overflow and scenes that show no triangles, and warns of nodes
 * that flatten their mesh. path names the file in errors. Errors: PSPLAT_ERROR_RANGE,
 * PSPLAT_ERROR_NO_SPLATS, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_scene_check(psplat_scene *scene, const char *path, psplat_error *error);

#endif
