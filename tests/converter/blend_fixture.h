/* SPDX-License-Identifier: MIT
 *
 * blend_fixture.h - the normals that splats blend to at points of a surface. Include it after
 * stage_fixture.h.
 */
#ifndef PHONGSPLAT_TESTS_BLEND_FIXTURE_H
#define PHONGSPLAT_TESTS_BLEND_FIXTURE_H

#include "base/region_tree.h"
#include "base/vector.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "stage_fixture.h"

/* Adds the fragment of a splat to a psplat_point_blend. */
static inline int blend_visit(void *user, uint32_t splat) {
    psplat_point_blend_add(user, splat);
    return 0;
}

/* Returns the angle, in degrees, between the normal that splats blend to at a point, from which
 * they may be as far away as the reach, and the normal of the surface there. The point is in the
 * file's coordinates, to which the origin is that of the splats. */
static inline double blend_normal_error(const psplat_measured_splats *measured,
                                        const double origin[3], double reach, const double point[3],
                                        const double normal[3]) {
    psplat_point_blend blend = {.measured = measured, .reach = reach, .limit = -HUGE_VAL};
    double cross[3];
    sub3(blend.point, point, origin);
    memcpy(blend.normal, normal, sizeof blend.normal);
    psplat_region_tree_visit(measured->region_tree, blend.point, blend_visit, &blend);
    assert_true(blend.weight > 0);
    cross3(cross, blend.blended, normal);
    return atan2(length3(cross), dot3(blend.blended, normal)) * 180 / fixture_pi;
}

#endif
