/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * metric.h - metrics in which floods measure how far they reach.
 */
#ifndef PHONGSPLAT_FEATURES_METRIC_H
#define PHONGSPLAT_FEATURES_METRIC_H

#include "base/vector.h"

/* A metric in which the distance of a point p from the centre is |rows (p - center)|. No distance
 * in it is greater than the Euclidean one. */
typedef struct psplat_metric {
    double center[3];
    double rows[3][3];
} psplat_metric;

/* Stores the coordinates of a point, whose length is its distance from the centre. */
static inline void psplat_metric_coordinates(const psplat_metric *metric, const double p[3],
                                             double w[3]) {
    double d[3];
    sub3(d, p, metric->center);
    for (int k = 0; k < 3; ++k) w[k] = dot3(metric->rows[k], d);
}

#endif
