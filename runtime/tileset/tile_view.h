/* SPDX-License-Identifier: MIT
 *
 * tile_view.h - a view in the space of a tileset: what of it may be visible, and how many pixels a
 * length takes.
 */
#ifndef PHONGSPLAT_TILESET_TILE_VIEW_H
#define PHONGSPLAT_TILESET_TILE_VIEW_H

#include "tileset/volume.h"

#include <phongsplat/tiles.h>

typedef struct psplat_tile_camera {
    double planes[6][4]; /* plane . (x, y, z, 1) >= 0 inside the view, which is grown by a pixel */
    double eye[3];       /* for perspective views */
    double direction[3]; /* for orthographic views: away from the eye, of unit length */
    int is_perspective;
    psplat_culling culling;
    double depth[4]; /* depth . (x, y, z, 1) is w of clip space */
    double near;     /* least w in front of the near plane */
    double slant;    /* w of visible points is at least this times their distance from the eye */
    double focal;    /* pixels of a unit at w = 1, along the image plane */
    double area;     /* of the view, pixels */
} psplat_tile_camera;

/* Computes a camera. Errors: ARGUMENT. */
psplat_result psplat_tile_camera_set(psplat_tile_camera *camera, const psplat_tiles_view *view,
                                     psplat_error *error);

/* Returns 0 where nothing in the volume is in the view. It may return 1 for some that are not. */
int psplat_tile_camera_sees(const psplat_tile_camera *camera, const psplat_tile_volume *volume);

/* Returns 1 where surfaces in the volume whose normals are in the cone are seen from behind alone.
 */
int psplat_tile_camera_sees_backs(const psplat_tile_camera *camera,
                                  const psplat_tile_volume *volume, const double cone[4]);

/* Returns how many pixels a unit of length has at the nearest point of the volume that may be
 * visible, along the image plane; infinity where that is not bounded. */
double psplat_tile_camera_scale(const psplat_tile_camera *camera, const psplat_tile_volume *volume);

#endif
