/* SPDX-License-Identifier: MIT
 *
 * deferred.h - the deferred way: meshes and splats write what they are into one G-buffer, and one
 * pass of the engine's lights all of it, without knowing which is which.
 */
#ifndef ENGINE_DEFERRED_H
#define ENGINE_DEFERRED_H

#include "frame.h"
#include "screen.h"

enum { DEFERRED_COLORS = 3, DEFERRED_LAMPS = 12 };

typedef struct deferred {
    const engine_gl *gl;
    const frame *frame;
    paint paint; /* of meshes, into the G-buffer */
    GLint paint_view;
    GLuint framebuffer;
    GLuint textures[DEFERRED_COLORS + 1]; /* normal; albedo, metallic; emission, roughness; depth */
    GLuint light;                         /* the program that lights */
    GLint lens, to_map, sun_direction, sun, up, lamps;
    GLuint nothing; /* a vertex array without attributes */
} deferred;

/* Returns 0 where GL refuses something. The frame must last as long. */
int deferred_make(deferred *d, const engine_gl *gl, const frame *frame);

/* Makes the G-buffer the framebuffer and leaves the paint in use for meshes. psplat_draw leaves
 * GL's initial state behind here, so this comes before meshes whenever splats were drawn. */
void deferred_begin(const deferred *d, int clears);

psplat_result deferred_draw_splats(const deferred *d, psplat_renderer *renderer,
                                   const psplat_item *items, size_t count, psplat_error *error);

/* Lights the G-buffer onto the screen. */
void deferred_light(const deferred *d, screen *s);

#endif
