/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * graph_json.h - the node graph of a scene as glTF JSON: that of the source file, with splats in
 * place of its meshes.
 */
#ifndef PHONGSPLAT_EXPORT_GRAPH_JSON_H
#define PHONGSPLAT_EXPORT_GRAPH_JSON_H

#include "base/json_writer.h"
#include "scene/scene.h"

/* The transform from the coordinates in which a mesh's splats are stored to those of the mesh:
 * scale first, then translation. */
typedef struct psplat_dequantize_transform {
    double translation[3];
    double scale;
} psplat_dequantize_transform;

/* Writes the members copyright and extras of "asset". */
void psplat_graph_write_asset(psplat_writer *json, const psplat_scene *scene);

/* Writes the members scene, scenes, nodes, cameras and extras of the root. placements and meshes
 * have one element for each mesh of the scene; meshes[i] is the index of mesh i in the file, or
 * PSPLAT_NO_INDEX if it is not written. A node whose mesh has a placement other than the identity
 * gets a child for it, which is written after all nodes of the scene. The placement is multiplied
 * into the node itself if it has no name, extras, children, camera or light and no animation moves
 * it, so that nothing depends on its transform, and if the node was made by the reader (is_made).
 */
void psplat_graph_write(psplat_writer *json, const psplat_scene *scene,
                        const psplat_dequantize_transform *placements, const uint32_t *meshes);

/* Writes KHR_lights_punctual as a member of the root's "extensions", if there are lights. */
void psplat_graph_write_lights(psplat_writer *json, const psplat_scene *scene);

#endif
