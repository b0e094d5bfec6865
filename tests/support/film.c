/* SPDX-License-Identifier: MIT
 *
 * film.c - short films, and how they differ; see film.h.
 */
#include "film.h"

#include "reference_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(psplat_result result, const psplat_error *error) {
    if (!result) return;
    fprintf(stderr, "film: %s\n", error->text);
    abort();
}

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory) return memory;
    fprintf(stderr, "film: out of memory\n");
    abort();
}

/* ---- frames ---------------------------------------------------------------------------------- */

/* Moves the picture by an offset of the projection, so that every pixel moves alike. */
static psplat_view view_of(int size, int across, int frame) {
    psplat_view view = camera_view(size, size);
    camera_look(&view, (double[]){0, 0, 10}, (double[]){0, 0, 0});
    camera_perspective(&view, across / 2.0 * sqrt(99), 8, 12);
    view.projection[8] = 2.0 * frame / FILM_FRAMES / size;
    view.projection[9] = 2.0 * frame / (1.5 * FILM_FRAMES) / size;
    for (int i = 0; i < 3; ++i) view.lights[0].direction[i] = (float[]){-0.6f, -0.5f, -0.7f}[i];
    return view;
}

static void average(const float *rgba, int size, int finer, double *value, double *covered) {
    size_t fine = (size_t)size * (size_t)finer;
    for (size_t i = 0; i < fine * fine; ++i) {
        size_t pixel = i / fine / (size_t)finer * (size_t)size + i % fine / (size_t)finer;
        value[pixel] += (double)rgba[4 * i] / (finer * finer);
        covered[pixel] += (double)rgba[4 * i + 3] / (finer * finer);
    }
}

film film_shoot(psplat_host *host, film_draw draw, void *self, int across, int no_filter,
                int finer) {
    const float clear[4] = {0, 0, 0, 0};
    film f = {.size = across + 2 * FILM_BORDER};
    size_t pixels = (size_t)f.size * (size_t)f.size;
    float *rgba = allocate(pixels * (size_t)finer * (size_t)finer, 4 * sizeof *rgba);
    for (int k = 0; k < FILM_FRAMES; ++k) {
        psplat_view view = view_of(f.size, across, k);
        psplat_error error;
        view.no_filter = no_filter;
        view.width *= finer;
        view.height *= finer;
        check(psplat_host_begin(host, view.width, view.height, 1, clear, &error), &error);
        draw(self, &view);
        check(psplat_host_read_float(host, rgba, &error), &error);
        f.value[k] = allocate(pixels, sizeof *f.value[k]);
        f.covered[k] = allocate(pixels, sizeof *f.covered[k]);
        average(rgba, f.size, finer, f.value[k], f.covered[k]);
    }
    free(rgba);
    return f;
}

void film_free(film *f) {
    for (int k = 0; k < FILM_FRAMES; ++k) {
        free(f->value[k]);
        free(f->covered[k]);
    }
    *f = (film){0};
}

/* ---- figures --------------------------------------------------------------------------------- */

/* Adds a pixel's values in two successive frames, a and b, and the true ones. */
static void add(film_figures *sum, double a, double b, double true_a, double true_b) {
    double change = b - a, flicker = fabs(change - (true_b - true_a));
    sum->change += fabs(change);
    sum->most_change = fmax(sum->most_change, fabs(change));
    sum->flicker += flicker;
    sum->most_flicker = fmax(sum->most_flicker, flicker);
    sum->error += fabs(a - true_a);
    sum->squared_error += (a - true_a) * (a - true_a);
    ++sum->count;
}

static void divide(film_figures *sum) {
    double count = fmax((double)sum->count, 1);
    sum->change /= count;
    sum->flicker /= count;
    sum->error /= count;
    sum->squared_error = sqrt(sum->squared_error / count);
}

film_report film_compare(const film *f, const film *truth) {
    film_report r = {0};
    int pixels = f->size * f->size;
    for (int k = 0; k + 1 < FILM_FRAMES; ++k)
        for (int i = 0; i < pixels; ++i) {
            const double now = truth->covered[k][i], next = truth->covered[k + 1][i];
            int filled = now >= 1 && next >= 1;
            if (!filled && now + next + f->covered[k][i] + f->covered[k + 1][i] <= 0) continue;
            if (filled)
                add(&r.inside, f->value[k][i], f->value[k + 1][i], truth->value[k][i],
                    truth->value[k + 1][i]);
            else
                add(&r.outline, f->covered[k][i], f->covered[k + 1][i], now, next);
        }
    for (int k = 0; k < FILM_FRAMES; ++k)
        for (int i = 0; i < pixels; ++i) r.covered += f->covered[k][i] / FILM_FRAMES;
    divide(&r.inside);
    divide(&r.outline);
    return r;
}
