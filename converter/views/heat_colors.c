/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * heat_colors.c - the colours of heat maps.
 */
#include "views/heat_colors.h"

const uint8_t psplat_heat_nothing[3] = {48, 48, 48}, psplat_heat_uncovered[3] = {0, 220, 220};

/* Nine colours of the colour map "inferno" by S. van der Walt and N. Smith (matplotlib, CC0). Their
 * lightness rises evenly, so that a map can be read in grey as well. */
static const uint8_t inferno[][3] = {{0, 0, 4},      {31, 12, 72},   {85, 15, 109},
                                     {136, 34, 106}, {186, 54, 85},  {227, 89, 51},
                                     {249, 140, 10}, {249, 201, 50}, {252, 255, 164}};

void psplat_heat_color(double value, double limit, uint8_t *rgb) {
    const int last = (int)(sizeof inferno / sizeof *inferno) - 1;
    double part = value <= 0 ? 0 : value < limit ? value / limit : 1, at = part * last;
    int below = at < last ? (int)at : last - 1;
    for (int c = 0; c < 3; ++c) {
        double low = inferno[below][c], high = inferno[below + 1][c];
        rgb[c] = (uint8_t)(low + (high - low) * (at - below) + 0.5);
    }
}
