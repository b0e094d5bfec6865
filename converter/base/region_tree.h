/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_tree.h - axis-aligned bounding box tree (AABB tree) over splat regions.
 */
#ifndef PHONGSPLAT_BASE_REGION_TREE_H
#define PHONGSPLAT_BASE_REGION_TREE_H

#include "base/region.h"

#include <stdint.h>

typedef struct psplat_region_tree psplat_region_tree;

/* Builds a tree of the boxes around the regions, each grown by reach. The regions are not kept.
 * Returns NULL when out of memory. */
psplat_region_tree *psplat_region_tree_create(const psplat_region *regions, size_t count,
                                              double reach);

/* Builds a tree of the boxes around all points that lie over the regions, or under them, as
 * psplat_region_contains has it, and no farther from their surfaces than a tolerance, as
 * psplat_region_local tells. That is all that these cover, in boxes that are hardly larger: a slack
 * of 2e-6 of u and v is allowed for. */
psplat_region_tree *psplat_region_tree_create_covering(const psplat_region *regions, size_t count,
                                                       double tolerance);

/* Calls visit with the index of each region whose box in the tree holds the point, until visit
 * returns other than 0. */
void psplat_region_tree_visit(const psplat_region_tree *region_tree, const double point[3],
                              int (*visit)(void *user, uint32_t region), void *user);

/* Does the same for each region whose box in the tree meets the box low, high. */
void psplat_region_tree_visit_box(const psplat_region_tree *region_tree, const double low[3],
                                  const double high[3], int (*visit)(void *user, uint32_t region),
                                  void *user);

/* Does the same for each region whose box in the tree, grown by a length to all sides, meets a
 * segment, and perhaps for some that it just misses by rounding. */
void psplat_region_tree_visit_segment(const psplat_region_tree *region_tree, const double from[3],
                                      const double to[3], double length,
                                      int (*visit)(void *user, uint32_t region), void *user);

void psplat_region_tree_destroy(psplat_region_tree *region_tree);

#endif
