/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * proxy.h - a mesh of fewer triangles that is proven to lie near its source.
 */
#ifndef PHONGSPLAT_MESH_PROXY_H
#define PHONGSPLAT_MESH_PROXY_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#include <stddef.h>
#include <stdint.h>

/* A mesh that stands for its source where only distances are asked for. Whatever lies within x of
 * the proxy lies within x + deviation of the source. Zero-initialise it. */
typedef struct psplat_proxy {
    psplat_mesh mesh; /* positions and triangles alone; no triangles where none pays */
    double deviation; /* no point of the proxy is farther from the source; a length, up to
                         rounding, some 1e-12 of the coordinates */
    size_t kept;      /* triangles of the source that the proxy has, since nothing simpler could
                         be proven there */
    size_t unproven;  /* simpler triangles that were left out for that */
} psplat_proxy;

/* Simplifies a mesh and proves each triangle of the result: it is within most (a length, > 0) of
 * the source, or else the triangles of the source around it stay. The proxy stays empty where the
 * source would have less than least_gain (> 1) times its triangles, and for point sets. Equal input
 * gives equal results. Fails only with PSPLAT_ERROR_MEMORY; *proxy is then empty. */
psplat_result psplat_proxy_build(const psplat_mesh *source, double most, double least_gain,
                                 psplat_proxy *proxy);

/* The memory of searches for bounds. Searches with a stamp of their own share it. */
typedef struct psplat_proxy_search {
    const psplat_mesh *source;
    const uint32_t
        *neighbors;         /* triangle_count x 3: the triangle across edge 3 t + k, which runs from
                               corner k to the next, or PSPLAT_NONE where there is not exactly one */
    double most;            /* a length, > 0: greater bounds are not looked for */
    uint32_t *visited;      /* of each triangle of the source, the last search that saw it */
    uint32_t stamp;         /* of the next search; no triangle has it yet */
    uint32_t *stack;        /* the triangles that the last search saw; the caller frees it */
    size_t count, capacity; /* of the stack */
} psplat_proxy_search;

/* Bounds the distance from all points of a triangle with these three vertices of the source to the
 * source. start is a triangle of the source at the first of them. *deviation is HUGE_VAL where it
 * is more than search->most or cannot be proven. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_proxy_bound(psplat_proxy_search *search, const uint32_t corners[3],
                                 uint32_t start, double *deviation);

void psplat_proxy_free(psplat_proxy *proxy);

#endif
