/* SPDX-License-Identifier: MIT
 *
 * target.h - the float textures that the splat passes draw into.
 */
#ifndef PHONGSPLAT_TARGET_H
#define PHONGSPLAT_TARGET_H

#include "gl_api.h"
#include "layout.h"
#include "texture.h"

typedef struct psplat_target {
    GLuint framebuffer;
    psplat_texture colors[PSPLAT_TARGET_COUNT_MATERIALS];
    psplat_texture depth;
    int width, height;
    int color_count; /* textures that exist */
    int is_wide;     /* the second holds two numbers: 0 where there are fewer than all */
} psplat_target;

/* Gives the target the size and at least color_count colour textures (layout.h), keeps what fits,
 * and leaves its framebuffer bound for drawing, its first color_count buffers enabled. Textures are
 * entered in the ledger. On failure the target is empty. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_target_bind(psplat_target *target, const psplat_gl *gl, size_t *ledger,
                                 int width, int height, int color_count, psplat_error *error);
void psplat_target_destroy(psplat_target *target, const psplat_gl *gl);

#endif
