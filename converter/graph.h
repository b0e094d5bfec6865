/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * graph.h - the graph of a scene as JSON: what the file held, with splats where meshes were.
 */
#ifndef PHONGSPLAT_GRAPH_H
#define PHONGSPLAT_GRAPH_H

#include "json_writer.h"
#include "scenes.h"

/* From the coordinates in which a mesh's splats are stored to those of the mesh. */
typedef struct psplat_placement {
    double translation[3];
    double scale;
} psplat_placement;

/* The members copyright and extras of "asset". */
void psplat_graph_write_asset(psplat_writer *json, const psplat_scene *scene);

/* The members scene, scenes, nodes, cameras and extras of the root. Both arrays are by the scene's
 * meshes: meshes says their index in the file, PSPLAT_NO_INDEX where there is none. Where a
 * placement is more than the identity, a node with a mesh gets a child for it, behind all nodes of
 * the scene; a node that nothing else hangs on, without name, extras, children, camera and light,
 * takes it itself, and so do nodes that we made. */
void psplat_graph_write(psplat_writer *json, const psplat_scene *scene,
                        const psplat_placement *placements, const uint32_t *meshes);

/* KHR_lights_punctual as a member of the root's "extensions", where there are lights. */
void psplat_graph_write_lights(psplat_writer *json, const psplat_scene *scene);

#endif
