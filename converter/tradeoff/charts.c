/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * charts.c - a script that draws two columns of the table each as a scatter chart on logarithmic
 * axes. Only what depends on the rows is worked out here: ranges, ticks and fronts.
 *
 * Colours are those of Okabe and Ito (2008), which colour-blind people tell apart; marks differ
 * like colours, so that neither is needed to tell the other.
 */
#define _XOPEN_SOURCE 700

#include "tradeoff/charts.h"

#include "benchmark/subprocess.h"
#include "table/folder.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_table.h"
#include "table/text.h"
#include "tradeoff/pareto.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *const psplat_chart_files[] = {"error-bytes.svg", "error-splats.svg", "error-ms.svg",
                                          "distance-bytes.svg", "normal-bytes.svg"};

typedef struct chart {
    const char *title, *x_label, *y_label;
    psplat_column x, y;
    int by_asset;      /* 1: it does not depend on how splats are drawn, and has a point an asset */
    const char *place; /* of labels beside the points of what convert writes, drawn as phong */
} chart;

/* gnuplot draws into files with this prefix first, for it may be killed. */
#define DRAFT ".phongsplat-"

static const char preamble[] =
    "# phongsplat tradeoff writes this file anew each time; copy it to change it.\n"
    "# It draws the charts of tradeoff.csv, in the same directory: gnuplot charts.gp\n"
    "if (!exists('prefix')) prefix = ''\n"
    "set datafile separator comma\n"
    "set datafile columnheaders\n"
    "set datafile missing NaN\n"
    "set encoding utf8\n"
    "set terminal svg size 880,500 font 'sans-serif,12' background '#ffffff' noenhanced\n"
    "set logscale xy\n"
    "set title font ',15'\n"
    "set border 3 lc rgb '#888888'\n"
    "set grid lt 1 lc rgb '#e4e4e4'\n"
    "set tics nomirror out textcolor rgb '#333333'\n"
    "set errorbars 0\n"
    "set lmargin at screen 0.085\n"
    "set rmargin at screen 0.72\n"
    "set key at screen 0.735,0.9 left top Left reverse samplen 3 spacing 1.4 noautotitle\n"
    "mode(i) = word('phong gaussian flat', i)\n"
    "color(i) = word('#0072b2 #d55e00 #009e73', i)\n"
    "pale(i) = '#b0'.substr(color(i), 2, 7)\n"
    "filled(i) = 3 + 2 * word('2 1 3', i)\n"
    "hollow(i) = filled(i) - 1\n"
    "\n"
    "# Values of a column in the rows of some splats, or of gltfpack; there are none in others.\n"
    "is_splats(i, f) = strcol('kind') eq 'splats' && strcol('mode') eq mode(i) && \\\n"
    "    strcol('form') eq f\n"
    "splats(c, i, f) = is_splats(i, f) ? column(c) : NaN\n"
    "gltfpack(c) = strcol('kind') eq 'gltfpack' ? column(c) : NaN\n"
    "\n"
    "# Parts of plots of a column yname against a column xname, by the first modes.\n"
    "table = 'tradeoff.csv'\n"
    "front = \"$front using 1:2 with lines lw 12 lc rgb '#f7efa0' title 'Pareto front'\"\n"
    "spread = \"for [i=1:modes] for [f in 'usual float planar'] \\\n"
    "    table using (splats(xname, i, f)):(column(yname)): \\\n"
    "    (column(xname.'_q1')):(column(xname.'_q3')) with xerrorbars pt 0 lc rgb pale(i)\"\n"
    "usual = \"for [i=1:modes] table using (splats(xname, i, 'usual')):(column(yname)) \\\n"
    "    with linespoints pt filled(i) ps 0.8 lw 1.4 lc rgb color(i) \\\n"
    "    title (modes > 1 ? 'convert, '.mode(i) : 'convert')\"\n"
    "floats = \"table using (splats(xname, 1, 'float')):(column(yname)) \\\n"
    "    with linespoints dt 2 pt hollow(1) ps 0.8 lw 1.4 lc rgb color(1) title 'floats'\"\n"
    "planar = \"table using (splats(xname, 1, 'planar')):(column(yname)) \\\n"
    "    with linespoints dt 4 pt hollow(2) ps 0.8 lw 1.4 lc rgb color(1) title 'planar splats'\"\n"
    "simplified = \"table using (gltfpack(xname)):(column(yname)) \\\n"
    "    with linespoints pt 13 ps 0.9 lw 1.4 lc rgb '#444444' title 'gltfpack'\"\n"
    "tolerances = \"table using (splats(xname, 1, 'usual')):(column(yname)): \\\n"
    "    (sprintf('%g %%', column('tolerance_percent'))) \\\n"
    "    with labels @place font ',11' textcolor rgb color(1)\"\n"
    "ratios = \"table using (gltfpack(xname)):(column(yname)): \\\n"
    "    (sprintf('-si %g', column('ratio'))) \\\n"
    "    with labels left offset 0.8,0.5 font ',11' textcolor rgb '#444444'\"\n";

/* ---- what is shown ------------------------------------------------------------------------ */

/* Logarithms need positive values, and gnuplot needs for ever where an axis has hundreds of
 * decades.
 */
static int has_place(double value) {
    return value > 1e-15 && value < 1e15;
}

static int is_shown(const chart *c, const psplat_row *row) {
    const psplat_setting *s = &row->setting;
    double x = row->values[c->x], y = row->values[c->y];
    if (s->competitor == PSPLAT_COMPETITOR_MESH) return 0;
    if (c->by_asset && (s->mode != PSPLAT_MODE_PHONG)) return 0;
    return has_place(x) && has_place(y);
}

static int is_time(const chart *c) {
    return c->x >= PSPLAT_COLUMN_FRAMES;
}

/* A range holds the values from low to high, and is empty where low is more. */
typedef struct range {
    double low, high;
} range;

static void extend(range *r, double value) {
    r->low = fmin(r->low, value);
    r->high = fmax(r->high, value);
}

/* Leaves room beside the points, and makes every axis long enough to have ticks. */
static range widen(range r) {
    if (r.low > r.high) r = (range){1, 1};
    double middle = 0.5 * (log(r.low) + log(r.high));
    double half = 0.56 * fmax(log(r.high) - log(r.low), log(2));
    return (range){exp(middle - half), exp(middle + half)};
}

/* A chart is as high as its splats and a little more: simplified meshes within a factor of them are
 * shown, and others are beyond the frame. */
static void fit(const chart *c, const psplat_sweep_table *table, range *x, range *y) {
    const double beyond = 4;
    range near = {INFINITY, 0};
    *x = *y = near;
    for (size_t i = 0; i < table->count; ++i)
        if (table->rows[i].setting.competitor == PSPLAT_COMPETITOR_SPLATS &&
            is_shown(c, &table->rows[i]))
            extend(&near, table->rows[i].values[c->y]);
    for (size_t i = 0; i < table->count; ++i) {
        const double *values = table->rows[i].values;
        int is_near = values[c->y] > near.low / beyond && values[c->y] < near.high * beyond;
        if (!is_shown(c, &table->rows[i]) || (!is_near && near.high > 0)) continue;
        extend(x, values[c->x]);
        extend(y, values[c->y]);
    }
    double source = table->count ? table->rows[0].values[c->x] : NAN;
    if (is_time(c) && has_place(source)) extend(x, source);
    *x = widen(*x);
    *y = widen(*y);
}

/* ---- axes --------------------------------------------------------------------------------- */

static void add_tick(double value, int is_bytes, psplat_text *script) {
    double unit = !is_bytes || value < 1e3 ? 1 : value < 1e6 ? 1e3 : 1e6;
    const char *name = !is_bytes ? "" : unit < 1e3 ? " B" : unit < 1e6 ? " kB" : " MB";
    psplat_text_add(script, "'");
    if (value / unit >= 1000)
        psplat_text_figure(script, value / unit);
    else
        psplat_text_add(script, "%.6g", value / unit);
    psplat_text_add(script, "%s' %.15g", name, value);
}

/* Ticks are at such multiples of powers of ten that there are some, but not too many. */
static void add_axis(char axis, const range *r, int is_bytes, psplat_text *script) {
    static const double all[] = {1, 1.5, 2, 3, 4, 5, 6, 8}, few[] = {1, 2, 5};
    double ratio = r->high / r->low;
    const double *steps = ratio > 10 ? few : all;
    size_t count = ratio > 1e4 ? 1 : ratio > 10 ? 3 : 8;
    const char *comma = "";
    psplat_text_add(script, "set %crange [%.6g:%.6g]\nset %ctics (", axis, r->low, r->high, axis);
    for (double decade = floor(log10(r->low)); decade <= log10(r->high); ++decade)
        for (size_t i = 0; i < count; ++i) {
            double value = steps[i] * pow(10, decade);
            if (value < r->low || value > r->high) continue;
            psplat_text_add(script, "%s", comma);
            add_tick(value, is_bytes, script);
            comma = ", ";
        }
    psplat_text_add(script, ")\n");
}

static void add_label(const char *what, const char *first, const char *second,
                      psplat_text *script) {
    psplat_text text = {0};
    psplat_text_add(&text, "%s%s", first, second);
    psplat_text_add(script, "set %s ", what);
    psplat_text_enclosed(script, text.data ? text.data : "", '\'');
    psplat_text_add(script, "\n");
    script->failed |= text.failed;
    free(text.data);
}

/* ---- points ------------------------------------------------------------------------------- */

/* Adds the Pareto front as a block of data. */
static void add_front(const chart *c, const psplat_sweep_table *table, psplat_text *script) {
    const psplat_column columns[] = {c->x, c->y};
    const psplat_row *rows = table->rows;
    uint8_t *is_front = malloc(table->count + 1);
    size_t *order = malloc((table->count + 1) * sizeof *order), count = 0;
    psplat_text_add(script, "$front << END\nx,y\n");
    if (is_front && order) {
        psplat_pareto_mark(rows, table->count, PSPLAT_COMPETITOR_SPLATS, columns, 2, is_front);
        for (size_t i = 0; i < table->count; ++i)
            if (!is_shown(c, &rows[i])) is_front[i] = 0;
        count = psplat_pareto_sort(rows, table->count, is_front, c->x, order);
    } else {
        script->failed = 1;
    }
    for (size_t i = 0; i < count; ++i)
        psplat_text_add(script, "%.9g,%.9g\n", rows[order[i]].values[c->x],
                        rows[order[i]].values[c->y]);
    psplat_text_add(script, "END\n");
    free(is_front);
    free(order);
}

/* The cost of the source is a line across, for it has no error. */
static void add_source(const chart *c, const psplat_sweep_table *table, psplat_text *script) {
    double cost = table->count && is_time(c) ? table->rows[0].values[c->x] : NAN;
    if (!has_place(cost)) return;
    psplat_text_add(script,
                    "set arrow from %.6g, graph 0 to %.6g, graph 1 nohead dt 3 lc rgb '#444444'\n",
                    cost, cost);
}

static void add_plot(const chart *c, const psplat_sweep_table *table, psplat_text *script) {
    psplat_text_add(script, "modes = %d\nplace = '%s offset %s'\nplot @front, ",
                    c->by_asset ? 1 : PSPLAT_DRAWN_MODES, c->place,
                    strcmp(c->place, "right") ? "0.8,0.5" : "-0.7,-0.7");
    if (is_time(c)) psplat_text_add(script, "@spread, ");
    psplat_text_add(script, "@usual, @floats, @planar");
    if (*table->gltfpack) psplat_text_add(script, ", @simplified, @ratios");
    if (is_time(c))
        psplat_text_add(script, ", \\\n    keyentry with lines dt 3 lc rgb '#444444' title 'source "
                                "mesh', \\\n    keyentry with lines lc rgb '#b0666666' title 'half "
                                "of the frames'");
    psplat_text_add(script, ", @tolerances\nunset arrow\n");
}

static void add_chart(const chart *c, const char *file, const psplat_sweep_table *table,
                      psplat_text *script) {
    const char *slash = strrchr(table->source, '/');
    range x, y;
    fit(c, table, &x, &y);
    psplat_text_add(script, "\nset output prefix.'%s'\nxname = '%s'\nyname = '%s'\n", file,
                    psplat_row_value_names[c->x], psplat_row_value_names[c->y]);
    add_label("title", slash ? slash + 1 : table->source, c->title, script);
    add_label("xlabel", c->x_label, "", script);
    add_label("ylabel", c->y_label, "", script);
    add_axis('x', &x, c->x == PSPLAT_COLUMN_BYTES, script);
    add_axis('y', &y, 0, script);
    add_front(c, table, script);
    add_source(c, table, script);
    add_plot(c, table, script);
}

void psplat_charts_script(const psplat_sweep_table *table, psplat_text *script) {
    static const char image[] = "mean difference of pictures, % of white";
    psplat_column cost = psplat_rows_cost(table->rows, table->count);
    const chart charts[PSPLAT_CHARTS] = {
        {": picture error against file size", "size of the file", image, PSPLAT_COLUMN_BYTES,
         PSPLAT_COLUMN_DIFFERENCE, 0, "right"},
        {": picture error against splats", "splats (gltfpack: triangles)", image,
         PSPLAT_COLUMN_ELEMENTS, PSPLAT_COLUMN_DIFFERENCE, 0, "right"},
        {": picture error against drawing time",
         cost == PSPLAT_COLUMN_GPU_MS ? "GPU time of a frame, ms"
                                      : "CPU time of a frame, all threads, ms",
         image, cost, PSPLAT_COLUMN_DIFFERENCE, 0, "left"},
        {": distance against file size", "size of the file",
         "greatest distance, both ways, % of the diagonal", PSPLAT_COLUMN_BYTES,
         PSPLAT_COLUMN_DISTANCE_MAX, 1, "left"},
        {": normals against file size", "size of the file",
         "error of normals, root mean square, degrees", PSPLAT_COLUMN_BYTES,
         PSPLAT_COLUMN_NORMAL_RMS, 1, "right"}};
    psplat_text_add(script, "%s", preamble);
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i)
        add_chart(&charts[i], psplat_chart_files[i], table, script);
}

/* ---- running it --------------------------------------------------------------------------- */

/* Runs gnuplot in the folder; returns its exit code, and what it says first. */
static int run_gnuplot(const char *folder, char *line, size_t size, psplat_error *error) {
    psplat_text begin = {0};
    psplat_text_add(&begin, "cd ");
    psplat_text_enclosed(&begin, folder, '\'');
    psplat_text_add(&begin, "; prefix = '" DRAFT "'");
    psplat_result result = psplat_text_check(&begin, error);
    const char *const arguments[] = {"gnuplot", "-d", "-e", begin.data, "charts.gp", NULL};
    int code = result ? -1 : psplat_subprocess_run(arguments, line, size);
    free(begin.data);
    return code;
}

/* Gives what was drawn its name, or removes what an earlier sweep has left. */
static psplat_result place(const char *folder, const char *file, int is_drawn,
                           psplat_error *error) {
    psplat_text draft_name = {0};
    psplat_text_add(&draft_name, DRAFT "%s", file);
    char *draft = draft_name.failed ? NULL : psplat_folder_path(folder, draft_name.data);
    char *path = psplat_folder_path(folder, file);
    psplat_result result = PSPLAT_OK;
    if (!draft || !path)
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    else if (!is_drawn || rename(draft, path)) {
        unlink(draft);
        unlink(path);
    }
    free(draft_name.data);
    free(draft);
    free(path);
    return result;
}

psplat_result psplat_charts_write(const psplat_sweep_table *table, const char *folder,
                                  char left_out[PSPLAT_CHARTS_CAUSE], psplat_error *error) {
    char line[100] = "";
    psplat_text script = {0};
    psplat_charts_script(table, &script);
    psplat_result result = psplat_text_check(&script, error);
    if (!result) result = psplat_folder_write(folder, "charts.gp", script.data, script.size, error);
    free(script.data);
    if (result) return result;
    int code = run_gnuplot(folder, line, sizeof line, error);
    *left_out = 0;
    if (code == -1)
        snprintf(left_out, PSPLAT_CHARTS_CAUSE, "gnuplot cannot be run; charts are left out");
    else if (code)
        snprintf(left_out, PSPLAT_CHARTS_CAUSE, "charts are left out: gnuplot: %s", line);
    for (size_t i = 0; i < PSPLAT_CHARTS && !result; ++i)
        result = place(folder, psplat_chart_files[i], !code, error);
    return result;
}
