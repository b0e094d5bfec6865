/* SPDX-License-Identifier: MIT
 *
 * camera.h - the camera and placement uniforms: what the shaders need of a view, and of a batch's
 * model matrix in that view. Everything is composed in double and only the products become float,
 * so that models far from the origin keep their pixels.
 */
#ifndef PHONGSPLAT_RENDERER_CAMERA_H
#define PHONGSPLAT_RENDERER_CAMERA_H

#include "core/chunk.h"
#include "renderer/depth_span.h"

typedef struct psplat_camera {
    double view[16];
    double projection[16]; /* the host's with z fitted to a depth span (depth_span.h) */
    double direction[3];   /* of view rays in eye space, away from the eye; 0 0 0 in perspective */
    double margin[2];      /* for psplat_chunk_view_set: one pixel in halves of the viewport */
    int width, height;     /* of the viewport, pixels */
    float ray[9];          /* 3 x 3 matrix from (pixel x, pixel y, 1) to the pixel's view ray in eye
                              space, of any length */
    float unproject[16];   /* matrix from pixel x, y and window depth to eye space */
    float to_host[2];      /* factor and offset that turn window depths into the host's */
    float planes[3];       /* of the host's projection: near distance; 1 / (far - near), 0 where far
                              is infinite; 1 where far is finite */
    float projection_float[16];
    float half_viewport[3]; /* half the width and height in pixels, half the depth range */
    float depth_range[2];   /* half and middle of the depth range */
    float shift[3];     /* u_shift of shift.glsl: the factor of shifts in z of clip space; 1 where
                           it is divided by the distance (perspective); 0 */
    int is_perspective; /* 0: orthographic */
    int is_mirrored;    /* 1: the projection turns counter-clockwise into clockwise */
} psplat_camera;

/* The parameters of psplat_camera_set. */
typedef struct psplat_camera_desc {
    const double *view, *projection; /* 16 each, as in psplat_view */
    int width, height;               /* pixels */
    float depth_range[2];            /* window depth of the near and the far plane */
    const psplat_depth_span *span;   /* the depths to fit to; NULL: all between the host's planes */
} psplat_camera_desc;

/* A batch's model matrix in a camera. */
typedef struct psplat_placement {
    double clip[16];     /* object to clip space */
    double scale;        /* lengths in object space to lengths in eye space: |det|^(1/3) */
    float modelview[16]; /* object to eye space */
    float normal[9];     /* normals from object to eye space (spec 4) */
    float epsilon;       /* of eq. (5) without its cosine, in eye space */
    float unstretch;     /* 1 / scale */
    int is_mirrored;     /* 1: front faces are clockwise in the window */
    int is_near;         /* 1: the near plane may cut the batch's bounding box */
    psplat_chunk_view chunk_view;
} psplat_placement;

/* Computes a camera. Errors: ARGUMENT where the projection has no inverse. */
psplat_result psplat_camera_set(psplat_camera *camera, const psplat_camera_desc *desc,
                                psplat_error *error);

/* Computes what batches with the same model matrix have in common in a placement. modelview is the
 * matrix from object to eye space. Returns 0 where it is singular, so that nothing is drawn (spec
 * 4). */
int psplat_camera_place(const psplat_camera *camera, const double modelview[16],
                        psplat_placement *placement);

/* What else a placement depends on. */
typedef struct psplat_placement_desc {
    double depth_tolerance;               /* object space */
    const float *bounds_min, *bounds_max; /* 3 each, object space */
    int is_culled;                        /* 1: backs are not seen */
} psplat_placement_desc;

/* Computes the rest of a placement. */
void psplat_camera_place_batch(const psplat_placement_desc *desc, psplat_placement *placement);

/* Returns by how many pixels the images of points of a box move at most where the points move by a
 * length, all in the object space of a matrix to clip space. The result is infinite where the box
 * reaches behind the eye. It counts what is in the view. */
double psplat_camera_pixels(const psplat_camera *camera, const double clip[16], const float min[3],
                            const float max[3], double length);

/* Computes transform times model; all zeros of transform mean the identity. */
void psplat_camera_compose(const double transform[16], const double model[16], double scene[16]);

/* Computes view times transform times model. */
void psplat_camera_modelview(const double view[16], const double transform[16],
                             const double model[16], double modelview[16]);

#endif
