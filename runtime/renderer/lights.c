/* SPDX-License-Identifier: MIT
 *
 * lights.c - turns the lights of KHR_lights_punctual (spec 5.6) into eye space and into the numbers
 * that shading.glsl takes.
 */
#include "renderer/lights.h"

#include <math.h>
#include <string.h>

_Static_assert(PSPLAT_SHADOW_COUNT == PSPLAT_MAX_SHADOWS, "shaders and header agree");

static const double default_outer_angle = 0.78539816339744831; /* pi / 4 radians */

double psplat_light_outer_angle(const psplat_light *light) {
    return light->outer_angle > 0.0f ? (double)light->outer_angle : default_outer_angle;
}

/* Rotates a direction into eye space and scales it to the length |scale|; a negative scale turns it
 * round. A direction of length 0 stays 0. */
static void rotate_to_eye(const double view[16], const float direction[3], double scale,
                          float out[3]) {
    double eye[3], length2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        eye[i] = 0.0;
        for (int k = 0; k < 3; ++k) eye[i] += view[k * 4 + i] * (double)direction[k];
        length2 += eye[i] * eye[i];
    }
    if (length2 > 0.0) scale /= sqrt(length2);
    for (int i = 0; i < 3; ++i) out[i] = (float)(eye[i] * scale);
}

/* Sets the factor and the offset that turn the cosine of an angle to the axis into s of eq. (8)
 * before clamping and squaring. Lights without a cone get the constant 1. */
static void set_cone(const psplat_light *light, float cone[4]) {
    cone[0] = 0.0f;
    cone[1] = 1.0f;
    cone[3] = 0.0f;
    if (light->type != PSPLAT_LIGHT_SPOT) return;
    double outer = cos(psplat_light_outer_angle(light)), inner = cos((double)light->inner_angle);
    double scale = 1.0 / fmax(inner - outer, 0.001);
    cone[0] = (float)scale;
    cone[1] = (float)(-outer * scale);
}

static void set_light(psplat_lights *lights, int i, const psplat_view *view) {
    const psplat_light *light = &view->lights[i];
    float *position = lights->position[i], *color = lights->color[i];
    rotate_to_eye(view->view, light->direction, 1.0, lights->axis[i]);
    set_cone(light, lights->cone[i]);
    memcpy(color, light->color, sizeof light->color);
    color[3] = 0.0f;
    if (light->type == PSPLAT_LIGHT_DIRECTIONAL) {
        rotate_to_eye(view->view, light->direction, -1.0, position);
        position[3] = 0.0f;
        return;
    }
    for (int row = 0; row < 3; ++row) {
        double sum = view->view[12 + row];
        for (int k = 0; k < 3; ++k) sum += view->view[k * 4 + row] * light->position[k];
        position[row] = (float)sum;
    }
    position[3] = 1.0f;
    if (light->range > 0.0f) color[3] = 1.0f / (light->range * light->range);
    lights->has_punctual = 1;
}

void psplat_lights_set(psplat_lights *lights, const psplat_view *view) {
    lights->count = view->light_count;
    lights->has_punctual = lights->shadow_count = 0;
    for (int i = 0; i < view->light_count; ++i) {
        const psplat_light *light = &view->lights[i];
        set_light(lights, i, view);
        int casts = light->casts_shadow && light->type != PSPLAT_LIGHT_POINT &&
                    lights->shadow_count < PSPLAT_SHADOW_COUNT;
        lights->cone[i][2] = casts ? (float)lights->shadow_count : -1.0f;
        if (casts) lights->casters[lights->shadow_count++] = i;
    }
}

void psplat_lights_use(const psplat_lights *lights, const psplat_gl *gl,
                       const psplat_program *program) {
    GLsizei count = lights->count;
    if (count == 0) return;
    gl->Uniform4fv(program->light_position, count, lights->position[0]);
    gl->Uniform4fv(program->light_color, count, lights->color[0]);
    gl->Uniform3fv(program->light_axis, count, lights->axis[0]);
    gl->Uniform4fv(program->light_cone, count, lights->cone[0]);
}
