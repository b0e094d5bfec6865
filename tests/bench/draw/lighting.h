/* SPDX-License-Identifier: MIT
 *
 * lighting.h - uniforms that the benchmark's own programs share (shaders/light.glsl).
 */
#ifndef PHONGSPLAT_BENCH_LIGHTING_H
#define PHONGSPLAT_BENCH_LIGHTING_H

#include "bench_gl.h"

#include <phongsplat/phongsplat.h>

/* Sets the matrices of the current program. model is the transform to scene space. */
void lighting_place(const bench_gl *gl, GLuint program, const psplat_view *view,
                    const double model[16]);
/* Sets lights and material; the view's lights must be directional. */
void lighting_light(const bench_gl *gl, GLuint program, const psplat_view *view,
                    const psplat_material *material);
/* Sets u_ray, which times (pixel x, y, 1) gives the ray through the pixel in eye space, with z =
 * -1. The projection must be a perspective one. */
void lighting_ray(const bench_gl *gl, GLuint program, const psplat_view *view);

int lighting_two_sided(const psplat_view *view, const psplat_material *material);

#endif
