/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * holes.c - an exhaustive search for points of the surface that no stored splat covers.
 *
 * The set of points that a flat splat covers is convex where its clip lines are straight: a region
 * of its plane, extended by the tolerance above and below. So a splat that covers the three corners
 * of a triangle covers all of it. Of a curved one and of bent lines it is bounded how far they go
 * astray between the corners. A
 * triangle that no single splat covers is halved until the middle of a part is found open, or the
 * part is too small to matter. The search draws no random points: a hole that it misses is smaller
 * than its resolution.
 */
#include "measure/holes.h"

#include "base/random.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/surface.h"
#include "measure/measured_splats.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* A part of a triangle: its corners, and the normals at them. */
typedef struct subtriangle {
    double p[3][3], n[3][3];
} subtriangle;

/* What is known of a triangle or point in place of the splat that covers it: it has no hole, or
 * may have. */
static const uint32_t several = 0xfffffffeu, open_part = 0xffffffffu;

/* The splats that covered the last triangles, which are tried first, since triangles follow each
 * other over the surface. */
enum { LIKELY = 4 };

/* The state of the search in one thread. */
typedef struct searcher {
    const psplat_surface *surface;
    const psplat_measured_splats *measured;
    uint32_t likely[LIKELY];
    int likely_count;
    uint32_t cover; /* what is known of the last triangle or point */
    double coarse;  /* middles are tested of parts whose longest side is at most this */
    double fine;    /* parts whose longest side is at most this are not halved */
    psplat_holes *holes;
    uint32_t triangle;
    uint32_t *near; /* a stack: splats near a part follow those near the part it was halved from */
    size_t near_count, near_capacity;
    int failed;
} searcher;

static void push_near(searcher *s, uint32_t splat) {
    if (s->near_count == s->near_capacity) {
        size_t capacity = 2 * s->near_capacity + 256;
        uint32_t *near = realloc(s->near, capacity * sizeof *near);
        if (!near) {
            s->failed = 1;
            return;
        }
        s->near = near;
        s->near_capacity = capacity;
    }
    s->near[s->near_count++] = splat;
}

static void push_hole(searcher *s, const double point[3]) {
    psplat_holes *h = s->holes;
    if (h->count == h->capacity) {
        size_t capacity = 2 * h->capacity + 64;
        double *points = realloc(h->points, capacity * 3 * sizeof *points);
        if (points) h->points = points;
        uint32_t *triangles = realloc(h->triangles, capacity * sizeof *triangles);
        if (triangles) h->triangles = triangles;
        if (!points || !triangles) {
            s->failed = 1;
            return;
        }
        h->capacity = capacity;
    }
    memcpy(h->points + 3 * h->count, point, 3 * sizeof *point);
    h->triangles[h->count++] = s->triangle;
}

/* A part in a splat's region: u, v and height at its corners, and what happens between them. For a
 * flat splat heights are linear there, and the slopes are 0. */
typedef struct local_part {
    double uvh[3][3];
    double slopes[3][2]; /* of the splat's surface at the corners */
    double bow;          /* how far heights leave those interpolated from the corners: a length */
    double least_stretch, most_stretch; /* of lengths on the surface over those in the plane */
} local_part;

/* Returns the length of a vector in a plane. Nothing here is large enough to overflow. */
static double length2(double x, double y) {
    return sqrt(x * x + y * y);
}

/* The height over the surface, along the normal of the plane, at (l0, l1, l2) in barycentric
 * coordinates differs from the one interpolated by the sum of l_i l_j times half of the second
 * derivative along each side. The sum of l_i l_j is at most 1/3. Slopes are linear in between. */
static void bound_between(const psplat_region *region, local_part *part) {
    double mean[2] = {0, 0}, spread = 0, most = 0;
    for (int i = 0; i < 3; ++i) psplat_region_slope(region, part->uvh[i], part->slopes[i]);
    for (int i = 0; i < 3; ++i) {
        const double *from = part->slopes[i], *to = part->slopes[(i + 1) % 3];
        double second = 0;
        for (int k = 0; k < 2; ++k) {
            second += (to[k] - from[k]) * (part->uvh[(i + 1) % 3][k] - part->uvh[i][k]) *
                      region->radius[k];
            mean[k] += from[k] / 3;
        }
        most = max2(most, fabs(second));
    }
    for (int i = 0; i < 3; ++i)
        spread = max2(spread, length2(part->slopes[i][0] - mean[0], part->slopes[i][1] - mean[1]));
    double slope = length2(mean[0], mean[1]);
    part->bow = most / 6;
    part->least_stretch = length2(1, max2(slope - spread, 0));
    part->most_stretch = length2(1, slope + spread);
}

/* Returns the height of a corner along the normal of the plane. */
static double plane_height(const local_part *part, int corner) {
    const double *slope = part->slopes[corner];
    return part->uvh[corner][2] * sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

/* Returns how far the values of a bent clip line leave those interpolated from the corners. Between
 * corners they are less where it bulges in, and more where it bulges out. */
static double line_bow(const psplat_region *region, uint32_t i, const local_part *part) {
    const double *line = region->lines[i];
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        double along = line[0] * part->uvh[k][1] - line[1] * part->uvh[k][0];
        low = min2(low, along);
        high = max2(high, along);
    }
    return fabs(region->bends[i]) * (high - low) * (high - low) / 8;
}

/* Returns whether a splat that covers the corners of a part surely covers what lies between. */
static int covers_between(const searcher *s, const psplat_region *region, const subtriangle *t,
                          const local_part *part) {
    for (uint32_t i = 0; i < region->line_count; ++i)
        for (int k = 0; k < 3 && region->bends[i] > 0; ++k)
            if (psplat_region_line_value(region, i, part->uvh[k]) < line_bow(region, i, part))
                return 0;
    if (part->bow == 0 && part->most_stretch == 1) return 1;
    double normals[3][3];
    for (int i = 0; i < 3; ++i) {
        if (fabs(plane_height(part, i)) + part->bow > s->measured->tolerance * part->least_stretch)
            return 0;
        memcpy(normals[i], region->n, sizeof normals[i]);
        mad3(normals[i], -part->slopes[i][0], region->u);
        mad3(normals[i], -part->slopes[i][1], region->v);
    }
    /* Both normals are linear in between: their product is a sum of these with positive factors. */
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
            if (!(dot3(t->n[i], normals[j]) + dot3(t->n[j], normals[i]) > 0)) return 0;
    return 1;
}

/* Returns whether all of a part lies beyond one side of what the splat covers. */
static int is_outside_splat(const psplat_region *region, double tolerance, const local_part *part) {
    double middle[2], spread = 0, most = tolerance * part->most_stretch + part->bow;
    int above = 1, below = 1;
    for (int k = 0; k < 2; ++k)
        middle[k] = (part->uvh[0][k] + part->uvh[1][k] + part->uvh[2][k]) / 3;
    for (int i = 0; i < 3; ++i) {
        double height = plane_height(part, i);
        above &= height > most, below &= height < -most;
        spread = max2(spread, length2(part->uvh[i][0] - middle[0], part->uvh[i][1] - middle[1]));
    }
    if (above || below || length2(middle[0], middle[1]) > 1 + spread + 1e-5) return 1;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double slack = region->bends[i] < 0 ? line_bow(region, i, part) + 1e-5 : 1e-5;
        int outside = 1;
        for (int k = 0; k < 3; ++k)
            outside &= psplat_region_line_value(region, i, part->uvh[k]) < -slack;
        if (outside) return 1;
    }
    return 0;
}

/* Stores a part in a splat's region. Returns whether the splat covers all of it. */
static int covers(const searcher *s, uint32_t splat, const subtriangle *t, local_part *part) {
    const psplat_region *region = &s->measured->regions[splat];
    int covered = 1;
    *part = (local_part){.least_stretch = 1, .most_stretch = 1};
    for (int k = 0; k < 3; ++k) {
        psplat_region_local(region, t->p[k], part->uvh[k]);
        covered =
            covered && psplat_measured_splats_cover(s->measured, splat, t->n[k], part->uvh[k]);
    }
    if (psplat_region_is_curved(region)) bound_between(region, part);
    return covered && covers_between(s, region, t, part);
}

/* Pushes those of the splats near[begin ... end) that may cover some of the part. Returns 1 where
 * one of them covers all of it, which is then s->cover. */
static int find_near(searcher *s, const subtriangle *t, size_t begin, size_t end) {
    for (size_t i = begin; i < end && !s->failed; ++i) {
        uint32_t splat = s->near[i];
        local_part part;
        s->cover = splat;
        if (covers(s, splat, t, &part)) return 1;
        if (!is_outside_splat(&s->measured->regions[splat], s->measured->tolerance, &part))
            push_near(s, splat);
    }
    return 0;
}

static int is_open(const searcher *s, const double p[3], const double n[3], size_t begin) {
    for (size_t i = begin; i < s->near_count; ++i) {
        double uvh[3];
        psplat_region_local(&s->measured->regions[s->near[i]], p, uvh);
        if (psplat_measured_splats_cover(s->measured, s->near[i], n, uvh)) return 0;
    }
    return 1;
}

static void midpoint(double out[3], const double a[3], const double b[3]) {
    for (int k = 0; k < 3; ++k) out[k] = 0.5 * (a[k] + b[k]);
}

/* Halves a part at the middle of its longest side. Returns that side's length. */
static double halve(const subtriangle *t, subtriangle halves[2]) {
    double longest = -1;
    int from = 0;
    for (int k = 0; k < 3; ++k) {
        double d[3];
        sub3(d, t->p[(k + 1) % 3], t->p[k]);
        if (length3(d) > longest) longest = length3(d), from = k;
    }
    int to = (from + 1) % 3;
    halves[0] = halves[1] = *t;
    midpoint(halves[0].p[to], t->p[from], t->p[to]);
    midpoint(halves[0].n[to], t->n[from], t->n[to]);
    memcpy(halves[1].p[from], halves[0].p[to], sizeof halves[0].p[to]);
    memcpy(halves[1].n[from], halves[0].n[to], sizeof halves[0].n[to]);
    return longest;
}

static double area_of(const subtriangle *t) {
    double a[3], b[3], n[3];
    sub3(a, t->p[1], t->p[0]);
    sub3(b, t->p[2], t->p[0]);
    cross3(n, a, b);
    return length3(n) / 2;
}

static void box_of(const subtriangle *t, double low[3], double high[3]) {
    for (int k = 0; k < 3; ++k) {
        low[k] = min2(t->p[0][k], min2(t->p[1][k], t->p[2][k]));
        high[k] = max2(t->p[0][k], max2(t->p[1][k], t->p[2][k]));
    }
}

/* Returns whether all of a part surely belongs to the apron of a surface. */
static int is_apron(const psplat_surface *surface, const subtriangle *t) {
    double low[3], high[3];
    if (!surface->owned) return 0;
    box_of(t, low, high);
    for (int k = 0; k < 3; ++k)
        if (high[k] < surface->owned[k] || low[k] > surface->owned[k + 3]) return 1;
    return 0;
}

static int search_part(searcher *s, const subtriangle *t, size_t begin);

/* Finds the holes of a part that no single splat covers, given that near[begin ... near_count) are
 * the splats near it. One hole is enough in a part no larger than coarse. Returns whether there is
 * one. */
static int search_halves(searcher *s, const subtriangle *t, size_t begin) {
    subtriangle halves[2];
    double side = halve(t, halves), p[3], n[3];
    for (int k = 0; k < 3; ++k) {
        p[k] = (t->p[0][k] + t->p[1][k] + t->p[2][k]) / 3;
        n[k] = (t->n[0][k] + t->n[1][k] + t->n[2][k]) / 3;
    }
    /* As samples have it; no splat faces the way of no normal. */
    if (!(length3(n) > PSPLAT_LEAST_NORMAL))
        memcpy(n, s->surface->face_normals + 3 * (size_t)s->triangle, sizeof n);
    int found = side <= s->coarse && psplat_surface_owns(s->surface, p) && is_open(s, p, n, begin);
    if (found) push_hole(s, p);
    if (!found && !(side > s->fine)) s->holes->unproven += area_of(t);
    for (int k = 0; k < 2 && side > s->fine && !s->failed; ++k)
        if (!found || side > s->coarse) found |= search_part(s, &halves[k], begin);
    return found;
}

/* Finds the holes of a part, given that near[begin ... near_count) are the splats near the part it
 * was halved from. Returns whether there is one. */
static int search_part(searcher *s, const subtriangle *t, size_t begin) {
    size_t end = s->near_count;
    if (is_apron(s->surface, t)) return 0;
    int found = !find_near(s, t, begin, end) && search_halves(s, t, end);
    s->near_count = end;
    return found;
}

static int visit_near(void *user, uint32_t splat) {
    searcher *s = user;
    push_near(s, splat);
    return s->failed;
}

/* Moves a splat to the front of the likely ones. */
static void put_first(searcher *s, uint32_t splat) {
    int at = 0;
    while (at < s->likely_count && s->likely[at] != splat) ++at;
    if (at == s->likely_count && at < LIKELY) ++s->likely_count;
    if (at == LIKELY) --at;
    memmove(s->likely + 1, s->likely, (size_t)at * sizeof *s->likely);
    s->likely[0] = splat;
}

/* Returns whether one of the likely splats covers all of a part, which is then the first. */
static int is_covered_by_likely(searcher *s, const subtriangle *t) {
    for (int k = 0; k < s->likely_count; ++k) {
        double uvh[3];
        local_part part;
        psplat_region_local(&s->measured->regions[s->likely[k]], t->p[0], uvh);
        if (!psplat_measured_splats_cover(s->measured, s->likely[k], t->n[0], uvh) ||
            !covers(s, s->likely[k], t, &part))
            continue;
        put_first(s, s->likely[k]);
        return 1;
    }
    return 0;
}

static void search_root(searcher *s, const subtriangle *t) {
    double low[3], high[3];
    if (is_covered_by_likely(s, t)) {
        s->cover = s->likely[0];
        return;
    }
    box_of(t, low, high);
    s->near_count = 0;
    psplat_region_tree_visit_box(s->measured->region_tree, low, high, visit_near, s);
    size_t end = s->near_count;
    if (find_near(s, t, 0, end))
        put_first(s, s->cover);
    else
        s->cover = search_halves(s, t, end) ? open_part : several;
}

/* Makes a part of a triangle, or of a point of a point set, which has no extent. Returns the
 * triangle. */
static uint32_t part_of(const psplat_surface *surface, size_t item, subtriangle *t) {
    const psplat_mesh *mesh = surface->mesh;
    if (item >= mesh->triangle_count) {
        size_t point = item - mesh->triangle_count;
        uint32_t triangle = mesh->point_triangles[point];
        for (int k = 0; k < 3; ++k) {
            memcpy(t->p[k], mesh->points + 3 * point, sizeof t->p[k]);
            memcpy(t->n[k], surface->face_normals + 3 * (size_t)triangle, sizeof t->n[k]);
        }
        return triangle;
    }
    const float *normals = surface->corner_normals + 9 * item;
    for (uint32_t k = 0; k < 3; ++k) {
        size_t vertex = mesh->triangles[3 * item + k];
        memcpy(t->p[k], mesh->positions + 3 * vertex, sizeof t->p[k]);
        for (uint32_t i = 0; i < 3; ++i) t->n[k][i] = (double)normals[3 * k + i];
    }
    return (uint32_t)item;
}

void psplat_holes_free(psplat_holes *holes) {
    free(holes->points);
    free(holes->triangles);
    *holes = (psplat_holes){0};
}

/* Appends the holes of a block. Returns 0 when out of memory. */
static int append_holes(psplat_holes *holes, const psplat_holes *block) {
    size_t count = holes->count + block->count;
    holes->unproven += block->unproven;
    if (!block->count) return 1;
    double *points = realloc(holes->points, count * 3 * sizeof *points);
    if (points) holes->points = points;
    uint32_t *triangles = realloc(holes->triangles, count * sizeof *triangles);
    if (triangles) holes->triangles = triangles;
    if (!points || !triangles) return 0;
    memcpy(points + 3 * holes->count, block->points, block->count * 3 * sizeof *points);
    memcpy(triangles + holes->count, block->triangles, block->count * sizeof *triangles);
    holes->count = holes->capacity = count;
    return 1;
}

/* A hole and the cube of a regular grid that it lies in. */
typedef struct hole_cube {
    double cell[3];
    size_t index;
} hole_cube;

static int compare_hole_cubes(const void *left, const void *right) {
    const hole_cube *a = left, *b = right;
    for (int k = 0; k < 3; ++k)
        if (a->cell[k] != b->cell[k]) return a->cell[k] < b->cell[k] ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Keeps the first hole in each cube of this side, since each of many small triangles may have one.
 * Returns 0 when out of memory. */
static int keep_one_per_cube(psplat_holes *holes, double side) {
    size_t count = holes->count, kept = 0;
    hole_cube *list = malloc((count + 1) * sizeof *list);
    uint8_t *first = calloc(count + 1, 1);
    for (size_t i = 0; list && i < count; ++i) {
        for (size_t k = 0; k < 3; ++k) list[i].cell[k] = floor(holes->points[3 * i + k] / side);
        list[i].index = i;
    }
    if (list && first) qsort(list, count, sizeof *list, compare_hole_cubes);
    for (size_t i = 0; list && first && i < count; ++i)
        first[list[i].index] =
            !i || memcmp(list[i].cell, list[i - 1].cell, sizeof list[i].cell) != 0;
    for (size_t i = 0; list && first && i < count; ++i) {
        if (!first[i]) continue;
        memmove(holes->points + 3 * kept, holes->points + 3 * i, 3 * sizeof *holes->points);
        holes->triangles[kept++] = holes->triangles[i];
    }
    int ok = list && first;
    if (ok) holes->count = kept;
    free(list);
    free(first);
    return ok;
}

/* ---- what the last search knew --------------------------------------------------------------- */

/* What a search knows of the last one. */
typedef struct changes {
    psplat_hole_memory *memory;  /* NULL: nothing is remembered */
    uint32_t *now;               /* the index of each region of the last search, or open_part */
    psplat_region_tree *changed; /* of the regions that are no longer there */
} changes;

static int is_same_region(const psplat_region *a, const psplat_region *b) {
    return a->line_count == b->line_count &&
           !memcmp(a, b, offsetof(psplat_region, lines)) && /* its frame and radii */
           !memcmp(a->lines, b->lines, a->line_count * sizeof *a->lines) &&
           !memcmp(a->bends, b->bends, a->line_count * sizeof *a->bends) &&
           !memcmp(a->slope, b->slope, sizeof a->slope) &&
           !memcmp(a->hessian, b->hessian, sizeof a->hessian);
}

static uint64_t place_hash(const psplat_region *region) {
    uint64_t hash = 0, bits;
    for (int k = 0; k < 3; ++k) {
        memcpy(&bits, &region->center[k], sizeof bits);
        hash ^= bits;
        hash = psplat_random_next(&hash);
    }
    return hash;
}

/* Finds the regions of the last search again. Returns 0 when out of memory. */
static int find_again(changes *c, const psplat_region *regions, size_t count) {
    const psplat_hole_memory *memory = c->memory;
    size_t room = 1;
    while (room < 2 * count + 2) room *= 2;
    uint32_t *table = malloc(room * sizeof *table);
    if (!table) return 0;
    memset(table, 0xff, room * sizeof *table);
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)place_hash(&regions[i]) & (room - 1);
        while (table[at] != open_part) at = (at + 1) & (room - 1);
        table[at] = i;
    }
    for (size_t i = 0; i < memory->region_count; ++i) {
        size_t at = (size_t)place_hash(&memory->regions[i]) & (room - 1);
        while (table[at] != open_part && !is_same_region(&regions[table[at]], &memory->regions[i]))
            at = (at + 1) & (room - 1);
        c->now[i] = table[at];
    }
    free(table);
    return 1;
}

static void changes_free(changes *c) {
    free(c->now);
    psplat_region_tree_destroy(c->changed);
}

/* Prepares the memory of items for a search of these regions. Returns 0 when out of memory. */
static int changes_begin(changes *c, psplat_hole_memory *memory, size_t items,
                         const searcher *first) {
    const psplat_measured_splats *measured = first->measured;
    *c = (changes){.memory = memory};
    if (!memory) return 1;
    if (memory->cover_count != items || memory->tolerance != measured->tolerance ||
        memory->coarse != first->coarse || memory->fine != first->fine) {
        psplat_hole_memory_free(memory);
        memory->covers = malloc((items + 1) * sizeof *memory->covers);
        if (!memory->covers) return 0;
        memset(memory->covers, 0xff, (items + 1) * sizeof *memory->covers);
        memory->cover_count = items;
        memory->tolerance = measured->tolerance;
        memory->coarse = first->coarse, memory->fine = first->fine;
    }
    size_t count = 0;
    c->now = malloc((memory->region_count + 1) * sizeof *c->now);
    psplat_region *gone = malloc((memory->region_count + 1) * sizeof *gone);
    int ok = c->now && gone && find_again(c, measured->regions, measured->count);
    for (size_t i = 0; ok && i < memory->region_count; ++i)
        if (c->now[i] == open_part) gone[count++] = memory->regions[i];
    if (ok) c->changed = psplat_region_tree_create_covering(gone, count, measured->tolerance);
    free(gone);
    return c->changed != NULL;
}

/* Keeps the regions of this search for the next one. Returns 0 when out of memory. */
static int changes_end(changes *c, const psplat_measured_splats *measured) {
    if (!c->memory) return 1;
    size_t size = (measured->count + 1) * sizeof *measured->regions;
    psplat_region *regions = realloc(c->memory->regions, size);
    if (!regions) return 0;
    c->memory->regions = regions;
    c->memory->region_count = measured->count;
    memcpy(regions, measured->regions, measured->count * sizeof *regions);
    return 1;
}

void psplat_hole_memory_free(psplat_hole_memory *memory) {
    free(memory->regions);
    free(memory->covers);
    *memory = (psplat_hole_memory){0};
}

static int visit_changed(void *user, uint32_t region) {
    (void)region;
    *(int *)user = 1;
    return 1;
}

/* Returns whether a part surely has no hole: the splat that covers it is there as before, or all
 * are that are near. */
static int is_known(const changes *c, size_t item, const psplat_surface *surface) {
    uint32_t *cover = c->memory ? &c->memory->covers[item] : NULL;
    subtriangle t;
    int changed = 0;
    double low[3], high[3];
    if (!cover || *cover == open_part) return 0;
    if (*cover < several) {
        if (c->now[*cover] == open_part) return 0;
        *cover = c->now[*cover];
        return 1;
    }
    part_of(surface, item, &t);
    box_of(&t, low, high);
    psplat_region_tree_visit_box(c->changed, low, high, visit_changed, &changed);
    return !changed;
}

/* ---- the search ------------------------------------------------------------------------------ */

/* The number of triangles or points that a thread takes at once. */
enum { BLOCK_SIZE = 256 };

static void search_item(searcher *s, const psplat_surface *surface, const changes *c, size_t item) {
    subtriangle t;
    if (is_known(c, item, surface)) return;
    s->triangle = part_of(surface, item, &t);
    if (is_apron(surface, &t)) return;
    search_root(s, &t);
    if (c->memory) c->memory->covers[item] = s->cover;
}

/* Finds the holes of each block of items. Returns 0 when out of memory. */
static int search_blocks(const psplat_surface *surface, const searcher *first, const changes *c,
                         size_t items, psplat_holes *blocks, size_t block_count) {
    int failed = 0;
    long end = (long)block_count;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        searcher s = *first;
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 1)
#endif
        for (long b = 0; b < end; ++b) {
            s.holes = &blocks[b];
            for (size_t i = (size_t)b * BLOCK_SIZE;
                 i < items && i < ((size_t)b + 1) * BLOCK_SIZE && !s.failed; ++i)
                search_item(&s, surface, c, i);
        }
        free(s.near);
        failed |= s.failed;
    }
    return !failed;
}

psplat_result psplat_holes_find_changed(const psplat_surface *surface,
                                        const psplat_measured_splats *measured, double coarse,
                                        double fine, psplat_hole_memory *memory,
                                        psplat_holes *holes) {
    size_t items = surface->mesh->triangle_count + surface->mesh->point_count,
           block_count = items / BLOCK_SIZE + 1;
    const searcher first = {
        .surface = surface, .measured = measured, .coarse = coarse, .fine = fine};
    changes c;
    psplat_holes *blocks = calloc(block_count, sizeof *blocks);
    *holes = (psplat_holes){0};
    int ok = changes_begin(&c, memory, items, &first) && blocks &&
             search_blocks(surface, &first, &c, items, blocks, block_count);
    for (size_t b = 0; b < block_count && blocks; ++b) {
        if (ok) ok = append_holes(holes, &blocks[b]);
        psplat_holes_free(&blocks[b]);
    }
    free(blocks);
    if (ok) ok = changes_end(&c, measured);
    changes_free(&c);
    if (ok && holes->count) ok = keep_one_per_cube(holes, coarse);
    if (!ok) psplat_holes_free(holes);
    if (!ok && memory) psplat_hole_memory_free(memory);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_holes_find(const psplat_surface *surface,
                                const psplat_measured_splats *measured, double coarse, double fine,
                                psplat_holes *holes) {
    return psplat_holes_find_changed(surface, measured, coarse, fine, NULL, holes);
}
