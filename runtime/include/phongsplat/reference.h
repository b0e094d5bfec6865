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

/* Per-pixel results; each array holds width * height entries, row 0 at the bottom as in GL. The
 * caller provides the arrays; a NULL array is not computed. */
typedef struct psplat_reference_image {
    float *color;    /* 4 per pixel: RGB as psplat_view.linear_output asks, A = 1 where covered */
    double *depth;   /* window depth 0 ... 1 of spec 5.5; 1 where uncovered */
    double *uv;      /* 2 per pixel: (u, v) of the nearest splat */
    int32_t *splat;  /* index of the nearest splat, counted over all batches in draw order; -1 */
    uint32_t *count; /* splats blended into the pixel (1 at most in flat mode) */
    double *tie; /* how far the pixel is from a different decision (>= 0): least of |1 - r| and
                    |clip distance| * least radius in pixels over the splats near the pixel, and of
                    |depth difference - epsilon| / epsilon over the splats covering it; tests skip
                    pixels whose tie is below what float32 can decide */
} psplat_reference_image;

/* Draws the asset's batches with the given transform (NULL: identity) and view; view.x and view.y
 * are ignored. image describes view.width x view.height pixels. Errors: ARGUMENT, MEMORY. */
psplat_result psplat_reference_draw(const psplat_asset *asset, const double transform[16],
                                    const psplat_view *view, psplat_reference_image *image,
                                    psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
