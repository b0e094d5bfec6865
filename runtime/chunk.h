/* SPDX-License-Identifier: MIT
 *
 * chunk.h - consecutive splats with a sphere around them and a cone around their normals, so that
 * what lies outside the view or is seen from behind is left out before any vertex is computed.
 */
#ifndef PHONGSPLAT_CHUNK_H
#define PHONGSPLAT_CHUNK_H

#include <phongsplat/phongsplat.h>

enum { PSPLAT_CHUNK_SPLATS = 256 };

/* Of chunk i: splats 256 i ... 256 i + 255, as far as there are as many. Object space. */
typedef struct psplat_chunk {
    float center[3], radius;
    float axis[3], cosine; /* each N has at least this cosine with axis; below 0: no cone */
} psplat_chunk;

/* What a chunk is judged by: a camera in the chunk's object space. */
typedef struct psplat_chunk_view {
    double planes[6][4]; /* inside: plane . (x, y, z, 1) >= 0; xyz normalised */
    double eye[3];       /* perspective */
    double direction[3]; /* orthographic: unit, away from the eye */
    int is_perspective;
    int is_culled; /* backs are not seen */
} psplat_chunk_view;

size_t psplat_chunk_count(size_t splat_count);

/* chunks has psplat_chunk_count(splat_count) entries. */
void psplat_chunks_find(const psplat_splat *splats, size_t splat_count, psplat_chunk *chunks);

/* clip: object to clip space; modelview_inverse: eye to object space. margin: what the filter may
 * add around a splat, in halves of the viewport (x, y). direction: as psplat_chunk_view in eye
 * space, for orthographic views. */
void psplat_chunk_view_set(psplat_chunk_view *view, const double clip[16],
                           const double modelview_inverse[16], const double margin[2],
                           int is_perspective, const double direction[3], int is_culled);

/* 0 where no splat of the chunk can show. */
int psplat_chunk_is_visible(const psplat_chunk *chunk, const psplat_chunk_view *view);

#endif
