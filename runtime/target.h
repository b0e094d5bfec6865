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
    int numbers;     /* that the second can hold: 1, 2 or 3 */
    unsigned used;   /* psplat_targets.clock when it was */
} psplat_target;

/* Of two sizes, so that a host's frame may have views of another size without making textures
 * anew; the one that so many calls of psplat_draw have not used goes. */
enum { PSPLAT_TARGET_SIZES = 2, PSPLAT_TARGET_IDLE = 60 };

typedef struct psplat_targets {
    psplat_target list[PSPLAT_TARGET_SIZES];
    psplat_target *current; /* of this call of psplat_draw */
    unsigned clock;         /* calls, may wrap */
} psplat_targets;

/* Finds or makes the target of a size with at least color_count colour textures (layout.h), and
 * leaves its framebuffer bound for drawing, its first color_count buffers enabled. The second holds
 * as many numbers a pixel. Textures are
 * entered in the ledger. On failure there is none of that size. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_targets_bind(psplat_targets *targets, psplat_gl *gl, size_t *ledger, int width,
                                  int height, int color_count, int numbers, psplat_error *error);
void psplat_targets_destroy(psplat_targets *targets, const psplat_gl *gl);

#endif
