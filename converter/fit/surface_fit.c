/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_fit.c - the least-squares fit of a splat's curved surface to samples.
 *
 * In the region's frame the surface is the height c + p s + q t + (A s^2 + 2 B s t + C t^2) / 2.
 * Its six coefficients follow from the samples' heights and, with a small weight, from the slopes
 * of their normals, which determine them where few samples lie in a row (Hermite data, as in
 * algebraic point set surfaces, Guennebaud, Gross 2007). The normal equations need nothing but sums
 * of products of the samples' coordinates. The frame is then turned into the tangent plane at the
 * centre, so that files need not store the slopes there.
 */
#include "fit/surface_fit.h"

#include "base/vector.h"

#include <math.h>
#include <string.h>

/* The weight of the equations of slopes against those of heights, in units of the radius, and the
 * part of the trace that is added to the normal equations' diagonal so that few samples have a
 * solution too: with second derivatives of 0 where nothing is known of them. Chosen by hand. */
static const double slope_weight = 0.03, ridge_part = 1e-9;
/* The least cosine of a sample's normal whose slope is used, the greatest slope at the centre by
 * which the frame is turned, and the slope beyond which it is turned and fitted again. */
static const double least_cosine = 0.2, greatest_turn = 3, small_turn = 0.05;

enum { UNKNOWNS = 6 }; /* c, p, q, A, B, C */

/* Samples are added in so many lanes, of which compilers make vectors. */
enum { LANES = 2 };

/* The products that are summed up: powers s^i t^j of degree 0 to 4, and heights and slopes times
 * the factors of the unknowns. */
enum { POWERS = 15, PRODUCTS = POWERS + UNKNOWNS };

/* Sums over samples in units of the scale, of each product in each lane. */
typedef struct sums {
    double of[PRODUCTS][LANES];
} sums;

/* What samples are seen from: a region's frame in units of the scale. */
typedef struct frame {
    double center[3];
    double u[3], v[3], n[3]; /* divided by the scale */
    double scale;
} frame;

double psplat_surface_sagitta(const psplat_region *r) {
    double radius = max2(r->radius[0], r->radius[1]);
    return psplat_region_bend(r) * radius * radius / 2;
}

double psplat_surface_slope_bound(const psplat_region *r) {
    const double *h = r->hessian;
    double a = h[0] * r->radius[0], b = h[1] * r->radius[0], c = h[2] * r->radius[1];
    double ratio = r->radius[1] / r->radius[0];
    return norm2(r->slope[0], r->slope[1]) + sqrt(a * a + c * c + b * b * (1 + ratio * ratio));
}

/* Adds a sample in each lane, of a weight of 0 or 1. */
static void add_samples(sums *m, const psplat_near_sample *const samples[LANES],
                        const double weights[LANES], const frame *r) {
    double x[PRODUCTS][LANES];
    for (int l = 0; l < LANES; ++l) {
        const double *n = samples[l]->n, w = weights[l];
        double d[3];
        sub3(d, samples[l]->p, r->center);
        double s = w * dot3(d, r->u), t = w * dot3(d, r->v), h = w * dot3(d, r->n);
        double turn = -slope_weight / max2(dot3(n, r->n) * r->scale, least_cosine) * r->scale * w;
        double a = turn * dot3(n, r->u), b = turn * dot3(n, r->v);
        double s2 = s * s, t2 = t * t, st = s * t;
        x[0][l] = w, x[1][l] = s, x[2][l] = t, x[3][l] = s2, x[4][l] = st, x[5][l] = t2;
        x[6][l] = s2 * s, x[7][l] = s2 * t, x[8][l] = s * t2, x[9][l] = t2 * t;
        x[10][l] = s2 * s2, x[11][l] = s2 * st, x[12][l] = s2 * t2, x[13][l] = st * t2;
        x[14][l] = t2 * t2;
        x[15][l] = h, x[16][l] = h * s + a, x[17][l] = h * t + b;
        x[18][l] = h * s2 / 2 + a * s, x[19][l] = h * st + a * t + b * s;
        x[20][l] = h * t2 / 2 + b * t;
    }
    for (int k = 0; k < PRODUCTS; ++k)
        for (int l = 0; l < LANES; ++l) m->of[k][l] += x[k][l];
}

/* Sums up samples (indices; NULL: the first count). */
static void sum_up(sums *m, const psplat_near_sample *samples, const uint32_t *some, size_t count,
                   const frame *r) {
    for (size_t i = 0; i < count; i += LANES) {
        const psplat_near_sample *lanes[LANES];
        double weights[LANES];
        for (size_t l = 0; l < LANES; ++l) {
            size_t at = i + l < count ? i + l : i;
            lanes[l] = &samples[some ? some[at] : at];
            weights[l] = at == i + l;
        }
        add_samples(m, lanes, weights, r);
    }
}

/* Adds up the lanes, and stores the powers s^i t^j by [i][j]. */
static void unite_lanes(const sums *m, double powers[5][5], double right[UNKNOWNS]) {
    double total[PRODUCTS] = {0};
    for (int k = 0; k < PRODUCTS; ++k)
        for (int l = 0; l < LANES; ++l) total[k] += m->of[k][l];
    for (int degree = 0, at = 0; degree < 5; ++degree)
        for (int j = 0; j <= degree; ++j) powers[degree - j][j] = total[at++];
    memcpy(right, total + POWERS, UNKNOWNS * sizeof *right);
}

/* Stores the normal equations' matrix: heights are (1, s, t, s^2/2, st, t^2/2) x, slopes
 * (0, 1, 0, s, t, 0) x and (0, 0, 1, 0, s, t) x. */
static void normal_matrix(const double p[5][5], double m[UNKNOWNS][UNKNOWNS]) {
    static const int powers[UNKNOWNS][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    static const double factors[UNKNOWNS] = {1, 1, 1, 0.5, 1, 0.5};
    double w = slope_weight, trace = 0;
    for (int i = 0; i < UNKNOWNS; ++i)
        for (int j = 0; j < UNKNOWNS; ++j)
            m[i][j] = factors[i] * factors[j] *
                      p[powers[i][0] + powers[j][0]][powers[i][1] + powers[j][1]];
    m[1][1] += w * p[0][0], m[2][2] += w * p[0][0];
    m[3][1] += w * p[1][0], m[4][1] += w * p[0][1];
    m[4][2] += w * p[1][0], m[5][2] += w * p[0][1];
    m[3][3] += w * p[2][0], m[4][4] += w * (p[2][0] + p[0][2]), m[5][5] += w * p[0][2];
    m[4][3] += w * p[1][1], m[5][4] += w * p[1][1];
    for (int i = 0; i < UNKNOWNS; ++i) trace += m[i][i];
    for (int i = 0; i < UNKNOWNS; ++i) m[i][i] += ridge_part * trace;
}

/* Solves the normal equations by the Cholesky factors L D L^T of the matrix, of which only the
 * lower half is read. With level, the slopes at the centre are 0. */
static void solve(const sums *sums, int level, double x[UNKNOWNS]) {
    double m[UNKNOWNS][UNKNOWNS], powers[5][5] = {{0}};
    unite_lanes(sums, powers, x);
    normal_matrix((const double(*)[5])powers, m);
    for (int i = 1; level && i <= 2; ++i) {
        for (int k = 0; k < UNKNOWNS; ++k) m[i][k] = m[k][i] = 0;
        m[i][i] = 1, x[i] = 0;
    }
    for (int i = 0; i < UNKNOWNS; ++i) {
        for (int j = 0; j < i; ++j) {
            for (int k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k] * m[k][k];
            m[i][j] /= m[j][j];
        }
        for (int k = 0; k < i; ++k) m[i][i] -= m[i][k] * m[i][k] * m[k][k];
        for (int k = 0; k < i; ++k) x[i] -= m[i][k] * x[k];
    }
    for (int i = 0; i < UNKNOWNS; ++i) x[i] /= m[i][i];
    for (int i = UNKNOWNS; i-- > 0;)
        for (int k = i + 1; k < UNKNOWNS; ++k) x[i] -= m[k][i] * x[k];
}

/* Turns the frame so that a surface of these slopes at the centre gets n for its normal there. */
static void turn_frame(psplat_region *r, const double slope[2]) {
    double u[3];
    mad3(r->n, -slope[0], r->u);
    mad3(r->n, -slope[1], r->v);
    normalize3(r->n);
    memcpy(u, r->u, sizeof u);
    mad3(u, -dot3(u, r->n), r->n);
    normalize3(u);
    memcpy(r->u, u, sizeof u);
    cross3(r->v, r->n, r->u);
}

static frame frame_of(const psplat_region *r, const double origin[3], double scale) {
    frame seen = {.scale = scale};
    sub3(seen.center, r->center, origin);
    for (int k = 0; k < 3; ++k) {
        seen.u[k] = r->u[k] / scale;
        seen.v[k] = r->v[k] / scale;
        seen.n[k] = r->n[k] / scale;
    }
    return seen;
}

int psplat_fit_surface(const psplat_near_sample *samples, const uint32_t *some, size_t count,
                       const double origin[3], psplat_region *r) {
    double scale = max2(r->radius[0], r->radius[1]), x[UNKNOWNS];
    memset(r->slope, 0, sizeof r->slope);
    memset(r->hessian, 0, sizeof r->hessian);
    for (int step = 0, level = 0; step < 3; ++step) {
        sums m = {.of = {{0}}};
        const frame seen = frame_of(r, origin, scale);
        sum_up(&m, samples, some, count, &seen);
        solve(&m, level, x);
        mad3(r->center, x[0] * scale, r->n);
        if (level) break;
        double turn = norm2(x[1], x[2]);
        if (!(turn <= greatest_turn)) return 0;
        turn_frame(r, x + 1);
        level = step == 1 || turn <= small_turn;
    }
    for (int k = 0; k < 3; ++k) r->hessian[k] = x[3 + k] / scale;
    return 1;
}
