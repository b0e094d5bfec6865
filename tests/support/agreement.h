/* SPDX-License-Identifier: MIT
 *
 * agreement.h - draws the same asset with the renderer and with the reference rasteriser, and says
 * by how much they differ. Pixels that a decision of the reference is too near to are skipped and
 * counted.
 */
#ifndef PHONGSPLAT_TEST_AGREEMENT_H
#define PHONGSPLAT_TEST_AGREEMENT_H

#include "reference_view.h"

#include <phongsplat/host.h>

typedef struct gpu {
    psplat_host *host;
    psplat_renderer *renderer;
} gpu;

/* Ends the program with a message where there is no context or renderer. */
gpu gpu_open(psplat_api api);
void gpu_close(gpu *g);

/* Group fixtures for cmocka: *state is a gpu, one at a time. */
int gpu_setup_gl(void **state);
int gpu_setup_gles(void **state);
int gpu_teardown(void **state);

/* A pixel is skipped where a tie of psplat_reference_image is below these. */
typedef struct agreement_ties {
    double edge, depth, epsilon;
} agreement_ties;

typedef struct agreement {
    size_t covered;    /* pixels that the reference covers */
    size_t skipped;    /* pixels not compared */
    size_t mismatches; /* compared pixels that one covers and the other does not */
    size_t other;      /* parameters mode: compared pixels that show another splat */
    double color;      /* largest difference of a colour channel (0 in parameters mode) */
    double uv;         /* parameters mode: largest difference of u or v */
    double depth;      /* largest difference of window depth */
    /* The same where the nearest splat shows in neither or only one direction beside the pixel:
     * there (u, v) may change by more than 1 a pixel, and magnifies the pixel's own position error.
     */
    double thin_uv, thin_depth;
} agreement;

/* transform may be NULL. is_float: compares in a float target, otherwise in RGBA8. */
agreement agreement_measure(gpu *g, const psplat_asset *asset, const double transform[16],
                            const psplat_view *view, int is_float, const agreement_ties *ties);

/* The same of a scene, with its environment. */
agreement agreement_measure_scene(gpu *g, const psplat_reference_scene *scene,
                                  const psplat_view *view, int is_float,
                                  const agreement_ties *ties);

/* Largest of each figure, sums of the counts. */
void agreement_add(agreement *total, const agreement *a);

#endif
