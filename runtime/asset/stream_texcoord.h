/* SPDX-License-Identifier: MIT
 *
 * stream_texcoord.h - what the texture coordinates of a splat in a stream say about those of a
 * later one (spec 3.12).
 */
#ifndef PHONGSPLAT_ASSET_STREAM_TEXCOORD_H
#define PHONGSPLAT_ASSET_STREAM_TEXCOORD_H

#include <stdint.h>

/* Texture coordinates over the plane of a splat. */
typedef struct psplat_stream_texcoord {
    double center[3];                /* units of POSITION */
    double axes[3][3];               /* U, V and N */
    double radius[2];                /* units of POSITION */
    double along[2][2], bends[3][2]; /* the change with u and v, and with uu, uv and vv */
} psplat_stream_texcoord;

/* Finds the axes of an octahedral code of so many bits and of a turn in half turns. */
void psplat_stream_texcoord_axes(const int32_t code[2], uint32_t bits, double turn,
                                 double axes[3][3]);

/* Predicts along of a splat, of which all else is known, from another one. */
void psplat_stream_texcoord_slopes(const psplat_stream_texcoord *from,
                                   const psplat_stream_texcoord *to, double along[2][2]);

/* Predicts how far the coordinates at a splat's centre differ from those at another's. */
void psplat_stream_texcoord_move(const psplat_stream_texcoord *from,
                                 const psplat_stream_texcoord *to, double move[2]);

/* Rounds a prediction in steps, which is limited to -most ... most; what is none becomes 0. */
int32_t psplat_stream_texcoord_round(double prediction, int32_t most);

#endif
