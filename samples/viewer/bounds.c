/* SPDX-License-Identifier: MIT
 *
 * bounds.c - a sphere around the visible parts of splats. psplat_asset_bounds, which encloses whole
 * ellipses, is several times too large where large splats are cut down to small faces.
 */
#include "viewer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDES = 12, MAX_CORNERS = SIDES + 4 * PSPLAT_MAX_CLIP_LINES };

/* A convex polygon in the splat's coordinates (u, v). */
typedef struct polygon {
    double corners[MAX_CORNERS][2];
    int count;
} polygon;

/* Returns a regular polygon around the unit circle. */
static polygon whole_splat(void) {
    polygon p = {.count = SIDES};
    const double step = 2 * 3.14159265358979323846 / SIDES;
    for (int i = 0; i < SIDES; ++i) {
        p.corners[i][0] = cos(i * step) / cos(0.5 * step);
        p.corners[i][1] = sin(i * step) / cos(0.5 * step);
    }
    return p;
}

/* Returns the value of a clip line of a bend at a corner. */
static double side_of(const float line[3], double bend, const double corner[2]) {
    double a = (double)line[0], b = (double)line[1];
    double across = a * corner[1] - b * corner[0];
    return a * corner[0] + b * corner[1] + (double)line[2] + bend * across * across / 2;
}

static void add_corner(polygon *p, double u, double v) {
    if (p->count == MAX_CORNERS) return;
    p->corners[p->count][0] = u;
    p->corners[p->count++][1] = v;
}

/* Adds the point between one corner and another, which is cut off, where the line cuts. */
static void add_crossing(polygon *p, const float line[3], double bend, const double in[2],
                         const double out[2]) {
    const double d[2] = {out[0] - in[0], out[1] - in[1]};
    double across = (double)line[0] * d[1] - (double)line[1] * d[0];
    double square = bend * across * across / 2, first = side_of(line, bend, in);
    double slope = side_of(line, bend, out) - first - square; /* below 0 */
    double t = 2 * first / (sqrt(slope * slope - 4 * square * first) - slope);
    add_corner(p, in[0] + t * d[0], in[1] + t * d[1]);
}

/* Keeps the convex hull of the part that the clip line keeps (Sutherland and Hodgman 1974). A
 * straight line adds at most one corner, a bent one few. A line that bulges out counts as the
 * straight one that touches it. */
static void cut(polygon *p, const float line[3], double bend) {
    polygon kept = {.count = 0};
    bend = fmax(bend, 0);
    for (int i = 0; i < p->count; ++i) {
        const double *a = p->corners[i], *b = p->corners[(i + 1) % p->count];
        int keeps_a = side_of(line, bend, a) >= 0, keeps_b = side_of(line, bend, b) >= 0;
        if (keeps_a) add_corner(&kept, a[0], a[1]);
        if (keeps_a != keeps_b) add_crossing(&kept, line, bend, keeps_a ? a : b, keeps_a ? b : a);
    }
    *p = kept;
}

/* Computes center + x U + y V + z N, where U, V and N are the columns of the quaternion's rotation
 * matrix. */
static void to_object(const psplat_splat *s, double x, double y, double z, double out[3]) {
    const double q[4] = {(double)s->rotation[0], (double)s->rotation[1], (double)s->rotation[2],
                         (double)s->rotation[3]};
    const double u[3] = {1 - 2 * (q[1] * q[1] + q[2] * q[2]), 2 * (q[0] * q[1] + q[3] * q[2]),
                         2 * (q[0] * q[2] - q[3] * q[1])};
    const double v[3] = {2 * (q[0] * q[1] - q[3] * q[2]), 1 - 2 * (q[0] * q[0] + q[2] * q[2]),
                         2 * (q[1] * q[2] + q[3] * q[0])};
    const double n[3] = {2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]),
                         1 - 2 * (q[0] * q[0] + q[1] * q[1])};
    for (int i = 0; i < 3; ++i)
        out[i] = (double)s->center[i] + x * u[i] + y * v[i] + (z != 0 ? z * n[i] : 0);
}

/* Returns the height of a splat's surface over its plane at (u, v) (eq. 1a of schema/README.md). */
static double height_of(const psplat_splat *s, double u, double v) {
    double q = (double)s->radius[1] / (double)s->radius[0];
    double along = (double)s->shape[0] + (double)s->shape[2] * u / 2 + (double)s->shape[4] * q * v;
    double across = (double)s->shape[1] + (double)s->shape[3] * v / 2;
    return -(double)s->radius[0] * (along * u + across * q * v);
}

static int is_curved(const psplat_splat *s) {
    for (int k = 0; k < 5; ++k)
        if (s->shape[k] != 0) return 1;
    return 0;
}

typedef struct extent {
    double min[3], max[3];
    sphere around;
} extent;

static void grow_box(extent *e, const double p[3]) {
    for (int i = 0; i < 3; ++i) {
        e->min[i] = fmin(e->min[i], p[i]);
        e->max[i] = fmax(e->max[i], p[i]);
    }
}

static void grow_sphere(extent *e, const double p[3]) {
    const double *c = e->around.center;
    double square = (p[0] - c[0]) * (p[0] - c[0]) + (p[1] - c[1]) * (p[1] - c[1]) +
                    (p[2] - c[2]) * (p[2] - c[2]);
    e->around.radius = fmax(e->around.radius, sqrt(square));
}

/* Visits the point of a splat's surface at (u, v), placed by the matrix m. */
static void visit_point(const psplat_splat *s, const double m[16], double u, double v, extent *e,
                        void (*visit)(extent *e, const double p[3])) {
    double p[3], q[3];
    to_object(s, (double)s->radius[0] * u, (double)s->radius[1] * v, height_of(s, u, v), p);
    for (int r = 0; r < 3; ++r) q[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
    visit(e, q);
}

/* Visits the corners of the outline that so many lines, the first, leave of a splat. Within it a
 * curved splat may reach farther, so there it is visited on some rings around the outline's middle,
 * and in that. */
static void visit_splat(const psplat_splat *s, uint32_t line_count, const double m[16], extent *e,
                        void (*visit)(extent *e, const double p[3])) {
    enum { RINGS = 4 };
    polygon outline = whole_splat();
    double middle[2] = {0, 0};
    int rings = is_curved(s) ? RINGS : 1;
    /* Those that bulge in come last: the hull of what they keep is smaller then. */
    for (uint32_t i = 0; i < 2 * line_count; ++i)
        if ((i < line_count) == (s->bend[i % line_count] <= 0))
            cut(&outline, s->clip[i % line_count], (double)s->bend[i % line_count]);
    for (int i = 0; i < outline.count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += outline.corners[i][k] / outline.count;
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < outline.count; ++i) {
            const double *corner = outline.corners[i];
            double t = (double)ring / RINGS;
            visit_point(s, m, corner[0] + t * (middle[0] - corner[0]),
                        corner[1] + t * (middle[1] - corner[1]), e, visit);
        }
    if (outline.count && rings > 1) visit_point(s, m, middle[0], middle[1], e, visit);
}

/* Seams, which come last, cut nothing of a splat's shape. */
static void visit_batch(const psplat_batch *batch, const double m[16], extent *e,
                        void (*visit)(extent *e, const double p[3])) {
    for (size_t i = 0; i < batch->splat_count; ++i)
        visit_splat(&batch->splats[i], batch->clip_count - batch->seam_lines, m, e, visit);
}

/* Returns the box around a batch in its own coordinates, empty where nothing of it is seen. */
static extent box_of(const psplat_batch *batch) {
    static const double identity[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};
    extent box = {.min = {INFINITY, INFINITY, INFINITY}, .max = {-INFINITY, -INFINITY, -INFINITY}};
    visit_batch(batch, identity, &box, grow_box);
    return box;
}

static void visit_corners(const extent *box, const double m[16], extent *e,
                          void (*visit)(extent *e, const double p[3])) {
    for (int corner = 0; box->min[0] <= box->max[0] && corner < 8; ++corner) {
        double p[3], q[3];
        for (int k = 0; k < 3; ++k) p[k] = corner >> k & 1 ? box->max[k] : box->min[k];
        for (int r = 0; r < 3; ++r)
            q[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
        visit(e, q);
    }
}

/* Visits the batches' boxes at some times of the first animations, so that these stay in the
 * picture: visiting all splats each time would take long. */
static void visit_poses(const psplat_asset *asset, psplat_pose *pose, const extent *boxes,
                        extent *e, void (*visit)(extent *e, const double p[3])) {
    enum { TIMES = 8, ANIMATIONS = 4 };
    size_t count = psplat_asset_animation_count(asset);
    for (size_t i = 0; i < count && i < ANIMATIONS; ++i)
        for (int k = 0; k <= TIMES; ++k) {
            double duration = psplat_asset_get_animation(asset, i)->duration;
            if (psplat_pose_set(pose, i, duration * k / TIMES, NULL)) continue;
            for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b)
                visit_corners(&boxes[b], psplat_pose_matrix(pose, b), e, visit);
        }
}

/* Visits the splats at rest, and what of them animations move. */
static void visit_all(const psplat_asset *asset, extent *e,
                      void (*visit)(extent *e, const double p[3])) {
    size_t count = psplat_asset_batch_count(asset);
    psplat_pose *pose = NULL;
    extent *boxes = NULL;
    for (size_t b = 0; b < count; ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        visit_batch(batch, batch->model, e, visit);
    }
    if (!psplat_asset_animation_count(asset) || psplat_pose_create(asset, &pose, NULL)) return;
    boxes = malloc((count + 1) * sizeof *boxes);
    for (size_t b = 0; boxes && b < count; ++b) boxes[b] = box_of(psplat_asset_batch(asset, b));
    if (boxes) visit_poses(asset, pose, boxes, e, visit);
    free(boxes);
    psplat_pose_destroy(pose);
}

sphere bounds_of(const psplat_asset *asset) {
    extent e = {.min = {INFINITY, INFINITY, INFINITY}, .max = {-INFINITY, -INFINITY, -INFINITY}};
    visit_all(asset, &e, grow_box);
    /* Where the clip lines leave nothing of any splat, the asset's bounds are used. */
    if (!(e.min[0] <= e.max[0])) psplat_asset_bounds(asset, e.min, e.max);
    for (int i = 0; i < 3; ++i) e.around.center[i] = 0.5 * (e.min[i] + e.max[i]);
    visit_all(asset, &e, grow_sphere);
    return e.around;
}
