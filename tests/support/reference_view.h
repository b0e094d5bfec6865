/* SPDX-License-Identifier: MIT
 *
 * reference_view.h - views for tests, and images that the reference rasteriser draws of them.
 * Matrices are column-major, angles in radians.
 */
#ifndef PHONGSPLAT_TEST_REFERENCE_VIEW_H
#define PHONGSPLAT_TEST_REFERENCE_VIEW_H

#include "scene_asset.h"

#include <phongsplat/reference.h>

#define CAMERA_PI 3.14159265358979323846

/* Returns a view of width x height pixels with unit matrices, a white light of irradiance pi from
 * +z, no ambient light and linear output. */
psplat_view camera_view(int width, int height);

/* Sets view->view. eye and target are in scene space; up is +y, unless that is the viewing
 * direction. */
void camera_look(psplat_view *view, const double eye[3], const double target[3]);

/* Sets view->projection; focal is the focal length in pixels, half_height in eye units. */
void camera_perspective(psplat_view *view, double focal, double near, double far);
void camera_parallel(psplat_view *view, double half_height, double near, double far);

/* What psplat_reference_draw computes. Every array is present unless a function says otherwise. */
typedef struct picture {
    int width, height;
    psplat_reference_image image;
} picture;

/* Ends the program with a message where drawing fails, because a test could not go on. Images of
 * assets of scene_asset.h are decoded where the scene has none. */
picture picture_of_scene(const psplat_reference_scene *from, const psplat_view *view);
picture picture_draw(const psplat_asset *asset, const double transform[16],
                     const psplat_view *view);
picture picture_of(const scene *s, const double transform[16], const psplat_view *view);
/* Has the arrays uv and splat alone, which takes a fraction of the time. */
picture picture_of_nearest(const psplat_reference_scene *from, const psplat_view *view);
void picture_free(picture *p);

size_t picture_covered(const picture *p); /* pixels */

#endif
