/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * node_transform.h - the local transform of one node of a scene.
 */
#ifndef PHONGSPLAT_SCENE_NODE_TRANSFORM_H
#define PHONGSPLAT_SCENE_NODE_TRANSFORM_H

#include "scene/scene.h"

/* Stores the local transform of a node, relative to its parent, as a column-major 4 x 4 matrix. */
void psplat_scene_local(const psplat_scene_node *node, double matrix[16]);

#endif
