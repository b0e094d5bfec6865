/* SPDX-License-Identifier: MIT
 *
 * compare_shaders.h - the shaders of the mesh renderer, embedded as text from the GLSL files beside
 * this header.
 */
#ifndef PHONGSPLAT_COMPARE_SHADERS_H
#define PHONGSPLAT_COMPARE_SHADERS_H

extern const char psplat_compare_shader_mesh_frag[];
extern const char psplat_compare_shader_mesh_vert[];
extern const char psplat_compare_shader_light_glsl[];

#endif
