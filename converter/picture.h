/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture.h - from a model to a picture of it: where to look from, what was drawn as 8-bit pixels,
 * and PNG. Shared by the commands and by what compares pictures.
 */
#ifndef PHONGSPLAT_PICTURE_H
#define PHONGSPLAT_PICTURE_H

#include <phongsplat/phongsplat.h>

/* ---- viewpoint.c: where pictures are taken from -------------------------------------------- */

/* Zeros are a view from the front at the fitting distance. */
typedef struct psplat_viewpoint {
    double azimuth_degrees;   /* about +y; 0 looks along -z from the front, 90 from +x */
    double elevation_degrees; /* -90 ... 90, positive looks down */
    double distance;          /* in units of the distance at which the sphere fits */
} psplat_viewpoint;

/* A sphere around what an asset's splats show: unlike psplat_asset_bounds it leaves out what
 * their clip lines cut away. */
void psplat_viewpoint_sphere(const psplat_asset *asset, double center[3], double *radius);

/* Fills view's matrices and light so that the sphere fills width x height (which must be set), with
 * near and far planes around the sphere. */
void psplat_viewpoint_fit(const psplat_viewpoint *viewpoint, const double center[3], double radius,
                          psplat_view *view);

/* Narrows view, whose width and height are those of the whole picture, to the width x height pixels
 * from column x and row y (row 0 at the bottom) on. */
void psplat_viewpoint_crop(psplat_view *view, int x, int y, int width, int height);

/* ---- png.c -------------------------------------------------------------------------------- */

/* Encodes 8-bit sRGB, row 0 on top, 3 channels or 4 (straight alpha), into memory from malloc. */
psplat_result psplat_png_encode(const uint8_t *pixels, int width, int height, int channels,
                                uint8_t **data, size_t *size, psplat_error *error);

/* ---- picture.c: what was drawn, reduced to what is stored ---------------------------------- */

/* Averages blocks of factor x factor linear, premultiplied RGBA pixels (row 0 at the bottom) into
 * width x height sRGB-encoded pixels (row 0 on top) of 3 channels, or 4 with straight alpha. */
void psplat_picture_reduce(const float *rgba, int width, int height, int factor, int channels,
                           uint8_t *pixels);

#endif
