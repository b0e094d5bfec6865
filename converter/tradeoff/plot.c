/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plot.c - where things are in a chart, and its axes.
 */
#include "plot.h"

#include <math.h>

/* The source itself is a line at its cost, for it has no error. */
int psplat_plot_shows(const psplat_chart *chart, const psplat_row *row) {
    const psplat_setting *s = &row->setting;
    if (s->contender == PSPLAT_CONTENDER_MESH) return 0;
    if (chart->by_asset && (s->mode != PSPLAT_MODE_PHONG || s->no_filter)) return 0;
    return isfinite(row->values[chart->x]) && isfinite(row->values[chart->y]);
}

int psplat_plot_is_time(psplat_column column) {
    return psplat_column_group(column) == PSPLAT_GROUP_TIMED;
}

/* The cost of the source; NaN where the chart shows none. */
double psplat_plot_reference(const psplat_plot *p) {
    const psplat_row *rows = p->journal->rows;
    for (size_t i = 0; i < p->journal->count && psplat_plot_is_time(p->chart->x); ++i)
        if (rows[i].setting.contender == PSPLAT_CONTENDER_MESH) return rows[i].values[p->chart->x];
    return NAN;
}

/* Simplified meshes may be too good, or too bad, to be drawn beside splats. */
int psplat_plot_holds(const psplat_plot *p, const psplat_row *row) {
    double y = row->values[p->chart->y];
    return psplat_plot_shows(p->chart, row) &&
           (row->setting.contender == PSPLAT_CONTENDER_SPLATS || (y > p->y.low && y < p->y.high));
}

double psplat_plot_x(const psplat_plot *p, double value) {
    return PSPLAT_PLOT_LEFT +
           psplat_axis_place(&p->x, value) * (PSPLAT_PLOT_RIGHT - PSPLAT_PLOT_LEFT);
}

double psplat_plot_y(const psplat_plot *p, double value) {
    return PSPLAT_PLOT_BOTTOM -
           psplat_axis_place(&p->y, value) * (PSPLAT_PLOT_BOTTOM - PSPLAT_PLOT_TOP);
}

/* ---- axes --------------------------------------------------------------------------------- */

static void add_tick_label(psplat_text *svg, psplat_column column, double value) {
    int is_bytes = column == PSPLAT_COLUMN_BYTES;
    double unit = !is_bytes || value < 999.5 ? 1 : value < 999999.5 ? 1e3 : 1e6;
    const char *name = !is_bytes ? "" : unit >= 1e6 ? " MB" : unit >= 1e3 ? " kB" : " B";
    double shown = value / unit;
    if (shown >= 1000 && shown < 1e12)
        psplat_text_figure(svg, shown);
    else
        psplat_text_add(svg, "%.6g", shown);
    psplat_text_add(svg, "%s", name);
}

static void draw_x_axis(const psplat_plot *p) {
    psplat_text *svg = p->svg;
    for (size_t i = 0; i < p->x.tick_count; ++i) {
        double x = psplat_plot_x(p, p->x.ticks[i]);
        int is_labelled = p->x.labelled[i];
        if (is_labelled)
            psplat_text_add(svg, "<path stroke=\"#e4e4e4\" d=\"M%.1f %dV%d\"/>", x, PSPLAT_PLOT_TOP,
                            PSPLAT_PLOT_BOTTOM);
        psplat_text_add(svg, "<path stroke=\"#888\" d=\"M%.1f %dv%d\"/>\n", x, PSPLAT_PLOT_BOTTOM,
                        is_labelled ? 6 : 3);
        if (!is_labelled) continue;
        psplat_text_add(svg, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">", x,
                        PSPLAT_PLOT_BOTTOM + 21);
        add_tick_label(svg, p->chart->x, p->x.ticks[i]);
        psplat_text_add(svg, "</text>\n");
    }
    psplat_text_add(svg, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\" font-size=\"13\">",
                    (PSPLAT_PLOT_LEFT + PSPLAT_PLOT_RIGHT) / 2, PSPLAT_PLOT_BOTTOM + 48);
    psplat_text_escaped(svg, p->chart->x_label);
    psplat_text_add(svg, "</text>\n");
}

static void draw_y_axis(const psplat_plot *p) {
    psplat_text *svg = p->svg;
    for (size_t i = 0; i < p->y.tick_count; ++i) {
        double y = psplat_plot_y(p, p->y.ticks[i]);
        int is_labelled = p->y.labelled[i];
        if (is_labelled)
            psplat_text_add(svg, "<path stroke=\"#e4e4e4\" d=\"M%d %.1fH%d\"/>", PSPLAT_PLOT_LEFT,
                            y, PSPLAT_PLOT_RIGHT);
        psplat_text_add(svg, "<path stroke=\"#888\" d=\"M%d %.1fh%d\"/>\n", PSPLAT_PLOT_LEFT, y,
                        is_labelled ? -6 : -3);
        if (!is_labelled) continue;
        psplat_text_add(svg, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">",
                        PSPLAT_PLOT_LEFT - 10, y + PSPLAT_HALF_LETTER);
        add_tick_label(svg, p->chart->y, p->y.ticks[i]);
        psplat_text_add(svg, "</text>\n");
    }
    psplat_text_add(svg,
                    "<text transform=\"translate(20 %d) rotate(-90)\" text-anchor=\"middle\" "
                    "font-size=\"13\">",
                    (PSPLAT_PLOT_TOP + PSPLAT_PLOT_BOTTOM) / 2);
    psplat_text_escaped(svg, p->chart->y_label);
    psplat_text_add(svg, "</text>\n");
}

void psplat_plot_axes(const psplat_plot *p) {
    draw_x_axis(p);
    draw_y_axis(p);
}

void psplat_plot_frame(const psplat_plot *p) {
    psplat_text_add(p->svg, "<path fill=\"none\" stroke=\"#888\" d=\"M%d %dV%dH%d\"/>\n",
                    PSPLAT_PLOT_LEFT, PSPLAT_PLOT_TOP, PSPLAT_PLOT_BOTTOM, PSPLAT_PLOT_RIGHT);
}
