/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_materials.c - releases the materials of a source file and their textures.
 */
#include "material/source_materials.h"

#include "material/image.h"

#include <stdlib.h>

void psplat_source_materials_free(psplat_source_materials *materials) {
    if (!materials) return;
    for (size_t i = 0; i < materials->source_material_count; ++i) {
        free(materials->source_materials[i].name);
        free(materials->source_materials[i].extras);
    }
    for (size_t i = 0; i < materials->image_count; ++i) psplat_image_free(&materials->images[i]);
    free(materials->source_materials);
    free(materials->images);
    free(materials->problem);
    *materials = (psplat_source_materials){0};
}
