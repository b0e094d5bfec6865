/* SPDX-License-Identifier: MIT
 *
 * detail.h - scenes that fit the unit sphere around the origin and are full of detail, so that they
 * alias where they are drawn small. Each has some 4000 splats and is seen from the side of +z.
 */
#ifndef PHONGSPLAT_TEST_DETAIL_H
#define PHONGSPLAT_TEST_DETAIL_H

#include "scene_asset.h"

/* Makes an unlit sphere of 24 x 48 black and white fields. At 16 pixels a field is a third of a
 * pixel wide. */
scene detail_checkered(void);

/* Makes a sphere with some 200 bumps, whose flanks are up to 55 degrees steep. At 16 pixels a bump
 * is a pixel wide. */
scene detail_bumpy(void);

/* Makes a torus that is turned from the camera by 60 degrees, so that its silhouettes lie in front
 * of its own surface. */
scene detail_torus(void);

/* Makes an unlit plate of black and white fields that the camera sees at a grazing angle: the plate
 * and each of its splats appear 5 times as wide as high. */
scene detail_plate(void);

#endif
