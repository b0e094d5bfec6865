/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facets.h - a mesh on the GPU, drawn as indexed triangles with normals and lit per pixel as splats
 * are (spec 5.6). Of lights it knows directional ones without shadows, and ambient light.
 */
#ifndef PHONGSPLAT_FACETS_H
#define PHONGSPLAT_FACETS_H

#include "compare.h"

typedef struct psplat_facets psplat_facets;

typedef struct psplat_facets_desc {
    void *(*get_proc)(void *user, const char *name); /* as in psplat_renderer_desc */
    void *user;
    const psplat_original *original; /* not needed afterwards */
} psplat_facets_desc;

/* Errors: MEMORY, GRAPHICS. The context is current then and in every call below. */
psplat_result psplat_facets_create(const psplat_facets_desc *desc, psplat_facets **facets,
                                   psplat_error *error);
void psplat_facets_destroy(psplat_facets *facets); /* NULL is accepted */

typedef enum psplat_facets_output {
    PSPLAT_FACETS_LIGHT = 0, /* as psplat_draw colours pixels in lit shading */
    PSPLAT_FACETS_NORMALS    /* interpolated normal of any length, eye space; alpha 1 */
} psplat_facets_output;

/* Draws into the framebuffer that is bound: colour with alpha 1 and depth where the depth test
 * (GL_LESS) passes. Sides as the view and the material say; the view's mode and filter mean
 * nothing. GL's state is expected at its defaults but for viewport, program and vertex array, and
 * left so, with none of these bound. Errors: ARGUMENT (a view with other light), MEMORY, GRAPHICS.
 */
psplat_result psplat_facets_draw(psplat_facets *facets, const psplat_view *view,
                                 psplat_facets_output output, psplat_error *error);

#endif
