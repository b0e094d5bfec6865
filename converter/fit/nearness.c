/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * nearness.c - whether points and regions are within the tolerance of the mesh, by its proxy if it
 * has one.
 *
 * What is within the tolerance less the proxy's deviation of the proxy is within the tolerance of
 * the mesh. What is a little farther from the proxy counts as farther from the mesh, which it need
 * not be: to ask the mesh would take as long as it has triangles.
 */
#include "fit/nearness.h"

#include "base/region.h"
#include "base/vector.h"
#include "fit/region_near.h"
#include "mesh/distance.h"

#include <stdint.h>

/* How far beyond a border of charts, as a part of its shorter radius, a region has to be near the
 * surface, so that normals blend across: with 0.15 edges still show at borders, and 0.3 takes 1 to
 * 8 % more splats. */
static const double chart_reach = 0.3;

static const psplat_distance *asked(const psplat_limits *limits) {
    return limits->proxy ? limits->proxy : limits->distance;
}

static double tolerance_of_asked(const psplat_limits *limits) {
    return limits->proxy ? limits->tolerance - limits->proxy_deviation : limits->tolerance;
}

psplat_result psplat_limits_point_near(const psplat_limits *limits, const double point[3],
                                       uint32_t *guess, int *near) {
    return psplat_distance_is_within(asked(limits), point, tolerance_of_asked(limits), guess, near);
}

psplat_result psplat_limits_region_near(const psplat_limits *limits, const psplat_region *region,
                                        int *near) {
    return psplat_region_near(region, asked(limits), tolerance_of_asked(limits), near);
}

psplat_region psplat_region_beyond_charts(const psplat_region *region) {
    psplat_region wide = *region;
    for (uint32_t i = 0; i < wide.line_count; ++i) {
        double a = wide.lines[i][0] / wide.radius[0], b = wide.lines[i][1] / wide.radius[1];
        if (wide.chart_lines >> i & 1)
            wide.lines[i][2] += chart_reach * wide.radius[1] * norm2(a, b);
    }
    return wide;
}
