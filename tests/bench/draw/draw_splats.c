/* SPDX-License-Identifier: MIT
 *
 * draw_splats.c - the draw methods of the renderer itself and of the lower bound of drawing its
 * primitives (probe.h).
 */
#include "draw_method.h"

#include "decode_image.h"
#include "probe.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct splats {
    psplat_renderer *renderer;
    psplat_model *model;
} splats;

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench: %s\n", error->text);
    exit(1);
}

static void draw(void *self, const psplat_view *view) {
    splats *s = self;
    psplat_error error;
    psplat_item item = {.model = s->model};
    check(psplat_draw(s->renderer, view, &item, 1, &error), &error);
}

static void destroy(void *self) {
    splats *s = self;
    psplat_model_destroy(s->renderer, s->model);
    psplat_renderer_destroy(s->renderer);
    free(s);
}

static splats *make(psplat_host *host, const subject *subject, psplat_images images, int half) {
    splats *s = calloc(1, sizeof *s);
    if (!s) abort();
    psplat_error error;
    psplat_renderer_desc desc = {
        .get_proc = probe_get_proc, .user = host, .images = images, .half_targets = half};
    check(psplat_renderer_create(&desc, &s->renderer, &error), &error);
    check(psplat_model_create(s->renderer, subject->asset, &s->model, &error), &error);
    return s;
}

draw_method draw_method_splats(psplat_host *host, const subject *subject, unsigned options) {
    const char *name = options & PROBE_BOUND ? "lower bound" : "ours";
    return (draw_method){name, draw, destroy, make(host, subject, decode_images(), 0), options};
}

draw_method draw_method_untextured(psplat_host *host, const subject *subject) {
    psplat_images none = {.load = NULL};
    return (draw_method){"no textures", draw, destroy, make(host, subject, none, 0), 0};
}

draw_method draw_method_half(psplat_host *host, const subject *subject) {
    return (draw_method){"half targets", draw, destroy, make(host, subject, decode_images(), 1), 0};
}

void draw_method_destroy(draw_method *method) {
    if (method->destroy) method->destroy(method->self);
    *method = (draw_method){0};
}
