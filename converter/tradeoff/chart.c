/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * chart.c - two columns of a journal as a scatter chart on logarithmic axes, as an SVG document.
 */
#include "plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The height of a chart is that of the splats and a little more: simplified meshes within this
 * factor of them are shown, and others are beyond the frame. */
static const double shown_beyond = 4;

/* The values of a column that the chart is to hold; values has room for all rows. */
static size_t collect_splats(const psplat_plot *p, psplat_column column, double *values) {
    size_t count = 0;
    for (size_t i = 0; i < p->journal->count; ++i) {
        const psplat_row *row = &p->journal->rows[i];
        if (row->setting.contender == PSPLAT_CONTENDER_SPLATS && psplat_plot_shows(p->chart, row))
            values[count++] = row->values[column];
    }
    return count;
}

static size_t collect_near(const psplat_plot *p, const psplat_axis *splats, double *values,
                           size_t count) {
    size_t splat_count = count;
    for (size_t i = 0; i < p->journal->count; ++i) {
        const psplat_row *row = &p->journal->rows[i];
        double y = row->values[p->chart->y];
        int is_near = y > splats->low / shown_beyond && y < splats->high * shown_beyond;
        if (row->setting.contender == PSPLAT_CONTENDER_GLTFPACK &&
            psplat_plot_shows(p->chart, row) && (is_near || !splat_count))
            values[count++] = y;
    }
    return count;
}

static int fit_axes(psplat_plot *p) {
    const psplat_journal *j = p->journal;
    double *values = malloc((2 * j->count + 1) * sizeof *values);
    if (!values) return 0;
    size_t count = collect_splats(p, p->chart->y, values);
    p->y = psplat_axis_fit(values, count);
    count = collect_near(p, &p->y, values, count);
    p->y = psplat_axis_fit(values, count);
    count = 0;
    for (size_t i = 0; i < j->count; ++i)
        if (psplat_plot_holds(p, &j->rows[i])) values[count++] = j->rows[i].values[p->chart->x];
    values[count++] = psplat_plot_reference(p);
    p->x = psplat_axis_fit(values, count);
    free(values);
    return 1;
}

static int find_front(psplat_plot *p) {
    const psplat_journal *j = p->journal;
    const psplat_column columns[] = {p->chart->x, p->chart->y};
    p->is_front = malloc(j->count + 1);
    p->order = malloc((j->count + 1) * sizeof *p->order);
    if (!p->is_front || !p->order) return 0;
    psplat_pareto_mark(j->rows, j->count, PSPLAT_CONTENDER_SPLATS, columns, 2, p->is_front);
    for (size_t i = 0; i < j->count; ++i)
        if (!psplat_plot_shows(p->chart, &j->rows[i])) p->is_front[i] = 0;
    p->front_count = psplat_pareto_sort(j->rows, j->count, p->is_front, p->chart->x, p->order);
    return 1;
}

static void draw_title(const psplat_plot *p) {
    const char *slash = strrchr(p->journal->source, '/');
    psplat_text_add(p->svg,
                    "<text x=\"%d\" y=\"28\" font-size=\"16\" font-weight=\"bold\" fill=\"#222\">",
                    PSPLAT_PLOT_LEFT);
    psplat_text_escaped(p->svg, slash ? slash + 1 : p->journal->source);
    psplat_text_add(p->svg, ": ");
    psplat_text_escaped(p->svg, p->chart->title);
    psplat_text_add(p->svg, "</text>\n");
}

void psplat_chart_write(const psplat_chart *chart, const psplat_journal *journal,
                        psplat_text *text) {
    psplat_plot p = {.chart = chart, .journal = journal, .svg = text};
    psplat_text_add(text,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
                    "height=\"%d\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
                    "font-size=\"12\" fill=\"#333\">\n<rect width=\"%d\" height=\"%d\" "
                    "fill=\"#fff\"/>\n",
                    PSPLAT_PLOT_WIDTH, PSPLAT_PLOT_HEIGHT, PSPLAT_PLOT_WIDTH, PSPLAT_PLOT_HEIGHT,
                    PSPLAT_PLOT_WIDTH, PSPLAT_PLOT_HEIGHT);
    if (fit_axes(&p) && find_front(&p)) {
        draw_title(&p);
        psplat_plot_axes(&p);
        psplat_series_front(&p);
        psplat_series_reference(&p);
        psplat_plot_frame(&p);
        psplat_series_draw(&p);
        psplat_legend_draw(&p);
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
