/* SPDX-License-Identifier: MIT
 *
 * quality.c - compares images of splats with images of their mesh; see quality.h.
 */
#include "quality.h"

#include "interleaved_timing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { VIEWS = 6 };

static const double directions[VIEWS][3] = {{0.3, 0.4, 1},  {-0.4, 0.3, -1}, {1, 0.3, -0.2},
                                            {-1, 0.2, 0.4}, {0.2, 1, 0.3},   {-0.3, -1, 0.2}};

static void draw(psplat_host *host, const subject *s, const draw_method *method, psplat_mode mode,
                 int size, int direction, uint8_t *image) {
    psplat_view view = subject_view(s, directions[direction], size, 1);
    psplat_error error;
    view.mode = mode;
    timing_frame(host, &view, method, 0);
    if (!psplat_host_read_rgba8(host, image, &error)) return;
    fprintf(stderr, "bench: %s\n", error.text);
    exit(1);
}

static uint8_t *allocate(size_t size) {
    uint8_t *memory = malloc(size);
    if (memory) return memory;
    fprintf(stderr, "bench: out of memory\n");
    exit(1);
}

quality_reference quality_draw_mesh(psplat_host *host, const subject *s, const draw_method *mesh,
                                    int size) {
    size_t bytes = 4 * (size_t)size * (size_t)size;
    quality_reference reference = {allocate(VIEWS * bytes), size};
    for (int i = 0; i < VIEWS; ++i)
        draw(host, s, mesh, PSPLAT_MODE_PHONG, size, i, reference.images + (size_t)i * bytes);
    return reference;
}

void quality_free(quality_reference *reference) {
    free(reference->images);
    *reference = (quality_reference){0};
}

typedef struct sums {
    double image, shading;
    size_t either, both;
} sums;

static void compare(const uint8_t *a, const uint8_t *b, size_t pixels, sums *sum) {
    for (size_t i = 0; i < pixels; ++i, a += 4, b += 4) {
        if (!a[3] && !b[3]) continue;
        int difference = abs(a[0] - b[0]) + abs(a[1] - b[1]) + abs(a[2] - b[2]);
        sum->image += difference;
        ++sum->either;
        if (!a[3] || !b[3]) continue;
        sum->shading += difference;
        ++sum->both;
    }
}

quality quality_measure(psplat_host *host, const subject *s, const draw_method *splats,
                        psplat_mode mode, const quality_reference *reference) {
    const double white = 3 * 255;
    size_t pixels = (size_t)reference->size * (size_t)reference->size;
    uint8_t *image = allocate(4 * pixels);
    sums sum = {0};
    for (int i = 0; i < VIEWS; ++i) {
        draw(host, s, splats, mode, reference->size, i, image);
        compare(reference->images + 4 * pixels * (size_t)i, image, pixels, &sum);
    }
    free(image);
    return (quality){100 * sum.image / (white * fmax((double)sum.either, 1)),
                     100 * sum.shading / (white * fmax((double)sum.both, 1)),
                     100 * (double)sum.either / ((double)pixels * VIEWS)};
}

double quality_splats_for(double error, const double *splats, const double *errors, size_t count) {
    if (count < 2 || error > errors[0]) return 0;
    size_t i = 1;
    while (i + 1 < count && errors[i] > error) ++i;
    double slope = log(errors[i] / errors[i - 1]) / log(splats[i] / splats[i - 1]);
    if (!(slope < 0)) return 0;
    double found = splats[i - 1] * exp(log(error / errors[i - 1]) / slope);
    return error < errors[i] ? -found : found;
}
