/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * curved_distance.c - distance of a point to a region with a curved surface or bent lines.
 *
 * The point of the whole quadric that is nearest to a point is found in one variable (foot_point).
 * Where the region holds it, it is the answer, and elsewhere no answer can be less. Then the
 * nearest point lies on the rim: on the ellipse or on one of the lines, which are cut where they
 * meet each other. Along each of these curves the distance is searched by branch and bound
 * (search_between). Only from a point farther away than a radius of curvature can the distance have
 * another minimum within the region; all points where it is stationary are the roots of a
 * polynomial (try_stationary).
 */
#include "base/curved_distance.h"

#include "base/angle.h"
#include "base/polynomial.h"
#include "base/region.h"
#include "base/vector.h"

#include <math.h>
#include <string.h>

/* How much the result may exceed the distance, in units of the first radius; what points are moved
 * by that lie where the quadric has two nearest points; and the most steps of an iteration. */
static const double accuracy = 3e-7, nudge = 1e-8;
enum {
    MAX_STEPS = 60,
    MAX_PLACES = 4 * PSPLAT_MAX_CLIP_LINES + 2,
    MAX_PARTS = 8,
    MAX_NEAR_STEPS = 8
};

/* The width, in radians or radii, in which the distance along a curve of the rim has one minimum:
 * two of them so near each other differ by its fourth power over some hundreds. */
static const double smooth_width = 0.1;

/* A point and a region in the coordinates of the region, as lengths along u, v and n. */
typedef struct query {
    const psplat_region *region;
    double point[3];
    double best; /* the least distance found, or the limit */
    int met;     /* whether a point of the region was seen */
} query;

/* ---- the whole quadric ---------------------------------------------------------------------- */

/* The quadric along the directions of its principal curvatures: the height at x is
 * sum(slope x + curvature x^2 / 2) over both. The point is there at p and at height z. */
typedef struct quadric {
    double axes[2][2], curvature[2], slope[2], p[2], z;
} quadric;

/* Moves the point off the planes of symmetry, from which the quadric has two nearest points. */
static void leave_symmetry(quadric *r, double step) {
    for (int i = 0; i < 2; ++i) {
        double off = r->p[i] * r->curvature[i] + r->slope[i];
        double least = step * fabs(r->curvature[i]);
        if (fabs(off) < least) r->p[i] += copysign(step, r->curvature[i]);
    }
}

static quadric quadric_of(const query *q) {
    const double *h = q->region->hessian;
    double angle = 0.5 * atan2(2 * h[1], h[0] - h[2]), c = cos(angle), s = sin(angle);
    double mean = (h[0] + h[2]) / 2, spread = hypot((h[0] - h[2]) / 2, h[1]);
    quadric r = {.axes = {{c, s}, {-s, c}}, .curvature = {mean + spread, mean - spread}};
    r.z = q->point[2];
    for (int i = 0; i < 2; ++i) {
        r.slope[i] = r.axes[i][0] * q->region->slope[0] + r.axes[i][1] * q->region->slope[1];
        r.p[i] = r.axes[i][0] * q->point[0] + r.axes[i][1] * q->point[1];
    }
    leave_symmetry(&r, nudge * q->region->radius[0]);
    return r;
}

/* Stores the point x of the quadric of which the distance is stationary, given how far it lies
 * above the point: (1 + w curvature) x = p - w slope. */
static void stationary_point(const quadric *r, double w, double x[2]) {
    for (int i = 0; i < 2; ++i) x[i] = (r->p[i] - w * r->slope[i]) / (1 + w * r->curvature[i]);
}

/* Returns how much higher than w the quadric lies over the point at stationary_point(w), and its
 * derivative by w. */
static double excess(const quadric *r, double w, double *derivative) {
    double x[2], height = 0;
    stationary_point(r, w, x);
    *derivative = -1;
    for (int i = 0; i < 2; ++i) {
        double slope = r->slope[i] + r->curvature[i] * x[i];
        height += (r->slope[i] + slope) * x[i] / 2;
        *derivative -= slope * slope / (1 + w * r->curvature[i]);
    }
    return height - r->z - w;
}

/* Turns a point of the principal directions into lengths along u and v. */
static void to_plane(const quadric *r, double x[2]) {
    double s = x[0] * r->axes[0][0] + x[1] * r->axes[1][0];
    x[1] = x[0] * r->axes[0][1] + x[1] * r->axes[1][1];
    x[0] = s;
}

/* Stores the point of the quadric that is nearest. That is a minimum under one quadratic condition,
 * so that its multiplier w makes 1 + w curvature positive, and between the poles the excess falls
 * by more than w rises: it has one root, which Newton's steps find, or halving where they leave the
 * range. */
static void foot_point(const quadric *r, double radius, double x[2]) {
    double slope, value = excess(r, 0, &slope), low = min2(value, 0), high = max2(value, 0), w = 0;
    for (int i = 0; i < 2; ++i) {
        double pole = -1 / r->curvature[i];
        if (r->curvature[i] > 0) low = max2(low, pole);
        if (r->curvature[i] < 0) high = min2(high, pole);
    }
    for (int step = 0; step < MAX_STEPS; ++step) {
        double next = w - value / slope;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        int settled = fabs(next - w) <= 1e-13 * radius;
        w = next;
        if (settled) break;
        value = excess(r, w, &slope);
        if (value > 0)
            low = w;
        else
            high = w;
    }
    stationary_point(r, w, x);
}

/* Stores the foot point (s, t) of a point that is nearer to the surface than most of a radius of
 * curvature, by Newton's steps as in foot_point but without principal axes. Returns whether it is
 * so near. */
static int near_foot(const query *q, double x[2]) {
    const double *g = q->region->slope, *h = q->region->hessian, *p = q->point;
    double w = 0, bend = psplat_region_bend(q->region), exact = 1e-10 * q->region->radius[0];
    for (int step = 0; step < MAX_NEAR_STEPS; ++step) {
        double a = 1 + w * h[0], b = w * h[1], c = 1 + w * h[2], det = a * c - b * b;
        double s = p[0] - w * g[0], t = p[1] - w * g[1];
        x[0] = (c * s - b * t) / det, x[1] = (a * t - b * s) / det;
        s = g[0] + h[0] * x[0] + h[1] * x[1], t = g[1] + h[1] * x[0] + h[2] * x[1];
        double value = ((g[0] + s) * x[0] + (g[1] + t) * x[1]) / 2 - p[2] - w;
        double change = value * det / (det + c * s * s - 2 * b * s * t + a * t * t);
        if (fabs(change) <= exact) return 1;
        w += change;
        if (!(fabs(w) * bend < 0.7)) return 0;
    }
    return 0;
}

/* Takes the surface's point at (s, t) as the nearest if the region holds it. Returns whether it
 * does. *distance becomes that from the point of the quadric, held or not. */
static int try_point(query *q, const double x[2], double *distance) {
    double s = x[0], t = x[1];
    const double uv[2] = {s / q->region->radius[0], t / q->region->radius[1]};
    double d[3] = {s - q->point[0], t - q->point[1],
                   psplat_region_height(q->region, uv) - q->point[2]};
    *distance = length3(d);
    if (!psplat_region_contains(q->region, uv, 1, 0)) return 0;
    q->best = min2(q->best, *distance);
    return q->met = 1;
}

/* Tries the points where the distance is stationary: the roots of the excess times the squares of
 * both 1 + w curvature. w is in units of the best distance. */
static void try_stationary(query *q, const quadric *r) {
    double sum[6] = {0}, roots[5], w = q->best, fall[2][2];
    for (int i = 0; i < 2; ++i) fall[i][0] = 1, fall[i][1] = w * r->curvature[i];
    for (int i = 0; i < 2; ++i) {
        const double n[2] = {r->p[i], -w * r->slope[i]}, *d = fall[i], *e = fall[1 - i];
        double own[3] = {0}; /* slope n d + curvature n n / 2 */
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                own[a + b] += n[a] * (r->slope[i] * d[b] + r->curvature[i] * n[b] / 2);
        const double square[3] = {1, 2 * e[1], e[1] * e[1]};
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) sum[a + b] += own[a] * square[b];
    }
    const double one[3] = {1, 2 * fall[0][1], fall[0][1] * fall[0][1]};
    const double two[3] = {1, 2 * fall[1][1], fall[1][1] * fall[1][1]};
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
            sum[a + b] -= r->z * one[a] * two[b];
            sum[a + b + 1] -= w * one[a] * two[b];
        }
    size_t count = psplat_polynomial_roots(sum, 5, -1, 1, roots);
    for (size_t k = 0; k < count; ++k) {
        double x[2], distance;
        stationary_point(r, w * roots[k], x);
        to_plane(r, x);
        try_point(q, x, &distance);
    }
}

/* ---- the rim -------------------------------------------------------------------------------- */

/* One curve of the rim: clip line `line`, or the ellipse where that is negative. bend bounds the
 * curve's second derivative, a length. */
typedef struct rim {
    query *query;
    int line;
    double bend;
} rim;

/* A place on a curve, its distance from the point, and the derivative of that. */
typedef struct place {
    double at, distance, slope;
} place;

/* Stores the parameters of the rim's point at a place, and their derivatives. */
static void rim_point(const rim *r, double at, double uv[2], double along[2]) {
    const psplat_region *region = r->query->region;
    if (r->line < 0) {
        uv[0] = cos(at), uv[1] = sin(at);
        along[0] = -uv[1], along[1] = uv[0];
        return;
    }
    const double *line = region->lines[r->line];
    double length = hypot(line[0], line[1]), x = line[0] / length, y = line[1] / length;
    double away = -region->bends[r->line] * length * at;
    psplat_region_line_point(region, (uint32_t)r->line, at, uv);
    along[0] = away * x - y, along[1] = away * y + x;
}

static place place_at(const rim *r, double at) {
    const psplat_region *region = r->query->region;
    double uv[2], along[2], slope[2];
    rim_point(r, at, uv, along);
    psplat_region_slope(region, uv, slope);
    double s = along[0] * region->radius[0], t = along[1] * region->radius[1];
    const double tangent[3] = {s, t, slope[0] * s + slope[1] * t};
    const double *p = r->query->point;
    const double d[3] = {uv[0] * region->radius[0] - p[0], uv[1] * region->radius[1] - p[1],
                         psplat_region_height(region, uv) - p[2]};
    double distance = length3(d);
    r->query->best = min2(r->query->best, distance);
    r->query->met = 1;
    return (place){at, distance, distance > 0 ? dot3(d, tangent) / distance : 0};
}

/* Returns a lower bound of the distance between two places, and stores where it is. The second
 * derivative of the distance to a fixed point is at least the negative of the curve's own. So the
 * distance plus bend (x - a) (x - b) / 2 is convex, and above its tangents at both ends. */
static double lower_bound(const rim *r, const place *a, const place *b, double *where) {
    double width = b->at - a->at, least = min2(a->distance, b->distance);
    double from = a->slope - r->bend * width / 2, to = b->slope + r->bend * width / 2;
    *where = 0.5 * (a->at + b->at);
    if (from >= 0 || to <= 0) return least;
    double x = (b->distance - a->distance - to * width) / (from - to);
    x = min2(max2(x, 0), width);
    double bound = a->distance + from * x + r->bend * x * (width - x) / 2;
    *where = a->at + min2(max2(x, 0.1 * width), 0.9 * width);
    return min2(bound, least);
}

/* Finds the least distance between two near places, where it has one minimum at most: where its
 * derivative is 0, by the secant between places of different signs. */
static void refine_between(const rim *r, place a, place b) {
    double exact = accuracy * r->query->region->radius[0];
    for (int step = 0; step < MAX_STEPS && a.slope < 0 && b.slope > 0; ++step) {
        double width = b.at - a.at, t = a.slope / (a.slope - b.slope);
        if (min2(-a.slope, b.slope) * width < exact) break;
        place middle = place_at(r, a.at + width * min2(max2(t, 0.05), 0.95));
        if (middle.slope < 0)
            a = middle;
        else
            b = middle;
    }
}

/* Finds the least distance between two places, unless it is not less than the best one known. */
static void search_between(const rim *r, const place *a, const place *b) {
    double where, least = r->query->best - accuracy * r->query->region->radius[0];
    if (lower_bound(r, a, b, &where) >= least) return;
    if (b->at - a->at < smooth_width) {
        refine_between(r, *a, *b);
        return;
    }
    place middle = place_at(r, where);
    int left = a->distance < b->distance;
    search_between(r, left ? a : &middle, left ? &middle : b);
    search_between(r, left ? &middle : a, left ? b : &middle);
}

/* Searches a curve from one place to another in parts of at most an eighth of a turn. */
static void search_rim(const rim *r, double from, double to) {
    place places[MAX_PARTS + 1];
    int parts = (int)min2(ceil((to - from) / (0.25 * PSPLAT_PI)), MAX_PARTS);
    for (int i = 0; i <= parts; ++i) places[i] = place_at(r, from + (to - from) * i / parts);
    for (int i = 0; i < parts; ++i) search_between(r, &places[i], &places[i + 1]);
}

/* ---- what lines and ellipse leave of each other ---------------------------------------------- */

/* Adds the angles at which line i meets the ellipse. With x the cosine of the angle to the line's
 * normal, its value there is quadratic in x. */
static size_t angles_of(const psplat_region *region, uint32_t i, double *places) {
    const double *line = region->lines[i];
    double length = hypot(line[0], line[1]), toward = atan2(line[1], line[0]), roots[2];
    double bend = region->bends[i] * length * length / 2;
    const double value[3] = {line[2] + bend, length, -bend};
    size_t count = psplat_polynomial_roots(value, 2, -1, 1, roots), result = 0;
    for (size_t k = 0; k < count; ++k)
        for (int side = -1; side < 2; side += 2) {
            double angle = toward + side * acos(roots[k]);
            angle -= 2 * PSPLAT_PI * floor(angle / (2 * PSPLAT_PI));
            places[result++] = angle;
        }
    return result;
}

/* Adds the places where line i leaves the unit circle: away^2 + m^2 = 1 is quadratic in m^2. */
static size_t ends_of(const psplat_region *region, uint32_t i, double *places) {
    const double *line = region->lines[i];
    double length = hypot(line[0], line[1]), away = -line[2] / length, roots[2];
    double bend = -region->bends[i] * length / 2;
    const double value[3] = {away * away - 1, 2 * away * bend + 1, bend * bend};
    size_t count = psplat_polynomial_roots(value, 2, 0, 1, roots), result = 0;
    for (size_t k = 0; k < count; ++k) {
        places[result++] = -sqrt(roots[k]);
        places[result++] = sqrt(roots[k]);
    }
    return result;
}

/* Adds the places on line i where it meets line j. */
static size_t meetings_of(const psplat_region *region, uint32_t i, uint32_t j, double *places) {
    const double *line = region->lines[i], *other = region->lines[j];
    double length = hypot(line[0], line[1]), x = line[0] / length, y = line[1] / length;
    double away[3] = {-line[2] / length, 0, -region->bends[i] * length / 2};
    double value[5] = {other[2]}, along[3] = {0};
    for (int k = 0; k < 3; ++k) {
        double u = away[k] * x - (k == 1 ? y : 0), v = away[k] * y + (k == 1 ? x : 0);
        value[k] += other[0] * u + other[1] * v;
        along[k] = other[0] * v - other[1] * u;
    }
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) value[a + b] += region->bends[j] * along[a] * along[b] / 2;
    return psplat_polynomial_roots(value, 4, -1, 1, places);
}

/* Returns whether the region holds the rim's point at a place, whichever side of the rim's own
 * curve rounding puts it on. */
static int is_held(const rim *r, double at) {
    const psplat_region *region = r->query->region;
    double uv[2], along[2];
    rim_point(r, at, uv, along);
    if (r->line >= 0 && uv[0] * uv[0] + uv[1] * uv[1] > 1) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i)
        if ((int)i != r->line && psplat_region_line_value(region, i, uv) < 0) return 0;
    return 1;
}

static void sort_places(double *places, size_t count) {
    for (size_t i = 1; i < count; ++i)
        for (size_t k = i; k > 0 && places[k] < places[k - 1]; --k) {
            double swap = places[k];
            places[k] = places[k - 1], places[k - 1] = swap;
        }
}

/* Searches the parts of a curve between neighbouring places that the region holds. */
static void search_held(const rim *r, double *places, size_t count) {
    sort_places(places, count);
    for (size_t i = 0; i + 1 < count; ++i)
        if (places[i] < places[i + 1] && is_held(r, 0.5 * (places[i] + places[i + 1])))
            search_rim(r, places[i], places[i + 1]);
}

/* Bounds the second derivative of the ellipse's curve: heights on it are a sine of the angle, by
 * the slopes, and one of twice the angle, by the curvatures. */
static double ellipse_bend(const psplat_region *region) {
    const double *radius = region->radius, *h = region->hessian;
    double once = hypot(region->slope[0] * radius[0], region->slope[1] * radius[1]);
    double across = h[0] * radius[0] * radius[0] - h[2] * radius[1] * radius[1];
    double twice = hypot(across / 4, h[1] * radius[0] * radius[1] / 2);
    return hypot(max2(radius[0], radius[1]), once + 4 * twice);
}

/* Bounds the second derivative of a clip line's curve, whose own is constant in the plane. */
static double line_bend(const psplat_region *region, uint32_t i) {
    const double *line = region->lines[i], *radius = region->radius;
    double length = hypot(line[0], line[1]), bend = fabs(region->bends[i]);
    double second = bend * hypot(line[0] * radius[0], line[1] * radius[1]);
    double first = hypot(line[1] * radius[0], line[0] * radius[1]) / length + second;
    double bow = psplat_region_bend(region), most = max2(radius[0], radius[1]);
    double slope = hypot(region->slope[0], region->slope[1]) + bow * most;
    return hypot(second, slope * second + bow * first * first);
}

static void search_ellipse(query *q) {
    rim r = {q, -1, ellipse_bend(q->region)};
    double places[MAX_PLACES] = {0, 2 * PSPLAT_PI};
    size_t count = 2;
    for (uint32_t i = 0; i < q->region->line_count; ++i)
        count += angles_of(q->region, i, places + count);
    search_held(&r, places, count);
}

static void search_line(query *q, uint32_t i) {
    rim r = {q, (int)i, line_bend(q->region, i)};
    double places[MAX_PLACES] = {0};
    size_t count = ends_of(q->region, i, places);
    for (uint32_t j = 0; j < q->region->line_count; ++j)
        if (j != i) count += meetings_of(q->region, i, j, places + count);
    search_held(&r, places, count);
}

double psplat_curved_distance(const psplat_region *region, const double point[3], double limit) {
    query q = {.region = region, .best = limit};
    double d[3], x[2], least;
    quadric r = {.z = 0};
    sub3(d, point, region->center);
    q.point[0] = dot3(d, region->u), q.point[1] = dot3(d, region->v);
    q.point[2] = dot3(d, region->n);
    int is_near = near_foot(&q, x);
    if (!is_near) {
        r = quadric_of(&q);
        foot_point(&r, region->radius[0], x);
        to_plane(&r, x);
    }
    if (try_point(&q, x, &least)) return q.best;
    if (least >= limit) return limit; /* The quadric's point is no farther away than any other. */
    search_ellipse(&q);
    for (uint32_t i = 0; i < region->line_count; ++i) search_line(&q, i);
    if (q.met && q.best * psplat_region_bend(region) > 1) {
        if (is_near) r = quadric_of(&q);
        try_stationary(&q, &r);
    }
    return q.met ? q.best : HUGE_VAL;
}
