/* SPDX-License-Identifier: MIT
 *
 * frame.h - what a frame of the engine is seen by and lit by; both ways of drawing it share this.
 */
#ifndef ENGINE_FRAME_H
#define ENGINE_FRAME_H

#include "engine_matrix.h"
#include "shadow_map.h"

typedef struct frame {
    matrix view, projection;
    float sun_direction[3], sun[3]; /* in which it shines; irradiance */
    shadow_map shadows;             /* of the sun */
} frame;

#endif
