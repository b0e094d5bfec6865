/* SPDX-License-Identifier: MIT
 *
 * filter.c - the screen-space filter (spec 5.8), a low-pass against aliasing: it widens splats that
 * are smaller than a pixel to one pixel, and softens their clip lines.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

/* ---- a splat's filter ------------------------------------------------------------------------ */

/* Computes J of spec 5.8. Window coordinates of a point C of clip space are
 * size / 2 (C_i / C_w + 1), and their derivative in the direction of A is
 * size / 2 (A_i C_w - C_i A_w) / C_w^2. */
static void jacobian_of(double frame[3][4], const double half[2], double jacobian[2][2]) {
    const double *center = frame[0];
    for (int i = 0; i < 2; ++i)
        for (int axis = 0; axis < 2; ++axis) {
            const double *along = frame[1 + axis];
            jacobian[i][axis] =
                half[i] * (along[i] * center[3] - center[i] * along[3]) / (center[3] * center[3]);
        }
}

static double determinant_of(double m[2][2]) {
    return m[0][0] * m[1][1] - m[0][1] * m[1][0];
}

/* Computes J' of eq. (10) by a singular value decomposition, as the spec words it. J^T J has its
 * eigenvectors m1 and m2 along half the angle of (m00 - m11, 2 m01) and perpendicular to it, and
 * J m_i is s_i l_i. Where s_i is 0, l_i is perpendicular to the other. */
static void widen(double jacobian[2][2], double widened[2][2]) {
    double(*j)[2] = jacobian, m[2][2], l[2][2], s[2];
    double angle =
        atan2(2 * (j[0][0] * j[0][1] + j[1][0] * j[1][1]),
              j[0][0] * j[0][0] + j[1][0] * j[1][0] - j[0][1] * j[0][1] - j[1][1] * j[1][1]) /
        2;
    m[0][0] = m[1][1] = cos(angle);
    m[0][1] = sin(angle);
    m[1][0] = -m[0][1];
    for (int i = 0; i < 2; ++i) l[0][i] = j[i][0] * m[0][0] + j[i][1] * m[0][1];
    s[0] = hypot(l[0][0], l[0][1]);
    s[1] = s[0] > 0 ? determinant_of(j) / s[0] : 0; /* signed, and without cancellation */
    for (int i = 0; i < 2; ++i) l[0][i] = s[0] > 0 ? l[0][i] / s[0] : m[0][i];
    l[1][0] = -l[0][1];
    l[1][1] = l[0][0];
    s[0] = fmax(s[0], 1);
    s[1] = s[1] < 0 ? fmin(s[1], -1) : fmax(s[1], 1);
    for (int row = 0; row < 2; ++row)
        for (int column = 0; column < 2; ++column)
            widened[row][column] =
                s[0] * l[0][row] * m[0][column] + s[1] * l[1][row] * m[1][column];
}

static double least_singular_value(double m[2][2]) {
    double more = hypot(m[0][0] + m[1][1], m[0][1] - m[1][0]);
    double less = hypot(m[0][0] - m[1][1], m[0][1] + m[1][0]);
    return fabs(more - less) / 2;
}

/* Returns how far the splat is from not being filtered; a negative margin means that it is not.
 * The filter applies where w changes little over the splat (edge), and where its centre lies
 * between the planes, by more than 2 |g| behind the near one (depth). */
static psplat_oracle_margins margins_of(double frame[3][4], double depth, double slope) {
    double w = frame[0][3];
    if (!(w > 0)) return (psplat_oracle_margins){-1, -1};
    double change = (fabs(frame[1][3]) + fabs(frame[2][3])) / w;
    return (psplat_oracle_margins){1 - 4 * change, fmin(depth - 2 * slope, 1 - depth)};
}

/* Returns |g| of spec 5.8, the derivative of window depth, which is 1/2 + C_z / C_w / 2. */
static double slope_of(double frame[3][4]) {
    double by[2], w = frame[0][3], z = frame[0][2] / w;
    for (int k = 0; k < 2; ++k) by[k] = (frame[1 + k][2] - z * frame[1 + k][3]) / w;
    return hypot(by[0], by[1]) / 2;
}

void psplat_oracle_filter_set(psplat_oracle_filter *filter, const psplat_oracle_camera *camera,
                              const psplat_oracle_splat *splat, int may_filter) {
    double half[2] = {0.5 * camera->width, 0.5 * camera->height}, before[2][2];
    *filter = (psplat_oracle_filter){.ratio = 1, .margins = {1, 1}};
    psplat_oracle_camera_frame(camera, splat, filter->frame);
    if (!may_filter || splat->is_curved) return;
    double *center = filter->frame[0], slope = slope_of(filter->frame);
    psplat_oracle_margins margins =
        margins_of(filter->frame, 0.5 + 0.5 * center[2] / center[3], slope);
    jacobian_of(filter->frame, half, before);
    double least = least_singular_value(before);
    if (!(least < 1)) return;
    filter->margins = margins;
    filter->is_on = margins.edge > 0 && margins.depth > 0;
    if (!filter->is_on) return;
    widen(before, filter->jacobian);
    filter->determinant = determinant_of(filter->jacobian);
    filter->softness = fmin(1 / least - 1, 1);
    filter->ratio = determinant_of(before) / filter->determinant;
    filter->nearer = fmin(1.1 * (1 / fmax(least, 0.05) - 1) * slope,
                          0.5 + 0.5 * center[2] / center[3] - 2 * slope);
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k)
            filter->frame[1 + k][i] +=
                (filter->jacobian[i][k] - before[i][k]) * center[3] / half[i];
}

/* ---- at a pixel ------------------------------------------------------------------------------ */

/* The widened splat's point on the ray, and the derivatives of its (u, v) by the pixel's x
 * (steps[0]) and y (steps[1]). */
typedef struct point {
    psplat_oracle_fragment f;
    double steps[2][2];
} point;

/* Solves the two linear equations for the point C'(u, v) whose x and y are those of the pixel times
 * its w. Returns 0 where there is no such point in front of the eye. */
static int find_point(const psplat_oracle_sight *sight, point *found) {
    const psplat_oracle_camera *camera = sight->camera;
    const double(*frame)[4] = sight->filter->frame;
    const double at[2] = {2 * sight->ray->x / camera->width - 1,
                          2 * sight->ray->y / camera->height - 1};
    const double pixel[2] = {2.0 / camera->width, 2.0 / camera->height};
    double m[2][2], right[2], center[4];
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 2; ++k) m[i][k] = frame[1 + k][i] - at[i] * frame[1 + k][3];
        right[i] = at[i] * frame[0][3] - frame[0][i];
    }
    double determinant = determinant_of(m);
    double u = (right[0] * m[1][1] - right[1] * m[0][1]) / determinant;
    double v = (right[1] * m[0][0] - right[0] * m[1][0]) / determinant;
    for (int i = 0; i < 4; ++i) center[i] = frame[0][i] + u * frame[1][i] + v * frame[2][i];
    if (!(isfinite(u) && isfinite(v) && center[3] > 0)) return 0;
    found->f = (psplat_oracle_fragment){
        .depth = 0.5 + 0.5 * center[2] / center[3], .u = u, .v = v, .r = hypot(u, v)};
    found->f.t = psplat_oracle_camera_reach(camera, sight->ray, found->f.depth);
    found->steps[0][0] = m[1][1] * pixel[0] * center[3] / determinant;
    found->steps[0][1] = -m[1][0] * pixel[0] * center[3] / determinant;
    found->steps[1][0] = -m[0][1] * pixel[1] * center[3] / determinant;
    found->steps[1][1] = m[0][0] * pixel[1] * center[3] / determinant;
    return 1;
}

/* Returns delta of clip line k, its distance in pixels. *scale becomes the number of pixels that a
 * unit of (u, v) spans perpendicular to the line. J'^-T is the matrix of cofactors over det J'. */
static double soft_distance(const psplat_oracle_sight *sight, uint32_t k,
                            const psplat_oracle_fragment *f, double *scale) {
    const double(*jacobian)[2] = sight->filter->jacobian;
    double by[2], value = psplat_oracle_line_value(sight->splat, k, f->u, f->v, by);
    double x = jacobian[1][1] * by[0] - jacobian[1][0] * by[1];
    double y = jacobian[0][0] * by[1] - jacobian[0][1] * by[0];
    double pixels = fabs(sight->filter->determinant) / hypot(x, y);
    *scale = pixels * hypot(by[0], by[1]);
    return value * pixels;
}

/* Returns the product of the factors of the lines that cut the shape. *least is lowered to the
 * least margin between a line's factor and 0. */
static double factor_of_lines(const psplat_oracle_sight *sight, const psplat_oracle_fragment *f,
                              double *least) {
    double factor = 1, scale = 1;
    for (uint32_t k = 0; k < sight->splat->clip_count; ++k) {
        double delta = soft_distance(sight, k, f, &scale);
        double t = sight->filter->softness;
        factor *= fmin(fmax(0.5 + delta / t, 0), 1);
        *least = fmin(*least, (0.5 * t + delta) / fmax(1, scale));
    }
    return factor;
}

/* What is left of the weight of a material beyond a seam (spec 3.6). */
static const double beyond_seams = 1.0 / 256;

/* Finds s of spec 3.6 where seams are hard. */
static void find_hard_seam(const psplat_oracle_sight *sight, psplat_oracle_share *share) {
    const psplat_oracle_splat *splat = sight->splat;
    share->seam = share->seam_margin = 1;
    for (uint32_t k = splat->clip_count; k < splat->line_count; ++k) {
        double by[2], value = psplat_oracle_line_value(splat, k, share->u, share->v, by);
        double length = hypot(by[0], by[1]);
        double margin =
            psplat_oracle_edge(value / length, by[0] / length, by[1] / length, share->steps);
        share->seam_margin = fmin(share->seam_margin, fabs(margin));
        if (!(value >= 0)) share->seam = beyond_seams;
    }
}

/* Does the same where the filter softens them. Over a ramp of t pixels s is as sharp as t is small,
 * so that t is what tells a hard seam from a soft one. */
static void find_soft_seam(const psplat_oracle_sight *sight, const psplat_oracle_fragment *f,
                           psplat_oracle_share *share) {
    double t = sight->filter->softness, scale = 1;
    share->seam = share->seam_margin = 1;
    for (uint32_t k = sight->splat->clip_count; k < sight->splat->line_count; ++k) {
        double delta = soft_distance(sight, k, f, &scale);
        share->seam *= fmin(fmax(0.5 + delta / t, 0), 1);
        share->seam_margin = fmin(share->seam_margin, fmax(fabs(delta) - t / 2, t));
    }
    share->seam = fmax(share->seam, beyond_seams);
}

/* Does what psplat_oracle_filter_share does, for a splat that is filtered. */
static int share_filtered(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                          psplat_oracle_margins *margins) {
    point at;
    double cosine = sight->splat->cosine, edge = sight->cull ? cosine : fabs(cosine);
    if (!find_point(sight, &at)) return 0;
    const psplat_oracle_fragment *f = &at.f;
    double factor = factor_of_lines(sight, f, &edge);
    *share = (psplat_oracle_share){.tested = f->t,
                                   .t = f->t,
                                   .depth = f->depth,
                                   .u = f->u,
                                   .v = f->v,
                                   .r = f->r,
                                   .factor = factor * sight->filter->ratio,
                                   .seen = psplat_oracle_fragment_side(sight->splat, f)};
    memcpy(share->steps, at.steps, sizeof share->steps);
    find_soft_seam(sight, f, share);
    double tested = f->depth - sight->filter->nearer;
    share->tested = psplat_oracle_camera_reach(sight->camera, sight->ray, tested);
    double inverse = f->r > 0 ? 1 / f->r : 0;
    if (margins)
        *margins = (psplat_oracle_margins){
            fmin(edge, psplat_oracle_edge(1 - f->r, f->u * inverse, f->v * inverse, at.steps)),
            fmin(tested, 1 - tested)};
    if (sight->cull && !(cosine > 0)) return 0;
    return f->r <= 1 && factor > 0 && tested >= 0 && tested <= 1;
}

int psplat_oracle_filter_share(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                               psplat_oracle_margins *margins) {
    const psplat_oracle_fragment *f = psplat_oracle_met(sight->meeting);
    *share = (psplat_oracle_share){.tested = HUGE_VAL};
    if (margins) *margins = (psplat_oracle_margins){-1, -1};
    if (sight->filter->is_on) return share_filtered(sight, share, margins);
    if (!f) return 0;
    *share = (psplat_oracle_share){.tested = f->t,
                                   .t = f->t,
                                   .depth = f->depth,
                                   .u = f->u,
                                   .v = f->v,
                                   .r = f->r,
                                   .factor = 1,
                                   .seen = psplat_oracle_fragment_side(sight->splat, f)};
    psplat_oracle_find_steps(sight->camera, sight->splat, sight->ray, f, share->steps);
    find_hard_seam(sight, share);
    return 1;
}
