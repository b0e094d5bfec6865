/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * open_charts.h - a surface and its samples as they are where borders of charts bound nothing.
 */
#ifndef PHONGSPLAT_FEATURES_OPEN_CHARTS_H
#define PHONGSPLAT_FEATURES_OPEN_CHARTS_H

#include "features/samples.h"
#include "features/surface.h"

/* Views of a surface and of its samples, which share all with these but for what bounds patches:
 * borders of charts do not. So floods over clusters go on across them. The patches of the surface
 * are still those that borders of charts bound. */
typedef struct psplat_open_charts {
    psplat_surface surface;
    psplat_samples samples;
} psplat_open_charts;

/* Makes the views of a surface and of blue noise on it, which must outlive them. Returns 0 when out
 * of memory. The caller frees *open with psplat_open_charts_free, also on failure. */
int psplat_open_charts_create(const psplat_surface *surface, const psplat_samples *samples,
                              psplat_open_charts *open);

/* Frees what is the views' own, and zeroes them. */
void psplat_open_charts_free(psplat_open_charts *open);

#endif
