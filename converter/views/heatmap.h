/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * heatmap.h - heat maps: pictures of the places where errors are.
 */
#ifndef PHONGSPLAT_VIEWS_HEATMAP_H
#define PHONGSPLAT_VIEWS_HEATMAP_H

#include <phongsplat/splat.h>

#include "compare/shape_errors.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <stdint.h>

/* The values from which on a heat map shows its brightest colour. */
typedef struct psplat_heatmap_limits {
    double difference; /* of colours, % of white */
    double distance;   /* % of the diagonal */
    double angle;      /* of normals, degrees */
} psplat_heatmap_limits;

/* Draws five panels of size x size pixels side by side, 8-bit RGB with row 0 on top: the source,
 * what is pictured, the difference of their colours, and the distance and the normal error at the
 * points of the source that are seen. Colours run from black (0) over violet and orange to pale
 * yellow (the limit and more). Cyan means not covered, as the probe says; dark grey means that
 * nothing is there. Below is a legend with numbers and units (views/legend.h). *pixels is from
 * malloc and owned by the caller, *width and *height are those of all panels and the legend
 * together. Errors: ARGUMENT, MEMORY, GRAPHICS; *pixels is NULL then. */
psplat_result psplat_picture_views_heatmap(psplat_picture_views *views,
                                           const psplat_pictured *pictured,
                                           const psplat_shape_probe *probe, int view,
                                           const psplat_heatmap_limits *limits, uint8_t **pixels,
                                           int *width, int *height, psplat_error *error);

#endif
