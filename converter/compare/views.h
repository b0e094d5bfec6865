/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * views.h - where a gallery's pictures are taken from.
 */
#ifndef PHONGSPLAT_VIEWS_H
#define PHONGSPLAT_VIEWS_H

#include "compare.h"

/* View index, 0 ... PSPLAT_GALLERY_VIEWS - 1, of a sphere, in pictures of size x size pixels. */
psplat_view psplat_views_at(int index, const double center[3], double radius, int size);

#endif
