/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * alpha_mask.c - alpha masks (glTF 2.0 section 3.9.4, alphaMode MASK) as geometry.
 *
 * What a mask hides is cut away, so that the edge of the mask is a border of the mesh like any
 * other, which clip lines follow. First the triangles that the edge crosses are refined until their
 * edges are short: all edges of such a triangle are halved, and its neighbours are divided at the
 * halved edges so that no vertex lies inside an edge (red-green refinement, Bank et al. 1983). Then
 * each triangle is cut along a straight line between the points where the edge of the mask crosses
 * its edges. Vertices, alphas and these points are the same on both sides of an edge wherever the
 * texture coordinates are, so that no gap opens.
 */
#include "appearance/alpha_mask.h"

#include "appearance/appearance.h"
#include "base/vector.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most steps of the grid that looks for the edge of a mask, the bisections that place it on an
 * edge of a triangle, and the most passes of refinement. */
enum { MAX_GRID_STEPS = 64, BISECTIONS = 10, MAX_PASSES = 24 };
/* Refinement ends at this many triangles, so that a mask of noise does not fill the memory. */
static const size_t max_refined_triangles = 4000000;

/* ---- alpha ----------------------------------------------------------------------------------- */

/* The mesh that is refined, and how its alpha is read. */
typedef struct cutter {
    psplat_mesh mesh;
    psplat_appearance appearance; /* with diameter 0, so that alpha is that of one point alone */
    double step;                  /* the length from which edges are halved */
} cutter;

/* Returns the material of a triangle if it has a mask, or NULL. */
static const psplat_source_material *mask_of(const psplat_mesh *mesh, size_t triangle) {
    size_t group = mesh->groups ? mesh->groups[triangle] : 0;
    if (group >= mesh->source_material_count || !mesh->source_materials[group].is_masked)
        return NULL;
    return &mesh->source_materials[group];
}

/* Returns whether the mask shows the point of a triangle with these barycentric coordinates. */
static int is_shown(const cutter *c, uint32_t triangle, const double weights[3]) {
    const psplat_source_material *mask = mask_of(&c->mesh, triangle);
    return !mask ||
           psplat_appearance_alpha(&c->appearance, triangle, weights) >= (double)mask->alpha_cutoff;
}

static double edge_length(const psplat_mesh *mesh, size_t triangle, size_t k) {
    const uint32_t *t = mesh->triangles + 3 * triangle;
    double d[3];
    sub3(d, mesh->positions + 3 * (size_t)t[(k + 1) % 3], mesh->positions + 3 * (size_t)t[k]);
    return length3(d);
}

/* Returns whether the edge of a mask crosses a triangle, tested at a grid of points as fine as the
 * step. */
static int is_crossed(const cutter *c, uint32_t triangle) {
    double longest = 0;
    if (!mask_of(&c->mesh, triangle)) return 0;
    for (size_t k = 0; k < 3; ++k) longest = max2(longest, edge_length(&c->mesh, triangle, k));
    int n = (int)min2(max2(ceil(longest / c->step), 1), MAX_GRID_STEPS), first = -1;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j) {
            const double weights[3] = {(double)i / n, (double)j / n, (double)(n - i - j) / n};
            int shown = is_shown(c, triangle, weights);
            if (first >= 0 && shown != first) return 1;
            first = shown;
        }
    return 0;
}

/* ---- corners --------------------------------------------------------------------------------- */

static unsigned parts_of(const psplat_mesh *mesh) {
    unsigned parts = (mesh->corner_normals ? PSPLAT_MESH_NORMALS : 0u) |
                     (mesh->corner_colors ? PSPLAT_MESH_COLORS : 0u) |
                     (mesh->corner_tangents ? PSPLAT_MESH_TANGENTS : 0u) |
                     (mesh->groups ? PSPLAT_MESH_GROUPS : 0u);
    for (unsigned i = 0; i < PSPLAT_TEXCOORDS; ++i)
        if (mesh->corner_uvs[i]) parts |= PSPLAT_MESH_UVS << i;
    return parts;
}

/* Allocates a mesh with the attributes and materials of another, but of a different size. */
static psplat_result allocate_like(const psplat_mesh *mesh, size_t vertices, size_t triangles,
                                   psplat_mesh *made, psplat_error *error) {
    psplat_result result = psplat_mesh_allocate(made, vertices, triangles, parts_of(mesh), error);
    if (result) return result;
    memcpy(made->origin, mesh->origin, sizeof made->origin);
    made->material = mesh->material;
    made->source_materials = mesh->source_materials;
    made->source_material_count = mesh->source_material_count;
    made->dropped = mesh->dropped;
    if (!mesh->both_sides) return PSPLAT_OK;
    made->both_sides = malloc(mesh->both_sides_count);
    if (!made->both_sides)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting a mask");
    memcpy(made->both_sides, mesh->both_sides, mesh->both_sides_count);
    made->both_sides_count = mesh->both_sides_count;
    return PSPLAT_OK;
}

/* Stores the attributes of a corner: those of `from` at barycentric coordinates of a triangle. */
static void store_corner(psplat_mesh *to, size_t corner, const psplat_mesh *from, size_t triangle,
                         const double weights[3]) {
    psplat_corners in[PSPLAT_CORNER_ARRAYS], out[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(from, in);
    psplat_mesh_corners(to, out);
    for (size_t a = 0; a < count; ++a)
        for (size_t k = 0; k < in[a].components; ++k) {
            double sum = 0;
            for (size_t i = 0; i < 3; ++i)
                if (weights[i] != 0) /* an unused corner may hold NaN */
                    sum += weights[i] *
                           (double)in[a].values[(3 * triangle + i) * in[a].components + k];
            out[a].values[corner * in[a].components + k] = (float)sum;
        }
}

/* Stores a triangle whose corners are points of a triangle of `from`. */
static void store_triangle(psplat_mesh *to, size_t target, const psplat_mesh *from, size_t triangle,
                           const double weights[3][3], const uint32_t vertices[3]) {
    for (size_t i = 0; i < 3; ++i) {
        to->triangles[3 * target + i] = vertices[i];
        store_corner(to, 3 * target + i, from, triangle, weights[i]);
    }
    if (to->groups) to->groups[target] = from->groups[triangle];
}

/* ---- refining -------------------------------------------------------------------------------- */

/* A hash table of the edges that are halved, with open addressing. A slot whose middle is 0 is
 * free. */
typedef struct marks {
    struct mark {
        uint32_t low, high, middle; /* end vertices, and the new vertex between them */
    } * slots;
    size_t size, count; /* size is a power of two */
} marks;

/* Returns the slot of edge k of a triangle, whose middle is 0 if the edge is not marked. */
static struct mark *find_mark(const marks *m, const psplat_mesh *mesh, size_t triangle, size_t k) {
    const uint32_t *t = mesh->triangles + 3 * triangle;
    uint32_t a = t[k], b = t[(k + 1) % 3], low = a < b ? a : b, high = a < b ? b : a;
    uint64_t hash = ((uint64_t)low << 32 | high) * 0x9e3779b97f4a7c15u;
    size_t slot = (size_t)(hash >> 32) & (m->size - 1);
    while (m->slots[slot].middle && (m->slots[slot].low != low || m->slots[slot].high != high))
        slot = (slot + 1) & (m->size - 1);
    struct mark *mark = &m->slots[slot];
    if (!mark->middle) mark->low = low, mark->high = high;
    return mark;
}

/* Marks the edges longer than the step of triangles that the edge of a mask crosses. Returns 0 when
 * out of memory. */
static int mark_edges(const cutter *c, marks *m) {
    const psplat_mesh *mesh = &c->mesh;
    uint8_t *crossed = malloc(mesh->triangle_count + 1);
    size_t count = 0;
    if (!crossed) return 0;
    long end = (long)mesh->triangle_count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 64)
#endif
    for (long t = 0; t < end; ++t) crossed[t] = (uint8_t)is_crossed(c, (uint32_t)t);
    for (size_t t = 0; t < mesh->triangle_count; ++t) count += crossed[t];
    for (m->size = 16; m->size < 8 * count; m->size *= 2) continue;
    m->slots = calloc(m->size, sizeof *m->slots);
    for (size_t t = 0; m->slots && t < mesh->triangle_count; ++t)
        for (size_t k = 0; crossed[t] && k < 3; ++k) {
            if (edge_length(mesh, t, k) <= c->step) continue;
            struct mark *mark = find_mark(m, mesh, t, k);
            /* New vertices come after all others, so that none has the number 0. */
            if (!mark->middle) mark->middle = (uint32_t)(mesh->vertex_count + m->count++);
        }
    free(crossed);
    return m->slots != NULL;
}

/* Divides one triangle whose edges have these vertices in their middles, or 0 where an edge is not
 * marked. Only counts if `to` is NULL. Returns the number of triangles. */
static size_t divide(psplat_mesh *to, size_t target, const psplat_mesh *from, size_t triangle,
                     const uint32_t middles[3]) {
    /* The triangles for each set of marked edges, given as bits. Points 0 1 2 are the corners, 3 4
     * 5 the middles of edges. */
    static const uint8_t patterns[8][4][3] = {
        {{0, 1, 2}},
        {{0, 3, 2}, {3, 1, 2}},
        {{1, 4, 0}, {4, 2, 0}},
        {{3, 1, 4}, {0, 3, 4}, {0, 4, 2}},
        {{2, 5, 1}, {5, 0, 1}},
        {{5, 0, 3}, {2, 5, 3}, {2, 3, 1}},
        {{4, 2, 5}, {1, 4, 5}, {1, 5, 0}},
        {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}},
    };
    static const uint8_t counts[8] = {1, 2, 2, 3, 2, 3, 3, 4};
    static const double points[6][3] = {{1, 0, 0},     {0, 1, 0},     {0, 0, 1},
                                        {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
    unsigned marked = (middles[0] ? 1u : 0u) | (middles[1] ? 2u : 0u) | (middles[2] ? 4u : 0u);
    for (size_t i = 0; to && i < counts[marked]; ++i) {
        double weights[3][3];
        uint32_t vertices[3];
        for (size_t k = 0; k < 3; ++k) {
            uint8_t point = patterns[marked][i][k];
            memcpy(weights[k], points[point], sizeof weights[k]);
            vertices[k] = point < 3 ? from->triangles[3 * triangle + point] : middles[point - 3];
        }
        store_triangle(to, target + i, from, triangle, (const double(*)[3])weights, vertices);
    }
    return counts[marked];
}

/* Divides all triangles into `to`, or only counts the new triangles if that is NULL. */
static size_t divide_all(const psplat_mesh *from, const marks *m, psplat_mesh *to) {
    size_t count = 0;
    for (size_t t = 0; t < from->triangle_count; ++t) {
        uint32_t middles[3];
        for (size_t k = 0; k < 3; ++k) middles[k] = find_mark(m, from, t, k)->middle;
        count += divide(to, count, from, t, middles);
    }
    return count;
}

static void place_middles(const marks *m, psplat_mesh *mesh) {
    for (size_t i = 0; i < m->size; ++i) {
        const struct mark *mark = &m->slots[i];
        if (!mark->middle) continue;
        for (size_t k = 0; k < 3; ++k)
            mesh->positions[3 * (size_t)mark->middle + k] =
                (mesh->positions[3 * (size_t)mark->low + k] +
                 mesh->positions[3 * (size_t)mark->high + k]) /
                2;
    }
}

/* Makes one pass of refinement. *done is set if nothing is left to be divided. */
static psplat_result refine(cutter *c, int *done, psplat_error *error) {
    marks m = {0};
    psplat_mesh finer;
    psplat_result result = PSPLAT_OK;
    if (!mark_edges(c, &m))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting a mask");
    size_t count = divide_all(&c->mesh, &m, NULL);
    *done = m.count == 0 || count > max_refined_triangles;
    if (!*done)
        result = allocate_like(&c->mesh, c->mesh.vertex_count + m.count, count, &finer, error);
    if (!*done && !result) {
        memcpy(finer.positions, c->mesh.positions, 3 * c->mesh.vertex_count * sizeof(double));
        place_middles(&m, &finer);
        divide_all(&c->mesh, &m, &finer);
        psplat_mesh_free(&c->mesh);
        c->mesh = finer;
    }
    free(m.slots);
    return result;
}

/* ---- cutting --------------------------------------------------------------------------------- */

/* A corner of the part of a triangle that is left. */
typedef struct cut_point {
    double weights[3], position[3];
} cut_point;

static cut_point corner_point(const psplat_mesh *mesh, size_t triangle, size_t k) {
    cut_point p = {.weights = {k == 0, k == 1, k == 2}};
    memcpy(p.position, mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + k],
           sizeof p.position);
    return p;
}

/* Returns the point where the edge of the mask crosses edge k of a triangle, whose ends are on
 * different sides of it. The bisection starts at the end of lower number, so that the neighbour
 * finds the same point. */
static cut_point edge_crossing(const cutter *c, uint32_t triangle, size_t k, int from_is_shown) {
    size_t ends[2] = {k, (k + 1) % 3};
    const uint32_t *t = c->mesh.triangles + 3 * (size_t)triangle;
    if (t[ends[0]] > t[ends[1]]) {
        size_t swap = ends[0];
        ends[0] = ends[1], ends[1] = swap;
        from_is_shown = !from_is_shown;
    }
    double low = 0, high = 1;
    cut_point p = {{0}, {0}};
    for (int i = 0; i < BISECTIONS; ++i) {
        double middle = (low + high) / 2;
        p.weights[ends[0]] = 1 - middle, p.weights[ends[1]] = middle;
        if (is_shown(c, triangle, p.weights) == from_is_shown)
            low = middle;
        else
            high = middle;
    }
    double at = (low + high) / 2;
    p.weights[ends[0]] = 1 - at, p.weights[ends[1]] = at;
    const double *a = c->mesh.positions + 3 * (size_t)t[ends[0]];
    const double *b = c->mesh.positions + 3 * (size_t)t[ends[1]];
    for (int axis = 0; axis < 3; ++axis) p.position[axis] = a[axis] + at * (b[axis] - a[axis]);
    return p;
}

/* Stores the part of a triangle that the mask shows as a polygon. Returns its corner count. */
static size_t shown_part(const cutter *c, uint32_t triangle, cut_point polygon[4]) {
    int shown[3];
    size_t count = 0;
    for (size_t k = 0; k < 3; ++k) {
        cut_point corner = corner_point(&c->mesh, triangle, k);
        shown[k] = is_shown(c, triangle, corner.weights);
    }
    for (size_t k = 0; k < 3; ++k) {
        if (shown[k]) polygon[count++] = corner_point(&c->mesh, triangle, k);
        if (shown[k] != shown[(k + 1) % 3])
            polygon[count++] = edge_crossing(c, triangle, k, shown[k]);
    }
    return count;
}

/* Cuts all triangles into `to`, each with vertices of its own, or only counts if that is NULL.
 * Returns the number of triangles. */
static size_t cut_all(const cutter *c, psplat_mesh *to) {
    size_t count = 0;
    for (uint32_t t = 0; t < c->mesh.triangle_count; ++t) {
        cut_point polygon[4];
        size_t corners = shown_part(c, t, polygon);
        for (size_t i = 2; i < corners; ++i, ++count) {
            const cut_point *fan[3] = {&polygon[0], &polygon[i - 1], &polygon[i]};
            double weights[3][3];
            uint32_t vertices[3];
            for (size_t k = 0; to && k < 3; ++k) {
                memcpy(weights[k], fan[k]->weights, sizeof weights[k]);
                vertices[k] = (uint32_t)(3 * count + k);
                memcpy(to->positions + 3 * (size_t)vertices[k], fan[k]->position,
                       sizeof fan[k]->position);
            }
            if (to) store_triangle(to, count, &c->mesh, t, (const double(*)[3])weights, vertices);
        }
    }
    return count;
}

static psplat_result cut(cutter *c, psplat_mesh *shown, psplat_error *error) {
    size_t count = cut_all(c, NULL);
    if (count == 0)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0,
                           "the alpha mask hides all of the mesh");
    psplat_result result = allocate_like(&c->mesh, 3 * count, count, shown, error);
    if (result) return result;
    cut_all(c, shown);
    result = psplat_mesh_weld(shown, error);
    psplat_mesh_drop_flat(shown);
    if (result) psplat_mesh_free(shown);
    return result;
}

/* ---- interface ------------------------------------------------------------------------------- */

int psplat_alpha_mask_is_needed(const psplat_mesh *mesh) {
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (mask_of(mesh, t)) return 1;
    return 0;
}

psplat_result psplat_alpha_mask_cut(const psplat_mesh *mesh, double step, psplat_mesh *shown,
                                    psplat_error *error) {
    static const double corners[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    cutter c = {.step = step};
    *shown = (psplat_mesh){0};
    psplat_result result =
        allocate_like(mesh, mesh->vertex_count, mesh->triangle_count, &c.mesh, error);
    if (result) return result;
    memcpy(c.mesh.positions, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        store_triangle(&c.mesh, t, mesh, t, corners, mesh->triangles + 3 * t);
    if (psplat_appearance_build(&c.mesh, 0, 0, &c.appearance))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting a mask");
    for (int pass = 0, done = 0; !result && !done && pass < MAX_PASSES; ++pass)
        result = refine(&c, &done, error);
    if (!result) result = cut(&c, shown, error);
    psplat_appearance_free(&c.appearance);
    psplat_mesh_free(&c.mesh);
    return result;
}

double psplat_mesh_diagonal(const psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double extent[3];
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        low[i % 3] = min2(low[i % 3], mesh->positions[i]);
        high[i % 3] = max2(high[i % 3], mesh->positions[i]);
    }
    sub3(extent, high, low);
    return mesh->vertex_count ? length3(extent) : 0;
}

psplat_result psplat_alpha_mask_apply(psplat_mesh *mesh, double step_percent, psplat_error *error) {
    psplat_mesh shown;
    if (!psplat_alpha_mask_is_needed(mesh)) return PSPLAT_OK;
    double step = step_percent / 100 * psplat_mesh_diagonal(mesh);
    psplat_result result = psplat_alpha_mask_cut(mesh, step, &shown, error);
    if (result) return result;
    shown.materials = mesh->materials;
    mesh->materials = NULL;
    psplat_mesh_free(mesh);
    *mesh = shown;
    return PSPLAT_OK;
}
