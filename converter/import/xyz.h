/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * xyz.h - the reader of point sets as text.
 */
#ifndef PHONGSPLAT_IMPORT_XYZ_H
#define PHONGSPLAT_IMPORT_XYZ_H

#include <phongsplat/splat.h>

#include "points/points.h"
#include "source/source_file.h"

/* Reads a point set with normals and colours if it has any (xyz.c lists the columns); the text is
 * changed. The caller frees the points, also after an error. Errors: FORMAT, MEMORY. */
psplat_result psplat_points_read_xyz(psplat_source *source, psplat_points *points,
                                     psplat_error *error);

#endif
