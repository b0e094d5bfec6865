/* SPDX-License-Identifier: MIT
 * Spec 5.8: the screen-space filter (Botsch et al. 2005, section 5), which widens to a pixel what
 * is smaller and softens clip lines. */
#include "oracle.h"

#include <math.h>

/* Window coordinates of clip space point C are size / 2 (C_i / C_w + 1), and their derivative in
 * the direction of A is size / 2 (A_i C_w - C_i A_w) / C_w^2. */
static void project(psplat_oracle_filter *filter, const psplat_oracle_camera *camera,
                    const psplat_oracle_splat *splat, double center[4]) {
    double half[2] = {0.5 * camera->width, 0.5 * camera->height}, moved[4];
    psplat_oracle_transform(camera->projection, splat->center, 1, center);
    for (int i = 0; i < 2; ++i) filter->center[i] = half[i] * (center[i] / center[3] + 1);
    for (int axis = 0; axis < 2; ++axis) {
        psplat_oracle_transform(camera->projection, splat->axis[axis], 0, moved);
        for (int i = 0; i < 2; ++i)
            filter->jacobian[i][axis] =
                half[i] * (moved[i] * center[3] - center[i] * moved[3]) / (center[3] * center[3]);
    }
}

/* Of J^T J the eigenvectors lie along the angle atan2(2 m01, m00 - m11) / 2 and across it. s1 and
 * s2 are the sum and the difference of the lengths of J's parts that keep and flip orientation;
 * |det J| / s1 does not cancel. */
static void decompose(psplat_oracle_filter *filter) {
    double a = filter->jacobian[0][0], b = filter->jacobian[0][1];
    double c = filter->jacobian[1][0], d = filter->jacobian[1][1];
    filter->determinant = a * d - b * c;
    filter->singular[0] = (hypot(a + d, b - c) + hypot(a - d, b + c)) / 2;
    filter->singular[1] =
        filter->singular[0] > 0 ? fabs(filter->determinant) / filter->singular[0] : 0;
    double angle = atan2(2 * (a * b + c * d), a * a + c * c - b * b - d * d) / 2;
    filter->minor[0] = -sin(angle);
    filter->minor[1] = cos(angle);
}

void psplat_oracle_filter_set(psplat_oracle_filter *filter, const psplat_oracle_camera *camera,
                              const psplat_oracle_splat *splat, int is_on) {
    double center[4];
    *filter = (psplat_oracle_filter){.size = PSPLAT_ORACLE_UNFILTERED};
    if (!is_on) return;
    project(filter, camera, splat, center);
    filter->depth = 0.5 + 0.5 * center[2] / center[3];
    if (!(center[3] > 0 && fabs(center[2]) < center[3])) return;
    decompose(filter);
    filter->size = filter->singular[1] >= 1  ? PSPLAT_ORACLE_LARGE
                   : filter->singular[0] > 1 ? PSPLAT_ORACLE_THIN
                                             : PSPLAT_ORACLE_SMALL;
}

static int within(double at, int size) {
    return (int)fmin(fmax(at, 0), size);
}

void psplat_oracle_filter_widen(const psplat_oracle_filter *filter,
                                const psplat_oracle_camera *camera, psplat_oracle_box *box) {
    if (filter->size < PSPLAT_ORACLE_THIN) return;
    const double reach = 2; /* d <= 1, and one pixel around */
    psplat_oracle_box disc = {within(floor(filter->center[0] - reach), camera->width),
                              within(ceil(filter->center[0] + reach), camera->width),
                              within(floor(filter->center[1] - reach), camera->height),
                              within(ceil(filter->center[1] + reach), camera->height)};
    if (box->x0 >= box->x1 || box->y0 >= box->y1) *box = disc;
    box->x0 = disc.x0 < box->x0 ? disc.x0 : box->x0;
    box->x1 = disc.x1 > box->x1 ? disc.x1 : box->x1;
    box->y0 = disc.y0 < box->y0 ? disc.y0 : box->y0;
    box->y1 = disc.y1 > box->y1 ? disc.y1 : box->y1;
}

/* ---- clip lines ------------------------------------------------------------------------------ */

/* A line's distance in pixels and how many pixels a unit of (u, v) is across it. J^-T = cof J / det
 * J, and J^-1 is the transpose of that: multiplied out, nothing is divided by det J, which is 0 for
 * splats seen along their plane. */
typedef struct soft_line {
    double delta, scale;
} soft_line;

static soft_line soften(const psplat_oracle_sight *sight, const double line[3],
                        const double from_center[2]) {
    const psplat_oracle_filter *filter = sight->filter;
    const psplat_oracle_fragment *f = sight->fragment;
    const double sharp = 1e6; /* a line without a direction in the image, which is hard */
    double x = filter->jacobian[1][1] * line[0] - filter->jacobian[1][0] * line[1];
    double y = filter->jacobian[0][0] * line[1] - filter->jacobian[0][1] * line[0];
    double length = hypot(x, y), area = fabs(filter->determinant);
    if (!(length > 0)) return (soft_line){sharp * line[2], sharp};
    double scale = area * hypot(line[0], line[1]) / length;
    double across = x * from_center[0] + y * from_center[1];
    double value = filter->size == PSPLAT_ORACLE_SMALL
                       ? line[2] * area + (filter->determinant < 0 ? -across : across)
                       : (line[0] * f->u + line[1] * f->v + line[2]) * area;
    return (soft_line){value / length, scale};
}

/* The product of the lines' factors; least becomes the least margin to a factor of 0. */
static double factor_of(const psplat_oracle_sight *sight, const double from_center[2],
                        double *least) {
    double factor = 1;
    for (uint32_t k = 0; k < sight->splat->clip_count; ++k) {
        soft_line line = soften(sight, sight->splat->clip[k], from_center);
        factor *= fmin(fmax(0.5 + line.delta, 0), 1);
        *least = fmin(*least, (0.5 + line.delta) / fmax(1, line.scale));
    }
    return factor;
}

/* ---- shares ---------------------------------------------------------------------------------- */

static double ellipse_margin(const psplat_oracle_sight *sight, double radius) {
    const psplat_oracle_fragment *f = sight->fragment;
    double steps[2][2], inverse = f->r > 0 ? 1 / f->r : 0;
    psplat_oracle_fragment_steps(sight->camera, sight->splat, sight->ray, f->s, steps);
    return psplat_oracle_edge(radius - f->r, f->u * inverse, f->v * inverse, steps);
}

/* s2 < 1 < s1: within the ellipse, or within a pixel of c and four radii. */
static double thin_margin(const psplat_oracle_sight *sight, double distance) {
    return fmax(ellipse_margin(sight, 1), fmin(1 - distance, ellipse_margin(sight, 4)));
}

static int is_seen(const psplat_oracle_sight *sight, double depth) {
    return depth >= 0 && depth <= 1 && !(sight->cull && !(sight->splat->cosine > 0));
}

/* Fragments of the plane: 5.1 without the filter. */
static int share_of_fragment(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                             psplat_oracle_margins *margins) {
    const psplat_oracle_fragment *f = sight->fragment;
    *share = (psplat_oracle_share){f->t, f->depth, f->r, f->u, f->v, 1};
    if (margins)
        *margins =
            psplat_oracle_fragment_margins(sight->camera, sight->splat, sight->ray, f, sight->cull);
    return psplat_oracle_fragment_exists(sight->splat, f, sight->cull);
}

/* s1 > 1: on the plane. */
static int share_of_plane(const psplat_oracle_sight *sight, const double from_center[2],
                          psplat_oracle_share *share, psplat_oracle_margins *margins) {
    const psplat_oracle_filter *filter = sight->filter;
    const psplat_oracle_fragment *f = sight->fragment;
    int is_thin = filter->size == PSPLAT_ORACLE_THIN;
    double distance = hypot(from_center[0], from_center[1]), cosine = sight->splat->cosine;
    double along = filter->minor[0] * f->u + filter->minor[1] * f->v;
    double less = is_thin ? along * (1 - fmax(filter->singular[1], 0.25)) : 0;
    double edge = sight->cull ? cosine : fabs(cosine);
    *share = (psplat_oracle_share){
        .t = f->t,
        .depth = f->depth,
        .r = is_thin ? fmin(f->r, distance) : f->r,
        .u = f->u - less * filter->minor[0],
        .v = f->v - less * filter->minor[1],
        .factor = factor_of(sight, from_center, &edge),
    };
    if (margins) {
        double inside = is_thin ? thin_margin(sight, distance) : ellipse_margin(sight, 1);
        *margins = (psplat_oracle_margins){fmin(edge, inside), fmin(f->depth, 1 - f->depth)};
    }
    int is_inside = f->r <= 1 || (is_thin && distance <= 1 && f->r <= 4);
    return is_inside && share->factor > 0 && is_seen(sight, f->depth);
}

/* s1 <= 1: a disc of a pixel's radius that faces the eye. */
static int share_of_disc(const psplat_oracle_sight *sight, const double from_center[2],
                         psplat_oracle_share *share, psplat_oracle_margins *margins) {
    const psplat_oracle_filter *filter = sight->filter;
    double distance = hypot(from_center[0], from_center[1]), edge = 1 - distance;
    *share = (psplat_oracle_share){
        .t = psplat_oracle_camera_reach(sight->camera, sight->ray, filter->depth),
        .depth = filter->depth,
        .r = distance,
        .factor = factor_of(sight, from_center, &edge),
    };
    if (sight->cull) edge = fmin(edge, sight->splat->cosine);
    if (margins) *margins = (psplat_oracle_margins){edge, fmin(filter->depth, 1 - filter->depth)};
    return distance <= 1 && share->factor > 0 && is_seen(sight, filter->depth);
}

int psplat_oracle_filter_share(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                               psplat_oracle_margins *margins) {
    const psplat_oracle_filter *filter = sight->filter;
    double from_center[2] = {sight->ray->x - filter->center[0], sight->ray->y - filter->center[1]};
    if (margins) *margins = (psplat_oracle_margins){-1, -1};
    if (filter->size == PSPLAT_ORACLE_SMALL)
        return share_of_disc(sight, from_center, share, margins);
    if (!sight->fragment) return 0;
    if (filter->size == PSPLAT_ORACLE_UNFILTERED) return share_of_fragment(sight, share, margins);
    return share_of_plane(sight, from_center, share, margins);
}
