/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clip_lines.c - the fit of clip lines that keep a splat on its side of the creases around it.
 *
 * A convex region free of creases is found around the seed as in IRIS (Deits, Tedrake 2014): the
 * crease that is nearest in the ellipse's metric gives a line, all creases behind that line are
 * done, and the next nearest one gives the next line. A line is fitted to a chain of crease edges,
 * straight or curved, as far as all of them stay within the slack. Where a bent line (spec 3.6)
 * fits more of the chain than a straight one, it is taken instead: a parabola needs about half as
 * many pieces. A line touches the chain from outside, so that a convex chain loses no surface.
 */
#include "base/vector.h"
#include "fit/clip_lines.h"

#include "base/region.h"
#include "fit/crease_segments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is left of a crease segment after the lines chosen so far. */
typedef struct piece {
    double a[2], b[2]; /* its ends (u, v), the surface to its left */
    uint32_t vertex[2];
    size_t previous, next; /* in the chain, or SIZE_MAX */
    int done;              /* 1: no line is needed for it any more */
    int is_chart;          /* as in psplat_segment */
} piece;

/* The state of one choice of lines. */
typedef struct clipper {
    piece *pieces;
    size_t count;
    double radius[2]; /* lengths of u and v */
    double seed[2];   /* (u, v) */
    double slack;     /* a length */
    int may_bend;     /* 0: lines are straight */
} clipper;

/* A line that keeps the points where its value is at least 0 (spec 3.6); (a, b) is a unit vector.
 */
typedef struct clip_line {
    double a, b, c, bend;
} clip_line;

/* The greatest bend of a line; spec 3.6 allows 4. */
static const double greatest_bend = 3;

/* Returns the place of a point along a line, in (u, v). */
static double place_along(const clip_line *line, const double uv[2]) {
    return line->a * uv[1] - line->b * uv[0];
}

static double line_value(const clip_line *line, const double uv[2]) {
    double along = place_along(line, uv);
    return line->a * uv[0] + line->b * uv[1] + line->c + line->bend * along * along / 2;
}

/* Returns by how much a line's value changes in a length along its normal, of a bent one where its
 * place is 0. */
static double rate_of(const clipper *c, const clip_line *line) {
    return norm2(line->a / c->radius[0], line->b / c->radius[1]);
}

/* The same at a point, given that rate: of a bent line it is at most the rate at the vertex, so
 * that distances are rather too large. */
static double rate_at(const clipper *c, const clip_line *line, double rate, const double uv[2]) {
    if (line->bend == 0) return rate;
    double turn = line->bend * place_along(line, uv);
    double a = line->a - turn * line->b, b = line->b + turn * line->a;
    return min2(rate, norm2(a / c->radius[0], b / c->radius[1]));
}

/* Returns about how far, in lengths, a line of a given rate keeps a point. */
static double distance_at(const clipper *c, const clip_line *line, double rate,
                          const double uv[2]) {
    return line_value(line, uv) / rate_at(c, line, rate, uv);
}

static double line_distance(const clipper *c, const clip_line *line, const double uv[2]) {
    return distance_at(c, line, rate_of(c, line), uv);
}

static double seed_distance(const clipper *c, const piece *p) {
    double d[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]};
    double s[2] = {c->seed[0] - p->a[0], c->seed[1] - p->a[1]};
    double length = d[0] * d[0] + d[1] * d[1];
    double t = length > 0 ? (s[0] * d[0] + s[1] * d[1]) / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return norm2(s[0] - t * d[0], s[1] - t * d[1]);
}

/* Gives a straight line the direction (a, b), of any length, through a point. */
static void set_direction(double a, double b, const double at[2], clip_line *line) {
    double length = norm2(a, b);
    line->a = a / length, line->b = b / length;
    line->c = -(line->a * at[0] + line->b * at[1]);
    line->bend = 0;
}

/* Finds the line from a to b that keeps its left side. Returns 0 for coincident points. */
static int line_through(const clipper *c, const double a[2], const double b[2], clip_line *line) {
    double d[2] = {b[0] - a[0], b[1] - a[1]};
    double length = norm2(d[0] * c->radius[0], d[1] * c->radius[1]);
    if (!(length > 1e-9 * c->radius[0])) return 0;
    set_direction(-d[1], d[0], a, line);
    return 1;
}

/* Returns the piece nearest to the seed, or SIZE_MAX. Among equally near ones it is the one whose
 * line has the seed farthest to its left: at a reflex corner both edges are equally near, but the
 * line of one may cut the seed off. */
static size_t nearest_piece(const clipper *c) {
    size_t best = SIZE_MAX;
    double best_distance = HUGE_VAL, best_left = -HUGE_VAL;
    for (size_t i = 0; i < c->count; ++i) {
        clip_line line;
        if (c->pieces[i].done || !line_through(c, c->pieces[i].a, c->pieces[i].b, &line)) continue;
        double distance = seed_distance(c, &c->pieces[i]);
        double left = line_distance(c, &line, c->seed);
        int nearer = distance < best_distance - 1e-9;
        if (!nearer && !(distance <= best_distance + 1e-9 && left > best_left)) continue;
        best = i, best_distance = distance, best_left = left;
    }
    return best;
}

/* A run of pieces along the chain, first ... last. */
typedef struct run {
    size_t first, last;
} run;

/* Stores the points at which a piece is measured, and returns their number: a straight piece may
 * leave a bent line most in its middle. */
static int points_of(const piece *p, const clip_line *line, double points[3][2]) {
    for (int k = 0; k < 2; ++k) {
        points[0][k] = p->a[k], points[1][k] = p->b[k];
        points[2][k] = (p->a[k] + p->b[k]) / 2;
    }
    return line->bend != 0 ? 3 : 2;
}

/* Returns the least value of a line at the points of a run. */
static double least_value(const clipper *c, run r, const clip_line *line) {
    double least = HUGE_VAL, points[3][2];
    for (size_t i = r.first;; i = c->pieces[i].next) {
        int count = points_of(&c->pieces[i], line, points);
        for (int k = 0; k < count; ++k) least = min2(least, line_value(line, points[k]));
        if (i == r.last) return least;
    }
}

/* Returns whether a run leaves a line by no more than the slack. Most lines that are tried do not
 * fit, which one point is enough to tell. */
static int keeps_slack(const clipper *c, run r, const clip_line *line) {
    double rate = rate_of(c, line), points[3][2];
    for (size_t i = r.first;; i = c->pieces[i].next) {
        int count = points_of(&c->pieces[i], line, points);
        for (int k = 0; k < count; ++k)
            if (line_value(line, points[k]) / rate_at(c, line, rate, points[k]) > c->slack)
                return 0;
        if (i == r.last) return 1;
    }
}

/* Moves a line out until it touches a run. Returns 0 where the run leaves it by more than the
 * slack, or where the line would cut off the seed. */
static int touch_run(const clipper *c, run r, clip_line *line) {
    line->c -= least_value(c, r, line);
    return line_distance(c, line, c->seed) >= -1e-9 * c->radius[0] && keeps_slack(c, r, line);
}

/* Fits a straight line to a run, of the direction of its chord. */
static int fit_straight(const clipper *c, run r, clip_line *line) {
    return line_through(c, c->pieces[r.first].a, c->pieces[r.last].b, line) &&
           touch_run(c, r, line);
}

/* Solves m x = right of three unknowns by elimination. Returns 0 where m is singular. */
static int solve3(double m[3][3], double right[3]) {
    for (int k = 0; k < 3; ++k) {
        if (!(m[k][k] > 1e-12 * m[0][0])) return 0;
        for (int l = k + 1; l < 3; ++l) {
            double factor = m[l][k] / m[k][k];
            for (int i = k; i < 3; ++i) m[l][i] -= factor * m[k][i];
            right[l] -= factor * right[k];
        }
    }
    for (int k = 3; k-- > 0;) {
        for (int l = k + 1; l < 3; ++l) right[k] -= m[k][l] * right[l];
        right[k] /= m[k][k];
    }
    return 1;
}

/* Fits value = c + slope y + bend y^2 / 2 over the places y along a line to the ends and the
 * middles of a run's pieces, by least squares. Returns 0 where these do not determine a parabola.
 */
static int fit_parabola(const clipper *c, run r, const clip_line *line, double x[3]) {
    double m[3][3] = {{0}};
    memset(x, 0, 3 * sizeof *x);
    for (size_t i = r.first;; i = c->pieces[i].next) {
        const piece *p = &c->pieces[i];
        for (int k = 0; k <= 2; ++k) {
            const double uv[2] = {p->a[0] + (p->b[0] - p->a[0]) * k / 2,
                                  p->a[1] + (p->b[1] - p->a[1]) * k / 2};
            double y = place_along(line, uv), row[3] = {1, y, y * y / 2};
            double value = line->a * uv[0] + line->b * uv[1];
            for (int j = 0; j < 3; ++j) {
                for (int l = 0; l < 3; ++l) m[j][l] += row[j] * row[l];
                x[j] += row[j] * value;
            }
        }
        if (i == r.last) break;
    }
    return solve3(m, x);
}

/* Fits a bent line to a run: a parabola whose direction is turned until its vertex is where
 * spec 3.6 has it. */
static int fit_bent(const clipper *c, run r, clip_line *line) {
    enum { TURNS = 3 };
    double x[3] = {0};
    if (!line_through(c, c->pieces[r.first].a, c->pieces[r.last].b, line)) return 0;
    for (int turn = 0; turn < TURNS; ++turn) {
        double a = line->a, b = line->b;
        const double at[2] = {0, 0};
        if (!fit_parabola(c, r, line, x) || !(fabs(x[1]) < 1)) return 0;
        if (turn + 1 < TURNS) set_direction(a + x[1] * b, b - x[1] * a, at, line);
    }
    line->c = -x[0];
    line->bend = -x[2];
    return fabs(line->bend) <= greatest_bend && touch_run(c, r, line);
}

static int fit_run(const clipper *c, run r, int bent, clip_line *line) {
    return bent ? fit_bent(c, r, line) : fit_straight(c, r, line);
}

/* Returns a run longer by one piece at one end; its first is SIZE_MAX where there is none. */
static run longer_run(const clipper *c, run r, int end) {
    size_t next = end ? c->pieces[r.last].next : c->pieces[r.first].previous;
    if (next == SIZE_MAX || next == r.first || next == r.last || c->pieces[next].done)
        r.first = SIZE_MAX;
    else if (end)
        r.last = next;
    else
        r.first = next;
    return r;
}

/* Returns a run longer by so many pieces at one end; its first is SIZE_MAX where there are fewer.
 */
static run run_longer_by(const clipper *c, run r, int end, size_t pieces) {
    for (size_t i = 0; i < pieces && r.first != SIZE_MAX; ++i) r = longer_run(c, r, end);
    return r;
}

/* Extends a run at one end by at most so many pieces, or half of that, a quarter and so on, and
 * stores its line. Returns how many they are; 0 where not even one fits. */
static size_t extend_end(const clipper *c, int bent, int end, size_t most, run *r,
                         clip_line *line) {
    for (size_t pieces = most; pieces; pieces /= 2) {
        run longer = run_longer_by(c, *r, end, pieces);
        clip_line candidate;
        if (longer.first == SIZE_MAX || !fit_run(c, longer, bent, &candidate)) continue;
        *r = longer, *line = candidate;
        return pieces;
    }
    return 0;
}

/* Extends a run at both ends in turn while one line still fits it, and stores that line. Returns
 * how many pieces it became longer by. Long runs grow by half of themselves at once, since each
 * line takes time in proportion to its run: a border may have thousands of pieces. */
static size_t extend_run(const clipper *c, int bent, run *r, clip_line *line) {
    enum { LONG_RUN = 16 };
    size_t total = 0;
    for (size_t grown = 1; grown;) {
        grown = 0;
        for (int end = 0; end < 2; ++end)
            grown += extend_end(c, bent, end, total < LONG_RUN ? 1 : total / 2, r, line);
        total += grown;
    }
    return total;
}

/* Finds the longest run around a piece that has a line, and the line. Returns 0 where not even the
 * piece alone has one. */
static int grow_run(const clipper *c, run *r, clip_line *line) {
    if (!fit_straight(c, *r, line)) return 0;
    extend_run(c, 0, r, line);
    if (!c->may_bend) return 1;
    /* A parabola may leave the run by more at first, and by less once the run is longer: a chord is
     * nearest to a short arc. One step is taken for good at either end. */
    extend_run(c, 1, r, line);
    return 1;
}

static int is_chart_run(const clipper *c, run r) {
    int is_chart = c->pieces[r.first].is_chart;
    for (size_t i = r.first; i != r.last; i = c->pieces[i].next)
        is_chart &= c->pieces[c->pieces[i].next].is_chart;
    return is_chart;
}

/* Returns the part of a piece at which a line crosses it, between ends on both sides. */
static double crossing(const clip_line *line, const piece *p) {
    const double d[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]};
    double at = line_value(line, p->a), to = line_value(line, p->b), along = place_along(line, d);
    /* The value is at + slope t + square t^2. */
    double square = line->bend * along * along / 2, slope = to - at - square;
    double root = sqrt(slope * slope - 4 * square * at);
    double q = -(slope + (slope < 0 ? -root : root)) / 2;
    double t = q != 0 ? at / q : 0;
    return t >= 0 && t <= 1 ? t : q / square;
}

/* Marks the pieces that a line cuts away as done, and shortens those that it crosses. */
static void apply_line(clipper *c, const clip_line *line) {
    double most = c->slack * (1 + 1e-9), rate = rate_of(c, line);
    for (size_t i = 0; i < c->count; ++i) {
        piece *p = &c->pieces[i];
        if (p->done) continue;
        const double middle[2] = {(p->a[0] + p->b[0]) / 2, (p->a[1] + p->b[1]) / 2};
        double a = distance_at(c, line, rate, p->a), b = distance_at(c, line, rate, p->b);
        double m = line->bend != 0 ? distance_at(c, line, rate, middle) : a;
        p->done = max2(m, max2(a, b)) <= most;
        if (p->done || (a >= 0) == (b >= 0)) continue;
        double *out = a < 0 ? p->a : p->b, t = crossing(line, p);
        double cut[2] = {p->a[0] + t * (p->b[0] - p->a[0]), p->a[1] + t * (p->b[1] - p->a[1])};
        out[0] = cut[0], out[1] = cut[1];
    }
}

static int compare_starts(const void *left, const void *right) {
    const piece *a = left, *b = right;
    return a->vertex[0] < b->vertex[0] ? -1 : a->vertex[0] > b->vertex[0];
}

/* Orders pieces by their starts, and equal starts by their ends, so that the order does not depend
 * on the implementation of qsort. */
static int compare_pieces(const void *left, const void *right) {
    const piece *a = left, *b = right;
    int starts = compare_starts(a, b);
    return starts ? starts : a->vertex[1] < b->vertex[1] ? -1 : a->vertex[1] > b->vertex[1];
}

/* Links each piece to one that begins where it ends. Several may, at a vertex that the surface
 * meets twice. Any of them will do, since fit_run tests the line along both. */
static void link_chain(clipper *c) {
    qsort(c->pieces, c->count, sizeof(piece), compare_pieces);
    for (size_t i = 0; i < c->count; ++i) c->pieces[i].previous = c->pieces[i].next = SIZE_MAX;
    for (size_t i = 0; i < c->count; ++i) {
        piece key = {.vertex = {c->pieces[i].vertex[1], 0}};
        piece *next = bsearch(&key, c->pieces, c->count, sizeof(piece), compare_starts);
        if (!next || next->previous != SIZE_MAX || next == &c->pieces[i]) continue;
        next->previous = i;
        c->pieces[i].next = (size_t)(next - c->pieces);
    }
}

static int choose_lines(clipper *c, psplat_region *region) {
    link_chain(c);
    region->line_count = region->chart_lines = 0;
    for (size_t i; (i = nearest_piece(c)) != SIZE_MAX;) {
        clip_line line;
        run r = {i, i};
        if (region->line_count == PSPLAT_MAX_CLIP_LINES || !grow_run(c, &r, &line)) return 0;
        if (is_chart_run(c, r)) region->chart_lines |= 1u << region->line_count;
        apply_line(c, &line);
        c->pieces[i].done = 1;
        const double stored[3] = {line.a, line.b, line.c};
        memcpy(region->lines[region->line_count], stored, sizeof stored);
        region->bends[region->line_count++] = line.bend;
    }
    return 1;
}

int psplat_clip_choose(psplat_region *region, const psplat_segment *segments, size_t count,
                       const double seed[2], double slack, int may_bend) {
    region->line_count = region->chart_lines = 0;
    memset(region->bends, 0, sizeof region->bends);
    if (!count) return 1;
    clipper c = {.pieces = malloc(count * sizeof(piece)),
                 .count = count,
                 .radius = {region->radius[0], region->radius[1]},
                 .seed = {seed[0], seed[1]},
                 .slack = slack,
                 .may_bend = may_bend};
    if (!c.pieces) return 0;
    for (size_t i = 0; i < count; ++i) {
        c.pieces[i] = (piece){.vertex = {segments[i].vertex[0], segments[i].vertex[1]}};
        c.pieces[i].is_chart = segments[i].is_chart;
        memcpy(c.pieces[i].a, segments[i].a, sizeof c.pieces[i].a);
        memcpy(c.pieces[i].b, segments[i].b, sizeof c.pieces[i].b);
    }
    int chosen = choose_lines(&c, region);
    free(c.pieces);
    if (!chosen) region->line_count = 0;
    return chosen;
}
