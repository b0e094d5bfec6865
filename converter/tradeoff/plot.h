/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plot.h - what the files of a chart share: chart.c is the document, plot.c knows where things are,
 * mark.c how they look, series.c and legend.c draw them.
 */
#ifndef PHONGSPLAT_PLOT_H
#define PHONGSPLAT_PLOT_H

#include "tradeoff.h"

/* Pixels. */
enum {
    PSPLAT_PLOT_WIDTH = 880,
    PSPLAT_PLOT_HEIGHT = 500,
    PSPLAT_PLOT_LEFT = 74,
    PSPLAT_PLOT_RIGHT = 656,
    PSPLAT_PLOT_TOP = 50,
    PSPLAT_PLOT_BOTTOM = 436,
    PSPLAT_PLOT_LEGEND = 680,
    PSPLAT_HALF_LETTER = 4 /* from the middle of 12 pixel letters down to their line */
};

#define PSPLAT_SIMPLIFIED_COLOR "#444444"
#define PSPLAT_NEUTRAL_COLOR "#666666"
#define PSPLAT_FRONT_COLOR "#f0e442"

typedef struct psplat_plot {
    const psplat_chart *chart;
    const psplat_journal *journal;
    psplat_axis x, y;
    uint8_t *is_front; /* journal->count */
    size_t *order;     /* of the front */
    size_t front_count;
    psplat_text *svg;
} psplat_plot;

/* ---- plot.c: where things are -----------------------------------------------------------------
 */

/* Whether a row has a point; the source has none, for it has no error. */
int psplat_plot_shows(const psplat_chart *chart, const psplat_row *row);
/* And within the frame: simplified meshes may be too good, or too bad, to be drawn beside splats.
 */
int psplat_plot_holds(const psplat_plot *plot, const psplat_row *row);
int psplat_plot_is_time(psplat_column column);
/* What the source costs; NaN where the chart shows nothing of it. */
double psplat_plot_reference(const psplat_plot *plot);
double psplat_plot_x(const psplat_plot *plot, double value);
double psplat_plot_y(const psplat_plot *plot, double value);
void psplat_plot_axes(const psplat_plot *plot);
void psplat_plot_frame(const psplat_plot *plot);

/* ---- mark.c: how points look ------------------------------------------------------------------
 */

typedef struct psplat_look {
    const char *color;
    char mark; /* circle, square, triangle, diamond, x */
    int is_hollow, has_line;
} psplat_look;

psplat_look psplat_mark_look(const psplat_setting *setting);
/* Colours of what follows, until "</g>". */
void psplat_mark_group(psplat_text *svg, const psplat_look *look);
/* Around what a mark tells, which begins with ">". */
void psplat_mark_begin(psplat_text *svg, char mark, double x, double y);
void psplat_mark_end(psplat_text *svg, char mark);
void psplat_mark_draw(const psplat_plot *plot, const psplat_row *row);

/* ---- series.c: points, lines, front -----------------------------------------------------------
 */

void psplat_series_draw(const psplat_plot *plot);
void psplat_series_front(const psplat_plot *plot);
void psplat_series_reference(const psplat_plot *plot); /* the source's cost as a line */

/* ---- legend.c ---------------------------------------------------------------------------------
 */

void psplat_legend_draw(const psplat_plot *plot);

#endif
