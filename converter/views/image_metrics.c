/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_metrics.c - image metrics of picture pairs: counts of pixels, differences of channels, and
 * the structural similarity (SSIM) of Wang, Bovik, Sheikh and Simoncelli 2004 ("Image quality
 * assessment: from error visibility to structural similarity"), eq. 13, with the authors' constants
 * and window.
 *
 * A picture counts as black beyond its edges, as its background is, so that every pixel has a
 * window.
 */
#include "views/image_metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WINDOW_REACH = 5, WINDOW = 2 * WINDOW_REACH + 1 }; /* pixels */
enum { MEANS = 4 };                                       /* of a window, see below */
enum { DEFAULT_EROSION = 2 };                             /* pixels */

static const double window_deviation = 1.5;         /* of the Gaussian window, pixels */
static const double c1 = 0.01 * 255 * (0.01 * 255); /* (K1 L)^2 */
static const double c2 = 0.03 * 255 * (0.03 * 255); /* (K2 L)^2 */

/* ---- pixels ---------------------------------------------------------------------------------- */

static void add_pixel(psplat_image_metrics *sums, const uint8_t *a, const uint8_t *b) {
    unsigned difference = 0, square = 0;
    if (!a[3] && !b[3]) return;
    for (int c = 0; c < 3; ++c) {
        int d = a[c] - b[c];
        difference += (unsigned)abs(d);
        square += (unsigned)(d * d);
    }
    sums->differences += difference;
    sums->squares += square;
    ++sums->either;
    sums->source += a[3] != 0;
    sums->missing += !b[3];
    sums->extra += !a[3];
    if (!a[3] || !b[3]) return;
    sums->inside += difference;
    sums->inside_squares += square;
    ++sums->both;
}

/* Returns whether a picture covers all pixels within so many of one, the corners of that square
 * included. Beyond its edges is background. */
static int is_interior(const uint8_t *rgba, int size, int x, int y, int erosion) {
    if (x < erosion || y < erosion || x >= size - erosion || y >= size - erosion) return 0;
    for (int j = y - erosion; j <= y + erosion; ++j)
        for (int i = x - erosion; i <= x + erosion; ++i)
            if (!rgba[4 * ((size_t)j * (size_t)size + (size_t)i) + 3]) return 0;
    return 1;
}

static void add_holes(psplat_image_metrics *sums, const uint8_t *source, const uint8_t *pictured,
                      int size) {
    int erosion = sums->erosion > 0 ? sums->erosion : DEFAULT_EROSION;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            size_t alpha = 4 * ((size_t)y * (size_t)size + (size_t)x) + 3;
            if (source[alpha] && !pictured[alpha])
                sums->holes += (uint64_t)is_interior(source, size, x, y, erosion);
        }
}

/* ---- structural similarity ------------------------------------------------------------------- */

/* The luma of a picture, with a black margin of WINDOW_REACH pixels on all sides. */
typedef struct plane {
    double *values;
    size_t stride;
} plane;

/* The weights of a window, and memory for comparing a pair. */
typedef struct windows {
    double weights[WINDOW];
    plane lumas[2];
    double *columns[MEANS]; /* of a row, over window columns: a, b, a^2 + b^2, a b */
    double *means[MEANS];   /* the same over whole windows */
} windows;

static void set_weights(double weights[WINDOW]) {
    double sum = 0;
    for (int i = 0; i < WINDOW; ++i)
        sum += weights[i] = exp(-(i - WINDOW_REACH) * (i - WINDOW_REACH) /
                                (2 * window_deviation * window_deviation));
    for (int i = 0; i < WINDOW; ++i) weights[i] /= sum;
}

/* Stores the luma of encoded values (ITU-R BT.601), which is 0 already where nothing is. */
static void set_luma(plane *p, const uint8_t *rgba, int size) {
    for (int y = 0; y < size; ++y) {
        double *row = p->values + (size_t)(y + WINDOW_REACH) * p->stride + WINDOW_REACH;
        for (int x = 0; x < size; ++x, rgba += 4)
            if (rgba[3]) row[x] = 0.299 * rgba[0] + 0.587 * rgba[1] + 0.114 * rgba[2];
    }
}

/* Averages over the columns begin ... end of the windows of row y. */
static void average_columns(const windows *w, int y, size_t begin, size_t end) {
    double *restrict first = w->columns[0], *restrict second = w->columns[1];
    double *restrict squares = w->columns[2], *restrict products = w->columns[3];
    for (int m = 0; m < MEANS; ++m)
        memset(w->columns[m] + begin, 0, (end - begin) * sizeof(double));
    for (int k = 0; k < WINDOW; ++k) {
        const double *a = w->lumas[0].values + (size_t)(y + k) * w->lumas[0].stride;
        const double *b = w->lumas[1].values + (size_t)(y + k) * w->lumas[1].stride;
        double weight = w->weights[k];
        for (size_t x = begin; x < end; ++x) {
            first[x] += weight * a[x];
            second[x] += weight * b[x];
            squares[x] += weight * (a[x] * a[x] + b[x] * b[x]);
            products[x] += weight * (a[x] * b[x]);
        }
    }
}

/* Averages the columns over the windows around the pixels begin ... end of a row. Pixel after pixel
 * is the inner loop, so that several are averaged at once. */
static void average_windows(const windows *w, size_t begin, size_t end) {
    for (int m = 0; m < MEANS; ++m) {
        double *restrict mean = w->means[m];
        memset(mean + begin, 0, (end - begin) * sizeof *mean);
        for (size_t k = 0; k < WINDOW; ++k) {
            const double *column = w->columns[m] + k;
            double weight = w->weights[k];
            for (size_t x = begin; x < end; ++x) mean[x] += weight * column[x];
        }
    }
}

static double similarity(const windows *w, size_t x) {
    double a = w->means[0][x], b = w->means[1][x], product = a * b, squares = a * a + b * b;
    return (2 * product + c1) * (2 * (w->means[3][x] - product) + c2) /
           ((squares + c1) * (w->means[2][x] - squares + c2));
}

static int is_covered(const uint8_t *source, const uint8_t *pictured, size_t x) {
    return source[4 * x + 3] || pictured[4 * x + 3];
}

static void add_windows(psplat_image_metrics *sums, const windows *w, const uint8_t *source,
                        const uint8_t *pictured, int size) {
    size_t side = (size_t)size;
    for (int y = 0; y < size; ++y, source += 4 * side, pictured += 4 * side) {
        size_t begin = 0, end = side;
        while (begin < end && !is_covered(source, pictured, begin)) ++begin;
        while (begin < end && !is_covered(source, pictured, end - 1)) --end;
        if (begin == end) continue;
        average_columns(w, y, begin, end + WINDOW - 1);
        average_windows(w, begin, end);
        for (size_t x = begin; x < end; ++x)
            if (is_covered(source, pictured, x)) sums->ssim += similarity(w, x);
    }
}

psplat_result psplat_image_metrics_add(psplat_image_metrics *sums, const uint8_t *source,
                                       const uint8_t *pictured, int size, psplat_error *error) {
    size_t side = (size_t)size + 2 * WINDOW_REACH, pixels = (size_t)size * (size_t)size;
    double *memory = calloc(2 * side * side + 2 * MEANS * side, sizeof *memory);
    if (!memory)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to compare %zu pixels",
                           pixels);
    windows w = {.lumas = {{memory, side}, {memory + side * side, side}}};
    for (size_t i = 0; i < MEANS; ++i) {
        w.columns[i] = memory + 2 * side * side + i * side;
        w.means[i] = w.columns[i] + MEANS * side;
    }
    set_weights(w.weights);
    set_luma(&w.lumas[0], source, size);
    set_luma(&w.lumas[1], pictured, size);
    for (size_t i = 0; i < pixels; ++i) add_pixel(sums, source + 4 * i, pictured + 4 * i);
    add_holes(sums, source, pictured, size);
    add_windows(sums, &w, source, pictured, size);
    free(memory);
    return PSPLAT_OK;
}

/* ---- results --------------------------------------------------------------------------------- */

/* Returns 100 % where the whole is 0 and the part is not. */
static double percent(uint64_t part, uint64_t whole) {
    if (!whole) return part ? 100 : 0;
    return 100 * (double)part / (double)whole;
}

static double psnr_of(uint64_t squares, uint64_t pixels) {
    if (!squares) return (double)INFINITY;
    return 10 * log10(255.0 * 255 * 3 * (double)pixels / (double)squares);
}

void psplat_image_metrics_report(const psplat_image_metrics *sums, psplat_picture_errors *errors) {
    errors->psnr = psnr_of(sums->squares, sums->either);
    errors->inside_psnr = psnr_of(sums->inside_squares, sums->both);
    errors->ssim = sums->either ? sums->ssim / (double)sums->either : 1;
    errors->difference = percent(sums->differences, 3 * 255 * sums->either);
    errors->inside = percent(sums->inside, 3 * 255 * sums->both);
    errors->missing = percent(sums->missing, sums->source);
    errors->extra = percent(sums->extra, sums->source);
    errors->covered = (size_t)sums->source;
    errors->interior_holes = (size_t)sums->holes;
}
