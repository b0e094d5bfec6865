/* SPDX-License-Identifier: MIT
 *
 * light_setups.c - rigs of lights. A white surface that faces the strongest light squarely comes
 * out close to white; positions and candelas scale with the scene.
 */
#include "viewer.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

enum { RIG_HEADLIGHT, RIG_STUDIO, RIG_SPOTS, RIG_NONE };
const char *const lights_names[] = {"headlight", "studio", "spots", "none", NULL};

static void set_ambient(psplat_view *view, double value) {
    for (int i = 0; i < 3; ++i) view->ambient[i] = (float)value;
}

static psplat_light *add(psplat_view *view, psplat_light_type type, const double color[3],
                         double intensity) {
    psplat_light *light = &view->lights[view->light_count++];
    *light = (psplat_light){.type = type};
    for (int i = 0; i < 3; ++i) light->color[i] = (float)(intensity * color[i]);
    return light;
}

/* Sets the light of `phongsplat render`: it shines over the shoulder and moves with the camera. */
static void set_headlight(const orbit *o, int has_shadows, psplat_view *view) {
    double axes[3][3];
    orbit_axes(o, axes);
    psplat_light *light = add(view, PSPLAT_LIGHT_DIRECTIONAL, (double[3]){1, 1, 1}, 0.85 * pi);
    for (int i = 0; i < 3; ++i)
        light->direction[i] = (float)(0.15 * axes[0][i] - 0.65 * axes[1][i] - 0.85 * axes[2][i]);
    light->casts_shadow = has_shadows;
    set_ambient(view, 0.12);
}

/* Sets a warm key light, a cool fill light from the other side and a rim light from behind. They
 * stay with the scene, so that turning the camera shows how the surface reflects them. */
static void set_studio(int has_shadows, psplat_view *view) {
    const struct {
        double color[3], intensity;
        float direction[3];
    } lights[] = {
        {{1, 0.93, 0.82}, 0.85 * pi, {0.6f, -1, -0.8f}},
        {{0.75, 0.85, 1}, 0.25 * pi, {-1, -0.2f, -0.6f}},
        {{1, 1, 1}, 0.35 * pi, {0.3f, -0.6f, 1}},
    };
    for (size_t i = 0; i < sizeof lights / sizeof *lights; ++i) {
        psplat_light *light =
            add(view, PSPLAT_LIGHT_DIRECTIONAL, lights[i].color, lights[i].intensity);
        memcpy(light->direction, lights[i].direction, sizeof light->direction);
        light->casts_shadow = has_shadows && i == 0;
    }
    set_ambient(view, 0.05);
}

/* Sets two spot lights from above, a warm and a cool one, and a dim point light near the ground. */
static void set_spots(const sphere *scene, int has_shadows, psplat_view *view) {
    const struct {
        double color[3], power, at[3];
    } lights[] = {
        {{1, 0.85, 0.65}, 0.8, {-1.6, 2.2, 1.4}},
        {{0.6, 0.75, 1}, 0.55, {1.9, 1.6, 0.6}},
        {{1, 0.6, 0.5}, 0.12, {0.4, -1.3, 1.2}},
    };
    double reach = scene->radius > 0 ? scene->radius : 1;
    for (size_t i = 0; i < sizeof lights / sizeof *lights; ++i) {
        const double *at = lights[i].at;
        double square = at[0] * at[0] + at[1] * at[1] + at[2] * at[2];
        psplat_light *light = add(view, i < 2 ? PSPLAT_LIGHT_SPOT : PSPLAT_LIGHT_POINT,
                                  lights[i].color, pi * lights[i].power * square * reach * reach);
        for (int k = 0; k < 3; ++k) {
            light->position[k] = scene->center[k] + reach * at[k];
            light->direction[k] = (float)-at[k];
        }
        light->inner_angle = 0.3f;
        light->outer_angle = 0.5f;
        light->casts_shadow = has_shadows && i < 2;
    }
    set_ambient(view, 0.04);
}

void lights_set(int rig, int has_shadows, const orbit *o, const sphere *scene, psplat_view *view) {
    view->light_count = 0;
    switch (rig) {
    case RIG_HEADLIGHT:
        set_headlight(o, has_shadows, view);
        break;
    case RIG_STUDIO:
        set_studio(has_shadows, view);
        break;
    case RIG_SPOTS:
        set_spots(scene, has_shadows, view);
        break;
    default:
        set_ambient(view, 0.9);
        break;
    }
}
