/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ellipse.c - minimum enclosing ellipse of points in a plane.
 *
 * Khachiyan's algorithm with the away steps of Todd and Yildirim (2007) on the convex hull, in
 * coordinates scaled to the hull's own extents: CGAL's Min_ellipse_2 in double is wrong on most
 * near-collinear sets, and this needs microseconds. A last scaling puts every point inside.
 */
#include "stages.h"

#include "vector.h"
#include <stdlib.h>

enum { HULL_CAPACITY = 192, ITERATIONS = 400 };

/* Excess of the largest distance at which the iteration stops; 1 % of area at most. */
static const double precision = 0.003;

static int compare_points(const void *left, const void *right) {
    const double *a = left, *b = right;
    if (a[0] != b[0]) return a[0] < b[0] ? -1 : 1;
    return a[1] < b[1] ? -1 : a[1] > b[1];
}

static double turn(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Directions whose farthest points make the octagon below, counter-clockwise. */
static const double octagon_directions[8][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                                {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};

static int inside_octagon(const double octagon[8][2], const double p[2]) {
    for (int i = 0; i < 8; ++i) {
        const double *a = octagon[i], *b = octagon[(i + 1) % 8];
        int same = a[0] == b[0] && a[1] == b[1]; /* farthest in both directions: no side */
        if (!same && turn(a, b, p) <= 0) return 0;
    }
    return 1;
}

/* Moves points that cannot be on the hull behind the others and returns how many remain: what lies
 * inside the octagon of the farthest points is inside the hull (Akl, Toussaint 1978). Points on a
 * side of it remain. */
static size_t drop_inner(double (*points)[2], size_t count) {
    double octagon[8][2] = {{0}}, farthest[8];
    for (int k = 0; k < 8; ++k) farthest[k] = -HUGE_VAL;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 8; ++k) {
            double along =
                points[i][0] * octagon_directions[k][0] + points[i][1] * octagon_directions[k][1];
            if (along <= farthest[k]) continue;
            farthest[k] = along;
            octagon[k][0] = points[i][0], octagon[k][1] = points[i][1];
        }
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        if (inside_octagon((const double(*)[2])octagon, points[i])) continue;
        double outer[2] = {points[i][0], points[i][1]};
        points[i][0] = points[kept][0], points[i][1] = points[kept][1];
        points[kept][0] = outer[0], points[kept++][1] = outer[1];
    }
    return kept ? kept : 1; /* all in one place */
}

/* Andrew's monotone chain: moves the hull of sorted points into hull (capacity count + 1). */
static size_t convex_hull(double (*points)[2], size_t count, double (*hull)[2]) {
    qsort(points, count, sizeof *points, compare_points);
    size_t size = 0;
    for (int side = 0; side < 2; ++side) {
        size_t floor_size = size + 1;
        for (size_t i = 0; i < count; ++i) {
            const double *p = points[side ? count - 1 - i : i];
            while (size > floor_size && turn(hull[size - 2], hull[size - 1], p) <= 0) --size;
            hull[size][0] = p[0], hull[size++][1] = p[1];
        }
        --size; /* the last point begins the other side */
    }
    return size ? size : 1;
}

/* Maps between the plane and the unit square along the principal axes of the hull. */
typedef struct frame {
    double origin[2], axis[2], half[2];
} frame;

static void principal_axis(double (*points)[2], size_t count, double axis[2]) {
    double mean[2] = {0, 0}, xx = 0, xy = 0, yy = 0;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += points[i][k] / (double)count;
    for (size_t i = 0; i < count; ++i) {
        double x = points[i][0] - mean[0], y = points[i][1] - mean[1];
        xx += x * x, xy += x * y, yy += y * y;
    }
    double angle = 0.5 * atan2(2 * xy, xx - yy);
    axis[0] = cos(angle), axis[1] = sin(angle);
}

static void find_frame(double (*points)[2], size_t count, frame *f) {
    principal_axis(points, count, f->axis);
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < count; ++i) {
        double along[2] = {points[i][0] * f->axis[0] + points[i][1] * f->axis[1],
                           points[i][1] * f->axis[0] - points[i][0] * f->axis[1]};
        for (int k = 0; k < 2; ++k) {
            low[k] = min2(low[k], along[k]);
            high[k] = max2(high[k], along[k]);
        }
    }
    double mid[2] = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2};
    f->origin[0] = mid[0] * f->axis[0] - mid[1] * f->axis[1];
    f->origin[1] = mid[0] * f->axis[1] + mid[1] * f->axis[0];
    for (int k = 0; k < 2; ++k) f->half[k] = (high[k] - low[k]) / 2;
}

static void to_frame(const frame *f, double p[2]) {
    double x = p[0] - f->origin[0], y = p[1] - f->origin[1];
    p[0] = (x * f->axis[0] + y * f->axis[1]) / f->half[0];
    p[1] = (y * f->axis[0] - x * f->axis[1]) / f->half[1];
}

/* Inverse of the symmetric 3x3 matrix xx xy x1 yy y1 11. Returns 0 where it is singular. */
static int invert3(const double m[6], double r[6]) {
    r[0] = m[3] * m[5] - m[4] * m[4];
    r[1] = m[2] * m[4] - m[1] * m[5];
    r[2] = m[1] * m[4] - m[2] * m[3];
    r[3] = m[0] * m[5] - m[2] * m[2];
    r[4] = m[1] * m[2] - m[0] * m[4];
    r[5] = m[0] * m[3] - m[1] * m[1];
    double det = m[0] * r[0] + m[1] * r[1] + m[2] * r[2];
    if (!(fabs(det) > 1e-30)) return 0;
    for (int k = 0; k < 6; ++k) r[k] /= det;
    return 1;
}

static double lifted_distance(const double r[6], const double p[2]) {
    return r[0] * p[0] * p[0] + 2 * r[1] * p[0] * p[1] + r[3] * p[1] * p[1] +
           2 * (r[2] * p[0] + r[4] * p[1]) + r[5];
}

static int lifted_inverse(double (*points)[2], const double *weights, size_t count, double r[6]) {
    double m[6] = {0};
    for (size_t i = 0; i < count; ++i) {
        double w = weights[i], x = points[i][0], y = points[i][1];
        m[0] += w * x * x, m[1] += w * x * y, m[2] += w * x;
        m[3] += w * y * y, m[4] += w * y, m[5] += w;
    }
    return invert3(m, r);
}

/* One step towards the farthest point, or away from the nearest that still has weight. Returns 0
 * when both are within precision. */
static int khachiyan_step(double (*points)[2], double *weights, size_t count) {
    double r[6], greatest = -HUGE_VAL, least = HUGE_VAL;
    size_t far = 0, near = 0;
    if (!lifted_inverse(points, weights, count, r)) return 0;
    for (size_t i = 0; i < count; ++i) {
        double d = lifted_distance(r, points[i]);
        if (d > greatest) greatest = d, far = i;
        if (weights[i] > 1e-12 && d < least) least = d, near = i;
    }
    int away = 3 - least > greatest - 3;
    double d = away ? least : greatest;
    if (fabs(d - 3) <= 3 * precision) return 0;
    double step = (d - 3) / (3 * (d - 1));
    size_t moved = away ? near : far;
    if (away) step = max2(step, -weights[moved] / (1 - weights[moved]));
    for (size_t i = 0; i < count; ++i) weights[i] *= 1 - step;
    weights[moved] += step;
    return 1;
}

/* Centre and shape matrix xx xy yy (p in the ellipse where (p-c)' S^-1 (p-c) <= 1). */
static void enclose_hull(double (*points)[2], size_t count, double center[2], double shape[3]) {
    double weights[HULL_CAPACITY];
    for (size_t i = 0; i < count; ++i) weights[i] = 1.0 / (double)count;
    for (int i = 0; i < ITERATIONS && khachiyan_step(points, weights, count);) ++i;
    center[0] = center[1] = shape[0] = shape[1] = shape[2] = 0;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) center[k] += weights[i] * points[i][k];
    for (size_t i = 0; i < count; ++i) {
        double x = points[i][0] - center[0], y = points[i][1] - center[1];
        shape[0] += 2 * weights[i] * x * x;
        shape[1] += 2 * weights[i] * x * y;
        shape[2] += 2 * weights[i] * y * y;
    }
}

/* Factor of the radii that puts every point inside. */
static double covering_scale(double (*points)[2], size_t count, const double center[2],
                             const double shape[3]) {
    double det = shape[0] * shape[2] - shape[1] * shape[1], greatest = 0;
    for (size_t i = 0; i < count; ++i) {
        double x = points[i][0] - center[0], y = points[i][1] - center[1];
        greatest =
            max2(greatest, (shape[2] * x * x - 2 * shape[1] * x * y + shape[0] * y * y) / det);
    }
    return sqrt(greatest) * (1 + 1e-12);
}

/* The ellipse of centre and shape in the unit square, back in the plane. */
static void from_frame(const frame *f, const double center[2], const double shape[3], double scale,
                       psplat_ellipse *ellipse) {
    double cx = center[0] * f->half[0], cy = center[1] * f->half[1];
    ellipse->center[0] = f->origin[0] + cx * f->axis[0] - cy * f->axis[1];
    ellipse->center[1] = f->origin[1] + cx * f->axis[1] + cy * f->axis[0];
    double xx = shape[0] * f->half[0] * f->half[0], xy = shape[1] * f->half[0] * f->half[1];
    double yy = shape[2] * f->half[1] * f->half[1];
    double angle = 0.5 * atan2(2 * xy, xx - yy), c = cos(angle), s = sin(angle);
    double middle = (xx + yy) / 2, spread = hypot((xx - yy) / 2, xy);
    ellipse->axis[0] = c * f->axis[0] - s * f->axis[1];
    ellipse->axis[1] = c * f->axis[1] + s * f->axis[0];
    ellipse->radius[0] = scale * sqrt(middle + spread);
    ellipse->radius[1] = scale * sqrt(max2((xx * yy - xy * xy) / (middle + spread), 0));
}

/* Hulls too large for the iteration's arrays (they come from thousands of points on a circle) are
 * thinned; covering_scale makes up for what was left out. */
static size_t thin_hull(double (*hull)[2], size_t count) {
    if (count <= HULL_CAPACITY) return count;
    for (size_t i = 0; i < HULL_CAPACITY; ++i) {
        size_t from = i * count / HULL_CAPACITY;
        hull[i][0] = hull[from][0], hull[i][1] = hull[from][1];
    }
    return HULL_CAPACITY;
}

static void enclose_flat(const frame *f, psplat_ellipse *ellipse) {
    *ellipse = (psplat_ellipse){.center = {f->origin[0], f->origin[1]},
                                .axis = {f->axis[0], f->axis[1]},
                                .radius = {f->half[0], f->half[1]}};
}

void psplat_ellipse_enclose(double (*points)[2], size_t count, psplat_ellipse *ellipse) {
    double small[2 * HULL_CAPACITY][2], (*hull)[2] = small;
    *ellipse = (psplat_ellipse){.axis = {1, 0}};
    if (!count) return;
    count = drop_inner(points, count);
    /* Without memory for a hull the first points stand in for it; scaling keeps the promise. */
    size_t used = count;
    if (2 * count + 2 > 2 * HULL_CAPACITY) {
        hull = malloc((2 * count + 2) * sizeof *hull);
        if (!hull) hull = small, used = HULL_CAPACITY - 1;
    }
    size_t hull_count = convex_hull(points, used, hull);
    frame f;
    find_frame(hull, hull_count, &f);
    if (f.half[1] <= 1e-9 * f.half[0] || !(f.half[0] > 0)) {
        enclose_flat(&f, ellipse);
    } else {
        double center[2], shape[3];
        hull_count = thin_hull(hull, hull_count);
        for (size_t i = 0; i < hull_count; ++i) to_frame(&f, hull[i]);
        for (size_t i = 0; i < count; ++i) to_frame(&f, points[i]);
        enclose_hull(hull, hull_count, center, shape);
        from_frame(&f, center, shape, covering_scale(points, count, center, shape), ellipse);
    }
    if (hull != small) free(hull);
}
