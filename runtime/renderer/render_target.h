/* SPDX-License-Identifier: MIT
 *
 * render_target.h - render targets: a framebuffer with the float textures that the splat passes add
 * to (multiple render targets) and a depth buffer. They are kept between frames.
 */
#ifndef PHONGSPLAT_RENDERER_RENDER_TARGET_H
#define PHONGSPLAT_RENDERER_RENDER_TARGET_H

#include "gl/gl_api.h"
#include "layout.h"
#include "gl/gl_texture.h"

typedef struct psplat_render_target {
    GLuint framebuffer;
    psplat_gl_texture colors[PSPLAT_TARGET_COUNT_EMISSIVE]; /* layout.h says what each holds */
    psplat_gl_texture depth;
    int width, height; /* pixels */
    int color_count;   /* colour textures that exist */
    int numbers;       /* numbers a pixel that the second one can hold: 1, 2 or 3 */
    unsigned used;     /* value of psplat_render_targets.clock at its last use */
} psplat_render_target;

/* Targets of two sizes are kept, so that a host's frame may have views of two sizes without making
 * textures anew. A target that was not used in the last PSPLAT_TARGET_IDLE calls of psplat_draw is
 * deleted. */
enum { PSPLAT_TARGET_SIZES = 2, PSPLAT_TARGET_IDLE = 60 };

typedef struct psplat_render_targets {
    psplat_render_target list[PSPLAT_TARGET_SIZES];
    psplat_render_target *current; /* the target of this call of psplat_draw */
    unsigned clock;                /* number of calls; may wrap */
} psplat_render_targets;

/* Finds or makes the target of a size with at least color_count colour textures (layout.h), of
 * which the second holds at least `numbers` numbers a pixel. Leaves its framebuffer bound for
 * drawing, with its first color_count buffers enabled. The bytes of new textures are added to
 * *ledger. On failure there is no target of that size. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_render_targets_bind(psplat_render_targets *targets, psplat_gl *gl,
                                         size_t *ledger, int width, int height, int color_count,
                                         int numbers, psplat_error *error);

/* Lets GL forget what the current target holds, where GL can, so that GPUs that draw in tiles need
 * not load what is about to be cleared in part. */
void psplat_render_targets_invalidate(const psplat_render_targets *targets, const psplat_gl *gl);

/* Deletes all targets. */
void psplat_render_targets_destroy(psplat_render_targets *targets, const psplat_gl *gl);

#endif
