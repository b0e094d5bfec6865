/* SPDX-License-Identifier: MIT
 *
 * layout.h - the texture layouts, texture units and pass numbers that the shaders and the runtime
 * share. It has preprocessor lines and comments only, so that it is both valid C and valid GLSL.
 */
#ifndef PHONGSPLAT_LAYOUT_H
#define PHONGSPLAT_LAYOUT_H

/* The passes of the splat shaders. All but the first write to render targets, which the resolve
 * pass reads. */
#define PSPLAT_PASS_VISIBILITY 0 /* depth alone, shifted by epsilon (spec 5.3) */
#define PSPLAT_PASS_NORMALS 1    /* normals, colours and materials, to be lit once per pixel */
#define PSPLAT_PASS_RADIANCE 2   /* splats lit one by one (spec 5.7) */
#define PSPLAT_PASS_PARAMETERS 3 /* u, v and index of the nearest splat */

/* How far down the wall under the rim of a curved splat reaches, and how far behind it what it
 * hides begins, in depth tolerances (spec 5.1 and 5.3). */
#define PSPLAT_WALL 0.25
#define PSPLAT_WALL_SHIFT 8.0

/* The greatest number of shadow maps, which lie side by side in one texture. */
#define PSPLAT_SHADOW_COUNT 4

/* The greatest number of lights that the resolve pass hands on from vertices to fragments. There
 * are 15 vectors for that in GLES 3.0, of which gl_FragCoord takes 1 (GLSL ES 3.00, section 11),
 * other uniforms take 9 and a light 2. */
#define PSPLAT_HANDED_ON_LIGHTS 2

/* Which splats of a curved batch a program draws: all; those that no clip line cuts, without lines;
 * the others. */
#define PSPLAT_PART_ALL 0
#define PSPLAT_PART_UNCUT 1
#define PSPLAT_PART_CUT 2

/* Splats lie in rows of an RGBA32F texture, 512 in each. With 4 texels a splat a row is 2048 texels
 * wide, the least size that GLES 3.0 guarantees; where a splat has 5 of them, rows have 256 splats.
 *
 *     texel 0: center x y z, ratio of radii r_v / r_u
 *     texel 1: quaternion x y z w times sqrt(r_u): a rotation matrix is quadratic in its
 *              quaternion, so the matrix of this one is r_u times the axes
 *     texel 2: normal field at the center and its gradient (x, y, alpha, beta of spec 3.5)
 *     texel 3: linear colour and gamma, in batches that have either
 *     last:    alpha, beta, gamma of the surface, in curved batches that have shapes of their own
 *              (spec 3.4); in the other curved batches the surface is that of the normal field
 *
 * Clip lines (a, b, c) lie in rows of an RGB32F texture, clip_count texels a splat, seams
 * (spec 3.6) after the others; where some of a batch's lines are bent, of an RGBA32F texture (a, b,
 * c, kappa). Finishes (the parts of a material that vary over a batch, spec 3.10) lie in another
 * one, up to 4 texels a splat: occlusion, roughness, metallic; emissive; change of colour with u;
 * change of colour with v. The PSPLAT_FINISH_ bits say which of them a batch has.
 *
 * Texture coordinates (spec 3.11) lie in rows of an RGB32F texture, 2 texels a splat, or 4 where
 * they have a second order: T0, T_u, T_v, T_uu, T_uv, T_vv, two numbers each. Where splats have
 * colours it is an RGBA32F texture, and the fourth numbers are the alpha of COLOR_0. */
#define PSPLAT_SPLAT_ROW_BITS(is_wide, has_shape) (9 - (is_wide) * (has_shape))
#define PSPLAT_SPLAT_TEXELS 3
#define PSPLAT_FINISH_SURFACE 1
#define PSPLAT_FINISH_EMISSIVE 2
#define PSPLAT_FINISH_GRADIENT 4 /* two texels */
#define PSPLAT_FINISH_COLOR 8    /* texel 3 of the splats holds a colour */

/* The vertex attributes of the splat passes. All of them are of instances: an instance is a run of
 * consecutive splats of a batch, as an item places it (psplat_instance).
 *
 *     MODELVIEW  the three rows of the matrix from object to eye space
 *     NORMAL     the three rows of the matrix for normals, each with a fourth number: epsilon of
 *                eq. (5) without its cosine; what turns lengths of eye space into those of object
 *                space, on average; the factor of weights (1 - psplat_item.fade)
 *     FIRST      two integers: the run's first splat; the batch's first splat, counted over all
 *                batches of all items, of which the sign bit is set where a side of the view may
 *                cut the run */
#define PSPLAT_ATTRIBUTE_MODELVIEW 0
#define PSPLAT_ATTRIBUTE_NORMAL 3
#define PSPLAT_ATTRIBUTE_FIRST 6
#define PSPLAT_ATTRIBUTE_COUNT 7

/* Texture units of the splat passes and of the resolve pass. The resolve pass reads the colour
 * attachments from units 0 to 3. */
#define PSPLAT_UNIT_SPLATS 0
#define PSPLAT_UNIT_CLIPS 1
#define PSPLAT_UNIT_FINISHES 2
#define PSPLAT_UNIT_TEXCOORDS 3
#define PSPLAT_UNIT_DEPTH 4
#define PSPLAT_UNIT_SHADOWS 5
#define PSPLAT_UNIT_DIFFUSE 6
#define PSPLAT_UNIT_GLOSSY 7
#define PSPLAT_UNIT_SPLIT_SUM 8
#define PSPLAT_UNIT_COUNT 9

/* The textures of materials are on further units, which only frames with such textures touch: one
 * for each psplat_texture_slot. */
#define PSPLAT_UNIT_MAPS 9
#define PSPLAT_MAP_COUNT 5
#define PSPLAT_UNIT_COUNT_MAPS 14

/* Texels along an edge of the table of a and b of eq. (9). Its axes are the square root of n.e,
 * because a and b change most at grazing angles, and roughness. */
#define PSPLAT_SPLIT_SUM_SIZE 32

/* The colour attachments of the attribute pass, which hold these sums over the splats of a pixel.
 * PSPLAT_TARGET_COUNT and the two after it are the numbers of attachments.
 *
 *     0: sum of w n, of w L or (u, v, index); sum of w
 *     1: sum of w z; of w roughness or w unlit where materials differ; of w occlusion where
 *        occlusion differs. Roughness is here where target 3 is not there, else unlit
 *     2: sum of w colour; sum of w metallic            where colours or materials differ
 *     3: sum of w emissive; sum of w roughness         where emission or unlit differ
 *
 * A pixel takes 24 bytes with the depth buffer; 40 with colours; 44 with materials, 52 with
 * occlusion; 60 with emission, 68 with both. */
#define PSPLAT_TARGET_COUNT 2
#define PSPLAT_TARGET_COUNT_COLORS 3
#define PSPLAT_TARGET_COUNT_EMISSIVE 4

#endif
