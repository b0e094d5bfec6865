/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region.c - the shape of a splat, an ellipse cut by clip lines: its surface, point tests, its
 * polygon and area.
 */
#include "base/region.h"

#include "base/angle.h"
#include "base/vector.h"

#include <math.h>
#include <string.h>

/* The corners between the ends of a bent line's part of a polygon, and the tangents that stand for
 * one that bulges out. */
enum { ARC_CORNERS = 3, ARC_TANGENTS = ARC_CORNERS + 1 };

/* The most steps that move a corner to where lines keep it, how far beyond them, in units of their
 * values, it may end, and the rows of which areas between bent lines are made. */
enum { MOVES = 20, ROWS = 128 };
static const double corner_slack = 1e-9;

/* The area of the inscribed polygon of OUTLINE_SIDES sides: 32 sin(2 pi / 64). */
static const double whole_area = 3.1365484905459393;

/* The sides of the finest polygon, the most corners of a polygon that is handed out, and the room
 * while one is cut: each clip line adds one, bent ones up to two arcs, and rounding may add some.
 */
enum {
    OUTLINE_SIDES = 64,
    OUTLINE_CORNERS = OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES,
    /* Of a curved surface, points between corners may be farther from another one than these, so
     * that there are points along sides, too, and more rings. */
    CURVED_SIDES = 64,
    CURVED_POINTS = 96,
    CURVED_RINGS = 4,
    MAX_CORNERS = OUTLINE_CORNERS + 2 * (ARC_CORNERS + 2) * PSPLAT_MAX_CLIP_LINES + 4
};

/* ---- the surface --------------------------------------------------------------------------- */

double psplat_region_bend(const psplat_region *r) {
    const double *h = r->hessian;
    return fabs(h[0] + h[2]) / 2 + norm2((h[0] - h[2]) / 2, h[1]);
}

double psplat_region_reach(const psplat_region *r) {
    double most = max2(r->radius[0], r->radius[1]);
    if (!psplat_region_is_curved(r)) return most;
    /* Heights on the rim are those of the slopes, and half of the second derivative along it. */
    double height = norm2(r->slope[0] * r->radius[0], r->slope[1] * r->radius[1]);
    const double form[3] = {r->hessian[0] * r->radius[0] * r->radius[0],
                            r->hessian[1] * r->radius[0] * r->radius[1],
                            r->hessian[2] * r->radius[1] * r->radius[1]};
    height += (fabs(form[0] + form[2]) / 2 + norm2((form[0] - form[2]) / 2, form[1])) / 2;
    return norm2(most, height);
}

/* ---- clip lines ---------------------------------------------------------------------------- */

void psplat_region_add_line(psplat_region *region, const double line[3], double bend) {
    uint32_t at = region->line_count++, seams = region->seam_count;
    memmove(region->lines[at + 1], region->lines[at], seams * sizeof *region->lines);
    memmove(region->bends + at + 1, region->bends + at, seams * sizeof *region->bends);
    memcpy(region->lines[at], line, sizeof region->lines[at]);
    region->bends[at] = bend;
}

void psplat_region_remove_line(psplat_region *region) {
    uint32_t at = --region->line_count, seams = region->seam_count;
    memmove(region->lines[at], region->lines[at + 1], seams * sizeof *region->lines);
    memmove(region->bends + at, region->bends + at + 1, seams * sizeof *region->bends);
    region->chart_lines &= ~(1u << at);
    memset(region->lines[at + seams], 0, sizeof region->lines[0]);
    region->bends[at + seams] = 0;
}

void psplat_region_line_point(const psplat_region *region, uint32_t i, double m, double uv[2]) {
    const double *line = region->lines[i];
    double length = norm2(line[0], line[1]), x = line[0] / length, y = line[1] / length;
    double away = -line[2] / length - region->bends[i] * length * m * m / 2;
    uv[0] = away * x - m * y;
    uv[1] = away * y + m * x;
}

/* ---- polygons ------------------------------------------------------------------------------ */

typedef double corner[2]; /* u, v */

static double line_distance(const double line[3], const double p[2]) {
    return line[0] * p[0] + line[1] * p[1] + line[2];
}

/* Keeps the part of a polygon with line >= 0 (Sutherland, Hodgman 1974). Returns the number of its
 * corners. */
static size_t clip_polygon(const double line[3], corner *in, size_t count, corner *out) {
    size_t result = 0;
    /* Rounding may give a sliver more corners than a convex polygon can have; they are left out. */
    for (size_t i = 0; i < count && result + 2 <= MAX_CORNERS; ++i) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        double da = line_distance(line, a), db = line_distance(line, b);
        if (da >= 0) memcpy(out[result++], a, sizeof(corner));
        if ((da >= 0) == (db >= 0)) continue;
        double t = da / (da - db);
        for (int k = 0; k < 2; ++k) out[result][k] = a[k] + t * (b[k] - a[k]);
        ++result;
    }
    return result;
}

static double arc_place(const double line[3], const double p[2]) {
    return (line[0] * p[1] - line[1] * p[0]) / norm2(line[0], line[1]);
}

/* Stores the corners of bent line i strictly between two of its points. Returns their number. */
static size_t add_arc(const psplat_region *region, uint32_t i, const double *from, const double *to,
                      corner *out) {
    double a = arc_place(region->lines[i], from), b = arc_place(region->lines[i], to);
    for (size_t k = 0; k < ARC_CORNERS; ++k)
        psplat_region_line_point(region, i, a + (b - a) * (double)(k + 1) / (ARC_CORNERS + 1),
                                 out[k]);
    return ARC_CORNERS;
}

/* Stores where a side of a polygon meets bent line i, whose values at its ends have different
 * signs. The value is quadratic along the side, so that it has one root there: of the two that the
 * quadratic has, the one within 0 ... 1. */
static void meet_arc(const psplat_region *region, uint32_t i, const double *a, const double *b,
                     double out[2]) {
    const double *line = region->lines[i];
    double along = line[0] * (b[1] - a[1]) - line[1] * (b[0] - a[0]);
    double c0 = psplat_region_line_value(region, i, a), c2 = region->bends[i] * along * along / 2;
    double c1 = psplat_region_line_value(region, i, b) - c0 - c2;
    double half = -(c1 + copysign(sqrt(max2(c1 * c1 - 4 * c0 * c2, 0)), c1)) / 2;
    double t = half != 0 ? c0 / half : 0;
    if (!(t >= 0 && t <= 1)) t = c2 != 0 ? min2(max2(half / c2, 0), 1) : 0;
    for (int k = 0; k < 2; ++k) out[k] = a[k] + t * (b[k] - a[k]);
}

/* Keeps the part of a polygon that bent line i keeps, with chords in place of the line. Returns the
 * number of corners. */
static size_t clip_by_arc(const psplat_region *region, uint32_t i, corner *in, size_t count,
                          corner *out) {
    size_t result = 0, first = 0;
    const double *left = NULL; /* where the polygon went out */
    corner exits[MAX_CORNERS];
    while (first < count && psplat_region_line_value(region, i, in[first]) < 0) ++first;
    if (first == count) return 0;
    for (size_t k = 0; k < count && result + ARC_CORNERS + 2 <= MAX_CORNERS; ++k) {
        const double *a = in[(first + k) % count], *b = in[(first + k + 1) % count];
        int from = psplat_region_line_value(region, i, a) >= 0,
            to = psplat_region_line_value(region, i, b) >= 0;
        if (from) memcpy(out[result++], a, sizeof(corner));
        if (from == to) continue;
        meet_arc(region, i, a, b, exits[k]);
        if (!from && left) result += add_arc(region, i, left, exits[k], out + result);
        left = from ? exits[k] : NULL;
        memcpy(out[result++], exits[k], sizeof(corner));
    }
    return result;
}

/* Clips a polygon by tangents of bent line i, which bulges out: they keep all that it keeps. */
static size_t clip_by_tangents(const psplat_region *region, uint32_t i, corner *in, size_t count,
                               corner *out) {
    const double *line = region->lines[i];
    for (int k = 0; k < ARC_TANGENTS && count; ++k) {
        double m = 2.0 * (k + 0.5) / ARC_TANGENTS - 1, length = norm2(line[0], line[1]), p[2];
        double bend = region->bends[i] * length * length * m; /* the slope along the line, by m */
        psplat_region_line_point(region, i, m, p);
        double tangent[3] = {line[0] - bend * line[1] / length, line[1] + bend * line[0] / length};
        tangent[2] = -tangent[0] * p[0] - tangent[1] * p[1];
        count = clip_polygon(tangent, in, count, out);
        memcpy(in, out, count * sizeof(corner));
    }
    return count;
}

/* Clips a polygon by all lines: the bent ones first, while its sides are short. */
static size_t clip_by_lines(const psplat_region *region, int inscribed, corner *corners,
                            size_t count) {
    corner clipped[MAX_CORNERS];
    for (int bent = 1; bent >= 0; --bent)
        for (uint32_t i = 0; i < region->line_count && count; ++i) {
            double bend = region->bends[i];
            if ((bend != 0) != bent) continue;
            if (!bent)
                count = clip_polygon(region->lines[i], corners, count, clipped);
            else if (bend < 0 && !inscribed)
                count = clip_by_tangents(region, i, corners, count, clipped);
            else
                count = clip_by_arc(region, i, corners, count, clipped);
            memcpy(corners, clipped, count * sizeof(corner));
        }
    return count;
}

/* Moves the corners of an inscribed polygon that lie on chords of lines that bulge in, where
 * another line meets these, to what both lines keep. Each step moves a corner onto the line that it
 * is beyond. Those that find no place are left out. Returns the number of corners. */
static size_t move_inside(const psplat_region *region, corner *corners, size_t count) {
    size_t result = 0;
    for (size_t k = 0; k < count; ++k) {
        double *p = corners[k];
        for (int step = 0; step < MOVES && !psplat_region_contains(region, p, HUGE_VAL, 0); ++step)
            for (uint32_t i = 0; i < region->line_count; ++i) {
                const double *line = region->lines[i];
                double beyond = min2(psplat_region_line_value(region, i, p), 0) /
                                (line[0] * line[0] + line[1] * line[1]);
                p[0] -= beyond * line[0];
                p[1] -= beyond * line[1];
            }
        if (psplat_region_contains(region, p, 1 + corner_slack, corner_slack))
            memmove(corners[result++], p, sizeof(corner));
    }
    return result;
}

/* Stores the corners of a regular polygon of `sides` sides in the unit circle or around it. */
static void regular_polygon(size_t sides, int inscribed, corner *corners) {
    double half = PSPLAT_PI / (double)sides, step[2] = {cos(2 * half), sin(2 * half)};
    double p[2] = {1, inscribed ? 0 : tan(half)};
    for (size_t i = 0; i < sides; ++i) {
        double x = p[0];
        corners[i][0] = p[0], corners[i][1] = p[1];
        p[0] = step[0] * x - step[1] * p[1];
        p[1] = step[1] * x + step[0] * p[1];
    }
}

size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity) {
    corner corners[MAX_CORNERS];
    size_t sides = capacity - PSPLAT_MAX_CLIP_LINES, count;
    if (sides > OUTLINE_SIDES) sides = OUTLINE_SIDES;
    for (uint32_t i = 0; i < region->line_count; ++i)
        if (region->bends[i] != 0) sides -= ARC_CORNERS;
    /* A bent line may cut off two corners and leave ten; then there is room for fewer others. */
    for (;; sides -= count - capacity) {
        regular_polygon(sides, inscribed, corners);
        count = clip_by_lines(region, inscribed, corners, sides);
        if (count <= capacity || sides < count - capacity + 3) break;
    }
    count = count < capacity ? count : capacity;
    for (uint32_t i = 0; i < region->line_count && inscribed; ++i)
        if (region->bends[i] > 0) {
            count = move_inside(region, corners, count);
            break;
        }
    memcpy(polygon, corners, count * sizeof(corner));
    return count;
}

/* The parts of a row of the disc that lines keep: disjoint ranges of u. Each line that bulges in
 * may add one. */
typedef struct row {
    double low[1 + PSPLAT_MAX_CLIP_LINES], high[1 + PSPLAT_MAX_CLIP_LINES];
    size_t count;
} row;

/* Adds what of a range lies between two numbers. */
static void add_range(row *r, double low, double high, double from, double to) {
    if (max2(low, from) >= min2(high, to) || r->count > PSPLAT_MAX_CLIP_LINES) return;
    r->low[r->count] = max2(low, from);
    r->high[r->count++] = min2(high, to);
}

/* Cuts a row at v by line i, whose value is quadratic in u: with two roots it is positive between
 * them or outside. */
static void cut_row(const psplat_region *region, uint32_t i, double v, row *r) {
    const double *line = region->lines[i], bend = region->bends[i];
    double c0 = psplat_region_line_value(region, i, (const double[2]){0, v});
    double c1 = line[0] - bend * line[0] * line[1] * v, c2 = bend * line[1] * line[1] / 2;
    double square = c1 * c1 - 4 * c0 * c2, near = -HUGE_VAL, far = HUGE_VAL;
    double half = -(c1 + copysign(sqrt(max2(square, 0)), c1)) / 2;
    row kept = {.count = 0};
    if (square > 0 && half != 0) {
        double other = c2 != 0 ? half / c2 : copysign(HUGE_VAL, c1);
        near = min2(c0 / half, other), far = max2(c0 / half, other);
    }
    int is_between = c2 < 0 || (c2 == 0 && c1 != 0);
    if (!(square > 0) && (c2 < 0 || (c2 == 0 && c0 < 0))) near = far = 0; /* Nothing is kept. */
    for (size_t k = 0; k < r->count; ++k) {
        if (is_between || !(square > 0)) {
            add_range(&kept, near, far, r->low[k], r->high[k]);
        } else {
            add_range(&kept, -HUGE_VAL, near, r->low[k], r->high[k]);
            add_range(&kept, far, HUGE_VAL, r->low[k], r->high[k]);
        }
    }
    *r = kept;
}

/* Returns the area in (u, v) that bent lines leave of the disc: that of rows, as chords of bent
 * lines may miss much of what several of them leave. */
static double bent_area(const psplat_region *region) {
    double sum = 0, height = 2.0 / ROWS;
    for (int k = 0; k < ROWS; ++k) {
        double v = (k + 0.5) * height - 1, half = sqrt(1 - v * v);
        row r = {{-half}, {half}, 1};
        for (uint32_t i = 0; i < region->line_count; ++i) cut_row(region, i, v, &r);
        for (size_t i = 0; i < r.count; ++i) sum += r.high[i] - r.low[i];
    }
    return sum * height;
}

static int has_bends(const psplat_region *region) {
    for (uint32_t i = 0; i < region->line_count; ++i)
        if (region->bends[i] != 0) return 1;
    return 0;
}

double psplat_region_area(const psplat_region *region) {
    if (!region->line_count) return whole_area * region->radius[0] * region->radius[1];
    if (has_bends(region)) return bent_area(region) * region->radius[0] * region->radius[1];
    double polygon[OUTLINE_CORNERS][2], twice = 0;
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE_CORNERS);
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[i + 1 < count ? i + 1 : 0];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2 * region->radius[0] * region->radius[1];
}

/* Moves a point of a side out to the rim of the ellipse, unless that side is a line's. */
static void move_to_rim(const psplat_region *region, corner at) {
    double length = norm2(at[0], at[1]);
    const corner out = {at[0] / length, at[1] / length};
    if (psplat_region_contains(region, out, 1 + 2 * corner_slack, 2 * corner_slack))
        memcpy(at, out, sizeof out);
}

/* Splits the sides of a region's polygon into parts of about the same length, between corners on
 * the rim along that. Returns the number of corners then, which is at most `most`, if that is more
 * than count. */
static size_t split_sides(const psplat_region *region, corner *in, size_t count, size_t most,
                          corner *out) {
    double around = 0;
    size_t result = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        around += norm2(b[0] - a[0], b[1] - a[1]);
    }
    for (size_t i = 0; i < count; ++i) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        double share = norm2(b[0] - a[0], b[1] - a[1]) / around * (double)(most - count);
        size_t parts = share > 1 ? (size_t)ceil(share) : 1;
        int rim = norm2(a[0], a[1]) > 1 - corner_slack && norm2(b[0], b[1]) > 1 - corner_slack;
        for (size_t part = 0; part < parts && result < most; ++part, ++result) {
            for (int k = 0; k < 2; ++k)
                out[result][k] = a[k] + (b[k] - a[k]) * (double)part / (double)parts;
            if (part && rim) move_to_rim(region, out[result]);
        }
    }
    return result;
}

/* Stores the points of the surface over a polygon's corners and its middle, and over rings between
 * them. Lines that bulge in may cut off what lies between corners. */
static size_t ring_points(const psplat_region *region, corner *polygon, size_t count, int rings,
                          double (*points)[3]) {
    double middle[2] = {0, 0};
    size_t stored = 0;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    for (size_t i = 0; i < (size_t)rings * count + 1; ++i) {
        double t = i < (size_t)rings * count ? 1 - (double)(i / count) / rings : 0;
        const double *corner = polygon[i % count];
        const double uv[2] = {middle[0] + t * (corner[0] - middle[0]),
                              middle[1] + t * (corner[1] - middle[1])};
        if (psplat_region_contains(region, uv, 1 + 2 * corner_slack, 2 * corner_slack))
            psplat_region_point(region, uv, points[stored++]);
    }
    return stored;
}

/* Stores the points over so many rings, of which there are two at most where they are not dense. */
static size_t points_of_rings(const psplat_region *region, int rings, int is_dense,
                              double (*points)[3]) {
    corner polygon[OUTLINE_CORNERS], sides[CURVED_POINTS];
    size_t capacity = is_dense ? CURVED_SIDES + PSPLAT_MAX_CLIP_LINES : OUTLINE_CORNERS;
    size_t count = psplat_region_polygon(region, 1, polygon, capacity);
    if (!count) return 0;
    if (!is_dense) return ring_points(region, polygon, count, rings < 2 ? rings : 2, points);
    count = split_sides(region, polygon, count, CURVED_POINTS, sides);
    return ring_points(region, sides, count, rings, points);
}

size_t psplat_region_points(const psplat_region *region, double (*points)[3]) {
    return points_of_rings(region, CURVED_RINGS, psplat_region_is_curved(region), points);
}

size_t psplat_region_dense_points(const psplat_region *region, double (*points)[3]) {
    return points_of_rings(region, CURVED_RINGS, 1, points);
}

size_t psplat_region_rim_points(const psplat_region *region, double (*points)[3]) {
    return points_of_rings(region, 1, psplat_region_is_curved(region), points);
}
