/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * node_transform.c - the local transform of one node (glTF 2.0 section 3.5.3), in double precision.
 */
#include "scene/node_transform.h"

#include "scene/scene.h"

#include <string.h>

/* The transform is translation x rotation x scale, or the node's matrix. */
void psplat_scene_local(const psplat_scene_node *node, double matrix[16]) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    memcpy(matrix, node->has_matrix ? node->matrix : identity, sizeof identity);
    if (node->has_matrix) return;
    double x = node->rotation[0], y = node->rotation[1], z = node->rotation[2],
           w = node->rotation[3];
    const double rotation[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            matrix[4 * column + row] = rotation[3 * column + row] * node->scale[column];
    memcpy(matrix + 12, node->translation, sizeof node->translation);
}
