/* SPDX-License-Identifier: MIT
 *
 * scene_asset.h - small assets for tests, made in memory through psplat_glb_write, or by
 * scene_curved.h where splats are curved or textured or have bent clip lines, and read back through
 * psplat_asset_open_memory. A scene is plain data: take a ready-made one, change what the
 * test is about, open it, free it.
 *
 *     scene s = scene_sphere(500, 1.0f);
 *     s.material.base_color[0] = 0.5f;
 *     psplat_asset *asset = scene_open(&s);
 *     scene_free(&s);
 */
#ifndef PHONGSPLAT_TEST_SCENE_ASSET_H
#define PHONGSPLAT_TEST_SCENE_ASSET_H

#include <phongsplat/phongsplat.h>

typedef struct scene {
    psplat_splat *splats; /* allocated with malloc; in any order of clip_count */
    size_t count;
    psplat_material material;    /* default: white, metallic 0, roughness 0.5, single-sided */
    psplat_kernel kernel;        /* default: psplat's default kernel */
    float depth_tolerance;       /* default: 1 % of the size */
    int has_color;               /* default: 0, and color 1 1 1 1 */
    double origin[3];            /* translation of the node */
    psplat_texcoord *texcoords;  /* count, allocated with malloc; NULL: the splats have none */
    const psplat_pixels *images; /* image_count, with their rgba; material.textures refers to them,
                                    with transforms of translation, rotation and scale */
    size_t image_count;
    uint32_t seam_lines; /* default: 0; of each splat's lines the last so many are seams, or all */
    int flat_is_curved;  /* default: 0; 1: flat splats lie in curved primitives */
} scene;

/* Returns count splats at the origin with unit axes along x, y, z and radius 1, white. */
scene scene_blank(size_t count);

/* Returns one disc of the given radius around the origin in the plane z = 0, facing +z. */
scene scene_disc(float radius);

/* Returns count round splats that overlap without a hole. Their centres lie on a Fibonacci sphere
 * around the origin; centre normals and linear normal fields are those of the sphere. */
scene scene_sphere(size_t count, float radius);

/* Returns six splats, each clipped by four lines to one face of the cube |x|, |y|, |z| <= half. */
scene scene_cube(float half);

/* Returns count ellipses in the unit cube with random centres, axes, radii (ratio up to 10),
 * normals, gradients, colours and 0 to max_clip_lines clip lines, all of which keep the centre. */
scene scene_ellipses(size_t count, uint32_t max_clip_lines, uint32_t seed);

/* These return the scene as a GLB, allocated with malloc and owned by the caller, and as an opened
 * asset. Both end the program with a message on stderr when that fails, because a test could not go
 * on. */
uint8_t *scene_glb(const scene *s, size_t *size);
psplat_asset *scene_open(const scene *s);

/* Gives a scene without textures coordinates of about an image a splat, and all textures with one
 * image of 2 x 2 pixels. */
void scene_add_textures(scene *s);

/* Decodes the images of such assets: psplat_images for renderers, and the pixels of one image,
 * which belong to the asset. */
psplat_images scene_images(void);
psplat_pixels scene_pixels(const psplat_asset *asset, size_t image);

void scene_free(scene *s);

/* Gives a splat the shape of its normal field (spec 3.4), or each splat of a scene. */
void scene_curve_splat(psplat_splat *splat);
void scene_curve(scene *s);

/* Sets a splat's rotation so that U and V are the given orthonormal axes. */
void scene_set_axes(psplat_splat *splat, const double u[3], const double v[3]);

/* Returns a uniform random number in 0 ... 1 from a small generator (xorshift32), whose state must
 * not be 0. */
float scene_random(uint32_t *state);

#endif
