/* SPDX-License-Identifier: MIT
 *
 * camera.h - what the shaders need of a view, and of a batch as a view places it. Everything is
 * composed in double; only the products become float, so that models far from the origin keep
 * their pixels.
 */
#ifndef PHONGSPLAT_CAMERA_H
#define PHONGSPLAT_CAMERA_H

#include <phongsplat/phongsplat.h>

typedef struct psplat_camera {
    double view[16], projection[16];
    float projection_float[16];
    float ray[9]; /* times (pixel x, pixel y, 1): the view ray of a pixel, eye space, any length */
    float light_direction[3]; /* unit, eye space; 0 where the view has no direction */
    int is_perspective;
    int is_mirrored; /* the projection turns counter-clockwise into clockwise */
} psplat_camera;

/* A model matrix in a camera. */
typedef struct psplat_placement {
    float modelview[16];
    float normal[9];
    float shift[3];  /* of shift_of() in splat.vert */
    int is_mirrored; /* front faces are clockwise in the window */
    int is_near;     /* the near plane may cut the box */
} psplat_placement;

/* Errors: ARGUMENT where the projection has no inverse. */
psplat_result psplat_camera_from_view(psplat_camera *camera, const psplat_view *view,
                                      psplat_error *error);

/* 0 where transform (all zeros: the identity) times model is singular: nothing to draw (spec 4). */
int psplat_camera_place(const psplat_camera *camera, const double transform[16],
                        const double model[16], double depth_tolerance, const float bounds_min[3],
                        const float bounds_max[3], psplat_placement *placement);

#endif
