/* SPDX-License-Identifier: MIT
 *
 * chunk.h - chunks for frustum and backface culling: 256 consecutive splats with a bounding sphere
 * and a cone around their normals. Chunks outside the view or seen from behind are left out before
 * any vertex is computed.
 */
#ifndef PHONGSPLAT_CORE_CHUNK_H
#define PHONGSPLAT_CORE_CHUNK_H

#include <phongsplat/phongsplat.h>

enum { PSPLAT_CHUNK_SPLATS = 256 };

/* The bounds of chunk i, which has the splats 256 i ... 256 i + 255 as far as there are that many.
 * All are in object space. */
typedef struct psplat_chunk {
    float center[3], radius; /* bounding sphere of the unclipped ellipses or curved patches,
                                without their walls (spec 5.1) */
    float axis[3], cosine;   /* axis . n >= cosine for N of each flat splat and each unit normal of
                                the surface of a curved one, axis being of length 1; where cosine is
                                below 0 there is no cone */
} psplat_chunk;

/* A camera in the object space of chunks. */
typedef struct psplat_chunk_view {
    double planes[6][4]; /* plane . (x, y, z, 1) >= 0 inside the view; xyz has length 1 */
    double eye[3];       /* for perspective views */
    double direction[3]; /* for orthographic views: unit view direction, away from the eye */
    int is_perspective;
    int is_culled; /* 1: backs are not seen */
} psplat_chunk_view;

/* Returns the number of chunks of so many splats. */
size_t psplat_chunk_count(size_t splat_count);

/* Computes the bounds of all chunks; chunks has psplat_chunk_count(splat_count) entries. */
void psplat_chunks_find(const psplat_splat *splats, size_t splat_count, psplat_chunk *chunks);

/* Sets a view. clip is the matrix from object to clip space and modelview_inverse that from eye to
 * object space. margin is the distance by which the filter may widen a splat, in halves of the
 * viewport's width and height. direction is the view direction of orthographic views in eye space,
 * and 0 0 0 in perspective. */
void psplat_chunk_view_set(psplat_chunk_view *view, const double clip[16],
                           const double modelview_inverse[16], const double margin[2],
                           int is_perspective, const double direction[3], int is_culled);

/* Returns 0 where no splat of the chunk can be visible. It may return 1 for some that are not. */
int psplat_chunk_is_visible(const psplat_chunk *chunk, const psplat_chunk_view *view);

/* Returns 1 where a sphere in object space lies between the four sides of the view, which the
 * margin has moved outwards. */
int psplat_sphere_is_between_sides(const float center[3], float radius,
                                   const psplat_chunk_view *view);

#endif
