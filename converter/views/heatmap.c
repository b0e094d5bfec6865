/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * heatmap.c - heat maps: the source, what is pictured, and maps of their differences side by side.
 * The point of the source that a pixel shows is found from its depth, unprojected in double; the
 * normal there is drawn into a float framebuffer.
 */
#include "views/heatmap.h"

#include "base/vector.h"
#include "compare/shape_errors.h"
#include "views/heat_colors.h"
#include "views/legend.h"
#include "views/mesh_renderer.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <stdlib.h>
#include <string.h>

enum { PANELS = 5 };

static void set_color(const uint8_t color[3], uint8_t *rgb) {
    memcpy(rgb, color, 3);
}

/* ---- points of the source -------------------------------------------------------------------- */

/* The source in each pixel of a view, row 0 at the bottom. */
typedef struct source_pixels {
    float *normals; /* RGBA: normal in eye space, and 1 where the source is seen */
    float *depth;   /* 0 ... 1 */
    psplat_view view;
} source_pixels;

static psplat_result draw_source_pixels(psplat_picture_views *views, int view, source_pixels *s,
                                        psplat_error *error) {
    size_t pixels = psplat_picture_views_bytes(views) / 4;
    *s = (source_pixels){malloc(4 * pixels * sizeof *s->normals), malloc(pixels * sizeof *s->depth),
                         psplat_picture_views_at(views, view)};
    if (!s->normals || !s->depth)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a map of %zu pixels",
                           pixels);
    psplat_result result = psplat_picture_views_begin(views, views->size, 1, error);
    if (!result)
        result = psplat_mesh_renderer_draw(views->source_renderer, &s->view,
                                           PSPLAT_MESH_RENDERER_NORMALS, error);
    if (!result) result = psplat_host_read_float(views->host, s->normals, error);
    if (!result) result = psplat_host_read_depth(views->host, s->depth, error);
    return result;
}

/* Transforms a direction from eye space to the scene. */
static void to_scene_direction(const psplat_view *view, const double eye[3], double scene[3]) {
    for (int i = 0; i < 3; ++i) scene[i] = dot3(view->view + 4 * i, eye);
}

/* Finds the point of the source and the normal that a pixel shows. It relies on the projections of
 * the views being symmetric: their third column has nothing but z and w. */
static void point_of_pixel(const source_pixels *s, int x, int y, double point[3],
                           double normal[3]) {
    const psplat_view *view = &s->view;
    const double *p = view->projection;
    size_t pixel = (size_t)y * (size_t)view->width + (size_t)x;
    double z = -p[14] / (2 * (double)s->depth[pixel] - 1 + p[10]);
    double eye[3] = {-z * (2 * (x + 0.5) / view->width - 1) / p[0],
                     -z * (2 * (y + 0.5) / view->height - 1) / p[5], z};
    double turned[3];
    for (int i = 0; i < 3; ++i) turned[i] = (double)s->normals[4 * pixel + (size_t)i];
    to_scene_direction(view, turned, normal);
    normalize3(normal);
    sub3(eye, eye, view->view + 12);
    to_scene_direction(view, eye, point);
}

/* ---- panels ---------------------------------------------------------------------------------- */

typedef struct map {
    const psplat_picture_views *views;
    const uint8_t *source; /* its picture, RGBA */
    const psplat_shape_probe *probe;
    const psplat_heatmap_limits *limits;
    source_pixels source_pixels;
    uint8_t *pixels;
} map;

static uint8_t *pixel_of(const map *m, int panel, int x, int y) {
    size_t size = (size_t)m->views->size, row = size - 1 - (size_t)y;
    return m->pixels + 3 * (row * PANELS * size + (size_t)panel * size + (size_t)x);
}

static void set_difference(const map *m, size_t pixel, uint8_t *rgb) {
    const uint8_t *a = m->source + 4 * pixel, *b = m->views->shown + 4 * pixel;
    int sum = 0;
    for (int c = 0; c < 3; ++c) sum += abs(a[c] - b[c]);
    if (a[3] || b[3])
        psplat_heat_color(100 * sum / (3 * 255.0), m->limits->difference, rgb);
    else
        set_color(psplat_heat_nothing, rgb);
}

static void set_shape(const map *m, int x, int y, uint8_t *distance_rgb, uint8_t *angle_rgb) {
    double point[3], normal[3], distance, angle;
    point_of_pixel(&m->source_pixels, x, y, point, normal);
    psplat_shape_probe_at(m->probe, point, normal, &distance, &angle);
    psplat_heat_color(distance, m->limits->distance, distance_rgb);
    if (angle < 0)
        set_color(psplat_heat_uncovered, angle_rgb);
    else
        psplat_heat_color(angle, m->limits->angle, angle_rgb);
}

static void set_row(const map *m, int y) {
    int size = m->views->size;
    for (int x = 0; x < size; ++x) {
        size_t pixel = (size_t)y * (size_t)size + (size_t)x;
        uint8_t *distance = pixel_of(m, 3, x, y), *angle = pixel_of(m, 4, x, y);
        memcpy(pixel_of(m, 0, x, y), m->source + 4 * pixel, 3);
        memcpy(pixel_of(m, 1, x, y), m->views->shown + 4 * pixel, 3);
        set_difference(m, pixel, pixel_of(m, 2, x, y));
        if (m->source_pixels.normals[4 * pixel + 3] > 0) {
            set_shape(m, x, y, distance, angle);
        } else {
            set_color(psplat_heat_nothing, distance);
            set_color(psplat_heat_nothing, angle);
        }
    }
}

static psplat_result fill_panels(map *m, psplat_error *error) {
    size_t rows = (size_t)(m->views->size + psplat_legend_height(m->views->size));
    size_t bytes = rows * (size_t)m->views->size * 3 * PANELS;
    m->pixels = malloc(bytes);
    if (!m->pixels)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a map of %zu bytes",
                           bytes);
    int size = m->views->size;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 4)
#endif
    for (int y = 0; y < size; ++y) set_row(m, y);
    return PSPLAT_OK;
}

/* Writes the legend below the panels. */
static void draw_legend(const map *m, int is_mesh) {
    const psplat_legend legends[PANELS] = {
        {"source", -1, NULL},
        {is_mesh ? "mesh" : "splats", -1, NULL},
        {"difference, % of white", m->limits->difference, NULL},
        {"distance, % of the diagonal", m->limits->distance, NULL},
        {"normals, degrees", m->limits->angle, "not covered"},
    };
    size_t size = (size_t)m->views->size;
    psplat_legend_draw(legends, PANELS, m->views->size, m->pixels + 3 * PANELS * size * size);
}

psplat_result psplat_picture_views_heatmap(psplat_picture_views *views,
                                           const psplat_pictured *pictured,
                                           const psplat_shape_probe *probe, int view,
                                           const psplat_heatmap_limits *limits, uint8_t **pixels,
                                           int *width, int *height, psplat_error *error) {
    *pixels = NULL;
    if (view < 0 || view >= PSPLAT_PICTURE_VIEWS || !probe)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a heat map needs a probe and a view from 0 to %d",
                           PSPLAT_PICTURE_VIEWS - 1);
    map m = {.views = views,
             .source = views->pictures + (size_t)view * psplat_picture_views_bytes(views),
             .probe = probe,
             .limits = limits};
    psplat_result result = psplat_picture_views_show(views, pictured, view, error);
    if (!result) result = draw_source_pixels(views, view, &m.source_pixels, error);
    if (!result) result = fill_panels(&m, error);
    if (!result) draw_legend(&m, pictured->mesh != NULL);
    free(m.source_pixels.normals);
    free(m.source_pixels.depth);
    *pixels = m.pixels;
    *width = PANELS * views->size;
    *height = views->size + psplat_legend_height(views->size);
    return result;
}
