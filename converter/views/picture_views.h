/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture_views.h - the picture views: pictures of the source mesh from all sides, and the
 * differences between them and pictures of splats or of another mesh.
 */
#ifndef PHONGSPLAT_VIEWS_PICTURE_VIEWS_H
#define PHONGSPLAT_VIEWS_PICTURE_VIEWS_H

#include <phongsplat/splat.h>
#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

#include "compare/source_mesh.h"
#include "views/image_metrics.h"

/* The number of views, which look from the corners of an icosahedron, none along an axis
 * (view_directions.c). psplat_viewpoint_fit sets camera and light for a sphere that is a twentieth
 * larger than the source's bounding sphere, since splats may reach beyond the source. */
#define PSPLAT_PICTURE_VIEWS 12

typedef struct psplat_picture_views psplat_picture_views;

typedef struct psplat_picture_views_desc {
    psplat_host *host; /* its context is current in every call; GL or GLES */
    const psplat_source_mesh *source;
    int size;               /* width and height of pictures, pixels, at most 8192; 0 means 512 */
    psplat_shading shading; /* of the source and of what is compared: lit or unlit */
} psplat_picture_views_desc;

/* Draws the source from all views, per pixel with the lights and the material that splats get.
 * host and source must outlive *views, which the caller frees with psplat_picture_views_destroy.
 * The host's framebuffer is used here and below, and GL's state must be at its defaults. Errors:
 * ARGUMENT, MEMORY, GRAPHICS. */
psplat_result psplat_picture_views_create(const psplat_picture_views_desc *desc,
                                          psplat_picture_views **views, psplat_error *error);

/* Accepts NULL. */
void psplat_picture_views_destroy(psplat_picture_views *views);

/* Returns view 0 ... PSPLAT_PICTURE_VIEWS - 1, for drawing with psplat_draw. */
psplat_view psplat_picture_views_at(const psplat_picture_views *views, int view);

/* What is pictured beside the source: a model of a renderer in the host's context, or, if mesh is
 * not NULL, another mesh, which is drawn as the source is. */
typedef struct psplat_pictured {
    psplat_renderer *renderer;
    psplat_model *model;
    psplat_mode mode;
    int no_filter;
    const psplat_source_mesh *mesh;
    int erosion; /* of psplat_image_metrics */
} psplat_pictured;

/* Measures the differences in one view, or, if view is negative, in all views as if they were one
 * picture. Errors: ARGUMENT, MEMORY, GRAPHICS. */
psplat_result psplat_picture_views_compare(psplat_picture_views *views,
                                           const psplat_pictured *pictured, int view,
                                           psplat_picture_errors *errors, psplat_error *error);

/* Encodes one view of what is pictured, or of the source where pictured is NULL, as a PNG of size x
 * size pixels without background, in memory from malloc, which the caller frees. Errors: ARGUMENT,
 * MEMORY, GRAPHICS. */
psplat_result psplat_picture_views_png(psplat_picture_views *views, const psplat_pictured *pictured,
                                       int view, uint8_t **png, size_t *size, psplat_error *error);

/* Draws the source into the bound framebuffer, for timing it. Errors: ARGUMENT (a light that is not
 * directional, or shadows), MEMORY, GRAPHICS. */
psplat_result psplat_picture_views_draw_source(psplat_picture_views *views, const psplat_view *view,
                                               psplat_error *error);

#endif
