/* SPDX-License-Identifier: MIT
 *
 * shadow_map.h - the engine's shadow map of the sun. Meshes and splats are drawn into it, and both
 * are shaded by it.
 */
#ifndef ENGINE_SHADOW_MAP_H
#define ENGINE_SHADOW_MAP_H

#include "engine_gl.h"
#include "engine_matrix.h"
#include "engine_mesh.h"

#include <phongsplat/phongsplat.h>

enum { SHADOW_SIZE = 2048, SHADOW_UNIT = PSPLAT_HOST_UNIT };

typedef struct shadow_map {
    GLuint framebuffer, texture;
    paint paint;             /* writes depth alone */
    matrix view, projection; /* of the sun */
} shadow_map;

int shadow_map_make(shadow_map *s, const engine_gl *gl); /* returns 0 where GL refuses */

/* Turns the map to a sun that shines in a direction, around the middle of the stage. */
void shadow_map_aim(shadow_map *s, const float direction[3]);

/* Clears the map and leaves it bound, with its paint in use. */
void shadow_map_begin(const shadow_map *s, const engine_gl *gl);

/* Draws splats into the map, after shadow_map_begin. */
psplat_result shadow_map_draw_splats(const shadow_map *s, psplat_renderer *renderer,
                                     const psplat_item *items, size_t count, psplat_error *error);

/* Binds the map for sampling (a sampler2DShadow) to SHADOW_UNIT. */
void shadow_map_bind(const shadow_map *s, const engine_gl *gl);

/* Computes the matrix from a space to the map's coordinates and depth, 0 ... 1 each; to_world leads
 * from that space to the world. */
void shadow_map_matrix(const shadow_map *s, const matrix *to_world, float out[16]);

#endif
