/* SPDX-License-Identifier: MIT
 *
 * shaders.h - the GLSL files beside it as text (embed.cmake of the repository's shaders).
 */
#ifndef PHONGSPLAT_COMPARE_SHADERS_H
#define PHONGSPLAT_COMPARE_SHADERS_H

extern const char psplat_compare_shader_facets_frag[];
extern const char psplat_compare_shader_facets_vert[];
extern const char psplat_compare_shader_light_glsl[];

#endif
