/* SPDX-License-Identifier: MIT
 *
 * frame.h - one call of psplat_draw: what its passes share.
 */
#ifndef PHONGSPLAT_FRAME_H
#define PHONGSPLAT_FRAME_H

#include "camera.h"
#include "extent.h"
#include "lights.h"
#include "renderer.h"

typedef struct psplat_frame {
    psplat_renderer *renderer;
    const psplat_view *view;
    const psplat_item *items;
    size_t item_count;
    psplat_camera camera;
    psplat_lights lights;
    psplat_program_key key; /* of the attribute pass, but for what differs between batches */
    double depth_range[2];  /* the host's: window depth of the near and the far plane */
    psplat_extent extent;   /* of what the last pass drew in its camera, in pixels of the view */
    int blends;             /* 0: the nearest splat wins, and no visibility pass is needed */
    psplat_error *error;
} psplat_frame;

/* ---- batches.c ---------------------------------------------------------------------------- */

/* Draws all batches of all items with the options of key and those that each batch asks for, and
 * enters them in frame->extent. */
psplat_result psplat_frame_draw_batches(psplat_frame *frame, const psplat_camera *camera,
                                        psplat_program_key key, psplat_culling culling);

void psplat_frame_bind_texture(const psplat_gl *gl, GLenum unit, const psplat_texture *texture,
                               GLenum target);

/* Uniforms of the current program. */
void psplat_frame_use_material(const psplat_gl *gl, const psplat_program *program,
                               const psplat_material *material);
void psplat_frame_use_light(const psplat_frame *frame, const psplat_program *program);

/* ---- shadow.c ----------------------------------------------------------------------------- */

/* Draws the shadow maps of frame->lights and tells the lights of them. */
psplat_result psplat_frame_draw_shadows(psplat_frame *frame);

#endif
