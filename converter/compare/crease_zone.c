/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_zone.c - the crease zone of a surface: its edges in a bounding box tree, and queries of
 * points near them.
 */
#include "compare/crease_zone.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

/* The sort key that brings the half-edges of one edge together: its vertices, lower index first. */
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

/* Keeps each edge once. An edge without a neighbour across is kept only if several triangles share
 * it, since it is a border otherwise. */
static void keep_unique_edges(const psplat_surface *surface, key *keys, size_t count,
                              psplat_crease_zone *zone) {
    qsort(keys, count, sizeof *keys, compare_keys);
    for (size_t i = 0, next; i < count; i = next) {
        for (next = i + 1; next < count && is_same(&keys[i], &keys[next]);) ++next;
        if (next > i + 1 || surface->neighbors[keys[i].edge] != PSPLAT_NONE)
            zone->edges[zone->count++] = keys[i].edge;
    }
}

/* Builds a tree of the edges, which are regions of no width to it. */
static psplat_region_tree *build_tree(const psplat_crease_zone *zone) {
    psplat_region *regions = calloc(zone->count + 1, sizeof *regions);
    for (size_t i = 0; regions && i < zone->count; ++i) {
        const double *a = start(zone->mesh, zone->edges[i]), *b = end(zone->mesh, zone->edges[i]);
        along3(regions[i].center, a, 0.5, b);
        mad3(regions[i].center, -0.5, a);
        sub3(regions[i].u, b, a);
        regions[i].radius[0] = 0.5;
    }
    psplat_region_tree *region_tree =
        regions ? psplat_region_tree_create(regions, zone->count, zone->width) : NULL;
    free(regions);
    return region_tree;
}

psplat_result psplat_crease_zone_create(const psplat_surface *surface, double width,
                                        psplat_crease_zone *zone) {
    size_t count = 0, edges = 3 * surface->mesh->triangle_count;
    *zone = (psplat_crease_zone){.mesh = surface->mesh, .width = width};
    for (uint32_t e = 0; e < edges; ++e) count += surface->creases[e] != 0;
    key *keys = malloc((count + 1) * sizeof *keys);
    zone->edges = malloc((count + 1) * sizeof *zone->edges);
    if (keys && zone->edges) {
        count = 0;
        for (uint32_t e = 0; e < edges; ++e)
            if (surface->creases[e]) keys[count++] = key_of(surface->mesh, e);
        keep_unique_edges(surface, keys, count, zone);
        zone->region_tree = build_tree(zone);
    }
    free(keys);
    if (zone->region_tree) return PSPLAT_OK;
    psplat_crease_zone_free(zone);
    return PSPLAT_ERROR_MEMORY;
}

typedef struct near_probe {
    const psplat_crease_zone *zone;
    const double *point;
    int near;
} near_probe;

static int visit_edge(void *user, uint32_t index) {
    near_probe *p = user;
    uint32_t edge = p->zone->edges[index];
    double distance2 =
        point_segment_distance2(p->point, start(p->zone->mesh, edge), end(p->zone->mesh, edge));
    return p->near = distance2 <= p->zone->width * p->zone->width;
}

int psplat_crease_zone_near(const psplat_crease_zone *zone, const double point[3]) {
    near_probe p = {zone, point, 0};
    psplat_region_tree_visit(zone->region_tree, point, visit_edge, &p);
    return p.near;
}

void psplat_crease_zone_free(psplat_crease_zone *zone) {
    psplat_region_tree_destroy(zone->region_tree);
    free(zone->edges);
    *zone = (psplat_crease_zone){0};
}
