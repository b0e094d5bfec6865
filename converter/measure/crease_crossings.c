/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_crossings.c - creases and borders that lie too deep inside splats of their own patch.
 *
 * A splat ends a little behind the creases of its patch, so no point of these may lie deeper inside
 * its outline than that. The depth of a point is its distance from the nearest side of the outline.
 * With straight clip lines that is a concave function: its maximum along an edge is that of a
 * linear program in one variable, which a ternary search finds. Bent lines are looked at by
 * themselves, since chords would cut off more of them than a tolerance, and then the maximum is
 * searched about the deepest of some places. Splats do not store their patch, so the samples that a
 * splat covers vote: the sheet around the splat, bounded by creases, to which most of them belong
 * is its own, as are others that have nearly as many votes where a caller wants that, and that
 * which it grew from, where that is known. The creases of other sheets that lie closer than the
 * tolerance are left out, be they of the same patch, as where cloth is folded.
 */
#include "measure/crease_crossings.h"

#include "base/polynomial.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "features/triangle_flood.h"
#include "measure/crease_spill.h"
#include "measure/measured_splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The capacity of an outline, the steps of the ternary search, each of which leaves 2/3 of the
 * range, and the places of an edge at which bent lines are looked at first. */
enum { MOST_CORNERS = 68, TERNARY_STEPS = 48, PLACES = 16 };

/* ---- what is looked at, and what is found ---------------------------------------------------- */

typedef struct crossing_list {
    psplat_crease_crossing *items;
    size_t count, capacity;
    int failed;
} crossing_list;

/* Returns whether a triangle has another material than a splat. Where parts of several lie closer
 * than the tolerance, a splat covers those of others, too, and shows none of them. */
static int is_foreign(const psplat_surface *surface, const psplat_measured_splats *measured,
                      uint32_t splat, uint32_t triangle) {
    const psplat_mesh *mesh = surface->mesh;
    return measured->materials && mesh->source_materials && mesh->groups &&
           mesh->groups[triangle] != measured->materials[splat];
}

/* One crease edge whose crossings are looked for. */
typedef struct edge_probe {
    const psplat_surface *surface;
    const psplat_measured_splats *measured;
    const double *a, *b, *normal;
    uint32_t edge;
    double limit;        /* deeper crossings are listed */
    double greatest;     /* depth found of those that are not */
    crossing_list *list; /* shared by all threads */
} edge_probe;

/* ---- the depth of an edge in a splat --------------------------------------------------------- */

/* The distances of a point on an edge from the sides of a convex outline, positive inside. Each is
 * a linear function a + b t of the place t = 0 ... 1 on the edge. */
typedef struct sides {
    double a[MOST_CORNERS], b[MOST_CORNERS];
    size_t count;
    const psplat_region *region; /* NULL where the outline says all: of a plane, lines straight */
    double from[2], to[2];       /* the edge in (u, v) */
    int is_curved;
    double ends[2][3], normal[3], tolerance; /* of the edge; of its triangle; of the measurement */
} sides;

/* Returns the distance of (u, v) from a bent line, up to the second order: its value over the
 * gradient of that. */
static double bent_distance(const psplat_region *region, uint32_t i, const double uv[2]) {
    const double *line = region->lines[i];
    double turn = region->bends[i] * (line[0] * uv[1] - line[1] * uv[0]);
    double u = (line[0] - turn * line[1]) / region->radius[0];
    double v = (line[1] + turn * line[0]) / region->radius[1];
    return psplat_region_line_value(region, i, uv) / hypot(u, v);
}

/* Returns whether a place of the edge lies within the tolerance of a curved surface that faces the
 * way of the edge's triangle there. The ranges of t are wider than that, since a surface may be
 * steep outside its ellipse. */
static int is_on_surface(const sides *s, double t) {
    double point[3], uvh[3], normal[3];
    for (int k = 0; k < 3; ++k) point[k] = s->ends[0][k] + t * (s->ends[1][k] - s->ends[0][k]);
    psplat_region_local(s->region, point, uvh);
    psplat_region_normal(s->region, uvh, normal);
    return fabs(uvh[2]) <= s->tolerance && dot3(s->normal, normal) > 0;
}

static double depth_at(const sides *s, double t) {
    double least = HUGE_VAL;
    if (s->is_curved && !is_on_surface(s, t)) return -HUGE_VAL;
    for (size_t i = 0; i < s->count; ++i) least = min2(least, s->a[i] + t * s->b[i]);
    if (!s->region) return least;
    const double uv[2] = {s->from[0] + t * (s->to[0] - s->from[0]),
                          s->from[1] + t * (s->to[1] - s->from[1])};
    for (uint32_t i = 0; i < s->region->line_count; ++i)
        if (s->region->bends[i] != 0) least = min2(least, bent_distance(s->region, i, uv));
    return least;
}

/* Clips a range of t to where a + b t >= 0. An empty range ends before it begins. */
static void clip_range(double range[2], double a, double b) {
    if (b > 0)
        range[0] = max2(range[0], -a / b);
    else if (b < 0)
        range[1] = min2(range[1], -a / b);
    else if (a < 0)
        range[1] = range[0] - 1;
}

/* Leaves out the bent clip lines. Returns whether there is one. */
static int leave_straight(psplat_region *region) {
    uint32_t kept = 0, count = region->line_count;
    for (uint32_t i = 0; i < count; ++i) {
        if (region->bends[i] != 0) continue;
        memmove(region->lines[kept], region->lines[i], sizeof region->lines[i]);
        region->bends[kept++] = region->bends[i];
    }
    region->line_count = kept;
    return kept < count;
}

static void find_sides(sides *s, const psplat_region *region, double from[3], double to[3]) {
    double polygon[MOST_CORNERS][2];
    psplat_region straight = *region;
    s->is_curved = psplat_region_is_curved(region);
    s->region = leave_straight(&straight) || s->is_curved ? region : NULL;
    for (int k = 0; k < 2; ++k) s->from[k] = from[k], s->to[k] = to[k];
    size_t corners = psplat_region_polygon(&straight, 1, polygon, MOST_CORNERS);
    double p[2] = {from[0] * region->radius[0], from[1] * region->radius[1]};
    double d[2] = {to[0] * region->radius[0] - p[0], to[1] * region->radius[1] - p[1]};
    s->count = 0;
    for (size_t i = 0; i < corners; ++i) {
        const double *c0 = polygon[i], *c1 = polygon[i + 1 < corners ? i + 1 : 0];
        double x = c0[0] * region->radius[0], y = c0[1] * region->radius[1];
        double side[2] = {c1[0] * region->radius[0] - x, c1[1] * region->radius[1] - y};
        double length = hypot(side[0], side[1]);
        if (!(length > 0)) continue;
        s->a[s->count] = (side[0] * (p[1] - y) - side[1] * (p[0] - x)) / length;
        s->b[s->count++] = (side[0] * d[1] - side[1] * d[0]) / length;
    }
}

/* Returns the greatest depth over a range of t, found by ternary search, and stores where it is. */
static double greatest_depth(const sides *s, const double range[2], double *at) {
    double low = range[0], high = range[1];
    for (int i = 0; i < TERNARY_STEPS; ++i) {
        double t0 = low + (high - low) / 3, t1 = high - (high - low) / 3;
        if (depth_at(s, t0) < depth_at(s, t1))
            low = t0;
        else
            high = t1;
    }
    *at = 0.5 * (low + high);
    return depth_at(s, *at);
}

/* Does the same where the depth is not concave: about the deepest of some places. */
static double deepest_part(const sides *s, const double range[2], double *at) {
    double step = (range[1] - range[0]) / PLACES, deepest = -HUGE_VAL, place = range[0];
    for (int i = 0; i <= PLACES; ++i) {
        double depth = depth_at(s, range[0] + i * step);
        if (depth > deepest) deepest = depth, place = range[0] + i * step;
    }
    const double about[2] = {max2(range[0], place - step), min2(range[1], place + step)};
    double found = greatest_depth(s, about, at);
    if (found >= deepest) return found;
    *at = place;
    return deepest;
}

/* Returns an upper bound of the depth of an edge (its ends as u, v, height) that is quick to find:
 * the smaller radius, and the distance of the farther end from each clip line that is straight, or
 * that bulges out and so lies within its straight one. */
static double depth_bound(const psplat_region *region, const double from[3], const double to[3]) {
    double least = region->radius[1];
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        if (region->bends[i] > 0) continue;
        double inside =
            max2(line[0] * from[0] + line[1] * from[1], line[0] * to[0] + line[1] * to[1]) +
            line[2];
        least =
            min2(least, inside / hypot(line[0] / region->radius[0], line[1] / region->radius[1]));
    }
    return least;
}

/* Finds the parts of an edge, whose ends are from and to in the region, that are within tolerance
 * of its surface: at most three ranges of t. For a plane that is one range. The height over a
 * curved surface is quadratic in t; the distance is less than the height by the cosine of a slope,
 * of which the greatest on the way is taken. Returns the number of ranges. */
static size_t near_ranges(const psplat_region *region, const double from[3], const double to[3],
                          double tolerance, double ranges[5][2]) {
    double slope[2], other[2], height[3], ends[6] = {0}, roots[2];
    size_t count = 1, result = 0;
    if (!psplat_region_is_curved(region)) {
        ranges[0][0] = 0, ranges[0][1] = 1;
        clip_range(ranges[0], tolerance - from[2], from[2] - to[2]);
        clip_range(ranges[0], tolerance + from[2], to[2] - from[2]);
        return ranges[0][0] <= ranges[0][1];
    }
    psplat_region_slope(region, from, slope);
    psplat_region_slope(region, to, other);
    double stretch = hypot(1, max2(hypot(slope[0], slope[1]), hypot(other[0], other[1])));
    height[0] = from[2] * hypot(1, hypot(slope[0], slope[1]));
    height[1] = to[2] * hypot(1, hypot(other[0], other[1])) - height[0];
    height[2] = 0;
    for (int k = 0; k < 2; ++k)
        height[2] -= (other[k] - slope[k]) * (to[k] - from[k]) * region->radius[k] / 2;
    height[1] -= height[2];
    for (int side = -1; side < 2; side += 2) {
        const double over[3] = {height[0] + side * tolerance * stretch, height[1], height[2]};
        size_t found = psplat_polynomial_roots(over, 2, 0, 1, roots);
        for (size_t k = 0; k < found; ++k) ends[count++] = roots[k];
    }
    ends[count] = 1;
    for (size_t i = 2; i < count; ++i)
        for (size_t k = i; k > 1 && ends[k] < ends[k - 1]; --k) {
            double swap = ends[k];
            ends[k] = ends[k - 1], ends[k - 1] = swap;
        }
    for (size_t i = 0; i < count; ++i) {
        double middle = 0.5 * (ends[i] + ends[i + 1]);
        if (fabs(psplat_polynomial_at(height, 2, middle)) > tolerance * stretch) continue;
        ranges[result][0] = ends[i], ranges[result++][1] = ends[i + 1];
    }
    return result;
}

/* Returns the greatest depth in a region of the part of an edge that is within tolerance of its
 * surface, and stores where it is. Returns 0 or less where the edge stays outside. Where the depth
 * is at most known_depth, the result may be any number up to that, and point may be left unset. */
static double edge_depth(const psplat_region *region, const edge_probe *p, double known_depth,
                         double point[3]) {
    const double *a = p->a, *b = p->b, tolerance = p->measured->tolerance;
    double from[3], to[3], ranges[5][2], deepest = 0, at;
    sides s = {.tolerance = tolerance};
    memcpy(s.ends[0], a, sizeof s.ends[0]);
    memcpy(s.ends[1], b, sizeof s.ends[1]);
    memcpy(s.normal, p->normal, sizeof s.normal);
    psplat_region_local(region, a, from);
    psplat_region_local(region, b, to);
    if (depth_bound(region, from, to) <= known_depth) return 0;
    size_t count = near_ranges(region, from, to, tolerance, ranges);
    find_sides(&s, region, from, to);
    for (size_t r = 0; r < count && s.count; ++r) {
        double *range = ranges[r];
        for (size_t i = 0; i < s.count && range[0] <= range[1]; ++i)
            clip_range(range, s.a[i], s.b[i]);
        if (!(range[0] <= range[1])) continue;
        double depth = s.region ? deepest_part(&s, range, &at) : greatest_depth(&s, range, &at);
        if (r && depth <= deepest) continue;
        deepest = depth;
        for (int k = 0; k < 3; ++k) point[k] = a[k] + at * (b[k] - a[k]);
    }
    return deepest;
}

/* ---- all edges ------------------------------------------------------------------------------ */

static void push_crossing(crossing_list *list, const psplat_crease_crossing *crossing) {
    if (list->count == list->capacity) {
        size_t capacity = 2 * list->capacity + 64;
        psplat_crease_crossing *items = realloc(list->items, capacity * sizeof *items);
        if (!items) {
            list->failed = 1;
            return;
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *crossing;
}

static int visit_region(void *user, uint32_t index) {
    edge_probe *p = user;
    const psplat_region *region = &p->measured->regions[index];
    if (is_foreign(p->surface, p->measured, index, p->edge / 3)) return 0;
    /* A curved one may face another way at each place of the edge. */
    if (!psplat_region_is_curved(region) && dot3(p->normal, region->n) <= 0) return 0;
    psplat_crease_crossing found = {.edge = p->edge, .splat = index};
    found.depth = edge_depth(region, p, min2(p->greatest, p->limit), found.point);
    if (found.depth <= p->limit) {
        p->greatest = max2(p->greatest, found.depth);
        return 0;
    }
#if defined(_OPENMP)
#pragma omp critical(psplat_crossing_push)
#endif
    push_crossing(p->list, &found);
    return 0;
}

static double probe_edge(const psplat_surface *surface, const psplat_measured_splats *measured,
                         uint32_t edge, double limit, double greatest, crossing_list *list) {
    const uint32_t *corners = surface->mesh->triangles + (size_t)(edge / 3) * 3;
    const double *a = surface->mesh->positions + 3 * (size_t)corners[edge % 3];
    const double *b = surface->mesh->positions + 3 * (size_t)corners[(edge % 3 + 1) % 3];
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) low[k] = min2(a[k], b[k]), high[k] = max2(a[k], b[k]);
    edge_probe p = {surface, measured, a,   b, surface->face_normals + (size_t)(edge / 3) * 3, edge,
                    limit,   greatest, list};
    psplat_region_tree_visit_box(measured->region_tree, low, high, visit_region, &p);
    return p.greatest;
}

static int compare_crossings(const void *left, const void *right) {
    const psplat_crease_crossing *a = left, *b = right;
    if (a->splat != b->splat) return a->splat < b->splat ? -1 : 1;
    return a->edge < b->edge ? -1 : a->edge > b->edge;
}

static double probe_all(const psplat_surface *surface, const psplat_measured_splats *measured,
                        double limit, crossing_list *list) {
    long edges = 3 * (long)surface->mesh->triangle_count;
    double greatest = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 4096) reduction(max : greatest)
#endif
    for (long e = 0; e < edges; ++e)
        if (surface->creases[e] & PSPLAT_BOUND_CREASE)
            greatest = probe_edge(surface, measured, (uint32_t)e, limit, greatest, list);
    if (list->count) qsort(list->items, list->count, sizeof *list->items, compare_crossings);
    return greatest;
}

/* ---- majority votes on the sheets of splats -------------------------------------------------- */

/* A sample that a splat covers, by its triangle. */
typedef struct vote {
    uint32_t splat, triangle;
} vote;

typedef struct vote_list {
    vote *items;
    size_t count, capacity;
    int failed;
} vote_list;

/* One sample, which votes on the splats of its material that cover it. */
typedef struct voter {
    const psplat_surface *surface;
    const psplat_measured_splats *measured;
    const uint8_t *crosses; /* of each splat: 1 where it has crossings */
    vote_list *list;        /* shared by all threads */
    const double *point;
    double normal[3];
    uint32_t triangle;
} voter;

static void push_vote(vote_list *list, const vote *item) {
    if (list->count == list->capacity) {
        size_t capacity = 2 * list->capacity + 64;
        vote *items = realloc(list->items, capacity * sizeof *items);
        if (!items) {
            list->failed = 1;
            return;
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *item;
}

static int visit_vote(void *user, uint32_t index) {
    voter *v = user;
    const vote item = {index, v->triangle};
    double uvh[3];
    if (!v->crosses[index] || is_foreign(v->surface, v->measured, index, v->triangle)) return 0;
    psplat_region_local(&v->measured->regions[index], v->point, uvh);
    if (!psplat_measured_splats_cover(v->measured, index, v->normal, uvh)) return 0;
#if defined(_OPENMP)
#pragma omp critical(psplat_vote_push)
#endif
    push_vote(v->list, &item);
    return 0;
}

static int compare_votes(const void *left, const void *right) {
    const vote *a = left, *b = right;
    if (a->splat != b->splat) return a->splat < b->splat ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

/* Finds the votes on the splats that have crossings, in an order that does not depend on threads.
 */
static psplat_result find_votes(const psplat_surface *surface, const psplat_samples *samples,
                                const psplat_measured_splats *measured,
                                const crossing_list *crossings, vote_list *votes) {
    uint8_t *crosses = calloc(measured->count + 1, 1);
    if (!crosses) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < crossings->count; ++i) crosses[crossings->items[i].splat] = 1;
    long end = (long)samples->count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(static)
#endif
    for (long i = 0; i < end; ++i) {
        voter v = {.surface = surface, .measured = measured, .crosses = crosses, .list = votes};
        v.point = samples->positions + 3 * i;
        for (int k = 0; k < 3; ++k) v.normal[k] = (double)samples->normals[3 * i + k];
        v.triangle = samples->triangles[i];
        psplat_region_tree_visit(measured->region_tree, v.point, visit_vote, &v);
    }
    if (votes->count) qsort(votes->items, votes->count, sizeof *votes->items, compare_votes);
    free(crosses);
    return votes->failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* The sheets that the votes on one splat are of, each by its first triangle. The sheet of a
 * triangle is what is connected with it over edges that are no creases, no farther from the splat's
 * centre than the splat reaches. */
typedef struct sheet_search {
    const psplat_surface *surface;
    const psplat_measured_splats *measured;
    double least_share; /* of psplat_crease_crossings_find */
    vote_list votes;    /* on all splats */
    uint32_t *starts;   /* sheet_count */
    size_t *sizes;      /* the votes of each, sheet_count */
    size_t sheet_count, capacity, largest;
    psplat_triangle_flood near; /* the sheet that was flooded last */
} sheet_search;

static void free_sheets(sheet_search *s) {
    free(s->votes.items);
    free(s->starts);
    free(s->sizes);
    psplat_triangle_flood_free(&s->near);
}

/* Returns 0 when out of memory. */
static int push_sheet(sheet_search *s, uint32_t start, size_t size) {
    if (s->sheet_count == s->capacity) {
        size_t capacity = 2 * s->capacity + 16;
        uint32_t *starts = realloc(s->starts, capacity * sizeof *starts);
        if (starts) s->starts = starts;
        size_t *sizes = realloc(s->sizes, capacity * sizeof *sizes);
        if (sizes) s->sizes = sizes;
        if (!starts || !sizes) return 0;
        s->capacity = capacity;
    }
    if (!s->sheet_count || size > s->sizes[s->largest]) s->largest = s->sheet_count;
    s->starts[s->sheet_count] = start;
    s->sizes[s->sheet_count++] = size;
    return 1;
}

/* Returns 0 when out of memory. */
static int flood_sheet(sheet_search *s, uint32_t splat, uint32_t start) {
    return psplat_triangle_flood_around(&s->near, s->surface, &s->measured->regions[splat],
                                        s->measured->tolerance, start);
}

/* Finds the sheets of the votes from `first` to before `end`, which are all on a splat, and the
 * largest, the first one of equals. Votes become PSPLAT_NONE when they were counted. Returns 0 when
 * out of memory. */
static int find_sheets(sheet_search *s, uint32_t splat, size_t first, size_t end) {
    vote *votes = s->votes.items;
    s->sheet_count = s->largest = 0;
    for (size_t i = first; i < end; ++i) {
        uint32_t start = votes[i].triangle;
        size_t size = 0;
        if (start == PSPLAT_NONE) continue;
        if (!flood_sheet(s, splat, start)) return 0;
        for (size_t k = i; k < end; ++k) {
            if (votes[k].triangle == PSPLAT_NONE ||
                !psplat_triangle_flood_met(&s->near, votes[k].triangle))
                continue;
            votes[k].triangle = PSPLAT_NONE;
            ++size;
        }
        if (!push_sheet(s, start, size)) return 0;
    }
    return 1;
}

/* Moves those of count crossings of one splat whose creases bound the sheet of a triangle behind
 * the first `own`, and counts them, too. Returns 0 when out of memory. */
static int put_own_first(sheet_search *s, uint32_t triangle, psplat_crease_crossing *crossings,
                         size_t count, size_t *own) {
    if (!flood_sheet(s, crossings->splat, triangle)) return 0;
    for (size_t k = *own; k < count; ++k) {
        if (!psplat_triangle_flood_met(&s->near, crossings[k].edge / 3)) continue;
        const psplat_crease_crossing found = crossings[k];
        crossings[k] = crossings[*own];
        crossings[(*own)++] = found;
    }
    return 1;
}

/* Does that for all sheets of a splat's own. Returns 0 when out of memory. */
static int sort_own_first(sheet_search *s, psplat_crease_crossing *crossings, size_t count,
                          size_t *own) {
    const uint32_t *grown = s->measured->triangles;
    double most = (double)s->sizes[s->largest], least = s->least_share * most;
    if (s->least_share < 1) least -= sqrt(most); /* of other samples there may be as many more */
    *own = least < 0 ? count : 0;
    for (size_t i = 0; i < s->sheet_count && *own < count; ++i) {
        if (i != s->largest && (double)s->sizes[i] <= least) continue;
        if (!put_own_first(s, s->starts[i], crossings, count, own)) return 0;
    }
    return !grown || *own == count ||
           put_own_first(s, grown[crossings->splat], crossings, count, own);
}

/* Drops the crossings of sheets other than a splat's own. Of one without votes all are kept. */
static psplat_result drop_foreign_crossings(const psplat_samples *samples, sheet_search *s,
                                            crossing_list *list) {
    psplat_result result = find_votes(s->surface, samples, s->measured, list, &s->votes);
    size_t kept = 0, vote = 0;
    for (size_t i = 0, end; i < list->count && !result; i = end) {
        uint32_t splat = list->items[i].splat;
        for (end = i; end < list->count && list->items[end].splat == splat;) ++end;
        while (vote < s->votes.count && s->votes.items[vote].splat < splat) ++vote;
        size_t first = vote, own = end - i;
        while (vote < s->votes.count && s->votes.items[vote].splat == splat) ++vote;
        if (vote > first && !(find_sheets(s, splat, first, vote) &&
                              sort_own_first(s, list->items + i, end - i, &own)))
            result = PSPLAT_ERROR_MEMORY;
        memmove(list->items + kept, list->items + i, own * sizeof *list->items);
        kept += own;
    }
    list->count = kept;
    if (kept) qsort(list->items, kept, sizeof *list->items, compare_crossings);
    return result;
}

psplat_result psplat_crease_crossings_find(const psplat_surface *surface,
                                           const psplat_samples *samples,
                                           const psplat_measured_splats *measured, double limit,
                                           double least_share, psplat_crease_crossing **crossings,
                                           size_t *count, double *greatest) {
    sheet_search sheets = {.surface = surface, .measured = measured, .least_share = least_share};
    crossing_list list = {0};
    *greatest = probe_all(surface, measured, limit, &list);
    psplat_result result = list.failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
    if (!result && list.count) result = drop_foreign_crossings(samples, &sheets, &list);
    free_sheets(&sheets);
    if (!result) result = psplat_drop_unseen_crossings(surface, measured, list.items, &list.count);
    for (size_t i = 0; i < list.count; ++i) *greatest = max2(*greatest, list.items[i].depth);
    *crossings = list.items;
    *count = list.count;
    if (!result) return PSPLAT_OK;
    free(list.items);
    *crossings = NULL;
    return result;
}
