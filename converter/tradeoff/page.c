/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * page.c - the sweep as one HTML file for reading, with no script and nothing to fetch.
 */
#include "tradeoff/page.h"

#include "table/folder.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"
#include "tradeoff/advice.h"
#include "tradeoff/charts.h"
#include "tradeoff/pareto.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A column of a table as the page shows it. */
typedef struct shown {
    psplat_column column;
    const char *name, *unit;
} shown;

static const shown asset_columns[] = {
    {PSPLAT_COLUMN_BYTES, "size", "bytes"},
    {PSPLAT_COLUMN_ELEMENTS, "splats or triangles", ""},
    {PSPLAT_COLUMN_CONVERT_S, "made in", "s"},
    {PSPLAT_COLUMN_LOAD_MS, "loaded in", "ms"},
    {PSPLAT_COLUMN_BROKEN, "promises broken", ""},
    {PSPLAT_COLUMN_DISTANCE_MAX, "distance, max", "%"},
    {PSPLAT_COLUMN_DISTANCE_RMS, "RMS", "%"},
    {PSPLAT_COLUMN_DISTANCE_P95, "95 %", "%"},
    {PSPLAT_COLUMN_NORMAL_RMS, "normals, RMS", "°"},
    {PSPLAT_COLUMN_NORMAL_P95, "95 %", "°"},
    {PSPLAT_COLUMN_FACE_NORMAL_RMS, "on faces, RMS", "°"},
    {PSPLAT_COLUMN_CREASE_NORMAL_RMS, "at creases, RMS", "°"},
    {PSPLAT_COLUMN_UNCOVERED_AREA, "uncovered", "%"},
    {PSPLAT_COLUMN_OVERHANG_AREA, "overhang", "%"},
};

static const shown drawn_columns[] = {
    {PSPLAT_COLUMN_BYTES, "size", "bytes"},       {PSPLAT_COLUMN_DIFFERENCE, "difference", "%"},
    {PSPLAT_COLUMN_INSIDE, "inside", "%"},        {PSPLAT_COLUMN_DISTANT, "from afar", "%"},
    {PSPLAT_COLUMN_PSNR, "PSNR", "dB"},           {PSPLAT_COLUMN_SSIM, "SSIM", ""},
    {PSPLAT_COLUMN_MISSING, "missing", "%"},      {PSPLAT_COLUMN_EXTRA, "extra", "%"},
    {PSPLAT_COLUMN_OUTLINE, "outline", "%"},      {PSPLAT_COLUMN_CPU_MS, "CPU", "ms"},
    {PSPLAT_COLUMN_CPU_MS_Q1, "quartiles", "ms"}, {PSPLAT_COLUMN_CPU_MS_Q3, "", "ms"},
    {PSPLAT_COLUMN_WALL_MS, "wall", "ms"},        {PSPLAT_COLUMN_WALL_MS_Q1, "quartiles", "ms"},
    {PSPLAT_COLUMN_WALL_MS_Q3, "", "ms"},         {PSPLAT_COLUMN_GPU_MS, "GPU", "ms"},
    {PSPLAT_COLUMN_GPU_MS_Q1, "quartiles", "ms"}, {PSPLAT_COLUMN_GPU_MS_Q3, "", "ms"},
};

enum {
    ASSET_COLUMNS = sizeof asset_columns / sizeof *asset_columns,
    DRAWN_COLUMNS = sizeof drawn_columns / sizeof *drawn_columns
};

static const char style[] =
    "body{font:15px/1.5 system-ui,Helvetica,Arial,sans-serif;color:#222;background:#fff;"
    "max-width:64em;margin:2em auto;padding:0 1em}"
    "h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em}"
    "figure{margin:1.5em 0}svg{max-width:100%;height:auto}"
    "div.wide{overflow-x:auto}"
    "table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}"
    "th,td{padding:2px 9px;text-align:right;white-space:nowrap;border-bottom:1px solid #e4e4e4}"
    "th{vertical-align:bottom;font-weight:600}th small{font-weight:400;color:#666}"
    "th:first-child,td:first-child{text-align:left}"
    "tr.front td{background:#fcfadf}tr.other td{color:#555}"
    "dt{font-weight:600;margin-top:.6em}dd{margin-left:1.5em}"
    "div.pictures{display:flex;flex-wrap:wrap;gap:1em}div.pictures figure{margin:0}"
    "div.pictures img{width:19em;height:19em}figcaption{text-align:center;color:#555}"
    "code{font-size:.95em;background:#f4f4f4;padding:0 .25em}";

static const char definitions[] =
    "<dl>\n"
    "<dt>distance</dt><dd>between points of the source and the nearest point of what stands for "
    "it, and the reverse, in % of the diagonal of the source's bounding box. The maximum is that "
    "of both ways, on random points.</dd>\n"
    "<dt>normals</dt><dd>angle between the source's normal and the normal blended from all splats "
    "that cover the point.</dd>\n"
    "<dt>uncovered, overhang</dt><dd>share of the source's area that nothing stands for, and of "
    "the splats' area that is far from the source.</dd>\n"
    "<dt>difference</dt><dd>mean absolute difference between pictures of the source and of what "
    "stands for it, from 12 sides, in % of white, over the pixels that either covers; inside: "
    "that both cover.</dd>\n"
    "<dt>missing, extra</dt><dd>pixels that only the source covers, and that it does not, in % of "
    "those that it covers; outline: both together.</dd>\n"
    "<dt>made in, loaded in</dt><dd>seconds of the conversion; milliseconds of opening the file "
    "and uploading it, a median.</dd>\n"
    "<dt>CPU, wall, GPU</dt><dd>milliseconds of a frame: medians and quartiles of frames that all "
    "settings drew in turn, the 12 views one after the other. CPU time is that of all threads. "
    "GPU time is left empty where GL is drawn in software.</dd>\n"
    "<dt>front</dt><dd>Highlighted settings are those that no other beats: none is at most as "
    "large and at most as different, and better in one of both.</dd>\n"
    "</dl>\n";

static const char about_gltfpack[] =
    "<p>gltfpack's rows are simplified meshes of the same source. Their size is that of the "
    "compressed file (<code>-cc -sv</code>); all else was measured on the same triangles written "
    "without compression and quantisation (<code>-noq</code>), for this version cannot read "
    "EXT_meshopt_compression. Sources without normals, or in a format that it does not read, are "
    "handed over with the normals that the conversion to splats starts from, and without colours. "
    "They are drawn as the source is, lit per pixel.</p>\n";

static void add_setting(const psplat_setting *setting, psplat_text *html) {
    psplat_text name = {0};
    psplat_setting_describe(setting, &name);
    if (name.data) psplat_text_escaped(html, name.data);
    html->failed |= name.failed;
    free(name.data);
}

/* Columns that no row has are left out. */
static int is_used(const psplat_sweep_table *table, psplat_column column) {
    for (size_t i = 0; i < table->count; ++i)
        if (!isnan(table->rows[i].values[column])) return 1;
    return 0;
}

static void add_head(const psplat_sweep_table *table, const char *first, const shown *columns,
                     size_t count, psplat_text *html) {
    psplat_text_add(html, "<div class=\"wide\"><table>\n<thead><tr><th>%s</th>", first);
    for (size_t i = 0; i < count; ++i)
        if (is_used(table, columns[i].column))
            psplat_text_add(html, "<th>%s<br><small>%s</small></th>", columns[i].name,
                            columns[i].unit);
    psplat_text_add(html, "</tr></thead>\n<tbody>\n");
}

/* Adds the values of a row, and ends it. */
static void add_cells(const psplat_sweep_table *table, const psplat_row *row, const shown *columns,
                      size_t count, psplat_text *html) {
    for (size_t i = 0; i < count; ++i) {
        if (!is_used(table, columns[i].column)) continue;
        psplat_text_add(html, "<td>");
        psplat_text_figure(html, row->values[columns[i].column]);
        psplat_text_add(html, "</td>");
    }
    psplat_text_add(html, "</tr>\n");
}

static void add_row(const psplat_sweep_table *table, size_t row, const char *kind,
                    const shown *columns, size_t count, psplat_text *html) {
    const psplat_row *r = &table->rows[row];
    psplat_text_add(html, "<tr%s><td>", kind);
    add_setting(&r->setting, html);
    psplat_text_add(html, "</td>");
    add_cells(table, r, columns, count, html);
}

static const char *kind_of(const psplat_sweep_table *table, size_t row, const uint8_t *is_front) {
    if (is_front[row]) return " class=\"front\"";
    int is_splats = table->rows[row].setting.competitor == PSPLAT_COMPETITOR_SPLATS;
    return is_splats ? "" : " class=\"other\"";
}

static void add_drawn_table(const psplat_sweep_table *table, const uint8_t *is_front,
                            psplat_text *html) {
    add_head(table, "setting", drawn_columns, DRAWN_COLUMNS, html);
    for (size_t i = 0; i < table->count; ++i)
        add_row(table, i, kind_of(table, i, is_front), drawn_columns, DRAWN_COLUMNS, html);
    psplat_text_add(html, "</tbody></table></div>\n");
}

static void add_asset_name(const psplat_setting *setting, psplat_text *html) {
    psplat_setting_file(setting, html);
    if (setting->competitor == PSPLAT_COMPETITOR_MESH) psplat_text_add(html, "source mesh");
}

/* A file gets one line, of the first row that draws it. */
static void add_asset_table(const psplat_sweep_table *table, psplat_text *html) {
    const psplat_row *rows = table->rows;
    add_head(table, "file", asset_columns, ASSET_COLUMNS, html);
    for (size_t i = 0; i < table->count; ++i) {
        if (i && psplat_setting_shares_asset(&rows[i].setting, &rows[i - 1].setting)) continue;
        psplat_text_add(html, "<tr><td>");
        add_asset_name(&rows[i].setting, html);
        psplat_text_add(html, "</td>");
        add_cells(table, &rows[i], asset_columns, ASSET_COLUMNS, html);
    }
    psplat_text_add(html, "</tbody></table></div>\n");
}

/* The front is shown in a few columns, cheapest first. */
static void add_front(const psplat_sweep_table *table, const size_t *order, size_t count,
                      psplat_column cost, psplat_text *html) {
    const shown columns[] = {
        {PSPLAT_COLUMN_BYTES, "size", "bytes"},
        {PSPLAT_COLUMN_ELEMENTS, "splats", ""},
        {PSPLAT_COLUMN_DISTANCE_MAX, "distance, max", "%"},
        {PSPLAT_COLUMN_NORMAL_RMS, "normals, RMS", "°"},
        {PSPLAT_COLUMN_DIFFERENCE, "difference", "%"},
        {PSPLAT_COLUMN_OUTLINE, "outline", "%"},
        {cost, cost == PSPLAT_COLUMN_GPU_MS ? "GPU" : "CPU", "ms a frame"},
    };
    const size_t column_count = sizeof columns / sizeof *columns;
    size_t knee = psplat_pareto_knee(table->rows, order, count, PSPLAT_COLUMN_BYTES,
                                     PSPLAT_COLUMN_DIFFERENCE);
    psplat_text_add(html,
                    "<h2>What to choose</h2>\n<p>The settings that no other beats in size "
                    "and in how the model looks, each drawn in the way that does most for it. "
                    "Highlighted: the knee, up to which bytes "
                    "buy most.</p>\n");
    add_head(table, "setting", columns, column_count, html);
    for (size_t i = 0; i < count; ++i)
        add_row(table, order[i], i == knee ? " class=\"front\"" : "", columns, column_count, html);
    psplat_text_add(html, "</tbody></table></div>\n");
    if (!count) return;
    psplat_text command = {0};
    psplat_setting_command(&table->rows[order[knee]].setting, &table->options, table->source,
                           &command);
    psplat_text_add(html, "<p><code>");
    if (command.data) psplat_text_escaped(html, command.data);
    psplat_text_add(html, "</code></p>\n");
    html->failed |= command.failed;
    free(command.data);
}

static void add_base64(const uint8_t *data, size_t size, psplat_text *html) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = (uint32_t)data[i] << 16;
        if (i + 1 < size) bits |= (uint32_t)data[i + 1] << 8;
        if (i + 2 < size) bits |= data[i + 2];
        char group[5] = {digits[bits >> 18], digits[bits >> 12 & 63], digits[bits >> 6 & 63],
                         digits[bits & 63], 0};
        if (i + 2 >= size) group[3] = '=';
        if (i + 1 >= size) group[2] = '=';
        psplat_text_add(html, "%s", group);
    }
}

/* The picture is part of the page. An interrupted sweep may have left none. */
static void add_picture(const char *folder, const psplat_setting *setting, psplat_text *html) {
    psplat_text name = {0};
    char *png = NULL;
    size_t size = 0;
    psplat_setting_picture(setting, &name);
    html->failed |= name.failed;
    if (!name.failed && !psplat_folder_read(folder, name.data, &png, &size, NULL)) {
        psplat_text_add(html, "<figure><img alt=\"\" src=\"data:image/png;base64,");
        add_base64((const uint8_t *)png, size, html);
        psplat_text_add(html, "\"/><figcaption>");
        add_setting(setting, html);
        psplat_text_add(html, "</figcaption></figure>\n");
    }
    free(png);
    free(name.data);
}

/* The source, and what the front makes of it. */
static void add_pictures(const psplat_sweep_table *table, const char *folder, const size_t *order,
                         size_t count, psplat_text *html) {
    if (!count) return;
    psplat_text_add(html, "<div class=\"pictures\">\n");
    add_picture(folder, &table->rows[0].setting, html);
    for (size_t i = count; i-- > 0;) add_picture(folder, &table->rows[order[i]].setting, html);
    psplat_text_add(html, "</div>\n");
}

/* Charts are part of the page; what comes before their element is not. */
static void add_charts(const char *folder, psplat_text *html) {
    psplat_text_add(html, "<h2>Charts</h2>\n<p>Both axes are logarithmic; further down and further "
                          "left is better. <code>charts.gp</code> draws them by gnuplot.</p>\n");
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) {
        char *svg = NULL;
        size_t size = 0;
        if (psplat_folder_read(folder, psplat_chart_files[i], &svg, &size, NULL)) continue;
        const char *begin = strstr(svg, "<svg");
        if (begin)
            psplat_text_add(html, "<figure id=\"%.*s\">\n%s</figure>\n",
                            (int)strcspn(psplat_chart_files[i], "."), psplat_chart_files[i], begin);
        free(svg);
    }
}

static void add_paragraph(const char *before, const char *text, const char *after,
                          psplat_text *html) {
    if (!*text) return;
    psplat_text_add(html, "%s", before);
    psplat_text_escaped(html, text);
    psplat_text_add(html, "%s", after);
}

static void add_introduction(const psplat_sweep_table *table, psplat_text *html) {
    const psplat_sweep_options *o = &table->options;
    const char *slash = strrchr(table->source, '/');
    const char *name = slash ? slash + 1 : table->source;
    psplat_text_add(html, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                          "<meta name=\"viewport\" content=\"width=device-width\">\n<title>");
    psplat_text_escaped(html, name);
    psplat_text_add(html, ": speed against accuracy</title>\n<style>%s</style>\n</head>\n<body>\n",
                    style);
    add_paragraph("<h1>", name, ": speed against accuracy</h1>\n", html);
    add_paragraph("<p>What Phong splats of <code>", table->source,
                  "</code> cost and what they buy, measured by <code>phongsplat "
                  "tradeoff</code>.",
                  html);
    psplat_text_add(html, " Pictures are %d pixels wide and high", o->size);
    add_paragraph(", drawn with ", table->graphics, "", html);
    psplat_text_add(html, "; %.0f frames of each setting were timed",
                    table->count ? table->rows->values[PSPLAT_COLUMN_FRAMES] : 0);
    psplat_text_add(html, ".</p>\n");
}

static void write_body(const psplat_sweep_table *table, const char *folder, int has_charts,
                       uint8_t *is_front, size_t *order, psplat_text *html) {
    psplat_column cost = psplat_rows_cost(table->rows, table->count);
    size_t count = psplat_advise_front(table->rows, table->count, order, is_front);
    add_front(table, order, count, cost, html);
    add_pictures(table, folder, order, count, html);
    if (has_charts) add_charts(folder, html);
    psplat_text_add(html, "<h2>Files</h2>\n");
    add_asset_table(table, html);
    psplat_text_add(html, "<h2>Settings</h2>\n");
    add_drawn_table(table, is_front, html);
    psplat_text_add(html, "<h2>What the numbers mean</h2>\n%s", definitions);
    if (*table->gltfpack) psplat_text_add(html, "%s", about_gltfpack);
    add_paragraph("<p>Simplified by ", table->gltfpack, ".</p>\n", html);
    psplat_text_add(html, "<p>All columns, exactly: <code>tradeoff.csv</code>.</p>\n");
}

void psplat_page_write(const psplat_sweep_table *table, const char *folder, int has_charts,
                       psplat_text *text) {
    uint8_t *is_front = malloc(table->count + 1);
    size_t *order = malloc((table->count + 1) * sizeof *order);
    add_introduction(table, text);
    if (is_front && order)
        write_body(table, folder, has_charts, is_front, order, text);
    else
        text->failed = 1;
    psplat_text_add(text, "</body>\n</html>\n");
    free(is_front);
    free(order);
}
