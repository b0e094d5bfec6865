/* SPDX-License-Identifier: MIT
 *
 * lights.h - the lights of a view in eye space, as shading.glsl takes them.
 */
#ifndef PHONGSPLAT_LIGHTS_H
#define PHONGSPLAT_LIGHTS_H

#include "program.h"

typedef struct psplat_lights {
    float position[PSPLAT_MAX_LIGHTS][4];
    float color[PSPLAT_MAX_LIGHTS][4];
    float axis[PSPLAT_MAX_LIGHTS][3];
    float cone[PSPLAT_MAX_LIGHTS][4]; /* scale and offset of the cosine, number of the shadow map or
                                         -1, width of its texels (of spot lights at distance 1) */
    int count;
    int has_punctual;
    int shadow_count;
    int casters[PSPLAT_SHADOW_COUNT]; /* lights of the view by the number of their shadow map */
} psplat_lights;

void psplat_lights_set(psplat_lights *lights, const psplat_view *view);

/* To the current program. */
void psplat_lights_use(const psplat_lights *lights, const psplat_gl *gl,
                       const psplat_program *program);

/* The half angle beyond which a spot light does not shine. */
double psplat_light_outer_angle(const psplat_light *light);

#endif
