/* SPDX-License-Identifier: MIT
 *
 * bench_shaders.h - the GLSL files beside it as text (embed.cmake of the repository's shaders).
 */
#ifndef PHONGSPLAT_BENCH_SHADERS_H
#define PHONGSPLAT_BENCH_SHADERS_H

extern const char bench_shader_light_glsl[];
extern const char bench_shader_screen_vert[];
extern const char bench_shader_sprite_frag[];
extern const char bench_shader_sprite_resolve_frag[];
extern const char bench_shader_sprite_vert[];

#endif
