/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_distance.c - the greatest distance from all points of a splat to a mesh, by branch and
 * bound.
 *
 * The region's parameters are divided into cells, convex polygons that together hold all of it. The
 * distance to one triangle is a convex function. So over a flat polygon it is greatest at a corner,
 * and the greatest distance of the corners to any one triangle bounds that of the whole polygon to
 * the mesh (Guthe, Borodin, Klein: Fast and Accurate Hausdorff Distance Calculation between Meshes,
 * 2005). A curved surface stays between two polygons parallel to its tangent plane, since its
 * second derivatives are constant. Cells for which no triangle gives a bound small enough are
 * halved. Those at the rim are cut by tangents and chords, so that they exceed the region by the
 * second order of their size only.
 */
#include "measure/splat_distance.h"

#include "base/region.h"
#include "base/vector.h"
#include "measure/region_cell.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "mesh/triangle_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The cells after which the search gives up. Chosen by hand: most splats take less than 2000. */
enum { DEFAULT_MOST_CELLS = 100000 };

/* The most triangles that are gathered for a cell. Those with more near them are halved: a splat
 * over a million triangles that are nearly flat needs few of them. Chosen by hand. */
enum { MOST_GATHERED = 256 };

/* The size below which cells are not halved, in tolerances, and how much the bound may exceed the
 * greatest distance found where that is beyond the tolerance. Chosen by hand. */
static const double least_size_tolerances = 1.0 / 512, found_slack = 1.01;

/* How far outside of the region, in units of the parameters, its corners may be by the rounding of
 * tangents and chords to them. */
static const double tip_slack = 1e-8;

/* A cell in space: all of the surface over it lies within `bow` of the polygon with these corners.
 */
typedef struct patch {
    double corners[PSPLAT_CELL_CORNERS][3];
    size_t count;
    double bow;
    double middle[3];    /* the surface's point over the mean of the corners */
    double middle_uv[2]; /* its parameters */
    double radius;       /* no point of the patch is farther from the middle */
    double size[2];      /* lengths along u and v */
} patch;

/* A triangle and a sphere around it. Its planes are found when they are first needed: `up` is the
 * unit normal, and sides are the unit normals of its sides within its plane, outwards. */
typedef struct triangle {
    double corners[9], middle[3], radius;
    double up[3], sides[3][3];
    int has_planes; /* 1: they are found; -1: it is too flat to have any */
} triangle;

/* The triangles that may be near a cell are a range of indices of `near`. Those of a cell follow
 * those of the cell that it is a part of. */
typedef struct searcher {
    const psplat_region *region;
    const psplat_distance *distance;
    const psplat_splat_distance_desc *desc;
    psplat_splat_distance *result;
    triangle *triangles; /* that may be near the region */
    triangle asked;      /* the one that was found last in the whole mesh */
    uint32_t guess;      /* for psplat_distance_nearest_corners */
    size_t triangle_count, triangle_capacity;
    uint32_t *near;
    size_t near_count, near_capacity;
    double accepted;  /* cells with at most this bound are not halved */
    int are_too_many; /* triangles, when they were gathered last */
    int failed, done;
} searcher;

/* ---- patches -------------------------------------------------------------------------------- */

/* Adds the least and the greatest value of factor s t / 2 for |s| <= a, |t| <= b; where is_square,
 * of factor s^2 / 2. */
static void add_range(double factor, double a, double b, int is_square, double range[2]) {
    double most = fabs(factor) * a * b / 2;
    if (!is_square || factor > 0) range[1] += most;
    if (!is_square || factor < 0) range[0] -= most;
}

/* Finds the polygon in space and its bow: over the cell's box the surface leaves the tangent plane
 * of the box's middle by its second derivatives alone. */
static void lift(const psplat_region *r, const psplat_cell *c, patch *p) {
    double low[2], high[2], middle[2], slope[2], range[2] = {0, 0};
    psplat_cell_box(c, low, high);
    for (int k = 0; k < 2; ++k) middle[k] = (low[k] + high[k]) / 2;
    double a = (high[0] - low[0]) / 2 * r->radius[0], b = (high[1] - low[1]) / 2 * r->radius[1];
    psplat_region_slope(r, middle, slope);
    add_range(r->hessian[0], a, a, 1, range);
    add_range(r->hessian[2], b, b, 1, range);
    add_range(2 * r->hessian[1], a, b, 0, range);
    double height = psplat_region_height(r, middle) + (range[0] + range[1]) / 2;
    p->bow = (range[1] - range[0]) / 2;
    p->count = c->count;
    p->size[0] = 2 * a * sqrt(1 + slope[0] * slope[0]);
    p->size[1] = 2 * b * sqrt(1 + slope[1] * slope[1]);
    psplat_cell_mean(c, p->middle_uv);
    psplat_region_point(r, p->middle_uv, p->middle);
    p->radius = 0;
    for (size_t i = 0; i < c->count; ++i) {
        const double *uv = c->corners[i];
        double s = uv[0] * r->radius[0], t = uv[1] * r->radius[1], *corner = p->corners[i];
        memcpy(corner, r->center, sizeof p->corners[i]);
        mad3(corner, s, r->u);
        mad3(corner, t, r->v);
        mad3(corner,
             height + slope[0] * (s - middle[0] * r->radius[0]) +
                 slope[1] * (t - middle[1] * r->radius[1]),
             r->n);
        p->radius = max2(p->radius, distance2_3(corner, p->middle));
    }
    p->radius = sqrt(p->radius) + p->bow;
}

/* ---- triangles ------------------------------------------------------------------------------ */

static void set_triangle(triangle *t, const double corners[9]) {
    memcpy(t->corners, corners, sizeof t->corners);
    double radius2 = 0;
    for (int k = 0; k < 3; ++k) t->middle[k] = (corners[k] + corners[3 + k] + corners[6 + k]) / 3;
    for (int i = 0; i < 3; ++i) radius2 = max2(radius2, distance2_3(t->middle, corners + 3 * i));
    t->radius = sqrt(radius2);
    t->has_planes = 0;
}

static void find_planes(triangle *t) {
    double edges[3][3];
    for (int i = 0; i < 3; ++i) sub3(edges[i], t->corners + 3 * ((i + 1) % 3), t->corners + 3 * i);
    cross3(t->up, edges[0], edges[1]);
    t->has_planes = normalize3(t->up) > 0 ? 1 : -1;
    for (int i = 0; i < 3; ++i) {
        cross3(t->sides[i], edges[i], t->up);
        if (!(normalize3(t->sides[i]) > 0)) t->has_planes = -1;
    }
}

/* Returns the squared distance of a point to a triangle, or where it is greater than `most`, some
 * number greater than that. From outside of some sides' half-planes, the nearest point lies on one
 * of these sides. */
static double triangle_distance2(const double p[3], triangle *t, double most) {
    if (!t->has_planes) find_planes(t);
    if (t->has_planes < 0)
        return point_triangle_distance2(p, t->corners, t->corners + 3, t->corners + 6);
    double d[3], outside[3], beyond = 0, nearest = HUGE_VAL;
    for (int i = 0; i < 3; ++i) {
        sub3(d, p, t->corners + 3 * i);
        outside[i] = dot3(d, t->sides[i]);
        beyond = max2(beyond, outside[i]);
    }
    double height = dot3(d, t->up), least = height * height + beyond * beyond;
    if (beyond == 0 || least > most) return least;
    for (int i = 0; i < 3; ++i)
        if (outside[i] > 0)
            nearest = min2(nearest, point_segment_distance2(p, t->corners + 3 * i,
                                                            t->corners + 3 * ((i + 1) % 3)));
    return nearest;
}

/* Returns a bound of the distance from all of a patch to a triangle. One that is greater than
 * `most` is not the least. */
static double patch_bound(const patch *p, triangle *t, double most) {
    double greatest = 0, left = max2(most - p->bow, 0), enough = left * left;
    for (size_t i = 0; i < p->count && greatest <= enough; ++i)
        greatest = max2(greatest, triangle_distance2(p->corners[i], t, enough));
    return sqrt(greatest) + p->bow;
}

/* ---- the search ----------------------------------------------------------------------------- */

/* Takes a point of the region, which is this far from the mesh. */
static void take_found(searcher *s, const double point[3], double distance) {
    psplat_splat_distance *r = s->result;
    if (distance <= r->found) return;
    r->found = distance;
    memcpy(r->point, point, sizeof r->point);
    if (!(distance > s->desc->tolerance)) return;
    s->accepted = max2(s->accepted, found_slack * distance);
    if (s->desc->stop_at_first) s->done = 1;
}

/* Finds the triangle of the mesh that is nearest to a point, into s->asked. Returns its distance.
 */
static double find_nearest(searcher *s, const double point[3]) {
    double at[3], corners[9];
    s->failed |=
        psplat_distance_nearest_corners(s->distance, point, &s->guess, at, corners) != PSPLAT_OK;
    if (s->failed) return 0;
    set_triangle(&s->asked, corners);
    return sqrt(distance2_3(at, point));
}

static int reserve_near(searcher *s, size_t more) {
    if (s->near_count + more <= s->near_capacity) return 1;
    size_t capacity = 2 * (s->near_count + more) + 256;
    uint32_t *grown = realloc(s->near, capacity * sizeof *grown);
    s->failed |= !grown;
    if (!grown) return 0;
    s->near = grown;
    s->near_capacity = capacity;
    return 1;
}

/* Pushes those of the triangles near[begin ... end) that may be near enough to some point of a
 * patch. Finds the nearest to its middle, NULL where none is near. Returns that one's distance. */
static double push_near(searcher *s, const patch *p, size_t begin, size_t end, triangle **nearest) {
    double most = s->accepted + p->radius, least = most;
    *nearest = NULL;
    if (!reserve_near(s, end - begin)) return HUGE_VAL;
    for (size_t i = begin; i < end; ++i) {
        triangle *t = &s->triangles[s->near[i]];
        double d2 = distance2_3(p->middle, t->middle), reach = most + t->radius;
        if (d2 > reach * reach) continue;
        s->near[s->near_count++] = s->near[i];
        if (d2 > (least + t->radius) * (least + t->radius)) continue;
        double exact = triangle_distance2(p->middle, t, least * least);
        if (exact > least * least) continue;
        least = sqrt(exact);
        *nearest = t;
    }
    return *nearest ? least : HUGE_VAL;
}

/* Measures the middle of a patch and finds the triangle nearest to that. Returns the bound that it
 * gives, or that which the middle's distance gives, since distances change no more than a point
 * moves. The lists hold all triangles within the tolerance of some point; beyond that the whole
 * mesh is asked. */
static double refine_bound(searcher *s, const patch *p, size_t begin, size_t end,
                           triangle **nearest) {
    double distance = push_near(s, p, begin, end, nearest);
    if (s->failed) return HUGE_VAL;
    if (distance > s->desc->tolerance) {
        distance = find_nearest(s, p->middle);
        *nearest = &s->asked;
    }
    if (psplat_region_contains(s->region, p->middle_uv, 1, 0)) take_found(s, p->middle, distance);
    return min2(patch_bound(p, *nearest, HUGE_VAL), distance + p->radius);
}

/* Measures the corners of a patch that is not halved any more. At sharp corners of the region its
 * middle may be outside. */
static void measure_tips(searcher *s, const psplat_cell *c) {
    double point[3];
    for (size_t i = 0; i < c->count && !s->failed; ++i) {
        if (!psplat_region_contains(s->region, c->corners[i], 1 + tip_slack, tip_slack)) continue;
        psplat_region_point(s->region, c->corners[i], point);
        take_found(s, point, find_nearest(s, point));
    }
}

static int is_exhausted(const searcher *s, const patch *p) {
    size_t most = s->desc->most_cells ? s->desc->most_cells : DEFAULT_MOST_CELLS;
    return s->result->cells > most ||
           max2(p->size[0], p->size[1]) < least_size_tolerances * s->desc->tolerance;
}

static void search(searcher *s, psplat_cell *c, size_t begin, triangle *guess);

/* Returns a half of a cell, cut across its longer side. */
static psplat_cell half_of(const psplat_cell *c, const patch *p, int side) {
    double low[2], high[2], line[3] = {0, 0, 0};
    int axis = p->size[1] > p->size[0];
    psplat_cell half = *c;
    psplat_cell_box(c, low, high);
    line[axis] = side;
    line[2] = -side * (low[axis] + high[axis]) / 2;
    psplat_cell_clip(&half, line);
    return half;
}

/* Searches both halves of a cell. */
static void search_halves(searcher *s, const psplat_cell *c, const patch *p, size_t begin,
                          triangle *guess) {
    for (int side = -1; side < 2 && !s->done && !s->failed; side += 2) {
        psplat_cell half = half_of(c, p, side);
        if (half.count) search(s, &half, begin, guess);
    }
}

/* Bounds the distances of a cell, given that near[begin ... near_count) are the triangles near the
 * cell that it is a part of, and one that is likely to be near. */
static void search(searcher *s, psplat_cell *c, size_t begin, triangle *guess) {
    patch p;
    triangle *nearest;
    size_t end = s->near_count;
    psplat_cell_clip_by_rim(s->region, c);
    if (!c->count) return;
    ++s->result->cells;
    lift(s->region, c, &p);
    double bound = patch_bound(&p, guess, s->accepted);
    if (bound > s->accepted) {
        bound = refine_bound(s, &p, begin, end, &nearest);
        if (!s->failed && !s->done && bound > s->accepted) {
            if (is_exhausted(s, &p)) {
                measure_tips(s, c);
            } else {
                search_halves(s, c, &p, end, nearest);
                bound = 0; /* The halves have bounds of their own. */
            }
        }
    }
    s->result->bound = max2(s->result->bound, bound);
    s->near_count = end;
}

/* ---- a region ------------------------------------------------------------------------------- */

static int push_triangle(void *user, const double corners[9]) {
    searcher *s = user;
    if (s->triangle_count == MOST_GATHERED) {
        s->are_too_many = 1;
        return 1;
    }
    if (s->triangle_count == s->triangle_capacity) {
        size_t capacity = 2 * s->triangle_capacity + 64;
        triangle *grown = realloc(s->triangles, capacity * sizeof *grown);
        s->failed |= !grown;
        if (!grown) return 1;
        s->triangles = grown;
        s->triangle_capacity = capacity;
    }
    set_triangle(&s->triangles[s->triangle_count++], corners);
    return 0;
}

/* Gathers the triangles within the tolerance of a patch. Returns 0 where they are too many. */
static int gather(searcher *s, const patch *p) {
    double low[3], high[3], reach = p->bow + s->desc->tolerance;
    for (int k = 0; k < 3; ++k) low[k] = HUGE_VAL, high[k] = -HUGE_VAL;
    for (size_t i = 0; i < p->count; ++i)
        for (int k = 0; k < 3; ++k) {
            low[k] = min2(low[k], p->corners[i][k] - reach);
            high[k] = max2(high[k], p->corners[i][k] + reach);
        }
    s->triangle_count = s->near_count = 0;
    s->are_too_many = 0;
    s->failed |= psplat_distance_visit_box(s->distance, low, high, push_triangle, s) != PSPLAT_OK;
    if (s->failed || s->are_too_many || !reserve_near(s, s->triangle_count)) return 0;
    for (uint32_t i = 0; i < s->triangle_count; ++i) s->near[s->near_count++] = i;
    return 1;
}

static void search_large(searcher *s, psplat_cell *c, const triangle *guess);

static void halve_large(searcher *s, const psplat_cell *c, const patch *p, const triangle *guess) {
    for (int side = -1; side < 2; side += 2) {
        psplat_cell half = half_of(c, p, side);
        if (half.count) search_large(s, &half, guess);
    }
}

/* Searches a cell, given a triangle that is likely near. All of most cells is near the triangle
 * that is nearest to their middle; only where that does not tell are triangles gathered, and where
 * these are too many, the cell is halved. */
static void search_large(searcher *s, psplat_cell *c, const triangle *guess) {
    patch p;
    triangle near = *guess;
    psplat_cell_clip_by_rim(s->region, c);
    if (!c->count || s->failed || s->done) return;
    lift(s->region, c, &p);
    double bound = patch_bound(&p, &near, s->accepted);
    if (bound > s->accepted) {
        double distance = find_nearest(s, p.middle);
        if (psplat_region_contains(s->region, p.middle_uv, 1, 0)) take_found(s, p.middle, distance);
        near = s->asked;
        bound = min2(patch_bound(&p, &near, HUGE_VAL), distance + p.radius);
        if (bound > s->accepted && !s->failed && !s->done && gather(s, &p)) {
            search(s, c, 0, &near);
            return;
        }
    }
    ++s->result->cells;
    if (bound > s->accepted && !s->failed && !s->done) {
        if (is_exhausted(s, &p)) {
            measure_tips(s, c);
        } else {
            halve_large(s, c, &p, &near);
            bound = 0; /* The halves have bounds of their own. */
        }
    }
    s->result->bound = max2(s->result->bound, bound);
}

/* Measures the corners of the region, where the greatest distances are likely. */
static void measure_corners(searcher *s) {
    double corners[PSPLAT_OUTLINE][2], point[3];
    size_t count = psplat_region_polygon(s->region, 1, corners, PSPLAT_OUTLINE);
    for (size_t i = 0; i < count && !s->failed && !s->done; ++i) {
        psplat_region_point(s->region, corners[i], point);
        take_found(s, point, find_nearest(s, point));
    }
}

static void search_region(searcher *s) {
    psplat_cell c = psplat_cell_of_disc();
    patch p;
    psplat_cell_clip_by_rim(s->region, &c);
    if (!c.count) return;
    lift(s->region, &c, &p);
    measure_corners(s);
    if (s->failed || s->done) return;
    find_nearest(s, p.middle);
    const triangle guess = s->asked;
    if (!s->failed) search_large(s, &c, &guess);
}

/* Bounds the distances of a cell alone, of which most are near the triangle that is guessed. */
static void search_cell(searcher *s, psplat_cell *c) {
    const psplat_triangle_tree *tree = psplat_distance_tree(s->distance);
    double corners[9];
    triangle near;
    for (int k = 0; k < 3; ++k)
        memcpy(corners + 3 * k, psplat_tree_corner(tree, s->guess, k), 3 * sizeof *corners);
    set_triangle(&near, corners);
    search_large(s, c, &near);
}

static psplat_result finish(searcher *s) {
    psplat_splat_distance *result = s->result;
    free(s->triangles);
    free(s->near);
    result->bound = max2(result->bound, result->found);
    if (result->found > s->desc->tolerance)
        result->nearness = PSPLAT_NEARNESS_EXCEEDS;
    else if (result->bound <= s->desc->tolerance)
        result->nearness = PSPLAT_NEARNESS_WITHIN;
    return s->failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

static searcher begin(const psplat_region *region, const psplat_distance *distance,
                      const psplat_splat_distance_desc *desc, psplat_splat_distance *result) {
    *result = (psplat_splat_distance){.nearness = PSPLAT_NEARNESS_UNDECIDED};
    return (searcher){.region = region,
                      .distance = distance,
                      .desc = desc,
                      .result = result,
                      .guess = PSPLAT_NONE,
                      .accepted = desc->tolerance};
}

psplat_result psplat_splat_distance_find(const psplat_region *region,
                                         const psplat_distance *distance,
                                         const psplat_splat_distance_desc *desc,
                                         psplat_splat_distance *result) {
    searcher s = begin(region, distance, desc, result);
    search_region(&s);
    return finish(&s);
}

psplat_result psplat_splat_distance_find_in(const psplat_region *region,
                                            const psplat_distance *distance,
                                            const psplat_splat_distance_desc *desc,
                                            const psplat_cell *cell, uint32_t *guess,
                                            psplat_splat_distance *result) {
    searcher s = begin(region, distance, desc, result);
    psplat_cell c = *cell;
    s.guess = *guess;
    search_cell(&s, &c);
    *guess = s.guess;
    return finish(&s);
}
