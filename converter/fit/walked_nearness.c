/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * walked_nearness.c - the check of the distance bound by a walk over the triangles under a region.
 *
 * Seen along the region's normal n, the walk goes from triangle to triangle over all edges that may
 * lie under the region, as long as triangles do not turn their backs. Edges that it cannot cross
 * are walls. Convex cells of the region in which no wall lies hold no border of the triangles
 * walked over, so that all of their points are seen equally often (the degree of a map is constant
 * where its border does not pass). No triangle is seen from behind, so that triangles lie under all
 * of such a cell if one lies under one point of it. Lines through walls divide the region into such
 * cells.
 *
 * Where a triangle lies under a cell of the region, the distance is at most the gap between surface
 * and plane along n. That is a quadratic polynomial, within the range of its coefficients in
 * Bernstein's basis over a triangle (Farin: Triangular Bernstein-Bezier Patches, 1986). What is
 * left are cells where these exceed the tolerance and cells without triangles; they are bounded by
 * branch and bound.
 */
#include "fit/walked_nearness.h"

#include "base/vector.h"
#include "measure/region_cell.h"
#include "measure/splat_distance.h"
#include "mesh/triangle_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most walls and steps after which the walk gives up, and the steps and the slots of places for
 * which no memory is allocated. Chosen by hand. */
enum { MOST_WALLS = 256, MOST_STEPS = 1 << 18, FIRST_STEPS = 64, FIRST_SLOTS = 256 };

/* The most cells that walls divide a region into before branch and bound takes the rest. Where
 * rounding leaves both sides of lines, cells double with each wall, without an end. Of machined
 * parts few regions have more than half as many. Chosen by hand. */
enum { MOST_CELLS = 512 };

/* The columns of u, from rim to rim, by which the triangles are listed that lie under points. */
enum { COLUMNS = 64 };

/* What lies beyond the rim or behind a wall by less, in units of the parameters, is rounding. */
static const double slack = 1e-12;

/* A triangle that is seen from behind by less than this part of its longest edge's square is seen
 * edge on, but for rounding. The first has to be seen from in front by more. */
static const double back_slack = 1e-13, front_least = 1e-6;

/* A vertex of the mesh in the region's parameters, how far the surface lies above it along n, and
 * whether it may lie under the region. */
typedef struct corner {
    double uv[2], gap;
    int is_under;
} corner;

/* A triangle that was walked over. */
typedef struct step {
    corner corners[3];
    double bound; /* of the distance over all of the triangle */
    uint32_t place;
    int entry; /* the edge that the walk came over; -1: none */
} step;

/* An edge that the walk could not cross, from a to b: the triangle before it lies on its left. */
typedef struct wall {
    double a[2], b[2];
} wall;

typedef struct walk {
    const psplat_region *region;
    const psplat_distance *distance;
    const psplat_triangle_tree *tree;
    double tolerance;
    double slope[2], hessian[3];            /* of the surface by (u, v) */
    double lines[PSPLAT_MAX_CLIP_LINES][3]; /* which keep more than the region's */
    step first_steps[FIRST_STEPS], *steps;
    size_t count, capacity;
    uint32_t first_slots[FIRST_SLOTS], *slots; /* a hash table of places, or PSPLAT_NONE */
    size_t slot_count;                         /* a power of two, over twice the steps */
    wall walls[MOST_WALLS];
    size_t wall_count, cell_count;
    uint32_t column_starts[COLUMNS + 1], *in_columns; /* indices of steps; NULL: not listed yet */
    uint32_t guess;      /* the place of the triangle that was found nearest last */
    int failed, is_lost; /* no memory; or the walk cannot tell */
} walk;

/* ---- places --------------------------------------------------------------------------------- */

static size_t slot_of(const walk *w, uint32_t place) {
    size_t at = (place * 2654435761u) & (w->slot_count - 1);
    while (w->slots[at] != PSPLAT_NONE && w->slots[at] != place)
        at = (at + 1) & (w->slot_count - 1);
    return at;
}

static int was_seen(const walk *w, uint32_t place) {
    return w->slots[slot_of(w, place)] != PSPLAT_NONE;
}

static void free_steps(walk *w) {
    if (w->steps != w->first_steps) free(w->steps);
    if (w->slots != w->first_slots) free(w->slots);
}

/* Doubles the room of steps and slots. */
static int grow(walk *w) {
    size_t capacity = 2 * w->capacity, slot_count = 2 * w->slot_count;
    step *steps = malloc(capacity * sizeof *steps);
    uint32_t *slots = malloc(slot_count * sizeof *slots);
    if (!steps || !slots) {
        free(steps);
        free(slots);
        w->failed = 1;
        return 0;
    }
    memcpy(steps, w->steps, w->count * sizeof *steps);
    memset(slots, 0xff, slot_count * sizeof *slots);
    free_steps(w);
    w->steps = steps, w->capacity = capacity;
    w->slots = slots, w->slot_count = slot_count;
    for (size_t i = 0; i < w->count; ++i) w->slots[slot_of(w, steps[i].place)] = steps[i].place;
    return 1;
}

/* ---- gaps ----------------------------------------------------------------------------------- */

static corner project(const walk *w, const double p[3]) {
    const psplat_region *r = w->region;
    const double *h = w->hessian;
    double d[3];
    sub3(d, p, r->center);
    double u = dot3(d, r->u) / r->radius[0], v = dot3(d, r->v) / r->radius[1];
    double height = (w->slope[0] + h[0] * u / 2 + h[1] * v) * u + (w->slope[1] + h[2] * v / 2) * v;
    int is_under = u * u + v * v <= 1;
    for (uint32_t i = 0; i < r->line_count && is_under; ++i)
        is_under = w->lines[i][0] * u + w->lines[i][1] * v + w->lines[i][2] >= 0;
    return (corner){{u, v}, height - dot3(d, r->n), is_under};
}

/* Returns the coefficient of the gap between two corners in Bernstein's basis. */
static double middle_gap(const walk *w, const corner *a, const corner *b) {
    double u = b->uv[0] - a->uv[0], v = b->uv[1] - a->uv[1];
    double bend = w->hessian[0] * u * u + 2 * w->hessian[1] * u * v + w->hessian[2] * v * v;
    return (a->gap + b->gap) / 2 - bend / 4;
}

/* Bounds the gap over a convex polygon, as over triangles around its first corner. */
static double gap_bound(const walk *w, const corner *corners, size_t count) {
    double most = 0;
    for (size_t i = 0; i < count; ++i) {
        most = max2(most, fabs(corners[i].gap));
        most = max2(most, fabs(middle_gap(w, &corners[i], &corners[(i + 1) % count])));
        if (i > 1 && i + 1 < count)
            most = max2(most, fabs(middle_gap(w, &corners[0], &corners[i])));
    }
    return most;
}

/* Returns twice the area of a triangle, negative where it is seen from behind, and stores the
 * square of its longest edge. */
static double area_of(const corner corners[3], double *longest2) {
    double e[3][2];
    *longest2 = 0;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 2; ++k) e[i][k] = corners[(i + 1) % 3].uv[k] - corners[i].uv[k];
        *longest2 = max2(*longest2, e[i][0] * e[i][0] + e[i][1] * e[i][1]);
    }
    return e[0][0] * e[1][1] - e[0][1] * e[1][0];
}

/* ---- the walk ------------------------------------------------------------------------------- */

/* Returns whether an edge may lie under the region: not beyond a line, nor outside of the disc. */
static int is_edge_under(const walk *w, const corner *from_corner, const corner *to_corner) {
    const double *a = from_corner->uv, *b = to_corner->uv;
    if (from_corner->is_under || to_corner->is_under) return 1;
    for (uint32_t i = 0; i < w->region->line_count; ++i) {
        const double *line = w->lines[i];
        double from = line[0] * a[0] + line[1] * a[1] + line[2];
        double to = line[0] * b[0] + line[1] * b[1] + line[2];
        if (max2(from, to) < -slack) return 0;
    }
    double way[2] = {b[0] - a[0], b[1] - a[1]}, length2 = way[0] * way[0] + way[1] * way[1];
    double along = -(a[0] * way[0] + a[1] * way[1]);
    double t = along <= 0 ? 0 : along >= length2 ? 1 : along / length2;
    double u = a[0] + t * way[0], v = a[1] + t * way[1];
    return u * u + v * v <= 1 + 2 * slack;
}

/* Puts up a wall at an edge. One that is seen as a point divides nothing. */
static void add_wall(walk *w, const step *from, int edge) {
    const double *a = from->corners[edge].uv, *b = from->corners[(edge + 1) % 3].uv;
    double u = b[0] - a[0], v = b[1] - a[1];
    if (!(u * u + v * v > slack * slack)) return;
    if (w->wall_count == MOST_WALLS) {
        w->is_lost = 1;
        return;
    }
    w->walls[w->wall_count++] = (wall){{a[0], a[1]}, {b[0], b[1]}};
}

static void add_step(walk *w, const step *s) {
    if (w->count == MOST_STEPS) w->is_lost = 1;
    if (w->is_lost || (w->count == w->capacity && !grow(w))) return;
    step *added = &w->steps[w->count++];
    *added = *s;
    added->bound = gap_bound(w, added->corners, 3);
    w->slots[slot_of(w, added->place)] = added->place;
}

/* Returns the corner of the triangle at a place that is not on an edge of another one. */
static int corner_across(const psplat_triangle_tree *tree, uint32_t place, const uint32_t edge[2]) {
    const uint32_t *corners = tree->corners + 3 * (size_t)place;
    for (int k = 0; k < 2; ++k)
        if (corners[k] != edge[0] && corners[k] != edge[1]) return k;
    return 2;
}

/* Steps over an edge of a triangle, or puts up a wall there. */
static void cross_edge(walk *w, const step *from, int edge) {
    const psplat_triangle_tree *tree = w->tree;
    const uint32_t *corners = tree->corners + 3 * (size_t)from->place;
    const uint32_t ends[2] = {corners[edge], corners[(edge + 1) % 3]};
    double longest2;
    step to = {.place = tree->neighbors[3 * (size_t)from->place + (size_t)edge]};
    if (to.place == PSPLAT_NONE) {
        add_wall(w, from, edge);
        return;
    }
    if (was_seen(w, to.place)) return;
    int new = corner_across(tree, to.place, ends);
    to.corners[new] = project(w, psplat_tree_corner(tree, to.place, new));
    to.corners[(new + 1) % 3] = from->corners[(edge + 1) % 3];
    to.corners[(new + 2) % 3] = from->corners[edge];
    to.entry = (new + 1) % 3;
    double area = area_of(to.corners, &longest2);
    if (area >= -back_slack * longest2)
        add_step(w, &to);
    else
        add_wall(w, from, edge);
}

/* Finds the triangle nearest to a point in the middle of the region. The walk is lost where that is
 * not seen from in front. */
static void find_start(walk *w, step *first) {
    const psplat_region *r = w->region;
    double polygon[PSPLAT_OUTLINE][2], middle[2] = {0, 0}, point[3], longest2;
    size_t count = 0;
    if (!psplat_region_contains(r, middle, 1, 0))
        count = psplat_region_polygon(r, 1, polygon, PSPLAT_OUTLINE);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    psplat_region_point(r, middle, point);
    psplat_tree_nearest nearest = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
    psplat_triangle_tree_nearest(w->tree, point, &nearest);
    w->is_lost = nearest.place == PSPLAT_NONE;
    if (w->is_lost) return;
    first->place = nearest.place;
    for (int i = 0; i < 3; ++i)
        first->corners[i] = project(w, psplat_tree_corner(w->tree, first->place, i));
    first->entry = -1;
    w->guess = first->place;
    double area = area_of(first->corners, &longest2);
    w->is_lost = !(area > front_least * longest2);
}

/* Prepares what a walk needs to know of the region. A line that bulges in keeps less than one moved
 * out by what the bulge is on the disc. */
static void begin_walk(walk *w) {
    const psplat_region *r = w->region;
    const double *radius = r->radius, *h = r->hessian;
    for (int k = 0; k < 2; ++k) w->slope[k] = r->slope[k] * radius[k];
    w->hessian[0] = h[0] * radius[0] * radius[0];
    w->hessian[1] = h[1] * radius[0] * radius[1];
    w->hessian[2] = h[2] * radius[1] * radius[1];
    for (uint32_t i = 0; i < r->line_count; ++i) {
        const double *line = r->lines[i];
        memcpy(w->lines[i], line, sizeof w->lines[i]);
        w->lines[i][2] += max2(r->bends[i], 0) * (line[0] * line[0] + line[1] * line[1]) / 2;
    }
    w->steps = w->first_steps, w->capacity = FIRST_STEPS;
    w->slots = w->first_slots, w->slot_count = FIRST_SLOTS;
    memset(w->slots, 0xff, sizeof w->first_slots);
}

static void walk_over(walk *w) {
    step first;
    begin_walk(w);
    find_start(w, &first);
    if (w->is_lost) return;
    add_step(w, &first);
    for (size_t i = 0; i < w->count && !w->is_lost && !w->failed; ++i) {
        const step from = w->steps[i]; /* Steps move where their room grows. */
        for (int edge = 0; edge < 3 && !w->is_lost && !w->failed; ++edge)
            if (edge != from.entry &&
                is_edge_under(w, &from.corners[edge], &from.corners[(edge + 1) % 3]))
                cross_edge(w, &from, edge);
    }
}

/* ---- the rest ------------------------------------------------------------------------------- */

/* Finds whether the region's part in a cell is near the mesh, by branch and bound. */
static int is_cell_near(walk *w, const psplat_cell *cell) {
    const psplat_splat_distance_desc desc = {.tolerance = w->tolerance, .stop_at_first = 1};
    psplat_splat_distance found;
    w->failed |= psplat_splat_distance_find_in(w->region, w->distance, &desc, cell, &w->guess,
                                               &found) != PSPLAT_OK;
    return !w->failed && found.nearness == PSPLAT_NEARNESS_WITHIN;
}

/* Stores the corners of a cell with their gaps to the plane of a triangle. */
static void lift_cell(const walk *w, const step *s, const psplat_cell *cell, corner *lifted) {
    double heights[3], longest2, area = area_of(s->corners, &longest2);
    for (int i = 0; i < 3; ++i)
        heights[i] = psplat_region_height(w->region, s->corners[i].uv) - s->corners[i].gap;
    for (size_t c = 0; c < cell->count; ++c) {
        const double *uv = cell->corners[c];
        double plane = 0;
        for (int i = 0; i < 3; ++i) {
            const double *a = s->corners[(i + 1) % 3].uv, *b = s->corners[(i + 2) % 3].uv;
            double weight = (a[0] - uv[0]) * (b[1] - uv[1]) - (a[1] - uv[1]) * (b[0] - uv[0]);
            plane += weight / area * heights[i];
        }
        memcpy(lifted[c].uv, uv, sizeof lifted[c].uv);
        lifted[c].gap = psplat_region_height(w->region, uv) - plane;
    }
}

/* Returns whether the region is near over a triangle of which the gap is too great somewhere, but
 * maybe not over the region. */
static int is_step_near(walk *w, const step *s) {
    psplat_cell cell;
    corner lifted[PSPLAT_CELL_CORNERS];
    double longest2, area = area_of(s->corners, &longest2);
    if (!(area > back_slack * longest2)) return 1; /* Nothing lies over it. */
    cell.count = 3;
    for (int i = 0; i < 3; ++i) memcpy(cell.corners[i], s->corners[i].uv, sizeof cell.corners[i]);
    psplat_cell_clip_by_rim(w->region, &cell);
    if (!cell.count) return 1;
    if (area > front_least * longest2) {
        lift_cell(w, s, &cell, lifted);
        if (gap_bound(w, lifted, cell.count) <= w->tolerance) return 1;
    }
    return is_cell_near(w, &cell);
}

/* ---- walls ---------------------------------------------------------------------------------- */

static int column_of(double u) {
    return (int)min2(max2((u + 1) * (COLUMNS / 2.0), 0), COLUMNS - 1);
}

/* Finds the first and the last column in which a triangle may lie. */
static void columns_of(const step *s, int *first, int *last) {
    const corner *c = s->corners;
    *first = column_of(min2(c[0].uv[0], min2(c[1].uv[0], c[2].uv[0])));
    *last = column_of(max2(c[0].uv[0], max2(c[1].uv[0], c[2].uv[0])));
}

/* Lists the triangles that were walked over by columns. */
static void list_columns(walk *w) {
    uint32_t ends[COLUMNS + 1] = {0};
    int first, last;
    for (size_t i = 0; i < w->count; ++i) {
        columns_of(&w->steps[i], &first, &last);
        for (int k = first; k <= last; ++k) ++ends[k + 1];
    }
    for (int k = 0; k < COLUMNS; ++k) ends[k + 1] += ends[k];
    memcpy(w->column_starts, ends, sizeof ends);
    w->in_columns = malloc((ends[COLUMNS] + 1) * sizeof *w->in_columns);
    w->failed |= !w->in_columns;
    for (size_t i = 0; i < w->count && w->in_columns; ++i) {
        columns_of(&w->steps[i], &first, &last);
        for (int k = first; k <= last; ++k) w->in_columns[ends[k]++] = (uint32_t)i;
    }
}

/* Returns whether a triangle that was walked over lies under a point that the region may hold. */
static int is_covered(walk *w, const double uv[2]) {
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1) return 0;
    for (uint32_t i = 0; i < w->region->line_count; ++i)
        if (w->lines[i][0] * uv[0] + w->lines[i][1] * uv[1] + w->lines[i][2] < 0) return 0;
    if (!w->in_columns) list_columns(w);
    if (w->failed) return 0;
    const uint32_t *at = w->column_starts + column_of(uv[0]);
    for (uint32_t i = at[0]; i < at[1]; ++i) {
        const corner *c = w->steps[w->in_columns[i]].corners;
        int inside = 1;
        for (int k = 0; k < 3 && inside; ++k) {
            const double *a = c[k].uv, *b = c[(k + 1) % 3].uv;
            inside = (b[0] - a[0]) * (uv[1] - a[1]) - (b[1] - a[1]) * (uv[0] - a[0]) > 0;
        }
        if (inside) return 1;
    }
    return 0;
}

/* Returns whether more than an end of a wall lies in a cell. */
static int is_wall_in(const psplat_cell *cell, const wall *wall) {
    return psplat_cell_holds_segment(cell, wall->a, wall->b, slack);
}

/* Walls that may lie in a cell, as indices. */
typedef struct wall_list {
    uint16_t walls[MOST_WALLS];
    size_t count;
} wall_list;

/* Returns whether the region is near in a cell: where no wall is, over triangles or by branch and
 * bound, and by that alone where there are too many cells; else on both sides of the line through
 * the last of the walls. */
static int are_sides_near(walk *w, const psplat_cell *cell, const wall_list *list) {
    if (++w->cell_count > MOST_CELLS) return is_cell_near(w, cell);
    if (!list->count) {
        double mean[2];
        psplat_cell_mean(cell, mean);
        return is_covered(w, mean) || is_cell_near(w, cell);
    }
    const wall *last = &w->walls[list->walls[list->count - 1]];
    double u = last->b[0] - last->a[0], v = last->b[1] - last->a[1];
    for (int sign = -1; sign < 2; sign += 2) {
        psplat_cell side = *cell;
        wall_list left;
        left.count = 0;
        psplat_cell_clip(&side, (const double[3]){-v * sign, u * sign,
                                                  (v * last->a[0] - u * last->a[1]) * sign});
        if (!side.count) continue;
        if (side.count + 2 + PSPLAT_MAX_CLIP_LINES >= PSPLAT_CELL_CORNERS) {
            /* Clipping would replace it by its box, which reaches back over walls. */
            if (!is_cell_near(w, &side)) return 0;
            continue;
        }
        psplat_cell_clip_by_rim(w->region, &side);
        if (!side.count) continue;
        for (size_t i = 0; i + 1 < list->count; ++i)
            if (is_wall_in(&side, &w->walls[list->walls[i]]))
                left.walls[left.count++] = list->walls[i];
        if (!are_sides_near(w, &side, &left)) return 0;
    }
    return 1;
}

static int are_walls_near(walk *w) {
    psplat_cell cell = psplat_cell_of_disc();
    wall_list list;
    list.count = 0;
    psplat_cell_clip_by_rim(w->region, &cell);
    for (size_t i = 0; i < w->wall_count && cell.count; ++i)
        if (is_wall_in(&cell, &w->walls[i])) list.walls[list.count++] = (uint16_t)i;
    return !cell.count || are_sides_near(w, &cell, &list);
}

/* ---- all ------------------------------------------------------------------------------------ */

/* Checks the triangle with the greatest bound first, which fails most often. */
static int is_walk_near(walk *w) {
    size_t worst = 0;
    for (size_t i = 0; i < w->count; ++i)
        if (w->steps[i].bound > w->steps[worst].bound) worst = i;
    if (w->steps[worst].bound > w->tolerance && !is_step_near(w, &w->steps[worst])) return 0;
    if (!are_walls_near(w)) return 0;
    for (size_t i = 0; i < w->count; ++i)
        if (i != worst && w->steps[i].bound > w->tolerance && !is_step_near(w, &w->steps[i]))
            return 0;
    return 1;
}

psplat_result psplat_walked_nearness(const psplat_region *region, const psplat_distance *distance,
                                     double tolerance, int *is_known, int *near) {
    walk w;
    w.region = region, w.distance = distance, w.tree = psplat_distance_tree(distance);
    w.tolerance = tolerance;
    w.count = w.wall_count = w.cell_count = 0;
    w.in_columns = NULL;
    w.failed = w.is_lost = 0;
    walk_over(&w);
    *is_known = !w.failed && !w.is_lost;
    *near = *is_known && is_walk_near(&w);
    free_steps(&w);
    free(w.in_columns);
    return w.failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
