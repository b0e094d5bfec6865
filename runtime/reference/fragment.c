/* SPDX-License-Identifier: MIT
 *
 * fragment.c - where a ray meets a splat's plane (spec 5.1), from which side (5.2), whether that
 * point is a fragment, and how near it is to the opposite.
 */
#include "reference/oracle.h"

#include <math.h>

/* The plane's point on the ray is that of BSK04 eq. 6; its cosine is N'.e of spec 5.2, with e
 * opposite to the ray. */
int psplat_oracle_fragment_find(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                psplat_oracle_fragment *fragment) {
    double to_center[3], from_center[3], point[3], w = 0;
    psplat_oracle_along(splat->center, -1, ray->origin, to_center);
    fragment->s = psplat_oracle_dot(splat->plane, to_center) /
                  psplat_oracle_dot(splat->plane, ray->direction);
    if (!isfinite(fragment->s)) return 0; /* the ray is parallel to the plane */
    psplat_oracle_along(ray->origin, fragment->s, ray->direction, point);
    psplat_oracle_along(point, -1, splat->center, from_center);
    fragment->u = psplat_oracle_dot(splat->parameter[0], from_center);
    fragment->v = psplat_oracle_dot(splat->parameter[1], from_center);
    fragment->r = sqrt(fragment->u * fragment->u + fragment->v * fragment->v);
    fragment->t = fragment->s * ray->length;
    fragment->depth = psplat_oracle_camera_depth(camera, point, &w);
    fragment->cosine = -psplat_oracle_dot(splat->side, ray->direction) / ray->length;
    return w > 0;
}

double psplat_oracle_fragment_limit(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                    const psplat_oracle_fragment *fragment) {
    double point[3];
    psplat_oracle_along(ray->origin, fragment->s, ray->direction, point);
    double least = 0x1p-20 * psplat_oracle_length(point) / fmax(fabs(splat->cosine), 0.5); /* 5a */
    return fragment->t + fmax(splat->epsilon, least);
}

int psplat_oracle_fragment_exists(const psplat_oracle_splat *splat,
                                  const psplat_oracle_fragment *fragment, int cull) {
    double u = fragment->u, v = fragment->v;
    if (!(u * u + v * v <= 1)) return 0;
    for (uint32_t k = 0; k < splat->clip_count; ++k)
        if (!(splat->clip[k][0] * u + splat->clip[k][1] * v + splat->clip[k][2] >= 0)) return 0;
    if (cull && !(fragment->cosine > 0)) return 0;
    return fragment->depth >= 0 && fragment->depth <= 1;
}

/* ---- margins -------------------------------------------------------------------------------- */

double psplat_oracle_edge(double value, double by_u, double by_v, double steps[2][2]) {
    double x = by_u * steps[0][0] + by_v * steps[0][1];
    double y = by_u * steps[1][0] + by_v * steps[1][1];
    return value / fmax(1, sqrt(x * x + y * y));
}

/* Finds the derivatives of (u, v) by the pixel's x (steps[0]) and y (steps[1]), where the ray meets
 * the plane at s: q = o + s d with s = n.(c - o) / n.d. */
static void find_steps(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                       const psplat_oracle_ray *ray, double s, double steps[2][2]) {
    psplat_oracle_ray_steps by;
    psplat_oracle_camera_ray_steps(camera, ray, &by);
    double facing = psplat_oracle_dot(splat->plane, ray->direction);
    for (int k = 0; k < 2; ++k) {
        double moved[3];
        psplat_oracle_along(by.origin[k], s, by.direction[k], moved);
        double s_by = -psplat_oracle_dot(splat->plane, moved) / facing;
        psplat_oracle_along(moved, s_by, ray->direction, moved);
        steps[k][0] = psplat_oracle_dot(splat->parameter[0], moved);
        steps[k][1] = psplat_oracle_dot(splat->parameter[1], moved);
    }
}

psplat_oracle_margins psplat_oracle_fragment_margins(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat,
                                                     const psplat_oracle_ray *ray,
                                                     const psplat_oracle_fragment *fragment,
                                                     int cull) {
    double steps[2][2], u = fragment->u, v = fragment->v, r = fragment->r;
    find_steps(camera, splat, ray, fragment->s, steps);
    double inverse = r > 0 ? 1 / r : 0;
    double least = psplat_oracle_edge(1 - r, u * inverse, v * inverse, steps);
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        const double *line = splat->clip[k];
        double length = hypot(line[0], line[1]);
        double a = line[0] / length, b = line[1] / length, c = line[2] / length;
        least = fmin(least, psplat_oracle_edge(a * u + b * v + c, a, b, steps));
    }
    least = fmin(least, cull ? fragment->cosine : fabs(fragment->cosine));
    return (psplat_oracle_margins){least, fmin(fragment->depth, 1 - fragment->depth)};
}
