/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * view_directions.h - the cameras of the picture views, from all directions around the source.
 */
#ifndef PHONGSPLAT_VIEWS_VIEW_DIRECTIONS_H
#define PHONGSPLAT_VIEWS_VIEW_DIRECTIONS_H

#include <phongsplat/phongsplat.h>

/* Returns view number index, 0 ... PSPLAT_PICTURE_VIEWS - 1, of a sphere, for pictures of size x
 * size pixels. */
psplat_view psplat_view_directions_at(int index, const double center[3], double radius, int size);

#endif
