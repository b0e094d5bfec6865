/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * legend.c - the legend of a heat map. The strokes of stb's font are rectangles, which are filled
 * here one by one.
 */
#include "views/legend.h"

#include "views/heat_colors.h"

#include <stb/stb_easy_font.h>
#include <stdio.h>
#include <string.h>

/* Lengths in font pixels: rows of text, the bar, and the distances between and around them. */
enum { TEXT = 8, BAR = 8, GAP = 4, ROWS = GAP + TEXT + GAP + BAR + GAP + TEXT + GAP };
/* The pixels of a panel for which a font pixel is one pixel. */
enum { FINE_PANEL = 384 };
/* Numbers stand at both ends of a bar and at the quarters between. */
enum { QUARTERS = 4 };

static const uint8_t paper[3] = {24, 24, 24}, ink[3] = {232, 232, 232};

/* The place below one panel. */
typedef struct sheet {
    uint8_t *pixels;
    int left, stride; /* pixels: where it begins, and a row of all panels */
    int size, rows;
    int scale; /* pixels of a font pixel */
} sheet;

static int scale_of(int size) {
    return size < 2 * FINE_PANEL ? 1 : size / FINE_PANEL;
}

int psplat_legend_height(int size) {
    return ROWS * scale_of(size);
}

/* Fills a rectangle, in pixels, as far as it lies on the sheet. */
static void fill(const sheet *s, int x, int y, int width, int height, const uint8_t color[3]) {
    for (int row = y < 0 ? 0 : y; row < y + height && row < s->rows; ++row)
        for (int column = x < 0 ? 0 : x; column < x + width && column < s->size; ++column) {
            size_t at = (size_t)row * (size_t)s->stride + (size_t)(s->left + column);
            memcpy(s->pixels + 3 * at, color, 3);
        }
}

/* Returns the width of a text in pixels. */
static int width_of(const sheet *s, const char *text) {
    char copy[64];
    snprintf(copy, sizeof copy, "%s", text); /* the font's functions want to write */
    return s->scale * stb_easy_font_width(copy);
}

static void write_text(const sheet *s, int x, int y, const char *text) {
    struct {
        float x, y, z;
        uint8_t color[4];
    } quads[64 * 16][4]; /* strokes; corners clockwise from the upper left */
    char copy[64];
    snprintf(copy, sizeof copy, "%s", text);
    int count = stb_easy_font_print(0, 0, copy, NULL, quads, sizeof quads);
    for (int i = 0; i < count; ++i) {
        int left = (int)quads[i][0].x, top = (int)quads[i][0].y;
        fill(s, x + s->scale * left, y + s->scale * top, s->scale * ((int)quads[i][2].x - left),
             s->scale * ((int)quads[i][2].y - top), ink);
    }
}

/* Writes the number of a quarter below the bar, its middle below the place that it is the value
 * of, but inside of the sheet. What lies beyond the last one has its colour, too. */
static void write_number(const sheet *s, const psplat_legend *legend, int quarter, int left,
                         int width, int y) {
    char text[32];
    snprintf(text, sizeof text, "%.3g%s", legend->limit * quarter / QUARTERS,
             quarter == QUARTERS ? "+" : "");
    int at = left + width * quarter / QUARTERS, wide = width_of(s, text);
    int x = quarter == 0 ? left : quarter == QUARTERS ? left + width - wide : at - wide / 2;
    write_text(s, x, y, text);
}

static void draw_bar(const sheet *s, const psplat_legend *legend) {
    int gap = s->scale * GAP, left = gap, width = s->size - 2 * gap;
    int y = s->scale * (GAP + TEXT + GAP), below = y + s->scale * (BAR + GAP);
    for (int x = 0; x < width; ++x) {
        uint8_t color[3];
        psplat_heat_color(width > 1 ? x / (double)(width - 1) : 0, 1, color);
        fill(s, left + x, y, 1, s->scale * BAR, color);
    }
    /* Narrow panels have room for the ends alone. */
    int step = width < s->scale * 160 ? QUARTERS : 1;
    for (int quarter = 0; quarter <= QUARTERS; quarter += step)
        write_number(s, legend, quarter, left, width, below);
}

/* Writes what the colour of uncovered surface means, at the right end of the title's row. */
static void draw_key(const sheet *s, const char *key) {
    int side = s->scale * TEXT, gap = s->scale * GAP, x = s->size - gap - width_of(s, key);
    write_text(s, x, gap, key);
    fill(s, x - gap - side, gap, side, side, psplat_heat_uncovered);
}

void psplat_legend_draw(const psplat_legend *legends, int count, int size, uint8_t *pixels) {
    for (int i = 0; i < count; ++i) {
        int scale = scale_of(size), gap = scale * GAP;
        sheet s = {pixels, i * size, count * size, size, psplat_legend_height(size), scale};
        fill(&s, 0, 0, size, s.rows, paper);
        write_text(&s, gap, gap, legends[i].title);
        if (legends[i].limit >= 0) draw_bar(&s, &legends[i]);
        if (legends[i].key) draw_key(&s, legends[i].key);
    }
}
