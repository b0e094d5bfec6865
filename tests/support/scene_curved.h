/* SPDX-License-Identifier: MIT
 *
 * scene_curved.h - scenes with curved splats, bent clip lines or textures as files of version 3,
 * all of floats. It shares no code with the converter's writer of such files.
 */
#ifndef PHONGSPLAT_TEST_SCENE_CURVED_H
#define PHONGSPLAT_TEST_SCENE_CURVED_H

#include "scene_asset.h"

/* Returns 1 where a splat of the scene is curved or has a bent clip line. */
int scene_is_curved(const scene *s);

/* Does what scene_glb does. The shape of each splat has to be 0, that of its normal field (to
 * 1e-5), or one with x = y = 0 (spec 3.4). */
uint8_t *scene_curved_glb(const scene *s, size_t *size);

#endif
