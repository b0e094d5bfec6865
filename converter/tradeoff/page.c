/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * page.c - the sweep as one HTML file: for reading, with no script and nothing to fetch.
 */
#include "tradeoff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A column of a table as it is shown. */
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
    {PSPLAT_COLUMN_PERCEPTUAL, "perceptual", ""}, {PSPLAT_COLUMN_CPU_MS, "CPU", "ms"},
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
    "those that it covers.</dd>\n"
    "<dt>made in, loaded in</dt><dd>seconds of the conversion; milliseconds of opening the file "
    "and uploading it, a median.</dd>\n"
    "<dt>CPU, wall, GPU</dt><dd>milliseconds of a frame: medians and quartiles of frames that all "
    "settings drew in turn, the 12 views one after the other. CPU time is that of all threads. "
    "GPU time is left empty where GL is drawn in software.</dd>\n"
    "<dt>front</dt><dd>Highlighted settings are those that no other beats: none is at most as "
    "large and at most as different, and better in one of both. Settings without filter are left "
    "out: it keeps models still that are small and move, which these pictures do not show.</dd>\n"
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
static int is_used(const psplat_journal *journal, psplat_column column) {
    for (size_t i = 0; i < journal->count; ++i)
        if (!isnan(journal->rows[i].values[column])) return 1;
    return 0;
}

static void add_head(const psplat_journal *journal, const char *first, const shown *columns,
                     size_t count, psplat_text *html) {
    psplat_text_add(html, "<div class=\"wide\"><table>\n<thead><tr><th>%s</th>", first);
    for (size_t i = 0; i < count; ++i)
        if (is_used(journal, columns[i].column))
            psplat_text_add(html, "<th>%s<br><small>%s</small></th>", columns[i].name,
                            columns[i].unit);
    psplat_text_add(html, "</tr></thead>\n<tbody>\n");
}

static void add_row(const psplat_journal *journal, size_t row, const char *kind,
                    const shown *columns, size_t count, psplat_text *html) {
    const psplat_row *r = &journal->rows[row];
    psplat_text_add(html, "<tr%s><td>", kind);
    add_setting(&r->setting, html);
    psplat_text_add(html, "</td>");
    for (size_t i = 0; i < count; ++i) {
        if (!is_used(journal, columns[i].column)) continue;
        psplat_text_add(html, "<td>");
        psplat_text_figure(html, r->values[columns[i].column]);
        psplat_text_add(html, "</td>");
    }
    psplat_text_add(html, "</tr>\n");
}

static const char *kind_of(const psplat_journal *journal, size_t row, const uint8_t *is_front) {
    if (is_front[row]) return " class=\"front\"";
    int is_splats = journal->rows[row].setting.contender == PSPLAT_CONTENDER_SPLATS;
    return is_splats ? "" : " class=\"other\"";
}

static void add_drawn_table(const psplat_journal *journal, const uint8_t *is_front,
                            psplat_text *html) {
    add_head(journal, "setting", drawn_columns, DRAWN_COLUMNS, html);
    for (size_t i = 0; i < journal->count; ++i)
        add_row(journal, i, kind_of(journal, i, is_front), drawn_columns, DRAWN_COLUMNS, html);
    psplat_text_add(html, "</tbody></table></div>\n");
}

static void add_asset_name(const psplat_setting *setting, psplat_text *html) {
    psplat_setting_file(setting, html);
    if (setting->contender == PSPLAT_CONTENDER_MESH) psplat_text_add(html, "source mesh");
}

/* A line a file: the first row of each. */
static void add_asset_table(const psplat_journal *journal, psplat_text *html) {
    const psplat_row *rows = journal->rows;
    add_head(journal, "file", asset_columns, ASSET_COLUMNS, html);
    for (size_t i = 0; i < journal->count; ++i) {
        if (i && psplat_setting_shares_asset(&rows[i].setting, &rows[i - 1].setting)) continue;
        psplat_text_add(html, "<tr><td>");
        add_asset_name(&rows[i].setting, html);
        psplat_text_add(html, "</td>");
        for (size_t k = 0; k < ASSET_COLUMNS; ++k) {
            if (!is_used(journal, asset_columns[k].column)) continue;
            psplat_text_add(html, "<td>");
            psplat_text_figure(html, rows[i].values[asset_columns[k].column]);
            psplat_text_add(html, "</td>");
        }
        psplat_text_add(html, "</tr>\n");
    }
    psplat_text_add(html, "</tbody></table></div>\n");
}

/* The front in a few columns, cheapest first. */
static void add_front(const psplat_journal *journal, const size_t *order, size_t count,
                      psplat_column cost, psplat_text *html) {
    const shown columns[] = {
        {PSPLAT_COLUMN_BYTES, "size", "bytes"},
        {PSPLAT_COLUMN_ELEMENTS, "splats", ""},
        {PSPLAT_COLUMN_DISTANCE_MAX, "distance, max", "%"},
        {PSPLAT_COLUMN_NORMAL_RMS, "normals, RMS", "°"},
        {PSPLAT_COLUMN_DIFFERENCE, "difference", "%"},
        {cost, cost == PSPLAT_COLUMN_GPU_MS ? "GPU" : "CPU", "ms a frame"},
    };
    const size_t column_count = sizeof columns / sizeof *columns;
    size_t knee = psplat_pareto_knee(journal->rows, order, count, PSPLAT_COLUMN_BYTES,
                                     PSPLAT_COLUMN_DIFFERENCE);
    psplat_text_add(html,
                    "<h2>What to choose</h2>\n<p>The settings that no other beats in size "
                    "and in how the model looks, each drawn in the way that does most for it. "
                    "Highlighted: the knee, up to which bytes "
                    "buy most.</p>\n");
    add_head(journal, "setting", columns, column_count, html);
    for (size_t i = 0; i < count; ++i)
        add_row(journal, order[i], i == knee ? " class=\"front\"" : "", columns, column_count,
                html);
    psplat_text_add(html, "</tbody></table></div>\n");
    if (!count) return;
    psplat_text command = {0};
    psplat_setting_command(&journal->rows[order[knee]].setting, &journal->options, journal->source,
                           &command);
    psplat_text_add(html, "<p><code>");
    if (command.data) psplat_text_escaped(html, command.data);
    psplat_text_add(html, "</code></p>\n");
    html->failed |= command.failed;
    free(command.data);
}

static void add_charts(const psplat_journal *journal, psplat_column cost, psplat_text *html) {
    psplat_chart charts[PSPLAT_CHARTS];
    size_t count = psplat_chart_list(cost, charts);
    psplat_text_add(html, "<h2>Charts</h2>\n<p>Both axes are logarithmic; further down and further "
                          "left is better. A mark tells its values when pointed at.</p>\n");
    for (size_t i = 0; i < count; ++i) {
        psplat_text_add(html, "<figure id=\"%.*s\">\n", (int)strcspn(charts[i].file, "."),
                        charts[i].file);
        psplat_chart_write(&charts[i], journal, html);
        psplat_text_add(html, "</figure>\n");
    }
}

static void add_paragraph(const char *before, const char *text, const char *after,
                          psplat_text *html) {
    if (!*text) return;
    psplat_text_add(html, "%s", before);
    psplat_text_escaped(html, text);
    psplat_text_add(html, "%s", after);
}

static void add_introduction(const psplat_journal *journal, psplat_text *html) {
    const psplat_tradeoff_options *o = &journal->options;
    const char *slash = strrchr(journal->source, '/');
    const char *name = slash ? slash + 1 : journal->source;
    psplat_text_add(html, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                          "<meta name=\"viewport\" content=\"width=device-width\">\n<title>");
    psplat_text_escaped(html, name);
    psplat_text_add(html, ": speed against accuracy</title>\n<style>%s</style>\n</head>\n<body>\n",
                    style);
    add_paragraph("<h1>", name, ": speed against accuracy</h1>\n", html);
    add_paragraph("<p>What Phong splats of <code>", journal->source,
                  "</code> cost and what they buy, measured by <code>phongsplat "
                  "tradeoff</code>.",
                  html);
    psplat_text_add(html, " Pictures are %d pixels wide and high", o->size);
    add_paragraph(", drawn with ", journal->graphics, "", html);
    psplat_text_add(html, "; %d frames of each setting were timed", o->frames);
    psplat_text_add(html, ".</p>\n");
}

static void write_body(const psplat_journal *journal, uint8_t *is_front, size_t *order,
                       psplat_text *html) {
    psplat_column cost = psplat_rows_cost(journal->rows, journal->count);
    size_t count = psplat_advise_front(journal->rows, journal->count, order, is_front);
    add_front(journal, order, count, cost, html);
    add_charts(journal, cost, html);
    psplat_text_add(html, "<h2>Files</h2>\n");
    add_asset_table(journal, html);
    psplat_text_add(html, "<h2>Settings</h2>\n");
    add_drawn_table(journal, is_front, html);
    psplat_text_add(html, "<h2>What the numbers mean</h2>\n%s", definitions);
    if (*journal->gltfpack) psplat_text_add(html, "%s", about_gltfpack);
    add_paragraph("<p>Simplified by ", journal->gltfpack, ".</p>\n", html);
    psplat_text_add(html, "<p>All columns, exactly: <code>tradeoff.csv</code>.</p>\n");
}

void psplat_page_write(const psplat_journal *journal, psplat_text *text) {
    uint8_t *is_front = malloc(journal->count + 1);
    size_t *order = malloc((journal->count + 1) * sizeof *order);
    add_introduction(journal, text);
    if (is_front && order)
        write_body(journal, is_front, order, text);
    else
        text->failed = 1;
    psplat_text_add(text, "</body>\n</html>\n");
    free(is_front);
    free(order);
}
