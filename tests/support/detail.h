/* SPDX-License-Identifier: MIT
 *
 * detail.h - scenes that fit the unit ball around the origin and are full of detail, so that they
 * alias where they are drawn small. Some 4000 splats each, the camera on the side of +z.
 */
#ifndef PHONGSPLAT_TEST_DETAIL_H
#define PHONGSPLAT_TEST_DETAIL_H

#include "scene_asset.h"

/* A sphere of 24 x 48 black and white fields, unlit: at 16 pixels, one is a third of a pixel
 * wide. */
scene detail_checkered(void);

/* A sphere with some 200 bumps, their flanks up to 55 degrees steep: at 16 pixels, one is a pixel
 * wide. */
scene detail_bumpy(void);

/* A torus that is turned from the camera by 60 degrees: silhouettes before its own surface. */
scene detail_torus(void);

/* A plate of black and white fields, unlit, that the camera sees at a grazing angle: 5 times as
 * wide as high, and so is each splat. */
scene detail_plate(void);

#endif
