/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_points.h - the reader of point sets in OBJ files.
 */
#ifndef PHONGSPLAT_IMPORT_OBJ_POINTS_H
#define PHONGSPLAT_IMPORT_OBJ_POINTS_H

#include <phongsplat/splat.h>

#include "points/points.h"
#include "source/source_file.h"

/* Reads the points of an OBJ that psplat_check_obj found to be a point set, with normals and
 * colours if it has any (obj_points.c says which). The caller frees the points, also after an
 * error. Errors: FORMAT and RANGE (a normal or a colour), MEMORY. */
psplat_result psplat_points_read_obj(psplat_source *source, psplat_points *points,
                                     psplat_error *error);

#endif
