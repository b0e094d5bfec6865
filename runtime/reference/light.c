/* SPDX-License-Identifier: MIT
 *
 * light.c - the lights of KHR_lights_punctual in eye space, what of them reaches a point by eq. (8)
 * of spec 5.6, and their shadows, for which a ray to the light is tested against all splats.
 */
#include "reference/oracle.h"

#include <math.h>

/* Moves (v, w) into eye space: a point where w is 1, a direction where it is 0. */
static void to_eye_space(const double view[16], const double v[3], double w, double out[3]) {
    double moved[4];
    psplat_oracle_transform(view, v, w, moved);
    for (int i = 0; i < 3; ++i) out[i] = moved[i];
}

static psplat_oracle_light light_of(const psplat_light *from, const double view[16]) {
    psplat_oracle_light light = {.type = from->type, .range = from->range};
    double direction[3];
    double outer = from->outer_angle > 0 ? (double)from->outer_angle : PSPLAT_ORACLE_PI / 4;
    for (int i = 0; i < 3; ++i) {
        direction[i] = from->direction[i];
        light.color[i] = from->color[i];
    }
    to_eye_space(view, direction, 0, light.direction);
    psplat_oracle_normalise(light.direction);
    to_eye_space(view, from->position, 1, light.position);
    light.cos_inner = cos((double)from->inner_angle);
    light.cos_outer = cos(outer);
    return light;
}

void psplat_oracle_lighting_set(psplat_oracle_lighting *lighting, const psplat_view *view,
                                const psplat_environment_desc *environment) {
    int shadows = 0;
    lighting->count = view->light_count;
    for (int k = 0; k < lighting->count; ++k) {
        const psplat_light *from = &view->lights[k];
        lighting->lights[k] = light_of(from, view->view);
        lighting->lights[k].casts_shadow = from->casts_shadow && from->type != PSPLAT_LIGHT_POINT &&
                                           shadows++ < PSPLAT_MAX_SHADOWS;
    }
    lighting->environment.desc = environment;
    for (int i = 0; i < 3; ++i) {
        lighting->ambient[i] = view->ambient[i];
        /* The view is rigid, so the inverse of its rotation is the transpose. */
        for (int k = 0; k < 3; ++k) lighting->environment.to_scene[i][k] = view->view[4 * i + k];
    }
}

int psplat_oracle_lighting_has_shadows(const psplat_oracle_lighting *lighting) {
    for (int k = 0; k < lighting->count; ++k)
        if (lighting->lights[k].casts_shadow) return 1;
    return 0;
}

/* Returns the distance from a point towards the light at which the light's ray meets the wall of a
 * splat of which it meets no other point; 0 or less where it does not. */
static double distance_to_wall(const psplat_oracle_splat *splat, const double point[3],
                               const double to_light[3], double at[2]) {
    psplat_oracle_entry entry;
    double from_light[3], met[3];
    for (int i = 0; i < 3; ++i) from_light[i] = -to_light[i];
    psplat_oracle_entry_set(&entry, splat, point, from_light);
    if (!(splat->wall > 0) || !psplat_oracle_entry_meets(&entry)) return 0;
    psplat_oracle_along(point, entry.s, from_light, met);
    psplat_oracle_along(met, -1, splat->center, met);
    for (int k = 0; k < 2; ++k) at[k] = psplat_oracle_dot(splat->parameter[k], met);
    return -entry.s;
}

/* Returns the distance from a point towards the light at which the light's ray meets the splat; of
 * two points of a curved one the one nearer to the light. What lies beyond the light or is no part
 * of the splat is not met: then it returns 0. *is_wall says whether it is its wall. Masks are those
 * of the finest texels, since light has no pixels. */
static double distance_to(const psplat_oracle_splat *splat, const double point[3],
                          const double to_light[3], double distance, double normal[3],
                          int *is_wall) {
    psplat_oracle_crossing crossing;
    double offset[3], met[3], s[2] = {-1, -1}, farthest = 0, at[2] = {0, 0};
    double steps[2][2] = {{0, 0}, {0, 0}};
    int is_met = 0;
    psplat_oracle_along(splat->center, -1, point, offset);
    s[0] = psplat_oracle_dot(splat->plane, offset) / psplat_oracle_dot(splat->plane, to_light);
    if (splat->is_curved) {
        psplat_oracle_crossing_set(&crossing, splat, point, to_light);
        for (int k = 0; k < 2; ++k) s[k] = psplat_oracle_crossing_root(&crossing, k);
    }
    for (int k = 0; k < 2; ++k) {
        if (!(s[k] <= distance && isfinite(s[k]))) continue;
        psplat_oracle_along(offset, -s[k], to_light, met); /* from there to the splat's centre */
        double u = -psplat_oracle_dot(splat->parameter[0], met);
        double v = -psplat_oracle_dot(splat->parameter[1], met);
        if (!psplat_oracle_is_inside(splat, u, v)) continue;
        is_met = 1;
        if (!(s[k] > farthest)) continue;
        farthest = s[k];
        at[0] = u;
        at[1] = v;
    }
    *is_wall = splat->is_curved && !is_met;
    if (*is_wall) {
        double wall = distance_to_wall(splat, point, to_light, at);
        if (wall <= distance) farthest = wall;
    }
    psplat_oracle_surface_normal(splat, at[0], at[1], normal);
    if (farthest > 0 && psplat_oracle_mask_margin(&splat->mask, at[0], at[1], steps) < 0) return 0;
    return farthest;
}

/* Returns 1 where the splat keeps the light off a point: the way to the light meets it farther from
 * the point than its epsilon, which is eq. (5) with the light as the eye. Its side does not matter.
 */
static int stands_between(const psplat_oracle_splat *splat, const psplat_oracle_light *light,
                          const double point[3], const double to_light[3], double distance) {
    double from_light[3], normal[3], epsilon = splat->epsilon;
    int is_wall;
    double s = distance_to(splat, point, to_light, distance, normal, &is_wall);
    if (!(s > 0)) return 0;
    int is_at_center = !splat->is_curved && light->type != PSPLAT_LIGHT_DIRECTIONAL;
    for (int i = 0; i < 3; ++i)
        from_light[i] = is_at_center ? splat->center[i] - light->position[i] : -to_light[i];
    psplat_oracle_normalise(from_light);
    psplat_oracle_normalise(normal);
    double cosine = psplat_oracle_dot(normal, from_light);
    if (is_wall) epsilon *= PSPLAT_ORACLE_WALL_SHIFT;
    return s > epsilon / fmax(fabs(cosine), 0.5);
}

static int is_in_shadow(const psplat_oracle_lighting *lighting, const psplat_oracle_light *light,
                        const double point[3], const double to_light[3], double distance) {
    for (size_t i = 0; i < lighting->caster_count; ++i)
        if (stands_between(&lighting->casters[i], light, point, to_light, distance)) return 1;
    return 0;
}

/* Returns the factor of intensity in eq. (8): the falloff with distance and range, and s of a spot
 * light's cone. */
static double falloff(const psplat_oracle_light *light, const double to_light[3], double distance) {
    double factor = 1 / (distance * distance);
    if (light->range > 0) factor *= fmax(fmin(1 - pow(distance / light->range, 4), 1), 0);
    if (light->type == PSPLAT_LIGHT_SPOT) {
        double cosine = -psplat_oracle_dot(light->direction, to_light);
        double s = (cosine - light->cos_outer) / fmax(light->cos_inner - light->cos_outer, 0.001);
        s = fmin(fmax(s, 0), 1);
        factor *= s * s;
    }
    return factor;
}

void psplat_oracle_light_at(const psplat_oracle_lighting *lighting,
                            const psplat_oracle_light *light, const double point[3],
                            double to_light[3], double irradiance[3]) {
    double factor = 1, distance = HUGE_VAL;
    if (light->type == PSPLAT_LIGHT_DIRECTIONAL) {
        for (int i = 0; i < 3; ++i) to_light[i] = -light->direction[i];
    } else {
        psplat_oracle_along(light->position, -1, point, to_light);
        distance = psplat_oracle_length(to_light);
        psplat_oracle_normalise(to_light);
        factor = falloff(light, to_light, distance);
    }
    if (light->casts_shadow && factor > 0 &&
        is_in_shadow(lighting, light, point, to_light, distance))
        factor = 0;
    for (int i = 0; i < 3; ++i) irradiance[i] = factor * light->color[i];
}
