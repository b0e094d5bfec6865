/* SPDX-License-Identifier: MIT
 *
 * agreement.h - draws the same asset with the renderer and with the reference rasteriser and
 * measures by how much they differ. Pixels for which a decision of the reference is too close to
 * call (a tie) are skipped and counted.
 *
 * Mesa's software rasteriser draws, whose figures are the same everywhere, unless PSPLAT_TEST_GPU
 * is set in the environment. GPUs round the places of vertices to a grid before they interpolate,
 * so that a picture may be shifted by up to half a step of the grid. There a difference counts as
 * far as it exceeds those of the reference's own pictures moved by a step, and a pixel which may
 * show other splats in those is left out.
 */
#ifndef PHONGSPLAT_TEST_AGREEMENT_H
#define PHONGSPLAT_TEST_AGREEMENT_H

#include "reference_view.h"

#include <phongsplat/host.h>

typedef struct gpu {
    psplat_host *host;
    psplat_renderer *renderer;
    double vertex_step; /* pixels: of the grid of vertices; 0 where places are not rounded */
} gpu;

/* Ends the program with a message where there is no context or renderer, or where PSPLAT_TEST_GPU
 * asks for a GPU and there is none. */
gpu gpu_open(psplat_api api);
void gpu_close(gpu *g);

/* Group fixtures for cmocka: *state is a gpu, of which there is one at a time. */
int gpu_setup_gl(void **state);
int gpu_setup_gles(void **state);
int gpu_teardown(void **state);

/* A pixel is skipped where a tie of psplat_reference_image is below one of these. */
typedef struct agreement_ties {
    double edge, depth, epsilon;
} agreement_ties;

typedef struct agreement {
    size_t covered;    /* pixels that the reference covers */
    size_t skipped;    /* pixels that are ties */
    size_t left_out;   /* others that rounded vertices may change; not compared, either */
    size_t mismatches; /* compared pixels that only one of them covers */
    size_t other;      /* parameters mode: compared pixels that show different splats */
    double color;      /* largest difference of a colour channel; 0 in parameters mode */
    double uv;         /* parameters mode: largest difference of u or v */
    double depth;      /* largest difference of window depth */
    /* The same differences in pixels whose nearest splat shows in none or only one direction beside
     * the pixel, or where the reference's (u, v) change by more than 1 a pixel, as they do without
     * a bound towards a contour. That change, and the depth's, magnifies the error of a pixel's
     * position, which is some 1e-5 pixels. agreement_measure_modes alone tells these pixels apart:
     * elsewhere their differences count for uv and depth. */
    double thin_uv, thin_depth;
} agreement;

/* Compares an asset. transform may be NULL. is_float: in a float target, otherwise in RGBA8. */
agreement agreement_measure(gpu *g, const psplat_asset *asset, const double transform[16],
                            const psplat_view *view, int is_float, const agreement_ties *ties);

/* Compares a scene with its environment in the same way. */
agreement agreement_measure_scene(gpu *g, const psplat_reference_scene *scene,
                                  const psplat_view *view, int is_float,
                                  const agreement_ties *ties);

/* Compares an asset in all modes of the set modes (1u << PSPLAT_MODE_PHONG and so on), whatever the
 * view's, and adds what it finds. Which pixels are thin does not depend on the mode, and takes two
 * more pictures of the reference. */
agreement agreement_measure_modes(gpu *g, const psplat_asset *asset, const double transform[16],
                                  const psplat_view *view, unsigned modes, int is_float,
                                  const agreement_ties *ties);

enum { AGREEMENT_ALL_MODES = (1u << PSPLAT_MODE_COUNT) - 1 };

/* Adds a to total: the largest of each difference, the sum of each count. */
void agreement_add(agreement *total, const agreement *a);

#endif
