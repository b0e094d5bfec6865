/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * viewpoint.h - the camera and light of a picture of a whole model.
 */
#ifndef PHONGSPLAT_PICTURE_VIEWPOINT_H
#define PHONGSPLAT_PICTURE_VIEWPOINT_H

#include <phongsplat/phongsplat.h>

/* All zeros mean a view from the front at the distance at which the model fits. */
typedef struct psplat_viewpoint {
    double azimuth_degrees;   /* about +y; 0 looks along -z from the front, 90 from +x */
    double elevation_degrees; /* -90 ... 90, positive looks down */
    double distance;          /* multiples of that at which the bounding sphere fits; 0 means 1 */
} psplat_viewpoint;

/* Finds a bounding sphere of an asset's splats, scene units. Unlike psplat_asset_bounds it leaves
 * out what their clip lines cut away. */
void psplat_viewpoint_sphere(const psplat_asset *asset, double center[3], double *radius);

/* Does the same over the course of an animation, so that pictures at all of its times have the same
 * camera: the sphere is around the splats at nine times from 0 to its end. Errors: ARGUMENT, RANGE,
 * MEMORY, as of poses. */
psplat_result psplat_viewpoint_sphere_over(const psplat_asset *asset, size_t animation,
                                           double center[3], double *radius, psplat_error *error);

/* Sets view's matrices and light so that the sphere fills the picture, with the near and far planes
 * around the sphere. view's width and height must be set. */
void psplat_viewpoint_fit(const psplat_viewpoint *viewpoint, const double center[3], double radius,
                          psplat_view *view);

/* Narrows view, whose width and height are those of the whole picture, to a tile of width x height
 * pixels, whose left column is x and whose lowest row is y (row 0 is at the bottom). */
void psplat_viewpoint_crop(psplat_view *view, int x, int y, int width, int height);

#endif
