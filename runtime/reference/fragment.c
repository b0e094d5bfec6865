/* SPDX-License-Identifier: MIT
 * Spec 5.1 and 5.2: where a ray meets a splat, and from which side. */
#include "oracle.h"

#include <math.h>

/* A linear or distance function of (u, v) that must be >= 0: its value, or its distance in pixels
 * (to first order) where that is less. by_* are its derivatives by u and v; step holds those of
 * (u, v) by the pixel's x and y. */
static double edge(double value, double by_u, double by_v, double step[2][2]) {
    double x = by_u * step[0][0] + by_v * step[0][1];
    double y = by_u * step[1][0] + by_v * step[1][1];
    return value / fmax(1, sqrt(x * x + y * y));
}

/* Derivatives of (u, v) by x and y: q = o + s d with s = n.(c - o) / n.d. */
static void parameter_steps(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                            double s, double facing, double step[2][2]) {
    for (int k = 0; k < 2; ++k) {
        double moved[3];
        psplat_oracle_along(ray->origin_by[k], s, ray->direction_by[k], moved);
        double s_by = -psplat_oracle_dot(splat->plane, moved) / facing;
        psplat_oracle_along(moved, s_by, ray->direction, moved);
        step[k][0] = psplat_oracle_dot(splat->parameter[0], moved);
        step[k][1] = psplat_oracle_dot(splat->parameter[1], moved);
    }
}

/* Least margin of the ellipse (spec 3.4) and of the clip lines (spec 3.6). */
static double edge_margin(const psplat_oracle_splat *splat, double u, double v, double r,
                          double step[2][2]) {
    double inverse = r > 0 ? 1 / r : 0;
    double least = edge(1 - r, u * inverse, v * inverse, step);
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        const double *line = splat->clip[k];
        double length = hypot(line[0], line[1]);
        double a = line[0] / length, b = line[1] / length, c = line[2] / length;
        least = fmin(least, edge(a * u + b * v + c, a, b, step));
    }
    return least;
}

static int is_inside(const psplat_oracle_splat *splat, double u, double v) {
    if (!(u * u + v * v <= 1)) return 0;
    for (uint32_t k = 0; k < splat->clip_count; ++k)
        if (!(splat->clip[k][0] * u + splat->clip[k][1] * v + splat->clip[k][2] >= 0)) return 0;
    return 1;
}

int psplat_oracle_fragment_find(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                int cull, psplat_oracle_fragment *fragment) {
    /* 5.1: the plane's point on the ray (BSK04 eq. 6), its (u, v) and its window depth. */
    double to_center[3], from_center[3], point[3], step[2][2], w = 0;
    psplat_oracle_along(splat->center, -1, ray->origin, to_center);
    double facing = psplat_oracle_dot(splat->plane, ray->direction);
    double s = psplat_oracle_dot(splat->plane, to_center) / facing;
    fragment->edge_margin = fragment->depth_margin = -1;
    if (!isfinite(s)) return 0;
    psplat_oracle_along(ray->origin, s, ray->direction, point);
    psplat_oracle_along(point, -1, splat->center, from_center);
    double u = psplat_oracle_dot(splat->parameter[0], from_center);
    double v = psplat_oracle_dot(splat->parameter[1], from_center);
    fragment->u = u;
    fragment->v = v;
    fragment->r = sqrt(u * u + v * v);
    fragment->t = s * ray->length;
    fragment->depth = psplat_oracle_camera_depth(camera, point, &w);
    if (!(w > 0)) return 0; /* behind the eye */

    /* 5.2: N'.e > 0 where seen from the front, e = -direction. */
    double cosine = -psplat_oracle_dot(splat->side, ray->direction) /
                    (psplat_oracle_length(splat->side) * ray->length);
    fragment->front = cosine > 0;

    parameter_steps(splat, ray, s, facing, step);
    fragment->edge_margin =
        fmin(edge_margin(splat, u, v, fragment->r, step), cull ? cosine : fabs(cosine));
    fragment->depth_margin = fmin(fragment->depth, 1 - fragment->depth);
    return is_inside(splat, u, v) && fragment->depth_margin >= 0 && (fragment->front || !cull);
}
