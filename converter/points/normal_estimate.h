/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * normal_estimate.h - normal estimation and smoothing of point sets by quadrics (osculating jets).
 */
#ifndef PHONGSPLAT_POINTS_NORMAL_ESTIMATE_H
#define PHONGSPLAT_POINTS_NORMAL_ESTIMATE_H

#include <phongsplat/splat.h>

#include "points/point_cloud.h"

/* Estimates the normals (kept_count x 3, unit) of a cloud from quadrics through the points that the
 * front connects to each point (Cazals, Pouget: Estimating differential quantities using polynomial
 * fitting of osculating jets, 2005). Neighbours by edges instead of by distance keep the two sides
 * of a thin sheet apart. A normal is 0 at a crease, or where the front has no triangle. Fails only
 * with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_points_estimate_normals(const psplat_point_cloud *cloud, float *normals);

/* Measures the noise of the set, and moves the kept positions of a very noisy set onto quadrics
 * through their neighbours. If sides is set, neighbours whose normals face away are left out. Fails
 * only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_points_smooth(psplat_point_cloud *cloud, int sides);

#endif
