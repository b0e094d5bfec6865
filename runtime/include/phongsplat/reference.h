/* SPDX-License-Identifier: MIT
 *
 * phongsplat/reference.h - the oracle: a slow rasteriser in double precision that follows
 * schema/README.md section 5 step by step and shares nothing with the renderer but splat.h and the
 * input structs of phongsplat.h. It is what the shaders are tested against.
 */
#ifndef PHONGSPLAT_REFERENCE_H
#define PHONGSPLAT_REFERENCE_H

#include "phongsplat.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is drawn. Zeros are the defaults of all but the asset. */
typedef struct psplat_reference_scene {
    const psplat_asset *asset;
    double transform[16]; /* after the asset's own node transforms; all zeros: the identity */
    const psplat_environment_desc *environment; /* in place of psplat_view.environment, which is the
                                                   renderer's and not looked at; NULL: none */
} psplat_reference_scene;

/* Per-pixel results; each array holds width * height entries, row 0 at the bottom as in GL. The
 * caller provides the arrays; a NULL array is not computed.
 *
 * The three ties say how near a pixel is to a different decision, so that tests can skip pixels
 * that float32 cannot decide. They are 1 where nothing is near, and count only splats that would
 * show: those not hidden by the pixel's visibility limit min(t + epsilon) of spec 5.3. In flat and
 * parameters mode the limit is the nearest splat; in the others they do not say whether the nearest
 * splat is nearest by far. Edges of shadows are no ties. */
typedef struct psplat_reference_image {
    float *color;    /* 4 per pixel: RGB as psplat_view.linear_output asks, A = 1 where covered */
    double *depth;   /* window depth 0 ... 1 of spec 5.5; 1 where uncovered */
    double *uv;      /* 2 per pixel: (u, v) of the nearest splat; 0 where there is none */
    int32_t *splat;  /* index of the nearest splat, counted over all batches in draw order; -1 where
                        there is none, be it that the filter of spec 5.8 covers the pixel */
    uint32_t *count; /* splats blended into the pixel (1 at most in flat and parameters mode) */
    double *tie;     /* least distance to an edge (|1 - r|, or to a clip line with a, b normalised),
                        in (u, v) or in pixels, whichever is less; least |cosine| between a splat's
                        normal and the ray, which decides front or back. With the filter, edges are
                        both those of the ellipses that decide visibility and those of the widened
                        ones, and a softened clip line's is where its factor becomes 0 */
    double *depth_tie;   /* least difference of window depth to the near and far plane and to the
                            visibility limit */
    double *epsilon_tie; /* least |t - limit| over the greatest epsilon of eq. (5); always 1 in flat
                            and parameters mode */
} psplat_reference_image;

/* Draws a scene with the given view; view.x and view.y are ignored; the projection may be any
 * invertible matrix. image describes view.width x view.height pixels. Takes some 300 bytes a pixel
 * from the C library while it runs, and 400 bytes a splat where a light casts shadows. Where the
 * materials of several batches meet in a pixel, their factors are blended as COLOR_0 is (spec 5.4).
 * Shadows are cast by rays and environments integrated pixel by pixel: choose small images. Values
 * of the shadings NORMAL, DEPTH and OVERDRAW are written as they are, never sRGB-encoded.
 * Errors: ARGUMENT, MEMORY, UNSUPPORTED (TOON, SPLATS, and OVERDRAW without linear_output). */
psplat_result psplat_reference_draw(const psplat_reference_scene *scene, const psplat_view *view,
                                    psplat_reference_image *image, psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
