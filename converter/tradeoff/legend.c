/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * legend.c - what the marks stand for, beside the data.
 */
#include "plot.h"

#include <math.h>

static double add_entry(const psplat_plot *p, double y, const psplat_look *l, const char *name) {
    psplat_text *svg = p->svg;
    if (l->has_line)
        psplat_text_add(svg, "<path stroke=\"%s\" stroke-width=\"1.4\"%s d=\"M%d %.1fh28\"/>",
                        l->color, l->is_hollow ? " stroke-dasharray=\"5 3\"" : "",
                        PSPLAT_PLOT_LEGEND, y);
    psplat_mark_group(svg, l);
    psplat_mark_begin(svg, l->mark, PSPLAT_PLOT_LEGEND + 14, y);
    psplat_text_add(svg, ">");
    psplat_mark_end(svg, l->mark);
    psplat_text_add(svg, "</g><text x=\"%d\" y=\"%.1f\">%s</text>\n", PSPLAT_PLOT_LEGEND + 38,
                    y + PSPLAT_HALF_LETTER, name);
    return y + 22;
}

static double add_line_entry(const psplat_plot *p, double y, const char *attributes,
                             const char *name) {
    psplat_text_add(p->svg, "<path %s d=\"M%d %.1fh28\"/><text x=\"%d\" y=\"%.1f\">%s</text>\n",
                    attributes, PSPLAT_PLOT_LEGEND, y, PSPLAT_PLOT_LEGEND + 38,
                    y + PSPLAT_HALF_LETTER, name);
    return y + 22;
}

/* How many of the rows that are shown are of a contender, with or without filter. */
static size_t count_shown(const psplat_plot *p, psplat_contender contender, int no_filter) {
    size_t count = 0;
    for (size_t i = 0; i < p->journal->count; ++i) {
        const psplat_row *row = &p->journal->rows[i];
        count += psplat_plot_shows(p->chart, row) && row->setting.contender == contender &&
                 row->setting.no_filter == no_filter;
    }
    return count;
}

static int leaves_frame(const psplat_plot *p) {
    for (size_t i = 0; i < p->journal->count; ++i)
        if (psplat_plot_shows(p->chart, &p->journal->rows[i]) &&
            !psplat_plot_holds(p, &p->journal->rows[i]))
            return 1;
    return 0;
}

static psplat_look look_of_mode(int mode) {
    const psplat_setting setting = {.contender = PSPLAT_CONTENDER_SPLATS,
                                    .mode = (psplat_mode)mode};
    return psplat_mark_look(&setting);
}

static double draw_modes(const psplat_plot *p, double y) {
    for (int mode = 0; mode < PSPLAT_DRAWN_MODES; ++mode) {
        psplat_look l = look_of_mode(mode);
        l.has_line = 0;
        y = add_entry(p, y, &l, psplat_mode_names[mode]);
    }
    return y + 10;
}

void psplat_legend_draw(const psplat_plot *p) {
    const char *color = p->chart->by_asset ? look_of_mode(0).color : PSPLAT_NEUTRAL_COLOR;
    const psplat_look linear = {color, 'c', 0, 1}, constant = {color, 'c', 1, 1};
    const psplat_look unfiltered = {PSPLAT_NEUTRAL_COLOR, 'x', 0, 0},
                      simplified = {PSPLAT_SIMPLIFIED_COLOR, 'd', 0, 1};
    double y = PSPLAT_PLOT_TOP + 8;
    if (!p->chart->by_asset) y = draw_modes(p, y);
    y = add_entry(p, y, &linear, "linear normals");
    y = add_entry(p, y, &constant, "constant normals");
    if (count_shown(p, PSPLAT_CONTENDER_SPLATS, 1)) y = add_entry(p, y, &unfiltered, "no filter");
    y += 10;
    if (p->front_count > 1)
        y = add_line_entry(p, y,
                           "stroke=\"" PSPLAT_FRONT_COLOR "\" stroke-width=\"12\" "
                           "stroke-opacity=\"0.6\" stroke-linecap=\"round\"",
                           "Pareto front");
    if (count_shown(p, PSPLAT_CONTENDER_GLTFPACK, 0))
        y = add_entry(p, y, &simplified,
                      leaves_frame(p) ? "gltfpack, leaves the chart" : "gltfpack");
    if (isfinite(psplat_plot_reference(p)))
        y = add_line_entry(p, y,
                           "stroke=\"" PSPLAT_SIMPLIFIED_COLOR
                           "\" stroke-width=\"1.4\" stroke-dasharray=\"2 4\"",
                           "source mesh");
    if (!psplat_plot_is_time(p->chart->x)) return;
    add_line_entry(p, y, "stroke=\"" PSPLAT_NEUTRAL_COLOR "\" stroke-opacity=\"0.5\"",
                   "half of the frames");
}
