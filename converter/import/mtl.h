/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mtl.h - the reader of MTL files, the material libraries of OBJ files.
 */
#ifndef PHONGSPLAT_IMPORT_MTL_H
#define PHONGSPLAT_IMPORT_MTL_H

#include <phongsplat/splat.h>

#include "material/source_materials.h"
#include "source/source_file.h"

/* Reads the materials of an OBJ: one for each name that the OBJ uses, in the order of these names,
 * and one more for faces without a material. Images are read from the library's directory. Where a
 * file cannot be read, the text of the problem is stored in materials or in the image. base has the
 * values of a material where the library says nothing. The caller frees *materials, also after an
 * error. Errors: MEMORY. */
psplat_result psplat_mtl_read(const psplat_source *source, const psplat_material *base,
                              psplat_source_materials *materials, psplat_error *error);

#endif
