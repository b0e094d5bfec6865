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
/* The weight where that one moves the surface off the heights by too much. Chosen by hand. */
static const double least_slope_weight = 3e-6;
/* The least cosine of a sample's normal whose slope is used, the greatest slope at the centre by
 * which the frame is turned, and the slope beyond which it is turned and fitted again. */
static const double least_cosine = 0.2, greatest_turn = 3, small_turn = 0.05;

enum { UNKNOWNS = 6 }; /* c, p, q, A, B, C */
enum { BLOCK = 32 };   /* samples that are turned into the frame in one go */

/* Sums over samples in units of the scale: powers s^i t^j by [i][j], heights and slopes times the
 * factors of the unknowns. */
typedef struct sums {
    double powers[5][5];
    double right[UNKNOWNS];
    double slopes[UNKNOWNS]; /* the part of right that stems from slopes */
} sums;

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

/* Samples in the frame of a region, in units of the scale: their places and heights, and their
 * slopes times the weight of slopes. */
typedef struct block {
    double s[BLOCK], t[BLOCK], h[BLOCK], x[BLOCK], y[BLOCK];
    size_t count;
} block;

static void add_powers(sums *m, const block *b) {
    sums a = *m; /* Sums of one function's own can stay in registers. */
    for (size_t i = 0; i < b->count; ++i) {
        double s = b->s[i], t = b->t[i], s2 = s * s, t2 = t * t, st = s * t;
        a.powers[1][0] += s, a.powers[0][1] += t;
        a.powers[2][0] += s2, a.powers[1][1] += st, a.powers[0][2] += t2;
        a.powers[3][0] += s2 * s, a.powers[2][1] += s2 * t;
        a.powers[1][2] += s * t2, a.powers[0][3] += t2 * t;
        a.powers[4][0] += s2 * s2, a.powers[3][1] += s2 * st, a.powers[2][2] += s2 * t2;
        a.powers[1][3] += st * t2, a.powers[0][4] += t2 * t2;
    }
    a.powers[0][0] += (double)b->count;
    *m = a;
}

static void add_right(sums *m, const block *b) {
    double right[UNKNOWNS], slopes[UNKNOWNS];
    memcpy(right, m->right, sizeof right);
    memcpy(slopes, m->slopes, sizeof slopes);
    for (size_t i = 0; i < b->count; ++i) {
        double s = b->s[i], t = b->t[i], h = b->h[i], x = b->x[i], y = b->y[i];
        right[0] += h;
        right[1] += h * s + x;
        right[2] += h * t + y;
        right[3] += h * s * s / 2 + x * s;
        right[4] += h * s * t + x * t + y * s;
        right[5] += h * t * t / 2 + y * t;
        slopes[1] += x, slopes[2] += y;
        slopes[3] += x * s, slopes[4] += x * t + y * s, slopes[5] += y * t;
    }
    memcpy(m->right, right, sizeof right);
    memcpy(m->slopes, slopes, sizeof slopes);
}

static void fill_block(block *b, const psplat_near_sample *samples, const uint32_t *some,
                       size_t first, const psplat_region *r, const double center[3], double scale) {
    double height[BLOCK];
    for (size_t i = 0; i < b->count; ++i) {
        const psplat_near_sample *sample = &samples[some ? some[first + i] : first + i];
        double d[3];
        sub3(d, sample->p, center);
        b->s[i] = dot3(d, r->u), b->t[i] = dot3(d, r->v), b->h[i] = dot3(d, r->n);
        height[i] = max2(dot3(sample->n, r->n), least_cosine);
        b->x[i] = -slope_weight * dot3(sample->n, r->u);
        b->y[i] = -slope_weight * dot3(sample->n, r->v);
    }
    for (size_t i = 0; i < b->count; ++i) { /* Divisions of neighbours can be done at once. */
        b->s[i] /= scale, b->t[i] /= scale, b->h[i] /= scale;
        b->x[i] /= height[i], b->y[i] /= height[i];
    }
}

/* Adds samples in their order, which rounding depends on. */
static void add_samples(sums *m, const psplat_near_sample *samples, const uint32_t *some,
                        size_t count, const psplat_region *r, const double center[3],
                        double scale) {
    block b;
    for (size_t first = 0; first < count; first += b.count) {
        b.count = count - first < BLOCK ? count - first : BLOCK;
        fill_block(&b, samples, some, first, r, center, scale);
        add_powers(m, &b);
        add_right(m, &b);
    }
}

/* Stores the normal equations' matrix: heights are (1, s, t, s^2/2, st, t^2/2) x, slopes
 * (0, 1, 0, s, t, 0) x and (0, 0, 1, 0, s, t) x. */
static void normal_matrix(const double p[5][5], double w, double m[UNKNOWNS][UNKNOWNS]) {
    static const int powers[UNKNOWNS][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    static const double factors[UNKNOWNS] = {1, 1, 1, 0.5, 1, 0.5};
    double trace = 0;
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

/* Solves the normal equations with a weight of slopes by the Cholesky factors L D L^T of the
 * matrix, of which only the lower half is read. With level, the slopes at the centre are 0. */
static void solve(const sums *sums, double weight, int level, double x[UNKNOWNS]) {
    double m[UNKNOWNS][UNKNOWNS];
    normal_matrix(sums->powers, weight, m);
    for (int i = 0; i < UNKNOWNS; ++i)
        x[i] = sums->right[i] - (1 - weight / slope_weight) * sums->slopes[i];
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

/* Returns the sum of the squared distances from the heights, but for a term that is the same for
 * all surfaces. */
static double height_error(const sums *sums, const double x[UNKNOWNS]) {
    double m[UNKNOWNS][UNKNOWNS], error = 0;
    normal_matrix(sums->powers, 0, m);
    for (int i = 0; i < UNKNOWNS; ++i) {
        error += x[i] * (m[i][i] * x[i] - 2 * (sums->right[i] - sums->slopes[i]));
        for (int k = 0; k < i; ++k) error += 2 * x[i] * m[i][k] * x[k];
    }
    return error;
}

/* Solves the normal equations with the weight of slopes, or with the least one where that moves the
 * surface off the heights by more than most_pull, root mean square, in units of the scale. */
static void solve_bounded(const sums *sums, double most_pull, int level, double x[UNKNOWNS]) {
    double other[UNKNOWNS];
    solve(sums, slope_weight, level, x);
    if (!(most_pull < HUGE_VAL)) return;
    solve(sums, least_slope_weight, level, other);
    double more = height_error(sums, x) - height_error(sums, other);
    if (more > most_pull * most_pull * sums->powers[0][0]) memcpy(x, other, sizeof other);
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

int psplat_fit_surface(const psplat_near_sample *samples, const uint32_t *some, size_t count,
                       const double origin[3], double most_pull, psplat_region *r) {
    double scale = max2(r->radius[0], r->radius[1]), x[UNKNOWNS];
    memset(r->slope, 0, sizeof r->slope);
    memset(r->hessian, 0, sizeof r->hessian);
    for (int step = 0, level = 0; step < 3; ++step) {
        sums m = {.right = {0}};
        double center[3];
        sub3(center, r->center, origin);
        add_samples(&m, samples, some, count, r, center, scale);
        solve_bounded(&m, most_pull / scale, level, x);
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
