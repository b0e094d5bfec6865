/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fit_context.h - the surface, samples, limits and scratch memory of fits, and their threads.
 */
#ifndef PHONGSPLAT_FIT_FIT_CONTEXT_H
#define PHONGSPLAT_FIT_FIT_CONTEXT_H

#include <phongsplat/splat.h>

#include "features/neighborhood.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/crease_segments.h"
#include "mesh/distance.h"
#include "splats/splats.h"

#include <stdint.h>

/* The limits that each splat keeps. Lengths are in the mesh's units. */
typedef struct psplat_limits {
    double tolerance;        /* greatest distance between splat and surface */
    double crease_tolerance; /* greatest distance of a crease from the plane of a splat beside it */
    double crease_slack;     /* how far a splat may reach over a crease, within its plane */
    double margin;           /* how far a splat reaches beyond the samples that it covers */
    double normal_tolerance; /* greatest error of the normal field, radians; 0: unbounded */
    int constant_normals;    /* 1: normal fields have no gradients */
    int planar;              /* 1: all splats are flat */
    double color_tolerance;  /* greatest root mean square of a splat's colour error, parts of sRGB's
                                range; 0: unbounded */
    int constant_colors;     /* 1: colours have no gradients */
    /* For each of the first color_range_count samples, the least and the greatest of the 8 values
     * of a look (measure/color_errors.h) around it: no splat may be off that by more than the
     * tolerance there. The first is NaN where that does not matter. */
    const float (*color_ranges)[16];
    size_t color_range_count;
    double texture_tolerance; /* greatest error of texture coordinates, a length: how far a texture
                                 may slide over the surface; 0: unbounded, or no texture is kept */
    double texture_tolerance_texels; /* the same in texels of the material's largest texture; 0: it
                                        is not bounded so */
    const psplat_precision *precision; /* that lines and fields are rounded to; NULL: none are */
    double mesh_pull; /* 0 to 1: how much nearer to the mesh curved splats come where they move to
                         the grid of the precision (quantize_candidate.c) */
    int proven; /* 1: an exact check of the distance bound takes all points of a region, not some */
    double measured_tolerance; /* of drafts, which are measured at some points only; 0: the same */
    const psplat_distance *distance; /* to the mesh; NULL: only triangles of samples are measured */
    const psplat_distance *proxy;    /* to its proxy (mesh/proxy.h); NULL: it has none */
    double proxy_deviation;          /* of the proxy, a length */
} psplat_limits;

/* A sample of a cell, by its index into near.samples. */
typedef struct psplat_celled_sample {
    double p[3]; /* relative to the neighbourhood's origin */
    uint32_t near;
} psplat_celled_sample;

/* The memory of one thread that evaluates regions. Zero-initialise it. */
typedef struct psplat_scratch {
    psplat_neighborhood near;
    const struct psplat_site *site; /* where the neighbourhood was gathered */
    size_t near_count; /* the number of its samples in the surroundings of the last region */
    double (*uvh)[3];  /* near_count: parameters and heights in that region */
    uint32_t *covered; /* the samples that the region covers, indices into near.samples */
    uint32_t *cells;   /* near_count, for evaluate_near.c, as are the next */
    psplat_celled_sample *sorted;
    double (*uv)[2], (*slopes)[2]; /* parameters and local normals of the covered samples */
    double *heights;               /* of samples, for grow_candidate.c */
    psplat_segment *segments;
    size_t capacity, segment_capacity; /* of the arrays, and of segments */
} psplat_scratch;

/* Frees what the scratch owns, and zeroes it. */
void psplat_scratch_free(psplat_scratch *scratch);

/* What every fit needs: the surface and its samples, the limits, and scratch memory. Owns nothing.
 */
typedef struct psplat_fit_context {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_scratch *scratch; /* of this thread; NULL in functions that use all cores */
} psplat_fit_context;

/* Returns a context for searches that prove only what they find: with the limits (kept in draft) of
 * regions that are measured at some points only. */
psplat_fit_context psplat_fit_draft(const psplat_fit_context *context, psplat_limits *draft);

/* Returns how far normals may move the surfaces that psplat_fit_surface finds off the samples, a
 * length: those of the file may not be those of the shape, and those that are averaged over facets
 * where splats end at their edges are none of it. HUGE_VAL where neither is so. */
double psplat_most_normal_pull(const psplat_fit_context *context);

/* Calls visit with each index below count, on all cores. The context that visit gets has a scratch
 * of its thread. Fails with PSPLAT_ERROR_MEMORY where any visit fails. */
psplat_result psplat_fit_each(const psplat_fit_context *context, size_t count,
                              psplat_result (*visit)(const psplat_fit_context *context,
                                                     size_t index, void *user),
                              void *user);

#endif
