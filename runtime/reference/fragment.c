/* SPDX-License-Identifier: MIT
 *
 * fragment.c - where a ray meets a splat's surface or the wall under its rim (spec 5.1), from which
 * side (5.2), whether that point is a fragment, and how near it is to the opposite.
 */
#include "reference/oracle.h"

#include <math.h>

/* Fills in what follows from the ray's parameter s. Returns 0 where there is no such point in front
 * of the eye. The cosine is N'.e of spec 5.2, with e opposite to the ray. */
static int set_point(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                     const psplat_oracle_ray *ray, psplat_oracle_fragment *fragment) {
    double from_center[3], point[3], normal[3], w = 0;
    if (!isfinite(fragment->s)) return 0;
    psplat_oracle_along(ray->origin, fragment->s, ray->direction, point);
    psplat_oracle_along(point, -1, splat->center, from_center);
    fragment->u = psplat_oracle_dot(splat->parameter[0], from_center);
    fragment->v = psplat_oracle_dot(splat->parameter[1], from_center);
    fragment->r = sqrt(fragment->u * fragment->u + fragment->v * fragment->v);
    fragment->t = fragment->s * ray->length;
    fragment->depth = psplat_oracle_camera_depth(camera, point, &w);
    psplat_oracle_surface_normal(splat, fragment->u, fragment->v, normal);
    double lengths = psplat_oracle_length(normal) * ray->length;
    fragment->cosine = -psplat_oracle_dot(normal, ray->direction) / lengths;
    return w > 0;
}

/* Returns 1 where the point is a fragment: inside the ellipse and the clip lines, between the near
 * and the far plane and, where cull is 1, seen from the front. A point of the wall is known to be
 * on the rim and between the lines. */
static int exists(const psplat_oracle_splat *splat, const psplat_oracle_fragment *fragment,
                  int cull) {
    if (fragment->is_missed) return 0;
    if (!fragment->is_wall && !psplat_oracle_is_inside(splat, fragment->u, fragment->v)) return 0;
    if (cull && !splat->is_curved && !(fragment->cosine > 0)) return 0;
    return fragment->depth >= 0 && fragment->depth <= 1;
}

/* Adds a point of the ray, which lies farther than those there are. */
static void add_point(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                      const psplat_oracle_ray *ray, int cull, psplat_oracle_fragment point,
                      psplat_oracle_meeting *meeting) {
    if (meeting->is_inside || !set_point(camera, splat, ray, &point)) return;
    meeting->points[meeting->count++] = point;
    meeting->is_inside = exists(splat, &point, cull);
}

/* Adds the point of the wall, which is met where no other is. */
static void add_wall(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                     const psplat_oracle_ray *ray, int cull, psplat_oracle_meeting *meeting) {
    psplat_oracle_entry entry;
    if (!(splat->wall > 0)) return;
    psplat_oracle_entry_set(&entry, splat, ray->origin, ray->direction);
    psplat_oracle_fragment point = {
        .s = entry.s, .is_missed = !psplat_oracle_entry_meets(&entry), .is_wall = 1};
    add_point(camera, splat, ray, cull, point, meeting);
}

/* The front is what a ray meets at the root where it goes in (spec 5.1), so that culled splats are
 * asked for that root alone. The order of the roots is that of their parameters. */
static void meet_surface(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                         const psplat_oracle_ray *ray, int cull, psplat_oracle_meeting *meeting) {
    psplat_oracle_crossing crossing;
    psplat_oracle_crossing_set(&crossing, splat, ray->origin, ray->direction);
    psplat_oracle_fragment middle = {.s = psplat_oracle_crossing_middle(&crossing), .is_missed = 1};
    if (crossing.discriminant < 0) {
        add_point(camera, splat, ray, cull, middle, meeting);
        return;
    }
    psplat_oracle_fragment front = {.s = psplat_oracle_crossing_root(&crossing, 0)};
    psplat_oracle_fragment back = {.s = psplat_oracle_crossing_root(&crossing, 1)};
    back.is_peeking =
        psplat_oracle_is_peeking(splat, sqrt(crossing.discriminant), crossing.height[2]);
    int back_is_first = back.s < front.s;
    if (!cull && back_is_first) add_point(camera, splat, ray, cull, back, meeting);
    add_point(camera, splat, ray, cull, front, meeting);
    if (!cull && !back_is_first) add_point(camera, splat, ray, cull, back, meeting);
}

/* The plane's point on the ray is that of BSK04 eq. 6. It is not finite where the ray is parallel
 * to the plane. */
void psplat_oracle_meet(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                        const psplat_oracle_ray *ray, int cull, psplat_oracle_meeting *meeting) {
    double to_center[3];
    *meeting = (psplat_oracle_meeting){.count = 0};
    if (splat->is_curved) {
        meet_surface(camera, splat, ray, cull, meeting);
        add_wall(camera, splat, ray, cull, meeting);
        return;
    }
    psplat_oracle_along(splat->center, -1, ray->origin, to_center);
    psplat_oracle_fragment point = {.s = psplat_oracle_dot(splat->plane, to_center) /
                                         psplat_oracle_dot(splat->plane, ray->direction)};
    add_point(camera, splat, ray, cull, point, meeting);
}

const psplat_oracle_fragment *psplat_oracle_met(const psplat_oracle_meeting *meeting) {
    return meeting->is_inside ? &meeting->points[meeting->count - 1] : NULL;
}

/* Theta of eq. (5) is the angle at the centre of a flat splat, and at the fragment of a curved one.
 * Epsilon is larger for walls. */
double psplat_oracle_fragment_limit(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                    const psplat_oracle_fragment *fragment) {
    double point[3], theta = splat->is_curved ? fragment->cosine : splat->cosine;
    double cosine = fmax(fabs(theta), 0.5), epsilon = splat->epsilon;
    if (fragment->is_wall) epsilon *= PSPLAT_ORACLE_WALL_SHIFT;
    psplat_oracle_along(ray->origin, fragment->s, ray->direction, point);
    double least = 0x1p-20 * psplat_oracle_length(point) / cosine; /* eq. (5a) */
    return fragment->t + fmax(epsilon / cosine, least);
}

psplat_oracle_side psplat_oracle_fragment_side(const psplat_oracle_splat *splat,
                                               const psplat_oracle_fragment *fragment) {
    if (!splat->is_curved) return splat->seen;
    if (fragment->cosine > 0) return PSPLAT_ORACLE_FRONT;
    return fragment->is_peeking ? PSPLAT_ORACLE_PEEKING : PSPLAT_ORACLE_BACK;
}

void psplat_oracle_face_normal(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                               psplat_oracle_side side, double normal[3]) {
    const double *toward = splat->is_curved ? ray->direction : splat->toward;
    if (side == PSPLAT_ORACLE_FRONT) return;
    if (side == PSPLAT_ORACLE_BACK) {
        for (int i = 0; i < 3; ++i) normal[i] = -normal[i];
        return;
    }
    double away = psplat_oracle_dot(normal, toward) / psplat_oracle_dot(toward, toward);
    if (splat->is_curved) away = fmax(away, 0);
    psplat_oracle_along(normal, -2 * away, toward, normal);
}

/* ---- margins -------------------------------------------------------------------------------- */

double psplat_oracle_edge(double value, double by_u, double by_v, double steps[2][2]) {
    double x = by_u * steps[0][0] + by_v * steps[0][1];
    double y = by_u * steps[1][0] + by_v * steps[1][1];
    return value / fmax(1, sqrt(x * x + y * y));
}

/* Stores the normal of the surface or the wall that a fragment is on, of any length. */
static void find_normal(const psplat_oracle_splat *splat, const psplat_oracle_fragment *fragment,
                        double normal[3]) {
    psplat_oracle_surface_normal(splat, fragment->u, fragment->v, normal);
    if (!fragment->is_wall) return;
    for (int i = 0; i < 3; ++i)
        normal[i] = fragment->u * splat->parameter[0][i] + fragment->v * splat->parameter[1][i];
}

/* The ray's point at s moves with the ray and along it, so that it stays on the surface, whose
 * normal is n: s moves by -n.moved / n.d. */
void psplat_oracle_find_steps(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                              const psplat_oracle_ray *ray, const psplat_oracle_fragment *fragment,
                              double steps[2][2]) {
    psplat_oracle_ray_steps by;
    double normal[3];
    psplat_oracle_camera_ray_steps(camera, ray, &by);
    find_normal(splat, fragment, normal);
    double facing = psplat_oracle_dot(normal, ray->direction);
    for (int k = 0; k < 2; ++k) {
        double moved[3];
        psplat_oracle_along(by.origin[k], fragment->s, by.direction[k], moved);
        double s_by = -psplat_oracle_dot(normal, moved) / facing;
        psplat_oracle_along(moved, s_by, ray->direction, moved);
        steps[k][0] = psplat_oracle_dot(splat->parameter[0], moved);
        steps[k][1] = psplat_oracle_dot(splat->parameter[1], moved);
    }
}

/* Returns the margin to the contour of a curved surface, where D is 0. D over the squares of the
 * ray's and of the gradient's lengths is the square of the cosine where the ray meets the surface,
 * and below 0 where it misses. */
static double contour_margin(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                             const psplat_oracle_ray *ray, const psplat_oracle_fragment *fragment) {
    psplat_oracle_crossing crossing;
    psplat_oracle_ray_steps by;
    double normal[3], change[2];
    psplat_oracle_crossing_set(&crossing, splat, ray->origin, ray->direction);
    psplat_oracle_camera_ray_steps(camera, ray, &by);
    psplat_oracle_surface_normal(splat, fragment->u, fragment->v, normal);
    double unit = psplat_oracle_dot(normal, normal) * ray->length * ray->length;
    for (int k = 0; k < 2; ++k)
        change[k] =
            psplat_oracle_crossing_change(&crossing, splat, by.origin[k], by.direction[k]) / unit;
    return crossing.discriminant / unit / fmax(1, hypot(change[0], change[1]));
}

/* Returns the least margin to the ellipse and to the clip lines. */
static double edge_margin(const psplat_oracle_splat *splat, const psplat_oracle_fragment *fragment,
                          double steps[2][2]) {
    double u = fragment->u, v = fragment->v, r = fragment->r;
    double inverse = r > 0 ? 1 / r : 0;
    double least = psplat_oracle_edge(1 - r, u * inverse, v * inverse, steps);
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        double by[2], value = psplat_oracle_line_value(splat, k, u, v, by);
        double length = hypot(by[0], by[1]);
        least =
            fmin(least, psplat_oracle_edge(value / length, by[0] / length, by[1] / length, steps));
    }
    return least;
}

/* Returns the least margin to where the ray meets no wall. Where a ray goes in moves with it in a
 * way that differences of near rays tell well enough. */
static double wall_margin(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                          const psplat_oracle_ray *ray) {
    const double step = 1e-4; /* pixels */
    psplat_oracle_entry here, beside[2];
    double least = HUGE_VAL;
    psplat_oracle_entry_set(&here, splat, ray->origin, ray->direction);
    for (int k = 0; k < 2; ++k) {
        psplat_oracle_ray moved;
        psplat_oracle_camera_ray(camera, ray->x + step * !k, ray->y + step * k, &moved);
        psplat_oracle_entry_set(&beside[k], splat, moved.origin, moved.direction);
    }
    for (uint32_t k = 0; k < here.count; ++k) {
        double x = (beside[0].margins[k] - here.margins[k]) / step;
        double y = (beside[1].margins[k] - here.margins[k]) / step;
        least = fmin(least, here.margins[k] / fmax(1, hypot(x, y)));
    }
    return least;
}

psplat_oracle_margins psplat_oracle_fragment_margins(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat,
                                                     const psplat_oracle_ray *ray,
                                                     const psplat_oracle_fragment *fragment,
                                                     int cull) {
    double steps[2][2] = {{0}}, window = fmin(fragment->depth, 1 - fragment->depth);
    if (fragment->is_wall) return (psplat_oracle_margins){wall_margin(camera, splat, ray), window};
    if (!fragment->is_missed) psplat_oracle_find_steps(camera, splat, ray, fragment, steps);
    double least = edge_margin(splat, fragment, steps);
    if (splat->is_curved) least = fmin(least, contour_margin(camera, splat, ray, fragment));
    if (!fragment->is_missed) least = fmin(least, cull ? fragment->cosine : fabs(fragment->cosine));
    return (psplat_oracle_margins){least, window};
}
