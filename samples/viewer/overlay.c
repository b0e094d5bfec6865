/* SPDX-License-Identifier: MIT
 *
 * overlay.c - the text over the picture: the keys, messages, errors, numbers of tiles, and a hint
 * while no model is shown.
 */
#include "viewer.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Distances in font pixels: between a panel's edge and its text, and between a key and its
 * description. */
enum { MARGIN = 6, GAP = 12 };

static const uint32_t panel_color = 0x0b0d10d8, text_color = 0xe8ebefff, key_color = 0xffc66dff,
                      error_color = 0xffb4a8ff, error_panel = 0x4a1512e8, title_color = 0x9fb4ccff;
static const double message_seconds = 2.5;

static int longest(int a, int b) {
    return a > b ? a : b;
}

/* Returns the largest whole size of a font pixel at which text of across x down font pixels fits
 * the window, but no more than is comfortable to read. */
static int text_size(int width, int height, int across, int down) {
    int comfortable = longest(1, (height + 250) / 500);
    int fitting = width / (across + 4 * MARGIN), fitting_down = height / (down + 2 * MARGIN);
    if (fitting_down < fitting) fitting = fitting_down;
    return longest(1, fitting < comfortable ? fitting : comfortable);
}

/* Draws the panel behind text of across x down font pixels whose upper left corner is at (x, y). */
static void draw_panel(canvas *c, int x, int y, int size, int across, int down, uint32_t color) {
    canvas_rectangle(c, x - size * MARGIN, y - size * MARGIN, size * (across + 2 * MARGIN),
                     size * (down + 2 * MARGIN), color, color);
}

/* ---- the keys ------------------------------------------------------------------------------ */

/* Returns the height of a row of the help in font pixels; a gap between groups is half a line. */
static int row_height(const key_binding *row) {
    return !row->label ? 0 : *row->label ? FONT_LINE : FONT_LINE / 2;
}

static void draw_rows(canvas *c, int x, int y, int size, int labels) {
    for (size_t i = 0; i < key_binding_count; ++i) {
        const key_binding *row = &key_bindings[i];
        if (!row->label) continue;
        canvas_text(c, x, y, size, key_color, row->label);
        canvas_text(c, x + size * labels, y, size, text_color, row->help);
        y += size * row_height(row);
    }
}

static void draw_help(canvas *c, int width, int height) {
    static const char heading[] = "phongsplat-viewer";
    int labels = 0, texts = 0, rows = 2 * FONT_LINE;
    for (size_t i = 0; i < key_binding_count; ++i) {
        if (!key_bindings[i].label) continue;
        labels = longest(labels, canvas_text_width(key_bindings[i].label) + GAP);
        texts = longest(texts, canvas_text_width(key_bindings[i].help));
        rows += row_height(&key_bindings[i]);
    }
    int across = labels + texts, size = text_size(width, height, across, rows);
    /* In a window that is too small, the beginnings of the lines stay readable. */
    int x = longest(size * MARGIN, (width - size * across) / 2);
    int y = longest(size * MARGIN, (height - size * rows) / 2);
    draw_panel(c, x, y, size, across, rows, panel_color);
    canvas_text(c, x, y, size, title_color, heading);
    draw_rows(c, x, y + 2 * size * FONT_LINE, size, labels);
}

/* ---- lines at the bottom ------------------------------------------------------------------- */

/* Cuts the line at the window's width, because file names may be long. */
static void draw_line(canvas *c, int width, int *bottom, uint32_t panel, uint32_t color, int size,
                      const char *text) {
    char shown[400];
    snprintf(shown, sizeof shown, "%s", text);
    size_t length = strlen(shown);
    while (length > 4 && canvas_text_width(shown) > width / size - 4 * MARGIN)
        strcpy(shown + --length - 3, "...");
    int x = 2 * size * MARGIN, y = *bottom - size * (FONT_HEIGHT + 2 * MARGIN);
    draw_panel(c, x, y, size, canvas_text_width(shown) - 1, FONT_HEIGHT, panel);
    canvas_text(c, x, y, size, color, shown);
    *bottom = y - 2 * size * MARGIN;
}

static void error_line(const viewer *v, const char *path, const psplat_error *error, char *text,
                       size_t size) {
    char place[40] = "";
    if (error->offset) snprintf(place, sizeof place, "byte %zu: ", error->offset);
    snprintf(text, size, "%s: %s%s%s", shown_asset_name(path), place,
             *error->text ? error->text : psplat_result_text(error->code),
             !shown_assets_are_empty(&v->shown) ? " (showing what was there before)" : "");
}

static void draw_lines(viewer *v, int width, int height) {
    int size = text_size(width, height, 240, FONT_LINE), bottom = height;
    char text[600];
    const char *path;
    const psplat_error *error = shown_assets_error(&v->shown, &path);
    if (error) {
        error_line(v, path, error, text, sizeof text);
        draw_line(v->canvas, width, &bottom, error_panel, error_color, size, text);
    }
    if (loader_is_busy(v->loader))
        draw_line(v->canvas, width, &bottom, panel_color, title_color, size, "loading ...");
    else if (window_seconds() < v->message_end)
        draw_line(v->canvas, width, &bottom, panel_color, text_color, size, v->message);
}

/* ---- tiles --------------------------------------------------------------------------------- */

/* Writes the numbers of the last frame's tiles in lines. */
static void draw_tile_report(viewer *v, int width, int height) {
    enum { LINES = 4, ACROSS = 180 };
    char lines[LINES][80];
    const psplat_tiles_state *s = &v->tiles_state;
    int size = text_size(width, height, ACROSS, LINES * FONT_LINE), margin = 2 * size * MARGIN;
    snprintf(lines[0], sizeof lines[0], "%zu splats in %zu tiles", s->splats, s->drawn);
    snprintf(lines[1], sizeof lines[1], "%zu missing, %zu under way", s->missing,
             s->under_way + s->waiting);
    snprintf(lines[2], sizeof lines[2], "error %.2f of %.2g pixels%s", s->error_pixels,
             v->settings.pixels, s->over_budget ? ", over budget" : "");
    snprintf(lines[3], sizeof lines[3], "%.1f MB of tiles%s", 1e-6 * (double)s->bytes,
             s->failed ? ", some cannot be read" : "");
    draw_panel(v->canvas, margin, margin, size, ACROSS, LINES * FONT_LINE - 2, panel_color);
    for (int i = 0; i < LINES; ++i)
        canvas_text(v->canvas, margin, margin + i * size * FONT_LINE, size, text_color, lines[i]);
}

static void draw_hint(viewer *v, int width, int height) {
    static const char hint[] = "Drop .glb files here - H shows the keys";
    int across = canvas_text_width(hint);
    int size = text_size(width, height, across, FONT_LINE);
    if (!shown_assets_are_empty(&v->shown) || v->has_help || loader_is_busy(v->loader)) return;
    canvas_text(v->canvas, (width - size * across) / 2, (height - size * FONT_LINE) / 2, size,
                title_color, hint);
}

void overlay_draw(viewer *v, int width, int height) {
    canvas_begin(v->canvas, width, height);
    draw_hint(v, width, height);
    draw_lines(v, width, height);
    if (v->settings.has_tile_report && shown_tiles_exist(&v->shown))
        draw_tile_report(v, width, height);
    if (v->has_help) draw_help(v->canvas, width, height);
    canvas_end(v->canvas);
}

void overlay_say(viewer *v, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(v->message, sizeof v->message, format, arguments);
    va_end(arguments);
    v->message_end = window_seconds() + message_seconds;
    v->needs_redraw = 1;
}
