/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * proxy_bound.c - how far a triangle lies from the part of a mesh that it stands for, proven.
 *
 * The triangles of the mesh are projected along the normal of the triangle T. A flood from one of
 * its corners takes all triangles that are reached over edges whose projections meet T. No edge
 * that bounds the flooded part P meets T then, so that all points of T are covered by equally many
 * triangles of P, modulo 2 (the degree of the projection, Milnor: Topology from the Differentiable
 * Viewpoint, section 4). If that is an odd number at one point of T, P covers T, and a point of T
 * is no farther from P than the greatest height over T of what P has above and below T, which is
 * that of a corner of a triangle clipped to T.
 *
 * Borders of the mesh may meet T along its sides. A strip along such a side is left to another
 * argument: if the border's edges beside a side cover it from end to end, each point of the strip
 * has one of the border's points across. The rest of T is convex, so that the first argument holds
 * for it.
 */
#include "mesh/proxy.h"

#include "base/vector.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>

/* Points of T at which triangles are counted, in barycentric coordinates. One may lie on an edge.
 */
enum { PROBES = 3 };
static const double probe_weights[PROBES][3] = {
    {0.31, 0.33, 0.36}, {0.53, 0.29, 0.18}, {0.17, 0.26, 0.57}};
/* The part of the greatest deviation that borders may be beside a side of T, since the argument for
 * strips costs twice of it. */
static const double strip_part = 0.4;
/* Coordinates that are less than this part of T's size count as none, where that makes the proof
 * stricter. It is far more than their rounding. */
static const double relative_slack = 1e-11;
/* Heights beyond this many greatest deviations end the flood of a triangle that has failed. */
static const double reach_deviations = 8;
/* The most edges of borders beside one side; more are not proven. */
enum { MAX_STRIP_EDGES = 256 };
/* A polygon that three lines clip has at most six corners. */
enum { MAX_CLIPPED = 12 };

/* A point relative to T: its distances from the lines through the three sides, positive inside, and
 * its height. Side k runs from corner k to the next. */
typedef struct local_point {
    double inward[3], height;
} local_point;

typedef struct interval {
    double from, to;
} interval;

/* The edges of borders beside a side of T. */
typedef struct strip {
    interval intervals[MAX_STRIP_EDGES];
    size_t count;
    double width, height; /* the greatest distance of these edges from the side, within T's plane
                             and across it */
} strip;

typedef struct frame {
    const double *corners[3];
    double along[3][3], inward[3][3], normal[3]; /* unit vectors */
    double lengths[3], slack;
    local_point probes[PROBES];
    unsigned odd, unsure; /* a bit for each probe: covered by an odd number of triangles, or on an
                             edge of one */
    unsigned needs[8];    /* [bits of sides]: some border's edge needs one of these sides' strips */
    strip strips[3];
    double most, height; /* the limit, and the greatest so far */
    int failed;
} frame;

static void to_local(const frame *f, const double p[3], local_point *local) {
    double d[3];
    for (int k = 0; k < 3; ++k) {
        sub3(d, p, f->corners[k]);
        local->inward[k] = dot3(d, f->inward[k]);
    }
    local->height = dot3(d, f->normal);
}

/* Returns 0 if T has no area. */
static int set_frame(frame *f, const psplat_mesh *mesh, const uint32_t corners[3], double most) {
    double ab[3], ac[3], longest = 0;
    for (int k = 0; k < 3; ++k) f->corners[k] = mesh->positions + 3 * (size_t)corners[k];
    for (int k = 0; k < 3; ++k) {
        sub3(f->along[k], f->corners[(k + 1) % 3], f->corners[k]);
        f->lengths[k] = normalize3(f->along[k]);
        longest = max2(longest, f->lengths[k]);
    }
    sub3(ab, f->corners[1], f->corners[0]);
    sub3(ac, f->corners[2], f->corners[0]);
    cross3(f->normal, ab, ac);
    double area = normalize3(f->normal);
    for (int k = 0; k < 3; ++k) cross3(f->inward[k], f->normal, f->along[k]);
    for (int k = 0; k < 3; ++k)
        f->strips[k].count = 0, f->strips[k].width = f->strips[k].height = 0;
    for (int k = 0; k < 8; ++k) f->needs[k] = 0;
    f->slack = relative_slack * longest;
    f->most = most;
    f->height = 0;
    f->odd = f->unsure = 0;
    f->failed = 0;
    for (int i = 0; i < PROBES; ++i) {
        double p[3] = {0, 0, 0};
        for (int k = 0; k < 3; ++k) mad3(p, probe_weights[i][k], f->corners[k]);
        to_local(f, p, &f->probes[i]);
    }
    return area > f->slack * longest;
}

/* Returns whether the projection of a segment comes within the slack of T. */
static int meets(const frame *f, const local_point *a, const local_point *b) {
    double from = 0, to = 1;
    for (int k = 0; k < 3; ++k) {
        double p = a->inward[k] + f->slack, q = b->inward[k] + f->slack;
        if (p < 0 && q < 0) return 0;
        if (p < 0) from = max2(from, p / (p - q));
        if (q < 0) to = min2(to, p / (p - q));
    }
    return from <= to;
}

/* Returns the place of the projection of p along side k of T. */
static double place(const frame *f, int k, const double p[3]) {
    double d[3];
    sub3(d, p, f->corners[k]);
    return dot3(d, f->along[k]);
}

/* ---- heights --------------------------------------------------------------------------------- */

static local_point between(const local_point *a, const local_point *b, double t) {
    local_point r;
    for (int k = 0; k < 3; ++k) r.inward[k] = a->inward[k] + t * (b->inward[k] - a->inward[k]);
    r.height = a->height + t * (b->height - a->height);
    return r;
}

/* Clips a polygon by the line through side k of T (Sutherland, Hodgman 1974). */
static size_t clip(const local_point *from, size_t count, int k, local_point *to) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const local_point *a = &from[i], *b = &from[(i + 1) % count];
        double p = a->inward[k], q = b->inward[k];
        if (p >= 0) to[kept++] = *a;
        if ((p >= 0) != (q >= 0)) to[kept++] = between(a, b, p / (p - q));
    }
    return kept;
}

/* Raises the greatest height to that of a projected triangle over T. */
static void raise_height(frame *f, const local_point p[3]) {
    double greatest = max2(max2(fabs(p[0].height), fabs(p[1].height)), fabs(p[2].height));
    if (greatest <= f->height) return;
    local_point polygon[MAX_CLIPPED + 1], clipped[MAX_CLIPPED + 1];
    size_t count = 3;
    for (int i = 0; i < 3; ++i) polygon[i] = p[i];
    for (int k = 0; k < 3 && count; ++k) {
        count = clip(polygon, count, k, clipped);
        for (size_t i = 0; i < count; ++i) polygon[i] = clipped[i];
    }
    for (size_t i = 0; i < count; ++i) f->height = max2(f->height, fabs(polygon[i].height));
    if (f->height > f->most) f->failed = 1;
}

/* ---- covering -------------------------------------------------------------------------------- */

/* Returns whether all corners of a projected triangle lie on one side of a point. */
static int is_beside(const local_point p[3], const double at[3], double slack) {
    for (int k = 0; k < 3; ++k) {
        double a = p[0].inward[k], b = p[1].inward[k], c = p[2].inward[k];
        if (min2(min2(a, b), c) > at[k] + slack || max2(max2(a, b), c) < at[k] - slack) return 1;
    }
    return 0;
}

/* Returns 1 if the edge from a to b, projected, runs around a point counterclockwise, -1 if
 * clockwise, and 0 if rounding hides it. The distances from two of T's sides are oblique
 * coordinates on its plane. */
static int turn_around(const frame *f, const double a[3], const double b[3], const double at[3]) {
    double x = b[0] - a[0], y = b[1] - a[1], u = at[0] - a[0], v = at[1] - a[1];
    double area = x * v - y * u;
    double place = fabs(a[0]) + fabs(a[1]) + fabs(b[0]) + fabs(b[1]);
    double rounding = (f->slack + relative_slack * place) * (fabs(x) + fabs(y) + fabs(u) + fabs(v));
    return area > rounding ? 1 : area < -rounding ? -1 : 0;
}

/* Counts a projected triangle at each probe that it covers. */
static void count_at_probes(frame *f, const local_point p[3]) {
    for (int i = 0; i < PROBES; ++i) {
        const double *at = f->probes[i].inward;
        int turns[3], has[3] = {0, 0, 0};
        if (is_beside(p, at, f->slack)) continue;
        for (int k = 0; k < 3; ++k) {
            turns[k] = turn_around(f, p[k].inward, p[(k + 1) % 3].inward, at);
            has[turns[k] + 1] = 1;
        }
        if (has[0] && has[2]) continue; /* outside */
        if (has[1])
            f->unsure |= 1u << i;
        else
            f->odd ^= 1u << i;
    }
}

/* Returns whether an edge from corner k of T leads away from T at once. */
static int leads_away(const local_point *other, int k) {
    return other->inward[k] < 0 || other->inward[(k + 2) % 3] < 0;
}

/* Lists an edge of the border in the strip of side k. Returns 0 if there are too many. */
static int add_to_strip(frame *f, int k, const double *ends[2], const local_point *p[2]) {
    strip *s = &f->strips[k];
    double a = place(f, k, ends[0]), b = place(f, k, ends[1]);
    if (s->count == MAX_STRIP_EDGES) return 0;
    s->intervals[s->count++] = (interval){min2(a, b), max2(a, b)};
    for (int i = 0; i < 2; ++i) {
        s->width = max2(s->width, fabs(p[i]->inward[k]));
        s->height = max2(s->height, fabs(p[i]->height));
    }
    return 1;
}

/* Takes an edge of the border, whose ends are vertices of the source. */
static void add_border(frame *f, const psplat_mesh *mesh, const uint32_t corners[3],
                       const uint32_t vertices[2], const local_point *p[2]) {
    const double *ends[2] = {mesh->positions + 3 * (size_t)vertices[0],
                             mesh->positions + 3 * (size_t)vertices[1]};
    double widest = strip_part * f->most;
    unsigned sides = 0;
    for (int k = 0; k < 3; ++k) {
        if (fabs(p[0]->inward[k]) > widest || fabs(p[1]->inward[k]) > widest) continue;
        if (fabs(p[0]->height) > f->most || fabs(p[1]->height) > f->most) continue;
        if (add_to_strip(f, k, ends, p)) sides |= 1u << k;
    }
    if (!meets(f, p[0], p[1])) return;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 2; ++i)
            if (vertices[i] == corners[k] && leads_away(p[1 - i], k)) return;
    f->needs[sides] = 1;
}

static int compare_intervals(const void *left, const void *right) {
    double a = ((const interval *)left)->from, b = ((const interval *)right)->from;
    return (a > b) - (a < b);
}

/* Returns whether the edges of a strip reach from one end of side k to the other. */
static int is_strip_whole(frame *f, int k) {
    strip *s = &f->strips[k];
    double reached = 0;
    qsort(s->intervals, s->count, sizeof *s->intervals, compare_intervals);
    for (size_t i = 0; i < s->count && s->intervals[i].from <= reached + f->slack; ++i)
        reached = max2(reached, s->intervals[i].to);
    return s->count && reached >= f->lengths[k] - f->slack;
}

/* Returns the sine of T's angle at a corner if the angle is obtuse, else 1. */
static double obtuse_sine(const frame *f, int corner) {
    const double *in = f->along[(corner + 2) % 3], *out = f->along[corner];
    double cosine = -dot3(in, out);
    return cosine < 0 ? sqrt(max2(1 - cosine * cosine, 0)) : 1;
}

/* Returns the greatest distance of a point of the strip along side k from the border. At an obtuse
 * corner some points have no border across, and the corner is the next. */
static double strip_deviation(const frame *f, int k) {
    const strip *s = &f->strips[k];
    double across = sqrt(4 * s->width * s->width + s->height * s->height);
    double sine = min2(obtuse_sine(f, k), obtuse_sine(f, (k + 1) % 3));
    return sine > 0 ? max2(across, s->width / sine) : HUGE_VAL;
}

/* Returns whether a probe of an odd count lies outside all strips, which are a bit for each side.
 */
static int is_covered(const frame *f, unsigned strips) {
    for (int i = 0; i < PROBES; ++i) {
        int is_inside = (f->odd & ~f->unsure) >> i & 1;
        for (int k = 0; k < 3; ++k)
            if (strips >> k & 1 && f->probes[i].inward[k] <= f->strips[k].width) is_inside = 0;
        if (is_inside) return 1;
    }
    return 0;
}

/* Returns the proven bound after the flood, or HUGE_VAL. */
static double deviation_of(frame *f) {
    unsigned strips = 0, needed = 0;
    double most = f->height;
    if (f->failed || f->needs[0]) return HUGE_VAL;
    for (unsigned sides = 1; sides < 8; ++sides)
        if (f->needs[sides]) needed |= sides;
    for (int k = 0; k < 3; ++k)
        if (needed >> k & 1 && is_strip_whole(f, k)) strips |= 1u << k;
    for (unsigned sides = 1; sides < 8; ++sides)
        if (f->needs[sides] && !(sides & strips)) return HUGE_VAL;
    for (int k = 0; k < 3; ++k)
        if (strips >> k & 1) most = max2(most, strip_deviation(f, k));
    return is_covered(f, strips) && most <= f->most ? most : HUGE_VAL;
}

/* ---- flood ----------------------------------------------------------------------------------- */

static int push(psplat_proxy_search *s, uint32_t triangle) {
    if (s->visited[triangle] == s->stamp) return 1;
    if (s->count == s->capacity) {
        size_t capacity = 2 * s->capacity + 256;
        uint32_t *larger = realloc(s->stack, capacity * sizeof *larger);
        if (!larger) return 0;
        s->stack = larger;
        s->capacity = capacity;
    }
    s->visited[triangle] = s->stamp;
    s->stack[s->count++] = triangle;
    return 1;
}

/* Takes the edge from corner k of a triangle. Returns 0 when out of memory. */
static int take_edge(psplat_proxy_search *s, frame *f, const uint32_t corners[3], uint32_t edge,
                     const local_point *p[2]) {
    const uint32_t *triangles = s->source->triangles;
    uint32_t next = s->neighbors[edge];
    double reach = reach_deviations * f->most;
    if (next == PSPLAT_NONE) {
        uint32_t ends[2] = {triangles[edge], triangles[edge % 3 == 2 ? edge - 2 : edge + 1]};
        add_border(f, s->source, corners, ends, p);
        return 1;
    }
    if (s->visited[next] == s->stamp || !meets(f, p[0], p[1])) return 1;
    if (fabs(p[0]->height) > reach && fabs(p[1]->height) > reach) {
        f->failed = 1;
        return 1;
    }
    return push(s, next);
}

static int take_triangle(psplat_proxy_search *s, frame *f, const uint32_t corners[3],
                         uint32_t triangle) {
    local_point p[3];
    for (int k = 0; k < 3; ++k) to_local(f, psplat_mesh_corner(s->source, triangle, k), &p[k]);
    raise_height(f, p);
    count_at_probes(f, p);
    for (uint32_t k = 0; k < 3; ++k) {
        const local_point *ends[2] = {&p[k], &p[(k + 1) % 3]};
        if (!take_edge(s, f, corners, 3 * triangle + k, ends)) return 0;
    }
    return 1;
}

psplat_result psplat_proxy_bound(psplat_proxy_search *search, const uint32_t corners[3],
                                 uint32_t start, double *deviation) {
    frame f;
    *deviation = HUGE_VAL;
    search->count = 0;
    if (!set_frame(&f, search->source, corners, search->most)) return PSPLAT_OK;
    if (!push(search, start)) return PSPLAT_ERROR_MEMORY;
    for (size_t at = 0; at < search->count; ++at)
        if (!take_triangle(search, &f, corners, search->stack[at])) return PSPLAT_ERROR_MEMORY;
    *deviation = deviation_of(&f);
    return PSPLAT_OK;
}
