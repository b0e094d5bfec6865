/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gallery.c - pictures of the source from all sides, drawn once, and what they say of what stands
 * for it. Both are drawn with one sample a pixel, at its centre, so that what the pixel holds is
 * what is there.
 */
#include "gallery.h"

#include "butteraugli.h"
#include "distant.h"
#include "likeness.h"
#include "original.h"
#include "views.h"

#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SIZE = 512, MOST_SIZE = 8192 };

/* ---- making ---------------------------------------------------------------------------------- */

static size_t bytes_of(int size) {
    return 4 * (size_t)size * (size_t)size;
}

size_t psplat_gallery_bytes(const psplat_gallery *gallery) {
    return bytes_of(gallery->size);
}

psplat_result psplat_gallery_begin(psplat_gallery *gallery, int size, int is_float,
                                   psplat_error *error) {
    static const float nothing[4] = {0, 0, 0, 0};
    return psplat_host_begin(gallery->host, size, size, is_float, nothing, error);
}

static psplat_view view_of(const psplat_gallery *gallery, int view, int size) {
    const psplat_original *source = gallery->source;
    return psplat_views_at(view, source->center, source->radius, size);
}

psplat_view psplat_gallery_view(const psplat_gallery *gallery, int view) {
    return view_of(gallery, view, gallery->size);
}

static psplat_result draw_mesh(psplat_gallery *gallery, psplat_facets *facets, int view, int size,
                               uint8_t *picture, psplat_error *error) {
    psplat_view at = view_of(gallery, view, size);
    psplat_result result = psplat_gallery_begin(gallery, size, 0, error);
    if (!result) result = psplat_facets_draw(facets, &at, PSPLAT_FACETS_LIGHT, error);
    if (!result) result = psplat_host_read_rgba8(gallery->host, picture, error);
    return result;
}

static psplat_result create_facets(psplat_gallery *gallery, const psplat_original *original,
                                   psplat_facets **facets, psplat_error *error) {
    const psplat_facets_desc desc = {psplat_host_get_proc, gallery->host, original};
    psplat_result result = psplat_host_make_current(gallery->host, error);
    return result ? result : psplat_facets_create(&desc, facets, error);
}

/* One view, and what is to be seen of it from far away. */
static psplat_result draw_source(psplat_gallery *gallery, int view, psplat_error *error) {
    size_t bytes = psplat_gallery_bytes(gallery);
    int fine = PSPLAT_DISTANT * gallery->distant_size;
    uint8_t *picture = gallery->pictures + (size_t)view * bytes;
    uint8_t *distant = gallery->distant + (size_t)view * bytes_of(gallery->distant_size);
    psplat_result result = draw_mesh(gallery, gallery->facets, view, fine, gallery->shown, error);
    if (result) return result;
    psplat_distant_shrink(gallery->shown, gallery->distant_size, distant);
    return draw_mesh(gallery, gallery->facets, view, gallery->size, picture, error);
}

static psplat_result hang(psplat_gallery *gallery, psplat_error *error) {
    size_t bytes = psplat_gallery_bytes(gallery);
    gallery->distant_size = (gallery->size + PSPLAT_DISTANT - 1) / PSPLAT_DISTANT;
    gallery->pictures = malloc(PSPLAT_GALLERY_VIEWS * bytes);
    gallery->distant = malloc(PSPLAT_GALLERY_VIEWS * bytes_of(gallery->distant_size));
    gallery->shown = malloc(bytes_of(PSPLAT_DISTANT * gallery->distant_size));
    if (!gallery->pictures || !gallery->distant || !gallery->shown)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %d pictures of %d x %d",
                           PSPLAT_GALLERY_VIEWS, gallery->size, gallery->size);
    psplat_result result = create_facets(gallery, gallery->source, &gallery->facets, error);
    for (int i = 0; i < PSPLAT_GALLERY_VIEWS && !result; ++i)
        result = draw_source(gallery, i, error);
    return result;
}

psplat_result psplat_gallery_create(const psplat_gallery_desc *desc, psplat_gallery **gallery,
                                    psplat_error *error) {
    *gallery = NULL;
    if (!desc->host || !desc->source || desc->size < 0 || desc->size > MOST_SIZE)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a gallery needs a host, a source and a size from 0 to %d", MOST_SIZE);
    psplat_gallery *g = calloc(1, sizeof *g);
    if (!g) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a gallery");
    g->host = desc->host;
    g->source = desc->source;
    g->size = desc->size ? desc->size : DEFAULT_SIZE;
    psplat_result result = hang(g, error);
    if (result)
        psplat_gallery_destroy(g);
    else
        *gallery = g;
    return result;
}

void psplat_gallery_destroy(psplat_gallery *gallery) {
    if (!gallery) return;
    psplat_facets_destroy(gallery->facets);
    free(gallery->pictures);
    free(gallery->distant);
    free(gallery->shown);
    free(gallery);
}

/* ---- showing --------------------------------------------------------------------------------- */

psplat_result psplat_gallery_draw_original(psplat_gallery *gallery, const psplat_view *view,
                                           psplat_error *error) {
    return psplat_facets_draw(gallery->facets, view, PSPLAT_FACETS_LIGHT, error);
}

static psplat_result show_splats(psplat_gallery *gallery, const psplat_exhibit *exhibit, int view,
                                 int size, psplat_error *error) {
    psplat_view at = view_of(gallery, view, size);
    const psplat_item item = {.model = exhibit->model};
    at.mode = exhibit->mode;
    at.no_filter = exhibit->no_filter;
    psplat_result result = psplat_gallery_begin(gallery, size, 0, error);
    if (!result) result = psplat_draw(exhibit->renderer, &at, &item, 1, error);
    if (!result) result = psplat_host_read_rgba8(gallery->host, gallery->shown, error);
    return result;
}

/* What an exhibit is drawn by; zero-initialised, mesh is NULL where it is splats. */
typedef struct display {
    const psplat_exhibit *exhibit;
    psplat_facets *mesh;
} display;

static psplat_result open_display(psplat_gallery *gallery, const psplat_exhibit *exhibit,
                                  display *d, psplat_error *error) {
    *d = (display){.exhibit = exhibit};
    if (exhibit->mesh) return create_facets(gallery, exhibit->mesh, &d->mesh, error);
    if (exhibit->renderer && exhibit->model) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                       "an exhibit is a renderer and a model, or a mesh");
}

static psplat_result show(psplat_gallery *gallery, const display *d, int view, int size,
                          psplat_error *error) {
    if (d->mesh) return draw_mesh(gallery, d->mesh, view, size, gallery->shown, error);
    return show_splats(gallery, d->exhibit, view, size, error);
}

psplat_result psplat_gallery_show(psplat_gallery *gallery, const psplat_exhibit *exhibit, int view,
                                  psplat_error *error) {
    display d;
    psplat_result result = open_display(gallery, exhibit, &d, error);
    if (!result) result = show(gallery, &d, view, gallery->size, error);
    psplat_facets_destroy(d.mesh);
    return result;
}

/* ---- comparing --------------------------------------------------------------------------------
 */

void psplat_gallery_turn(const uint8_t *rgba, int size, uint8_t *rgb, size_t stride) {
    for (int y = 0; y < size; ++y) {
        uint8_t *row = rgb + 3 * (size_t)(size - 1 - y) * stride;
        for (int x = 0; x < size; ++x, rgba += 4) memcpy(row + 3 * x, rgba, 3);
    }
}

/* Pictures from several views, one above the other, for butteraugli. */
typedef struct strip {
    uint8_t *pixels[2]; /* NULL: not asked for */
    int count;          /* of views so far */
} strip;

static psplat_result open_strip(const psplat_gallery *gallery, int views, strip *s,
                                psplat_error *error) {
    size_t bytes = (size_t)views * psplat_gallery_bytes(gallery) / 4 * 3;
    for (int i = 0; i < 2; ++i) s->pixels[i] = malloc(bytes);
    if (s->pixels[0] && s->pixels[1]) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %d pictures", 2 * views);
}

static void append(strip *s, const psplat_gallery *gallery, const uint8_t *source) {
    const uint8_t *pictures[2] = {source, gallery->shown};
    size_t side = (size_t)gallery->size, begin = 3 * side * side * (size_t)s->count++;
    for (int i = 0; i < 2; ++i)
        psplat_gallery_turn(pictures[i], gallery->size, s->pixels[i] + begin, side);
}

/* The exhibit beside what the source should look like from far away. */
static psplat_result measure_distant(psplat_gallery *gallery, const display *d, int first, int last,
                                     double *difference, psplat_error *error) {
    size_t bytes = bytes_of(gallery->distant_size);
    uint64_t differences = 0, pixels = 0;
    for (int i = first; i <= last; ++i) {
        psplat_result result = show(gallery, d, i, gallery->distant_size, error);
        if (result) return result;
        psplat_distant_add(gallery->distant + (size_t)i * bytes, gallery->shown,
                           gallery->distant_size, &differences, &pixels);
    }
    *difference = pixels ? 100 * (double)differences / (3 * 255 * (double)pixels) : 0;
    return PSPLAT_OK;
}

static psplat_result measure(psplat_gallery *gallery, const display *d, int first, int last,
                             strip *s, psplat_picture_errors *errors, psplat_error *error) {
    psplat_likeness sums = {0};
    psplat_result result = PSPLAT_OK;
    errors->perceptual = -1;
    for (int i = first; i <= last && !result; ++i) {
        const uint8_t *source = gallery->pictures + (size_t)i * psplat_gallery_bytes(gallery);
        result = show(gallery, d, i, gallery->size, error);
        if (!result)
            result = psplat_likeness_add(&sums, source, gallery->shown, gallery->size, error);
        if (!result && s->pixels[0]) append(s, gallery, source);
    }
    if (!result) result = measure_distant(gallery, d, first, last, &errors->distant, error);
    if (result) return result;
    psplat_likeness_report(&sums, errors);
    if (!s->pixels[0]) return PSPLAT_OK;
    const psplat_picture_pair pair = {
        {s->pixels[0], s->pixels[1]}, gallery->size, gallery->size * s->count};
    return psplat_butteraugli_measure(&pair, &errors->perceptual, error);
}

psplat_result psplat_gallery_compare(psplat_gallery *gallery, const psplat_exhibit *exhibit,
                                     int view, int perceptual, psplat_picture_errors *errors,
                                     psplat_error *error) {
    int first = view < 0 ? 0 : view, last = view < 0 ? PSPLAT_GALLERY_VIEWS - 1 : view;
    display d;
    strip s = {0};
    *errors = (psplat_picture_errors){0};
    if (view >= PSPLAT_GALLERY_VIEWS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "there is no view %d", view);
    psplat_result result = open_display(gallery, exhibit, &d, error);
    if (!result && perceptual) result = open_strip(gallery, last - first + 1, &s, error);
    if (!result) result = measure(gallery, &d, first, last, &s, errors, error);
    psplat_facets_destroy(d.mesh);
    for (int i = 0; i < 2; ++i) free(s.pixels[i]);
    return result;
}
