/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture_views.c - the picture views. The source is drawn once from all sides; pictures of splats
 * or of another mesh are then compared with these. Pixels have one sample, at their centre, without
 * antialiasing, so that a pixel shows either the model or the background.
 */
#include "views/picture_views.h"

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "picture/png_writer.h"
#include "views/distant_view.h"
#include "views/image_metrics.h"
#include "views/mesh_renderer.h"
#include "views/picture_views_parts.h"
#include "views/view_directions.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SIZE = 512, MAX_SIZE = 8192 }; /* pixels */

/* ---- creation -------------------------------------------------------------------------------- */

static size_t bytes_of(int size) {
    return 4 * (size_t)size * (size_t)size;
}

size_t psplat_picture_views_bytes(const psplat_picture_views *views) {
    return bytes_of(views->size);
}

psplat_result psplat_picture_views_begin(psplat_picture_views *views, int size, int is_float,
                                         psplat_error *error) {
    static const float nothing[4] = {0, 0, 0, 0};
    return psplat_host_begin(views->host, size, size, is_float, nothing, error);
}

static psplat_view view_of(const psplat_picture_views *views, int view, int size) {
    const psplat_source_mesh *source = views->source;
    psplat_view at = psplat_view_directions_at(view, source->center, source->radius, size);
    at.shading = views->shading;
    return at;
}

psplat_view psplat_picture_views_at(const psplat_picture_views *views, int view) {
    return view_of(views, view, views->size);
}

static psplat_result draw_mesh(psplat_picture_views *views, psplat_mesh_renderer *renderer,
                               int view, int size, uint8_t *picture, psplat_error *error) {
    psplat_view at = view_of(views, view, size);
    psplat_result result = psplat_picture_views_begin(views, size, 0, error);
    if (!result)
        result = psplat_mesh_renderer_draw(renderer, &at, PSPLAT_MESH_RENDERER_LIGHT, error);
    if (!result) result = psplat_host_read_rgba8(views->host, picture, error);
    return result;
}

static psplat_result create_mesh_renderer(psplat_picture_views *views,
                                          const psplat_source_mesh *mesh,
                                          psplat_mesh_renderer **renderer, psplat_error *error) {
    const psplat_mesh_renderer_desc desc = {psplat_host_get_proc, views->host, mesh};
    psplat_result result = psplat_host_make_current(views->host, error);
    return result ? result : psplat_mesh_renderer_create(&desc, renderer, error);
}

/* Draws the source from one view, and the reference for the distant view. */
static psplat_result draw_source(psplat_picture_views *views, int view, psplat_error *error) {
    size_t bytes = psplat_picture_views_bytes(views);
    int fine = PSPLAT_DISTANT * views->distant_size;
    uint8_t *picture = views->pictures + (size_t)view * bytes;
    uint8_t *distant = views->distant + (size_t)view * bytes_of(views->distant_size);
    psplat_result result =
        draw_mesh(views, views->source_renderer, view, fine, views->shown, error);
    if (result) return result;
    psplat_distant_view_shrink(views->shown, views->distant_size, distant);
    return draw_mesh(views, views->source_renderer, view, views->size, picture, error);
}

static psplat_result draw_all_views(psplat_picture_views *views, psplat_error *error) {
    size_t bytes = psplat_picture_views_bytes(views);
    views->distant_size = (views->size + PSPLAT_DISTANT - 1) / PSPLAT_DISTANT;
    views->pictures = malloc(PSPLAT_PICTURE_VIEWS * bytes);
    views->distant = malloc(PSPLAT_PICTURE_VIEWS * bytes_of(views->distant_size));
    views->shown = malloc(bytes_of(PSPLAT_DISTANT * views->distant_size));
    if (!views->pictures || !views->distant || !views->shown)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %d pictures of %d x %d",
                           PSPLAT_PICTURE_VIEWS, views->size, views->size);
    psplat_result result =
        create_mesh_renderer(views, views->source, &views->source_renderer, error);
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS && !result; ++i) result = draw_source(views, i, error);
    return result;
}

psplat_result psplat_picture_views_create(const psplat_picture_views_desc *desc,
                                          psplat_picture_views **views, psplat_error *error) {
    *views = NULL;
    if (!desc->host || !desc->source || desc->size < 0 || desc->size > MAX_SIZE)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "picture views need a host, a source and a size from 0 to %d", MAX_SIZE);
    psplat_picture_views *g = calloc(1, sizeof *g);
    if (!g) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for picture views");
    g->host = desc->host;
    g->source = desc->source;
    g->size = desc->size ? desc->size : DEFAULT_SIZE;
    g->shading = desc->shading;
    psplat_result result = draw_all_views(g, error);
    if (result)
        psplat_picture_views_destroy(g);
    else
        *views = g;
    return result;
}

void psplat_picture_views_destroy(psplat_picture_views *views) {
    if (!views) return;
    psplat_mesh_renderer_destroy(views->source_renderer);
    free(views->pictures);
    free(views->distant);
    free(views->shown);
    free(views);
}

/* ---- drawing --------------------------------------------------------------------------------- */

psplat_result psplat_picture_views_draw_source(psplat_picture_views *views, const psplat_view *view,
                                               psplat_error *error) {
    return psplat_mesh_renderer_draw(views->source_renderer, view, PSPLAT_MESH_RENDERER_LIGHT,
                                     error);
}

static psplat_result show_splats(psplat_picture_views *views, const psplat_pictured *pictured,
                                 int view, int size, psplat_error *error) {
    psplat_view at = view_of(views, view, size);
    const psplat_item item = {.model = pictured->model};
    at.mode = pictured->mode;
    at.no_filter = pictured->no_filter;
    psplat_result result = psplat_picture_views_begin(views, size, 0, error);
    if (!result) result = psplat_draw(pictured->renderer, &at, &item, 1, error);
    if (!result) result = psplat_host_read_rgba8(views->host, views->shown, error);
    return result;
}

/* What is pictured, with the renderer of its mesh, which is NULL where it is splats. */
typedef struct drawable {
    const psplat_pictured *pictured;
    psplat_mesh_renderer *mesh;
} drawable;

static psplat_result open_drawable(psplat_picture_views *views, const psplat_pictured *pictured,
                                   drawable *d, psplat_error *error) {
    *d = (drawable){.pictured = pictured};
    if (pictured->mesh) return create_mesh_renderer(views, pictured->mesh, &d->mesh, error);
    if (pictured->renderer && pictured->model) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                       "a picture needs a renderer and a model, or a mesh");
}

static psplat_result show(psplat_picture_views *views, const drawable *d, int view, int size,
                          psplat_error *error) {
    if (d->mesh) return draw_mesh(views, d->mesh, view, size, views->shown, error);
    return show_splats(views, d->pictured, view, size, error);
}

psplat_result psplat_picture_views_show(psplat_picture_views *views,
                                        const psplat_pictured *pictured, int view,
                                        psplat_error *error) {
    drawable d;
    psplat_result result = open_drawable(views, pictured, &d, error);
    if (!result) result = show(views, &d, view, views->size, error);
    psplat_mesh_renderer_destroy(d.mesh);
    return result;
}

/* GL's rows begin at the bottom, and those of a PNG at the top. */
static psplat_result encode(const uint8_t *picture, int edge, uint8_t **png, size_t *size,
                            psplat_error *error) {
    size_t row = 4 * (size_t)edge, rows = (size_t)edge;
    uint8_t *turned = malloc(bytes_of(edge));
    if (!turned)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a picture of %d x %d",
                           edge, edge);
    for (size_t y = 0; y < rows; ++y) memcpy(turned + y * row, picture + (rows - 1 - y) * row, row);
    psplat_result result = psplat_png_encode(turned, edge, edge, 4, png, size, error);
    free(turned);
    return result;
}

psplat_result psplat_picture_views_png(psplat_picture_views *views, const psplat_pictured *pictured,
                                       int view, uint8_t **png, size_t *size, psplat_error *error) {
    const uint8_t *source = views->pictures + (size_t)view * psplat_picture_views_bytes(views);
    psplat_result result =
        pictured ? psplat_picture_views_show(views, pictured, view, error) : PSPLAT_OK;
    return result ? result
                  : encode(pictured ? views->shown : source, views->size, png, size, error);
}

/* ---- comparison ------------------------------------------------------------------------------ */

/* Measures the mean difference of distant views, % of white. */
static psplat_result measure_distant(psplat_picture_views *views, const drawable *d, int first,
                                     int last, double *difference, psplat_error *error) {
    size_t bytes = bytes_of(views->distant_size);
    uint64_t differences = 0, pixels = 0;
    for (int i = first; i <= last; ++i) {
        psplat_result result = show(views, d, i, views->distant_size, error);
        if (result) return result;
        psplat_distant_view_add(views->distant + (size_t)i * bytes, views->shown,
                                views->distant_size, &differences, &pixels);
    }
    *difference = pixels ? 100 * (double)differences / (3 * 255 * (double)pixels) : 0;
    return PSPLAT_OK;
}

static psplat_result measure(psplat_picture_views *views, const drawable *d, int first, int last,
                             psplat_picture_errors *errors, psplat_error *error) {
    psplat_image_metrics sums = {.erosion = d->pictured->erosion};
    psplat_result result = PSPLAT_OK;
    for (int i = first; i <= last && !result; ++i) {
        const uint8_t *source = views->pictures + (size_t)i * psplat_picture_views_bytes(views);
        result = show(views, d, i, views->size, error);
        if (!result)
            result = psplat_image_metrics_add(&sums, source, views->shown, views->size, error);
    }
    if (!result) result = measure_distant(views, d, first, last, &errors->distant, error);
    if (!result) psplat_image_metrics_report(&sums, errors);
    return result;
}

psplat_result psplat_picture_views_compare(psplat_picture_views *views,
                                           const psplat_pictured *pictured, int view,
                                           psplat_picture_errors *errors, psplat_error *error) {
    int first = view < 0 ? 0 : view, last = view < 0 ? PSPLAT_PICTURE_VIEWS - 1 : view;
    drawable d;
    *errors = (psplat_picture_errors){0};
    if (view >= PSPLAT_PICTURE_VIEWS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "there is no view %d", view);
    psplat_result result = open_drawable(views, pictured, &d, error);
    if (!result) result = measure(views, &d, first, last, errors, error);
    psplat_mesh_renderer_destroy(d.mesh);
    return result;
}
