/* SPDX-License-Identifier: MIT
 *
 * images.h - the images of a model's materials as textures on the GPU (spec 3.11).
 */
#ifndef PHONGSPLAT_RENDERER_IMAGES_H
#define PHONGSPLAT_RENDERER_IMAGES_H

#include "renderer/renderer.h"

/* Loads the images that batches with texture coordinates use through the host's psplat_images, each
 * once for colours and once for other numbers, and stores them in the model. Without a loader there
 * are none. GL's state is as before whenever the host is called, and afterwards. On failure what
 * was loaded is in the model. Errors: MEMORY, RANGE (an image has more pixels than GL takes),
 * ARGUMENT (the host returned no pixels), GRAPHICS, and those of psplat_images.load. */
psplat_result psplat_model_load_images(psplat_renderer *renderer, const psplat_asset *asset,
                                       psplat_model *model, psplat_error *error);

/* Sets out->textures, out->maps, out->samplers and the transforms of out->material. */
void psplat_model_use_images(psplat_renderer *renderer, const psplat_model *model,
                             const psplat_batch *batch, psplat_model_batch *out);

/* Deletes the model's images, and releases textures of the host. */
void psplat_model_drop_images(psplat_renderer *renderer, psplat_model *model);

#endif
