/* SPDX-License-Identifier: MIT
 *
 * tube_fixture.h - tubes of twelve sides in the text of an OBJ file.
 */
#ifndef PHONGSPLAT_TESTS_TUBE_FIXTURE_H
#define PHONGSPLAT_TESTS_TUBE_FIXTURE_H

#include "mesh_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TUBE_SIDES = 12, TUBE_TEXT = 65536 };

static const double tube_pi = 3.14159265358979323846;

/* A file under construction. */
typedef struct obj {
    char text[TUBE_TEXT];
    int vertices;
} obj;

/* Appends a tube with caps in rings + 1 rings about an arc in the plane of x and y, or about the x
 * axis where turn is 0. */
static inline void add_tube(obj *o, double radius, double length, double turn, int rings,
                            double z) {
    char *end = o->text + strlen(o->text);
    for (int ring = 0; ring <= rings; ++ring) {
        double at = length * ring / rings, angle = turn * ring / rings,
               bend = turn > 0 ? length / turn : 0;
        double x = turn > 0 ? bend * sin(angle) : at, y = turn > 0 ? bend * (1 - cos(angle)) : 0;
        for (int side = 0; side < TUBE_SIDES; ++side) {
            double a = 2 * tube_pi * side / TUBE_SIDES, out = radius * cos(a);
            end += sprintf(end, "v %.9g %.9g %.9g\n", x - out * sin(angle), y + out * cos(angle),
                           z + radius * sin(a));
        }
    }
    for (int ring = 0; ring < rings; ++ring)
        for (int side = 0; side < TUBE_SIDES; ++side) {
            int a = o->vertices + TUBE_SIDES * ring + side + 1;
            int b = o->vertices + TUBE_SIDES * ring + (side + 1) % TUBE_SIDES + 1;
            end += sprintf(end, "f %d %d %d %d\n", a, a + TUBE_SIDES, b + TUBE_SIDES, b);
        }
    for (int cap = 0; cap < 2; ++cap) {
        end += sprintf(end, "f");
        for (int side = 0; side < TUBE_SIDES; ++side)
            end += sprintf(end, " %d",
                           o->vertices + 1 +
                               (cap ? TUBE_SIDES * rings + TUBE_SIDES - 1 - side : side));
        end += sprintf(end, "\n");
    }
    o->vertices += TUBE_SIDES * (rings + 1);
}

#endif
