/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * view_directions.c - the cameras of the picture views: twelve views from the corners of an
 * icosahedron, which are as evenly distributed around a model as twelve directions can be.
 *
 * The icosahedron is rotated by 20, 125 and -25 degrees about z, x and y. This keeps its corners at
 * least 11.4 degrees from the axes, 7.3 degrees from the planes between them, and 7.3 degrees from
 * the images of other corners (except opposite ones) under the symmetries of the axes; no other
 * rotation by multiples of 5 degrees does better. So no view looks along the faces of a model whose
 * faces are axis-aligned, and no two views show a symmetric model alike, except from opposite
 * sides.
 */
#include "views/view_directions.h"

#include "base/angle.h"
#include "picture/viewpoint.h"

#include <phongsplat/phongsplat.h>

#include <math.h>

static const double golden_ratio = 1.618033988749895;
/* The sphere that is pictured, in radii of the source's: splats may reach beyond the source. */
static const double sphere_margin = 1.05;

static void rotate(double *a, double *b, double angle) {
    double c = cos(angle * PSPLAT_DEGREE), s = sin(angle * PSPLAT_DEGREE), x = *a;
    *a = c * x - s * *b;
    *b = s * x + c * *b;
}

/* Finds a corner: cyclic permutations of (0, +-1, +-golden_ratio), rotated and of unit length. */
static void corner_of(int index, double corner[3]) {
    int axis = index % 3, signs = index / 3;
    double p[3];
    p[axis] = 0;
    p[(axis + 1) % 3] = signs & 1 ? -1 : 1;
    p[(axis + 2) % 3] = signs & 2 ? -golden_ratio : golden_ratio;
    rotate(&p[0], &p[1], 20);
    rotate(&p[1], &p[2], 125);
    rotate(&p[2], &p[0], -25);
    for (int k = 0; k < 3; ++k) corner[k] = p[k] / sqrt(1 + golden_ratio * golden_ratio);
}

psplat_view psplat_view_directions_at(int index, const double center[3], double radius, int size) {
    psplat_view view = {.width = size, .height = size};
    double corner[3];
    corner_of(index, corner);
    const psplat_viewpoint viewpoint = {.azimuth_degrees =
                                            atan2(corner[0], corner[2]) / PSPLAT_DEGREE,
                                        .elevation_degrees = asin(corner[1]) / PSPLAT_DEGREE};
    psplat_viewpoint_fit(&viewpoint, center, radius > 0 ? sphere_margin * radius : 1, &view);
    return view;
}
