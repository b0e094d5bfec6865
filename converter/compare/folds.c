/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * folds.c - which points are near the creases of a surface.
 */
#include "folds.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

typedef struct key {
    uint32_t low, high, edge;
} key;

static const double *start(const psplat_mesh *mesh, uint32_t edge) {
    return mesh->positions + 3 * (size_t)mesh->triangles[edge];
}

static const double *end(const psplat_mesh *mesh, uint32_t edge) {
    return start(mesh, edge % 3 == 2 ? edge - 2 : edge + 1);
}

static key key_of(const psplat_mesh *mesh, uint32_t edge) {
    uint32_t a = mesh->triangles[edge], b = mesh->triangles[edge % 3 == 2 ? edge - 2 : edge + 1];
    return a < b ? (key){a, b, edge} : (key){b, a, edge};
}

static int compare_keys(const void *left, const void *right) {
    const key *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return a->edge < b->edge ? -1 : a->edge > b->edge;
}

static int is_same(const key *a, const key *b) {
    return a->low == b->low && a->high == b->high;
}

/* Each edge once; of those that have no neighbour across only what several triangles share. */
static void choose(const psplat_surface *surface, key *keys, size_t count, psplat_folds *folds) {
    qsort(keys, count, sizeof *keys, compare_keys);
    for (size_t i = 0, next; i < count; i = next) {
        for (next = i + 1; next < count && is_same(&keys[i], &keys[next]);) ++next;
        if (next > i + 1 || surface->neighbors[keys[i].edge] != PSPLAT_NONE)
            folds->edges[folds->count++] = keys[i].edge;
    }
}

/* Edges as regions of no width, for the locator. */
static psplat_locator *locate(const psplat_folds *folds) {
    psplat_region *regions = calloc(folds->count + 1, sizeof *regions);
    for (size_t i = 0; regions && i < folds->count; ++i) {
        const double *a = start(folds->mesh, folds->edges[i]),
                     *b = end(folds->mesh, folds->edges[i]);
        along3(regions[i].center, a, 0.5, b);
        mad3(regions[i].center, -0.5, a);
        sub3(regions[i].u, b, a);
        regions[i].radius[0] = 0.5;
    }
    psplat_locator *locator =
        regions ? psplat_locator_create(regions, folds->count, folds->width) : NULL;
    free(regions);
    return locator;
}

psplat_result psplat_folds_create(const psplat_surface *surface, double width,
                                  psplat_folds *folds) {
    size_t count = 0, edges = 3 * surface->mesh->triangle_count;
    *folds = (psplat_folds){.mesh = surface->mesh, .width = width};
    for (uint32_t e = 0; e < edges; ++e) count += surface->creases[e] != 0;
    key *keys = malloc((count + 1) * sizeof *keys);
    folds->edges = malloc((count + 1) * sizeof *folds->edges);
    if (keys && folds->edges) {
        count = 0;
        for (uint32_t e = 0; e < edges; ++e)
            if (surface->creases[e]) keys[count++] = key_of(surface->mesh, e);
        choose(surface, keys, count, folds);
        folds->locator = locate(folds);
    }
    free(keys);
    if (folds->locator) return PSPLAT_OK;
    psplat_folds_free(folds);
    return PSPLAT_ERROR_MEMORY;
}

typedef struct near_probe {
    const psplat_folds *folds;
    const double *point;
    int near;
} near_probe;

static int visit_edge(void *user, uint32_t index) {
    near_probe *p = user;
    uint32_t edge = p->folds->edges[index];
    double distance2 =
        point_segment_distance2(p->point, start(p->folds->mesh, edge), end(p->folds->mesh, edge));
    return p->near = distance2 <= p->folds->width * p->folds->width;
}

int psplat_folds_near(const psplat_folds *folds, const double point[3]) {
    near_probe p = {folds, point, 0};
    psplat_locator_visit(folds->locator, point, visit_edge, &p);
    return p.near;
}

void psplat_folds_free(psplat_folds *folds) {
    psplat_locator_destroy(folds->locator);
    free(folds->edges);
    *folds = (psplat_folds){0};
}
