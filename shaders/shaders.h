/* SPDX-License-Identifier: MIT
 *
 * shaders.h - the GLSL files of this directory as zero-terminated strings. gl_program.c declares
 * those of the resolve_*.glsl files that are shadings.
 */
#ifndef PHONGSPLAT_SHADERS_H
#define PHONGSPLAT_SHADERS_H

extern const char psplat_shader_layout_h[];
extern const char psplat_shader_shading_glsl[];
extern const char psplat_shader_texels_glsl[];
extern const char psplat_shader_splat_data_glsl[];
extern const char psplat_shader_shift_glsl[];
extern const char psplat_shader_splat_vert[];
extern const char psplat_shader_curved_vert[];
extern const char psplat_shader_maps_glsl[];
extern const char psplat_shader_sums_glsl[];
extern const char psplat_shader_splat_frag[];
extern const char psplat_shader_curved_frag[];
extern const char psplat_shader_screen_vert[];
extern const char psplat_shader_resolve_vert[];
extern const char psplat_shader_resolve_inputs_glsl[];
extern const char psplat_shader_resolve_frag[];
extern const char psplat_shader_depth_frag[]; /* for the headless host */

#endif
