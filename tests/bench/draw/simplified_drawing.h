/* SPDX-License-Identifier: MIT
 *
 * simplified_drawing.h - the mesh that a user would draw instead of splats: the source, simplified
 * by gltfpack (meshoptimizer) as far as its pictures are no worse than those of the splats.
 */
#ifndef PHONGSPLAT_BENCH_SIMPLIFIED_DRAWING_H
#define PHONGSPLAT_BENCH_SIMPLIFIED_DRAWING_H

#include "source_drawing.h"

/* What is compared: splats with their source. */
typedef struct simplified_desc {
    psplat_host *host;
    const subject *subject;
    const draw_method *splats, *source_drawing;
    const mesh *source;
    const char *gltfpack; /* the program */
    int size;             /* of the pictures, pixels */
} simplified_desc;

typedef struct simplified {
    mesh mesh;                            /* release it with mesh_free; it must not move */
    double splat_error, simplified_error; /* quality.image, percent of white */
} simplified;

/* Finds the coarsest mesh whose pictures from six sides (quality.h) differ from the source's no
 * more than those of the splats, to a 32nd of its triangles, by bisection: errors rise with
 * simplification but for small steps. Ends the program with a message where gltfpack fails or even
 * its finest mesh is worse. */
void simplified_read(const simplified_desc *desc, simplified *result);

#endif
