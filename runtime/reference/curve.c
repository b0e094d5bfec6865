/* SPDX-License-Identifier: MIT
 *
 * curve.c - the second order of a splat: where a ray crosses the quadric of a curved splat (spec
 * 3.4 and 5.1) and the wall under its rim, the normals of that surface, and clip lines, straight
 * and bent (spec 3.6).
 *
 * In the splat's own coordinates (u, v, w) a transform of the node is forgotten: rays stay rays,
 * and the surface is f = 0 with the f of oracle.h, which is above 0 on its front.
 */
#include "reference/oracle.h"

#include <math.h>

/* Multiplies u and v by the surface's second derivatives. */
static void apply_bend(const double bend[3], const double uv[2], double out[2]) {
    out[0] = bend[0] * uv[0] + bend[1] * uv[1];
    out[1] = bend[1] * uv[0] + bend[2] * uv[1];
}

/* F(s) is f along the ray: f at s0, its derivative there in the ray's direction, and half of its
 * second derivative in that direction. */
void psplat_oracle_crossing_set(psplat_oracle_crossing *c, const psplat_oracle_splat *splat,
                                const double origin[3], const double direction[3]) {
    double from_center[3], *o = c->origin, *d = c->direction, bent_o[2], bent_d[2];
    psplat_oracle_along(origin, -1, splat->center, from_center);
    for (int k = 0; k < 3; ++k) {
        o[k] = psplat_oracle_dot(splat->parameter[k], from_center);
        d[k] = psplat_oracle_dot(splat->parameter[k], direction);
    }
    c->s0 = -psplat_oracle_dot(o, d) / psplat_oracle_dot(d, d);
    psplat_oracle_along(o, c->s0, d, o);
    apply_bend(splat->bend, o, bent_o);
    apply_bend(splat->bend, d, bent_d);
    c->height[0] = o[2];
    c->height[1] = d[2];
    c->height[2] = 0;
    for (int k = 0; k < 2; ++k) {
        c->height[0] += (splat->slope[k] + bent_o[k] / 2) * o[k];
        c->height[1] += (splat->slope[k] + bent_o[k]) * d[k];
        c->height[2] += bent_d[k] * d[k] / 2;
    }
    c->discriminant = c->height[1] * c->height[1] - 4 * c->height[0] * c->height[2];
}

/* Of the two forms of a root that are equal in exact arithmetic it takes the one that adds numbers
 * of equal signs, which is right also where F is linear. */
double psplat_oracle_crossing_root(const psplat_oracle_crossing *c, int is_back) {
    const double *h = c->height;
    double slope = is_back ? sqrt(c->discriminant) : -sqrt(c->discriminant);
    double s = h[1] * slope > 0 ? -2 * h[0] / (h[1] + slope) : (slope - h[1]) / (2 * h[2]);
    return c->s0 + s;
}

double psplat_oracle_crossing_middle(const psplat_oracle_crossing *c) {
    return c->s0 - c->height[1] / (2 * c->height[2]);
}

/* What s0 is does not change D, so it is held. */
double psplat_oracle_crossing_change(const psplat_oracle_crossing *c,
                                     const psplat_oracle_splat *splat, const double origin[3],
                                     const double direction[3]) {
    double at_s0[3], o[3], d[3], gradient[3], bent_o[2], bent_d[2], change[3];
    psplat_oracle_along(origin, c->s0, direction, at_s0);
    for (int k = 0; k < 3; ++k) {
        o[k] = psplat_oracle_dot(splat->parameter[k], at_s0);
        d[k] = psplat_oracle_dot(splat->parameter[k], direction);
    }
    apply_bend(splat->bend, c->origin, gradient);
    apply_bend(splat->bend, c->direction, bent_d);
    apply_bend(splat->bend, o, bent_o);
    for (int k = 0; k < 2; ++k) gradient[k] += splat->slope[k];
    gradient[2] = 1;
    change[0] = psplat_oracle_dot(gradient, o);
    change[1] =
        psplat_oracle_dot(gradient, d) + bent_o[0] * c->direction[0] + bent_o[1] * c->direction[1];
    change[2] = bent_d[0] * d[0] + bent_d[1] * d[1];
    return 2 * c->height[1] * change[1] - 4 * (change[0] * c->height[2] + c->height[0] * change[2]);
}

void psplat_oracle_surface_normal(const psplat_oracle_splat *splat, double u, double v,
                                  double normal[3]) {
    double uv[2] = {u, v}, bent[2];
    const double *from = splat->is_curved ? splat->parameter[2] : splat->side;
    for (int i = 0; i < 3; ++i) normal[i] = from[i];
    if (!splat->is_curved) return;
    apply_bend(splat->bend, uv, bent);
    for (int k = 0; k < 2; ++k)
        psplat_oracle_along(normal, splat->slope[k] + bent[k], splat->parameter[k], normal);
}

/* Between its roots F is at least -F'^2 / 4a. */
int psplat_oracle_is_peeking(const psplat_oracle_splat *splat, double first, double half_second) {
    return first > 0 && half_second > 0 && first * first <= 4 * half_second * splat->peek;
}

double psplat_oracle_line_value(const psplat_oracle_splat *splat, uint32_t k, double u, double v,
                                double slope[2]) {
    const double *line = splat->clip[k];
    double bend = line[3], along = line[0] * v - line[1] * u;
    if (slope) {
        slope[0] = line[0] - bend * along * line[1];
        slope[1] = line[1] + bend * along * line[0];
    }
    return line[0] * u + line[1] * v + line[2] + bend * along * along / 2;
}

int psplat_oracle_is_inside(const psplat_oracle_splat *splat, double u, double v) {
    if (!(u * u + v * v <= 1)) return 0;
    for (uint32_t k = 0; k < splat->clip_count; ++k)
        if (!(psplat_oracle_line_value(splat, k, u, v, NULL) >= 0)) return 0;
    return 1;
}

/* With the ray at o + t d and in (u, v) alone, t is -(o.d) / d.d next to the axis, where the ray is
 * |o x d| / |d| from it, and half a chord of the unit circle before that on the circle. */
void psplat_oracle_entry_set(psplat_oracle_entry *entry, const psplat_oracle_splat *splat,
                             const double origin[3], const double direction[3]) {
    psplat_oracle_crossing c;
    psplat_oracle_crossing_set(&c, splat, origin, direction);
    const double *o = c.origin, *d = c.direction, *h = c.height;
    double length2 = d[0] * d[0] + d[1] * d[1], away = o[0] * d[1] - o[1] * d[0];
    double half_chord = sqrt(fmax(length2 - away * away, 0));
    double t = -(o[0] * d[0] + o[1] * d[1] + half_chord) / length2;
    double height = h[0] + t * (h[1] + t * h[2]), u = o[0] + t * d[0], v = o[1] + t * d[1];
    entry->s = c.s0 + t;
    entry->margins[0] = 1 - fabs(away) / sqrt(length2);
    entry->margins[1] = height + splat->wall;
    entry->margins[2] = -height;
    entry->margins[3] = -(h[1] + 2 * t * h[2]) / psplat_oracle_length(d);
    entry->count = 4 + splat->clip_count;
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        double by[2], value = psplat_oracle_line_value(splat, k, u, v, by);
        entry->margins[4 + k] = value / hypot(by[0], by[1]);
    }
}

int psplat_oracle_entry_meets(const psplat_oracle_entry *entry) {
    for (uint32_t k = 0; k < entry->count; ++k)
        if (!(entry->margins[k] > 0)) return 0;
    return isfinite(entry->s);
}
