/* SPDX-License-Identifier: MIT
 *
 * lights.h - the lights of a view as the uniforms of shading.glsl, in eye space.
 */
#ifndef PHONGSPLAT_RENDERER_LIGHTS_H
#define PHONGSPLAT_RENDERER_LIGHTS_H

#include "gl/gl_program.h"

typedef struct psplat_lights {
    float position[PSPLAT_MAX_LIGHTS][4]; /* w is 1; or with w 0 the unit direction towards a
                                             directional light */
    float color[PSPLAT_MAX_LIGHTS][4];    /* linear intensity; 1 / range^2, 0 without a range */
    float axis[PSPLAT_MAX_LIGHTS][3];     /* unit direction in which it shines */
    float cone[PSPLAT_MAX_LIGHTS][4]; /* scale and offset of the cosine; number of the shadow map or
                                         -1; width of its texels (spot lights: at distance 1) */
    int count;
    int has_punctual;                 /* 1: some light is not directional */
    int shadow_count;                 /* lights that cast shadows */
    int casters[PSPLAT_SHADOW_COUNT]; /* for each shadow map the index of its light in the view */
} psplat_lights;

/* Sets the lights of a view. The widths of shadow texels stay 0; shadow_pass.c sets them. */
void psplat_lights_set(psplat_lights *lights, const psplat_view *view);

/* Sets the current program's uniforms of lights. */
void psplat_lights_use(const psplat_lights *lights, const psplat_gl *gl,
                       const psplat_program *program);

/* Returns the angle from its axis, in radians, beyond which a spot light does not shine. */
double psplat_light_outer_angle(const psplat_light *light);

#endif
