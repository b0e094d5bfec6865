/* SPDX-License-Identifier: MIT
 *
 * cone.h - cones of normals: an axis of unit length and the cosine of the angle to it that no
 * normal exceeds. A cosine below -1 says that nothing is known.
 */
#ifndef PHONGSPLAT_TILESET_CONE_H
#define PHONGSPLAT_TILESET_CONE_H

/* Enlarges cone so that it holds other, too. */
void psplat_tile_cone_add(double cone[4], const double other[4]);

#endif
