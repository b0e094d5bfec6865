/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * views.c - twelve views from the corners of an icosahedron, which lie as evenly around a model as
 * twelve can.
 *
 * It is turned by 20, 125 and -25 degrees about z, x and y: among turns by multiples of 5 degrees
 * none keeps its corners farther from the axes (11.4 degrees), from the planes between them (7.3),
 * and from where reflections and quarter turns that map the axes onto each other take other corners
 * (7.3), but for a corner's opposite. So no view of a part with axis-aligned faces looks along one,
 * and no two show a symmetric part alike, but from opposite sides.
 */
#include "views.h"

#include "picture.h"

#include <math.h>

static const double degree = 3.141592653589793 / 180;
static const double golden = 1.618033988749895;
static const double margin = 1.05; /* room for what lies around the source in an exhibit */

static void turn(double *a, double *b, double angle) {
    double c = cos(angle * degree), s = sin(angle * degree), x = *a;
    *a = c * x - s * *b;
    *b = s * x + c * *b;
}

/* Cyclic permutations of (0, +-1, +-golden). */
static void corner_of(int index, double corner[3]) {
    int axis = index % 3, signs = index / 3;
    double p[3];
    p[axis] = 0;
    p[(axis + 1) % 3] = signs & 1 ? -1 : 1;
    p[(axis + 2) % 3] = signs & 2 ? -golden : golden;
    turn(&p[0], &p[1], 20);
    turn(&p[1], &p[2], 125);
    turn(&p[2], &p[0], -25);
    for (int k = 0; k < 3; ++k) corner[k] = p[k] / sqrt(1 + golden * golden);
}

psplat_view psplat_views_at(int index, const double center[3], double radius, int size) {
    psplat_view view = {.width = size, .height = size};
    double corner[3];
    corner_of(index, corner);
    const psplat_viewpoint viewpoint = {.azimuth_degrees = atan2(corner[0], corner[2]) / degree,
                                        .elevation_degrees = asin(corner[1]) / degree};
    psplat_viewpoint_fit(&viewpoint, center, radius > 0 ? margin * radius : 1, &view);
    return view;
}
