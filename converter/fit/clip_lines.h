/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clip_lines.h - the choice of clip lines that keep a splat on its side of the creases around it.
 */
#ifndef PHONGSPLAT_FIT_CLIP_LINES_H
#define PHONGSPLAT_FIT_CLIP_LINES_H

#include "base/region.h"
#include "fit/crease_segments.h"

/* Replaces the lines of a region by up to PSPLAT_MAX_CLIP_LINES that keep the seed (u, v) and cut
 * away every crease segment. The region may then reach over a crease by at most slack, a length in
 * the plane. Lines are straight unless may_bend is 1. Returns 1 on success. Returns 0, and leaves
 * no lines, where so many do not suffice or memory runs out. */
int psplat_clip_choose(psplat_region *region, const psplat_segment *segments, size_t count,
                       const double seed[2], double slack, int may_bend);

#endif
