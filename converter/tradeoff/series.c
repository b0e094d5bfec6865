/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * series.c - what belongs together in a chart: lines through the tolerances of a way to draw, their
 * points, the front.
 */
#include "plot.h"

#include <math.h>
#include <string.h>

/* Rows that differ in tolerance or ratio alone, in the order of the journal. */
static int is_of_series(const psplat_plot *p, const psplat_row *row, const psplat_setting *first) {
    const psplat_setting *s = &row->setting;
    return psplat_plot_shows(p->chart, row) && s->contender == first->contender &&
           s->field == first->field && s->precision == first->precision && s->mode == first->mode &&
           s->no_filter == first->no_filter;
}

static int begins_series(const psplat_plot *p, size_t row) {
    const psplat_row *rows = p->journal->rows;
    if (!psplat_plot_shows(p->chart, &rows[row])) return 0;
    for (size_t i = 0; i < row; ++i)
        if (is_of_series(p, &rows[i], &rows[row].setting)) return 0;
    return 1;
}

static void draw_series_line(const psplat_plot *p, const psplat_setting *first) {
    const psplat_journal *j = p->journal;
    const psplat_look l = psplat_mark_look(first);
    char command = 'M';
    if (!l.has_line) return;
    psplat_text_add(p->svg, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\"%s d=\"",
                    l.color, l.is_hollow ? " stroke-dasharray=\"5 3\"" : "");
    for (size_t i = 0; i < j->count; ++i) {
        if (!is_of_series(p, &j->rows[i], first)) continue;
        psplat_text_add(p->svg, "%c%.1f %.1f", command,
                        psplat_plot_x(p, j->rows[i].values[p->chart->x]),
                        psplat_plot_y(p, j->rows[i].values[p->chart->y]));
        command = 'L';
    }
    psplat_text_add(p->svg, "\"/>\n");
}

/* Half of all frames took a time within the bar. */
static void draw_spread(const psplat_plot *p, const psplat_row *row) {
    double low = row->values[p->chart->x + 1], high = row->values[p->chart->x + 2];
    if (!isfinite(low) || !isfinite(high)) return;
    psplat_text_add(p->svg, "<path stroke=\"%s\" stroke-opacity=\"0.35\" d=\"M%.1f %.1fH%.1f\"/>\n",
                    psplat_mark_look(&row->setting).color, psplat_plot_x(p, low),
                    psplat_plot_y(p, row->values[p->chart->y]), psplat_plot_x(p, high));
}

static void draw_spreads(const psplat_plot *p) {
    for (size_t i = 0; i < p->journal->count && psplat_plot_is_time(p->chart->x); ++i)
        if (psplat_plot_holds(p, &p->journal->rows[i])) draw_spread(p, &p->journal->rows[i]);
}

/* Tolerances beside the series that the defaults draw, ratios beside gltfpack's: where neighbours
 * are fewest, and within the frame. */
static void draw_label(const psplat_plot *p, const psplat_row *row) {
    const psplat_setting *s = &row->setting;
    int is_simplified = s->contender == PSPLAT_CONTENDER_GLTFPACK;
    if (!is_simplified && (s->field || s->mode || s->no_filter)) return;
    double x = psplat_plot_x(p, row->values[p->chart->x]),
           y = psplat_plot_y(p, row->values[p->chart->y]);
    int is_time = psplat_plot_is_time(p->chart->x);
    int is_beside = is_simplified || is_time || p->chart->y == PSPLAT_COLUMN_DISTANCE_MAX;
    int is_right = is_beside && x < PSPLAT_PLOT_RIGHT - 50;
    int is_above = is_simplified || (is_right && !is_time);
    psplat_text_add(p->svg,
                    "<text x=\"%.1f\" y=\"%.1f\" font-size=\"11\" text-anchor=\"%s\" "
                    "fill=\"%s\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">",
                    x + (is_right ? 8 : -8), y + (is_above ? -5 : 14), is_right ? "start" : "end",
                    psplat_mark_look(s).color);
    psplat_text_add(p->svg, is_simplified ? "-si %.4g</text>\n" : "%.4g %%</text>\n",
                    is_simplified ? s->ratio : s->tolerance);
}

/* What leaves the frame is cut off there. Several charts in one page need a name each. */
static void begin_clip(const psplat_plot *p) {
    const char *name = p->chart->file;
    int length = (int)strcspn(name, ".");
    psplat_text_add(p->svg,
                    "<clipPath id=\"frame-%.*s\"><path d=\"M%d %dH%dV%dH%dz\"/></clipPath>\n"
                    "<g clip-path=\"url(#frame-%.*s)\">\n",
                    length, name, PSPLAT_PLOT_LEFT, PSPLAT_PLOT_TOP, PSPLAT_PLOT_RIGHT,
                    PSPLAT_PLOT_BOTTOM, PSPLAT_PLOT_LEFT, length, name);
}

void psplat_series_draw(const psplat_plot *p) {
    const psplat_journal *j = p->journal;
    begin_clip(p);
    for (size_t i = 0; i < j->count; ++i)
        if (begins_series(p, i)) draw_series_line(p, &j->rows[i].setting);
    draw_spreads(p);
    psplat_text_add(p->svg, "</g>\n");
    for (size_t i = 0; i < j->count; ++i)
        if (psplat_plot_holds(p, &j->rows[i])) draw_label(p, &j->rows[i]);
    for (size_t i = 0; i < j->count; ++i) {
        if (!begins_series(p, i)) continue;
        const psplat_look l = psplat_mark_look(&j->rows[i].setting);
        psplat_mark_group(p->svg, &l);
        for (size_t k = i; k < j->count; ++k)
            if (is_of_series(p, &j->rows[k], &j->rows[i].setting) &&
                psplat_plot_holds(p, &j->rows[k]))
                psplat_mark_draw(p, &j->rows[k]);
        psplat_text_add(p->svg, "</g>\n");
    }
}

void psplat_series_front(const psplat_plot *p) {
    if (p->front_count < 2) return;
    psplat_text_add(p->svg,
                    "<path fill=\"none\" stroke=\"%s\" stroke-width=\"12\" stroke-opacity=\"0.6\" "
                    "stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"",
                    PSPLAT_FRONT_COLOR);
    for (size_t i = 0; i < p->front_count; ++i) {
        const psplat_row *row = &p->journal->rows[p->order[i]];
        psplat_text_add(p->svg, "%c%.1f %.1f", i ? 'L' : 'M',
                        psplat_plot_x(p, row->values[p->chart->x]),
                        psplat_plot_y(p, row->values[p->chart->y]));
    }
    psplat_text_add(p->svg, "\"/>\n");
}

void psplat_series_reference(const psplat_plot *p) {
    double value = psplat_plot_reference(p);
    if (!isfinite(value)) return;
    psplat_text_add(p->svg,
                    "<path stroke=\"%s\" stroke-width=\"1.4\" stroke-dasharray=\"2 4\" "
                    "d=\"M%.1f %dV%d\"><title>source mesh: ",
                    PSPLAT_SIMPLIFIED_COLOR, psplat_plot_x(p, value), PSPLAT_PLOT_TOP,
                    PSPLAT_PLOT_BOTTOM);
    psplat_text_figure(p->svg, value);
    psplat_text_add(p->svg, " ms</title></path>\n");
}
