/* SPDX-License-Identifier: MIT
 *
 * forward.h - the forward way: each surface is lit where it is drawn. Meshes have a simple shader
 * of the engine's, splats phongsplat's material, environment and lights. Both receive the engine's
 * shadow map; splats through psplat_resolve.filters_light.
 */
#ifndef ENGINE_FORWARD_H
#define ENGINE_FORWARD_H

#include "frame.h"
#include "screen.h"

typedef struct forward {
    const engine_gl *gl;
    const frame *frame;
    paint paint;
    GLint light, sun, ambient, to_map, map;
    psplat_environment *sky;
    unsigned splat_program; /* whose uniform this is: */
    GLint splat_to_map;
} forward;

/* Returns 0 and fills error on failure. The frame must last as long. */
int forward_make(forward *f, const engine_gl *gl, const frame *frame, psplat_renderer *renderer,
                 psplat_error *error);
void forward_free(forward *f, psplat_renderer *renderer);

/* Makes the screen the framebuffer and leaves the paint in use for meshes. */
void forward_begin(const forward *f, screen *s);

/* Draws splats. psplat_draw changes no state of GL here: program, uniforms and everything else stay
 * as the engine set them, for more meshes. */
psplat_result forward_draw_splats(forward *f, psplat_renderer *renderer, const psplat_item *items,
                                  size_t count, psplat_error *error);

#endif
