/* SPDX-License-Identifier: MIT
 *
 * phongsplat/reference.h - the reference rasteriser: a slow one in double precision that follows
 * schema/README.md section 5 step by step. It shares only splat.h and the input structs of
 * phongsplat.h with the renderer, whose shaders are tested against it.
 */
#ifndef PHONGSPLAT_REFERENCE_H
#define PHONGSPLAT_REFERENCE_H

#include "phongsplat.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The scene to draw. Zeros are the defaults of all members except the asset. */
typedef struct psplat_reference_scene {
    const psplat_asset *asset; /* not opened with psplat_asset_desc.only_draws */
    double transform[16];      /* applied after the asset's own node transforms; all zeros mean the
                                  identity */
    const psplat_environment_desc *environment; /* takes the place of psplat_view.environment, which
                                                   is ignored; NULL: there is none */
    const psplat_pixels *images; /* image_count decoded images, by psplat_texture.image - 1; a
                                    texture whose image is beyond them, or has no rgba, is left out.
                                    Each is at most 65536 texels wide and high */
    size_t image_count;
} psplat_reference_scene;

/* Per-pixel results. Each array holds width * height entries, row 0 at the bottom as in GL. The
 * caller provides the arrays; what belongs in an array that is NULL is not computed.
 *
 * The four ties say how near a pixel is to the opposite of a decision, so that tests can skip
 * pixels that single precision cannot decide. They are 1 where no decision is near. They consider
 * only splats that could contribute, which are those not hidden behind the pixel's visibility limit
 * min(t + epsilon) of spec 5.3. In flat and parameters mode the limit is the nearest splat; in the
 * other modes ties do not say how near the second splat is to the nearest one. Edges of shadows are
 * not ties. */
typedef struct psplat_reference_image {
    float *color;    /* 4 per pixel: RGB, encoded unless psplat_view.linear_output is 1, and A = 1
                         where the pixel is covered; all four are 0 elsewhere */
    double *depth;   /* window depth 0 ... 1 of spec 5.5; 1 where uncovered */
    double *uv;      /* 2 per pixel: (u, v) of the nearest splat; 0 where there is none */
    int32_t *splat;  /* index of the nearest splat, counted over all batches in draw order; -1 where
                        the ray meets no splat */
    uint32_t *count; /* splats blended into the pixel (at most 1 in flat and parameters mode) */
    double *tie; /* the least of these: distance to an edge, |1 - r| or to a line or seam, in (u, v)
                    or in pixels, whichever is less; |cosine| between the normal of a splat's
                    surface and the ray, which decides between front and back; and for a curved
                    splat the distance in pixels to its contour, where rays touch it (to first
                    order), or the square of the cosine where that is less, and those to where rays
                    begin to meet its wall (spec 5.1). A ray that misses the
                    splat beyond its contour ties if it would touch it inside its edges. With the
                    filter, edges are those of the ellipses that decide visibility and those of
                    the widened ones; the edge of a softened clip line is where its factor
                    becomes 0 */
    double *depth_tie;   /* least difference of window depth to the near plane, the far plane and
                            the visibility limit */
    double *epsilon_tie; /* least |t - limit| over the greatest epsilon of eq. (5); always 1 in flat
                            and parameters mode */
    double *alpha_tie;   /* least |alpha - alphaCutoff| of a fragment with an alpha mask */
} psplat_reference_image;

/* Draws a scene with the given view, of which x, y and environment are ignored; the projection may
 * be any invertible matrix. The arrays of image have view.width x view.height pixels. While it runs
 * it takes some 300 bytes a pixel from the C library, 43 bytes a texel of each image that is used,
 * and 500 bytes a splat where a light casts shadows. Where the materials of several batches meet in
 * a pixel, their factors are blended as COLOR_0 is (spec 5.4). Images should be small, because
 * shadows are found by rays and environments are integrated pixel by pixel. Values of the shadings
 * NORMAL, DEPTH and OVERDRAW are never sRGB-encoded. Textures are sampled without anisotropy, from
 * mipmaps that are exact means. Errors: ARGUMENT, MEMORY, UNSUPPORTED (TOON, SPLATS, and OVERDRAW
 * without linear_output). */
PSPLAT_EXPORT psplat_result psplat_reference_draw(const psplat_reference_scene *scene,
                                                  const psplat_view *view,
                                                  psplat_reference_image *image,
                                                  psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
