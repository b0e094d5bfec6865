/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * palette.c - what the meshes of a file look like, owned in one place.
 */
#include "texture.h"

#include <stdlib.h>

void psplat_palette_free(psplat_palette *palette) {
    if (!palette) return;
    for (size_t i = 0; i < palette->appearance_count; ++i) {
        free(palette->appearances[i].name);
        free(palette->appearances[i].extras);
    }
    for (size_t i = 0; i < palette->image_count; ++i) psplat_image_free(&palette->images[i]);
    free(palette->appearances);
    free(palette->images);
    free(palette->problem);
    *palette = (psplat_palette){0};
}
