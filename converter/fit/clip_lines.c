/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clip_lines.c - the fit of clip lines that keep a splat on its side of the creases around it.
 *
 * A convex region free of creases is found around the seed as in IRIS (Deits, Tedrake 2014): the
 * crease that is nearest in the ellipse's metric gives a line, all creases behind that line are
 * done, and the next nearest one gives the next line. A line is fitted to a chain of crease edges,
 * straight or curved, as far as all of them stay within the slack. It touches the chain from
 * outside, so that a convex chain loses no surface.
 */
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
} piece;

/* The state of one choice of lines. */
typedef struct clipper {
    piece *pieces;
    size_t count;
    double radius[2]; /* lengths of u and v */
    double seed[2];   /* (u, v) */
    double slack;     /* a length */
} clipper;

/* A line that keeps the points p with normal . p >= offset, in lengths. */
typedef struct half_plane {
    double normal[2], offset;
} half_plane;

static double along(const clipper *c, const half_plane *line, const double uv[2]) {
    return line->normal[0] * uv[0] * c->radius[0] + line->normal[1] * uv[1] * c->radius[1];
}

static double seed_distance(const clipper *c, const piece *p) {
    double d[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]};
    double s[2] = {c->seed[0] - p->a[0], c->seed[1] - p->a[1]};
    double length = d[0] * d[0] + d[1] * d[1];
    double t = length > 0 ? (s[0] * d[0] + s[1] * d[1]) / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return hypot(s[0] - t * d[0], s[1] - t * d[1]);
}

/* Finds the line from a to b that keeps its left side. Returns 0 for coincident points. */
static int line_through(const clipper *c, const double a[2], const double b[2], half_plane *line) {
    double d[2] = {(b[0] - a[0]) * c->radius[0], (b[1] - a[1]) * c->radius[1]};
    double length = hypot(d[0], d[1]);
    if (!(length > 1e-9 * c->radius[0])) return 0;
    line->normal[0] = -d[1] / length;
    line->normal[1] = d[0] / length;
    line->offset = along(c, line, a);
    return 1;
}

/* Returns the piece nearest to the seed, or SIZE_MAX. Among equally near ones it is the one whose
 * line has the seed farthest to its left: at a reflex corner both edges are equally near, but the
 * line of one may cut the seed off. */
static size_t nearest_piece(const clipper *c) {
    size_t best = SIZE_MAX;
    double best_distance = HUGE_VAL, best_left = -HUGE_VAL;
    for (size_t i = 0; i < c->count; ++i) {
        half_plane line;
        if (c->pieces[i].done || !line_through(c, c->pieces[i].a, c->pieces[i].b, &line)) continue;
        double distance = seed_distance(c, &c->pieces[i]);
        double left = along(c, &line, c->seed) - line.offset;
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

/* Fits a line to a run: that of its chord, moved out until it touches the run. Returns 0 where the
 * run bends by more than the slack, or where the line would cut off the seed. */
static int fit_run(const clipper *c, run r, half_plane *line) {
    if (!line_through(c, c->pieces[r.first].a, c->pieces[r.last].b, line)) return 0;
    double least = HUGE_VAL, greatest = -HUGE_VAL;
    for (size_t i = r.first;; i = c->pieces[i].next) {
        const piece *p = &c->pieces[i];
        double a = along(c, line, p->a), b = along(c, line, p->b);
        least = fmin(least, fmin(a, b));
        greatest = fmax(greatest, fmax(a, b));
        if (i == r.last) break;
    }
    line->offset = least;
    return greatest - least <= c->slack && along(c, line, c->seed) >= least - 1e-9 * c->radius[0];
}

/* Extends a run of one piece at both ends while one line still fits it, and stores that line.
 * Returns 0 where not even the piece alone has one. */
static int grow_run(const clipper *c, size_t start, half_plane *line) {
    run r = {start, start};
    if (!fit_run(c, r, line)) return 0;
    for (int grown = 1; grown;) {
        grown = 0;
        for (int end = 0; end < 2; ++end) {
            run longer = r;
            size_t next = end ? c->pieces[r.last].next : c->pieces[r.first].previous;
            if (next == SIZE_MAX || next == r.first || next == r.last) continue;
            if (c->pieces[next].done) continue;
            if (end)
                longer.last = next;
            else
                longer.first = next;
            half_plane candidate;
            if (!fit_run(c, longer, &candidate)) continue;
            r = longer, *line = candidate, grown = 1;
        }
    }
    return 1;
}

/* Marks the pieces that a line cuts away as done, and shortens those that it crosses. */
static void apply_line(clipper *c, const half_plane *line) {
    for (size_t i = 0; i < c->count; ++i) {
        piece *p = &c->pieces[i];
        double a = along(c, line, p->a) - line->offset, b = along(c, line, p->b) - line->offset;
        if (fmax(a, b) <= c->slack * (1 + 1e-9)) p->done = 1;
        if (p->done || (a >= 0 && b >= 0)) continue;
        double *out = a < 0 ? p->a : p->b, t = a / (a - b);
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

static void store_line(const clipper *c, const half_plane *line, double out[3]) {
    double a = line->normal[0] * c->radius[0], b = line->normal[1] * c->radius[1];
    double length = hypot(a, b);
    out[0] = a / length, out[1] = b / length, out[2] = -line->offset / length;
}

static int choose_lines(clipper *c, psplat_region *region) {
    link_chain(c);
    region->line_count = 0;
    for (size_t i; (i = nearest_piece(c)) != SIZE_MAX;) {
        half_plane line;
        if (region->line_count == PSPLAT_MAX_CLIP_LINES || !grow_run(c, i, &line)) return 0;
        apply_line(c, &line);
        c->pieces[i].done = 1;
        store_line(c, &line, region->lines[region->line_count++]);
    }
    return 1;
}

int psplat_clip_choose(psplat_region *region, const psplat_segment *segments, size_t count,
                       const double seed[2], double slack) {
    region->line_count = 0;
    if (!count) return 1;
    clipper c = {.pieces = malloc(count * sizeof(piece)),
                 .count = count,
                 .radius = {region->radius[0], region->radius[1]},
                 .seed = {seed[0], seed[1]},
                 .slack = slack};
    if (!c.pieces) return 0;
    for (size_t i = 0; i < count; ++i) {
        c.pieces[i] = (piece){.vertex = {segments[i].vertex[0], segments[i].vertex[1]}};
        memcpy(c.pieces[i].a, segments[i].a, sizeof c.pieces[i].a);
        memcpy(c.pieces[i].b, segments[i].b, sizeof c.pieces[i].b);
    }
    int chosen = choose_lines(&c, region);
    free(c.pieces);
    if (!chosen) region->line_count = 0;
    return chosen;
}
