/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * check.h - the strict validation of OBJ, OFF, PLY and STL files before OpenMesh reads them.
 *
 * OpenMesh's readers accept malformed files without a word. These passes refuse them, and rewrite
 * in memory what OpenMesh would misread.
 */
#ifndef PHONGSPLAT_IMPORT_CHECK_H
#define PHONGSPLAT_IMPORT_CHECK_H

#include <phongsplat/splat.h>

#include "source/source_file.h"

/* Each function fills the counts of source, and may rewrite its data. Error texts name the line of
 * a text file or the byte of a binary file. Errors: FORMAT, RANGE, UNSUPPORTED, NO_SPLATS, MEMORY.
 */
psplat_result psplat_check_obj(psplat_source *source, psplat_error *error);

psplat_result psplat_check_off(psplat_source *source, psplat_error *error);

psplat_result psplat_check_ply(psplat_source *source, psplat_error *error);

psplat_result psplat_check_stl(psplat_source *source, psplat_error *error);

#endif
