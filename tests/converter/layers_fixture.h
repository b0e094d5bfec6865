/* SPDX-License-Identifier: MIT
 *
 * layers_fixture.h - a sheet that is laid back over itself, for tests of layers.
 */
#ifndef PHONGSPLAT_LAYERS_FIXTURE_H
#define PHONGSPLAT_LAYERS_FIXTURE_H

#include "stage_fixture.h"

#include <math.h>

enum { LAYERS_CELLS = 9 };
static const double layer_height = 0.01;

/* The lower layer takes the first five of ten columns of corners, the upper one the others, which
 * begins above where the lower one did; between them a strip goes back and faces down. */
static inline void place_layers(double s, double t, double p[3]) {
    int column = (int)lrint(s * LAYERS_CELLS), upper = column > 4;
    p[0] = column % 5 / 4.0, p[1] = t, p[2] = upper ? layer_height : 0;
}

static inline void fixture_layers(fixture *f) {
    fixture_grid(f, LAYERS_CELLS, LAYERS_CELLS, place_layers);
    fixture_build(f);
    fixture_sample(f, 0.05);
}

#endif
