/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * heat_colors.h - the colours of heat maps, for the maps and their legend.
 */
#ifndef PHONGSPLAT_VIEWS_HEAT_COLORS_H
#define PHONGSPLAT_VIEWS_HEAT_COLORS_H

#include <stdint.h>

/* The colours of pixels without a surface, and of surface that is not covered. */
extern const uint8_t psplat_heat_nothing[3], psplat_heat_uncovered[3];

/* Stores the colour of a value from 0 to limit and more: black over violet and orange to pale
 * yellow. Not-a-number gets the brightest colour. */
void psplat_heat_color(double value, double limit, uint8_t *rgb);

#endif
