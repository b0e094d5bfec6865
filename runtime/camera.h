/* SPDX-License-Identifier: MIT
 *
 * camera.h - what the shaders need of a view, and of a batch as a view places it. Everything is
 * composed in double; only the products become float, so that models far from the origin keep
 * their pixels.
 */
#ifndef PHONGSPLAT_CAMERA_H
#define PHONGSPLAT_CAMERA_H

#include "chunk.h"
#include "span.h"

typedef struct psplat_camera {
    double view[16];
    double projection[16]; /* fitted to a span: its depths are not the host's */
    double direction[3];   /* eye space, away from the eye; 0 0 0 in perspective */
    double margin[2];      /* of psplat_chunk_view_set: one pixel */
    float ray[9];          /* times (pixel x, pixel y, 1): the view ray of a pixel, eye space, any
                              length */
    float unproject[16];   /* pixel x, y and window depth to eye space */
    float to_host[2];      /* factor and offset that turn window depths into the host's */
    float planes[3];       /* the host's: near distance, 1 / (far - near), whether far is finite */
    float projection_float[16];
    float half_viewport[3]; /* in pixels; of the depth range */
    int is_perspective;
    int is_mirrored; /* the projection turns counter-clockwise into clockwise */
} psplat_camera;

/* What a camera is made of. */
typedef struct psplat_camera_desc {
    const double *view, *projection; /* 16 each, as in psplat_view */
    int width, height;
    float depth_range[2];    /* window depth of the near and the far plane */
    const psplat_span *span; /* where something is drawn; NULL: between the host's planes */
} psplat_camera_desc;

/* A model matrix in a camera. */
typedef struct psplat_placement {
    double clip[16]; /* object to clip space */
    float modelview[16];
    float normal[9];
    float shift[3];  /* of shift_of() in splat.vert */
    int is_mirrored; /* front faces are clockwise in the window */
    int is_near;     /* the near plane may cut the box */
    psplat_chunk_view chunk_view;
} psplat_placement;

/* Errors: ARGUMENT where the projection has no inverse. */
psplat_result psplat_camera_set(psplat_camera *camera, const psplat_camera_desc *desc,
                                psplat_error *error);

/* What psplat_camera_place asks of a batch. */
typedef struct psplat_placement_desc {
    const double *transform; /* of the item; all zeros: the identity */
    const double *model;     /* of the batch */
    double depth_tolerance;
    const float *bounds_min, *bounds_max;
    int is_culled;
} psplat_placement_desc;

/* 0 where transform times model is singular: nothing to draw (spec 4). */
int psplat_camera_place(const psplat_camera *camera, const psplat_placement_desc *desc,
                        psplat_placement *placement);

/* transform (all zeros: the identity) times model. */
void psplat_camera_compose(const double transform[16], const double model[16], double scene[16]);

#endif
