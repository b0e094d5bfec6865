/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mark.c - how points look. Colour and mark stand for how splats are drawn, filled or hollow for
 * their normals, so that neither is needed to tell the other. Colours are those of Okabe and Ito
 * (2008), which colour-blind people tell apart.
 */
#include "plot.h"

#include <stdlib.h>

static const char *const mode_colors[] = {"#0072b2", "#d55e00", "#009e73"};
static const char mode_marks[] = {'c', 's', 't'};

psplat_look psplat_mark_look(const psplat_setting *s) {
    if (s->contender == PSPLAT_CONTENDER_GLTFPACK)
        return (psplat_look){PSPLAT_SIMPLIFIED_COLOR, 'd', 0, 1};
    if (s->no_filter) return (psplat_look){mode_colors[s->mode], 'x', 0, 0};
    return (psplat_look){mode_colors[s->mode], mode_marks[s->mode],
                         s->field == PSPLAT_FIELD_CONSTANT, 1};
}

/* Without its end, for a title may follow. */
void psplat_mark_begin(psplat_text *svg, char mark, double x, double y) {
    switch (mark) {
    case 'c':
        psplat_text_add(svg, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\"", x, y);
        break;
    case 's':
        psplat_text_add(svg, "<path d=\"M%.1f %.1fh8v8h-8z\"", x - 4, y - 4);
        break;
    case 't':
        psplat_text_add(svg, "<path d=\"M%.1f %.1fl5 8.6h-10z\"", x, y - 5.5);
        break;
    case 'd':
        psplat_text_add(svg, "<path d=\"M%.1f %.1fl5 5l-5 5l-5 -5z\"", x, y - 5);
        break;
    default:
        psplat_text_add(svg, "<path d=\"M%.1f %.1fl6 6m0 -6l-6 6\"", x - 3, y - 3);
    }
}

void psplat_mark_end(psplat_text *svg, char mark) {
    psplat_text_add(svg, mark == 'c' ? "</circle>\n" : "</path>\n");
}

void psplat_mark_group(psplat_text *svg, const psplat_look *l) {
    psplat_text_add(svg, "<g stroke=\"%s\" fill=\"%s\" stroke-width=\"1.6\">\n", l->color,
                    l->mark == 'x' ? "none"
                    : l->is_hollow ? "#fff"
                                   : l->color);
}

static void add_values(const psplat_plot *p, const psplat_row *row) {
    psplat_text *svg = p->svg, name = {0};
    psplat_setting_describe(&row->setting, &name);
    if (name.data) psplat_text_escaped(svg, name.data);
    svg->failed |= name.failed;
    free(name.data);
    psplat_text_add(svg, "\n");
    psplat_text_escaped(svg, p->chart->x_label);
    psplat_text_add(svg, ": ");
    psplat_text_figure(svg, row->values[p->chart->x]);
    psplat_text_add(svg, "\n");
    psplat_text_escaped(svg, p->chart->y_label);
    psplat_text_add(svg, ": ");
    psplat_text_figure(svg, row->values[p->chart->y]);
}

void psplat_mark_draw(const psplat_plot *p, const psplat_row *row) {
    char mark = psplat_mark_look(&row->setting).mark;
    psplat_mark_begin(p->svg, mark, psplat_plot_x(p, row->values[p->chart->x]),
                      psplat_plot_y(p, row->values[p->chart->y]));
    psplat_text_add(p->svg, "><title>");
    add_values(p, row);
    psplat_text_add(p->svg, "</title>");
    psplat_mark_end(p->svg, mark);
}
