/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * read_scene.h - the scene import: a file of any supported format as a scene.
 */
#ifndef PHONGSPLAT_IMPORT_READ_SCENE_H
#define PHONGSPLAT_IMPORT_READ_SCENE_H

#include <phongsplat/splat.h>

#include "scene/scene.h"

/* Reads a file of any supported format (see psplat_mesh_read) with all of its meshes, nodes and
 * materials. Each mesh is welded, oriented and recentred by itself. A file without a node graph
 * becomes one mesh and one node, both called name. The caller frees *scene with psplat_scene_free;
 * after an error it is empty. Errors are those of psplat_mesh_read; NO_SPLATS also means that the
 * scene which is shown has no triangle with area. */
psplat_result psplat_scene_read(const char *path, const char *name, psplat_scene *scene,
                                psplat_error *error);

#endif
