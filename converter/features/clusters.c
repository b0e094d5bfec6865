/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clusters.c - the partition of a surface into small connected pieces.
 *
 * A cluster starts at the first triangle that has none and takes neighbours over edges that are no
 * creases, breadth first, as long as these are near. So there are about as many clusters as there
 * are samples, or triangles if these are fewer, and a flood over clusters costs the same however
 * fine the mesh is.
 */
#include "features/clusters.h"

#include "base/morton.h"
#include "base/vector.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

void psplat_clusters_unlink(psplat_clusters *c) {
    free(c->first_neighbor);
    free(c->neighbors);
    free(c->first_crease);
    free(c->creases);
    c->first_neighbor = c->neighbors = c->first_crease = c->creases = NULL;
}

void psplat_clusters_free(psplat_clusters *c) {
    free(c->of_triangles);
    free(c->spheres);
    free(c->triangles);
    psplat_clusters_unlink(c);
    *c = (psplat_clusters){0};
}

static int is_near(const psplat_mesh *mesh, uint32_t triangle, const double from[3], double size) {
    for (int k = 0; k < 3; ++k)
        if (distance2_3(psplat_mesh_corner(mesh, triangle, k), from) > size * size) return 0;
    return 1;
}

/* Gives all triangles that are connected with `first` and near it the next cluster. queue has room
 * for all triangles. */
static void grow_cluster(const psplat_surface *surface, double size, uint32_t first,
                         psplat_clusters *c, uint32_t *queue) {
    const double *from = psplat_mesh_corner(surface->mesh, first, 0);
    uint32_t cluster = (uint32_t)c->count++;
    size_t count = 1;
    queue[0] = first;
    c->of_triangles[first] = cluster;
    for (size_t at = 0; at < count; ++at)
        for (uint32_t k = 0; k < 3; ++k) {
            size_t edge = 3 * (size_t)queue[at] + k;
            uint32_t next = surface->neighbors[edge];
            if (surface->creases[edge] || c->of_triangles[next] != PSPLAT_NONE ||
                !is_near(surface->mesh, next, from, size))
                continue;
            c->of_triangles[next] = cluster;
            queue[count++] = next;
        }
}

static int partition(const psplat_surface *surface, double size, psplat_clusters *c) {
    size_t triangles = surface->mesh->triangle_count;
    uint32_t *queue = malloc((triangles + 1) * sizeof *queue);
    c->of_triangles = malloc((triangles + 1) * sizeof *c->of_triangles);
    int ok = queue && c->of_triangles;
    if (ok) memset(c->of_triangles, 0xff, triangles * sizeof *c->of_triangles);
    for (uint32_t t = 0; ok && t < triangles; ++t)
        if (c->of_triangles[t] == PSPLAT_NONE) grow_cluster(surface, size, t, c, queue);
    free(queue);
    return ok;
}

/* Finds the spheres: around the middles of the boxes. */
static int find_spheres(const psplat_mesh *mesh, psplat_clusters *c) {
    double(*boxes)[6] = malloc((c->count + 1) * sizeof *boxes);
    c->spheres = calloc(c->count + 1, sizeof *c->spheres);
    c->triangles = malloc((c->count + 1) * sizeof *c->triangles);
    int ok = boxes && c->spheres && c->triangles;
    for (size_t i = 0; ok && i < c->count; ++i) {
        c->triangles[i] = PSPLAT_NONE;
        for (int k = 0; k < 3; ++k) boxes[i][k] = HUGE_VAL, boxes[i][3 + k] = -HUGE_VAL;
    }
    for (uint32_t t = 0; ok && t < mesh->triangle_count; ++t) {
        uint32_t of = c->of_triangles[t];
        int is_first = !(boxes[of][0] < HUGE_VAL);
        c->triangles[of] = is_first ? t : PSPLAT_NONE;
        for (int corner = 0; corner < 3; ++corner)
            for (int k = 0; k < 3; ++k) {
                double x = psplat_mesh_corner(mesh, t, corner)[k];
                boxes[of][k] = min2(boxes[of][k], x);
                boxes[of][3 + k] = max2(boxes[of][3 + k], x);
            }
    }
    for (size_t i = 0; ok && i < c->count; ++i)
        for (int k = 0; k < 3; ++k) c->spheres[i].center[k] = (boxes[i][k] + boxes[i][3 + k]) / 2;
    for (uint32_t t = 0; ok && t < mesh->triangle_count; ++t)
        for (int corner = 0; corner < 3; ++corner) {
            psplat_sphere *s = &c->spheres[c->of_triangles[t]];
            s->radius =
                max2(s->radius, distance2_3(psplat_mesh_corner(mesh, t, corner), s->center));
        }
    for (size_t i = 0; ok && i < c->count; ++i) c->spheres[i].radius = sqrt(c->spheres[i].radius);
    free(boxes);
    return ok;
}

/* A cluster and the place of its first triangle along a Morton curve through the surface. */
typedef struct placed_cluster {
    uint32_t code, cluster;
} placed_cluster;

static int compare_places(const void *left, const void *right) {
    const placed_cluster *a = left, *b = right;
    if (a->code != b->code) return a->code < b->code ? -1 : 1;
    return a->cluster < b->cluster ? -1 : a->cluster > b->cluster;
}

/* Sorts the clusters along a Morton curve, so that a flood stays within a few pages of memory. */
static int sort_along_curve(const psplat_surface *surface, psplat_clusters *c) {
    const psplat_mesh *mesh = surface->mesh;
    placed_cluster *places = malloc((c->count + 1) * sizeof *places);
    uint32_t *moved = malloc((c->count + 1) * sizeof *moved), found = 0;
    int ok = places && moved;
    for (uint32_t t = 0; ok && t < mesh->triangle_count; ++t) {
        if (c->of_triangles[t] != found) continue; /* Clusters are numbered by first triangles. */
        const double *p = psplat_mesh_corner(mesh, t, 0);
        uint32_t code = psplat_morton_code(p, psplat_mesh_corner(mesh, 0, 0), surface->diagonal);
        places[found] = (placed_cluster){code, found};
        ++found;
    }
    if (ok) qsort(places, c->count, sizeof *places, compare_places);
    for (uint32_t i = 0; ok && i < c->count; ++i) moved[places[i].cluster] = i;
    for (size_t t = 0; ok && t < mesh->triangle_count; ++t)
        c->of_triangles[t] = moved[c->of_triangles[t]];
    free(places);
    free(moved);
    return ok;
}

/* Makes the sums of counts, which are stored from the second one on, the first index of each. */
static void sum_up(uint32_t *firsts, size_t count) {
    for (size_t i = 0; i < count; ++i) firsts[i + 1] += firsts[i];
}

/* Lists the creases of each cluster, in the order of its triangles. */
static int list_creases(const psplat_surface *surface, psplat_clusters *c) {
    size_t edges = 3 * surface->mesh->triangle_count;
    c->first_crease = calloc(c->count + 2, sizeof *c->first_crease);
    if (!c->first_crease) return 0;
    uint32_t *ends = c->first_crease + 1; /* Filling moves each start to the next one's place. */
    for (size_t e = 0; e < edges; ++e)
        if (surface->creases[e]) ++ends[c->of_triangles[e / 3] + 1];
    sum_up(ends, c->count);
    c->creases = malloc((ends[c->count] + 1) * sizeof *c->creases);
    if (!c->creases) return 0;
    for (size_t e = 0; e < edges; ++e)
        if (surface->creases[e]) c->creases[ends[c->of_triangles[e / 3]]++] = (uint32_t)e;
    return 1;
}

/* Returns the cluster across an edge; PSPLAT_NONE where that is the same one or the edge is a
 * crease. */
static uint32_t cluster_across(const psplat_surface *surface, const psplat_clusters *c, size_t e) {
    if (surface->creases[e]) return PSPLAT_NONE;
    uint32_t across = c->of_triangles[surface->neighbors[e]];
    return across == c->of_triangles[e / 3] ? PSPLAT_NONE : across;
}

static int compare_indices(const void *left, const void *right) {
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return a < b ? -1 : a > b;
}

/* Lists the neighbours of each cluster, each once. */
static int list_neighbors(const psplat_surface *surface, psplat_clusters *c) {
    size_t edges = 3 * surface->mesh->triangle_count;
    c->first_neighbor = calloc(c->count + 2, sizeof *c->first_neighbor);
    if (!c->first_neighbor) return 0;
    uint32_t *ends = c->first_neighbor + 1; /* as above */
    for (size_t e = 0; e < edges; ++e)
        if (cluster_across(surface, c, e) != PSPLAT_NONE) ++ends[c->of_triangles[e / 3] + 1];
    sum_up(ends, c->count);
    c->neighbors = malloc((ends[c->count] + 1) * sizeof *c->neighbors);
    if (!c->neighbors) return 0;
    for (size_t e = 0; e < edges; ++e) {
        uint32_t across = cluster_across(surface, c, e);
        if (across != PSPLAT_NONE) c->neighbors[ends[c->of_triangles[e / 3]]++] = across;
    }
    uint32_t kept = 0, begin = 0;
    for (size_t i = 0; i < c->count; ++i) {
        uint32_t end = c->first_neighbor[i + 1], first = kept;
        qsort(c->neighbors + begin, end - begin, sizeof *c->neighbors, compare_indices);
        for (uint32_t at = begin; at < end; ++at)
            if (kept == first || c->neighbors[at] != c->neighbors[kept - 1])
                c->neighbors[kept++] = c->neighbors[at];
        c->first_neighbor[i] = first;
        begin = end;
    }
    c->first_neighbor[c->count] = kept;
    return 1;
}

int psplat_clusters_relink(const psplat_surface *surface, psplat_clusters *clusters) {
    clusters->first_neighbor = clusters->neighbors = NULL;
    clusters->first_crease = clusters->creases = NULL;
    if (list_creases(surface, clusters) && list_neighbors(surface, clusters)) return 1;
    psplat_clusters_unlink(clusters);
    return 0;
}

int psplat_clusters_build(const psplat_surface *surface, double size, psplat_clusters *clusters) {
    *clusters = (psplat_clusters){0};
    if (partition(surface, size, clusters) && sort_along_curve(surface, clusters) &&
        find_spheres(surface->mesh, clusters) && list_creases(surface, clusters) &&
        list_neighbors(surface, clusters))
        return 1;
    psplat_clusters_free(clusters);
    return 0;
}
