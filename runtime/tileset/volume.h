/* SPDX-License-Identifier: MIT
 *
 * volume.h - bounding volumes of tiles, as spheres and oriented boxes in the space of the tileset
 * with y up.
 */
#ifndef PHONGSPLAT_TILESET_VOLUME_H
#define PHONGSPLAT_TILESET_VOLUME_H

/* A box with orthonormal axes, or a sphere where half is 0 0 0 and round is its radius. */
typedef struct psplat_tile_volume {
    double center[3];
    double axis[3][3]; /* unit vectors, at right angles */
    double half[3];    /* half the extent along each of them */
    double round;      /* by which the box is grown to all sides, with round edges */
} psplat_tile_volume;

/* A point (x, y, z) of a tileset, with z up, becomes (x, z, -y). */
void psplat_tile_y_up(const double z_up[3], double y_up[3]);

/* Turns a transform between spaces with z up into one between spaces with y up. */
void psplat_tile_transform_y_up(const double z_up[16], double y_up[16]);

/* Returns the greatest factor by which an affine transform stretches lengths, and the least: of
 * transforms with orthogonal columns (rotations, scales) exactly, of others a bound from outside.
 */
double psplat_tile_stretch(const double transform[16]);
double psplat_tile_shrink(const double transform[16]);

/* Returns 1 where a transform is a rotation, perhaps mirrored, times one scale and a translation.
 */
int psplat_tile_is_similarity(const double transform[16]);

/* Makes a volume from the numbers of 3D Tiles (z up): 12 of a box, which a transform (y up) moves,
 * stretches and shears; a box that is sheared becomes the axis-aligned one around it. */
void psplat_tile_volume_box(const double box[12], const double transform[16],
                            psplat_tile_volume *volume);

/* The same of the 4 numbers of a sphere. */
void psplat_tile_volume_sphere(const double sphere[4], const double transform[16],
                               psplat_tile_volume *volume);

/* Makes a sphere around a region of the WGS 84 ellipsoid: west, south, east, north in radians,
 * least and greatest height in metres. Regions are not transformed (3D Tiles 1.1). */
void psplat_tile_volume_region(const double region[6], psplat_tile_volume *volume);

/* Returns the distance of a point from the volume, 0 inside. */
double psplat_tile_distance(const psplat_tile_volume *volume, const double point[3]);

/* Returns how far the volume reaches from its center along a direction, times its length. */
double psplat_tile_reach(const psplat_tile_volume *volume, const double direction[3]);

/* Returns the radius of the sphere around the volume and its center. */
double psplat_tile_radius(const psplat_tile_volume *volume);

#endif
