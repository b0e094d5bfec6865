/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * legend.h - the legend of a heat map: what its panels show, and colour bars with numbers.
 */
#ifndef PHONGSPLAT_VIEWS_LEGEND_H
#define PHONGSPLAT_VIEWS_LEGEND_H

#include <stdint.h>

/* What stands below one panel. */
typedef struct psplat_legend {
    const char *title;
    double limit;    /* the value of the brightest colour; negative: the panel has no colour bar */
    const char *key; /* what psplat_heat_uncovered means, or NULL */
} psplat_legend;

/* Returns the rows that a legend takes below panels of size x size pixels. */
int psplat_legend_height(int size);

/* Draws the legends of count panels side by side into 8-bit RGB pixels of
 * psplat_legend_height(size) rows, each of count * size pixels, row 0 on top. What does not fit
 * below its panel is cut off. */
void psplat_legend_draw(const psplat_legend *legends, int count, int size, uint8_t *pixels);

#endif
