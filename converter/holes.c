/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * holes.c - where stored splats leave the surface open.
 *
 * What a splat covers is convex: a region of its plane, within the tolerance above and below. So a
 * triangle whose three corners one splat covers is covered wholly, and one of which that is not so
 * is halved, until a part's middle is found open, or the part is too small to matter. No chance is
 * involved: what stays unknown is smaller than the resolution.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Of a triangle: corners and normals there. */
typedef struct part {
    double p[3][3], n[3][3];
} part;

/* What one thread works with. */
typedef struct searcher {
    const psplat_measured *measured;
    double coarse, fine; /* sides at which middles are looked at, and no longer */
    psplat_holes *holes;
    uint32_t triangle;
    uint32_t *near; /* splats near the part under way, after those of what it is a part of */
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

/* Whether all of a part, given in a splat's parameters, lies beyond one side of what it covers. */
static int is_beside(const psplat_region *region, double tolerance, const double uvh[3][3]) {
    double middle[2], spread = 0;
    int above = 1, below = 1;
    for (int k = 0; k < 2; ++k) middle[k] = (uvh[0][k] + uvh[1][k] + uvh[2][k]) / 3;
    for (int i = 0; i < 3; ++i) {
        above &= uvh[i][2] > tolerance, below &= uvh[i][2] < -tolerance;
        spread = max2(spread, hypot(uvh[i][0] - middle[0], uvh[i][1] - middle[1]));
    }
    if (above || below || hypot(middle[0], middle[1]) > 1 + spread + 1e-5) return 1;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        int outside = 1;
        for (int k = 0; k < 3; ++k)
            outside &= line[0] * uvh[k][0] + line[1] * uvh[k][1] + line[2] < -1e-5;
        if (outside) return 1;
    }
    return 0;
}

/* Keeps those of the splats near[begin ... end) that are near the part. Returns 1 where one of them
 * covers it. */
static int find_near(searcher *s, const part *t, size_t begin, size_t end) {
    for (size_t i = begin; i < end && !s->failed; ++i) {
        uint32_t splat = s->near[i];
        const psplat_region *region = &s->measured->regions[splat];
        double uvh[3][3];
        int covered = 1;
        for (int k = 0; k < 3; ++k) {
            psplat_region_local(region, t->p[k], uvh[k]);
            covered = covered && psplat_measured_covers(s->measured, splat, t->n[k], uvh[k]);
        }
        if (covered) return 1;
        if (!is_beside(region, s->measured->tolerance, (const double(*)[3])uvh))
            push_near(s, splat);
    }
    return 0;
}

static int is_open(const searcher *s, const double p[3], const double n[3], size_t begin) {
    for (size_t i = begin; i < s->near_count; ++i) {
        double uvh[3];
        psplat_region_local(&s->measured->regions[s->near[i]], p, uvh);
        if (psplat_measured_covers(s->measured, s->near[i], n, uvh)) return 0;
    }
    return 1;
}

static void between(double out[3], const double a[3], const double b[3]) {
    for (int k = 0; k < 3; ++k) out[k] = 0.5 * (a[k] + b[k]);
}

/* Halves a part across its longest side. Returns that side's length. */
static double halve(const part *t, part halves[2]) {
    double longest = -1;
    int from = 0;
    for (int k = 0; k < 3; ++k) {
        double d[3];
        sub3(d, t->p[(k + 1) % 3], t->p[k]);
        if (length3(d) > longest) longest = length3(d), from = k;
    }
    int to = (from + 1) % 3;
    halves[0] = halves[1] = *t;
    between(halves[0].p[to], t->p[from], t->p[to]);
    between(halves[0].n[to], t->n[from], t->n[to]);
    memcpy(halves[1].p[from], halves[0].p[to], sizeof halves[0].p[to]);
    memcpy(halves[1].n[from], halves[0].n[to], sizeof halves[0].n[to]);
    return longest;
}

/* Looks for holes in a part, of whose whole near[begin ... near_count) are near; one is enough
 * where the part is small. Returns whether there is one. */
static int search(searcher *s, const part *t, size_t begin) {
    size_t end = s->near_count;
    part halves[2];
    if (find_near(s, t, begin, end)) {
        s->near_count = end;
        return 0;
    }
    double side = halve(t, halves), p[3], n[3];
    for (int k = 0; k < 3; ++k) {
        p[k] = (t->p[0][k] + t->p[1][k] + t->p[2][k]) / 3;
        n[k] = (t->n[0][k] + t->n[1][k] + t->n[2][k]) / 3;
    }
    int found = side <= s->coarse && is_open(s, p, n, end);
    if (found) push_hole(s, p);
    for (int k = 0; k < 2 && side > s->fine && !s->failed; ++k)
        if (!found || side > s->coarse) found |= search(s, &halves[k], end);
    s->near_count = end;
    return found;
}

static int visit_near(void *user, uint32_t splat) {
    searcher *s = user;
    push_near(s, splat);
    return s->failed;
}

static void search_part(searcher *s, const part *t) {
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = min2(t->p[0][k], min2(t->p[1][k], t->p[2][k]));
        high[k] = max2(t->p[0][k], max2(t->p[1][k], t->p[2][k]));
    }
    s->near_count = 0;
    psplat_locator_visit_box(s->measured->locator, low, high, visit_near, s);
    search(s, t, 0);
}

static void search_triangle(searcher *s, const psplat_surface *surface, uint32_t triangle) {
    part t;
    const float *normals = surface->corner_normals + 9 * (size_t)triangle;
    for (uint32_t k = 0; k < 3; ++k) {
        size_t vertex = surface->mesh->triangles[3 * (size_t)triangle + k];
        memcpy(t.p[k], surface->mesh->positions + 3 * vertex, sizeof t.p[k]);
        for (uint32_t i = 0; i < 3; ++i) t.n[k][i] = (double)normals[3 * k + i];
    }
    s->triangle = triangle;
    search_part(s, &t);
}

/* A point of a point set: a part without extent. */
static void search_point(searcher *s, const psplat_surface *surface, size_t point) {
    part t;
    s->triangle = surface->mesh->point_triangles[point];
    for (int k = 0; k < 3; ++k) {
        memcpy(t.p[k], surface->mesh->points + 3 * point, sizeof t.p[k]);
        memcpy(t.n[k], surface->face_normals + 3 * (size_t)s->triangle, sizeof t.n[k]);
    }
    search_part(s, &t);
}

void psplat_holes_free(psplat_holes *holes) {
    free(holes->points);
    free(holes->triangles);
    *holes = (psplat_holes){0};
}

/* Appends what a block found. */
static int unite(psplat_holes *holes, const psplat_holes *block) {
    size_t count = holes->count + block->count;
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

/* A hole and the cube of space that it lies in. */
typedef struct placed {
    double cell[3];
    size_t index;
} placed;

static int compare_placed(const void *left, const void *right) {
    const placed *a = left, *b = right;
    for (int k = 0; k < 3; ++k)
        if (a->cell[k] != b->cell[k]) return a->cell[k] < b->cell[k] ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Keeps the first hole of each cube with these sides: small triangles have one each. */
static int thin(psplat_holes *holes, double side) {
    size_t count = holes->count, kept = 0;
    placed *list = malloc((count + 1) * sizeof *list);
    uint8_t *first = calloc(count + 1, 1);
    for (size_t i = 0; list && i < count; ++i) {
        for (size_t k = 0; k < 3; ++k) list[i].cell[k] = floor(holes->points[3 * i + k] / side);
        list[i].index = i;
    }
    if (list && first) qsort(list, count, sizeof *list, compare_placed);
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

enum { BLOCK = 256 }; /* triangles or points that a thread takes at once */

psplat_result psplat_holes_find(const psplat_surface *surface, const psplat_measured *measured,
                                double coarse, double fine, psplat_holes *holes) {
    size_t triangles = surface->mesh->triangle_count,
           items = triangles + surface->mesh->point_count;
    long block_count = (long)(items / BLOCK + 1);
    psplat_holes *blocks = calloc((size_t)block_count, sizeof *blocks);
    int failed = !blocks;
    *holes = (psplat_holes){0};
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        searcher s = {.measured = measured, .coarse = coarse, .fine = fine, .failed = !blocks};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 1)
#endif
        for (long b = 0; b < block_count; ++b) {
            s.holes = blocks ? &blocks[b] : NULL;
            size_t begin = (size_t)b * BLOCK, end = begin + BLOCK < items ? begin + BLOCK : items;
            for (size_t i = begin; i < end && !s.failed; ++i) {
                if (i < triangles)
                    search_triangle(&s, surface, (uint32_t)i);
                else
                    search_point(&s, surface, i - triangles);
            }
        }
        free(s.near);
        failed |= s.failed;
    }
    for (long b = 0; b < block_count && blocks; ++b) {
        if (!failed) failed = !unite(holes, &blocks[b]);
        psplat_holes_free(&blocks[b]);
    }
    free(blocks);
    if (!failed && holes->count) failed = !thin(holes, coarse);
    if (failed) psplat_holes_free(holes);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
