/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * chart.c - two columns of a journal as a scatter chart on logarithmic axes.
 *
 * Colour and mark stand for how splats are drawn, filled or hollow for their normals, so that
 * neither is needed to tell the other. Colours are those of Okabe and Ito (2008), which
 * colour-blind people tell apart. Nothing covers data: the legend is beside it.
 */
#include "tradeoff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 880, HEIGHT = 500, LEFT = 74, RIGHT = 656, TOP = 50, BOTTOM = 436, LEGEND = 680 };

/* Baselines relative to the middle of 12 pixel letters. */
static const double half_letter = 4;

/* How points of a kind look. */
typedef struct look {
    const char *color;
    char mark; /* circle, square, triangle, diamond, x */
    int is_hollow, has_line;
} look;

static const char *const mode_colors[] = {"#0072b2", "#d55e00", "#009e73"};
static const char mode_marks[] = {'c', 's', 't'};
static const char *const simplified_color = "#444444", *const neutral_color = "#666666",
                         *const front_color = "#f0e442";

typedef struct plot {
    const psplat_chart *chart;
    const psplat_journal *journal;
    psplat_axis x, y;
    uint8_t *is_front; /* journal->count */
    size_t *order;     /* of the front */
    size_t front_count;
    psplat_text *svg;
} plot;

static look look_of(const psplat_setting *s) {
    if (s->contender == PSPLAT_CONTENDER_GLTFPACK) return (look){simplified_color, 'd', 0, 1};
    if (s->no_filter) return (look){mode_colors[s->mode], 'x', 0, 0};
    return (look){mode_colors[s->mode], mode_marks[s->mode], s->field == PSPLAT_FIELD_CONSTANT, 1};
}

/* The source itself is a line at its cost, for it has no error. */
static int is_shown(const psplat_chart *chart, const psplat_row *row) {
    const psplat_setting *s = &row->setting;
    if (s->contender == PSPLAT_CONTENDER_MESH) return 0;
    if (chart->by_asset && (s->mode != PSPLAT_MODE_PHONG || s->no_filter)) return 0;
    return isfinite(row->values[chart->x]) && isfinite(row->values[chart->y]);
}

static int is_time(psplat_column column) {
    return psplat_column_group(column) == PSPLAT_GROUP_TIMED;
}

/* The cost of the source; NaN where the chart shows none. */
static double reference(const plot *p) {
    const psplat_row *rows = p->journal->rows;
    for (size_t i = 0; i < p->journal->count && is_time(p->chart->x); ++i)
        if (rows[i].setting.contender == PSPLAT_CONTENDER_MESH) return rows[i].values[p->chart->x];
    return NAN;
}

static double place_x(const plot *p, double value) {
    return LEFT + psplat_axis_place(&p->x, value) * (RIGHT - LEFT);
}

static double place_y(const plot *p, double value) {
    return BOTTOM - psplat_axis_place(&p->y, value) * (BOTTOM - TOP);
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

static void draw_x_axis(const plot *p) {
    psplat_text *svg = p->svg;
    for (size_t i = 0; i < p->x.tick_count; ++i) {
        double x = place_x(p, p->x.ticks[i]);
        int is_labelled = p->x.labelled[i];
        if (is_labelled)
            psplat_text_add(svg, "<path stroke=\"#e4e4e4\" d=\"M%.1f %dV%d\"/>", x, TOP, BOTTOM);
        psplat_text_add(svg, "<path stroke=\"#888\" d=\"M%.1f %dv%d\"/>\n", x, BOTTOM,
                        is_labelled ? 6 : 3);
        if (!is_labelled) continue;
        psplat_text_add(svg, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">", x, BOTTOM + 21);
        add_tick_label(svg, p->chart->x, p->x.ticks[i]);
        psplat_text_add(svg, "</text>\n");
    }
    psplat_text_add(svg, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\" font-size=\"13\">",
                    (LEFT + RIGHT) / 2, BOTTOM + 48);
    psplat_text_escaped(svg, p->chart->x_label);
    psplat_text_add(svg, "</text>\n");
}

static void draw_y_axis(const plot *p) {
    psplat_text *svg = p->svg;
    for (size_t i = 0; i < p->y.tick_count; ++i) {
        double y = place_y(p, p->y.ticks[i]);
        int is_labelled = p->y.labelled[i];
        if (is_labelled)
            psplat_text_add(svg, "<path stroke=\"#e4e4e4\" d=\"M%d %.1fH%d\"/>", LEFT, y, RIGHT);
        psplat_text_add(svg, "<path stroke=\"#888\" d=\"M%d %.1fh%d\"/>\n", LEFT, y,
                        is_labelled ? -6 : -3);
        if (!is_labelled) continue;
        psplat_text_add(svg, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">", LEFT - 10,
                        y + half_letter);
        add_tick_label(svg, p->chart->y, p->y.ticks[i]);
        psplat_text_add(svg, "</text>\n");
    }
    psplat_text_add(svg,
                    "<text transform=\"translate(20 %d) rotate(-90)\" text-anchor=\"middle\" "
                    "font-size=\"13\">",
                    (TOP + BOTTOM) / 2);
    psplat_text_escaped(svg, p->chart->y_label);
    psplat_text_add(svg, "</text>\n");
}

static void draw_frame(const plot *p) {
    psplat_text_add(p->svg, "<path fill=\"none\" stroke=\"#888\" d=\"M%d %dV%dH%d\"/>\n", LEFT, TOP,
                    BOTTOM, RIGHT);
}

/* ---- marks -------------------------------------------------------------------------------- */

/* Without its end, for a title may follow. */
static void begin_mark(psplat_text *svg, char mark, double x, double y) {
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

static void end_mark(psplat_text *svg, char mark) {
    psplat_text_add(svg, mark == 'c' ? "</circle>\n" : "</path>\n");
}

static void begin_group(psplat_text *svg, const look *l) {
    psplat_text_add(svg, "<g stroke=\"%s\" fill=\"%s\" stroke-width=\"1.6\">\n", l->color,
                    l->mark == 'x' ? "none"
                    : l->is_hollow ? "#fff"
                                   : l->color);
}

static void add_values(const plot *p, const psplat_row *row) {
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

static void draw_mark(const plot *p, const psplat_row *row) {
    char mark = look_of(&row->setting).mark;
    begin_mark(p->svg, mark, place_x(p, row->values[p->chart->x]),
               place_y(p, row->values[p->chart->y]));
    psplat_text_add(p->svg, "><title>");
    add_values(p, row);
    psplat_text_add(p->svg, "</title>");
    end_mark(p->svg, mark);
}

/* ---- series ------------------------------------------------------------------------------- */

/* Rows that differ in tolerance or ratio alone, in the order of the journal. */
static int is_of_series(const plot *p, const psplat_row *row, const psplat_setting *first) {
    const psplat_setting *s = &row->setting;
    return is_shown(p->chart, row) && s->contender == first->contender &&
           s->field == first->field && s->precision == first->precision && s->mode == first->mode &&
           s->no_filter == first->no_filter;
}

static int begins_series(const plot *p, size_t row) {
    const psplat_row *rows = p->journal->rows;
    if (!is_shown(p->chart, &rows[row])) return 0;
    for (size_t i = 0; i < row; ++i)
        if (is_of_series(p, &rows[i], &rows[row].setting)) return 0;
    return 1;
}

static void draw_series_line(const plot *p, const psplat_setting *first) {
    const psplat_journal *j = p->journal;
    const look l = look_of(first);
    char command = 'M';
    if (!l.has_line) return;
    psplat_text_add(p->svg, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\"%s d=\"",
                    l.color, l.is_hollow ? " stroke-dasharray=\"5 3\"" : "");
    for (size_t i = 0; i < j->count; ++i) {
        if (!is_of_series(p, &j->rows[i], first)) continue;
        psplat_text_add(p->svg, "%c%.1f %.1f", command, place_x(p, j->rows[i].values[p->chart->x]),
                        place_y(p, j->rows[i].values[p->chart->y]));
        command = 'L';
    }
    psplat_text_add(p->svg, "\"/>\n");
}

/* Half of all frames took a time within the bar. */
static void draw_spread(const plot *p, const psplat_row *row) {
    double low = row->values[p->chart->x + 1], high = row->values[p->chart->x + 2];
    if (!isfinite(low) || !isfinite(high)) return;
    psplat_text_add(p->svg, "<path stroke=\"%s\" stroke-opacity=\"0.35\" d=\"M%.1f %.1fH%.1f\"/>\n",
                    look_of(&row->setting).color, place_x(p, low),
                    place_y(p, row->values[p->chart->y]), place_x(p, high));
}

static void draw_spreads(const plot *p) {
    for (size_t i = 0; i < p->journal->count && is_time(p->chart->x); ++i)
        if (is_shown(p->chart, &p->journal->rows[i])) draw_spread(p, &p->journal->rows[i]);
}

/* Tolerances beside the series that the defaults draw, ratios beside gltfpack's: where neighbours
 * are fewest, and within the frame. */
static void draw_label(const plot *p, const psplat_row *row) {
    const psplat_setting *s = &row->setting;
    int is_simplified = s->contender == PSPLAT_CONTENDER_GLTFPACK;
    if (!is_simplified && (s->field || s->mode || s->no_filter)) return;
    double x = place_x(p, row->values[p->chart->x]), y = place_y(p, row->values[p->chart->y]);
    int is_right = (is_simplified || p->chart->by_asset) && x < RIGHT - 50;
    int is_above = is_simplified || is_right;
    psplat_text_add(p->svg,
                    "<text x=\"%.1f\" y=\"%.1f\" font-size=\"11\" text-anchor=\"%s\" "
                    "fill=\"%s\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">",
                    x + (is_right ? 8 : -8), y + (is_above ? -5 : 14), is_right ? "start" : "end",
                    look_of(s).color);
    psplat_text_add(p->svg, is_simplified ? "-si %.4g</text>\n" : "%.4g %%</text>\n",
                    is_simplified ? s->ratio : s->tolerance);
}

static void draw_series(const plot *p) {
    const psplat_journal *j = p->journal;
    for (size_t i = 0; i < j->count; ++i)
        if (begins_series(p, i)) draw_series_line(p, &j->rows[i].setting);
    draw_spreads(p);
    for (size_t i = 0; i < j->count; ++i) {
        if (!begins_series(p, i)) continue;
        const look l = look_of(&j->rows[i].setting);
        begin_group(p->svg, &l);
        for (size_t k = i; k < j->count; ++k)
            if (is_of_series(p, &j->rows[k], &j->rows[i].setting)) draw_mark(p, &j->rows[k]);
        psplat_text_add(p->svg, "</g>\n");
    }
    for (size_t i = 0; i < j->count; ++i)
        if (is_shown(p->chart, &j->rows[i])) draw_label(p, &j->rows[i]);
}

static void draw_front(const plot *p) {
    if (p->front_count < 2) return;
    psplat_text_add(p->svg,
                    "<path fill=\"none\" stroke=\"%s\" stroke-width=\"12\" stroke-opacity=\"0.6\" "
                    "stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"",
                    front_color);
    for (size_t i = 0; i < p->front_count; ++i) {
        const psplat_row *row = &p->journal->rows[p->order[i]];
        psplat_text_add(p->svg, "%c%.1f %.1f", i ? 'L' : 'M', place_x(p, row->values[p->chart->x]),
                        place_y(p, row->values[p->chart->y]));
    }
    psplat_text_add(p->svg, "\"/>\n");
}

static void draw_reference(const plot *p) {
    double value = reference(p);
    if (!isfinite(value)) return;
    psplat_text_add(p->svg,
                    "<path stroke=\"%s\" stroke-width=\"1.4\" stroke-dasharray=\"2 4\" "
                    "d=\"M%.1f %dV%d\"><title>source mesh: ",
                    simplified_color, place_x(p, value), TOP, BOTTOM);
    psplat_text_figure(p->svg, value);
    psplat_text_add(p->svg, " ms</title></path>\n");
}

/* ---- legend ------------------------------------------------------------------------------- */

static double add_entry(const plot *p, double y, const look *l, const char *name) {
    psplat_text *svg = p->svg;
    if (l->has_line)
        psplat_text_add(svg, "<path stroke=\"%s\" stroke-width=\"1.4\"%s d=\"M%d %.1fh28\"/>",
                        l->color, l->is_hollow ? " stroke-dasharray=\"5 3\"" : "", LEGEND, y);
    begin_group(svg, l);
    begin_mark(svg, l->mark, LEGEND + 14, y);
    psplat_text_add(svg, ">");
    end_mark(svg, l->mark);
    psplat_text_add(svg, "</g><text x=\"%d\" y=\"%.1f\">%s</text>\n", LEGEND + 38, y + half_letter,
                    name);
    return y + 22;
}

static double add_line_entry(const plot *p, double y, const char *attributes, const char *name) {
    psplat_text_add(p->svg, "<path %s d=\"M%d %.1fh28\"/><text x=\"%d\" y=\"%.1f\">%s</text>\n",
                    attributes, LEGEND, y, LEGEND + 38, y + half_letter, name);
    return y + 22;
}

/* How many of the rows that are shown are of a contender, with or without filter. */
static size_t count_shown(const plot *p, psplat_contender contender, int no_filter) {
    size_t count = 0;
    for (size_t i = 0; i < p->journal->count; ++i) {
        const psplat_row *row = &p->journal->rows[i];
        count += is_shown(p->chart, row) && row->setting.contender == contender &&
                 row->setting.no_filter == no_filter;
    }
    return count;
}

static double draw_modes(const plot *p, double y) {
    static const char *const names[] = {"phong", "gaussian", "flat"};
    for (int mode = 0; mode < PSPLAT_DRAWN_MODES; ++mode) {
        const look l = {mode_colors[mode], mode_marks[mode], 0, 0};
        y = add_entry(p, y, &l, names[mode]);
    }
    return y + 10;
}

static void draw_legend(const plot *p) {
    const char *color = p->chart->by_asset ? mode_colors[0] : neutral_color;
    const look linear = {color, 'c', 0, 1}, constant = {color, 'c', 1, 1};
    const look unfiltered = {neutral_color, 'x', 0, 0}, simplified = {simplified_color, 'd', 0, 1};
    double y = TOP + 8;
    if (!p->chart->by_asset) y = draw_modes(p, y);
    y = add_entry(p, y, &linear, "linear normals");
    y = add_entry(p, y, &constant, "constant normals");
    if (count_shown(p, PSPLAT_CONTENDER_SPLATS, 1)) y = add_entry(p, y, &unfiltered, "no filter");
    y += 10;
    if (p->front_count > 1)
        y = add_line_entry(p, y,
                           "stroke=\"#f0e442\" stroke-width=\"12\" stroke-opacity=\"0.6\" "
                           "stroke-linecap=\"round\"",
                           "Pareto front");
    if (count_shown(p, PSPLAT_CONTENDER_GLTFPACK, 0)) y = add_entry(p, y, &simplified, "gltfpack");
    if (isfinite(reference(p)))
        y = add_line_entry(p, y, "stroke=\"#444444\" stroke-width=\"1.4\" stroke-dasharray=\"2 4\"",
                           "source mesh");
    if (!is_time(p->chart->x)) return;
    add_line_entry(p, y, "stroke=\"#666666\" stroke-opacity=\"0.5\"", "half of the frames");
}

/* ---- document ----------------------------------------------------------------------------- */

static int fit_axes(plot *p) {
    const psplat_journal *j = p->journal;
    double *values = malloc((2 * j->count + 1) * sizeof *values);
    size_t count = 0;
    if (!values) return 0;
    for (size_t i = 0; i < j->count; ++i)
        if (is_shown(p->chart, &j->rows[i])) values[count++] = j->rows[i].values[p->chart->y];
    p->y = psplat_axis_fit(values, count);
    count = 0;
    for (size_t i = 0; i < j->count; ++i)
        if (is_shown(p->chart, &j->rows[i])) values[count++] = j->rows[i].values[p->chart->x];
    values[count++] = reference(p);
    p->x = psplat_axis_fit(values, count);
    free(values);
    return 1;
}

static int find_front(plot *p) {
    const psplat_journal *j = p->journal;
    const psplat_column columns[] = {p->chart->x, p->chart->y};
    p->is_front = malloc(j->count + 1);
    p->order = malloc((j->count + 1) * sizeof *p->order);
    if (!p->is_front || !p->order) return 0;
    psplat_pareto_mark(j->rows, j->count, PSPLAT_CONTENDER_SPLATS, columns, 2, p->is_front);
    for (size_t i = 0; i < j->count; ++i)
        if (!is_shown(p->chart, &j->rows[i])) p->is_front[i] = 0;
    p->front_count = psplat_pareto_sort(j->rows, j->count, p->is_front, p->chart->x, p->order);
    return 1;
}

static void draw_title(const plot *p) {
    const char *slash = strrchr(p->journal->source, '/');
    psplat_text_add(p->svg,
                    "<text x=\"%d\" y=\"28\" font-size=\"16\" font-weight=\"bold\" fill=\"#222\">",
                    LEFT);
    psplat_text_escaped(p->svg, slash ? slash + 1 : p->journal->source);
    psplat_text_add(p->svg, ": ");
    psplat_text_escaped(p->svg, p->chart->title);
    psplat_text_add(p->svg, "</text>\n");
}

void psplat_chart_write(const psplat_chart *chart, const psplat_journal *journal,
                        psplat_text *text) {
    plot p = {.chart = chart, .journal = journal, .svg = text};
    psplat_text_add(text,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
                    "height=\"%d\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
                    "font-size=\"12\" fill=\"#333\">\n<rect width=\"%d\" height=\"%d\" "
                    "fill=\"#fff\"/>\n",
                    WIDTH, HEIGHT, WIDTH, HEIGHT, WIDTH, HEIGHT);
    if (fit_axes(&p) && find_front(&p)) {
        draw_title(&p);
        draw_x_axis(&p);
        draw_y_axis(&p);
        draw_front(&p);
        draw_reference(&p);
        draw_frame(&p);
        draw_series(&p);
        draw_legend(&p);
    } else {
        text->failed = 1;
    }
    psplat_text_add(text, "</svg>\n");
    free(p.is_front);
    free(p.order);
}

size_t psplat_chart_list(psplat_column cost, psplat_chart charts[PSPLAT_CHARTS]) {
    static const char *const image = "mean difference of pictures, % of white";
    const char *time = cost == PSPLAT_COLUMN_GPU_MS ? "GPU time of a frame, ms"
                                                    : "CPU time of a frame, all threads, ms";
    const psplat_chart all[PSPLAT_CHARTS] = {
        {"error-bytes.svg", "picture error against file size", "size of the file", image,
         PSPLAT_COLUMN_BYTES, PSPLAT_COLUMN_DIFFERENCE, 0},
        {"error-splats.svg", "picture error against splats", "splats (gltfpack: triangles)", image,
         PSPLAT_COLUMN_ELEMENTS, PSPLAT_COLUMN_DIFFERENCE, 0},
        {"error-ms.svg", "picture error against drawing time", time, image, cost,
         PSPLAT_COLUMN_DIFFERENCE, 0},
        {"distance-bytes.svg", "distance against file size", "size of the file",
         "greatest distance, both ways, % of the diagonal", PSPLAT_COLUMN_BYTES,
         PSPLAT_COLUMN_DISTANCE_MAX, 1},
        {"normal-bytes.svg", "normals against file size", "size of the file",
         "error of normals, root mean square, degrees", PSPLAT_COLUMN_BYTES,
         PSPLAT_COLUMN_NORMAL_RMS, 1},
    };
    memcpy(charts, all, sizeof all);
    return PSPLAT_CHARTS;
}
