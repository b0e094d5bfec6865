/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_renderer.h - the mesh renderer: a mesh on the GPU, drawn as indexed triangles and lit per
 * pixel as splats are (spec 5.6). It supports directional lights without shadows, and ambient
 * light.
 */
#ifndef PHONGSPLAT_VIEWS_MESH_RENDERER_H
#define PHONGSPLAT_VIEWS_MESH_RENDERER_H

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"

#include <phongsplat/phongsplat.h>

typedef struct psplat_mesh_renderer psplat_mesh_renderer;

typedef struct psplat_mesh_renderer_desc {
    void *(*get_proc)(void *user, const char *name); /* as in psplat_renderer_desc */
    void *user;
    const psplat_source_mesh *source; /* need not outlive creation */
} psplat_mesh_renderer_desc;

/* Uploads the mesh. The GL context must be current here and in every call below. The caller frees
 * *renderer with psplat_mesh_renderer_destroy. Errors: MEMORY, GRAPHICS. */
psplat_result psplat_mesh_renderer_create(const psplat_mesh_renderer_desc *desc,
                                          psplat_mesh_renderer **renderer, psplat_error *error);
/* Accepts NULL. */
void psplat_mesh_renderer_destroy(psplat_mesh_renderer *renderer);

typedef enum psplat_mesh_renderer_output {
    PSPLAT_MESH_RENDERER_LIGHT = 0, /* the colours of psplat_draw in the view's shading */
    PSPLAT_MESH_RENDERER_NORMALS    /* the interpolated normal, eye space, of any length; alpha 1 */
} psplat_mesh_renderer_output;

/* Draws into the bound framebuffer: colour with alpha 1, and depth, where the depth test (GL_LESS)
 * passes. The view's shading is lit or unlit. The view and the material decide which sides are
 * drawn; the view's mode and filter have no effect. GL's state must be at its defaults except for
 * viewport, program and vertex array; it is left at its defaults, without program and vertex array,
 * but with the viewport of the view. Errors: ARGUMENT (the view has other lights or another
 * shading), MEMORY, GRAPHICS. */
psplat_result psplat_mesh_renderer_draw(psplat_mesh_renderer *renderer, const psplat_view *view,
                                        psplat_mesh_renderer_output output, psplat_error *error);

#endif
