/* SPDX-License-Identifier: MIT
 *
 * frame.h - one call of psplat_draw: the data that its passes share, and the passes that have files
 * of their own. draw.c runs them.
 */
#ifndef PHONGSPLAT_RENDERER_FRAME_H
#define PHONGSPLAT_RENDERER_FRAME_H

#include "gl/gl_state.h"
#include "renderer/camera.h"
#include "renderer/screen_extent.h"
#include "renderer/lights.h"
#include "renderer/marked_blocks.h"
#include "renderer/renderer.h"

#include <string.h>

typedef struct psplat_frame {
    psplat_renderer *renderer;
    const psplat_view *view;
    const psplat_item *items;
    size_t item_count;
    psplat_camera camera;
    psplat_lights lights;
    psplat_program_key key;      /* of the attribute pass, without the options that batches add */
    double depth_range[2];       /* the host's: window depth of the near and the far plane */
    psplat_screen_extent extent; /* pixels of the view that the last pass may have covered */
    psplat_marked_blocks blocks; /* those of the extent that it may have covered */
    int blends;                  /* 0: the nearest splat wins, and no visibility pass is needed */
    psplat_error *error;         /* the caller's, may be NULL */
} psplat_frame;

/* Returns the matrix of a batch of an item: that of the item's pose or, without one, that at
 * rest. */
static inline const double *psplat_item_matrix(const psplat_item *item, size_t batch) {
    return item->pose ? psplat_pose_matrix(item->pose, batch) : item->model->batches[batch].model;
}

/* Returns 1 where an item is drawn, and 1 where it is not drawn whole. */
static inline int psplat_item_is_drawn(const psplat_item *item) {
    return item->fade < 1.0f;
}
static inline int psplat_item_is_faded(const psplat_item *item) {
    return item->fade > 0.0f;
}

/* Returns whether a batch of an item is of the level that the item shows. */
static inline int psplat_item_shows(const psplat_item *item, size_t batch) {
    const psplat_model_batch *b = &item->model->batches[batch];
    size_t coarsest = item->model->level_count - 1;
    size_t level = item->level < coarsest ? item->level : coarsest;
    return b->level <= level && level <= b->last_level;
}

/* Returns whether a batch of an item is where the batch before it is, as those of one node are, and
 * that one is shown too. */
static inline int psplat_item_shares_place(const psplat_item *item, size_t batch) {
    if (batch > 0 && !psplat_item_shows(item, batch - 1)) return 0;
    if (!item->pose) return item->model->batches[batch].shares_place;
    return batch > 0 && !memcmp(psplat_pose_matrix(item->pose, batch),
                                psplat_pose_matrix(item->pose, batch - 1), 16 * sizeof(double));
}

/* ---- batches.c ---------------------------------------------------------------------------- */

/* Places all batches of all items in a camera, for psplat_frame_draw_placed, and sets frame->extent
 * to what they may cover. Batches whose transform is singular are left out. keeps_order is as in
 * psplat_instances_make. Errors: MEMORY, GRAPHICS. */
psplat_result psplat_frame_place(psplat_frame *frame, const psplat_camera *camera,
                                 psplat_culling culling, int keeps_order);

/* Draws what was placed in this camera last, with the options of key and those that each batch asks
 * for. Errors: GRAPHICS, MEMORY (a shader program cannot be made). */
psplat_result psplat_frame_draw_placed(psplat_frame *frame, const psplat_camera *camera,
                                       psplat_program_key key);

/* Does both, in any order of items. */
psplat_result psplat_frame_draw_batches(psplat_frame *frame, const psplat_camera *camera,
                                        psplat_program_key key, psplat_culling culling);

/* Sets the current program's uniforms of a material. */
void psplat_frame_use_material(const psplat_gl *gl, const psplat_program *program,
                               const psplat_material *material);

/* Sets the current program's uniforms of the view's lights, environment and shadow maps, and binds
 * their textures. */
void psplat_frame_use_light(const psplat_frame *frame, const psplat_program *program);

/* ---- host_pass.c -------------------------------------------------------------------------- */

/* Checks the members of a view that tell of the host: resolve, host. Errors: ARGUMENT. */
psplat_result psplat_frame_check_host(const psplat_view *view, psplat_error *error);

/* Stores the host's depth range, read from GL or told by the view. */
void psplat_frame_find_depth_range(const psplat_frame *frame, float range[2]);

/* Takes or assumes the state of GL, by the renderer's policy. Errors: GRAPHICS. */
psplat_result psplat_frame_take_state(const psplat_frame *frame, psplat_gl_state *state,
                                      GLuint unit_count);

/* Returns what psplat_draw is to return. Where the host resets state GL is asked nothing, unless
 * the frame failed. */
psplat_result psplat_frame_finish(const psplat_frame *frame, psplat_result result);

/* Returns GRAPHICS where GL tells that the context is lost. */
psplat_result psplat_frame_ask_for_loss(psplat_renderer *renderer, psplat_error *error);

/* Finds the host's resolve function, where the view has one that matters, and stores its number in
 * frame->key. Errors: MEMORY. */
psplat_result psplat_frame_find_resolve(psplat_frame *frame);

/* Return the shading that stands for what the frame draws, and 1 where it reads materials. */
int psplat_frame_shading(const psplat_frame *frame);
int psplat_frame_reads_material(const psplat_frame *frame);

/* Lets the host set the uniforms of its resolve function's program, which is current. */
void psplat_frame_use_resolve(const psplat_frame *frame, const psplat_program *program);

/* Draws the depths of a shadow map into the host's framebuffer. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_frame_draw_depth(psplat_frame *frame, const psplat_gl_state *state);

/* ---- shadow_pass.c ------------------------------------------------------------------------ */

/* Draws a shadow map for each of frame->lights.casters, and stores the matrices in the renderer's
 * psplat_shadows and the width of a texel in the lights. Errors: GRAPHICS, MEMORY, ARGUMENT (the
 * view has no inverse). */
psplat_result psplat_frame_draw_shadows(psplat_frame *frame);

#endif
